"""View-dependent detail: models, views and camera flights."""

from __future__ import annotations

import copy
import pickle
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

import tristrip

Find = Callable[[str], Path]
FILTERS = ["none", "stss", "dtfs", "linked", "repair"]


def terrain(n: int = 60) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.int64]]:
    """Return hills over a square of n - 1 units from the origin, with y up."""
    x, z = np.meshgrid(np.arange(n), np.arange(n))
    y = np.sin(x / 3) * np.cos(z / 4)
    corner = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    lower = np.column_stack([corner, corner + n, corner + 1])
    upper = np.column_stack([corner + 1, corner + n, corner + n + 1])
    return np.column_stack([x.ravel(), y.ravel(), z.ravel()]).astype(np.float32), np.concatenate([lower, upper])


VERTICES, FACES = terrain()
MODEL = tristrip.ViewModel.build(VERTICES, FACES)


def overview(view: tristrip.View, pixels: float = 0.0) -> None:
    """Look at the whole terrain from above."""
    view.set_view((30, 90, 30), (30, 0, 30.001), pixels=pixels, frustum=False)


def test_a_model_has_the_mesh_and_its_strips() -> None:
    assert (MODEL.vertices == VERTICES).all()
    assert MODEL.triangle_count == len(MODEL.faces) == len(FACES)
    MODEL.strips.verify(FACES, VERTICES)
    report = MODEL.report
    assert report["method"] == "best"
    assert report["order"] == "quadric"
    assert report["proven"] is True
    assert report["triangles"] == len(FACES)
    assert report["collapses"] == MODEL.collapse_count
    assert report["height"] == MODEL.height > 5
    assert (report["levels"] or 0) > 5
    assert report["bytes"] is None
    assert 0 < MODEL.base_triangle_count < len(FACES) / 10
    assert MODEL.memory["strips"] > 0
    assert MODEL.memory["tree"] > MODEL.memory["strips"]


@pytest.mark.parametrize("name", FILTERS)
def test_a_view_draws_its_triangles(name: str) -> None:
    view = MODEL.view(name)  # type: ignore[arg-type]
    assert view.filter == name
    assert view.triangle_count == MODEL.base_triangle_count
    for step in range(12):
        eye = (5.0 * step, 4.0, -5.0 + 3 * step)
        moved = view.set_view(eye, (30, 0, 30), pixels=1.5)
        assert moved["complete"]
        assert moved["triangles"] == view.triangle_count == len(view.triangles())
        assert view.verify() == view.triangle_count
        used = np.unique(view.triangles())
        assert used.max() < len(VERTICES)
        assert len(used) <= view.active_vertex_count == moved["active_vertices"]
        assert (view.strips().triangles() == view.triangles()).all()


def test_the_finest_view_is_the_full_mesh() -> None:
    view = MODEL.view()
    overview(view)
    assert view.triangle_count == len(FACES)
    assert view.surface_error == 0
    view.strips().verify(FACES, VERTICES)


def test_near_triangles_are_finer_than_far_ones() -> None:
    view = MODEL.view()
    view.set_view((30, 3, -3), (30, 0, 60), pixels=4.0, frustum=False)
    z = VERTICES[view.triangles()].mean(axis=1)[:, 2]
    near, far = (z < 20).sum(), (z > 39).sum()
    assert near > 2 * far > 0
    assert view.surface_error > 0


def test_what_is_outside_or_looks_away_is_coarse() -> None:
    view = MODEL.view()
    ahead = view.set_view((30, 3, 30), (30, 2, 60), pixels=1.0)["triangles"]
    everywhere = view.set_view((30, 3, 30), (30, 2, 60), pixels=1.0, frustum=False)["triangles"]
    assert ahead < 0.7 * everywhere
    fovea = view.set_view((30, 3, 30), (30, 2, 60), pixels=1.0, foveation=1.0, attention=(0.5, 0.7))["triangles"]
    assert fovea < ahead
    shaded = view.set_view((30, 3, 30), (30, 2, 60), pixels=1.0, light=(0, -1, 0))["triangles"]
    assert shaded < ahead


