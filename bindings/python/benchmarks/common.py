"""Shared by the benchmarks: the model directory and timing."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable

ROOT = Path(__file__).resolve().parents[3]


def folder_of_models() -> Path:
    """Return the directory in TRISTRIP_MODELS, or `shared/models` next to the repository."""
    return Path(os.environ.get("TRISTRIP_MODELS", ROOT.parent / "shared/models"))


def timed(run: Callable[[], Any], repeat: int) -> tuple[float, Any]:
    """Return the minimum time in seconds, and the last result."""
    times = []
    result = None
    for _ in range(repeat):
        start = time.perf_counter()
        result = run()
        times.append(time.perf_counter() - start)
    return min(times), result
