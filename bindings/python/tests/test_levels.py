"""Levels of detail of arrays and scenes, in every level model."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import meshes
import oracle
import tristrip

Hand = tuple[meshes.Positions, meshes.Triangles]
MODELS = ["progressive-mesh", "naive", "progressive", "sets", "blocks", "skip"]


def renamed(triangles: npt.ArrayLike, renaming: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return triangles with replaced vertices, without degenerate ones."""
    return oracle.canonical(renaming[oracle.canonical(triangles)])


@pytest.mark.parametrize("model", MODELS)
@given(mesh=meshes.meshes(), share=st.floats(0, 1))
@settings(max_examples=15)
def test_every_level_draws_the_renamed_triangles(model: Any, mesh: meshes.GeneratedMesh, share: float) -> None:
    levels = tristrip.Levels(mesh.vertices, mesh.faces, model=model)
    assert levels.model == model
    assert levels.level == levels.last_level
    oracle.assert_same_triangles(levels.triangles(), mesh.faces)
    level = round(share * levels.last_level)
    assert levels.set_level(level) == level == levels.level
    expected = renamed(mesh.faces, levels.renaming())
    assert len(expected) == levels.triangle_count
    oracle.assert_same_triangles(levels.triangles(), expected)
    for layout in ("restart", "degenerate", "list"):
        found = oracle.expand(levels.indices(layout, "uint32"), layout)
        oracle.assert_same_triangles(found, expected)
    levels.verify()


@pytest.mark.parametrize("model", MODELS)
def test_the_model_does_not_change_the_levels(model: Any) -> None:
    ball = meshes.sphere(3)
    levels = tristrip.Levels(ball.vertices, ball.faces, model=model, effort=1)
    usual = tristrip.Levels(ball.vertices, ball.faces, effort=1)
    for share in ("0%", "30%", "70%"):
        assert levels.set_level(share) == usual.set_level(share)
        assert np.array_equal(levels.renaming(), usual.renaming())
        assert levels.surface_error == usual.surface_error
    assert levels.memory["model"] > 0
    assert levels.memory["cursor"] > 0


def test_goals() -> None:
    ball = meshes.sphere(4)
    levels = tristrip.Levels(ball.vertices, ball.faces)
    levels.set_triangles(200)
    assert 190 < levels.triangle_count <= 200
    levels.set_error("1%")
    one = levels.level
    assert levels.surface_error <= 0.01 * levels.diagonal
    assert levels.set_error(0.01 * levels.diagonal) == one
    levels.set_level(one - 1)
    assert levels.surface_error > 0.01 * levels.diagonal
    near, far = (levels.set_pixels(1.5, distance=distance) for distance in (3, 30))
    assert far < near <= levels.last_level
    assert levels.set_pixels(1.5, 3, field_of_view=90.0, rows=540.0) < near
    with pytest.raises(tristrip.ParameterError):
        levels.set_pixels(1.5, distance=-1)
    with pytest.raises(tristrip.ParameterError, match="level"):
        levels.set_level(levels.last_level + 1)
    assert levels.level == levels.set_pixels(1.5, 3, field_of_view=90.0, rows=540.0)


def test_base_and_table() -> None:
    ball = meshes.sphere(4)
    levels = tristrip.Levels(ball.vertices, ball.faces, base=0.25)
    table = levels.table(4)
    assert [row["level"] for row in table] == sorted(row["level"] for row in table)
    assert table[0]["level"] == 0
    assert table[-1]["triangles"] == len(ball.faces)
    assert 0.24 * len(ball.faces) < table[0]["triangles"] <= 0.25 * len(ball.faces)
    assert levels.level == levels.last_level


def test_updates_patch_the_last_buffer() -> None:
    ball = meshes.sphere(3)
    levels = tristrip.Levels(ball.vertices, ball.faces)
    mine, changed = levels.update()
    assert changed == [(0, len(mine))]
    for level in ("80%", "79%", "20%", "100%"):
        levels.set_level(level)
        new, changed = levels.update()
        patched = np.resize(mine, len(new))
        for start, end in changed:
            patched[start:end] = new[start:end]
        assert np.array_equal(patched, new)
        oracle.assert_same_triangles(oracle.expand(new, "restart"), levels.triangles())
        mine = new
    assert levels.update()[1] == []


def test_another_object_stands_at_its_own_level() -> None:
    ball = meshes.sphere(3)
    levels = tristrip.Levels(ball.vertices, ball.faces)
    levels.set_level("50%")
    other = levels.another()
    assert other.level == other.last_level == levels.last_level > levels.level
    other.set_level(0)
    assert levels.level > 0
    assert other.triangle_count < levels.triangle_count


