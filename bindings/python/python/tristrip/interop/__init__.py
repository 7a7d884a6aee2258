"""Conversions from and to the meshes of other packages: trimesh, PyVista, Open3D and meshio.

No package is required; each is imported by the functions that need it. A `ConversionWarning` names
data that a package cannot represent.
"""

from __future__ import annotations

from ._arrays import ConversionWarning, split_corners
from ._meshio import from_meshio, to_meshio
from ._open3d import from_open3d, to_open3d
from ._pyvista import from_pyvista, plot_strips, strip_colours, strips_from_pyvista, to_pyvista
from ._trimesh import from_trimesh, to_trimesh

__all__ = [
    "ConversionWarning",
    "from_meshio",
    "from_open3d",
    "from_pyvista",
    "from_trimesh",
    "plot_strips",
    "split_corners",
    "strip_colours",
    "strips_from_pyvista",
    "to_meshio",
    "to_open3d",
    "to_pyvista",
    "to_trimesh",
]
