"""Simplification of arrays, and its interruption."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given

import meshes
import oracle
import tristrip
from interrupts import interrupt_after


def bumpy(width: int) -> meshes.GeneratedMesh:
    """Build an open grid with bumps."""
    mesh = meshes.grid(width, width)
    vertices = mesh.vertices.copy()
    x, y = vertices[:, 0] / width, vertices[:, 1] / width
    vertices[:, 2] = 3 * np.sin(7 * x) * np.cos(5 * y) + x * y
    return meshes.GeneratedMesh("bumpy", vertices, mesh.faces)


def edges_of(faces: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return the undirected edges of triangles, with repetitions."""
    return np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)


@given(meshes.meshes())
def test_any_mesh(mesh: meshes.GeneratedMesh) -> None:
    for fit in (False, True):
        small = tristrip.simplify(mesh.vertices, mesh.faces, ratio=0.4, error="100%", fit=fit)
        assert len(small.faces) <= len(oracle.canonical(mesh.faces))
        assert small.vertices.shape == (len(small.sources), 3)
        assert np.array_equal(np.unique(small.faces), np.arange(len(small.vertices)))
        assert np.isfinite(small.vertices).all()
        assert not small.interrupted
        if not fit:
            assert np.array_equal(small.vertices, mesh.vertices[small.sources].astype(np.float32))


def test_a_closed_surface_stays_closed() -> None:
    ball = meshes.sphere(3)
    goals: list[dict[str, Any]] = [
        {"ratio": 0.2},
        {"triangles": 100},
        {"error": "2%"},
        {"ratio": 0.1, "permissive": True},
    ]
    for options in goals:
        small = tristrip.simplify(ball.vertices, ball.faces, **options)
        _, counts = np.unique(edges_of(small.faces), axis=0, return_counts=True)
        assert (counts == 2).all()
        assert len(small.faces) < len(ball.faces)


def test_goals() -> None:
    mesh = bumpy(40)
    count = len(mesh.faces)
    for ratio in (1, 0.5, 0.1):
        small = tristrip.simplify(mesh.vertices, mesh.faces, ratio=ratio, error="100%")
        assert ratio * count - 2 <= len(small.faces) <= ratio * count
        assert small.warning is None
    vertices, faces = tristrip.simplify(mesh.vertices, mesh.faces, triangles=123, error="100%")
    assert 121 <= len(faces) <= 123
    assert faces.max() + 1 == len(vertices)
    # Any error, in mesh units or relative to the diagonal.
    exact, loose = (
        tristrip.simplify(mesh.vertices, mesh.faces, error=error, fit=False, measure=True) for error in (0.01, 0.2)
    )
    assert len(loose.faces) < len(exact.faces) < count
    assert exact.surface_error <= 0.01 < loose.surface_error <= 0.2
    assert loose.rms_deviation is not None
    assert loose.largest_deviation is not None
    assert 0 < loose.rms_deviation < loose.largest_deviation <= 0.25
    same = tristrip.simplify(mesh.vertices, mesh.faces, error=f"{100 * 0.2 / loose.diagonal}%", fit=False)
    assert np.array_equal(same.faces, loose.faces)
    stuck = tristrip.simplify(mesh.vertices, mesh.faces, triangles=2, error="0.01%")
    assert stuck.warning is not None
    assert "error limit" in stuck.warning


def test_the_fit_is_closer_and_keeps_borders() -> None:
    mesh = bumpy(60)
    options: dict[str, Any] = {"ratio": 0.05, "error": "100%", "measure": True}
    kept, fitted = (tristrip.simplify(mesh.vertices, mesh.faces, fit=fit, **options) for fit in (False, True))
    # The triangles are the same, over reordered vertices.
    oracle.assert_same_triangles(kept.sources[kept.faces], fitted.sources[fitted.faces])
    assert kept.rms_deviation is not None
    assert fitted.rms_deviation is not None
    assert fitted.rms_deviation < 0.9 * kept.rms_deviation
    edges, counts = np.unique(edges_of(fitted.faces), axis=0, return_counts=True)
    border = np.unique(edges[counts == 1])
    moved = (fitted.vertices != mesh.vertices[fitted.sources]).any(axis=1)
    assert not moved[border].any()
    assert moved.sum() > 0.5 * (len(moved) - len(border))


