"""Strips of triangles: every method, layout and index type against the oracle."""

from __future__ import annotations

import json
import subprocess
import sys
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from typing import Any

import hypothesis
import numpy as np
import pytest
from hypothesis import strategies as st

import meshes
import oracle
import tristrip
from conftest import shared_models
from stub import choices

METHODS = choices("Method")
LAYOUTS = choices("Layout")
COSTS: list[Any] = choices("Cost")
KEYS_OF_COSTS = {
    "restart": "indices_restart",
    "degenerate": "indices_degenerate",
    "opengl": "vertices_sent",
    "gl": "gl_cost",
}
#: Methods that need only the buffer.
BUFFERS: list[Any] = ["restart", "degenerate", "list"]
EXAMPLES = meshes.examples()

mesh_parameter = pytest.mark.parametrize("mesh", EXAMPLES, ids=lambda mesh: mesh.name)


def check(strips: tristrip.Strips, faces: Any) -> None:
    """Check in all forms that strips draw the faces."""
    oracle.assert_same_triangles(strips.triangles(), faces)
    for layout in BUFFERS:
        oracle.assert_same_triangles(oracle.expand(strips.indices(layout), layout), faces)
    oracle.assert_same_triangles(oracle.expand(strips.indices("separate"), "separate", strips.offsets), faces)


@pytest.mark.parametrize("method", METHODS)
@mesh_parameter
def test_every_method_draws_the_faces(method: str, mesh: meshes.GeneratedMesh) -> None:
    strips = tristrip.stripify(mesh.faces, method=method)
    check(strips, mesh.faces)
    assert strips.verify(mesh.faces)["triangles"] == len(oracle.canonical(mesh.faces))
    # Positions are needed only for polygons and welding, and must not change what is drawn.
    check(tristrip.stripify(mesh.faces, mesh.vertices, method=method, verify=True), mesh.faces)


@hypothesis.given(mesh=meshes.meshes(), method=st.sampled_from(METHODS), data=st.data())
@hypothesis.settings(max_examples=150)
def test_any_method_draws_any_mesh(mesh: meshes.GeneratedMesh, method: str, data: st.DataObject) -> None:
    options: dict[str, Any] = {}
    if method == "best":
        options["cost"] = data.draw(st.sampled_from(COSTS), "cost")
    if method in {"best", "fewest", "cache"}:
        options["effort"] = data.draw(st.integers(0, 6), "effort")
    check(tristrip.stripify(mesh.faces, method=method, **options), mesh.faces)


@pytest.mark.parametrize("cost", COSTS)
def test_the_cost_is_what_best_minimizes(cost: str) -> None:
    faces = meshes.shuffled(meshes.torus(20, 20), np.random.default_rng(3)).faces
    key = KEYS_OF_COSTS[cost]
    results: dict[str, Any] = {other: tristrip.stripify(faces, cost=other, effort=5).metrics() for other in COSTS}
    assert results[cost][key] == min(metrics[key] for metrics in results.values())


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("dtype", ["uint8", "uint16", "uint32", np.uint8, np.uint16, np.uint32, np.dtype("<u4")])
def test_layouts_and_dtypes(layout: Any, dtype: Any) -> None:
    mesh = meshes.grid(9, 8)
    strips = tristrip.stripify(mesh.faces)
    indices = strips.indices(layout, dtype=dtype)
    assert indices.dtype == np.dtype(dtype)
    assert indices.ndim == 1
    assert indices.flags.c_contiguous
    assert indices.flags.writeable
    oracle.assert_same_triangles(oracle.expand(indices, layout, strips.offsets), mesh.faces)


def test_the_smallest_dtype_that_names_all_vertices() -> None:
    assert tristrip.stripify([[0, 1, 65534]]).indices().dtype == np.uint16
    assert tristrip.stripify([[0, 1, 65535]]).indices().dtype == np.uint32
    assert tristrip.stripify([[0, 1, 2]]).indices().dtype == np.uint16
    for dtype, highest in [("uint8", 254), ("uint16", 65534), ("uint32", 2**32 - 3)]:
        strips = tristrip.stripify([[0, 1, highest]], method="input")
        assert sorted(strips.indices(dtype=dtype).tolist()) == [0, 1, highest]
        if dtype != "uint32":
            above = tristrip.stripify([[0, 1, highest + 1]])
            with pytest.raises(tristrip.LimitError, match=f"found {highest + 1}, the limit is {highest}"):
                above.indices(dtype=dtype)


