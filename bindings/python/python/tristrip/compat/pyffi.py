"""A replacement for `pyffi.utils.tristrip` with the same functions, arguments and results.

    from tristrip.compat import pyffi as tristrip          # instead of: from pyffi.utils import tristrip
    strips = tristrip.stripify(triangles, stitchstrips=True)

A triangle list is any iterable of integer triples. A strip is a list of integers whose first
triangle has even winding. As in PyFFI, triangles with a repeated vertex are dropped, and duplicates
with the same winding are drawn once. The strips and their order differ from PyFFI's, but they draw
the same triangles.
"""

from __future__ import annotations

from collections import defaultdict
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from tristrip._native import stripify as _stripify

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

__all__ = ["OrientedStrip", "stitch_strips", "stripify", "triangulate", "unstitch_strip"]

_NO_FACE = "a strip needs a triangle with three different vertices"


def stripify(triangles: Iterable[Sequence[int]], stitchstrips: bool = False) -> list[list[int]]:  # noqa: FBT001, FBT002
    """Compute strips that draw every triangle exactly once, with its original winding.

    Args:
        triangles: an iterable of integer triples. Integers can have any size; a generator is
            consumed once.
        stitchstrips: whether to join all strips into one by degenerate triangles.

    Returns:
        A list of strips. With `stitchstrips`, a list of one strip, empty if there are no triangles.

    Raises:
        TypeError: a triangle does not have three vertices, or a vertex is not an integer.

    >>> from tristrip.compat import pyffi
    >>> pyffi.stripify([(0, 1, 2), (2, 1, 3), (5, 6, 7)])
    [[3, 2, 1, 0], [5, 6, 7]]
    >>> pyffi.stripify([(0, 1, 2), (2, 1, 3), (5, 6, 7)], stitchstrips=True)
    [[3, 2, 1, 0, 0, 5, 5, 6, 7]]
    """
    faces, names = _faces(triangles)
    if len(faces) == 0:
        return [[]] if stitchstrips else []
    if stitchstrips:
        joined = _stripify(faces, cost="degenerate").indices("degenerate", dtype="uint32")
        return [joined.tolist() if names is None else names[joined].tolist()]
    strips = _stripify(faces, cost="restart")
    vertices = (strips.vertices if names is None else names[strips.vertices]).tolist()
    ends = strips.offsets.tolist()
    return [vertices[start:end] for start, end in pairwise(ends)]


def _faces(triangles: Iterable[Sequence[int]]) -> tuple[npt.NDArray[np.uint32], npt.NDArray[Any] | None]:
    """Return each distinct triangle once, and the original vertices unless they are the indices."""
    given: Any = triangles if isinstance(triangles, np.ndarray) else list(triangles)
    if len(given) == 0:
        return np.empty((0, 3), np.uint32), None
    try:
        array = np.asarray(given)
    except (ValueError, OverflowError):
        array = np.empty((0, 0))
    if array.ndim != 2 or array.shape[1] != 3:
        found = next((len(face) for face in given if len(face) != 3), 3)
        raise TypeError(f"triangles: found a triangle with {found} vertices, expected 3")
    if array.dtype.kind == "f" and all(isinstance(vertex, int | np.integer) for face in given for vertex in face):
        array = np.array(given, dtype=object)  # NumPy has no integer dtype for values beyond 64 bits.
    if array.dtype.kind == "O":
        if not all(isinstance(vertex, int | np.integer) for vertex in array.flat):
            raise TypeError("triangles: expected integers")
    elif array.dtype.kind not in "iu":
        raise TypeError(f"triangles: found {array.dtype} vertices, expected integers")
    names = None
    if array.dtype.kind == "O" or array.min() < 0 or array.max() >= max(4 * array.size, 1 << 16):
        names, flat = np.unique(array.ravel(), return_inverse=True)
        array = flat.reshape(-1, 3)
    return _without_repeats(np.ascontiguousarray(array, dtype=np.uint32)), names


def _without_repeats(faces: npt.NDArray[np.uint32]) -> npt.NDArray[np.uint32]:
    """Drop triangles with a repeated vertex, and rotations of earlier triangles."""
    a, b, c = faces.T
    faces = faces[(a != b) & (b != c) & (c != a)]
    if len(faces) == 0:
        return faces
    a, b, c = faces.T
    first = np.argmin(faces, axis=1)
    rotated = [np.choose(first, corners) for corners in ((a, b, c), (b, c, a), (c, a, b))]
    order = np.lexsort(rotated[::-1])
    sorted_corners = np.stack(rotated)[:, order]
    is_new = np.append(True, (sorted_corners[:, 1:] != sorted_corners[:, :-1]).any(axis=0))
    if is_new.all():
        return faces
    # The sort is stable, so the first triangle of each kind is kept.
    kept: npt.NDArray[np.uint32] = faces[np.sort(order[is_new])]
    return kept


