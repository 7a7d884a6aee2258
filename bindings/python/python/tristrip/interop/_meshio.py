"""Meshes of meshio."""

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

#: The cell data with the number of each face, where faces of several sizes are in blocks of their own.
_FACE = "face"
_PART = "part"
#: The names under which meshio reads normals, texture coordinates and colours from OBJ, PLY and VTK.
_NAMES = {
    "obj:vn": NORMAL,
    "obj:vt": UV,
    "Normals": NORMAL,
    "Texture Coordinates": UV,
    "RGB": COLOUR,
    "RGBA": COLOUR,
}
#: Attributes that PLY has as one number per property.
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
    """Convert a mesh, strips or a scene for meshio.

    Args:
        mesh: a `Scene`, one of its parts, a `Simplified`, a pair of vertices and faces or strips, or vertices of
            shape (n, 3).
        faces: with vertices only: faces as of `stripify`, or `Strips`, of which the triangles are taken in their order.
        normals: of shape (n, 3), one per vertex.
        uv: texture coordinates of shape (n, 2).
        colors: of shape (n, 3) or (n, 4): floats from 0 to 1, or uint8 or uint16.
        attributes: other values per vertex, by name: arrays of shape (n,) or (n, k).

    Returns:
        A `meshio.Mesh` with a block of cells per face size: "triangle", "quad" and "polygon"; if there are several
        blocks, the cell data "face" have the number of each face. Attributes are point data under their names:
        "NORMAL", "TEXCOORD_0", "COLOR_0" and others. The parts of a `Scene` are joined, placed as its nodes place
        them; the cell data "part" have the number of each. Materials are left out.

    Raises:
        ImportError: meshio is not installed.
        MeshError, ArrayTypeError: the arrays have wrong values or a wrong shape.

    Warns:
        ConversionWarning: attributes that only some parts of a scene have are left out.

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
        A `Scene` with the triangles, quads and polygons in the order of the blocks, or of the cell data "face" as
        `to_meshio` writes them. Normals, texture coordinates and colours under the names with which meshio reads OBJ,
        PLY and VTK, and other point data, are kept. Points with two coordinates lie in the plane z = 0.

    Raises:
        ImportError: meshio is not installed.
        ArrayTypeError: the argument is no mesh of meshio.

    Warns:
        ConversionWarning: cells without a surface, cell data, nodes on edges, or point data that are no numbers are
            left out.
    """
    return scene_of([part_of_meshio(mesh, name=name)])


def part_of_meshio(mesh: Any, *, name: str | None = None) -> Part:
    """Take the arrays of a mesh."""
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
        warn(f"left out {'; '.join(left_out)}")
    return Part(points, faces, attributes, name)


def _corner_count(kind: str) -> int | None:
    """Return the number of corners of a type of cells that is a surface."""
    for prefix, size in (("triangle", 3), ("quad", 4)):
        if kind == prefix or kind.removeprefix(prefix).isdigit():
            return size
    return None


def _together(point_data: Mapping[str, Any]) -> dict[str, Any]:
    """Put the numbers of each attribute of PLY into one array."""
    data = dict(point_data)
    for name, columns in _SEPARATE:
        if name not in data and all(column in data for column in columns):
            data[name] = np.column_stack([data.pop(column) for column in columns])
    return data