@pytest.mark.parametrize("layout", ["", "Restart", "strip", "fan"])
def test_unknown_layouts(layout: Any) -> None:
    strips = tristrip.stripify([[0, 1, 2]])
    with pytest.raises(tristrip.ParameterError, match=r"layout: found .*, expected .*restart"):
        strips.indices(layout)
    with pytest.raises(tristrip.ParameterError, match=r"layout: found .*, expected .*restart"):
        tristrip.Strips.from_indices([0, 1, 2], layout)


@pytest.mark.parametrize("dtype", ["int32", "uint64", "float32", np.int64, "no dtype", 7, object])
def test_unknown_dtypes(dtype: Any) -> None:
    with pytest.raises(tristrip.ParameterError, match=r"dtype: found .*, expected uint8, uint16 or uint32"):
        tristrip.stripify([[0, 1, 2]]).indices(dtype=dtype)


@mesh_parameter
@pytest.mark.parametrize("method", ["best", "cache", "tunnel", "input"])
def test_metrics(mesh: meshes.GeneratedMesh, method: str) -> None:
    strips = tristrip.stripify(mesh.faces, method=method)
    metrics: dict[str, Any] = dict(strips.metrics())
    expected = oracle.figures(strips.vertices, strips.offsets)
    assert {key: metrics[key] for key in expected} == pytest.approx(expected, abs=1e-6)
    assert metrics["indices_restart"] == len(strips.indices("restart"))
    assert metrics["indices_degenerate"] == len(strips.indices("degenerate"))
    assert metrics["vertices_sent"] == len(strips.vertices) == len(strips.indices("separate"))
    per = metrics["indices_degenerate"] / max(metrics["triangles"], 1)
    assert metrics["indices_degenerate_per_triangle"] == pytest.approx(per, abs=1e-6)


@pytest.mark.parametrize("flush", [False, True])
@pytest.mark.parametrize("cache", ["fifo:1", "fifo:3", "fifo:16", "fifo:24", "lru:3", "lru:16", "lru:32"])
def test_vertex_caches(cache: str, flush: bool) -> None:
    mesh = meshes.shuffled(meshes.torus(12, 10), np.random.default_rng(5))
    strips = tristrip.stripify(mesh.faces, method="cache")
    policy, entries = cache.split(":")
    misses = oracle.cache_misses([strip.tolist() for strip in strips], policy, int(entries), flush=flush)
    expected = {"misses": misses, "acmr": misses / len(mesh.faces), "atvr": misses / len(mesh.vertices)}
    assert dict(strips.vertex_cache(cache, flush=flush)) == pytest.approx(expected)


@pytest.mark.parametrize("cache", ["", "fifo", "fifo:0", "fifo:-1", "lru:x", "mru:16"])
def test_unknown_vertex_caches(cache: str) -> None:
    with pytest.raises(tristrip.ParameterError, match="found"):
        tristrip.stripify([[0, 1, 2]]).vertex_cache(cache)


def test_method_cache_has_fewer_misses(hand: tuple[meshes.Positions, meshes.Triangles]) -> None:
    misses = [tristrip.stripify(hand[1], method=method).metrics()["acmr_fifo_16"] for method in ["cache", "best"]]
    assert misses[0] < 0.85 * misses[1]


@mesh_parameter
@pytest.mark.parametrize("layout", ["restart", "degenerate", "list"])
@pytest.mark.parametrize("dtype", ["uint8", "uint32"])
def test_index_buffers_come_back(mesh: meshes.GeneratedMesh, layout: Any, dtype: Any) -> None:
    strips = tristrip.stripify(mesh.faces)
    again = tristrip.Strips.from_indices(strips.indices(layout, dtype=dtype), layout)
    check(again, mesh.faces)
    assert again.method is None
    if layout == "restart":
        assert [strip.tolist() for strip in again] == [strip.tolist() for strip in strips]
    if layout == "list":
        assert len(again) == len(strips.triangles())


