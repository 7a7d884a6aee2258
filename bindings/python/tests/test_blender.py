"""The Blender add-on: its functions on arrays, and its operators with the package bpy."""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import tristrip
from interop_meshes import grid

FOLDER = Path(__file__).resolve().parents[1] / "blender"
sys.path.insert(0, str(FOLDER))

import tristrip_blender  # noqa: E402
from tristrip_blender import levels, strips, wheel  # noqa: E402


def grid_of_quads(rows: int) -> tuple[Any, Any]:
    points, triangles = grid(rows)
    half = len(triangles) // 2
    return points, np.column_stack([triangles[:half], triangles[half:, 2]])


# --- functions on arrays


def test_strips_of_triangles_and_quads_and_larger_faces() -> None:
    points, quads = grid_of_quads(4)
    faces = [quads[0, :3].tolist(), quads[0, [0, 2, 3]].tolist(), *quads[1:12].tolist()]
    # A concave pentagon, for which only Blender's triangulation is correct.
    more = np.array([[10, 0, 0], [14, 0, 0], [14, 4, 0], [12, 1, 0], [10, 4, 0]], np.float32)
    faces.append([25, 26, 27, 28, 29])
    cut = [[25, 26, 28], [26, 27, 28], [25, 28, 29]]
    corners = np.concatenate(faces)
    offsets = np.concatenate([[0], np.cumsum([len(face) for face in faces])])
    triangles = np.array([face[:3] for face in faces[:-1]] + [[face[0], *face[2:4]] for face in faces[2:-1]] + cut)
    of_faces = np.array([*range(13), *range(2, 13), 13, 13, 13])
    found = strips.face_strips(np.concatenate([points, more]), corners, offsets, triangles, of_faces)
    assert found.metrics["triangles"] == 2 + 2 * 11 + 3
    assert (found.strip >= 0).all()
    assert found.strip.max() == found.metrics["strips"] - 1
    assert len(set(found.order)) == len(faces)
    assert found.order.min() == 0
    # Consecutive faces in the order belong to one strip, or start another one.
    assert (np.diff(found.strip[np.argsort(found.order)]) >= 0).all()
    assert found.notes == []


def test_equal_faces_get_numbers_of_their_own() -> None:
    points, _ = grid(1)
    faces = np.array([[0, 1, 3], [1, 3, 0], [0, 3, 1]])
    found = strips.face_strips(points, faces.ravel(), np.arange(4) * 3, faces, np.arange(3))
    assert sorted(found.order) == [0, 1, 2]


def test_faces_that_draw_nothing_are_noted() -> None:
    points, _ = grid(1)
    faces = np.array([[0, 1, 3], [1, 1, 0]])
    found = strips.face_strips(points, faces.ravel(), np.arange(3) * 3, faces, np.arange(2))
    assert found.strip.tolist() == [0, -1]
    assert found.order.tolist() == [0, -1]
    assert "1 degenerate face" in found.notes[0]
    assert strips.colours(found.strip)[1].tolist() == [0.5, 0.5, 0.5, 1]


def test_no_faces() -> None:
    empty = np.empty(0, np.int64)
    found = strips.face_strips(np.empty((0, 3)), empty, np.zeros(1, np.int64), empty.reshape(0, 3), empty)
    assert len(found.strip) == 0
    assert strips.sentence(found.metrics) == "No faces to draw"


def corner_mesh(rows: int, **values: Any) -> levels.CornerMesh:
    points, faces = grid(rows)
    corners = np.arange(faces.size).reshape(-1, 3)
    arguments: dict[str, Any] = {"face_class": np.zeros(faces.size, int)} | values
    return levels.CornerMesh(points, corners, faces.ravel(), **arguments)


def test_levels_go_down_and_keep_a_plane() -> None:
    mesh = corner_mesh(20)
    whole = levels.levels_of(mesh)
    assert levels.levels_of(corner_mesh(20)) is whole
    half, few = whole.level(ratio=0.5), whole.level(error=0.001)
    assert whole.level(ratio=1.0).triangles.shape == (800, 3)
    assert 380 <= len(half.triangles) <= 400
    assert len(few.triangles) < 100
    assert few.error < 1e-4
    points = mesh.vertices[mesh.vertex_of_corner[few.triangles]]
    area = np.linalg.norm(np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0]), axis=1).sum() / 2
    assert area == pytest.approx(400)
    both = whole.level(ratio=0.5, error=0.001)
    assert len(both.triangles) == len(half.triangles)


def test_seams_between_classes_and_texture_coordinates_stay() -> None:
    points, faces = grid(10)
    middle = points[faces].mean(axis=1)
    side = np.repeat((middle[:, 0] > 5).astype(int), 3)
    flat = points[faces.ravel(), :2]
    uv = flat / 10 + 2 * side[:, None]
    level = levels.MeshLevels(corner_mesh(10, face_class=side, uv={"map": uv})).level(ratio=0.1)
    chosen = level.triangles
    # All corners of a triangle have the same class, and texture coordinates match positions.
    assert (side[chosen] == side[chosen][:, :1]).all()
    assert np.allclose(uv[chosen], points[faces.ravel()[chosen], :2] / 10 + 2 * side[chosen][..., None])
    x = points[faces.ravel()[chosen]][..., 0]
    assert ((x <= 5).all(axis=1) | (x >= 5).all(axis=1)).all()


