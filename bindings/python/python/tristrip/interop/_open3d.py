"""Triangle meshes of Open3D."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from .._errors import ArrayTypeError, MeshError
from ._arrays import (
    COLOUR,
    NORMAL,
    UV,
    Array,
    Faces,
    Part,
    attributes_of,
    check_range,
    joined,
    part_of,
    required,
    split_corners,
    warn,
)
from ._scenes import is_scene, placed_parts, scenes_of

if TYPE_CHECKING:
    from .._native import Scene

#: The names of vertex and triangle attributes of tensor meshes.
_NAMES: dict[str | None, str] = {"normals": NORMAL, "colors": COLOUR, "texture_uvs": UV}
_TENSOR_NAMES = {NORMAL: "normals", COLOUR: "colors"}
_MOST_VERTICES = (1 << 31) - 1


def to_open3d(
    mesh: Any,
    faces: Any = None,
    *,
    normals: Any = None,
    uv: Any = None,
    colors: Any = None,
    attributes: Mapping[str, Any] | None = None,
    image: Any = None,
    tensor: bool = False,
) -> Any:
    """Convert a mesh, strips or a scene for Open3D.

    Args:
        mesh: a `Scene`, one of its parts, a `Simplified`, a pair of vertices and faces or strips, or vertices of shape (n, 3).
        faces: with vertices only: faces as of `stripify`, or `Strips`, of which the triangles are taken in their order.
        normals, uv, colors, attributes: arrays with one row per vertex, as of `simplify`. Open3D has `uv` with v upwards, as these are.
        image: of a texture: an array of shape (height, width, 3) of uint8; with `tensor=False` only.
        tensor: whether a mesh of `open3d.t.geometry` is made, which has all attributes.

    Returns:
        An `open3d.geometry.TriangleMesh`, or an `open3d.t.geometry.TriangleMesh`. Faces keep their order, polygons are triangles. The
        parts of a `Scene` are joined, placed as its nodes place them, with the images of its materials as textures.

    Raises:
        ImportError: Open3D is not installed.
        MeshError, ArrayTypeError: the arrays have wrong values or a wrong shape.

    Warns:
        ConversionWarning: the opacity of colours, and with `tensor=False` other attributes, are left out.
    """
    open3d = required("open3d")
    images: list[Any] = [] if image is None else [np.ascontiguousarray(image)]
    materials: Array | None = None
    if is_scene(mesh):
        parts = placed_parts(mesh)
        part, numbers = joined(parts)
        images, of_parts = _images(parts)
        # Polygons have more than one triangle each.
        materials = np.repeat(of_parts[numbers], part.polygons().sizes - 2) if images else None
    else:
        part = part_of(mesh, faces, normals=normals, uv=uv, colors=colors, attributes=attributes)
    triangles = part.triangles()
    if len(part.vertices) > _MOST_VERTICES:
        raise MeshError(f"vertices: found {len(part.vertices)}, expected fewer than 2^31")
    if tensor:
        return _tensor(open3d, part, triangles)
    found = part.attributes
    vector = open3d.utility
    made = open3d.geometry.TriangleMesh(
        vector.Vector3dVector(part.vertices.astype(np.float64)), vector.Vector3iVector(triangles.astype(np.int32))
    )
    if NORMAL in found:
        made.vertex_normals = vector.Vector3dVector(found[NORMAL].astype(np.float64))
    if COLOUR in found:
        made.vertex_colors = vector.Vector3dVector(_opaque(found[COLOUR]))
    if UV in found:
        made.triangle_uvs = vector.Vector2dVector(found[UV].astype(np.float64)[triangles.ravel()])
    if images:
        made.textures = [open3d.geometry.Image(one) for one in images]
        made.triangle_material_ids = vector.IntVector(
            np.zeros(len(triangles), np.int32) if materials is None else materials.astype(np.int32)
        )
    others = [name for name, _ in part.other_attributes()]
    if others:
        warn(f"left out {', '.join(others)}: only meshes of open3d.t.geometry have other attributes (tensor=True)")
    return made


def _images(parts: list[Part]) -> tuple[list[Any], Array]:
    """Return the different images of parts, and the number of the image of each part."""
    return [], np.zeros(len(parts), np.int64)


def _opaque(colours: Array) -> Array:
    if colours.shape[1] == 4:
        opacity = colours[:, 3]
        highest = 1.0 if colours.dtype.kind == "f" else np.iinfo(colours.dtype).max
        if (opacity < highest).any():
            warn(f"{COLOUR}: the opacity is left out, Open3D has none")
        colours = colours[:, :3]
    if colours.dtype.kind == "f":
        return colours.astype(np.float64)
    return colours / float(np.iinfo(colours.dtype).max)


def _tensor(open3d: Any, part: Part, triangles: Array) -> Any:
    def of(values: Array) -> Any:
        return open3d.core.Tensor(np.ascontiguousarray(values))

    made = open3d.t.geometry.TriangleMesh()
    wide = part.vertices.dtype.itemsize == 8
    made.vertex.positions = of(part.vertices.astype(np.float64 if wide else np.float32))
    made.triangle.indices = of(triangles)
    for name, values in part.attributes.items():
        if name == UV:
            made.triangle.texture_uvs = of(values.astype(np.float32)[triangles])
        else:
            if name == COLOUR:
                values = _opaque(values).astype(np.float32) if values.dtype != np.uint8 else values[:, :3]
            made.vertex[_TENSOR_NAMES.get(name, name)] = of(values if values.ndim == 2 else values[:, None])
    return made


def from_open3d(mesh: Any, *, name: str | None = None) -> Scene:
    """Convert a triangle mesh of Open3D.

    Args:
        mesh: an `open3d.geometry.TriangleMesh` or an `open3d.t.geometry.TriangleMesh`.
        name: the name of the mesh.

    Returns:
        A `Scene` with the faces in their order, normals, colours and other attributes of vertices. Texture coordinates of corners become
        those of vertices, which are split where they differ. A mesh with several textures becomes a part per texture.

    Raises:
        ImportError: Open3D is not installed.
        ArrayTypeError: the argument is no triangle mesh of Open3D.

    Warns:
        ConversionWarning: attributes of triangles are left out.
    """
    return scenes_of(parts_of_open3d(mesh, name=name))


def parts_of_open3d(mesh: Any, *, name: str | None = None) -> list[Part]:
    """Take the arrays of a mesh."""
    open3d = required("open3d")
    left_out: list[str] = []
    if isinstance(mesh, open3d.t.geometry.TriangleMesh):
        mesh = mesh.cpu()
        given = {key: mesh.vertex[key].numpy() for key in mesh.vertex if key != "positions"}
        of_triangles = {key: mesh.triangle[key].numpy() for key in mesh.triangle if key != "indices"}
        vertices = mesh.vertex["positions"].numpy() if "positions" in mesh.vertex else np.empty((0, 3))
        triangles = mesh.triangle["indices"].numpy() if "indices" in mesh.triangle else np.empty((0, 3), np.int64)
        coordinates = of_triangles.pop("texture_uvs", None)
        left_out += [f"{key} of triangles" for key in of_triangles if key != "normals"]
    elif isinstance(mesh, open3d.geometry.TriangleMesh):
        vertices, triangles = np.asarray(mesh.vertices), np.asarray(mesh.triangles)
        given = {"normals": np.asarray(mesh.vertex_normals)} if mesh.has_vertex_normals() else {}
        given |= {"colors": np.asarray(mesh.vertex_colors)} if mesh.has_vertex_colors() else {}
        coordinates = np.asarray(mesh.triangle_uvs) if mesh.has_triangle_uvs() else None
    else:
        raise ArrayTypeError(f"mesh: found {type(mesh).__name__}, expected a TriangleMesh of Open3D")
    check_range("triangles", triangles, len(vertices))
    attributes = attributes_of(given, _NAMES, left_out)
    if coordinates is not None:
        coordinates = coordinates.reshape(-1, 2)
        triangles, old, corner = split_corners(triangles, len(vertices), coordinates)
        vertices = vertices[old]
        attributes = {key: values[old] for key, values in attributes.items()}
        attributes[UV] = np.where(corner[:, None] < 0, 0, coordinates[corner])
    if left_out:
        warn(f"left out {'; '.join(left_out)}")
    return [Part(vertices, Faces.of("triangles", triangles), attributes, name)]
