"""Conversion of Blender meshes to and from arrays, without imports from Blender."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from .levels import CornerMesh

Array = npt.NDArray[Any]

#: The value property, component count and NumPy type of each attribute type.
_VALUES: dict[str, tuple[str, int, Any]] = {
    "BOOLEAN": ("value", 1, np.bool_),
    "INT": ("value", 1, np.int32),
    "INT8": ("value", 1, np.int32),
    "INT16_2D": ("value", 2, np.int32),
    "INT32_2D": ("value", 2, np.int32),
    "FLOAT": ("value", 1, np.float32),
    "FLOAT2": ("vector", 2, np.float32),
    "FLOAT_VECTOR": ("vector", 3, np.float32),
    "FLOAT_COLOR": ("color", 4, np.float32),
    "BYTE_COLOR": ("color_srgb", 4, np.float32),
    "QUATERNION": ("value", 4, np.float32),
    "FLOAT4X4": ("value", 16, np.float32),
}
#: Attributes of strips, which are valid only for one set of faces.
_OF_STRIPS = ("strip", "strip_order", "strip_color")
FIGURES = "tristrip"
#: Attributes that are not copied: positions are vertices, and normals are set by a separate
#: function.
_NOT_COPIED = ("position", "custom_normal", *_OF_STRIPS)


def read(collection: Any, name: str, columns: int, dtype: Any) -> Array:
    """Read a property of all items of a collection."""
    values = np.empty(len(collection) * columns, dtype)
    if len(values):
        collection.foreach_get(name, values)
    return values.reshape(-1, columns) if columns > 1 else values


def polygons(mesh: Any) -> tuple[Array, Array, Array]:
    """Return the positions, the vertex of each corner, and the offsets of the faces."""
    vertices = read(mesh.vertices, "co", 3, np.float32)
    corners = read(mesh.loops, "vertex_index", 1, np.int32).astype(np.int64)
    sizes = read(mesh.polygons, "loop_total", 1, np.int32).astype(np.int64)
    return vertices, corners, np.concatenate([[0], np.cumsum(sizes)])


def triangles(mesh: Any) -> tuple[Array, Array]:
    """Return Blender's triangulation: corner indices, shape (n, 3), and the face of each."""
    mesh.calc_loop_triangles()
    corners = read(mesh.loop_triangles, "loops", 3, np.int32).astype(np.int64)
    return corners, read(mesh.loop_triangles, "polygon_index", 1, np.int32).astype(np.int64)


def values_of(attribute: Any) -> Array | None:
    """Return the values of an attribute, shape (n,) or (n, k), or None for strings."""
    if attribute.data_type not in _VALUES:
        return None
    name, columns, dtype = _VALUES[attribute.data_type]
    return read(attribute.data, name, columns, dtype)


def corner_mesh(mesh: Any) -> CornerMesh:
    """Read the input of a simplification: triangles, materials, shading and attributes."""
    vertices, corners, offsets = polygons(mesh)
    found = CornerMesh(vertices, triangles(mesh)[0], corners, np.zeros(len(corners), np.int64))
    sizes = np.diff(offsets)
    material = read(mesh.polygons, "material_index", 1, np.int32).astype(np.int64)
    is_smooth = read(mesh.polygons, "use_smooth", 1, np.bool_)
    found.face_class = np.repeat(2 * material + is_smooth, sizes)
    for attribute in mesh.attributes:
        if (
            attribute.name.startswith(".")
            or attribute.name in _OF_STRIPS
            or attribute.domain not in ("CORNER", "POINT")
        ):
            continue
        values = values_of(attribute)
        if values is None:
            continue
        if attribute.domain == "POINT":
            values = values[corners]
        if attribute.data_type == "FLOAT2" and attribute.domain == "CORNER":
            found.uv[attribute.name] = values
        elif attribute.data_type in ("FLOAT_COLOR", "BYTE_COLOR"):
            found.colors[attribute.name] = values
    if mesh.has_custom_normals:
        found.normals = read(mesh.corner_normals, "vector", 3, np.float32)
    return found


def _kept_attributes(mesh: Any) -> tuple[list[tuple[str, str, str, Array]], list[str]]:
    """Return name, type, domain and values of supported attributes, and names of others."""
    kept, lost = [], []
    for attribute in mesh.attributes:
        if attribute.name.startswith(".") or attribute.name in _NOT_COPIED:
            continue
        values = values_of(attribute)
        if values is None:
            lost.append(attribute.name)
        else:
            kept.append((attribute.name, attribute.data_type, attribute.domain, values))
    return kept, lost