def triangulate(strips: Iterable[Sequence[int]]) -> list[tuple[int, int, int]]:
    """Return the triangles of strips in draw order, without degenerate ones.

    >>> from tristrip.compat import pyffi
    >>> pyffi.triangulate([[0, 1, 2, 3], [5, 6, 7]])
    [(0, 1, 2), (1, 3, 2), (5, 6, 7)]
    """
    triangles = []
    for strip in strips:
        windows = zip(strip, strip[1:], strip[2:], strict=False)
        for number, (a, b, c) in enumerate(windows):
            if len({a, b, c}) == 3:
                triangles.append((a, c, b) if number % 2 else (a, b, c))
    return triangles


class OrientedStrip:
    """A strip without degenerate triangles at its ends, and the winding of its first triangle.

    As a sequence of vertices, a reversed strip starts with its first vertex twice.

    >>> from tristrip.compat.pyffi import OrientedStrip
    >>> OrientedStrip([0, 0, 1, 2, 3]).vertices, OrientedStrip([0, 0, 1, 2, 3]).reversed
    ([0, 1, 2, 3], True)
    """

    vertices: list[int]
    reversed: bool

    def __init__(self, strip: list[int] | tuple[int, ...] | OrientedStrip) -> None:
        if isinstance(strip, OrientedStrip):
            self.vertices, self.reversed = strip.vertices[:], strip.reversed
        elif isinstance(strip, list | tuple):
            self.vertices, self.reversed = list(strip), False
            self.compactify()
        else:
            raise TypeError(f"strip: found {type(strip).__name__}, expected a list, a tuple or an OrientedStrip")

    def compactify(self) -> None:
        """Remove repeated vertices at both ends."""
        vertices = self.vertices
        start, end = 0, len(vertices)
        while start + 1 < end and vertices[start] == vertices[start + 1]:
            start += 1
        while end - 2 >= start and vertices[end - 1] == vertices[end - 2]:
            end -= 1
        if end - start < 3:
            raise ValueError(_NO_FACE)
        self.vertices = vertices[start:end]
        self.reversed = self.reversed != bool(start % 2)

    def reverse(self) -> None:
        """Reverse the order of the vertices; the triangles are unchanged."""
        self.vertices.reverse()
        if len(self.vertices) % 2:
            self.reversed = not self.reversed

    def get_num_stitches(self, other: OrientedStrip) -> int:
        """Return the number of vertices needed to join this strip and a following one."""
        meets = self.vertices[-1] == other.vertices[0]
        fits = (self.reversed != bool(len(self.vertices) % 2)) == other.reversed
        return (0 if meets else 2) + (0 if fits else 1)

    def __len__(self) -> int:
        return len(self.vertices) + self.reversed

    def __iter__(self) -> Iterator[int]:
        return iter([*self.vertices[: int(self.reversed)], *self.vertices])

    def __str__(self) -> str:
        return str(list(self))

    def __repr__(self) -> str:
        return f"OrientedStrip({self})"

    def __add__(self, other: OrientedStrip) -> OrientedStrip:
        """Join two strips with the fewest vertices between them.

        >>> from tristrip.compat.pyffi import OrientedStrip
        >>> OrientedStrip([0, 1, 2]) + OrientedStrip([5, 6, 7])
        OrientedStrip([0, 1, 2, 2, 5, 5, 5, 6, 7])
        """
        count = self.get_num_stitches(other)
        between = [self.vertices[-1]] * min(count, 1) + [other.vertices[0]] * max(count - 1, 0)
        joined = OrientedStrip(self)
        joined.vertices += between + other.vertices
        return joined


def stitch_strips(strips: Iterable[list[int] | tuple[int, ...]]) -> list[int]:
    """Join strips into one with few degenerate triangles.

    Strips are reordered and reversed; winding is preserved.

    >>> from tristrip.compat import pyffi
    >>> pyffi.stitch_strips([[3, 4, 5], [0, 1, 2, 3]])
    [0, 1, 2, 3, 3, 4, 5]
    """
    given = [OrientedStrip(strip) for strip in strips if len(strip) >= 3]
    if not given:
        return []
    chains = _Chains(given)
    chains.join_where(lambda vertex, bit: (vertex, bit))
    chains.join_where(lambda vertex, _: vertex)
    ordered = iter(chains.in_order())
    joined = next(ordered)
    for strip in ordered:
        # In place, as `+` would copy what is joined so far.
        count = joined.get_num_stitches(strip)
        joined.vertices += [joined.vertices[-1]] * min(count, 1) + [strip.vertices[0]] * max(count - 1, 0)
        joined.vertices += strip.vertices
    return list(joined)