def test_seams_of_attributes_stay_closed() -> None:
    mesh = meshes.grid(12, 12)
    # Two copies of the vertices in the middle, with different texture coordinates.
    middle = np.flatnonzero(mesh.vertices[:, 0] == 6)
    copies = np.arange(len(middle)) + len(mesh.vertices)
    positions = np.concatenate([mesh.vertices, mesh.vertices[middle]])
    right = (mesh.vertices[mesh.faces, 0] > 6).any(axis=1)
    faces = mesh.faces.copy()
    for old, new in zip(middle, copies, strict=True):
        faces[right] = np.where(faces[right] == old, new, faces[right])
    uv = np.zeros((len(positions), 2), np.float32)
    uv[len(mesh.vertices) :] = 0.5
    levels = tristrip.Levels(positions, faces, uv=uv)
    levels.set_level(0)
    renaming = levels.renaming()
    for old, new in zip(middle, copies, strict=True):
        assert np.array_equal(positions[renaming[old]], positions[renaming[new]])


@pytest.mark.parametrize("model", ["blocks", "sets", "skip"])
def test_levels_of_a_scene(model: Any) -> None:
    ball, torus = meshes.sphere(3), meshes.torus(20, 10)
    parts = [
        tristrip.Part(ball.vertices, ball.faces, name="ball"),
        tristrip.Part(torus.vertices + np.array([9, 0, 0]), torus.faces, name="torus"),
    ]
    levels = tristrip.Scene.from_parts(parts).levels(model=model, effort=1)
    assert levels.part_count == 2
    total = len(ball.faces) + len(torus.faces)
    assert levels.triangle_count == total
    levels.set_triangles(total // 4)
    assert total // 4 - 2 <= levels.triangle_count <= total // 4
    drawn = 0
    for part, mesh in enumerate([ball, torus]):
        expected = renamed(mesh.faces, levels.renaming(part))
        oracle.assert_same_triangles(oracle.expand(levels.indices(part=part), "restart"), expected)
        assert np.array_equal(levels.vertices(part), parts[part].vertices)
        drawn += len(expected)
    assert drawn == levels.triangle_count
    levels.verify()
    with pytest.raises(tristrip.ParameterError, match="part"):
        levels.vertices(2)
    with pytest.raises(tristrip.ParameterError, match="odd"):
        tristrip.Scene.from_parts(parts).levels(odd=1)


def test_levels_of_a_textured_scene(model: Callable[[str], Path]) -> None:
    scene = tristrip.load(model("milktruck.glb"))
    levels = scene.levels(effort=0)
    assert levels.part_count == len(scene.parts)
    before = levels.triangle_count
    levels.set_error("1%")
    assert 0 < levels.triangle_count < before
    levels.verify()


def test_levels_pickle() -> None:
    ball = meshes.sphere(3)
    uv = (ball.vertices[:, :2]).astype(np.float32)
    levels = tristrip.Levels(ball.vertices, ball.faces, model="sets", base=0.1, uv=uv, method="sequential")
    levels.set_level("40%")
    again = pickle.loads(pickle.dumps(levels))
    assert repr(again) == repr(levels)
    assert np.array_equal(again.indices(), levels.indices())
    assert again.memory == levels.memory
    assert again.set_level(0) == levels.set_level(0) == 0
    assert np.array_equal(again.triangles(), levels.triangles())


def test_interrupts() -> None:
    def stop(progress: tristrip.Progress) -> None:
        if progress.stage == "simplify" and progress.steps > 0:
            raise KeyboardInterrupt

    mesh = meshes.grid(400, 400)
    with pytest.raises(KeyboardInterrupt):
        tristrip.Levels(mesh.vertices, mesh.faces, method="sequential", progress=stop)


def test_threads_with_objects_of_their_own(hand: Hand) -> None:
    levels = tristrip.Levels(*hand, effort=0)
    expected = {}
    for share in range(0, 101, 20):
        levels.set_level(f"{share}%")
        expected[share] = levels.indices()

    def is_as_alone(own: tristrip.Levels, first: int) -> bool:
        same = True
        for step in range(6):
            share = (first + 20 * step) % 120
            own.set_level(f"{share}%")
            same &= np.array_equal(own.indices(), expected[share])
        return same

    with ThreadPoolExecutor(6) as pool:
        assert all(pool.map(is_as_alone, [levels.another() for _ in range(6)], range(0, 120, 20)))


def test_bad_arguments() -> None:
    ball = meshes.sphere(2)

    def refused(**options: Any) -> None:
        with pytest.raises(tristrip.ParameterError):
            tristrip.Levels(ball.vertices, ball.faces, **options)

    refused(model="x")
    refused(base=2.0)
    refused(price="cheap")
    refused(method="x")
    refused(odd=3)


def test_the_papers_have_their_real_titles() -> None:
    text = " ".join((tristrip.Levels.__doc__ or "").split())
    for title in (
        "Kim, Park, Yang, Neelamkavil: A Rendering-Efficient Progressive Transmission of 3D Meshes, 2005",
        "Belmonte, Aguado, Sancho: Triangle Strip Multiresolution Modelling Using Sorted Edges, 2006",
        "Efficiently Computing and Updating Triangle Strips for Real-Time Rendering, 2000",
    ):
        assert title in text
