"""Conversions from and to PyVista, and plots of strips."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import tristrip
from interop_meshes import POLYGONS, attributes, expected_attributes, grid, vertices
from tristrip.interop._pyvista import parts_of_pyvista, strip_colours

pyvista = pytest.importorskip("pyvista")


def polygons_of(mesh: object) -> list[list[int]]:
    (part,) = parts_of_pyvista(mesh)
    return [[int(corner) for corner in face] for face in part.polygons().as_argument()]


def test_polygons_stay_polygons() -> None:
    mesh = tristrip.to_pyvista(vertices(), POLYGONS)
    assert [face.tolist() for face in mesh.irregular_faces] == POLYGONS
    assert polygons_of(mesh) == POLYGONS


def test_attributes_there_and_back() -> None:
    mesh = tristrip.to_pyvista(vertices(), POLYGONS, **attributes())
    assert np.array_equal(mesh.active_texture_coordinates, attributes()["uv"])
    assert np.array_equal(mesh.point_data.active_normals, attributes()["normals"])
    (part,) = parts_of_pyvista(mesh)
    assert part.attributes.keys() == expected_attributes().keys()
    for name, values in expected_attributes().items():
        assert part.attributes[name].dtype == values.dtype, name
        assert np.array_equal(part.attributes[name], values), name


def test_meshes_share_no_memory() -> None:
    points = vertices()
    mesh = tristrip.to_pyvista(points, POLYGONS)
    mesh.points[:] = 0
    assert np.array_equal(points, vertices())


def test_strips_are_rows() -> None:
    points, faces = grid(20)
    strips = tristrip.stripify(faces)
    mesh = tristrip.to_pyvista(points, strips)
    assert mesh.n_strips == len(strips) == mesh.n_cells
    rows = np.concatenate([np.concatenate([[len(strip)], strip]) for strip in strips])
    assert np.array_equal(mesh.strips, rows)
    assert mesh.area == pytest.approx(400)
    found = tristrip.strips_from_pyvista(mesh)
    assert [strip.tolist() for strip in found] == [strip.tolist() for strip in strips]
    found.verify(faces)


def test_strips_of_vtk_are_read_and_prove() -> None:
    points, faces = grid(20)
    mesh = tristrip.to_pyvista(points, faces).strip()
    tristrip.strips_from_pyvista(mesh).verify(faces)
    (part,) = parts_of_pyvista(mesh)
    tristrip.stripify(part.triangles()).verify(faces)


def test_polygons_and_strips_in_one_mesh() -> None:
    mesh = pyvista.PolyData(vertices(), faces=[3, 0, 1, 2], strips=[4, 3, 4, 5, 6])
    assert polygons_of(mesh) == [[0, 1, 2], [3, 4, 5], [5, 4, 6]]


def test_no_strips() -> None:
    assert len(tristrip.strips_from_pyvista(pyvista.Sphere())) == 0
    assert tristrip.to_pyvista(vertices(), []).n_cells == 0


def test_what_is_left_out_is_warned_of() -> None:
    mesh = pyvista.PolyData(vertices(), faces=[3, 0, 1, 2], lines=[2, 0, 1])
    mesh.cell_data["group"] = [1, 2]
    mesh.point_data["words"] = ["x"] * 9
    mesh.point_data["wide"] = np.full(9, 2**40)
    with pytest.warns(tristrip.ConversionWarning) as caught:
        (part,) = parts_of_pyvista(mesh)
    assert len(caught) == 1
    text = str(caught[0].message)
    assert all(what in text for what in ("1 lines", "cell data: group", "words", "wide of int64"))
    assert part.attributes == {}


def test_other_datasets_give_their_surface() -> None:
    (part,) = parts_of_pyvista(pyvista.ImageData(dimensions=(3, 3, 3)))
    assert len(part.faces) == 24
    assert (part.polygons().sizes == 4).all()
    blocks = pyvista.MultiBlock({"a": pyvista.Sphere(), "b": pyvista.Plane(), "none": None})
    assert [part.name for part in parts_of_pyvista(blocks)] == ["a", "b"]
    with pytest.raises(tristrip.ArrayTypeError, match="expected a PolyData"):
        parts_of_pyvista(3)


def test_indices_out_of_range_are_errors() -> None:
    mesh = pyvista.PolyData(vertices(), strips=[3, 0, 1, 9])
    with pytest.raises(tristrip.MeshError, match="strips: found vertex 9, expected 0 to 8"):
        tristrip.strips_from_pyvista(mesh)


def test_colours_of_strips_differ() -> None:
    colours = strip_colours(2000).astype(int)
    assert (np.abs(np.diff(colours, axis=0)).max(axis=1) > 60).all()
    assert len(np.unique(colours, axis=0)) > 1900


def test_a_picture_has_the_colour_of_each_strip(tmp_path: Path) -> None:
    points, faces = grid(6)
    strips = tristrip.stripify(faces, method="input")
    plotter = tristrip.plot_strips(points, strips, off_screen=True, window_size=(300, 300), lighting=False)
    plotter.view_xy()
    plotter.disable_anti_aliasing()
    picture = plotter.screenshot(tmp_path / "strips.png", return_img=True)
    plotter.close()
    assert (tmp_path / "strips.png").stat().st_size > 500
    found = {tuple(colour) for colour in np.unique(picture.reshape(-1, 3), axis=0).tolist()}
    wanted = {tuple(colour) for colour in strip_colours(len(strips)).tolist()}
    assert len(strips) > 1
    assert wanted <= found
    assert (255, 255, 255) in found
    # Each strip covers its part of the image; pixels per triangle are similar.
    share = {colour: (picture == colour).all(axis=2).sum() for colour in wanted}
    triangles = [len(strip) - 2 for strip in strips]
    per_triangle = [
        share[tuple(colour)] / n for colour, n in zip(strip_colours(len(strips)).tolist(), triangles, strict=True)
    ]
    assert max(per_triangle) < 1.3 * min(per_triangle)


def test_plots_of_wrong_arguments() -> None:
    with pytest.raises(tristrip.MeshError, match="found none"):
        tristrip.plot_strips(vertices(), tristrip.stripify([]))
    with pytest.raises(tristrip.ArrayTypeError, match="expected Strips"):
        tristrip.plot_strips(vertices(), [[0, 1, 2]])  # type: ignore[arg-type] # pyright: ignore[reportArgumentType]