def test_an_index_buffer_of_signed_integers_has_restarts_of_32_bits() -> None:
    buffer = np.array([0, 1, 2, 2**32 - 1, 3, 4, 5], dtype=np.int64)
    assert [strip.tolist() for strip in tristrip.Strips.from_indices(buffer)] == [[0, 1, 2], [3, 4, 5]]
    assert tristrip.Strips.from_indices(np.array([65535, 1, 2], dtype=np.uint32))[0].tolist() == [65535, 1, 2]
    assert len(tristrip.Strips.from_indices(np.array([65535, 1, 2], dtype=np.uint16))) == 0


@mesh_parameter
def test_strips_are_a_sequence(mesh: meshes.GeneratedMesh) -> None:
    strips = tristrip.stripify(mesh.faces)
    listed = list(strips)
    assert len(listed) == len(strips) == len(strips.offsets) - 1
    parts = np.split(strips.vertices, strips.offsets[1:-1]) if len(strips) else []
    for index, (strip, part) in enumerate(zip(listed, parts, strict=True)):
        assert strip.dtype == np.uint32
        assert strip.tolist() == part.tolist() == strips[index].tolist() == strips[index - len(strips)].tolist()
    for index in [len(strips), -len(strips) - 1, 2**31]:
        noun = "strip" if len(strips) == 1 else "strips"
        with pytest.raises(IndexError, match=f"found {len(strips)} {noun}\\b"):
            strips[index]
    assert isinstance(iter(strips), type(iter(strips)))
    assert [strip.tolist() for strip in reversed(strips)] == [strip.tolist() for strip in reversed(listed)]


def test_iteration_takes_linear_time(hand: tuple[meshes.Positions, meshes.Triangles]) -> None:
    # Access each strip by index: 16,000 strips at a microsecond each, independent of the preceding
    # strips.
    strips = tristrip.stripify(np.tile(hand[1], (8, 1)), method="input")
    assert sum(len(strip) for strip in strips) == strips.metrics()["vertices_sent"]
    assert sum(len(strips[index]) for index in range(len(strips))) == strips.metrics()["vertices_sent"]


def test_results_are_copies() -> None:
    strips = tristrip.stripify([[0, 1, 2], [2, 1, 3]])
    before = strips.triangles().tolist()
    arrays: list[Any] = [strips.vertices, strips.offsets, strips.indices(), strips.triangles(), strips[0]]
    for array in arrays:
        array[...] = 7
    assert strips.triangles().tolist() == before


def test_arguments_are_not_changed() -> None:
    mesh = meshes.shuffled(meshes.torus(6, 6), np.random.default_rng(1))
    for dtype in ["uint32", "int64"]:
        faces, vertices = mesh.faces.astype(dtype), mesh.vertices.copy()
        tristrip.stripify(faces, vertices).verify(faces)
        assert np.array_equal(faces, mesh.faces)
        assert np.array_equal(vertices, mesh.vertices)


@pytest.mark.parametrize("method", METHODS)
def test_same_result_of_every_dtype_and_form(method: str) -> None:
    faces = meshes.shuffled(meshes.sphere(2), np.random.default_rng(11)).faces
    expected = tristrip.stripify(faces.astype(np.uint32), method=method)
    forms: list[Any] = [meshes.as_dtype(faces, dtype) for dtype in ["uint8", "int16", "int32", "uint64", ">i4", "<u2"]]
    forms += [faces.ravel(), faces.tolist(), tuple(map(tuple, faces.tolist())), np.asfortranarray(faces)]
    for form in forms:
        assert tristrip.stripify(form, method=method) == expected


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.usefixtures("default_threads")
def test_same_result_on_any_number_of_threads(method: str) -> None:
    mesh = meshes.shuffled(meshes.torus(40, 30), np.random.default_rng(13))
    results = []
    for threads in [1, 2, 5, None]:
        tristrip.set_threads(threads)
        results.append(tristrip.stripify(mesh.faces, mesh.vertices, method=method).indices().tobytes())
    assert len(set(results)) == 1


