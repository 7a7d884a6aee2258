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
    Decoder,
    Levels,
    Simplified,
    StreamedPart,
    Strips,
    View,
    ViewModel,
    inspect,
    pack,
    run_command,
    set_threads,
    simplify,
    stripify,
    unpack,
)
from ._progress import Progress
from ._streams import Packed, Unpacked, decode

__all__ = [
    "ArrayTypeError",
    "Decoder",
    "FileError",
    "FormatError",
    "InternalError",
    "Interrupted",
    "Levels",
    "LimitError",
    "MeshError",
    "NotProvenError",
    "Packed",
    "ParameterError",
    "Progress",
    "Simplified",
    "StreamedPart",
    "Strips",
    "TristripError",
    "Unpacked",
    "View",
    "ViewModel",
    "__version__",
    "decode",
    "inspect",
    "pack",
    "run_command",
    "set_threads",
    "simplify",
    "stripify",
    "unpack",
]
