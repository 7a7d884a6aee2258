"""Conversions for trimesh."""

from __future__ import annotations

import io
import json
import struct
from typing import TYPE_CHECKING, Any

import numpy as np

from tristrip._errors import ArrayTypeError

from ._arrays import (
    COLOUR,
    NORMAL,
    UV,
    Array,
    Faces,
    Part,
    bytes_of_colours,
    part_of,
    required,
    split_corners,
    warn,
    warn_of_rounding,
)
from ._scenes import is_scene, scene_in, scene_of, scene_of_glb

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from tristrip._native import Scene

#: The glTF attributes that trimesh reads, in addition to those that start with an underscore.
_READ_BY_TRIMESH = {"POSITION", NORMAL, UV, COLOUR}
_EXTENSIONS_READ_BY_TRIMESH = {
    "KHR_materials_pbrSpecularGlossiness",
    "EXT_texture_webp",
    "KHR_draco_mesh_compression",
    # Implied by the data: integer positions, normals and texture coordinates.
    "KHR_mesh_quantization",
}
_IMAGES = ("baseColorTexture", "emissiveTexture", "normalTexture", "occlusionTexture", "metallicRoughnessTexture")
_FACTORS = (
    "name",
    "emissiveFactor",
    "baseColorFactor",
    "metallicFactor",
    "roughnessFactor",
    "doubleSided",
    "alphaMode",
    "alphaCutoff",
)


def to_trimesh(
    mesh: Any,
    faces: Any = None,
    *,
    normals: Any = None,
    uv: Any = None,
    colors: Any = None,
    attributes: Mapping[str, Any] | None = None,
    material: Any = None,
) -> Any:
    """Convert a mesh or a scene to trimesh.

    Args:
        mesh: a `Scene`, one of its parts, a `Simplified`, a pair of vertices and faces, or vertices
            of shape (n, 3).
        faces: only with vertices: faces (see `stripify`), or `Strips`, which are converted to
            triangles in draw order.
        normals: shape (n, 3), one per vertex.
        uv: texture coordinates of shape (n, 2), v up.
        colors: shape (n, 3) or (n, 4); floats from 0 to 1, uint8 or uint16.
        attributes: other per-vertex values by name, of shape (n,) or (n, k).
        material: a trimesh material.

    Returns:
        An unprocessed `trimesh.Trimesh`, or for a `Scene` a `trimesh.Scene` with its nodes,
        materials and images. Vertices and faces keep their order; polygons are triangulated.

    Raises:
        ImportError: trimesh is not installed.
        MeshError, ArrayTypeError: an array has invalid values, shape or type.

    Warns:
        ConversionWarning: colours were rounded to 8 bits, or the scene has data that trimesh does
            not read: animations, skins, other attributes.

    >>> import tristrip
    >>> strips = tristrip.stripify([[0, 1, 2], [2, 1, 3]])
    >>> tristrip.to_trimesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], strips).faces.tolist()
    [[3, 2, 1], [1, 2, 0]]
    """
    trimesh = required("trimesh")
    if is_scene(mesh):
        return _scene(trimesh, scene_in(mesh))
    part = part_of(mesh, faces, normals=normals, uv=uv, colors=colors, attributes=attributes)
    found = part.attributes
    colours = found.get(COLOUR)
    arguments: dict[str, Any] = {}
    if colours is not None:
        warn_of_rounding(colours)
        colours = _with_opacity(bytes_of_colours(colours))
    if UV in found or material is not None:
        visual = trimesh.visual.texture.TextureVisuals(uv=found.get(UV), material=material)
        if colours is not None:
            visual.vertex_attributes["color"] = colours
        arguments["visual"] = visual
    elif colours is not None:
        arguments["vertex_colors"] = colours
    return trimesh.Trimesh(
        vertices=part.vertices,
        faces=part.triangles(),
        vertex_normals=found.get(NORMAL),
        vertex_attributes=dict(part.other_attributes()),
        metadata={} if part.name is None else {"name": part.name},
        process=False,
        validate=False,
        **arguments,
    )


def _with_opacity(colours: Array) -> Array:
    if colours.shape[1] == 4:
        return colours
    return np.column_stack([colours, np.full(len(colours), 255, np.uint8)])


