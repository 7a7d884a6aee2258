"""An independent oracle: index buffers as triangles, in NumPy without the package.

Triangle i of a strip has the vertices i, i + 1, i + 2, in this order for even i, and with the first
two swapped for odd i. Triangles with two equal vertices draw nothing. Two triangles are equal if
one is a rotation of the other.
"""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Iterable, Sequence
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

IntArray: TypeAlias = npt.NDArray[np.int64]
Indices: TypeAlias = npt.NDArray[Any]


def expand(indices: Indices, layout: str, offsets: Indices | None = None) -> IntArray:
    """Return the triangles of an index buffer in draw order, shape (n, 3).

    offsets: the starts of strips and the end of the last one; required for the layout "separate".
    """
    flat = np.asarray(indices)
    assert flat.ndim == 1
    if layout == "list":
        assert len(flat) % 3 == 0
        return _drawn(flat.astype(np.int64).reshape(-1, 3))
    breaks = np.zeros(len(flat), dtype=bool)
    starts = np.zeros(len(flat), dtype=np.int64)
    if layout == "restart":
        breaks = flat == np.iinfo(flat.dtype).max
        starts = np.maximum.accumulate(np.where(breaks, np.arange(len(flat)) + 1, 0)) if len(flat) else starts
    elif layout == "separate":
        assert offsets is not None
        ends = np.asarray(offsets, dtype=np.int64)
        assert ends[0] == 0
        assert ends[-1] == len(flat)
        starts = np.repeat(ends[:-1], np.diff(ends))
    else:
        assert layout == "degenerate"
    if len(flat) < 3:
        return np.zeros((0, 3), dtype=np.int64)
    windows = np.lib.stride_tricks.sliding_window_view(flat.astype(np.int64), 3)
    first = np.arange(len(windows))
    inside = (starts[2:] == starts[:-2]) & ~(breaks[:-2] | breaks[1:-1] | breaks[2:])
    odd = (first - starts[:-2]) % 2 == 1
    triangles = np.where(odd[:, None], windows[:, [1, 0, 2]], windows)
    return _drawn(triangles[inside])


def _drawn(triangles: IntArray) -> IntArray:
    a, b, c = triangles.T
    drawn: IntArray = triangles[(a != b) & (b != c) & (c != a)]
    return drawn


def canonical(triangles: npt.ArrayLike) -> IntArray:
    """Rotate triangles to their lowest vertex, drop degenerate ones, and sort them."""
    rows = _drawn(np.asarray(triangles, dtype=np.int64).reshape(-1, 3))
    first = np.argmin(rows, axis=1)
    rows = np.take_along_axis(rows, (first[:, None] + np.arange(3)) % 3, axis=1)
    return rows[np.lexsort(rows.T[::-1])]


def assert_same_triangles(found: npt.ArrayLike, expected: npt.ArrayLike) -> None:
    """Fail unless both have the same triangles, equally often and with the same winding."""
    left, right = canonical(found), canonical(expected)
    if left.shape == right.shape and np.array_equal(left, right):
        return
    counts, wanted = (Counter(map(tuple, rows.tolist())) for rows in (left, right))
    extra, missing = counts - wanted, wanted - counts
    raise AssertionError(
        f"{missing.total()} triangles missing: {_some(missing)}; {extra.total()} extra: {_some(extra)}"
    )


def _some(triangles: Counter[tuple[int, ...]]) -> str:
    return ", ".join(map(str, list(triangles)[:3])) or "none"


def assert_triangulates(found: npt.ArrayLike, polygons: Iterable[Sequence[int]]) -> None:
    """Fail unless triangles triangulate simple polygons.

    Each polygon has as many triangles as corners minus two, each triangle lies in one polygon, and
    the oriented edges of all triangles, without the diagonals, which cancel out, are those of the
    polygons.
    """
    triangles = canonical(found).tolist()
    faces = [list(map(int, polygon)) for polygon in polygons]
    expected = sum(len(face) - 2 for face in faces)
    assert len(triangles) == expected, f"{len(triangles)} triangles, the polygons have {expected}"
    assert _boundary(triangles) == _boundary(faces), "the oriented edges differ"
    of_vertex: dict[int, set[int]] = {}
    for number, face in enumerate(faces):
        for vertex in face:
            of_vertex.setdefault(vertex, set()).add(number)
    for triangle in triangles:
        shared = set.intersection(*(of_vertex[vertex] for vertex in triangle))
        assert shared, f"{triangle} lies in no polygon"


def _boundary(faces: Iterable[Sequence[int]]) -> Counter[tuple[int, int]]:
    """Return the count of each edge, oriented from lower to higher vertex, minus its reverse."""
    edges: Counter[tuple[int, int]] = Counter()
    for face in faces:
        for u, v in zip(face, [*face[1:], face[0]], strict=True):
            edges[min(u, v), max(u, v)] += 1 if u < v else -1
    return Counter({edge: count for edge, count in edges.items() if count})


def cache_misses(strips: Iterable[Sequence[int]], policy: str, entries: int, *, flush: bool = False) -> int:
    """Count the misses of a vertex cache, vertex by vertex, with the policy "fifo" or "lru"."""
    misses = 0
    cache: deque[int] = deque()
    for strip in strips:
        if flush:
            cache.clear()
        for vertex in strip:
            if vertex in cache:
                if policy == "lru":
                    cache.remove(vertex)
                    cache.append(vertex)
                continue
            misses += 1
            cache.append(vertex)
            if len(cache) > entries:
                cache.popleft()
    return misses


def figures(vertices: Indices, offsets: Indices) -> dict[str, float]:
    """Return the metrics of strips, without joining triangles, keyed as in the command's JSON."""
    strips = [part.tolist() for part in np.split(np.asarray(vertices, dtype=np.int64), np.asarray(offsets)[1:-1])]
    if len(offsets) == 1:
        strips = []
    triangles = len(expand(vertices, "separate", offsets))
    windows = sum(max(len(strip) - 2, 0) for strip in strips)
    sent = sum(map(len, strips))
    per = max(triangles, 1)
    used = max(len(set(map(int, vertices))), 1)
    found: dict[str, float] = {
        "triangles": triangles,
        "strips": len(strips),
        "isolated": sum(len(expand(np.array(strip), "degenerate")) == 1 for strip in strips),
        "vertices_sent": sent,
        "swaps": windows - triangles,
        "gl_cost": sent - (windows - triangles),
        "indices_restart": sent + max(len(strips) - 1, 0),
        "vertices_per_triangle": sent / per,
        "indices_restart_per_triangle": (sent + max(len(strips) - 1, 0)) / per,
    }
    for entries in (16, 32):
        misses = cache_misses(strips, "fifo", entries)
        found |= {f"acmr_fifo_{entries}": misses / per, f"atvr_fifo_{entries}": misses / used}
    return found
