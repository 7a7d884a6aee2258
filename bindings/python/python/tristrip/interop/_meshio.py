"""Conversions for meshio."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from tristrip._errors import ArrayTypeError

from ._arrays import COLOUR, NORMAL, UV, Array, Faces, Part, attributes_of, check_range, joined, part_of, required, warn
from ._scenes import is_scene, placed_parts, scene_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from tristrip._native import Scene

#: The cell data with face indices, used if faces of different sizes are in separate blocks.
_FACE = "face"
_PART = "part"
#: The names that meshio uses for normals, texture coordinates and colours of OBJ, PLY and VTK
#: files.
_NAMES = {
    "obj:vn": NORMAL,
    "obj:vt": UV,
    "Normals": NORMAL,
    "Texture Coordinates": UV,
    "RGB": COLOUR,
    "RGBA": COLOUR,
}
#: Attributes that PLY stores as one property per component.
_SEPARATE = [
    (NORMAL, ("nx", "ny", "nz")),
    (UV, ("s", "t")),
    (UV, ("u", "v")),
    (UV, ("texture_u", "texture_v")),
    (COLOUR, ("red", "green", "blue", "alpha")),
    (COLOUR, ("red", "green", "blue")),
]


def to_meshio(
    mesh: Any,
    faces: Any = None,
    *,
    normals: Any = None,
    uv: Any = None,
    colors: Any = None,
    attributes: Mapping[str, Any] | None = None,
) -> Any:
    """Convert a mesh, strips or a scene to meshio.

    Args:
        mesh: a `Scene`, one of its parts, a `Simplified`, a pair of vertices and faces or strips,
            or vertices of shape (n, 3).
        faces: only with vertices: faces (see `stripify`), or `Strips`, which are converted to
            triangles in draw order.
        normals: shape (n, 3), one per vertex.
        uv: texture coordinates of shape (n, 2).
        colors: shape (n, 3) or (n, 4); floats from 0 to 1, uint8 or uint16.
        attributes: other per-vertex values by name, of shape (n,) or (n, k).

    Returns:
        A `meshio.Mesh` with one cell block per face size: "triangle", "quad" and "polygon". With
        several blocks, the cell data "face" has the index of each face. Attributes become point
        data under their names: "NORMAL", "TEXCOORD_0", "COLOR_0" and others. The parts of a `Scene`
        are transformed by their nodes and joined; the cell data "part" has the part of each face.
        Materials are dropped.

    Raises:
        ImportError: meshio is not installed.
        MeshError, ArrayTypeError: an array has invalid values, shape or type.

    Warns:
        ConversionWarning: attributes that some parts of a scene lack were dropped.

    >>> import tristrip
    >>> tristrip.to_meshio([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], [[0, 1, 3, 2]]).cells[0].type
    'quad'
    """
    meshio = required("meshio")
    cell_data: dict[str, npt.NDArray[np.int64]] = {}
    if is_scene(mesh):
        parts = placed_parts(mesh)
        part, numbers = joined(parts)
        if len(parts) > 1:
            cell_data[_PART] = numbers
    else:
        part = part_of(mesh, faces, normals=normals, uv=uv, colors=colors, attributes=attributes)
    blocks = list(part.polygons().by_size())
    if len(blocks) > 1:
        cell_data[_FACE] = np.arange(len(part.polygons()))
    return meshio.Mesh(
        part.vertices,
        [({3: "triangle", 4: "quad"}.get(size, "polygon"), corners) for size, _, corners in blocks],
        point_data=dict(part.attributes),
        cell_data={key: [values[numbers] for _, numbers, _ in blocks] for key, values in cell_data.items()},
    )


def from_meshio(mesh: Any, *, name: str | None = None) -> Scene:
    """Convert a mesh of meshio.

    Args:
        mesh: a `meshio.Mesh`.
        name: the name of the mesh.

    Returns:
        A `Scene` with the triangles, quads and polygons in block order, or in the order of the cell
        data "face" written by `to_meshio`. Point data are kept, including normals, texture
        coordinates and colours under the names that meshio uses for OBJ, PLY and VTK.
        Two-dimensional points get z = 0.

    Raises:
        ImportError: meshio is not installed.
        ArrayTypeError: the argument is not a mesh of meshio.

    Warns:
        ConversionWarning: cells that are not faces, cell data, nodes on edges, or non-numeric point
            data were dropped.
    """
    return scene_of([part_of_meshio(mesh, name=name)])


def part_of_meshio(mesh: Any, *, name: str | None = None) -> Part:
    """Read the arrays of a mesh."""
    meshio = required("meshio")
    if not isinstance(mesh, meshio.Mesh):
        raise ArrayTypeError(f"mesh: found {type(mesh).__name__}, expected a Mesh of meshio")
    left_out: list[str] = []
    sizes: list[Array] = [np.empty(0, np.int64)]
    corners: list[Array] = [np.empty(0, np.int64)]
    order: list[Array] = []
    for number, block in enumerate(mesh.cells):
        size = _corner_count(block.type)
        data = np.asarray(block.data) if size or block.type == "polygon" else None
        if data is None:
            left_out.append(f"{len(block)} cells of type {block.type}")
            continue
        size = size or data.shape[1]
        if data.shape[1] > size:
            left_out.append(f"nodes on edges of {len(data)} cells of type {block.type}")
        sizes.append(np.full(len(data), size, np.int64))
        corners.append(data[:, :size].astype(np.int64).ravel())
        if _FACE in mesh.cell_data:
            order.append(np.asarray(mesh.cell_data[_FACE][number]).astype(np.int64).ravel())
    left_out += [f"cell data {key}" for key in mesh.cell_data if key not in (_FACE, _PART)]
    points = np.asarray(mesh.points)
    if points.ndim == 2 and points.shape[1] == 2:
        points = np.column_stack([points, np.zeros(len(points), points.dtype)])
    attributes = attributes_of(_together(mesh.point_data), _NAMES, left_out)
    faces = Faces(np.concatenate([[0], np.cumsum(np.concatenate(sizes))]).astype(np.int64), np.concatenate(corners))
    check_range("cells", faces.corners, len(points))
    if order:
        faces = faces.reordered(np.argsort(np.concatenate(order), kind="stable"))
    if left_out:
        warn(f"dropped {'; '.join(left_out)}")
    return Part(points, faces, attributes, name)


def _corner_count(kind: str) -> int | None:
    """Return the number of corners of a surface cell type; None for other cell types."""
    for prefix, size in (("triangle", 3), ("quad", 4)):
        if kind == prefix or kind.removeprefix(prefix).isdigit():
            return size
    return None


def _together(point_data: Mapping[str, Any]) -> dict[str, Any]:
    """Combine the separate components of PLY attributes into arrays."""
    data = dict(point_data)
    for name, columns in _SEPARATE:
        if name not in data and all(column in data for column in columns):
            data[name] = np.column_stack([data.pop(column) for column in columns])
    return data
