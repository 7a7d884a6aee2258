"""Conversions from and to meshio, also through files that it writes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import tristrip
from interop_meshes import POLYGONS, attributes, expected_attributes, grid, vertices
from tristrip.interop._meshio import part_of_meshio

meshio = pytest.importorskip("meshio")


def test_polygons_and_attributes_there_and_back() -> None:
    mesh = tristrip.to_meshio(vertices(), POLYGONS, **attributes())
    assert {block.type: len(block) for block in mesh.cells} == {"triangle": 2, "quad": 2, "polygon": 1}
    part = part_of_meshio(mesh)
    assert [list(face) for face in part.polygons().as_argument()] == POLYGONS
    assert part.attributes.keys() == expected_attributes().keys()
    for name, values in expected_attributes().items():
        assert part.attributes[name].dtype == values.dtype, name
        assert np.array_equal(part.attributes[name], values), name


def test_strips_become_triangles() -> None:
    points, faces = grid(10)
    strips = tristrip.stripify(faces)
    (block,) = tristrip.to_meshio(points, strips).cells
    assert block.type == "triangle"
    assert block.data.tolist() == strips.triangles().tolist()


@pytest.mark.filterwarnings("ignore:dropped cell data", "ignore:overflow")  # groups of OBJ, normals and sizes of STL
@pytest.mark.parametrize("name", ["a.vtu", "a.vtk", "a.obj", "a.off", "a.stl", "a.ply", "a.xdmf"])
def test_files_of_meshio(name: str, tmp_path: Path) -> None:
    if name.endswith("xdmf"):
        pytest.importorskip("h5py")
    points, faces = grid(4)
    tristrip.to_meshio(points, faces).write(tmp_path / name)
    part = part_of_meshio(meshio.read(tmp_path / name))
    assert np.allclose(part.vertices[part.triangles()], points[faces])


def test_names_of_ply() -> None:
    columns = {name: np.arange(9, dtype=np.float32) / 9 for name in ("nx", "ny", "nz", "s", "t")}
    columns |= {name: np.arange(9, dtype=np.uint8) for name in ("red", "green", "blue")}
    part = part_of_meshio(meshio.Mesh(vertices(), [("triangle", [[0, 1, 2]])], point_data=columns))
    assert {name: values.shape for name, values in part.attributes.items()} == {
        "NORMAL": (9, 3),
        "TEXCOORD_0": (9, 2),
        "COLOR_0": (9, 3),
    }


def test_what_is_left_out_is_warned_of() -> None:
    cells = [
        ("line", [[0, 1]]),
        ("triangle6", [[0, 1, 2, 3, 4, 5]]),
        ("tetra", [[0, 1, 2, 3]]),
        ("quad9", [list(range(9))]),
    ]
    mesh = meshio.Mesh(vertices(), cells, cell_data={"group": [[1], [2], [3], [4]]})
    with pytest.warns(tristrip.ConversionWarning) as caught:
        part = part_of_meshio(mesh)
    assert [list(face) for face in part.polygons().as_argument()] == [[0, 1, 2], [0, 1, 2, 3]]
    text = str(caught[0].message)
    for what in (
        "1 cells of type line",
        "nodes on edges of 1 cells of type triangle6",
        "1 cells of type tetra",
        "cell data group",
    ):
        assert what in text


def test_points_in_a_plane_and_wrong_meshes() -> None:
    part = part_of_meshio(meshio.Mesh([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], [("triangle", [[0, 1, 2]])]))
    assert part.vertices.shape == (3, 3)
    with pytest.raises(tristrip.MeshError, match="found vertex 3, expected 0 to 2"):
        part_of_meshio(meshio.Mesh(np.zeros((3, 3)), [("triangle", [[0, 1, 3]])]))
    with pytest.raises(tristrip.ArrayTypeError, match="expected a Mesh of meshio"):
        part_of_meshio(3)