class _Chains:
    """Strips joined at their ends.

    # Algorithm

    Each end of a strip has a vertex and a bit: whether the strip is `reversed` when drawn from this
    end. A join costs no vertex if both are equal, one vertex if the bits differ, two if the
    vertices differ, and three if both differ. The other ends of both strips keep their vertex and
    bit. Ends are therefore paired greedily, equal ones first, unless they belong to the same chain
    (detected by union-find). The remaining chains are concatenated so that adjacent bits are equal.

    # Complexity

    Nearly linear in the number of strips, plus the copying of their vertices.
    """

    def __init__(self, strips: list[OrientedStrip]) -> None:
        self.strips = strips
        # Ends 2 i and 2 i + 1 are the first and last vertex of strip i.
        self.partner: list[int | None] = [None] * (2 * len(strips))
        self.root = list(range(len(strips)))
        self.bits = [
            bit for strip in strips for bit in (strip.reversed, strip.reversed != bool(len(strip.vertices) % 2))
        ]

    def vertex(self, end: int) -> int:
        return self.strips[end // 2].vertices[-(end % 2)]

    def chain_of(self, strip: int) -> int:
        while self.root[strip] != strip:
            self.root[strip] = self.root[self.root[strip]]
            strip = self.root[strip]
        return strip

    def join_where(self, key: Any) -> None:
        """Pair free ends with equal keys that belong to different chains."""
        waiting: dict[Any, list[int]] = defaultdict(list)
        for end, partner in enumerate(self.partner):
            if partner is not None:
                continue
            others = waiting[key(self.vertex(end), self.bits[end])]
            chain = self.chain_of(end // 2)
            # All ends with the same key in the list belong to one chain; otherwise they would have
            # been joined.
            if others and self.chain_of(others[-1] // 2) != chain:
                other = others.pop()
                self.partner[end], self.partner[other] = other, end
                self.root[chain] = self.chain_of(other // 2)
            else:
                others.append(end)

    def in_order(self) -> Iterator[OrientedStrip]:
        """Yield the strips of all chains, oriented as drawn."""
        kinds: dict[tuple[bool, bool], list[int]] = defaultdict(list)
        for start, end in self._ends():
            kinds[self.bits[start], self.bits[end]].append(start)
        # Concatenate chains with equal bits. A chain with two different bits links bit 0 to bit 1,
        # and a second one links back.
        mixed = kinds[False, True] + [self._other_end(start) for start in kinds[True, False]]
        firsts = kinds[False, False] + mixed[:1] + kinds[True, True]
        for start in firsts:
            yield from self._strips_from(start)
        is_one = bool(mixed)
        for start in mixed[1:]:
            yield from self._strips_from(self._other_end(start) if is_one else start)
            is_one = not is_one

    def _ends(self) -> Iterator[tuple[int, int]]:
        """Yield both ends of each chain."""
        seen: set[int] = set()
        for end, partner in enumerate(self.partner):
            if partner is None and end not in seen:
                other = self._other_end(end)
                seen.add(other)
                yield end, other

    def _walk(self, end: int) -> Iterator[int]:
        """Yield the end at which drawing enters each strip of a chain."""
        entered: int | None = end
        while entered is not None:
            yield entered
            entered = self.partner[entered ^ 1]

    def _other_end(self, end: int) -> int:
        last = end
        for entered in self._walk(end):
            last = entered
        return last ^ 1

    def _strips_from(self, start: int) -> Iterator[OrientedStrip]:
        for entered in self._walk(start):
            strip = self.strips[entered // 2]
            if entered % 2:
                strip.reverse()
            yield strip


def unstitch_strip(strip: Sequence[int]) -> list[list[int]]:
    """Split a strip at its degenerate joins, with the original winding.

    >>> from tristrip.compat import pyffi
    >>> pyffi.unstitch_strip([0, 1, 2, 3, 3, 5, 5, 6, 7])
    [[0, 1, 2, 3], [5, 6, 7]]
    """
    strips = []
    start = 0
    for end in range(1, len(strip) + 1):
        if end < len(strip) and strip[end] != strip[end - 1]:
            continue
        # If the strip starts at an odd position, repeat its first vertex to keep the winding.
        part = [*strip[start : start + start % 2], *strip[start:end]]
        if len(part) - start % 2 >= 3:
            strips.append(part)
        start = end
    return strips
