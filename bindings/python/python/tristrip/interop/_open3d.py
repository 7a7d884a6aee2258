"""Conversions for Open3D triangle meshes."""

from __future__ import annotations

import io
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from tristrip._errors import ArrayTypeError, MeshError

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
from ._scenes import is_scene, placed_parts, scene_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from tristrip._native import Scene

_DEFAULTS = {"metallic": 0.0, "roughness": 1.0}
#: The names of vertex and triangle attributes in tensor meshes.
_NAMES = {"normals": NORMAL, "colors": COLOUR, "texture_uvs": UV}
_TENSOR_NAMES = {NORMAL: "normals"}
_MAX_VERTICES = (1 << 31) - 1


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
    """Convert a mesh, strips or a scene to Open3D.

    Args:
        mesh: a `Scene`, one of its parts, a `Simplified`, a pair of vertices and faces or strips,
            or vertices of shape (n, 3).
        faces: only with vertices: faces (see `stripify`), or `Strips`, which are converted to
            triangles in draw order.
        normals: shape (n, 3), one per vertex.
        uv: texture coordinates of shape (n, 2), v up.
        colors: shape (n, 3) or (n, 4); floats from 0 to 1, uint8 or uint16.
        attributes: other per-vertex values by name, of shape (n,) or (n, k).
        image: the texture image, uint8 of shape (height, width, 3), top row first.
        tensor: whether to create a mesh of `open3d.t.geometry`, which supports all attributes.

    Returns:
        An `open3d.geometry.TriangleMesh`, or an `open3d.t.geometry.TriangleMesh`. Faces keep their
        order; polygons are triangulated. The parts of a `Scene` are transformed by their nodes and
        joined. The images of their materials become textures; a material without an image becomes a
        one-pixel texture. A tensor mesh has a material if the scene has exactly one.

    Raises:
        ImportError: Open3D is not installed, or Pillow, which decodes images of materials.
        MeshError, ArrayTypeError: an array has invalid values, shape or type.

    Warns:
        ConversionWarning: the opacity of colours, properties of materials or, with `tensor=False`,
            other attributes were dropped.
    """
    open3d = required("open3d")
    if is_scene(mesh):
        parts = placed_parts(mesh)
    else:
        parts = [part_of(mesh, faces, normals=normals, uv=uv, colors=colors, attributes=attributes)]
    if image is not None:
        parts = [
            replace(part, material={"name": None, "base_color": (1.0,) * 4, "image": np.asarray(image)})
            for part in parts
        ]
    materials, of_parts = _materials(parts)
    if materials and len(parts) > 1:
        parts = [_with_coordinates(part) for part in parts]
    part, numbers = joined(parts)
    triangles = part.triangles()
    if len(part.vertices) > _MAX_VERTICES:
        raise MeshError(f"vertices: found {len(part.vertices)}, expected fewer than 2^31")
    if tensor:
        return _tensor(open3d, part, triangles, materials)
    made = _legacy(open3d, part, triangles)
    if materials:
        # A polygon has several triangles.
        _set_textures(open3d, made, materials, np.repeat(of_parts[numbers], part.polygons().sizes - 2))
    return made


def _legacy(open3d: Any, part: Part, triangles: Array) -> Any:
    vector, found = open3d.utility, part.attributes
    made = open3d.geometry.TriangleMesh(
        vector.Vector3dVector(part.vertices.astype(np.float64)), vector.Vector3iVector(triangles.astype(np.int32))
    )
    if NORMAL in found:
        made.vertex_normals = vector.Vector3dVector(found[NORMAL].astype(np.float64))
    if COLOUR in found:
        made.vertex_colors = vector.Vector3dVector(_fractions(_opaque(found[COLOUR])))
    if UV in found:
        made.triangle_uvs = vector.Vector2dVector(found[UV].astype(np.float64)[triangles.ravel()])
    others = [name for name, _ in part.other_attributes()]
    if others:
        warn(f"dropped {', '.join(others)}: only meshes of open3d.t.geometry have other attributes (tensor=True)")
    return made


