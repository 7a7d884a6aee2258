"""Strips of the faces of a mesh: which strip draws each face, in which order."""

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

    strip: the number of the strip that draws each face; of a face in several strips, the first one.
    order: the number of the triangle with which each face is first drawn.
    metrics: the figures of the strips, with the keys of `tristrip.Strips.metrics`.
    notes: what was dropped; a face that is not drawn has -1 as strip and as order.
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
    """Compute strips, prove them, and find the face of each of their triangles.

    Args:
        vertices: positions, shape (n, 3).
        corners: the vertices of all faces, one after the other.
        offsets: the start of each face in `corners`, and the end of the last one.
        triangles: the triangles into which Blender cuts the faces, as vertices, shape (m, 3).
        face_of_triangle: the face of each of these.
        effort: 0 to 9; by default that of `tristrip.stripify`.

    Triangles and quads are given to `stripify` as they are, which chooses the diagonals of quads; larger faces, which
    may be concave, are cut as Blender cuts them.
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
    # A quad is drawn by two of four triangles.
    halves = [four[:, columns] for columns in ([0, 1, 2], [0, 2, 3], [0, 1, 3], [1, 2, 3])]
    known = np.concatenate([three, *halves])
    faces = np.concatenate([faces_of_three, *[numbers[1]] * 4])
    face = faces[_matches(drawn, known)]
    strip_of = np.repeat(np.arange(len(strips)), _triangle_counts(strips))
    order = np.full(len(sizes), -1)
    strip = np.full(len(sizes), -1)
    # From the last to the first, so that the first stays.
    order[face[::-1]] = np.arange(len(drawn))[::-1]
    strip[face[::-1]] = strip_of[::-1]
    return FaceStrips(strip, order, dict(strips.metrics()), strips.notes)


def _triangle_counts(strips: Any) -> Ints:
    """Count the triangles of each strip that are not degenerate."""
    counts = []
    for strip in strips:
        a, b, c = strip[:-2], strip[1:-1], strip[2:]
        counts.append(int(((a != b) & (b != c) & (c != a)).sum()))
    return np.array(counts, np.int64)


def _matches(drawn: Ints, known: Ints) -> Ints:
    """Find each drawn triangle among the known ones, with its winding; equal ones are taken one after the other."""

    def rotated(triangles: Ints) -> Ints:
        columns = (np.argmin(triangles, axis=1)[:, None] + np.arange(3)) % 3
        return np.take_along_axis(triangles, columns, axis=1)

    both, kind = np.unique(np.concatenate([rotated(known), rotated(drawn)]), axis=0, return_inverse=True)
    kind = kind.ravel()
    of_known, of_drawn = kind[: len(known)], kind[len(known) :]
    by_kind = np.argsort(of_known, kind="stable")
    counts = np.bincount(of_known, minlength=len(both))
    starts = np.cumsum(counts) - counts
    # The how-manieth drawn triangle of its kind each one is.
    order = np.argsort(of_drawn, kind="stable")
    drawn_counts = np.bincount(of_drawn, minlength=len(both))
    rank = np.empty(len(drawn), np.int64)
    rank[order] = np.arange(len(drawn)) - np.repeat(np.cumsum(drawn_counts) - drawn_counts, drawn_counts)
    found: Ints = by_kind[starts[of_drawn] + np.minimum(rank, np.maximum(counts[of_drawn] - 1, 0))]
    return found


def colours(strip: Ints) -> Floats:
    """Return a colour per face by its strip: red, green, blue and opacity from 0 to 1; grey without a strip."""
    from tristrip.interop import strip_colours

    found = np.full((len(strip), 4), 0.5)
    found[:, 3] = 1
    has_strip = strip >= 0
    if has_strip.any():
        found[has_strip, :3] = strip_colours(int(strip.max()) + 1)[strip[has_strip]] / 255
    return found


def sentence(metrics: dict[str, Any]) -> str:
    """Say in a line what was found."""
    if not metrics:
        return "No faces to draw"
    return (
        f"{metrics['triangles']:,} triangles in {metrics['strips']:,} strips: "
        f"{metrics['indices_restart']:,} indices with restarts, "
        f"{metrics['indices_restart_per_triangle']:.3f} per triangle; proven"
    )
