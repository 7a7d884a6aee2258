"""The oracle and the generated meshes: comparisons must find every difference."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

import meshes
import oracle


def test_expansion_of_each_layout() -> None:
    restart = np.array([0, 1, 2, 3, 255, 4, 5, 6, 255, 7, 8], dtype=np.uint8)
    assert oracle.expand(restart, "restart").tolist() == [[0, 1, 2], [2, 1, 3], [4, 5, 6]]
    joined = np.array([0, 1, 2, 2, 3, 3, 4, 5, 6])
    assert oracle.expand(joined, "degenerate").tolist() == [[0, 1, 2], [4, 3, 5], [4, 5, 6]]
    assert oracle.expand(np.array([0, 1, 2, 3, 3, 3]), "list").tolist() == [[0, 1, 2]]
    separate = oracle.expand(np.array([0, 1, 2, 3, 4, 5, 6]), "separate", np.array([0, 3, 7]))
    assert separate.tolist() == [[0, 1, 2], [3, 4, 5], [5, 4, 6]]
    for layout in ["restart", "degenerate", "list"]:
        assert oracle.expand(np.zeros(0, dtype=np.uint16), layout).shape == (0, 3)


@pytest.mark.parametrize(
    "wrong",
    [
        [[0, 1, 2]],
        [[0, 1, 2], [2, 3, 1]],
        [[0, 1, 2], [2, 1, 3], [2, 1, 3]],
        [[0, 1, 2], [2, 1, 4]],
        [[0, 1, 2], [2, 2, 3]],
    ],
    ids=["missing", "flipped", "twice", "other vertex", "degenerate"],
)
def test_differences_are_found(wrong: list[list[int]]) -> None:
    oracle.assert_same_triangles([[1, 2, 0], [3, 2, 1]], [[0, 1, 2], [2, 1, 3]])
    with pytest.raises(AssertionError):
        oracle.assert_same_triangles(wrong, [[0, 1, 2], [2, 1, 3]])


@pytest.mark.parametrize(
    "wrong",
    [
        [[0, 1, 2]],
        [[0, 1, 2], [0, 3, 2]],
        [[0, 1, 2], [0, 2, 3], [0, 2, 3]],
        [[0, 1, 4], [0, 4, 3]],
    ],
    ids=["missing", "flipped", "twice", "other vertex"],
)
def test_wrong_triangulations_are_found(wrong: list[list[int]]) -> None:
    oracle.assert_triangulates([[0, 1, 2], [0, 2, 3]], [[0, 1, 2, 3]])
    oracle.assert_triangulates([[1, 2, 3], [3, 0, 1]], [[0, 1, 2, 3]])
    with pytest.raises(AssertionError):
        oracle.assert_triangulates(wrong, [[0, 1, 2, 3]])


def test_cache_misses() -> None:
    strips = [[0, 1, 2, 3], [0, 4, 0]]
    assert oracle.cache_misses(strips, "fifo", 3) == 6  # 0 was replaced by 3
    assert oracle.cache_misses(strips, "fifo", 4) == 6  # and here by 4
    assert oracle.cache_misses(strips, "fifo", 5) == 5
    assert oracle.cache_misses([[0, 1, 0, 2, 0, 1]], "fifo", 2) == 5
    assert oracle.cache_misses([[0, 1, 0, 2, 0, 1]], "lru", 2) == 4
    assert oracle.cache_misses(strips, "fifo", 16, flush=True) == 6


@pytest.mark.parametrize("mesh", meshes.examples(), ids=lambda mesh: mesh.name)
def test_generated_meshes_are_meshes(mesh: meshes.GeneratedMesh) -> None:
    assert mesh.vertices.dtype == np.float32
    assert mesh.vertices.shape == (len(mesh.vertices), 3)
    assert mesh.faces.dtype == np.int64
    assert mesh.faces.shape == (len(mesh.faces), 3)
    assert np.isfinite(mesh.vertices).all()
    assert not len(mesh.faces) or (mesh.faces.min() >= 0 and mesh.faces.max() < len(mesh.vertices))


def edges(faces: meshes.Triangles) -> Counter[tuple[int, int]]:
    return Counter((face[i], face[i - 1]) for face in faces.tolist() for i in range(3))


@pytest.mark.parametrize(("mesh", "genus"), [(meshes.sphere(2), 0), (meshes.torus(5, 4), 1)])
def test_closed_meshes_have_their_genus(mesh: meshes.GeneratedMesh, genus: int) -> None:
    directed = edges(mesh.faces)
    assert all(count == 1 and directed[v, u] == 1 for (u, v), count in directed.items())
    assert len(mesh.vertices) - len(directed) // 2 + len(mesh.faces) == 2 - 2 * genus


def test_the_fan_is_not_manifold() -> None:
    assert edges(meshes.fan(5).faces)[1, 0] == 5