@pytest.mark.parametrize("threads", [0, -1, 1025, 2**40])
def test_wrong_numbers_of_threads(threads: int) -> None:
    with pytest.raises(tristrip.ParameterError, match=f"threads: found {threads}, expected 1 to 1024, or None"):
        tristrip.set_threads(threads)


def test_a_seed_changes_a_search(hand: tuple[meshes.Positions, meshes.Triangles]) -> None:
    results = [tristrip.stripify(hand[1], effort=1, seed=seed).indices().tobytes() for seed in (1, 1, 2)]
    assert results[0] == results[1] != results[2]


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"method": "magic"}, "method"),
        ({"method": ""}, "method"),
        ({"cost": "money"}, "cost"),
        ({"effort": 10}, "effort"),
        ({"effort": -1}, "effort: found `-1` in `best:effort=-1`, expected an integer from 0 to 9"),
        ({"effort": 300}, "effort: found `300` in `best:effort=300`, expected"),
        ({"effort": 2**70}, "effort: found `1180591620717411303424` in"),
        ({"effort": "high"}, "effort: found `high` in `best:effort=high`, expected"),
        (
            {"colour": "red"},
            "found `colour` in `best:colour=red`, expected one of the parameters cost, effort and seed",
        ),
        ({"vertex_cache": "fifo:0", "method": "cache"}, "vertex_cache"),
        ({"vertex_cache": "fifo:16"}, "found `vertex-cache` in `best:vertex_cache=fifo:16`, expected one of"),
        ({"method": "input", "effort": 3}, "found `effort` in `input:effort=3`, expected no parameters for input"),
        ({"method": "cache", "cost": "gl"}, "cost"),
        ({"seed": "x"}, "seed: found `x` in `best:seed=x`, expected an integer of at least 0"),
        ({"budget": -1.0}, "budget"),
        ({"budget": float("nan")}, "budget"),
        ({"on_interrupt": "ignore"}, "on_interrupt"),
        ({"progress": 5}, "progress"),
    ],
    ids=str,
)
def test_wrong_options(options: dict[str, Any], text: str) -> None:
    with pytest.raises(tristrip.ParameterError) as caught:
        tristrip.stripify([[0, 1, 2]], **options)
    assert text in str(caught.value)
    assert "--" not in str(caught.value)
    assert isinstance(caught.value, ValueError)


def test_degenerate_faces_are_noted() -> None:
    assert tristrip.stripify([[0, 1, 2]]).notes == []
    assert tristrip.stripify([[0, 1, 2], [0, 0, 1]]).notes == ["1 degenerate face dropped (no area)"]
    faces = [[0, 1, 2], [3, 3, 3], [4, 5, 4]]
    for vertices in [None, np.zeros((6, 3))]:
        strips = tristrip.stripify(faces, vertices)
        assert strips.notes == ["2 degenerate faces dropped (no area)"]
        assert strips.metrics()["triangles"] == 1


def test_verification_finds_differences() -> None:
    mesh = meshes.grid(4, 4)
    strips = tristrip.stripify(mesh.faces, verify=True)
    assert strips.proven
    assert not tristrip.stripify(mesh.faces).proven
    changed = mesh.faces.copy()
    changed[3] = changed[3, [0, 2, 1]]
    for faces in [mesh.faces[1:], np.concatenate([mesh.faces, mesh.faces[:1]]), changed, mesh.faces + 1]:
        with pytest.raises(tristrip.NotProvenError, match="missing"):
            strips.verify(faces)
    rotated = mesh.faces[:, [1, 2, 0]][::-1]
    assert dict(strips.verify(rotated)) == {"faces": 32, "triangles": 32}


