"""Scenes with materials, images and nodes, converted to other packages and back."""

from __future__ import annotations

import io
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import tristrip
from interop_meshes import POLYGONS, attributes, expected_attributes, grid, vertices

PIL = pytest.importorskip("PIL.Image")


def picture() -> Any:
    """Return an image in which every pixel has a different colour."""
    return np.arange(8 * 4 * 3, dtype=np.uint8).reshape(8, 4, 3) * 2


def encoded(pixels: Any, kind: str = "PNG", **options: Any) -> bytes:
    file = io.BytesIO()
    PIL.fromarray(pixels).save(file, kind, **options)
    return file.getvalue()


def pixels_of(image: bytes) -> Any:
    return np.asarray(PIL.open(io.BytesIO(image)).convert("RGB"))


def properties_of(part: tristrip.Part) -> Any:
    """Return the properties of the material of a part."""
    assert part.material_properties is not None
    return part.material_properties


def image_of(part: tristrip.Part) -> bytes:
    """Return the image of the material of a part."""
    image: bytes | None = properties_of(part)["base_color_image"]
    assert image is not None
    return image


def polygons_of(part: tristrip.Part) -> list[list[int]]:
    assert part.polygons is not None
    offsets, corners = part.polygons
    return [corners[a:b].tolist() for a, b in pairwise(offsets)]


def textured() -> tristrip.Scene:
    """Return a scene of two parts, one with an image and one with a colour."""
    points, faces = grid(3)
    uv = points[:, :2] / 3
    board = {"name": "board", "base_color_image": encoded(picture()), "roughness": 0.25}
    paint = {"name": "paint", "base_color": (0.5, 0.25, 1.0, 0.5), "metallic": 1.0}
    return tristrip.Scene.from_parts(
        [
            tristrip.Part(points, faces, uv=uv, normals=np.tile([0, 0, 1], (16, 1)), name="board", material=board),
            tristrip.Part(points + np.array([0, 0, 1]), faces[::-1], name="paint", material=paint),
        ]
    )


def assert_same(found: tristrip.Part, wanted: tristrip.Part) -> None:
    """Compare geometry and texture coordinates at face corners, in order."""
    assert np.allclose(found.vertices[found.faces], wanted.vertices[wanted.faces], atol=1e-6)
    if wanted.uv is not None:
        assert found.uv is not None
        assert np.allclose(found.uv[found.faces], wanted.uv[wanted.faces], atol=1e-6)


# --- trimesh


def test_trimesh_keeps_materials_and_images() -> None:
    pytest.importorskip("trimesh")
    scene = textured()
    other = tristrip.to_trimesh(scene)
    assert len(other.geometry) == 2
    back = tristrip.from_trimesh(other)
    for found, wanted in zip(back.parts, scene.parts, strict=True):
        assert_same(found, wanted)
        assert np.array_equal(found.faces, wanted.faces)
        assert found.material == wanted.material
        given, kept = properties_of(wanted), properties_of(found)
        # trimesh stores colours with 8 bits.
        assert kept["base_color"] == pytest.approx(given["base_color"], abs=1 / 255)
        assert (kept["metallic"], kept["roughness"]) == (given["metallic"], given["roughness"])
        assert kept["blend"] == given["blend"]
    assert np.array_equal(pixels_of(image_of(back.parts[0])), picture())
    assert np.allclose(back.parts[0].attributes["NORMAL"], [0, 0, 1])


def test_trimesh_keeps_maps_of_materials_and_jpegs() -> None:
    trimesh = pytest.importorskip("trimesh")
    points, faces = grid(3)
    photo = encoded(np.kron(picture(), np.ones((8, 8, 1), np.uint8)), "JPEG", quality=30)
    material = trimesh.visual.material.PBRMaterial(
        name="all",
        baseColorTexture=PIL.open(io.BytesIO(photo)),
        normalTexture=PIL.fromarray(picture()),
        emissiveFactor=[1, 0.5, 0],
        alphaMode="MASK",
        alphaCutoff=0.25,
        doubleSided=True,
    )
    mesh = tristrip.to_trimesh(points, faces, uv=points[:, :2] / 3, material=material)
    scene = tristrip.from_trimesh(mesh, name="leaf")
    image = image_of(scene.parts[0])
    assert image.startswith(b"\xff\xd8\xff")
    assert len(image) < 1.5 * len(photo)
    assert np.abs(pixels_of(image).astype(int) - pixels_of(photo)).max() <= 4
    assert scene.parts[0].name == "leaf"
    (back,) = tristrip.to_trimesh(scene).geometry.values()
    kept = back.visual.material
    assert (kept.alphaMode, kept.alphaCutoff, kept.doubleSided, kept.name) == ("MASK", 0.25, True, "all")
    assert kept.emissiveFactor.tolist() == [1, 0.5, 0]
    assert np.array_equal(np.asarray(kept.normalTexture), picture())
    assert np.allclose(back.visual.uv, points[:, :2] / 3)
    assert mesh.visual.material.baseColorTexture.format == "JPEG"


