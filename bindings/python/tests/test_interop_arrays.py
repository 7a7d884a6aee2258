"""What all conversions have in common: which arrays are taken, and what is said if they are wrong or a package is missing."""

from __future__ import annotations

import sys
import warnings
from typing import Any

import numpy as np
import pytest
import tristrip
from hypothesis import given, settings
from hypothesis import strategies as st
from interop_meshes import POLYGONS, fans, vertices
from tristrip.interop import _arrays as arrays
from tristrip.interop._arrays import Faces, part_of


@pytest.mark.parametrize("package", ["trimesh", "pyvista", "open3d", "meshio"])
def test_missing_packages_are_named(package: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    to, of = getattr(tristrip, f"to_{package}"), getattr(tristrip, f"from_{package}")
    for call in (lambda: to(vertices(), POLYGONS), lambda: of(object())):
        with pytest.raises(ImportError, match=f"pip install {package}") as caught:
            call()
        assert caught.value.name == package


def test_importing_imports_no_other_package() -> None:
    import subprocess

    code = "import sys, tristrip; print([name for name in ('trimesh', 'pyvista', 'open3d', 'meshio', 'vtk') if name in sys.modules])"
    assert (
        subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.strip() == "[]"
    )


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
    assert sorted(set(old)) == list(range(10)) and (np.diff(old) >= 0).all()
    assert len({(int(v), float(x)) for v, x in zip(faces.ravel(), values[:, 0], strict=True)}) == len(np.unique(new))
    assert set(np.flatnonzero(corner < 0)) == set(range(len(old))) - set(new)


@pytest.mark.parametrize(
    ("faces", "error", "text"),
    [
        ([[0, 1, 9]], tristrip.MeshError, "vertex 9, expected 0 to 8"),
        ([[0, 1, -1]], tristrip.MeshError, "vertex -1"),
        (np.array([[0, 1, 2**64 - 1]], np.uint64), tristrip.MeshError, "32 bits"),
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
    assert part.vertices.tolist() == small.vertices.tolist() and part.triangles().tolist() == small.faces.tolist()
    assert list(part.attributes) == ["TEXCOORD_0"]


def test_warnings_name_the_line_of_the_caller() -> None:
    meshio = pytest.importorskip("meshio")
    mesh = meshio.Mesh(np.zeros((4, 3)), [("tetra", [[0, 1, 2, 3]]), ("triangle", [[0, 1, 2]])])
    from tristrip.interop._meshio import part_of_meshio

    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        part_of_meshio(mesh)
    assert [(warning.category, warning.filename) for warning in caught] == [(tristrip.ConversionWarning, __file__)]
