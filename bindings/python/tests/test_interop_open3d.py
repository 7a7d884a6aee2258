"""Conversions from and to Open3D."""

from __future__ import annotations

import numpy as np
import pytest

import tristrip
from interop_meshes import POLYGONS, attributes, expected_attributes, fans, grid, vertices
from tristrip.interop._open3d import parts_of_open3d

open3d = pytest.importorskip("open3d", exc_type=ImportError)


def test_tensor_meshes_keep_all_attributes() -> None:
    given = attributes()
    given["colors"] = given["colors"][:, :3]
    mesh = tristrip.to_open3d(vertices(), POLYGONS, tensor=True, **given)
    assert mesh.triangle.indices.numpy().tolist() == fans(POLYGONS)
    (part,) = parts_of_open3d(mesh)
    used = np.unique(part.triangles())
    for name, values in expected_attributes().items():
        wanted = values[:, :3] if name == "COLOR_0" else values
        # Texture coordinates belong to corners, so vertices without faces have none.
        rows = used if name == "TEXCOORD_0" else slice(None)
        assert np.array_equal(part.attributes[name].reshape(wanted.shape)[rows], wanted[rows]), name


def test_legacy_meshes() -> None:
    given = {key: values for key, values in attributes().items() if key != "attributes"}
    with pytest.warns(tristrip.ConversionWarning, match="opacity dropped"):
        mesh = tristrip.to_open3d(vertices(), POLYGONS, **given)
    assert np.asarray(mesh.triangles).tolist() == fans(POLYGONS)
    (part,) = parts_of_open3d(mesh)
    assert np.allclose(part.vertices, vertices())
    assert np.allclose(part.attributes["NORMAL"], given["normals"])
    assert np.allclose(part.attributes["COLOR_0"] * 255, given["colors"][:, :3])
    with pytest.warns(tristrip.ConversionWarning, match="dropped heat, ids"):
        tristrip.to_open3d(vertices(), POLYGONS, attributes=attributes()["attributes"])


def test_strips_become_triangles() -> None:
    points, faces = grid(10)
    strips = tristrip.stripify(faces)
    mesh = tristrip.to_open3d(points, strips)
    assert np.asarray(mesh.triangles).tolist() == strips.triangles().tolist()
    assert mesh.get_surface_area() == pytest.approx(100)


@pytest.mark.parametrize("tensor", [False, True])
def test_texture_coordinates_of_corners_split_vertices(tensor: bool) -> None:
    box = open3d.geometry.TriangleMesh.create_box(create_uv_map=True)
    coordinates = np.asarray(box.triangle_uvs)
    (part,) = parts_of_open3d(open3d.t.geometry.TriangleMesh.from_legacy(box) if tensor else box)
    faces = part.triangles()
    assert np.array_equal(part.vertices[faces], np.asarray(box.vertices)[np.asarray(box.triangles)])
    assert np.allclose(part.attributes["TEXCOORD_0"][faces.ravel()], coordinates)


def test_a_texture() -> None:
    points, faces = grid(2)
    image = np.arange(48, dtype=np.uint8).reshape(4, 4, 3)
    mesh = tristrip.to_open3d(points, faces, uv=points[:, :2] / 2, image=image)
    assert mesh.has_textures()
    # Open3D stores the bottom row first.
    assert np.array_equal(np.flipud(np.asarray(mesh.textures[0])), image)
    assert np.asarray(mesh.triangle_material_ids).tolist() == [0] * 8


def test_other_objects() -> None:
    with pytest.raises(tristrip.ArrayTypeError, match="expected a TriangleMesh"):
        parts_of_open3d(open3d.geometry.PointCloud())
    assert parts_of_open3d(open3d.geometry.TriangleMesh())[0].vertices.shape == (0, 3)
