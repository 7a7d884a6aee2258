"""Progressive GLB: packing, unpacking, inspecting, and invalid files."""

from __future__ import annotations

import copy
import math
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import tristrip

Find = Callable[[str], Path]


def hills(n: int) -> bytes:
    """Return a hilly grid of quadrilaterals as OBJ."""
    lines = [f"v {x} {y} {2 * math.sin(x / 5) * math.cos(y / 7):.4f}" for y in range(n) for x in range(n)]
    corners = [y * n + x + 1 for y in range(n - 1) for x in range(n - 1)]
    return "\n".join(lines + [f"f {v} {v + 1} {v + n + 1} {v + n}" for v in corners]).encode()


PACKED = tristrip.pack(hills(30), format="obj")
BYTES = PACKED.bytes


def test_the_full_mesh_has_the_triangles_and_rounded_positions_of_the_input(model: Find) -> None:
    packed = tristrip.pack(model("hand.ply"))
    assert packed.report["proven"] is True
    assert len(packed.bytes) == packed.report["bytes"]
    again = tristrip.unpack(packed.bytes)
    assert len(again.faces) == packed.report["triangles"] == again.report["triangles_full"]
    assert again.faces.max() < len(again.vertices) == packed.report["vertices"]
    given_vertices, _ = tristrip.unpack(packed.bytes)
    error = packed.report["position_error"]
    assert error is not None
    assert error > 0
    coarse = tristrip.pack(model("hand.ply"), position_bits=6)
    coarse_error = coarse.report["position_error"]
    assert coarse_error is not None
    assert coarse_error > 100 * error
    assert np.ptp(given_vertices, axis=0) == pytest.approx(
        np.ptp(tristrip.unpack(coarse.bytes).vertices, axis=0), rel=0.05
    )


def test_paths_and_bytes_give_the_same(tmp_path: Path, model: Find) -> None:
    source = model("hand.ply")
    output = tmp_path / "hand.glb"
    written = tristrip.pack(source, output)
    assert written.bytes == output.read_bytes()
    assert written.report["output"] == str(output)
    in_memory = tristrip.pack(source.read_bytes())
    assert written.bytes == in_memory.bytes == tristrip.pack(str(source)).bytes
    assert tristrip.pack(memoryview(source.read_bytes())).bytes == in_memory.bytes
    assert tristrip.pack(bytearray(source.read_bytes()), format="ply").bytes == in_memory.bytes
    level = tmp_path / "level.ply"
    unpacked = tristrip.unpack(output, level, level="40%")
    assert unpacked.report["proven"] is True
    assert unpacked.report["output"] == str(level)
    with level.open("rb") as file:
        assert file.read(3) == b"ply"
    assert tristrip.inspect(output)["triangles"] == written.report["triangles"]


def test_a_scene_keeps_its_materials(tmp_path: Path, model: Find) -> None:
    packed = tristrip.pack(model("milktruck.glb"))
    assert packed.report["meshes"] > 0
    assert packed.report["parts"] > 1
    unpacked = tristrip.unpack(packed.bytes, tmp_path / "level.glb", triangles=1000)
    assert set(unpacked.attributes) <= {"NORMAL", "TEXCOORD_0"}
    assert b"Cesium" in (tmp_path / "level.glb").read_bytes() or unpacked.report["parts"] == packed.report["parts"]


def test_scenes_are_packed_and_unpacked(tmp_path: Path, model: Find) -> None:
    scene = tristrip.load(model("milktruck.glb"))
    packed = scene.pack()
    assert packed.bytes == tristrip.pack(scene).bytes == tristrip.pack(model("milktruck.glb")).bytes
    unpacked = tristrip.unpack(packed.bytes)
    assert [part.material for part in unpacked.scene.parts] == [part.material for part in scene.parts]
    assert sum(len(part.faces) for part in unpacked.scene.parts) == len(unpacked.faces) == packed.report["triangles"]
    assert tristrip.load(model("milktruck.glb")).pack(tmp_path / "a.glb").report["output"] == str(tmp_path / "a.glb")
    level = tristrip.unpack(packed.bytes, tmp_path / "level.gltf", level="50%")
    assert len(tristrip.load(tmp_path / "level.gltf").parts) == len(level.scene.parts)
    assert {file.name for file in tmp_path.iterdir()} == {"a.glb", "level.gltf", "level.bin"}
    decoder = tristrip.Decoder()
    assert decoder.scene() is None
    decoder.update(packed.bytes[: decoder.chunk_start or 8000])
    decoder.update(packed.bytes[decoder.offset : decoder.chunk_start])
    base = decoder.scene()
    assert base is not None and len(base.parts) == 4
    decoder.update(packed.bytes[decoder.offset :])
    full = decoder.scene()
    assert full is not None
    triangles = [sum(len(part.faces) for part in each.parts) for each in (base, full)]
    assert triangles[0] <= packed.report["base_triangles"] + 2856 and triangles[1] == packed.report["triangles"]


