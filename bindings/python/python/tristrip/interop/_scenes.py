"""Scenes of this package from the arrays or files that other packages give."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .. import _native
from ._arrays import COLOUR, NORMAL, UV, Part, part_of

if TYPE_CHECKING:
    from .._native import Scene


def is_scene(mesh: Any) -> bool:
    """Check whether an object is a scene: what has parts, and can be written."""
    return hasattr(mesh, "parts") and hasattr(mesh, "to_bytes")


def placed_parts(scene: Any) -> list[Part]:
    """Take the parts of a scene."""
    return [part_of(part) for part in scene.parts]


def scene_of(part: Part) -> Scene:
    """Build a scene of one part without a material."""
    return _native.Scene.from_arrays(
        part.vertices,
        part.polygons().as_argument(),
        normals=part.attributes.get(NORMAL),
        uv=part.attributes.get(UV),
        colors=part.attributes.get(COLOUR),
        attributes=dict(part.other_attributes()),
        name=part.name,
    )


def scenes_of(parts: list[Part]) -> Scene:
    (part,) = parts
    return scene_of(part)


def scene_of_glb(glb: bytes) -> Scene:
    """Read a scene from the bytes of a GLB file."""
    return _native.Scene.from_bytes(glb, "glb")
