"""Triangle strips, mesh simplification, levels of detail and progressive streams for NumPy arrays.

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
    Decoder,
    Levels,
    Part,
    Scene,
    Simplified,
    SimplifiedScene,
    StreamedPart,
    StrippedScene,
    Strips,
    View,
    ViewModel,
    convert,
    inspect,
    load,
    pack,
    run_command,
    set_threads,
    simplify,
    stripify,
    unpack,
    verify,
)
from ._progress import Progress
from ._streams import Packed, Unpacked, decode
from .interop import (
    ConversionWarning,
    from_meshio,
    from_open3d,
    from_pyvista,
    from_trimesh,
    plot_strips,
    strips_from_pyvista,
    to_meshio,
    to_open3d,
    to_pyvista,
    to_trimesh,
)

__all__ = [
    "ArrayTypeError",
    "Chain",
    "ConversionWarning",
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
    "Part",
    "Progress",
    "Scene",
    "Simplified",
    "SimplifiedScene",
    "StreamedPart",
    "StrippedScene",
    "Strips",
    "TristripError",
    "Unpacked",
    "View",
    "ViewModel",
    "__version__",
    "convert",
    "decode",
    "from_meshio",
    "from_open3d",
    "from_pyvista",
    "from_trimesh",
    "inspect",
    "load",
    "pack",
    "plot_strips",
    "run_command",
    "set_threads",
    "simplify",
    "stripify",
    "strips_from_pyvista",
    "to_meshio",
    "to_open3d",
    "to_pyvista",
    "to_trimesh",
    "unpack",
    "verify",
]