def test_goals_select_a_level() -> None:
    full = tristrip.unpack(BYTES)
    levels = full.report["levels"]
    assert full.report["level"] == levels
    assert tristrip.unpack(BYTES, level=levels // 2).report["level"] == levels // 2
    assert tristrip.unpack(BYTES, level="50%").report["level"] == pytest.approx(levels / 2, abs=1)
    assert len(tristrip.unpack(BYTES, triangles=400).faces) <= 400
    first = tristrip.unpack(BYTES, bytes=tristrip.inspect(BYTES)["chunks"][1]["end"])
    assert first.report["chunks"] == 2
    assert not first.report["ended_early"]


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"position_bits": 3}, "position_bits: found 3, expected 4 to 16"),
        ({"eye": (0.0, float("nan"), 0.0)}, "eye: found"),
        ({"format": "doc"}, 'format: found "doc"'),
        ({"output": "a.ply"}, "output: found a.ply, expected the extension .glb"),
    ],
)
def test_wrong_options_of_pack_are_told(options: dict[str, Any], text: str) -> None:
    with pytest.raises(tristrip.ParameterError) as found:
        tristrip.pack(hills(3), **{"format": "obj", **options})
    assert str(found.value).startswith(text)


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"level": 10**9}, "level: found 1000000000, expected at most"),
        ({"level": "x%"}, "level: found 'x%', expected a number of collapses"),
        ({"level": -1}, "level: found -1"),
        ({"level": 0.5}, "level: found 0.5"),
        ({"triangles": -1}, "found -1, expected a count of 0 or more"),
        ({"bytes": -1}, "found -1, expected a count of 0 or more"),
        ({"level": 1, "triangles": 1}, "level, triangles, bytes: found several"),
        ({"output": "a.stl"}, "a.stl: cannot write STL"),
    ],
)
def test_wrong_options_of_unpack_are_told(options: dict[str, Any], text: str) -> None:
    with pytest.raises(tristrip.ParameterError) as found:
        tristrip.unpack(BYTES, **options)
    assert str(found.value).startswith(text)


def test_wrong_inputs_are_told(tmp_path: Path) -> None:
    uses: list[Callable[[Any], object]] = [tristrip.pack, tristrip.unpack, tristrip.inspect]
    for use in uses:
        with pytest.raises(tristrip.ArrayTypeError, match="input: found int, expected a path or bytes"):
            use(3)
        with pytest.raises(tristrip.FileError) as missing:
            use(tmp_path / "missing.glb")
        assert isinstance(missing.value, OSError)
        assert missing.value.filename.endswith("missing.glb")
    for use in uses[1:]:
        for wrong in (b"", b"glTF", hills(3), BYTES[:100]):
            with pytest.raises(tristrip.FormatError):
                use(wrong)
    with pytest.raises(tristrip.FormatError, match="a GLB without a stream"):
        tristrip.unpack(tristrip.pack(hills(2), format="obj").bytes)
    with pytest.raises(tristrip.FileError):
        tristrip.pack(hills(5), tmp_path / "no folder" / "a.glb", format="obj")


@given(st.integers(0, len(BYTES)))
def test_a_file_that_is_cut_off_gives_a_level_or_an_error(end: int) -> None:
    start = tristrip.inspect(BYTES)["chunks"][0]["end"]
    if end < start:
        try:
            unpacked = tristrip.unpack(BYTES[:end])
        except tristrip.FormatError:
            return
        # The base meshes are available, but not the first chunk, which has the counts.
        assert unpacked.report["ended_early"]
        assert unpacked.report["level"] == 0
        return
    unpacked = tristrip.unpack(BYTES[:end])
    complete = end >= tristrip.inspect(BYTES)["chunks"][-1]["end"]
    assert unpacked.report["ended_early"] is not complete
    assert bool(unpacked.report["notes"]) or complete
    assert bool(tristrip.inspect(BYTES[:end])["notes"]) is not complete


@given(st.integers(0, len(BYTES) - 1), st.integers(1, 255))
def test_damaged_files_do_no_harm(at: int, change: int) -> None:
    damaged = bytearray(BYTES)
    damaged[at] ^= change
    try:
        unpacked = tristrip.unpack(damaged)
    except (tristrip.FormatError, tristrip.LimitError, tristrip.MeshError, tristrip.ParameterError):
        return
    assert len(unpacked.faces) == 0 or unpacked.faces.max() < len(unpacked.vertices)


def test_what_is_near_the_eye_comes_first() -> None:
    near = tristrip.pack(hills(60), format="obj", eye=(0.0, 0.0, 3.0))
    part = tristrip.unpack(near.bytes, triangles=1500)
    is_near = part.vertices[:, :2].sum(axis=1) < 59
    everywhere = tristrip.unpack(tristrip.pack(hills(60), format="obj").bytes, triangles=1500)
    assert is_near.mean() > 0.1 + (everywhere.vertices[:, :2].sum(axis=1) < 59).mean()


def test_results_can_be_pickled_and_shown() -> None:
    assert pickle.loads(pickle.dumps(PACKED)) == PACKED
    unpacked = tristrip.unpack(BYTES, level="50%")
    again = pickle.loads(pickle.dumps(unpacked))
    assert (again.faces == unpacked.faces).all()
    assert again.report == unpacked.report
    assert copy.deepcopy(unpacked).report == unpacked.report
    assert repr(PACKED).startswith("Packed(1,682 triangles, ")
    assert repr(unpacked).startswith("Unpacked(level ")
    for shown in (PACKED, unpacked):
        assert "<table>" in shown._repr_html_()


def test_progress_and_keys_are_those_of_the_command() -> None:
    stages: list[str] = []
    tristrip.pack(hills(120), format="obj", progress=lambda progress: stages.append(progress.stage))
    assert set(stages) <= {"simplify", "write", "verify"}
    assert list(PACKED.report) == [
        "proven", "parts", "meshes", "chunks", "vertices", "triangles", "base_triangles", "bytes", "base_bytes",
        "bits_per_vertex", "position_error", "notes", "output",
    ]  # fmt: skip