def _scene(trimesh: Any, scene: Scene) -> Any:
    """Convert a scene through GLB, from which trimesh reads nodes, materials and images."""
    glb = bytes(scene.to_bytes("glb"))
    (size,) = struct.unpack_from("<I", glb, 12)
    document = json.loads(glb[20 : 20 + size])
    primitives = [primitive for mesh in document.get("meshes", []) for primitive in mesh["primitives"]]
    names = {name for primitive in primitives for name in primitive["attributes"] if not name.startswith("_")}
    lost = sorted(names - _READ_BY_TRIMESH)
    lost += ["morph targets"] * any("targets" in primitive for primitive in primitives)
    lost += [what for what in ("animations", "skins") if document.get(what)]
    lost += sorted(set(document.get("extensionsUsed", [])) - _EXTENSIONS_READ_BY_TRIMESH)
    if lost:
        warn(f"trimesh does not read {', '.join(lost)}")
    for part in scene.parts:
        if COLOUR in part.attributes:
            warn_of_rounding(part.attributes[COLOUR])
    return trimesh.load(io.BytesIO(glb), file_type="glb", force="scene", process=False)


def from_trimesh(mesh: Any, *, normals: bool | None = None, name: str | None = None) -> Scene:
    """Convert a mesh or a scene of trimesh.

    Args:
        mesh: a `trimesh.Trimesh` or a `trimesh.Scene`.
        normals: whether to convert vertex normals. By default only if the mesh already has them,
            because trimesh computes missing ones on access.
        name: the name of a single mesh.

    Returns:
        A `Scene` with the faces in their order, texture coordinates, vertex colours and other
        attributes. Face colours become vertex colours; vertices with different values are split.
        Scenes, and meshes with a material, are converted through GLB, which keeps materials, images
        and nodes with their transforms. Other attributes then become 32-bit floats with names that
        start with an underscore, as glTF requires. Positions are 32-bit floats.

    Raises:
        ImportError: trimesh is not installed.
        ArrayTypeError: the argument is not a mesh or scene of trimesh.

    Warns:
        ConversionWarning: face attributes, paths, point clouds, or attributes that glTF does not
            support were dropped.
    """
    trimesh = required("trimesh")
    if isinstance(mesh, trimesh.Scene):
        return scene_of_glb(_kept(trimesh, mesh).export(file_type="glb", include_normals=normals))
    if not isinstance(mesh, trimesh.Trimesh):
        raise ArrayTypeError(f"mesh: found {type(mesh).__name__}, expected a Trimesh or a Scene of trimesh")
    if mesh.visual.kind == "texture" and mesh.visual.material is not None:
        scene = trimesh.Scene()
        scene.add_geometry(mesh, geom_name=name or "mesh", node_name=name or "mesh")
        return from_trimesh(scene, normals=normals)
    return scene_of([part_of_trimesh(mesh, normals=normals, name=name)])


def part_of_trimesh(mesh: Any, *, normals: bool | None = None, name: str | None = None) -> Part:
    """Read the arrays of a mesh, without its material."""
    mesh = _prepared(mesh)
    attributes: dict[str, Array] = {}
    if normals or (normals is None and _has_normals(mesh)):
        attributes[NORMAL] = np.asarray(mesh.vertex_normals)
    if mesh.visual.kind == "vertex":
        attributes[COLOUR] = np.asarray(mesh.visual.vertex_colors)
    elif mesh.visual.kind == "texture":
        if mesh.visual.uv is not None:
            attributes[UV] = np.asarray(mesh.visual.uv)[:, :2]
        if "color" in mesh.visual.vertex_attributes:
            attributes[COLOUR] = np.asarray(mesh.visual.vertex_attributes["color"])
    attributes.update({key: np.asarray(values) for key, values in mesh.vertex_attributes.items()})
    return Part(np.asarray(mesh.vertices), Faces.of("faces", np.asarray(mesh.faces)), attributes, name)


def _has_normals(mesh: Any) -> bool:
    """Check whether a mesh already has normals, as trimesh's exporters do."""
    return "vertex_normals" in mesh._cache  # noqa: SLF001


def _kept(trimesh: Any, scene: Any) -> Any:
    """Return a copy of a scene with meshes prepared for GLB, without paths and point clouds."""
    kept = trimesh.Scene(metadata=scene.metadata)
    kept.graph = scene.graph.copy()
    if scene.has_camera:
        kept.camera = scene.camera
    kept.geometry.update(scene.geometry)
    others = [key for key, geometry in scene.geometry.items() if not isinstance(geometry, trimesh.Trimesh)]
    if others:
        warn(f"dropped {len(others)} paths or point clouds: {', '.join(others[:3])}{', …' * (len(others) > 3)}")
        kept.delete_geometry(others)
    known: dict[int, Any] = {}
    for key, geometry in list(kept.geometry.items()):
        parts = list(_by_material(trimesh, _prepared(geometry)))
        parts = [_for_glb(trimesh, part, known) for part in parts]
        kept.geometry[key] = parts[0]
        for number, part in enumerate(parts[1:], 1):
            for node in [node for node in kept.graph.nodes_geometry if kept.graph[node][1] == key]:
                # Add it as a child of the node with the first part, so that both move together.
                kept.add_geometry(
                    part, geom_name=f"{key}_{number}", node_name=f"{node}_{number}", parent_node_name=node
                )
    return kept


