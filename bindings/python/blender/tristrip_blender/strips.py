"""Strips of the faces of a mesh: the strip and draw order of each face."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

Ints = npt.NDArray[Any]
Floats = npt.NDArray[Any]


@dataclass
class FaceStrips:
    """The strips of a mesh.

    Attributes:
        strip: the strip index of each face. A face in several strips has the first one. -1 if the
            face is not drawn.
        order: the index of the triangle that first draws each face, or -1.
        metrics: the metrics of the strips, with the keys of `tristrip.Strips.metrics`.
        notes: notes on dropped faces.
    """

    strip: Ints
    order: Ints
    metrics: dict[str, Any]
    notes: list[str] = field(default_factory=list)


def face_strips(
    vertices: Floats,
    corners: Ints,
    offsets: Ints,
    triangles: Ints,
    face_of_triangle: Ints,
    *,
    effort: int | None = None,
) -> FaceStrips:
    """Compute strips, prove them, and find the face of each drawn triangle.

    Triangles and quads are passed to `stripify`, which chooses the diagonals of quads. Larger faces
    can be concave, so Blender's triangulation is used.

    Args:
        vertices: positions, shape (n, 3).
        corners: the vertices of all faces, concatenated.
        offsets: the start of each face in `corners`, and the end of the last one.
        triangles: Blender's triangulation of the faces as vertex indices, shape (m, 3).
        face_of_triangle: the face of each triangle.
        effort: 0 to 9. By default that of `tristrip.stripify`.
    """
    import tristrip

    sizes = np.diff(offsets)
    larger = sizes[face_of_triangle] > 4
    numbers = [np.flatnonzero(sizes == 3), np.flatnonzero(sizes == 4)]
    three, four = (
        corners[offsets[of_size, None] + np.arange(size)] for of_size, size in zip(numbers, (3, 4), strict=True)
    )
    three = np.concatenate([three, triangles[larger]])
    faces_of_three = np.concatenate([numbers[0], face_of_triangle[larger]])
    given = three.tolist() + four.tolist() if len(three) and len(four) else (three if len(three) else four)
    if len(given) == 0:
        return FaceStrips(np.empty(0, np.int64), np.empty(0, np.int64), {})
    strips = tristrip.stripify(given, vertices, effort=effort, verify=True)
    drawn = strips.triangles().astype(np.int64)
    # A quad is drawn by two of four possible triangles.
    halves = [four[:, columns] for columns in ([0, 1, 2], [0, 2, 3], [0, 1, 3], [1, 2, 3])]
    known = np.concatenate([three, *halves])
    faces = np.concatenate([faces_of_three, *[numbers[1]] * 4])
    face = faces[_matches(drawn, known)]
    strip_of = np.repeat(np.arange(len(strips)), _triangle_counts(strips))
    order = np.full(len(sizes), -1)
    strip = np.full(len(sizes), -1)
    # Assign in reverse, so that the first triangle of a face wins.
    order[face[::-1]] = np.arange(len(drawn))[::-1]
    strip[face[::-1]] = strip_of[::-1]
    return FaceStrips(strip, order, dict(strips.metrics()), strips.notes)


def _triangle_counts(strips: Any) -> Ints:
    """Count the non-degenerate triangles of each strip."""
    counts = []
    for strip in strips:
        a, b, c = strip[:-2], strip[1:-1], strip[2:]
        counts.append(int(((a != b) & (b != c) & (c != a)).sum()))
    return np.array(counts, np.int64)


def _matches(drawn: Ints, known: Ints) -> Ints:
    """Match drawn triangles to known ones with the same winding, duplicates in order."""

    def rotated(triangles: Ints) -> Ints:
        columns = (np.argmin(triangles, axis=1)[:, None] + np.arange(3)) % 3
        return np.take_along_axis(triangles, columns, axis=1)

    both, kind = np.unique(np.concatenate([rotated(known), rotated(drawn)]), axis=0, return_inverse=True)
    kind = kind.ravel()
    of_known, of_drawn = kind[: len(known)], kind[len(known) :]
    by_kind = np.argsort(of_known, kind="stable")
    counts = np.bincount(of_known, minlength=len(both))
    starts = np.cumsum(counts) - counts
    # The rank of each drawn triangle among its duplicates.
    order = np.argsort(of_drawn, kind="stable")
    drawn_counts = np.bincount(of_drawn, minlength=len(both))
    rank = np.empty(len(drawn), np.int64)
    rank[order] = np.arange(len(drawn)) - np.repeat(np.cumsum(drawn_counts) - drawn_counts, drawn_counts)
    found: Ints = by_kind[starts[of_drawn] + np.minimum(rank, np.maximum(counts[of_drawn] - 1, 0))]
    return found


def colours(strip: Ints) -> Floats:
    """Return a colour per face from its strip: RGBA from 0 to 1, grey without a strip."""
    from tristrip.interop import strip_colours

    found = np.full((len(strip), 4), 0.5)
    found[:, 3] = 1
    has_strip = strip >= 0
    if has_strip.any():
        found[has_strip, :3] = strip_colours(int(strip.max()) + 1)[strip[has_strip]] / 255
    return found


def sentence(metrics: dict[str, Any]) -> str:
    """Return a one-line summary."""
    if not metrics:
        return "No faces to draw"
    return (
        f"{metrics['triangles']:,} triangles in {metrics['strips']:,} strips: "
        f"{metrics['indices_restart']:,} indices with restarts, "
        f"{metrics['indices_restart_per_triangle']:.3f} per triangle; proven"
    )