def test_texts() -> None:
    strips = tristrip.stripify(meshes.grid(40, 40).faces, effort=3)
    assert strips.method == "method best, cost restart, effort 3"
    assert repr(strips) == (
        f"Strips({len(strips)} strips, 3,200 triangles, {len(strips.indices()):,} indices, "
        "method best, cost restart, effort 3)"
    )
    html = strips._repr_html_()
    assert "<td>3,200</td>" in html
    assert html.count("<table>") == html.count("</table>") == 1
    one = tristrip.Strips.from_indices([0, 1, 2])
    assert repr(one) == "Strips(1 strip, 1 triangle, 3 indices)"
    assert "strips" in one._repr_html_()


def test_equality() -> None:
    faces = meshes.grid(3, 3).faces
    strips = tristrip.stripify(faces)
    assert strips == tristrip.stripify(faces.copy())
    assert strips != tristrip.stripify(faces[1:])
    assert strips != tristrip.stripify(faces, method="input")
    assert strips != "strips"
    assert strips != [strip.tolist() for strip in strips]
    with pytest.raises(TypeError, match="unhashable"):
        hash(strips)


def test_the_class_cannot_be_made_or_changed() -> None:
    strips = tristrip.stripify([[0, 1, 2]])
    with pytest.raises(TypeError):
        tristrip.Strips()
    for name in ["method", "vertices", "other"]:
        with pytest.raises(AttributeError):
            setattr(strips, name, None)


@pytest.mark.parametrize(
    "name", ["fish_control.ply", "catmark_bishop.ply", "hand.ply", "wingnut.ply", "self_intersect_a.ply"]
)
def test_models(model: Callable[[str], Path], name: str) -> None:
    vertices, polygons = meshes.read_model(model(name))
    strips = tristrip.stripify(polygons, vertices, verify=True)
    assert strips.proven
    oracle.assert_triangulates(strips.triangles(), polygons)
    # A third of the indices of a list or better, including restarts.
    assert strips.metrics()["indices_restart_per_triangle"] < 1.4


def write_ply(path: Path, vertices: meshes.Positions, strips: tristrip.Strips) -> None:
    """Write a text PLY with strips."""
    lines = ["ply", "format ascii 1.0", f"element vertex {len(vertices)}"]
    lines += [f"property float {axis}" for axis in "xyz"]
    lines += [f"element tristrips {len(strips)}", "property list int int vertex_indices", "end_header"]
    lines += [" ".join(map(repr, point)) for point in vertices.astype(float).tolist()]
    lines += [" ".join(map(str, [len(strip), *strip.tolist()])) for strip in strips]
    path.write_text("\n".join(lines) + "\n", encoding="ascii")


@pytest.mark.parametrize("method", ["best", "fewest", "cache", "tunnel"])
@pytest.mark.parametrize("name", ["fish_control.ply", "wingnut.ply"])
def test_the_checker_of_files_agrees(tmp_path: Path, model: Callable[[str], Path], name: str, method: str) -> None:
    """An independent program proves the strips of a file against its source."""
    program = shared_models().parent / "check_strips.py"
    if not program.is_file():
        pytest.skip(f"{program} is missing")
    source, result = model(name), tmp_path / "result.ply"
    vertices, polygons = meshes.read_model(source)
    strips = tristrip.stripify(polygons, vertices, method=method)
    write_ply(result, vertices, strips)
    command = [sys.executable, str(program), str(source), str(result), "--json"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    found = json.loads(done.stdout)
    metrics: dict[str, Any] = dict(strips.metrics())
    for key in ["triangles", "strips", "vertices_sent", "isolated"]:
        assert found[key] == metrics[key]


def test_contiguous_uint32_is_not_copied() -> None:
    faces = np.ascontiguousarray(meshes.grid(300, 300).faces, np.uint32)
    tristrip.stripify(faces[:10])

    def peak(given: Any) -> int:
        tracemalloc.start()
        tristrip.stripify(given, method="sequential")
        found = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return found

    # NumPy reports its allocations to tracemalloc.
    assert peak(faces) < faces.nbytes / 10
    assert peak(faces.ravel()) < faces.nbytes / 10
    assert peak(faces.astype(np.int64)) >= faces.nbytes
