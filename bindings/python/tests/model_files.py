"""The models of tests: small ones in `testdata/models`, and those of the folder that TRISTRIP_MODELS names."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]


def model_path(name: str) -> Path:
    """Return the path of a model, or skip the test that needs it."""
    named = os.environ.get("TRISTRIP_MODELS")
    folders = [ROOT / "testdata/models", Path(named) if named else ROOT.parent / "shared/models"]
    found = next(_found(folders, name), None)
    if found is None:
        pytest.skip(f"the model {name} is not there; TRISTRIP_MODELS can name its folder")
    return found


def _found(folders: list[Path], name: str) -> Iterator[Path]:
    yield from (folder / name for folder in folders if (folder / name).is_file())
