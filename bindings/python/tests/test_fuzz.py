"""A few examples of each fuzz target. `--examples N` runs more; `tests/fuzz.py` any number."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import fuzz


@pytest.mark.parametrize("name", fuzz.TARGETS)
def test_arbitrary_arguments(name: str, pytestconfig: pytest.Config, capsys: pytest.CaptureFixture[str]) -> None:
    examples: Any = pytestconfig.getoption("--examples")
    assert fuzz.run_target(name, examples, seed=1), capsys.readouterr().out


CRASHING = """
import os, sys
sys.path.insert(0, {folder!r})
import fuzz
fuzz.TARGETS["crash"] = lambda data: fuzz.attempt(os.abort)
fuzz.TARGETS["wrong"] = lambda data: fuzz.oracle.assert_same_triangles([[0, 1, 2]], [[0, 2, 1]])
sys.exit(fuzz.main())
"""


@pytest.mark.parametrize(
    ("name", "text"), [("crash", "last call:\n<built-in function abort>"), ("wrong", "1 triangles missing")]
)
def test_failures_are_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], name: str, text: str
) -> None:
    program = tmp_path / "crashing.py"
    program.write_text(CRASHING.format(folder=str(fuzz.FOLDER)), encoding="utf-8")
    monkeypatch.setattr(fuzz, "__file__", str(program))
    assert not fuzz.run_target(name, 1, seed=1)
    shown = capsys.readouterr().out
    assert "FAILED" in shown
    assert text in shown