def test_attributes_and_their_seams_stay() -> None:
    mesh = bumpy(30)
    uv = (mesh.vertices[:, :2] / 30).astype(np.float32)
    colors = np.zeros((len(uv), 4), np.uint8)
    colors[:, 0] = np.arange(len(uv)) % 251
    weights = np.linspace(0, 1, len(uv))
    small = tristrip.simplify(
        mesh.vertices, mesh.faces, ratio=0.3, uv=uv, colors=colors, attributes={"heat": weights}, fit=False
    )
    assert small.uv is not None
    assert np.array_equal(small.uv, uv[small.sources])
    assert small.colors is not None
    assert small.colors.dtype == np.uint8
    assert np.array_equal(small.colors, colors[small.sources])
    assert set(small.attributes) == {"TEXCOORD_0", "COLOR_0", "heat"}
    assert np.array_equal(small.attributes["heat"], weights[small.sources])
    assert small.normals is None


def test_prices_and_borders() -> None:
    mesh = bumpy(30)
    counts = set()
    for price in ("distance", "planes", "quadric"):
        small = tristrip.simplify(mesh.vertices, mesh.faces, ratio=0.1, error="100%", price=price)
        counts.add(small.faces.tobytes())
    assert len(counts) == 3
    locked = tristrip.simplify(mesh.vertices, mesh.faces, ratio=0, error="100%", lock_borders=True)
    edges, times = np.unique(edges_of(locked.faces), axis=0, return_counts=True)
    assert len(edges[times == 1]) == 4 * 30


def test_a_result_pickles() -> None:
    mesh = bumpy(20)
    colors = np.full((len(mesh.vertices), 3), 40000, np.uint16)
    small = tristrip.simplify(mesh.vertices, mesh.faces, ratio=0.3, colors=colors, measure=True)
    again = pickle.loads(pickle.dumps(small))
    assert repr(again) == repr(small)
    assert np.array_equal(again.vertices, small.vertices)
    assert np.array_equal(again.faces, small.faces)
    assert np.array_equal(again.sources, small.sources)
    assert again.colors.dtype == np.uint16
    assert np.array_equal(again.colors, colors[small.sources])
    assert (again.rms_deviation, again.largest_deviation) == (small.rms_deviation, small.largest_deviation)
    assert (again.warning, again.notes, again.diagonal) == (small.warning, small.notes, small.diagonal)


def stop(progress: tristrip.Progress) -> None:
    """Raise like Ctrl-C, once some triangles have been removed."""
    if progress.stage == "simplify" and progress.steps > 0:
        raise KeyboardInterrupt


def test_an_interrupted_simplification_is_one_to_fewer_triangles() -> None:
    mesh = bumpy(300)
    options: dict[str, Any] = {"triangles": 100, "error": "100%", "fit": False}
    with pytest.raises(tristrip.Interrupted) as caught:
        tristrip.simplify(mesh.vertices, mesh.faces, progress=stop, **options)
    best = caught.value.best
    count = len(best.faces)
    assert best.interrupted
    assert any("interrupted" in note for note in best.notes)
    assert 100 < count < len(mesh.faces)
    wanted = tristrip.simplify(mesh.vertices, mesh.faces, **{**options, "triangles": count})
    assert np.array_equal(best.faces, wanted.faces)
    assert np.array_equal(best.vertices, wanted.vertices)
    assert pickle.loads(pickle.dumps(caught.value)).best.interrupted
    small = tristrip.simplify(mesh.vertices, mesh.faces, progress=stop, on_interrupt="return", **options)
    assert small.interrupted


