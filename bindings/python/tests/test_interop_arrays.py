"""Shared code of conversions: supported arrays, errors of invalid ones, and missing packages."""

from __future__ import annotations

import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import tristrip
from interop_meshes import POLYGONS, fans, vertices
from tristrip.interop import _arrays as arrays
from tristrip.interop._arrays import Faces, part_of


@pytest.mark.parametrize("package", ["trimesh", "pyvista", "open3d", "meshio"])
def test_missing_packages_are_named(package: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    to, of = getattr(tristrip, f"to_{package}"), getattr(tristrip, f"from_{package}")
    for function, arguments in ((to, (vertices(), POLYGONS)), (of, (object(),))):
        with pytest.raises(ImportError, match=f"pip install {package}") as caught:
            function(*arguments)
        assert caught.value.name == package


def test_importing_imports_no_other_package() -> None:
    import subprocess

    code = "import sys, tristrip; print({'trimesh', 'pyvista', 'open3d', 'meshio', 'vtk', 'PIL'} & set(sys.modules))"
    folder = str(Path(tristrip.__file__).parents[1])
    done = subprocess.run([sys.executable, "-c", code], cwd=folder, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"


def test_faces_in_every_form() -> None:
    assert Faces.of("faces", POLYGONS).as_argument()[3].tolist() == POLYGONS[3]
    assert Faces.of("faces", [0, 1, 2, 2, 1, 3]).triangles().tolist() == [[0, 1, 2], [2, 1, 3]]
    assert Faces.of("faces", np.array([[0, 1, 3, 2]], np.uint8)).sizes.tolist() == [4]
    assert len(Faces.of("faces", [])) == 0
    assert Faces.of("faces", POLYGONS).triangles().tolist() == fans(POLYGONS)
    assert Faces.of("faces", []).as_argument().shape == (0, 3)


@given(st.lists(st.lists(st.integers(0, 9), min_size=3, max_size=7), max_size=12), st.randoms())
@settings(max_examples=200, deadline=None)
def test_faces_against_lists(polygons: list[list[int]], random: Any) -> None:
    faces = Faces.of("faces", polygons)
    assert [list(face) for face in faces.as_argument()] == polygons
    assert faces.triangles().tolist() == fans(polygons)
    order = list(range(len(polygons)))
    random.shuffle(order)
    reordered = faces.reordered(np.array(order, np.int64))
    assert [list(face) for face in reordered.as_argument()] == [polygons[i] for i in order]
    blocks = {
        int(number): row.tolist()
        for _, numbers, rows in faces.by_size()
        for number, row in zip(numbers, rows, strict=True)
    }
    assert [blocks[i] for i in range(len(polygons))] == polygons


@given(st.integers(0, 8), st.data())
@settings(max_examples=200, deadline=None)
def test_split_corners(count: int, data: st.DataObject) -> None:
    faces = np.array(
        data.draw(st.lists(st.lists(st.integers(0, 9), min_size=3, max_size=3), min_size=count, max_size=count)),
        np.int64,
    ).reshape(-1, 3)
    values = np.array(data.draw(st.lists(st.integers(0, 2), min_size=3 * count, max_size=3 * count)), float).reshape(
        -1, 1
    )
    new, old, corner = arrays.split_corners(faces.ravel(), 10, values)
    assert old[new].tolist() == faces.ravel().tolist()
    assert values[corner[new]].tolist() == values.tolist()
    assert sorted(set(old)) == list(range(10))
    assert (np.diff(old) >= 0).all()
    assert len({(int(v), float(x)) for v, x in zip(faces.ravel(), values[:, 0], strict=True)}) == len(np.unique(new))
    assert set(np.flatnonzero(corner < 0)) == set(range(len(old))) - set(new)


@pytest.mark.parametrize(
    ("faces", "error", "text"),
    [
        ([[0, 1, 9]], tristrip.MeshError, "vertex 9, expected 0 to 8"),
        ([[0, 1, -1]], tristrip.MeshError, "vertex -1"),
        (np.array([[0, 1, 2**64 - 1]], np.uint64), tristrip.MeshError, "32-bit"),
        ([[0.0, 1.0, 2.0]], tristrip.ArrayTypeError, "dtype float64"),
        ([[0, 1]], tristrip.MeshError, "shape"),
        ([["a", "b", "c"]], tristrip.ArrayTypeError, "dtype"),
    ],
)
def test_wrong_faces(faces: Any, error: type[Exception], text: str) -> None:
    with pytest.raises(error, match=text):
        part_of(vertices(), faces)


@pytest.mark.parametrize(
    ("mesh", "error"),
    [
        (3, tristrip.ArrayTypeError),
        ("bunny", tristrip.ArrayTypeError),
        ((1, 2, 3), tristrip.ArrayTypeError),
        ((np.zeros((2, 2)), [[0, 1, 2]]), tristrip.MeshError),
        ((np.full((3, 3), np.nan), [[0, 1, 2]]), tristrip.MeshError),
        ((np.full((3, 3), "x"), [[0, 1, 2]]), tristrip.ArrayTypeError),
    ],
)
def test_wrong_meshes(mesh: Any, error: type[Exception]) -> None:
    with pytest.raises(error):
        part_of(mesh)


def test_wrong_attributes() -> None:
    with pytest.raises(tristrip.MeshError, match="uv: found shape"):
        part_of(vertices(), POLYGONS, uv=np.zeros((3, 2)))
    with pytest.raises(tristrip.ArrayTypeError, match="heat"):
        part_of(vertices(), POLYGONS, attributes={"heat": ["x"] * 9})


def test_strips_with_a_vertex_out_of_range() -> None:
    with pytest.raises(tristrip.MeshError, match="vertex 8"):
        part_of(vertices()[:8], tristrip.stripify([[0, 1, 8]]))


def test_simplified_meshes_are_taken_with_their_attributes() -> None:
    small = tristrip.simplify(vertices(), POLYGONS, ratio=1.0, uv=vertices()[:, :2])
    part = part_of(small)
    assert part.vertices.tolist() == small.vertices.tolist()
    assert part.triangles().tolist() == small.faces.tolist()
    assert list(part.attributes) == ["TEXCOORD_0"]


def test_warnings_name_the_line_of_the_caller() -> None:
    meshio = pytest.importorskip("meshio")
    mesh = meshio.Mesh(np.zeros((4, 3)), [("tetra", [[0, 1, 2, 3]]), ("triangle", [[0, 1, 2]])])
    from tristrip.interop._meshio import part_of_meshio

    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        part_of_meshio(mesh)
    assert [(warning.category, warning.filename) for warning in caught] == [(tristrip.ConversionWarning, __file__)]


@given(st.lists(st.floats(-2, 2), min_size=9, max_size=9))
@settings(max_examples=100, deadline=None)
def test_placed_parts_turn_with_their_normals(numbers: list[float]) -> None:
    transform = np.eye(4)
    transform[:3, :3] = np.array(numbers).reshape(3, 3)
    transform[:3, 3] = [1, 2, 3]
    if abs(np.linalg.det(transform)) < 0.05:
        return
    points = np.array([[0, 0, 0], [1, 0, 0.5], [0, 1, 0.25], [1, 1, 0.75]])
    normal = np.cross(points[1] - points[0], points[2] - points[0])
    normal /= np.linalg.norm(normal)
    part = part_of(points, [[0, 1, 3, 2]], normals=np.tile(normal, (4, 1)))
    placed = part.placed(transform)
    assert np.allclose(placed.vertices, points @ transform[:3, :3].T + [1, 2, 3])
    for a, b, c in placed.vertices[placed.triangles()]:
        found = np.cross(b - a, c - a)
        # The front of a face is on the side of its normals, also after mirroring.
        assert np.allclose(found / np.linalg.norm(found), placed.attributes["NORMAL"], atol=1e-6)


def test_a_part_in_its_place_stays_as_it_is() -> None:
    part = part_of(vertices(), POLYGONS)
    assert part.placed(np.eye(4)) is part
    mirrored = part.placed(np.diag([-1.0, 1, 1, 1]))
    assert [list(face) for face in mirrored.polygons().as_argument()] == [[face[0], *face[:0:-1]] for face in POLYGONS]


def test_joined_parts() -> None:
    one = part_of(vertices(), POLYGONS, uv=vertices()[:, :2], attributes={"heat": vertices()[:, 0]})
    other = part_of(vertices()[:3], [[0, 1, 2]], uv=vertices()[:3, :2])
    with pytest.warns(tristrip.ConversionWarning, match="only some parts have: heat"):
        part, numbers = arrays.joined([one, other])
    assert [list(face) for face in part.polygons().as_argument()] == [*POLYGONS, [9, 10, 11]]
    assert numbers.tolist() == [0] * 5 + [1]
    assert list(part.attributes) == ["TEXCOORD_0"]
    assert len(part.vertices) == 12
    assert len(arrays.joined([])[0].vertices) == 0
