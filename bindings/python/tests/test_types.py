"""The stub agrees with the native module, and the public names are those it exports."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import tristrip
from stub import PACKAGE, STUB, only_types
from tristrip import _native


def test_the_stub_agrees_with_the_module(tmp_path: Path) -> None:
    pytest.importorskip("mypy")
    allowed = tmp_path / "allowed.txt"
    # Names that exist only for type checkers.
    names = [*only_types(), "__all__"]
    allowed.write_text("".join(f"tristrip\\._native\\.{name}\n" for name in names), encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-m", "mypy.stubtest", "tristrip._native", "--allowlist", str(allowed)],
        cwd=PACKAGE.parent.parent,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_all_public_names_are_exported() -> None:
    assert tristrip.__all__ == sorted(tristrip.__all__)
    assert len(set(tristrip.__all__)) == len(tristrip.__all__)
    for name in tristrip.__all__:
        assert hasattr(tristrip, name)
    native = {name for name in dir(_native) if not name.startswith("_")} - {"VERSION"}
    assert native <= set(tristrip.__all__)


def test_the_stub_has_nothing_untyped() -> None:
    for node in ast.walk(ast.parse(STUB.read_text(encoding="utf-8"))):
        if isinstance(node, ast.FunctionDef):
            assert node.returns is not None, node.name
            for argument in [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]:
                assert argument.annotation is not None or argument.arg in {"self", "cls"}, (node.name, argument.arg)


def test_the_package_is_marked_as_typed() -> None:
    assert (PACKAGE / "py.typed").is_file()


def test_the_version_is_that_of_the_workspace() -> None:
    lines = (PACKAGE.parents[3] / "Cargo.toml").read_text(encoding="utf-8").splitlines()
    versions = [line.split('"')[1] for line in lines if line.startswith("version = ")]
    assert tristrip.__version__ in versions
