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
    "from_meshio",
    "from_open3d",
    "from_pyvista",
    "from_trimesh",
    "load",
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
    "verify",
]