def test_transforms_of_trimesh_stay_with_nodes() -> None:
    trimesh = pytest.importorskip("trimesh")
    box = trimesh.creation.box()
    scene = trimesh.Scene()
    places = [trimesh.transformations.translation_matrix([3.0 * i, 0, 0]) for i in range(3)]
    places[2] = places[2] @ np.diag([-1.0, 2, 1, 1])
    scene.add_geometry(box, geom_name="box", node_name="box 0", transform=places[0])
    for number, place in enumerate(places[1:], 1):
        scene.graph.update(frame_to=f"box {number}", matrix=place, geometry="box")
    read = tristrip.from_trimesh(scene)
    assert len(read.parts) == 1
    assert [list(parts) for parts, _ in read.placements] == [[0], [0], [0]]
    assert np.allclose([transform for _, transform in read.placements], places)
    back = tristrip.to_trimesh(read)
    assert np.allclose(back.bounds, scene.bounds)
    assert np.allclose(back.to_mesh().area, scene.to_mesh().area)
    meshio = pytest.importorskip("meshio")
    mesh = tristrip.to_meshio(read)
    assert isinstance(mesh, meshio.Mesh)
    assert np.allclose([mesh.points.min(axis=0), mesh.points.max(axis=0)], scene.bounds)
    # The mirrored box must also have its faces outside.
    corners = mesh.points[mesh.cells[0].data]
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
    assert volume == pytest.approx(1 + 1 + 2)


def test_trimesh_attributes_without_a_material_are_exact() -> None:
    pytest.importorskip("trimesh")
    given = {key: values for key, values in attributes().items() if key != "uv"}
    scene = tristrip.from_trimesh(tristrip.to_trimesh(vertices(), POLYGONS, **given))
    found = scene.parts[0].attributes
    for name, values in expected_attributes().items():
        if name == "TEXCOORD_0":
            continue
        assert found[name].dtype == values.dtype, name
        assert np.allclose(found[name], values, atol=1e-6), name


def test_trimesh_attributes_with_a_material() -> None:
    pytest.importorskip("trimesh")
    given = attributes()
    given["attributes"] |= {"large": np.full(9, 2**30 + 1), "five": np.zeros((9, 5))}
    mesh = tristrip.to_trimesh(vertices(), POLYGONS, **given)
    with pytest.warns(tristrip.ConversionWarning) as caught:
        scene = tristrip.from_trimesh(mesh)
    assert sorted(str(warning.message).split()[1] for warning in caught) == ["five", "large"]
    found = scene.parts[0].attributes
    assert np.array_equal(found["_heat"], given["attributes"]["heat"])
    assert np.array_equal(found["_ids"], given["attributes"]["ids"])
    assert np.array_equal(found["COLOR_0"], given["colors"])
    assert np.allclose(1 - found["TEXCOORD_0"], given["uv"] * [-1, 1] + [1, 0])


def test_several_materials_in_a_mesh_of_trimesh() -> None:
    trimesh = pytest.importorskip("trimesh")
    box = trimesh.creation.box()
    of_faces = np.repeat([0, 1], 6)
    materials = [trimesh.visual.material.PBRMaterial(name=name) for name in ("a", "b")]
    box.visual = trimesh.visual.TextureVisuals(
        uv=np.zeros((8, 2)),
        material=trimesh.visual.material.MultiMaterial(materials=materials),
        face_materials=of_faces,
    )
    scene = tristrip.from_trimesh(box)
    assert [part.material for part in scene.parts] == ["a", "b"]
    assert sum(len(part.faces) for part in scene.parts) == 12


def test_paths_are_warned_of() -> None:
    trimesh = pytest.importorskip("trimesh")
    scene = trimesh.Scene([trimesh.creation.box(), trimesh.PointCloud(np.zeros((3, 3)))])
    with pytest.warns(tristrip.ConversionWarning, match="dropped 1 paths or point clouds"):
        read = tristrip.from_trimesh(scene)
    assert len(read.parts) == 1
    assert len(scene.geometry) == 2


def test_what_trimesh_does_not_read_is_warned_of() -> None:
    pytest.importorskip("trimesh")
    points, faces = grid(1)
    scene = tristrip.Scene.from_arrays(points, faces, uv=points[:, :2], attributes={"TEXCOORD_1": points[:, :2]})
    with pytest.warns(tristrip.ConversionWarning, match="trimesh does not read TEXCOORD_1"):
        tristrip.to_trimesh(scene)


