"""Conversion between scenes and the parts, arrays or files of other packages."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from tristrip import _native

from ._arrays import COLOUR, NORMAL, UV, Part, part_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from tristrip._native import Scene


def is_scene(mesh: Any) -> bool:
    """Check whether an object is a scene, or a stripped or simplified scene."""
    return isinstance(mesh, _native.Scene | _native.StrippedScene | _native.SimplifiedScene)


def scene_in(mesh: Any) -> Scene:
    """Return the scene of an object that is a scene or has one as its result."""
    scene: Scene = mesh if isinstance(mesh, _native.Scene) else mesh.scene
    return scene


def placed_parts(mesh: Any) -> list[Part]:
    """Return the parts of a scene, transformed by their nodes.

    Parts of a stripped scene have its strips.

    A part that several nodes refer to is repeated.
    """
    scene = scene_in(mesh)
    strips = mesh.parts if isinstance(mesh, _native.StrippedScene) else None
    parts = [part_of(part, None if strips is None else strips[number]) for number, part in enumerate(scene.parts)]
    return [parts[number].placed(transform) for numbers, transform in scene.placements for number in numbers]


def scene_of(parts: Sequence[Part]) -> Scene:
    """Build a scene of parts."""
    return _native.Scene.from_parts(
        [
            _native.Part(
                part.vertices,
                part.polygons().as_argument(),
                normals=part.attributes.get(NORMAL),
                uv=part.attributes.get(UV),
                colors=part.attributes.get(COLOUR),
                attributes=dict(part.other_attributes()),
                name=part.name,
                material=part.material,
            )
            for part in parts
        ]
    )


def scene_of_glb(glb: bytes) -> Scene:
    """Read a scene from the bytes of a GLB file."""
    return _native.Scene.from_bytes(glb, "glb")