def _set_textures(open3d: Any, mesh: Any, materials: list[dict[str, Any]], of_triangles: Array) -> None:
    # Open3D stores the bottom row of a texture first.
    mesh.textures = [open3d.geometry.Image(np.ascontiguousarray(np.flipud(_pixels(one)))) for one in materials]
    mesh.triangle_material_ids = open3d.utility.IntVector(of_triangles.astype(np.int32))
    lost = [key for key, value in _DEFAULTS.items() if any(one.get(key, value) != value for one in materials)]
    if any(one.get("base_color_image") and tuple(one["base_color"])[:3] != (1.0,) * 3 for one in materials):
        lost.append("the factor of an image")
    if lost:
        warn(f"dropped {', '.join(lost)} of materials: only meshes of open3d.t.geometry have them (tensor=True)")


def _materials(parts: list[Part]) -> tuple[list[dict[str, Any]], Array]:
    """Return the distinct materials, and the material index of each part."""
    materials: list[dict[str, Any]] = []
    numbers = []
    if all(part.material is None for part in parts):
        return [], np.zeros(len(parts), np.int64)
    for part in parts:
        material = part.material or {"name": None, "base_color": (1.0,) * 4}
        known = [
            number
            for number, one in enumerate(materials)
            if one is material or ("image" not in one and one == material)
        ]
        if not known:
            materials.append(material)
        numbers.append(known[0] if known else len(materials) - 1)
    return materials, np.array(numbers, np.int64)


def _with_coordinates(part: Part) -> Part:
    """Return a part with texture coordinates. If it has none, its texture is one pixel."""
    if UV in part.attributes:
        return replace(part, attributes={**part.attributes, UV: part.attributes[UV].astype(np.float32)})
    return replace(part, attributes={**part.attributes, UV: np.zeros((len(part.vertices), 2), np.float32)})


def _pixels(material: dict[str, Any]) -> Array:
    """Return the image of a material, top row first, or one pixel of its colour."""
    if "image" in material:
        pixels: Array = material["image"]
        return pixels
    if material.get("base_color_image"):
        image = required("PIL.Image", "pillow").open(io.BytesIO(material["base_color_image"]))
        return np.asarray(image if image.mode in ("L", "RGB") else image.convert("RGB"))
    linear = np.array(material["base_color"][:3])
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    pixel: Array = np.rint(255 * encoded).astype(np.uint8).reshape(1, 1, 3)
    return pixel


def _opaque(colours: Array) -> Array:
    if colours.shape[1] == 4:
        opacity = colours[:, 3]
        highest = 1.0 if colours.dtype.kind == "f" else np.iinfo(colours.dtype).max
        if (opacity < highest).any():
            warn(f"{COLOUR}: opacity dropped, Open3D has none")
        colours = colours[:, :3]
    return colours


def _fractions(colours: Array) -> Array:
    if colours.dtype.kind == "f":
        return colours.astype(np.float64)
    return colours / float(np.iinfo(colours.dtype).max)


def _tensor(open3d: Any, part: Part, triangles: Array, materials: list[dict[str, Any]]) -> Any:
    def of(values: Array) -> Any:
        return open3d.core.Tensor(np.ascontiguousarray(values))

    made = open3d.t.geometry.TriangleMesh()
    wide = part.vertices.dtype.itemsize == 8
    made.vertex.positions = of(part.vertices.astype(np.float64 if wide else np.float32))
    made.triangle.indices = of(triangles)
    for name, values in part.attributes.items():
        if name == UV:
            made.triangle.texture_uvs = of(values.astype(np.float32)[triangles])
        elif name == COLOUR:
            colours = _opaque(values)
            made.vertex.colors = of(colours if colours.dtype == np.uint8 else _fractions(colours).astype(np.float32))
        else:
            made.vertex[_TENSOR_NAMES.get(name, name)] = of(values if values.ndim == 2 else values[:, None])
    if len(materials) > 1:
        warn(f"dropped {len(materials)} materials: a mesh of open3d.t.geometry has one")
    elif materials:
        _set_material(open3d, made, materials[0])
    return made


def _set_material(open3d: Any, mesh: Any, material: dict[str, Any]) -> None:
    made = mesh.material
    made.set_default_properties()
    made.material_name = "defaultLit"
    made.vector_properties["base_color"] = np.array(material["base_color"], np.float32)
    for key in ("metallic", "roughness"):
        made.scalar_properties[key] = material.get(key, _DEFAULTS[key])
    if "image" in material or material.get("base_color_image"):
        made.texture_maps["albedo"] = open3d.t.geometry.Image(open3d.core.Tensor(np.array(_pixels(material))))


