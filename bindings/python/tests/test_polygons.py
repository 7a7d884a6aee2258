"""Faces with positions: polygons of any size, triangulated along strips, and welded vertices."""

from __future__ import annotations

from typing import Any

import hypothesis
import numpy as np
import pytest
from hypothesis import strategies as st

import meshes
import oracle
import tristrip
from stub import choices

METHODS = choices("Method")


def area(vertices: Any, faces: list[list[int]]) -> float:
    """Return the area of counterclockwise faces in the plane z = 0."""
    points = np.asarray(vertices, dtype=np.float64)[:, :2]
    return sum(
        float(points[a, 0] * points[b, 1] - points[b, 0] * points[a, 1]) / 2
        for face in faces
        for a, b in zip(face, [*face[1:], face[0]], strict=True)
    )


@pytest.mark.parametrize("method", METHODS)
def test_quadrilaterals(method: str) -> None:
    mesh, quads = meshes.grid(7, 5), meshes.grid_quads(7, 5)
    strips = tristrip.stripify(quads, mesh.vertices, method=method, verify=True)
    oracle.assert_triangulates(strips.triangles(), quads.tolist())
    assert dict(strips.verify(quads, mesh.vertices)) == {"faces": 35, "triangles": 70}
    # The same faces as lists.
    assert tristrip.stripify(quads.tolist(), mesh.vertices, method=method, verify=True) == strips


@hypothesis.given(mesh=meshes.polygon_meshes(), method=st.sampled_from(METHODS))
@hypothesis.settings(max_examples=100)
def test_polygons_of_several_sizes(mesh: tuple[meshes.Positions, meshes.Polygons], method: str) -> None:
    vertices, polygons = mesh
    strips = tristrip.stripify(polygons, vertices, method=method, verify=True)
    oracle.assert_triangulates(strips.triangles(), polygons)
    strips.verify(polygons, vertices)


@pytest.mark.parametrize(
    "points",
    [
        [(0, 0), (4, 0), (4, 4), (2, 1), (0, 4)],
        [(0, 0), (3, 0), (3, 1), (1, 1), (1, 2), (3, 2), (3, 3), (0, 3)],
        [(0, 0), (2, 0.5), (4, 0), (3.5, 2), (4, 4), (2, 3.5), (0, 4), (0.5, 2)],
    ],
    ids=["arrow", "C", "star"],
)
@pytest.mark.parametrize("method", METHODS)
def test_concave_polygons(points: list[tuple[float, float]], method: str) -> None:
    vertices = np.array([(x, y, 0) for x, y in points])
    polygon = [list(range(len(points)))]
    triangles = tristrip.stripify(polygon, vertices, method=method, verify=True).triangles().tolist()
    oracle.assert_triangulates(triangles, polygon)
    # No triangle is flipped or outside; otherwise the areas would not add up.
    areas = [area(vertices, [triangle]) for triangle in triangles]
    assert min(areas) > 0
    assert sum(areas) == pytest.approx(area(vertices, polygon))


@pytest.mark.parametrize("corners", [4, 5, 8, 100, 1000])
def test_one_convex_polygon(corners: int) -> None:
    angles = np.arange(corners) * 2 * np.pi / corners
    vertices = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(corners)])
    strips = tristrip.stripify([list(range(corners))], vertices)
    oracle.assert_triangulates(strips.triangles(), [range(corners)])
    assert len(strips) == 1


@pytest.mark.parametrize("faces", [[[0, 1, 2, 3]], np.array([[0, 1, 2, 3]]), [[0, 1, 2], [0, 1, 2, 3]]])
def test_polygons_need_positions(faces: Any) -> None:
    with pytest.raises(tristrip.ParameterError, match="vertices: found None, expected positions, for polygons"):
        tristrip.stripify(faces)


@pytest.mark.parametrize(
    ("faces", "count"), [([[0, 1, 2], [0, 1], [3]], 2), ([[0, 1, 2, 0], [0, 1, 1, 0]], 1), ([[], [0, 1, 2], []], 2)]
)
def test_what_is_no_face_is_noted(faces: list[list[int]], count: int) -> None:
    strips = tristrip.stripify(faces, np.random.default_rng(1).normal(size=(4, 3)))
    assert strips.metrics()["triangles"] == 1
    assert any(str(count) in note and "degenerate" in note for note in strips.notes), strips.notes


def test_welded_vertices() -> None:
    mesh = meshes.grid(8, 6)
    vertices, faces = mesh.vertices[mesh.faces.ravel()], np.arange(mesh.faces.size).reshape(-1, 3)
    loose = tristrip.stripify(faces, vertices)
    assert len(loose) == len(faces)
    strips = tristrip.stripify(faces, vertices, weld=True, verify=True)
    assert len(strips) < len(faces) / 4
    drawn = vertices[strips.triangles()]
    expected = vertices[faces]

    def rows(triangles: Any) -> Any:
        return oracle.canonical(np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)[1]).tolist()

    assert rows(drawn) == rows(expected)
    assert strips.verify(faces, vertices)["triangles"] == len(faces)
    with pytest.raises(tristrip.ParameterError, match="vertices: found None, expected the positions"):
        strips.verify(faces)


def test_weld_needs_positions() -> None:
    with pytest.raises(tristrip.ParameterError, match="vertices: found None, expected positions, by which"):
        tristrip.stripify([[0, 1, 2]], weld=True)


@pytest.mark.parametrize("dtype", ["float16", "float32", "float64", "longdouble", "int8", "int64", "uint16", ">f8"])
def test_positions_of_every_dtype(dtype: str) -> None:
    vertices, polygons = np.array([[0, 0, 0], [4, 0, 0], [4, 4, 0], [2, 1, 0], [0, 4, 0]]), [[0, 1, 2, 3, 4]]
    assert tristrip.stripify(polygons, vertices.astype(dtype)) == tristrip.stripify(polygons, vertices)
