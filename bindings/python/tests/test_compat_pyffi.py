"""`tristrip.compat.pyffi` against the module that it replaces."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from meshes import read_model
from tristrip.compat import pyffi as ours

theirs = pytest.importorskip("pyffi.utils.tristrip", reason="PyFFI is not installed", exc_type=ImportError)

Triangle = tuple[int, int, int]

MODELS = ["wingnut.ply", "non_manif_hole.ply", "galleon.ply", "airplane.ply", "cow.ply"]

CASES: list[list[Triangle]] = [
    [],
    [(7, 7, 7)],
    [(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)],
    [(3 * i, 3 * i + 1, 3 * i + 2) for i in range(8)],
    [(0, 1, 2), (0, 1, 2), (1, 2, 0)],
    [(0, 1, 2), (2, 1, 0)],
    [(0, 1, 2), (2, 1, 0), (1, 2, 3)],
    [(0, 1, 2), (0, 1, 3)],
    [(0, 1, 2), (1, 0, 1), (2, 1, 3), (4, 4, 4)],
]


def drawn(triangles: Iterable[Sequence[int]]) -> Counter[Triangle]:
    """Count triangles rotated to their lowest corner, which preserves winding."""
    found: Counter[Triangle] = Counter()
    for triangle in triangles:
        a, b, c = triangle
        if len({a, b, c}) == 3:
            found[min((a, b, c), (b, c, a), (c, a, b))] += 1
    return found


def once(triangles: Iterable[Sequence[int]]) -> Counter[Triangle]:
    return Counter(set(drawn(triangles)))


def faces_of(path: Path) -> list[list[int]]:
    """Return the faces of a model, with polygons as fans."""
    return [[face[0], face[i], face[i + 1]] for face in read_model(path)[1] for i in range(1, len(face) - 1)]


def words(strips: list[list[int]]) -> int:
    """Return the size of strips in a NIF file: their vertices, and one length per strip."""
    return sum(len(strip) + 1 for strip in strips)


@pytest.mark.parametrize("triangles", CASES)
@pytest.mark.parametrize("stitches", [False, True])
def test_both_draw_each_triangle_once(triangles: list[Triangle], stitches: bool) -> None:
    found = [module.stripify(triangles, stitchstrips=stitches) for module in (ours, theirs)]
    for strips in found:
        assert drawn(theirs.triangulate(strips)) == once(triangles)
        assert isinstance(strips, list)
        assert all(isinstance(strip, list) for strip in strips)
        assert all(type(vertex) is int for strip in strips for vertex in strip)
    if not stitches:
        assert words(found[0]) <= words(found[1])
    else:
        assert len(found[0]) == len(found[1]) == 1


@pytest.mark.parametrize("name", MODELS)
def test_models_get_fewer_indices(name: str, model: Callable[[str], Path]) -> None:
    faces = faces_of(model(name))
    mine, other = ours.stripify(faces), theirs.stripify(faces)
    assert drawn(ours.triangulate(mine)) == once(faces) == drawn(theirs.triangulate(other))
    assert words(mine) < words(other)
    assert len(mine) < len(other)
    joined = [stitch(other) for stitch in (ours.stitch_strips, theirs.stitch_strips)]
    assert all(drawn(theirs.triangulate([strip])) == once(faces) for strip in joined)
    assert len(joined[0]) <= len(joined[1])


@pytest.mark.parametrize("name", ["wingnut.ply", "airplane.ply"])
def test_one_strip_for_nif(name: str, model: Callable[[str], Path]) -> None:
    faces = faces_of(model(name))
    (strip,) = ours.stripify(faces, stitchstrips=True)
    (other,) = theirs.stripify(faces, stitchstrips=True)
    assert drawn(theirs.triangulate([strip])) == once(faces)
    assert len(strip) < len(other)
    # NIF stores the triangle count of a strip, including degenerate triangles, in 16 bits.
    assert max(strip) < 1 << 16


@given(st.lists(st.tuples(*[st.integers(0, 9)] * 3), max_size=30), st.booleans())
@settings(max_examples=300, deadline=None)
def test_any_triangles(triangles: list[Triangle], stitches: bool) -> None:
    assert drawn(ours.triangulate(ours.stripify(triangles, stitches))) == once(triangles)


@given(st.lists(st.lists(st.integers(0, 9), max_size=12), max_size=8))
@settings(max_examples=300, deadline=None)
def test_strips_are_read_alike(strips: list[list[int]]) -> None:
    assert ours.triangulate(strips) == theirs.triangulate(strips)
    for strip in strips:
        if strip:
            assert ours.unstitch_strip(strip) == theirs.unstitch_strip(strip)


@given(st.lists(st.lists(st.integers(0, 9), min_size=3, max_size=9), max_size=8))
@settings(max_examples=300, deadline=None)
def test_strips_are_joined_with_their_winding(strips: list[list[int]]) -> None:
    try:
        other = theirs.stitch_strips(strips)
    except ValueError:
        with pytest.raises(ValueError, match="three different"):
            ours.stitch_strips(strips)
        return
    joined = ours.stitch_strips(strips)
    assert drawn(ours.triangulate([joined])) == drawn(ours.triangulate(strips)) == drawn(theirs.triangulate([other]))


def test_joining_is_shorter_on_the_whole() -> None:
    randoms = random.Random(1)
    lengths = [0, 0]
    for _ in range(500):
        strips = [[randoms.randrange(40) for _ in range(randoms.randrange(4, 9))] for _ in range(12)]
        strips = [strip for strip in strips if strip[0] != strip[1] and strip[-1] != strip[-2]]
        lengths = [
            length + len(stitch(strips))
            for length, stitch in zip(lengths, (ours.stitch_strips, theirs.stitch_strips), strict=True)
        ]
    assert lengths[0] < lengths[1]


def test_joining_many_strips_takes_linear_time() -> None:
    strips = [[4 * i, 4 * i + 1, 4 * i + 2, 4 * i + 3][: 3 + i % 2] for i in range(50_000)]
    assert drawn(ours.triangulate([ours.stitch_strips(strips)])) == drawn(ours.triangulate(strips))


@given(st.lists(st.lists(st.integers(0, 9), min_size=1, max_size=9), min_size=2, max_size=2))
@settings(max_examples=300, deadline=None)
def test_oriented_strips(strips: list[list[int]]) -> None:
    try:
        expected = [theirs.OrientedStrip(strip) for strip in strips]
    except ValueError:
        with pytest.raises(ValueError, match="three different"):
            [ours.OrientedStrip(strip) for strip in strips]
        return
    found = [ours.OrientedStrip(strip) for strip in strips]
    for _ in range(2):
        assert [str(strip) for strip in found] == [str(strip) for strip in expected]
        assert [repr(strip) for strip in found] == [repr(strip) for strip in expected]
        assert [len(strip) for strip in found] == [len(list(strip)) for strip in expected]
        assert [(strip.vertices, strip.reversed) for strip in found] == [
            (strip.vertices, strip.reversed) for strip in expected
        ]
        assert found[0].get_num_stitches(found[1]) == expected[0].get_num_stitches(expected[1])
        assert list(found[0] + found[1]) == list(expected[0] + expected[1])
        found[0].reverse()
        expected[0].reverse()


def test_inputs() -> None:
    expected = [(0, 1, 2), (2, 1, 3)]
    inputs: list[Any] = [
        iter(expected),
        [list(triangle) for triangle in expected],
        np.array(expected),
        np.array(expected, dtype=np.uint16),
        ([np.int32(vertex) for vertex in triangle] for triangle in expected),
    ]
    for triangles in inputs:
        assert drawn(ours.triangulate(ours.stripify(triangles))) == drawn(expected)


@pytest.mark.parametrize("shift", [-5, 10**9, 2**32 - 2, 2**63 - 2, -(2**63) - 2, 10**30])
@pytest.mark.parametrize("stitches", [False, True])
def test_integers_of_any_size(shift: int, stitches: bool) -> None:
    triangles = [(a + shift, b + shift, c + shift) for a, b, c in CASES[2]]
    strips = ours.stripify(triangles, stitches)
    assert drawn(ours.triangulate(strips)) == drawn(triangles)
    assert all(type(vertex) is int for strip in strips for vertex in strip)


@pytest.mark.parametrize(
    "triangles", [[(0, 1)], [(0, 1, 2), (0, 1, 2, 3)], [(0.0, 1.0, 2.0)], [("a", "b", "c")], [None], 3, [[[0, 1, 2]]]]
)
def test_wrong_triangles(triangles: object) -> None:
    with pytest.raises(TypeError):
        ours.stripify(triangles)  # type: ignore[arg-type]
