"""Conversions from and to trimesh."""

from __future__ import annotations

import numpy as np
import pytest

import tristrip
from interop_meshes import POLYGONS, attributes, expected_attributes, fans, grid, vertices
from tristrip.interop._trimesh import part_of_trimesh

trimesh = pytest.importorskip("trimesh")


def test_faces_keep_their_order() -> None:
    mesh = tristrip.to_trimesh(vertices(), POLYGONS)
    assert mesh.faces.tolist() == fans(POLYGONS)
    assert np.array_equal(mesh.vertices.astype(np.float32), vertices())


def test_strips_become_triangles() -> None:
    points, faces = grid(10)
    strips = tristrip.stripify(faces)
    mesh = tristrip.to_trimesh(points, strips)
    assert mesh.faces.tolist() == strips.triangles().tolist()
    assert mesh.area == pytest.approx(100)
    tristrip.stripify(mesh.faces).verify(faces)


def test_attributes_there_and_back() -> None:
    mesh = tristrip.to_trimesh(vertices(), POLYGONS, **attributes())
    assert mesh.visual.kind == "texture"
    assert np.array_equal(mesh.visual.uv, attributes()["uv"])
    part = part_of_trimesh(mesh)
    assert part.attributes.keys() == expected_attributes().keys()
    for name, values in expected_attributes().items():
        assert np.allclose(part.attributes[name], values, atol=1e-7), name


def test_colours_without_texture_coordinates() -> None:
    given = attributes()["colors"]
    mesh = tristrip.to_trimesh(vertices(), POLYGONS, colors=given)
    assert mesh.visual.kind == "vertex"
    assert np.array_equal(mesh.visual.vertex_colors, given)
    mesh = tristrip.to_trimesh(vertices(), POLYGONS, colors=given[:, :3])
    assert (mesh.visual.vertex_colors[:, 3] == 255).all()


def test_rounded_colours_are_warned_of() -> None:
    with pytest.warns(tristrip.ConversionWarning, match="rounded to 8 bits"):
        mesh = tristrip.to_trimesh(vertices(), POLYGONS, colors=np.full((9, 3), 0.3))
    assert mesh.visual.vertex_colors[0].tolist() == [76, 76, 76, 255]
    tristrip.to_trimesh(vertices(), POLYGONS, colors=np.full((9, 3), 51 / 255))


def test_normals_are_taken_where_they_are() -> None:
    mesh = trimesh.creation.box()
    assert part_of_trimesh(mesh).attributes == {}
    assert np.array_equal(part_of_trimesh(mesh, normals=True).attributes["NORMAL"], mesh.vertex_normals)
    assert "NORMAL" in part_of_trimesh(mesh).attributes
    assert part_of_trimesh(mesh, normals=False).attributes == {}


def test_colours_of_faces_split_vertices() -> None:
    mesh = trimesh.creation.box()
    colours = np.repeat(np.arange(6, dtype=np.uint8) * 40, 2)
    mesh.visual.face_colors = np.column_stack([colours, colours, colours, np.full(12, 255)])
    part = part_of_trimesh(mesh)
    faces = part.triangles()
    assert np.array_equal(part.vertices[faces], mesh.triangles)
    assert np.array_equal(part.attributes["COLOR_0"][faces], np.repeat(mesh.visual.face_colors[:, None], 3, axis=1))
    assert len(part.vertices) < 36
    assert mesh.visual.kind == "face"


def test_attributes_of_faces_are_warned_of() -> None:
    mesh = trimesh.creation.box()
    mesh.face_attributes["group"] = np.arange(12)
    with pytest.warns(tristrip.ConversionWarning, match="face attributes: group"):
        part_of_trimesh(mesh)


def test_a_material_is_kept_with_a_simplified_mesh() -> None:
    points, faces = grid(10)
    material = trimesh.visual.material.PBRMaterial(baseColorFactor=[255, 0, 0, 255])
    small = tristrip.simplify(points, faces, ratio=0.2, uv=points[:, :2] / 10)
    mesh = tristrip.to_trimesh(small, material=material)
    assert mesh.visual.material is material
    assert np.allclose(mesh.visual.uv, mesh.vertices[:, :2] / 10)


def test_other_objects() -> None:
    with pytest.raises(tristrip.ArrayTypeError, match="expected a Trimesh or a Scene"):
        tristrip.from_trimesh(trimesh.PointCloud([[0, 0, 0]]))
