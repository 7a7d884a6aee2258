"""Polygon meshes into render-ready triangle strips, levels of detail and streams, over NumPy arrays.

>>> import tristrip
>>> strips = tristrip.stripify([[0, 1, 2], [2, 1, 3], [2, 3, 4]])
>>> strips.indices(layout="restart").tolist()
[0, 1, 2, 3, 4]
"""

from __future__ import annotations

from ._errors import (
    ArrayTypeError,
    FileError,
    FormatError,
    InternalError,
    Interrupted,
    LimitError,
    MeshError,
    NotProvenError,
    ParameterError,
    TristripError,
)
from ._native import VERSION as __version__
from ._native import (
    Chain,
    Levels,
    Part,
    Scene,
    Simplified,
    SimplifiedScene,
    StrippedScene,
    Strips,
    convert,
    load,
    run_command,
    set_threads,
    simplify,
    stripify,
    verify,
)
from ._progress import Progress

__all__ = [
    "ArrayTypeError",
    "Chain",
    "FileError",
    "FormatError",
    "InternalError",
    "Interrupted",
    "Levels",
    "LimitError",
    "MeshError",
    "NotProvenError",
    "ParameterError",
    "Part",
    "Progress",
    "Scene",
    "Simplified",
    "SimplifiedScene",
    "StrippedScene",
    "Strips",
    "TristripError",
    "__version__",
    "convert",
    "load",
    "run_command",
    "set_threads",
    "simplify",
    "stripify",
    "verify",
]