def test_budgets_and_steps_are_kept() -> None:
    view = MODEL.view()
    for _ in range(5):
        view.set_view((30, 3, -3), (30, 0, 30), pixels=0.1, triangles=800)
    assert MODEL.base_triangle_count < view.triangle_count <= 800
    slow = MODEL.view()
    moved = slow.set_view((30, 3, -3), (30, 0, 30), pixels=0.1, steps=10)
    # The last split includes the splits that it needs.
    assert not moved["complete"]
    assert moved["collapses"] + moved["splits"] < 10 + MODEL.collapse_count / 10
    calls = 1
    while not slow.set_view((30, 3, -3), (30, 0, 30), pixels=0.1, steps=200)["complete"]:
        calls += 1
    assert calls > 2
    assert slow.verify() > 800


def test_a_direction_is_as_good_as_a_point() -> None:
    one, other = MODEL.view(), MODEL.view()
    one.set_view((30, 3, -3), (30, 0, 57), pixels=1.0)
    other.set_view(np.array([30.0, 3, -3]), direction=[0, -3, 60], pixels=1.0)
    assert abs(one.triangle_count - other.triangle_count) <= 4


@pytest.mark.parametrize("name", FILTERS)
@pytest.mark.parametrize("dtype", ["uint16", "uint32"])
def test_changed_ranges_bring_a_buffer_up_to_date(name: str, dtype: str) -> None:
    view = MODEL.view(name)  # type: ignore[arg-type]
    kept, changed = view.update(dtype)
    assert kept.dtype == dtype
    assert changed == [(0, len(kept))]
    sent, whole = 0, 0
    for step in range(40):
        view.set_view((10 + 0.3 * step, 3, -3), (30, 0, 30), pixels=1.5)
        if step % 3 == 2:
            continue
        buffer, changed = view.update(dtype)
        grown = np.full(len(buffer), np.iinfo(dtype).max, dtype)
        grown[: min(len(kept), len(buffer))] = kept[: len(buffer)]
        for start, end in changed:
            assert 0 <= start < end <= len(buffer)
            grown[start:end] = buffer[start:end]
            if step > 0:
                sent += end - start
        assert (grown == buffer).all()
        whole += len(buffer) if step > 0 else 0
        kept = buffer
        drawn = tristrip.Strips.from_indices(buffer)
        expected = view.triangles()
        found = drawn.triangles()
        assert len(found) == len(expected) == view.triangle_count
    assert name == "repair" or sent < whole / 2
    assert view.update(dtype)[1] == []