def test_a_missing_wheel_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    assert wheel.problem() is None
    wheel.check()
    monkeypatch.setitem(sys.modules, "tristrip", None)
    text = wheel.problem()
    assert text is not None
    assert f'"{sys.executable}" -m pip install ./bindings/python' in text
    with pytest.raises(wheel.MissingWheelError):
        wheel.check()


def test_the_manifest_says_what_the_add_on_says() -> None:
    if sys.version_info < (3, 11):
        pytest.skip("tomllib is new in Python 3.11")
    import tomllib

    manifest = tomllib.loads((FOLDER / "tristrip_blender/blender_manifest.toml").read_text())
    info = tristrip_blender.bl_info
    assert manifest["name"] == info["name"]
    assert manifest["tagline"] == info["description"]
    assert manifest["version"] == ".".join(map(str, info["version"]))
    assert manifest["blender_version_min"] == ".".join(map(str, info["blender"]))
    assert manifest["id"] == "tristrip_blender"
    assert manifest["schema_version"] == "1.0.0"
    assert len(manifest["tagline"]) <= 64
    assert not manifest["tagline"].endswith(".")


def test_only_one_module_imports_blender() -> None:
    importing = set()
    for path in (FOLDER / "tristrip_blender").glob("*.py"):
        for node in ast.parse(path.read_text()).body:
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            if any(name.split(".")[0] in ("bpy", "bmesh", "bpy_extras") for name in names):
                importing.add(path.name)
    assert importing == {"interface.py"}


# --- operators


@pytest.fixture
def bpy() -> Iterator[Any]:
    found = pytest.importorskip(
        "bpy", reason="the package bpy is not installed: it needs CPython 3.11", exc_type=ImportError
    )
    found.ops.wm.read_factory_settings(use_empty=True)
    tristrip_blender.register()
    yield found
    tristrip_blender.unregister()


@pytest.fixture
def monkey(bpy: Any) -> Any:
    """Return an object with materials, texture coordinates, colours, weights and sharp edges."""
    bpy.ops.mesh.primitive_monkey_add()
    made = bpy.context.object
    mesh = made.data
    for name in ("left", "right"):
        mesh.materials.append(bpy.data.materials.new(name))
    for polygon in mesh.polygons:
        polygon.material_index = int(polygon.center.x > 0)
        polygon.use_smooth = True
    group = made.vertex_groups.new(name="side")
    for vertex in mesh.vertices:
        if vertex.co.x > 0:
            group.add([vertex.index], vertex.co.x, "REPLACE")
    colours = mesh.color_attributes.new("paint", "FLOAT_COLOR", "POINT")
    colours.data.foreach_set("color", [x for vertex in mesh.vertices for x in (abs(vertex.co.z) / 2, 0.25, 0.5, 1)])
    heat = mesh.attributes.new("heat", "FLOAT", "POINT")
    heat.data.foreach_set("value", [vertex.co.y for vertex in mesh.vertices])
    sharp = mesh.attributes.new("sharp_edge", "BOOLEAN", "EDGE")
    sharp.data.foreach_set("value", [abs(mesh.vertices[edge.vertices[0]].co.x) < 1e-6 for edge in mesh.edges])
    return made


def loops(mesh: Any) -> dict[tuple[Any, ...], set[tuple[float, ...]]]:
    """Return the texture coordinates and material of each position."""
    found: dict[tuple[Any, ...], set[tuple[float, ...]]] = {}
    layer = mesh.uv_layers["UVMap"].data
    for polygon in mesh.polygons:
        for loop in polygon.loop_indices:
            position = tuple(mesh.vertices[mesh.loops[loop].vertex_index].co)
            found.setdefault((position, polygon.material_index), set()).add(tuple(layer[loop].uv))
    return found


def test_strips_are_stored_as_attributes(bpy: Any, monkey: Any) -> None:
    assert bpy.ops.tristrip.strips() == {"FINISHED"}
    mesh = monkey.data
    order = [item.value for item in mesh.attributes["strip_order"].data]
    strip = [item.value for item in mesh.attributes["strip"].data]
    assert len(set(order)) == len(mesh.polygons) == 500
    assert mesh["tristrip"]["triangles"] == 968
    assert max(strip) == mesh["tristrip"]["strips"] - 1
    assert mesh["tristrip"]["indices_restart"] < 1.3 * 968
    colours = {tuple(item.color_srgb) for item in mesh.attributes["strip_color"].data}
    assert len(colours) > 10
    assert bpy.ops.tristrip.strips(color=False, effort=0) == {"FINISHED"}
    assert not mesh.validate()