@pytest.mark.parametrize("stage", ["fit", "compare"])
def test_ctrl_c_after_the_collapses_keeps_them(stage: str) -> None:
    def stop_later(progress: tristrip.Progress) -> None:
        if progress.stage == stage:
            raise KeyboardInterrupt

    # A stage is reported if it takes longer than the interval of reports.
    for width in (100, 200, 400, 800):
        mesh = bumpy(width)
        try:
            tristrip.simplify(mesh.vertices, mesh.faces, ratio=0.2, error="100%", fit=True, progress=stop_later)
        except tristrip.Interrupted as interrupted:
            best = interrupted.best
            break
    else:
        pytest.fail(f"{stage} was never seen")
    assert 0.19 * len(mesh.faces) < len(best.faces) <= 0.2 * len(mesh.faces)
    assert best.interrupted == (stage == "fit")
    assert (best.rms_deviation is None) == (stage == "fit")


def test_an_interrupted_file_is_not_that_of_less_collapses() -> None:
    mesh = bumpy(160)
    scene = tristrip.Scene.from_arrays(mesh.vertices, mesh.faces)
    for verify in (False, True):
        small = scene.simplify(ratio=0.01, error="100%", measure=False, verify=verify)
        again = pickle.loads(pickle.dumps(small))
        # The data for files are computed now, and again after the interrupt.
        with pytest.raises(KeyboardInterrupt), interrupt_after(0.03):
            again.to_bytes("glb")
        assert len(tristrip.Scene.from_bytes(again.to_bytes("glb")).parts[0].faces) == small.report["triangles_after"]


def test_many_parts_are_interrupted_together() -> None:
    mesh = bumpy(150)
    parts = [tristrip.Part(mesh.vertices + np.array([200 * i, 0, i], np.float32), mesh.faces) for i in range(6)]
    scene = tristrip.Scene.from_parts(parts)
    total = 6 * len(mesh.faces)
    seen: list[int] = []

    def watch(progress: tristrip.Progress) -> None:
        if progress.stage == "simplify":
            seen.append(progress.steps)
        stop(progress)

    with pytest.raises(tristrip.Interrupted) as caught:
        scene.simplify(ratio=0.01, error="100%", progress=watch)
    best = caught.value.best
    assert seen == sorted(seen)
    assert best.interrupted
    assert 0.01 * total < best.report["triangles_after"] < total
    assert sum(len(part.faces) for part in best.scene.parts) == best.report["triangles_after"]


def test_large_triangles_take_no_points() -> None:
    ball = meshes.sphere(6)
    count = len(ball.vertices)
    floor = np.array([[-900, -900, -2], [900, -900, -2], [900, 900, -2], [-900, 900, -2]], np.float32)
    faces = np.concatenate([ball.faces, [[count, count + 1, count + 2], [count, count + 2, count + 3]]])
    small = tristrip.simplify(np.concatenate([ball.vertices, floor]), faces, ratio=0.2, error="100%", fit=True)
    radii = np.linalg.norm(small.vertices[small.sources < count], axis=1)
    assert 0.99 < radii.min() <= radii.max() < 1.03


def test_progress_counts_removed_triangles() -> None:
    mesh = bumpy(200)
    seen: list[tristrip.Progress] = []
    small = tristrip.simplify(mesh.vertices, mesh.faces, ratio=0.1, error="100%", progress=seen.append)
    steps = [progress.steps for progress in seen if progress.stage == "simplify"]
    assert steps == sorted(steps)
    assert 0 < steps[-1] <= len(mesh.faces) - len(small.faces)
    assert {progress.step_limit for progress in seen if progress.steps} == {len(mesh.faces) * 9 // 10}


def test_an_interrupted_scene() -> None:
    mesh = bumpy(300)
    scene = tristrip.Scene.from_arrays(mesh.vertices, mesh.faces)
    with pytest.raises(tristrip.Interrupted) as caught:
        scene.simplify(ratio=0.001, error="100%", progress=stop)
    best = caught.value.best
    count = best.report["triangles_after"]
    assert best.interrupted
    assert best.proven
    assert len(best.scene.parts[0].faces) == count
    again = pickle.loads(pickle.dumps(best))
    assert again.interrupted
    # Its files have the same number of triangles.
    assert len(tristrip.Scene.from_bytes(again.to_bytes("ply")).parts[0].faces) == count
    assert scene.simplify(ratio=0.001, error="100%", progress=stop, on_interrupt="return").interrupted
    with pytest.raises(TypeError, match="budget"):
        scene.simplify(ratio=0.5, budget=1)  # type: ignore[call-arg]