def test_indices_have_any_layout_and_type() -> None:
    view = MODEL.view()
    view.set_view((30, 3, -3), (30, 0, 30), pixels=2.0)
    assert view.indices().dtype == np.uint16
    assert view.indices(dtype="uint32").dtype == np.uint32
    assert view.indices("list").shape == (3 * view.triangle_count,)
    assert (view.indices("list").reshape(-1, 3) == view.triangles()).all()
    with pytest.raises(tristrip.ParameterError, match="dtype"):
        view.update("uint8")
    with pytest.raises(tristrip.ParameterError, match="dtype"):
        view.indices(dtype="int16")


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ({"look_at": (0, 0, 0)}, "look_at: found [0.0, 0.0, 0.0], the position of the camera"),
        ({}, "look_at, direction: expected exactly one"),
        ({"look_at": (1, 0, 0), "direction": (1, 0, 0)}, "look_at, direction: expected exactly one"),
        ({"direction": (0, 0, 0)}, "direction: found [0.0, 0.0, 0.0], expected a finite direction"),
        ({"direction": (float("nan"), 0, 0)}, "direction: found"),
        ({"look_at": (float("inf"), 0, 0)}, "look_at: found"),
        ({"look_at": (1, 0, 0), "up": (0, 0, 0)}, "up: found [0.0, 0.0, 0.0], expected a direction"),
        ({"look_at": (1, 0, 0), "field_of_view": 180}, "field_of_view: found 180, expected an angle"),
        ({"look_at": (1, 0, 0), "image": (0, 5)}, "image: found 0 by 5, expected at least 1 by 1"),
        ({"look_at": (1, 0, 0), "pixels": -1}, "pixels: found -1, expected 0 or more"),
        ({"look_at": (1, 0, 0), "pixels": float("nan")}, "pixels: found NaN"),
        ({"look_at": (1, 0, 0), "steps": 0}, "steps: found 0, expected at least 1"),
        ({"look_at": (1, 0, 0), "light": (0, 0, 0)}, "light: found [0.0, 0.0, 0.0], expected a direction"),
        ({"look_at": (1, 0, 0), "foveation": -1}, "foveation: found -1, expected a finite number of at least 0"),
        ({"look_at": (1, 0, 0), "foveation": 1, "attention": (2, 0)}, "attention: found [2.0, 0.0]"),
    ],
)
def test_wrong_cameras_are_told_and_change_nothing(arguments: dict[str, Any], text: str) -> None:
    view = MODEL.view()
    view.set_view((30, 3, -3), (30, 0, 30))
    before = view.triangle_count
    with pytest.raises(tristrip.ParameterError) as found:
        view.set_view((0, 0, 0), **arguments)
    assert str(found.value).startswith(text)
    assert view.triangle_count == before
    with pytest.raises((tristrip.ParameterError, TypeError)):
        view.set_view((0, 0, 0), (1, 0, 0), triangles=-1)


@given(st.lists(st.tuples(*[st.floats(-200, 200, width=32)] * 3), min_size=1, max_size=6), st.floats(0.05, 20))
def test_any_flight_leaves_a_mesh_that_is_proven(eyes: list[tuple[float, float, float]], pixels: float) -> None:
    view, fresh = MODEL.view(), MODEL.view()
    for eye in eyes:
        view.set_view(eye, (30.5, 0.5, 30.5), pixels=pixels)
        view.verify()
    fresh.set_view(eyes[-1], (30.5, 0.5, 30.5), pixels=pixels)
    # Splits for an earlier frame may remain: they are kept while their errors are above four fifths
    # of the limit.
    assert view.triangle_count >= fresh.triangle_count * 0.95


def test_files_and_pickles_hold_the_model(tmp_path: Path) -> None:
    path = tmp_path / "terrain.tlod"
    MODEL.save(path)
    assert path.read_bytes() == MODEL.to_bytes()
    for again in (tristrip.ViewModel.load(path), tristrip.ViewModel.load(path.read_bytes()), copy.deepcopy(MODEL)):
        assert (again.faces == MODEL.faces).all()
        assert again.strips == MODEL.strips
        view, other = again.view(), MODEL.view()
        for each in (view, other):
            each.set_view((30, 3, -3), (30, 0, 30))
        assert (view.triangles() == other.triangles()).all()
    pickled = pickle.loads(pickle.dumps(MODEL))
    assert pickled.to_bytes() == MODEL.to_bytes()
    assert pickled.report["levels"] == MODEL.report["levels"]
    with pytest.raises(TypeError):
        pickle.dumps(MODEL.view())


def test_damaged_files_are_told(tmp_path: Path, models: Path) -> None:
    data = (models / "fish_control.tlod").read_bytes()
    assert tristrip.ViewModel.load(data).triangle_count == 220
    for end in range(0, len(data), 97):
        with pytest.raises(tristrip.FormatError):
            tristrip.ViewModel.load(data[:end])
    for at in range(0, len(data), 97):
        damaged = bytearray(data)
        damaged[at] ^= 0x41
        with pytest.raises((tristrip.FormatError, tristrip.LimitError)):
            tristrip.ViewModel.load(damaged)
    with pytest.raises(tristrip.FileError):
        tristrip.ViewModel.load(tmp_path / "missing.tlod")
    with pytest.raises(tristrip.FileError):
        MODEL.save(tmp_path / "missing" / "a.tlod")