def _prepared(mesh: Any) -> Any:
    """Return a mesh with vertex colours instead of face colours, and warn about lost data."""
    if mesh.face_attributes:
        warn(f"dropped face attributes: {', '.join(map(str, mesh.face_attributes))}")
    if mesh.visual.kind != "face":
        return mesh
    faces = np.asarray(mesh.faces)
    colours = np.repeat(np.asarray(mesh.visual.face_colors), 3, axis=0)
    corners, old, corner = split_corners(faces.ravel(), len(mesh.vertices), colours)
    return _copy(
        mesh,
        vertices=np.asarray(mesh.vertices)[old],
        faces=corners.reshape(-1, 3),
        vertex_normals=np.asarray(mesh.vertex_normals)[old] if _has_normals(mesh) else None,
        vertex_attributes={key: np.asarray(values)[old] for key, values in mesh.vertex_attributes.items()},
        visual=None,
        vertex_colors=colours[corner],
    )


def _copy(mesh: Any, **changed: Any) -> Any:
    """Return a mesh with the same arrays, except for some."""
    arguments = {
        "vertices": mesh.vertices,
        "faces": mesh.faces,
        "vertex_normals": mesh.vertex_normals if _has_normals(mesh) else None,
        "vertex_attributes": dict(mesh.vertex_attributes),
        "metadata": mesh.metadata,
        "visual": mesh.visual,
        **changed,
    }
    return type(mesh)(process=False, validate=False, **arguments)


def _for_glb(trimesh: Any, mesh: Any, known: dict[int, Any]) -> Any:
    """Return a mesh whose attributes and images trimesh can write without loss."""
    attributes = {}
    for key, given in mesh.vertex_attributes.items():
        values = np.asarray(given)
        values = values.reshape(len(values), -1)
        exact = values.astype(np.float32)
        is_kept = values.dtype.kind == "f" or (values.dtype.kind in "biu" and np.array_equal(exact, values))
        if not is_kept or not 1 <= values.shape[1] <= 4:
            found = f"{key} of {given.dtype} with {values.shape[1]} columns"
            warn(f"dropped {found}: glTF supports up to four 32-bit components")
        else:
            attributes[key] = exact
    changed: dict[str, Any] = {"vertex_attributes": attributes}
    if mesh.visual.kind == "texture" and mesh.visual.material is not None:
        given = mesh.visual.material
        if id(given) not in known:
            known[id(given)] = _with_kept_images(trimesh, given)
        material = known[id(given)]
        if material is not given:
            visual = trimesh.visual.texture.TextureVisuals(uv=mesh.visual.uv, material=material)
            for key in mesh.visual.vertex_attributes:
                visual.vertex_attributes[key] = mesh.visual.vertex_attributes[key]
            changed["visual"] = visual
    return _copy(mesh, **changed)


class _KeptJpeg:
    """A JPEG image that trimesh writes with its original quantization tables."""

    format = "JPEG"

    def __init__(self, image: Any) -> None:
        self.image = image

    def save(self, file: Any, **options: Any) -> None:
        self.image.save(file, quality="keep", **options)


def _with_kept_images(trimesh: Any, material: Any) -> Any:
    """Return a PBR material whose JPEG images are kept unchanged."""
    pbr = material.to_pbr() if hasattr(material, "to_pbr") else material
    images = {key: getattr(pbr, key, None) for key in _IMAGES}
    if not any(getattr(image, "format", None) == "JPEG" for image in images.values()):
        return material
    kept = {
        key: _KeptJpeg(image) if getattr(image, "format", None) == "JPEG" else image for key, image in images.items()
    }
    return trimesh.visual.material.PBRMaterial(**kept, **{key: getattr(pbr, key) for key in _FACTORS})


def _by_material(trimesh: Any, mesh: Any) -> Iterator[Any]:
    """Yield one mesh per material of a multi-material mesh."""
    numbers = getattr(mesh.visual, "face_materials", None)
    materials = getattr(getattr(mesh.visual, "material", None), "materials", None)
    if numbers is None or not materials or len(numbers) != len(mesh.faces):
        yield mesh
        return
    for number in np.unique(numbers):
        visual = trimesh.visual.texture.TextureVisuals(uv=mesh.visual.uv, material=materials[number])
        yield trimesh.Trimesh(
            vertices=mesh.vertices,
            faces=np.asarray(mesh.faces)[np.asarray(numbers) == number],
            vertex_normals=mesh.vertex_normals if _has_normals(mesh) else None,
            vertex_attributes=dict(mesh.vertex_attributes),
            visual=visual,
            process=False,
            validate=False,
        )
