"""Scenes: reading, arrays, parts, materials, files identical to the command's, pickles."""

from __future__ import annotations

import errno
import json
import os
import pickle
import struct
import subprocess
import sys
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import tristrip

REPOSITORY = Path(__file__).resolve().parents[3]
SMALL = REPOSITORY / "testdata" / "models"
MODELS = Path(os.environ.get("TRISTRIP_MODELS", REPOSITORY.parent / "shared" / "models"))
SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=np.float64)
HALVES = [[0, 1, 2], [0, 2, 3]]


def model(name: str) -> Path:
    for folder in (SMALL, MODELS):
        if (folder / name).is_file():
            return folder / name
    raise pytest.skip.Exception(f"no model {name}")


def png(red: int, green: int, blue: int) -> bytes:
    """An image of 2 × 2 pixels."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = (b"\0" + bytes((red, green, blue)) * 2) * 2
    header = struct.pack(">IIBBBBB", 2, 2, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def textured() -> tristrip.Scene:
    material = {"name": "wood", "base_color": (1, 0.5, 0.25), "base_color_image": png(200, 100, 0), "metallic": 0.5}
    uv = np.array([[0, 0], [1, 0], [1, 0.25], [0, 1]])
    colors = np.array([[255, 0, 0, 255]] * 4, dtype=np.uint8)
    normals = [[0, 0, 1]] * 4
    return tristrip.Scene.from_arrays(
        SQUARE, HALVES, normals=normals, uv=uv, colors=colors, name="square", material=material
    )


def command(*arguments: str | Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "tristrip", *map(str, arguments), "--quiet"],
        env={**os.environ, "PYTHONPATH": str(Path(tristrip.__file__).parents[1])},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr


def test_a_file_is_read_with_its_parts() -> None:
    scene = tristrip.load(model("milktruck.glb"))
    assert scene.format == "glb"
    assert [part.material for part in scene.parts] == ["truck", "glass", "window_trim", "wheels"]
    truck = scene.parts[0]
    assert truck.name == "Cesium_Milk_Truck"
    assert truck.vertices.shape == (1856, 3) and truck.vertices.dtype == np.float32
    assert truck.faces.shape == (1744, 3) and truck.faces.dtype == np.uint32
    assert truck.polygons is None and truck.strips is None and truck.uv_origin == "top"
    assert set(truck.attributes) == {"NORMAL", "TEXCOORD_0"}
    assert truck.uv is not None
    assert np.array_equal(truck.uv[:, 1], 1 - truck.attributes["TEXCOORD_0"][:, 1])


def test_arrays_become_a_scene_with_its_attributes() -> None:
    weights = np.arange(4, dtype=np.uint16)
    part = tristrip.Part(
        SQUARE,
        [[0, 1, 2, 3]],
        colors=np.full((4, 3), 0.5),
        attributes={"quality": weights, "_TEMPERATURE": np.arange(8.0).reshape(4, 2)},
    )
    assert part.attributes["quality"].dtype == np.uint16 and part.attributes["quality"].shape == (4,)
    assert part.attributes["_TEMPERATURE"].dtype == np.float64
    assert part.colors is not None and part.colors.dtype == np.float32
    offsets, corners = part.polygons or pytest.fail("no polygon")
    assert offsets.tolist() == [0, 4] and corners.tolist() == [0, 1, 2, 3]
    assert part.faces.tolist() == HALVES
    scene = tristrip.Scene.from_parts([part, part])
    assert repr(scene) == "Scene(2 parts, 2 faces, 8 vertices)"
    written = tristrip.Scene.from_bytes(scene.to_bytes("ply"))
    assert [len(part.faces) for part in written.parts] == [4]


def test_textures_go_through_a_glb() -> None:
    scene = textured()
    found = tristrip.Scene.from_bytes(scene.to_bytes("glb")).parts[0]
    before = scene.parts[0]
    assert (found.name, found.material) == ("square", "wood")
    assert found.material_properties == before.material_properties
    assert found.material_properties is not None
    assert found.material_properties["base_color"] == (1.0, 0.5, 0.25, 1.0)
    assert found.material_properties["base_color_image"] == png(200, 100, 0)
    assert (found.material_properties["metallic"], found.material_properties["roughness"]) == (0.5, 1.0)
    assert found.uv is not None and before.uv is not None
    assert np.array_equal(found.uv, before.uv) and found.uv_origin == "top"
    assert np.array_equal(found.attributes["TEXCOORD_0"][:, 1], 1 - before.uv[:, 1])
    assert found.normalized == ["COLOR_0"] and found.colors is not None and found.colors.dtype == np.uint8


def test_texture_coordinates_from_the_top_are_kept() -> None:
    uv = np.array([[0, 0.1], [1, 0.3], [1, 0.7], [0, 0.9]], dtype=np.float32)
    scene = tristrip.Scene.from_arrays(SQUARE, HALVES, uv=uv, uv_origin="top")
    found = tristrip.Scene.from_bytes(scene.to_bytes("glb")).parts[0]
    assert np.array_equal(found.attributes["TEXCOORD_0"], uv)
    integers = np.array([[0, 0], [255, 0], [255, 200], [0, 255]], dtype=np.uint8)
    scene = tristrip.Scene.from_arrays(SQUARE, HALVES, uv=integers)
    found = tristrip.Scene.from_bytes(scene.to_bytes("glb")).parts[0]
    assert found.uv is not None and np.array_equal(found.uv, integers)
    # Parts with different directions of v become one scene.
    both = tristrip.Scene.from_parts([found, tristrip.Part(SQUARE, HALVES, uv=integers)])
    first, second = both.parts
    assert (first.uv_origin, second.uv_origin) == ("top", "top")
    assert first.uv is not None and second.uv is not None
    assert np.array_equal(first.uv, second.uv)


def test_an_obj_gets_its_materials(tmp_path: Path) -> None:
    report = textured().save(tmp_path / "a.obj")
    names = sorted(Path(file).name for file in report["beside"])
    assert names == ["a.mtl", "a_0.png"]
    found = tristrip.load(tmp_path / "a.obj").parts[0]
    assert found.material_properties == textured().parts[0].material_properties
    assert found.uv_origin == "bottom" and found.uv is not None
    assert found.uv.tolist() == [[0, 0], [1, 0], [1, 0.25], [0, 1]]
    # The scene does not depend on its files.
    scene = tristrip.load(tmp_path / "a.obj")
    for file in report["beside"]:
        Path(file).unlink()
    assert tristrip.Scene.from_bytes(scene.to_bytes()).parts[0].material_properties == found.material_properties


def test_materials_have_distinct_names() -> None:
    red, dark = {"base_color": (1, 0, 0)}, {"base_color": (0.5, 0, 0, 0.5)}
    parts = [tristrip.Part(SQUARE, HALVES, material=material) for material in (red, dark, red, "known", None)]
    scene = tristrip.Scene.from_parts(parts)
    assert [part.material for part in scene.parts] == ["material_0", "material_1", "material_0", "known", None]
    properties = [part.material_properties for part in scene.parts]
    assert properties[1] is not None and properties[1]["blend"] and properties[3:] == [None, None]
    same = [tristrip.Part(SQUARE, HALVES, material={"name": "a", **one}) for one in (red, dark)]
    with pytest.raises(tristrip.ParameterError, match="another one named"):
        tristrip.Scene.from_parts(same)
    without_uv = tristrip.Scene.from_arrays(SQUARE, HALVES, material={"base_color_image": png(1, 2, 3)})
    assert "image of its material is not shown" in without_uv.notes[0]


@pytest.mark.parametrize(
    ("material", "error"),
    [
        (3, tristrip.ArrayTypeError),
        ({"colour": 1}, tristrip.ParameterError),
        ({"base_color": (2, 0, 0)}, tristrip.ParameterError),
        ({"base_color": 5}, tristrip.ParameterError),
        ({"base_color": (float("nan"), 0, 0)}, tristrip.ParameterError),
        ({"base_color": (0, 0, 0, 0, 0)}, tristrip.ParameterError),
        ({"metallic": -1}, tristrip.ParameterError),
        ({"base_color_image": b"GIF89a"}, tristrip.ParameterError),
        ({"base_color_image": "a.png"}, tristrip.ArrayTypeError),
    ],
)
def test_wrong_materials_are_refused(material: object, error: type[Exception]) -> None:
    with pytest.raises(error, match="material"):
        tristrip.Part(SQUARE, HALVES, material=material)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("arguments", "error"),
    [
        ({"vertices": [[0, 0, float("nan")]] * 3, "faces": [[0, 1, 2]]}, tristrip.MeshError),
        ({"vertices": SQUARE, "faces": [[0, 1, 4]]}, tristrip.MeshError),
        ({"vertices": SQUARE, "faces": [[0, 1, -1]]}, tristrip.MeshError),
        ({"vertices": SQUARE[:, :2], "faces": HALVES}, tristrip.MeshError),
        ({"vertices": SQUARE, "faces": HALVES, "normals": [[0, 0, 1]]}, tristrip.MeshError),
        ({"vertices": SQUARE, "faces": HALVES, "uv": [[0, 0, 1]] * 4}, tristrip.MeshError),
        ({"vertices": SQUARE, "faces": HALVES, "uv": [["a", "b"]] * 4}, tristrip.ArrayTypeError),
        ({"vertices": SQUARE, "faces": HALVES, "colors": [[255, 0, 0]] * 4}, tristrip.ArrayTypeError),
        ({"vertices": SQUARE, "faces": HALVES, "attributes": {"POSITION": SQUARE}}, tristrip.ParameterError),
        ({"vertices": SQUARE, "faces": HALVES, "uv_origin": "left"}, tristrip.ParameterError),
        ({"vertices": SQUARE, "faces": HALVES, "normalized": ["COLOR_0"]}, tristrip.ParameterError),
        ({"vertices": SQUARE, "faces": HALVES, "attributes": {"a": np.zeros((4, 300))}}, tristrip.MeshError),
    ],
)
def test_wrong_arrays_are_refused(arguments: dict[str, object], error: type[Exception]) -> None:
    with pytest.raises(error):
        tristrip.Scene.from_arrays(**arguments)  # type: ignore[arg-type]


def test_empty_scenes_are_scenes() -> None:
    for scene in (tristrip.Scene.from_parts([]), tristrip.Scene.from_arrays(np.zeros((0, 3)), np.zeros((0, 3), int))):
        stripped = scene.strip()
        assert stripped.metrics()["triangles"] == 0 and stripped.proven
        assert scene.simplify(ratio=0.5).report["triangles_after"] == 0
        assert scene.picture(8, 8).startswith(b"\x89PNG")
        assert pickle.loads(pickle.dumps(scene)).to_bytes() == scene.to_bytes()


def test_strips_are_saved_as_the_command_does(tmp_path: Path) -> None:
    for name, extension, flags, options in [
        ("milktruck.glb", "glb", (), {}),
        ("milktruck.glb", "gltf", ("--layout", "restart"), {"layout": "restart"}),
        ("milktruck.glb", "obj", (), {}),
        ("milktruck_meshopt.glb", "glb", ("--reorder-vertices",), {"reorder_vertices": True}),
        ("catmark_bishop.ply", "ply", (), {}),
        ("wingnut.ply", "glb", (), {}),
    ]:
        mine, theirs = tmp_path / "mine" / f"a.{extension}", tmp_path / "theirs" / f"a.{extension}"
        for file in (mine, theirs):
            file.parent.mkdir(exist_ok=True)
        source = model(name)
        report = tristrip.load(source).strip().save(mine, **options)  # type: ignore[arg-type]
        command("strip", source, "-o", theirs, *flags)
        for file in theirs.parent.iterdir():
            assert (mine.parent / file.name).read_bytes() == file.read_bytes(), file.name
        assert report["proven"] and report["output"] == str(mine)
        assert tristrip.verify(source, mine)["proven"]


def test_other_results_are_saved_as_the_command_does(tmp_path: Path) -> None:
    mine, theirs = tmp_path / "mine", tmp_path / "theirs"
    for folder in (mine, theirs):
        folder.mkdir()
    for name, extension in [
        ("milktruck.glb", "glb"),
        ("milktruck.glb", "ply"),
        ("milktruck.glb", "obj"),
        ("hand.ply", "ply"),
    ]:
        source = model(name)
        scene = tristrip.load(source)
        scene.simplify(ratio=0.3).save(mine / f"s.{extension}")
        command("simplify", source, "--ratio", "0.3", "-o", theirs / f"s.{extension}")
        scene.save(mine / f"c.{extension}")
        command("convert", source, "-o", theirs / f"c.{extension}")
        for file in theirs.iterdir():
            assert (mine / file.name).read_bytes() == file.read_bytes(), (name, file.name)
    source = model("milktruck.glb")
    chain = tristrip.load(source).chain("100%,50%")
    assert chain.report["proven"] is True
    # An unverified result is not disproven either.
    assert tristrip.load(source).chain("100%,50%", verify=False).report["proven"] is None
    chain.save(mine / "lod.glb")
    chain.save(f"{mine}/levels/", format="ply")
    command("chain", source, "--ratios", "100%,50%", "-o", theirs / "lod.glb")
    command("chain", source, "--ratios", "100%,50%", "-o", f"{theirs}/levels/", "--to", "ply")
    tristrip.load(source).chain([1, 0.5], layout="list").save(mine / "list.glb")
    command("chain", source, "--ratios", "100%,50%", "--layout", "list", "-o", theirs / "list.glb")
    for one in ["lod.glb", "list.glb", "levels/milktruck_0.ply", "levels/milktruck_1.ply"]:
        assert (mine / one).read_bytes() == (theirs / one).read_bytes(), one


def test_images_beside_a_gltf_go_into_a_glb(tmp_path: Path) -> None:
    scene = textured()
    report = scene.save(tmp_path / "a.gltf")
    assert (tmp_path / "a.bin").is_file() and report["bytes"] > 0
    # The image goes to a separate file.
    document = json.loads((tmp_path / "a.gltf").read_text())
    (tmp_path / "image.png").write_bytes(png(200, 100, 0))
    document["images"] = [{"uri": "image.png"}]
    (tmp_path / "b.gltf").write_text(json.dumps(document))
    outside = tristrip.load(tmp_path / "b.gltf")
    assert outside.parts[0].material_properties == scene.parts[0].material_properties
    assert any("images" in note for note in outside.notes)
    (tmp_path / "out").mkdir()
    outside.strip().save(tmp_path / "out" / "b.glb")
    assert tristrip.load(tmp_path / "out" / "b.glb").parts[0].material_properties == scene.parts[0].material_properties
    # In the same directory, it remains a file.
    outside.strip().save(tmp_path / "c.gltf")
    assert json.loads((tmp_path / "c.gltf").read_text())["images"] == [{"uri": "image.png"}]
    outside.simplify(ratio=1).save(tmp_path / "d.gltf")
    assert json.loads((tmp_path / "d.gltf").read_text())["images"] == [{"uri": "image.png"}]
    again = pickle.loads(pickle.dumps(outside))
    assert again.parts[0].material_properties == scene.parts[0].material_properties


def test_everything_is_pickled() -> None:
    for scene in (tristrip.load(model("milktruck.glb")), tristrip.load(model("catmark_bishop.ply")), textured()):
        again = pickle.loads(pickle.dumps(scene))
        assert repr(again) == repr(scene) and again.notes == scene.notes and again.format == scene.format
        assert again.to_bytes("glb") == scene.to_bytes("glb") and again.to_bytes("ply") == scene.to_bytes("ply")
        part = pickle.loads(pickle.dumps(scene.parts[0]))
        assert np.array_equal(part.vertices, scene.parts[0].vertices)
        assert part.material_properties == scene.parts[0].material_properties
        stripped = scene.strip(method="sgi")
        restored = pickle.loads(pickle.dumps(stripped))
        assert repr(restored) == repr(stripped) and restored.metrics() == stripped.metrics()
        assert restored.to_bytes() == stripped.to_bytes() and restored.parts == stripped.parts
        small = scene.simplify(ratio=0.5)
        restored = pickle.loads(pickle.dumps(small))
        assert restored.report == small.report and restored.to_bytes() == small.to_bytes()
        chain = scene.chain([1, 0.5])
        restored = pickle.loads(pickle.dumps(chain))
        assert restored.levels == chain.levels and restored.to_bytes() == chain.to_bytes()


def test_attributes_of_all_types_are_pickled() -> None:
    attributes = {
        dtype: np.arange(8, dtype=dtype).reshape(4, 2)
        for dtype in ("float32", "float64", "uint8", "int8", "uint16", "int16", "uint32", "int32")
    }
    scene = tristrip.Scene.from_arrays(SQUARE, [[0, 1, 2, 3]], attributes=attributes, normalized=["int8", "uint16"])
    part = pickle.loads(pickle.dumps(scene)).parts[0]
    assert sorted(part.normalized) == ["int8", "uint16"]
    for dtype, values in attributes.items():
        assert part.attributes[dtype].dtype == values.dtype and np.array_equal(part.attributes[dtype], values)


def test_strips_of_a_file_are_returned(tmp_path: Path) -> None:
    scene = tristrip.load(model("milktruck.glb"))
    stripped = scene.strip(method="sequential")
    stripped.save(tmp_path / "s.glb", layout="restart")
    again = tristrip.load(tmp_path / "s.glb")
    strips = [part.strips for part in again.parts]
    assert [len(found) if found is not None else 0 for found in strips] == [len(found) for found in stripped.parts]
    assert again.analyze()["drawn"] == "strips"
    # Strips remain strips.
    again.save(tmp_path / "t.glb", layout="restart")
    assert tristrip.load(tmp_path / "t.glb").parts[0].strips is not None


def test_options_of_scenes_are_checked() -> None:
    scene = textured()
    wrong = [
        lambda: scene.strip(method="none"),
        lambda: scene.strip(colour=1),
        lambda: scene.strip(effort=10),
        lambda: scene.strip(on_interrupt="x"),  # type: ignore[arg-type]
        lambda: scene.simplify(ratio=2),
        lambda: scene.simplify(ratio=0.5, triangles=1),
        lambda: scene.simplify(error=-1),
        lambda: scene.simplify(normals="x"),  # type: ignore[arg-type]
        lambda: scene.simplify(price="x"),  # type: ignore[arg-type]
        lambda: scene.simplify(weight="x=1"),
        lambda: scene.chain([0.5, 1]),
        lambda: scene.chain([]),
        lambda: scene.chain("a"),
        lambda: scene.chain([1], layout="x"),  # type: ignore[arg-type]
        lambda: scene.compare(effort=10),
        lambda: scene.analyze("fifo:0"),
        lambda: scene.to_bytes("stl"),
        lambda: scene.to_bytes("gltf"),
        lambda: scene.to_bytes("obj", layout="restart"),
        lambda: scene.picture(0, 1),
        lambda: scene.picture(9000, 1),
        lambda: scene.picture(1, 1, mode="x"),  # type: ignore[arg-type]
        lambda: tristrip.load("a.ply", format="x"),
    ]
    call: Callable[[], object]
    for call in wrong:
        with pytest.raises(tristrip.ParameterError):
            call()


def test_bounds_statistics_and_methods() -> None:
    scene = tristrip.load(model("wingnut.ply"))
    bound = scene.bound()
    rows = scene.compare(effort=0)
    assert all(row["proven"] and row["strips"] >= bound["bound"]["strips"] for row in rows)
    assert {row["method"] for row in rows} >= {"best", "fewest", "cache", "sgi", "stripe-local"}
    stripped = scene.strip(effort=4)
    assert stripped.bound is not None and stripped.bound["bound"] == bound["bound"]["indices_restart"]
    assert stripped.mesh == bound["mesh"]
    found = scene.analyze(["fifo:16", "lru:8"])
    assert [row["vertex_cache"] for row in found["vertex_caches"]] == ["fifo:16", "lru:8"]
    assert found["triangles"] == stripped.metrics()["triangles"]
    assert found["by_part"][0]["misses"] == [row["misses"] for row in found["vertex_caches"]]


def test_scenes_are_compared() -> None:
    scene = textured()
    assert scene.verify(tristrip.Scene.from_bytes(scene.strip().to_bytes()))["faces"] == 2
    flipped = tristrip.Scene.from_arrays(SQUARE, [[0, 1, 2], [0, 3, 2]])
    with pytest.raises(tristrip.NotProvenError) as caught:
        tristrip.verify(scene, flipped)
    assert caught.value.difference["flipped"] == 1  # type: ignore[attr-defined]
    with pytest.raises(tristrip.ArrayTypeError):
        scene.verify(5)  # type: ignore[arg-type]


def test_conversion_of_files(tmp_path: Path) -> None:
    report = tristrip.convert(model("catmark_bishop.ply"), tmp_path / "a.obj")
    before, after = tristrip.load(model("catmark_bishop.ply")).parts[0], tristrip.load(tmp_path / "a.obj").parts[0]
    assert report["faces"] == len(before.polygons[0]) - 1 if before.polygons else len(before.faces)
    assert np.array_equal(before.faces, after.faces)


def test_notebooks_show_scenes() -> None:
    scene = textured()
    for html in (scene._repr_html_(), scene.strip()._repr_html_(), scene.simplify(ratio=1)._repr_html_()):
        assert "<table>" in html and "data:image/png;base64," in html
    assert "<table>" in scene.chain([1, 0.5])._repr_html_()


def test_a_picture_shows_the_material() -> None:
    def reds(scene: tristrip.Scene) -> bytes:
        return scene.picture(16, 16)

    red = tristrip.Scene.from_arrays(SQUARE, HALVES, material={"base_color": (1, 0, 0)})
    grey = tristrip.Scene.from_arrays(SQUARE, HALVES)
    assert reds(red) != reds(grey) and reds(red) == reds(tristrip.Scene.from_bytes(red.to_bytes()))


def test_progress_and_interrupts_of_scenes() -> None:
    scene = tristrip.load(model("hand.ply"))
    stages: set[str] = set()
    scene.strip(effort=4, progress=lambda progress: stages.add(progress.stage))
    scene.simplify(ratio=0.1, progress=lambda progress: stages.add(progress.stage))
    assert stages & {"stripify", "simplify", "verify", "mesh"}

    def stop(progress: tristrip.Progress) -> None:
        if progress.stage == "stripify" and progress.steps > 0:
            raise KeyboardInterrupt

    with pytest.raises(tristrip.Interrupted) as caught:
        scene.strip(effort=9, progress=stop)
    best = caught.value.best
    assert best.stopped == "interrupt" and best.proven and best.to_bytes()[:4] == b"glTF"
    assert pickle.loads(pickle.dumps(best)).stopped == "interrupt"
    assert scene.strip(effort=9, progress=stop, on_interrupt="return").stopped == "interrupt"
    assert scene.strip(effort=9, budget=0.2).stopped == "budget"
    with pytest.raises(tristrip.Interrupted) as caught:
        scene.compare(effort=9, progress=stop)
    assert 1 <= len(caught.value.best) < 14
    with pytest.raises(KeyboardInterrupt):
        scene.chain([1, 0.5], method="best", effort=9).save(os.devnull, format="glb", progress=stop)

    class OddError(Exception):
        pass

    def fail(_: tristrip.Progress) -> None:
        raise OddError

    with pytest.raises(OddError):
        scene.strip(effort=9, progress=fail)


def test_scenes_work_in_threads() -> None:
    from concurrent.futures import ThreadPoolExecutor

    scene = tristrip.load(model("wingnut.ply"))
    expected = scene.strip().to_bytes()
    with ThreadPoolExecutor(4) as threads:
        assert all(found == expected for found in threads.map(lambda _: scene.strip().to_bytes(), range(8)))


# --- invalid files


def glb(document: bytes, binary: bytes = b"") -> bytes:
    document += b" " * (-len(document) % 4)
    chunks = struct.pack("<II", len(document), 0x4E4F534A) + document
    if binary:
        chunks += struct.pack("<II", len(binary), 0x004E4942) + binary
    return b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks


HOSTILE: dict[str, tuple[bytes, type[Exception] | tuple[type[Exception], ...]]] = {
    "empty.ply": (b"", tristrip.FormatError),
    "empty.glb": (b"", tristrip.FormatError),
    "short.glb": (b"glTF\2\0", tristrip.FormatError),
    "truncated.glb": (glb(b'{"asset":{"version":"2.0"}}')[:-8], tristrip.FormatError),
    "no.obj": (b"v 0 0 zero\n", tristrip.FormatError),
    "nan.obj": (b"v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", (tristrip.MeshError, tristrip.FormatError)),
    "index.obj": (b"v 0 0 0\nf 1 2 3\n", (tristrip.MeshError, tristrip.FormatError)),
    "count.ply": (
        b"ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\nend_header\nab",
        tristrip.FormatError,
    ),
    "count.stl": (b"\0" * 80 + struct.pack("<I", 0xFFFFFFF0) + b"ab", tristrip.FormatError),
    "count.off": (b"OFF\n4000000000 1 0\n0 0 0\n", tristrip.FormatError),
    "deep.gltf": (b"[" * 100_000, tristrip.FormatError),
    "version.gltf": (b'{"asset":{"version":"1.0"}}', (tristrip.FormatError, tristrip.ParameterError)),
    "outside.gltf": (
        b'{"asset":{"version":"2.0"},"buffers":[{"byteLength":4,"uri":"../../etc/passwd"}]}',
        (tristrip.FormatError, tristrip.FileError),
    ),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_files_are_errors(name: str, tmp_path: Path) -> None:
    data, expected = HOSTILE[name]
    (tmp_path / name).write_bytes(data)
    with pytest.raises(expected):
        tristrip.load(tmp_path / name)
    with pytest.raises(expected):
        tristrip.Scene.from_bytes(data, name.rsplit(".", 1)[-1])


def test_errors_of_the_file_system(tmp_path: Path) -> None:
    with pytest.raises(tristrip.FileError) as caught:
        tristrip.load(tmp_path / "none.ply")
    assert (caught.value.errno, caught.value.filename) == (errno.ENOENT, str(tmp_path / "none.ply"))
    assert isinstance(caught.value, OSError)
    with pytest.raises(tristrip.FileError) as caught:
        tristrip.load(tmp_path)
    assert caught.value.errno == errno.EISDIR
    scene = textured()
    for path in (tmp_path / "none" / "a.glb", tmp_path):
        with pytest.raises((tristrip.FileError, tristrip.ParameterError)):
            scene.save(path)
    with pytest.raises(tristrip.FileError) as caught:
        scene.strip().save(tmp_path / "none" / "a.glb")
    assert caught.value.errno == errno.ENOENT
    old = tmp_path / "old.glb"
    old.write_bytes(b"old")
    old.chmod(0o400)
    with pytest.raises(tristrip.FileError) as caught:
        scene.save(old)
    assert caught.value.errno == errno.EACCES and old.read_bytes() == b"old"
    assert [file.name for file in tmp_path.iterdir()] == ["old.glb"], "no temporary file is left"
    for name in ("a.stl", "a", "a.bin"):
        with pytest.raises(tristrip.ParameterError):
            scene.save(tmp_path / name)
    for wrong in (5, None, [1]):
        with pytest.raises(TypeError):
            tristrip.load(wrong)  # type: ignore[arg-type]
    with pytest.raises(tristrip.ArrayTypeError):
        tristrip.Scene.from_bytes("text")  # type: ignore[arg-type]


def test_random_bytes_are_no_crash() -> None:
    random = np.random.default_rng(7)
    good = bytearray(textured().to_bytes())
    for _ in range(300):
        changed = bytearray(good)
        for place in random.integers(0, len(good), 4):
            changed[place] = random.integers(0, 256)
        try:
            scene = tristrip.Scene.from_bytes(changed, "glb")
            scene.strip(effort=0).to_bytes()
            scene.parts  # noqa: B018
        except tristrip.TristripError as error:
            assert not isinstance(error, tristrip.InternalError), error


@pytest.mark.parametrize(
    "name", ["cow.ply", "texturedknot.obj", "textured/Duck.glb", "textured/CesiumMan.glb", "chair_nonmanifold.ply"]
)
def test_models_go_through_all_formats(name: str, tmp_path: Path) -> None:
    scene = tristrip.load(model(name))
    stripped = scene.strip(effort=0)
    for extension in ("glb", "ply", "obj", "gltf"):
        file = tmp_path / f"a.{extension}"
        assert stripped.save(file)["proven"]
        assert scene.verify(file)["proven"]
    again = tristrip.load(tmp_path / "a.glb")
    for part, strips, written in zip(scene.parts, stripped.parts, again.parts, strict=True):
        assert part.polygons is not None or strips.verify(part.faces)["faces"] == len(part.faces)
        # A material whose library is missing has only a name.
        assert part.material_properties in (None, written.material_properties)