def test_simplified_meshes_keep_what_they_have(bpy: Any, monkey: Any) -> None:
    mesh = monkey.data
    known = loops(mesh)
    weights = {tuple(v.co): [(g.group, g.weight) for g in v.groups] for v in mesh.vertices}
    sharp_before = sum(item.value for item in mesh.attributes["sharp_edge"].data)
    bpy.ops.tristrip.strips()
    assert bpy.ops.tristrip.simplify(ratio=0.5) == {"FINISHED"}
    assert not mesh.validate()
    assert 460 <= len(mesh.polygons) <= 484
    assert [material.name for material in mesh.materials] == ["left", "right"]
    # Every corner has texture coordinates and a material that the full mesh has at its position.
    for key, coordinates in loops(mesh).items():
        assert coordinates <= known[key]
    for vertex in mesh.vertices:
        assert [(g.group, g.weight) for g in vertex.groups] == weights[tuple(vertex.co)]
        assert mesh.attributes["heat"].data[vertex.index].value == vertex.co.y
        assert mesh.attributes["paint"].data[vertex.index].color[0] == pytest.approx(abs(vertex.co.z) / 2)
    assert 0 < sum(item.value for item in mesh.attributes["sharp_edge"].data) <= sharp_before
    assert all(polygon.use_smooth for polygon in mesh.polygons)
    assert "strip" not in mesh.attributes
    assert "tristrip" not in mesh
    assert mesh.color_attributes.active_color_name == "paint"


def test_custom_normals_stay(bpy: Any) -> None:
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=10, y_subdivisions=10)
    mesh = bpy.context.object.data
    mesh.normals_split_custom_set([(0.6, 0.0, 0.8)] * len(mesh.loops))
    assert bpy.ops.tristrip.simplify(goal="ERROR", error=0.01) == {"FINISHED"}
    assert len(mesh.polygons) < 60
    assert mesh.has_custom_normals
    for normal in mesh.corner_normals:
        assert tuple(normal.vector) == pytest.approx((0.6, 0, 0.8), abs=1e-3)


def test_shape_keys_are_not_lost(bpy: Any, monkey: Any) -> None:
    monkey.shape_key_add(name="Basis")
    with pytest.raises(RuntimeError, match="shape keys"):
        bpy.ops.tristrip.simplify(ratio=0.5)
    assert len(monkey.data.polygons) == 500


@pytest.mark.usefixtures("monkey")
def test_operators_need_a_mesh_and_the_wheel(bpy: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setitem(sys.modules, "tristrip", None)
    with pytest.raises(RuntimeError, match=r"pip install \./bindings/python"):
        bpy.ops.tristrip.strips()
    with pytest.raises(RuntimeError, match=r"pip install \./bindings/python"):
        bpy.ops.export_scene.tristrip_glb(filepath=str(tmp_path / "a.glb"))
    monkeypatch.undo()
    bpy.ops.object.empty_add()
    with pytest.raises(RuntimeError, match="Select a mesh object"):
        bpy.ops.tristrip.simplify()


def test_a_mesh_without_faces(bpy: Any) -> None:
    made = bpy.data.objects.new("empty", bpy.data.meshes.new("empty"))
    bpy.context.collection.objects.link(made)
    bpy.context.view_layer.objects.active = made
    assert bpy.ops.tristrip.strips() == {"FINISHED"}
    with pytest.raises(RuntimeError, match="no faces"):
        bpy.ops.tristrip.simplify()


def test_the_menu_has_the_export(bpy: Any) -> None:
    from tristrip_blender import interface

    assert interface._menu in bpy.types.TOPBAR_MT_file_export._dyn_ui_initialize()
    assert bpy.types.TRISTRIP_PT_panel.bl_category == "Tristrip"


@pytest.mark.usefixtures("monkey")
@pytest.mark.parametrize("layout", ["degenerate", "restart"])
def test_exported_files_are_drawn_as_strips(bpy: Any, tmp_path: Path, layout: str) -> None:
    plain, stripped = tmp_path / "plain.glb", tmp_path / "strips.glb"
    bpy.ops.export_scene.gltf(filepath=str(plain), export_format="GLB", export_apply=True)
    assert bpy.ops.export_scene.tristrip_glb(filepath=str(stripped), layout_name=layout) == {"FINISHED"}
    tristrip.verify(plain, stripped)
    scene, source = tristrip.load(stripped), tristrip.load(plain)
    assert all(part.strips is not None for part in scene.parts)
    assert [part.material for part in scene.parts] == [part.material for part in source.parts]
    assert [sorted(part.attributes) for part in scene.parts] == [sorted(part.attributes) for part in source.parts]
    if layout == "degenerate":  # Blender does not read the extension for restarts.
        assert bpy.ops.import_scene.gltf(filepath=str(stripped)) == {"FINISHED"}
