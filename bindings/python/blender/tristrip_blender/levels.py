"""Levels of detail of a mesh with corner attributes, as Blender has them."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

Ints = npt.NDArray[Any]
Floats = npt.NDArray[Any]


@dataclass
class CornerMesh:
    """A triangle mesh with corner attributes.

    Attributes:
        vertices: positions, shape (n, 3).
        triangles: the triangles as corner indices, shape (m, 3).
        vertex_of_corner: the vertex of each corner, shape (k,).
        face_class: a class per corner. Seams between faces of different classes, such as materials,
            are kept.
        uv, colors: corner attributes by name, shape (k, 2) and (k, 3 or 4).
        normals: custom corner normals, shape (k, 3), or None for the normals of the surface.
    """

    vertices: Floats
    triangles: Ints
    vertex_of_corner: Ints
    face_class: Ints
    uv: dict[str, Floats] = field(default_factory=dict)
    colors: dict[str, Floats] = field(default_factory=dict)
    normals: Floats | None = None

    def key(self) -> bytes:
        """Return a digest of all values."""
        digest = hashlib.blake2b()
        arrays = [self.vertices, self.triangles, self.vertex_of_corner, self.face_class, self.normals]
        for array in [*arrays, *self.uv.values(), *self.colors.values()]:
            digest.update(b"-" if array is None else np.ascontiguousarray(array).tobytes())
            digest.update(b"/")
        return digest.digest()


@dataclass
class Level:
    """The triangles of a level.

    Attributes:
        triangles: indices of corners of the full mesh, shape (m, 3). Each has the vertex and
            attributes of the corner in the level.
        error: the distance from the full mesh in mesh units.
    """

    triangles: Ints
    error: float


class MeshLevels:
    """All levels of a mesh. After it is built, it can move to any level."""

    def __init__(self, mesh: CornerMesh) -> None:
        import tristrip
        from tristrip.interop import split_corners

        self.full_count = len(mesh.triangles)
        used = np.unique(mesh.triangles)
        columns = [mesh.face_class[:, None], *mesh.uv.values(), *mesh.colors.values()]
        columns += (
            [] if mesh.normals is None else [_normal_key(mesh.normals, mesh.vertex_of_corner, len(mesh.vertices))]
        )
        values = np.concatenate([np.asarray(column, np.float32) for column in columns], axis=1)
        split, old, corner = split_corners(mesh.vertex_of_corner[used], len(mesh.vertices), values[used])
        # Vertices without faces have corner 0; no triangle uses them.
        self.corner = used[corner] if len(used) else corner
        number = np.empty(len(mesh.vertex_of_corner), np.int64)
        number[used] = split
        faces = number[mesh.triangles]
        uvs, colours = list(mesh.uv.values()), list(mesh.colors.values())
        others = {f"TEXCOORD_{i}": values for i, values in enumerate(uvs) if i} | {
            f"COLOR_{i}": values for i, values in enumerate(colours) if i
        }
        if len(np.unique(mesh.face_class)) > 1:
            others["FACE_CLASS"] = mesh.face_class

        def of_vertices(values: Floats) -> Floats:
            return np.asarray(values, np.float32)[self.corner]

        self.levels = tristrip.Levels(
            mesh.vertices[old],
            faces,
            method="sequential",
            normals=None if mesh.normals is None else of_vertices(mesh.normals),
            uv=of_vertices(uvs[0]) if uvs else None,
            colors=np.clip(of_vertices(colours[0]), 0, 1) if colours else None,
            attributes={name: of_vertices(values) for name, values in others.items()},
        )

    def level(self, *, ratio: float | None = None, error: float | None = None) -> Level:
        """Move to a level.

        Args:
            ratio: the ratio of triangles to keep.
            error: the maximum error in percent of the bounding-box diagonal. With both, the first
                one reached ends the simplification.
        """
        reached = []
        if ratio is not None:
            reached.append(self.levels.set_triangles(round(self.full_count * ratio)))
        if error is not None:
            reached.append(self.levels.set_error(f"{error}%"))
        self.levels.set_level(max(reached, default=self.levels.last_level))
        return Level(self.corner[self.levels.triangles()].astype(np.int64), float(self.levels.surface_error))


def _normal_key(normals: Floats, vertex_of_corner: Ints, vertex_count: int) -> Floats:
    """Return values that differ where the corner normals of a vertex differ beyond rounding."""
    sums = np.stack([np.bincount(vertex_of_corner, column, vertex_count) for column in normals.T], axis=1)
    means = sums / np.maximum(np.linalg.norm(sums, axis=1), 1e-12)[:, None]
    differs = np.linalg.norm(normals - means[vertex_of_corner], axis=1) > 0.01
    is_split = np.bincount(vertex_of_corner, differs, vertex_count) > 0
    return np.where(is_split[vertex_of_corner, None], np.round(normals, 2), 0)


#: The levels of the last mesh, by its digest.
_last: dict[bytes, MeshLevels] = {}


def levels_of(mesh: CornerMesh) -> MeshLevels:
    """Return the levels of a mesh, cached for the last one to keep sliders responsive."""
    key = mesh.key()
    if key not in _last:
        _last.clear()
        _last[key] = MeshLevels(mesh)
    return _last[key]