def test_models_of_files_join_parts(models: Path) -> None:
    model = tristrip.ViewModel.from_scene(models / "milktruck.glb", order="shortest-edge")
    assert model.report["parts"] == 4
    assert model.report["order"] == "shortest-edge"
    assert model.triangle_count == 2856
    assert set(model.attributes) == {"NORMAL"}
    assert any("parts joined into one: 4" in note for note in model.notes)
    for source in ((models / "milktruck.glb").read_bytes(), tristrip.load(models / "milktruck.glb")):
        assert tristrip.ViewModel.from_scene(source, order="shortest-edge").to_bytes() == model.to_bytes()
    with pytest.raises(tristrip.ParameterError, match="weld: found True"):
        tristrip.ViewModel.from_scene(models / "hand.ply", weld=True)
    with pytest.raises(TypeError, match=r"View.set_view\(\) got an unexpected keyword argument 'pixel'"):
        model.view().set_view((0, 0, 9), (0, 0, 0), pixel=1)  # type: ignore[call-arg]


def test_wrong_models_are_told() -> None:
    with pytest.raises(tristrip.ParameterError, match="order"):
        tristrip.ViewModel.build(VERTICES, FACES, order="random")  # type: ignore[arg-type]
    with pytest.raises(tristrip.ParameterError, match="filter: found `all`"):
        MODEL.view("all")  # type: ignore[arg-type]
    with pytest.raises(tristrip.MeshError):
        tristrip.ViewModel.build(VERTICES[:10], FACES)
    with pytest.raises(tristrip.ParameterError):
        tristrip.ViewModel.build(VERTICES, FACES, method="none")
    empty = tristrip.ViewModel.build(np.zeros((0, 3)), np.zeros((0, 3), int))
    view = empty.view()
    view.set_view((0, 0, 1), (0, 0, 0))
    assert view.triangle_count == 0
    assert view.indices().shape == (0,)
    assert view.update()[1] == []


def test_attributes_keep_their_seams() -> None:
    u = (VERTICES[:, 0] / 59).astype(np.float32)
    uv = np.column_stack([u, u])
    model = tristrip.ViewModel.build(VERTICES, FACES, uv=uv, attributes={"height": VERTICES[:, 1]})
    assert set(model.attributes) == {"TEXCOORD_0", "height"}
    assert (model.attributes["TEXCOORD_0"] == uv).all()


def test_pictures_and_texts_show_the_view() -> None:
    view = MODEL.view()
    assert view._repr_png_() is None
    with pytest.raises(tristrip.ParameterError, match="call set_view first"):
        view.picture()
    view.set_view((30, 20, -20), (30, 0, 30), image=(160, 90))
    png = view.picture()
    assert png.startswith(b"\x89PNG")
    assert png == view._repr_png_()
    assert png != view.picture(shaded=True)
    assert repr(view).startswith("View(")
    assert repr(view).endswith("of 6,962 triangles, filter dtfs)")
    assert repr(MODEL).startswith("ViewModel(6,962 triangles, ")
    assert "<table>" in MODEL._repr_html_()
    assert view.memory > 0


def test_copies_and_threads_have_views_of_their_own() -> None:
    view = MODEL.view()
    view.set_view((30, 3, -3), (30, 0, 30), pixels=2.0)
    other = copy.copy(view)
    view.set_view((30, 300, -300), (30, 0, 30), pixels=2.0)
    assert other.triangle_count > view.triangle_count
    other.verify()
    results: dict[int, int] = {}

    def fly(number: int) -> None:
        own = MODEL.view()
        for step in range(10):
            own.set_view((5.0 * step, 3, -3 + number), (30, 0, 30), pixels=1.0)
            view.set_view((5.0 * step, 3, -3 + number), (30, 0, 30), pixels=1.0)
        results[number] = own.verify()

    threads = [threading.Thread(target=fly, args=(number,)) for number in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(results) == 4
    assert all(results.values())
    view.verify()