def replace(mesh: Any, level_triangles: Array) -> list[str]:
    """Replace the faces of a mesh by triangles of its corners, with their attributes.

    Args:
        mesh: the mesh. It keeps its materials and vertex groups.
        level_triangles: corner indices, shape (n, 3).

    Returns:
        The names of dropped attributes. Strip attributes and metrics are removed.
    """
    vertices, corners, offsets = polygons(mesh)
    face_of_corner = np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))
    kept, lost = _kept_attributes(mesh)
    edges = read(mesh.edges, "vertices", 2, np.int32).astype(np.int64)
    weights = [[(group.group, group.weight) for group in vertex.groups] for vertex in mesh.vertices]
    normals = read(mesh.corner_normals, "vector", 3, np.float32) if mesh.has_custom_normals else None
    active = _active_names(mesh)

    flat = level_triangles.ravel()
    vertex_of_corner = corners[flat]
    old_vertices, new_vertices = np.unique(vertex_of_corner, return_inverse=True)
    new_vertices = new_vertices.ravel()
    face_count = len(level_triangles)
    mesh.clear_geometry()
    if FIGURES in mesh:
        del mesh[FIGURES]
    mesh.vertices.add(len(old_vertices))
    mesh.loops.add(len(flat))
    mesh.polygons.add(face_count)
    _write(mesh.vertices, "co", vertices[old_vertices])
    _write(mesh.loops, "vertex_index", new_vertices.astype(np.int32))
    _write(mesh.polygons, "loop_start", np.arange(face_count, dtype=np.int32) * 3)
    mesh.update(calc_edges=True)

    rows = {"POINT": old_vertices, "CORNER": flat, "FACE": face_of_corner[flat[::3]]}
    rows["EDGE"] = _old_edges(edges, old_vertices[read(mesh.edges, "vertices", 2, np.int32)], len(vertices))
    for name, data_type, domain, values in kept:
        _restore(mesh, name, data_type, domain, values, rows[domain])
    _restore_active(mesh, active)
    _restore_weights(mesh, [weights[vertex] for vertex in old_vertices])
    if normals is not None:
        mesh.normals_split_custom_set(normals[flat])
    mesh.update()
    return lost


def _write(collection: Any, name: str, values: Array) -> None:
    if len(values):
        collection.foreach_set(name, np.ascontiguousarray(values).ravel())


def _old_edges(old: Array, new: Array, vertex_count: int) -> Array:
    """Return the old edge with the same vertices for each new edge, or -1."""
    if len(old) == 0:
        return np.full(len(new), -1)
    old_keys, new_keys = (np.sort(edges, axis=1) @ np.array([vertex_count, 1]) for edges in (old, new))
    order = np.argsort(old_keys, kind="stable")
    at = np.minimum(np.searchsorted(old_keys[order], new_keys), len(order) - 1)
    return np.where(old_keys[order][at] == new_keys, order[at], -1)


def _restore(mesh: Any, name: str, data_type: str, domain: str, values: Array, rows: Array) -> None:  # noqa: PLR0917
    """Create an attribute if it is missing, and write the given rows (-1: none)."""
    attribute = mesh.attributes.get(name)
    if attribute is None:
        attribute = mesh.attributes.new(name, data_type, domain)
    property_name, columns, dtype = _VALUES[data_type]
    if len(values):
        taken = values[np.maximum(rows, 0)]
        taken[rows < 0] = 0
    else:
        taken = np.zeros((len(rows), columns) if columns > 1 else len(rows), dtype)
    _write(attribute.data, property_name, taken)


def _active_names(mesh: Any) -> dict[str, Any]:
    uv = mesh.uv_layers
    return {
        "uv": uv.active.name if uv.active else None,
        "uv_render": next((layer.name for layer in uv if layer.active_render), None),
        "color": mesh.color_attributes.active_color_name or None,
        "color_render": mesh.color_attributes.default_color_name or None,
    }


def _restore_active(mesh: Any, names: dict[str, Any]) -> None:
    if names["uv"] in mesh.uv_layers:
        mesh.uv_layers.active = mesh.uv_layers[names["uv"]]
    if names["uv_render"] in mesh.uv_layers:
        mesh.uv_layers[names["uv_render"]].active_render = True
    colors = mesh.color_attributes
    first = next((color.name for color in colors if color.name not in _OF_STRIPS), None)
    if first is not None:
        colors.active_color_name = names["color"] if names["color"] in colors else first
        colors.default_color_name = names["color_render"] if names["color_render"] in colors else first


def _restore_weights(mesh: Any, weights: list[list[tuple[int, float]]]) -> None:
    """Write the weights of vertex groups. Without an object, only BMesh can write them."""
    if not any(weights):
        return
    import bmesh

    edited = bmesh.new()
    edited.from_mesh(mesh)
    layer = edited.verts.layers.deform.verify()
    for vertex, of_groups in zip(edited.verts, weights, strict=True):
        for group, weight in of_groups:
            vertex[layer][group] = weight
    edited.to_mesh(mesh)
    edited.free()


def write_strips(mesh: Any, strip: Array, order: Array, colours: Array | None) -> None:
    """Store the face attributes "strip" and "strip_order", and "strip_color" for display."""
    for name, values in (("strip", strip), ("strip_order", order)):
        _replace_attribute(mesh, name, "INT", "FACE", values.astype(np.int32))
    if colours is not None:
        sizes = read(mesh.polygons, "loop_total", 1, np.int32)
        _replace_attribute(
            mesh, "strip_color", "BYTE_COLOR", "CORNER", np.repeat(colours, sizes, axis=0).astype(np.float32)
        )
        mesh.color_attributes.active_color_name = "strip_color"
    mesh.update()


def _replace_attribute(mesh: Any, name: str, data_type: str, domain: str, values: Array) -> None:
    old = mesh.attributes.get(name)
    if old is not None:
        mesh.attributes.remove(old)
    _restore(mesh, name, data_type, domain, values, np.arange(len(values)))