@pytest.mark.parametrize("name", ["milktruck.glb", "textured/Duck.glb"])
def test_models_by_way_of_trimesh(name: str, model: Callable[[str], Path]) -> None:
    pytest.importorskip("trimesh")
    scene = tristrip.load(model(name))
    back = tristrip.from_trimesh(tristrip.to_trimesh(scene))
    for found, wanted in zip(back.parts, scene.parts, strict=True):
        assert np.array_equal(found.faces, wanted.faces)
        assert_same(found, wanted)
        assert np.allclose(found.attributes["NORMAL"], wanted.attributes["NORMAL"], atol=1e-6)
    # The nodes are in a different order.
    places = [
        sorted((part, place.round(5).tolist()) for parts, place in one.placements for part in parts)
        for one in (back, scene)
    ]
    assert places[0] == places[1]
    assert back.strip().metrics()["indices_restart"] == scene.strip().metrics()["indices_restart"]


# --- PyVista


def test_pyvista_has_a_block_per_part() -> None:
    pyvista = pytest.importorskip("pyvista")
    scene = textured()
    blocks = tristrip.to_pyvista(scene)
    assert blocks.keys() == ["board", "paint"]
    back = tristrip.from_pyvista(blocks)
    for found, wanted in zip(back.parts, scene.parts, strict=True):
        assert_same(found, wanted)
        assert found.name == wanted.name
    stripped = scene.strip()
    for block, strips in zip(tristrip.to_pyvista(stripped), stripped.parts, strict=True):
        assert isinstance(block, pyvista.PolyData)
        assert block.n_strips == len(strips)
    small = scene.simplify(ratio=0.1)
    assert sum(block.n_cells for block in tristrip.to_pyvista(small)) < 36


def test_pyvista_keeps_polygons_in_scenes() -> None:
    pytest.importorskip("pyvista")
    scene = tristrip.from_pyvista(tristrip.to_pyvista(vertices(), POLYGONS, **attributes()), name="mixed")
    (part,) = scene.parts
    assert polygons_of(part) == POLYGONS
    assert part.name == "mixed"
    assert np.array_equal(part.attributes["ids"], attributes()["attributes"]["ids"])


# --- meshio


def test_meshio_joins_parts() -> None:
    pytest.importorskip("meshio")
    scene = textured()
    with pytest.warns(tristrip.ConversionWarning, match="only some parts have: NORMAL, TEXCOORD_0"):
        mesh = tristrip.to_meshio(scene)
    assert mesh.cell_data["part"][0].tolist() == [0] * 18 + [1] * 18
    (part,) = tristrip.from_meshio(mesh).parts
    wanted = np.concatenate([one.vertices[one.faces] for one in scene.parts])
    assert np.allclose(part.vertices[part.faces], wanted)


def test_meshio_keeps_polygons_in_scenes() -> None:
    pytest.importorskip("meshio")
    (part,) = tristrip.from_meshio(tristrip.to_meshio(vertices(), POLYGONS, **attributes())).parts
    assert polygons_of(part) == POLYGONS
    for name, values in expected_attributes().items():
        assert np.allclose(part.attributes[name], values, atol=1e-6), name


# --- Open3D


def test_open3d_has_a_texture_per_material() -> None:
    pytest.importorskip("open3d", exc_type=ImportError)
    scene = textured()
    with pytest.warns(tristrip.ConversionWarning):
        mesh = tristrip.to_open3d(scene)
    assert len(mesh.textures) == 2
    back = tristrip.from_open3d(mesh)
    for found, wanted in zip(back.parts, scene.parts, strict=True):
        assert_same(found, wanted)
    images = [pixels_of(image_of(part)) for part in back.parts]
    assert np.array_equal(images[0], picture())
    # The colour of the other material, encoded as sRGB.
    assert images[1].tolist() == [[[188, 137, 255]]]


def test_tensor_meshes_of_open3d_have_the_material() -> None:
    pytest.importorskip("open3d", exc_type=ImportError)
    board = textured().parts[0]
    back = tristrip.from_open3d(tristrip.to_open3d(board, tensor=True), name="board")
    (part,) = back.parts
    assert_same(part, board)
    assert properties_of(part)["roughness"] == 0.25
    assert np.array_equal(pixels_of(image_of(part)), picture())
    with pytest.warns(tristrip.ConversionWarning) as caught:
        tristrip.to_open3d(textured(), tensor=True)
    said = [str(warning.message) for warning in caught]
    assert any("dropped 2 materials" in text for text in said)
    assert any("only some parts have: NORMAL" in text for text in said)