def from_open3d(mesh: Any, *, name: str | None = None) -> Scene:
    """Convert a triangle mesh of Open3D.

    Args:
        mesh: an `open3d.geometry.TriangleMesh` or an `open3d.t.geometry.TriangleMesh`.
        name: the name of the mesh.

    Returns:
        A `Scene` with the faces in their order, normals, colours and other vertex attributes.
        Texture coordinates of corners become vertex attributes; vertices with different values are
        split. A mesh with textures becomes one part per texture. A tensor mesh keeps its material.

    Raises:
        ImportError: Open3D is not installed, or Pillow, which encodes images of textures.
        ArrayTypeError: the argument is not a triangle mesh of Open3D.

    Warns:
        ConversionWarning: triangle attributes, or material maps other than the base colour, were
            dropped.
    """
    return scene_of(parts_of_open3d(mesh, name=name))


def parts_of_open3d(mesh: Any, *, name: str | None = None) -> list[Part]:
    """Read the arrays of a mesh."""
    open3d = required("open3d")
    left_out: list[str] = []
    is_legacy = isinstance(mesh, open3d.geometry.TriangleMesh)
    if isinstance(mesh, open3d.t.geometry.TriangleMesh):
        mesh = mesh.cpu()
        given = {key: mesh.vertex[key].numpy() for key in mesh.vertex if key != "positions"}
        of_triangles = {key: mesh.triangle[key].numpy() for key in mesh.triangle if key != "indices"}
        vertices = mesh.vertex["positions"].numpy() if "positions" in mesh.vertex else np.empty((0, 3))
        triangles = mesh.triangle["indices"].numpy() if "indices" in mesh.triangle else np.empty((0, 3), np.int64)
        coordinates = of_triangles.pop("texture_uvs", None)
        left_out += [f"{key} of triangles" for key in of_triangles if key != "normals"]
    elif is_legacy:
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
        corners, old, corner = split_corners(triangles.ravel(), len(vertices), coordinates)
        triangles = corners.reshape(-1, 3)
        vertices = vertices[old]
        attributes = {key: values[old] for key, values in attributes.items()}
        attributes[UV] = np.where(corner[:, None] < 0, 0, coordinates[corner])
    if left_out:
        warn(f"dropped {'; '.join(left_out)}")
    whole = Part(vertices, Faces.of("triangles", triangles), attributes, name)
    return _by_texture(whole, mesh) if is_legacy else [replace(whole, material=_material_of(mesh))]


def _by_texture(whole: Part, mesh: Any) -> list[Part]:
    """Return one part per texture of a legacy mesh."""
    textures, numbers = list(mesh.textures), np.asarray(mesh.triangle_material_ids)
    if not textures or len(numbers) != len(whole.faces):
        return [whole]
    parts = []
    for number in np.unique(numbers):
        chosen = np.flatnonzero(numbers == number)
        used, corners = np.unique(whole.triangles()[chosen], return_inverse=True)
        material = None
        if 0 <= number < len(textures) and not textures[number].is_empty():
            material = {"base_color_image": _png(np.flipud(np.asarray(textures[number])))}
        parts.append(
            Part(
                whole.vertices[used],
                Faces.of("triangles", corners.reshape(-1, 3)),
                {key: values[used] for key, values in whole.attributes.items()},
                whole.name,
                material,
            )
        )
    return parts


def _png(pixels: Array) -> bytes:
    """Encode an image, top row first."""
    if pixels.ndim == 3 and pixels.shape[2] == 1:
        pixels = pixels[:, :, 0]
    image = required("PIL.Image", "pillow").fromarray(np.ascontiguousarray(pixels))
    encoded = io.BytesIO()
    image.save(encoded, "PNG")
    return encoded.getvalue()


def _material_of(mesh: Any) -> dict[str, Any] | None:
    """Return the material of a tensor mesh."""
    if not mesh.has_valid_material():
        return None
    given = mesh.material
    material: dict[str, Any] = {"name": given.material_name}
    if "base_color" in given.vector_properties:
        material["base_color"] = np.clip(given.vector_properties["base_color"], 0, 1).tolist()
    for key, value in _DEFAULTS.items():
        material[key] = min(max(dict(given.scalar_properties).get(key, value), 0.0), 1.0)
    if "albedo" in given.texture_maps:
        material["base_color_image"] = _png(given.texture_maps["albedo"].as_tensor().cpu().numpy())
    others = [key for key in given.texture_maps if key != "albedo"]
    if others:
        warn(f"dropped material maps: {', '.join(others)}")
    return material
