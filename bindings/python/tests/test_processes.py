"""Threads, forks, pickles and copies."""

from __future__ import annotations

import copy
import gc
import multiprocessing
import pickle
import sys
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest

import meshes
import oracle
import tristrip

ERRORS = [
    error
    for name in tristrip.__all__
    if isinstance(error := getattr(tristrip, name), type)
    and issubclass(error, BaseException)
    and not issubclass(error, Warning)
]


def strips_of(seed: int) -> bytes:
    """Strip a mesh, in a separate thread or process."""
    mesh = meshes.shuffled(meshes.torus(30, 20), np.random.default_rng(seed))
    strips = tristrip.stripify(mesh.faces, mesh.vertices, effort=2)
    strips.verify(mesh.faces)
    return strips.indices().tobytes()


def test_threads_have_the_same_results() -> None:
    expected = [strips_of(seed) for seed in range(4)]
    with ThreadPoolExecutor(8) as executor:
        results = list(executor.map(strips_of, [seed for seed in range(4) for _ in range(8)]))
    assert results == [result for result in expected for _ in range(8)]


def test_threads_share_strips() -> None:
    mesh = meshes.torus(30, 20)
    strips = tristrip.stripify(mesh.faces)

    def use(_: int) -> tuple[bytes, int, Any]:
        return strips.indices("degenerate").tobytes(), len(strips.triangles()), dict(strips.metrics())

    with ThreadPoolExecutor(8) as executor:
        results = list(executor.map(use, range(64)))
    assert all(result == results[0] for result in results)


def test_threads_change_the_number_of_threads() -> None:
    def run(number: int) -> bytes:
        tristrip.set_threads(1 + number % 3)
        return strips_of(1)

    try:
        with ThreadPoolExecutor(8) as executor:
            results = set(executor.map(run, range(24)))
    finally:
        tristrip.set_threads(None)
    assert results == {strips_of(1)}


@pytest.mark.parametrize("method", ["fork", "spawn"])
# A warning of Python 3.12 and later about forks of processes with threads.
@pytest.mark.filterwarnings("ignore:.*use of fork:DeprecationWarning")
def test_processes(method: str) -> None:
    if method not in multiprocessing.get_all_start_methods():
        pytest.skip(f"this system has no {method}")
    expected = [strips_of(seed) for seed in range(2)]
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context(method)) as executor:
        # Otherwise a forked process would wait forever for threads that it does not have.
        assert list(executor.map(strips_of, range(2), timeout=60)) == expected
    assert strips_of(0) == expected[0]


def test_strips_of_other_processes() -> None:
    faces = meshes.torus(5, 5).faces
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as executor:
        strips = executor.submit(tristrip.stripify, faces, method="cache", verify=True).result(60)
    assert strips == tristrip.stripify(faces, method="cache", verify=True)


@pytest.mark.parametrize("protocol", range(2, pickle.HIGHEST_PROTOCOL + 1))
@pytest.mark.parametrize("mesh", meshes.examples(), ids=lambda mesh: mesh.name)
def test_strips_pickle(mesh: meshes.GeneratedMesh, protocol: int) -> None:
    strips = tristrip.stripify(mesh.faces, verify=True, effort=1)
    restored = pickle.loads(pickle.dumps(strips, protocol))
    assert type(restored) is tristrip.Strips
    assert restored == strips
    for name in ["method", "stopped", "notes", "proven"]:
        assert getattr(restored, name) == getattr(strips, name)
    assert restored.metrics() == strips.metrics()
    oracle.assert_same_triangles(restored.triangles(), mesh.faces)


def test_welded_strips_pickle() -> None:
    mesh = meshes.grid(3, 3)
    vertices, faces = mesh.vertices[mesh.faces.ravel()], np.arange(mesh.faces.size).reshape(-1, 3)
    strips = tristrip.stripify(faces, vertices, weld=True)
    restored = pickle.loads(pickle.dumps(strips))
    assert restored == strips
    assert restored.verify(faces, vertices)["triangles"] == len(faces)


def test_copies() -> None:
    strips = tristrip.stripify([[0, 1, 2], [2, 1, 3]])
    for copied in [copy.copy(strips), copy.deepcopy(strips), copy.deepcopy({"key": [strips]})["key"][0]]:
        assert copied == strips
        assert copied.notes == strips.notes


@pytest.mark.parametrize("data", [b"", b"{}", b"[1]", b'{"strips": 5}', b"\xff" * 9])
def test_damaged_pickles(data: bytes) -> None:
    restore = getattr(tristrip.Strips, "_restore")  # noqa: B009
    with pytest.raises(tristrip.ParameterError, match="pickle: "):
        restore(data)


@pytest.mark.parametrize("error", ERRORS, ids=lambda error: error.__name__)
def test_exceptions(error: type[BaseException]) -> None:
    """Exceptions have the given text, can be pickled, and are subclasses of Python's exceptions."""
    assert error.__module__ == "tristrip"
    assert error.__doc__
    if error is tristrip.Interrupted:
        assert issubclass(error, KeyboardInterrupt)
        made: BaseException = error(best=[1, 2])
        assert pickle.loads(pickle.dumps(made)).best == [1, 2]
    elif error is tristrip.FileError:
        made = error(2, "No such file or directory", "model.ply")
        restored = pickle.loads(pickle.dumps(made))
        assert (restored.errno, restored.strerror, restored.filename) == (2, "No such file or directory", "model.ply")
    else:
        made = error("faces: found 5, expected 3")
        assert str(made) == "faces: found 5, expected 3"
    restored = pickle.loads(pickle.dumps(made))
    assert type(restored) is error
    assert (str(restored), restored.args) == (str(made), made.args)
    assert issubclass(error, tristrip.TristripError) or error is tristrip.Interrupted


def test_bases_of_exceptions() -> None:
    for error, base in [
        (tristrip.ParameterError, ValueError),
        (tristrip.MeshError, ValueError),
        (tristrip.FormatError, ValueError),
        (tristrip.LimitError, ValueError),
        (tristrip.ArrayTypeError, TypeError),
        (tristrip.FileError, OSError),
        (tristrip.InternalError, RuntimeError),
    ]:
        assert issubclass(error, base)


def test_nothing_is_leaked() -> None:
    faces = meshes.torus(20, 20).faces.astype(np.uint32)
    strips = tristrip.stripify(faces)
    gc.collect()
    before = sys.getrefcount(faces)
    for _ in range(50):
        strips.verify(faces)
        tristrip.stripify(faces)
        with pytest.raises(tristrip.MeshError):
            tristrip.stripify(faces[:, :2])
    gc.collect()
    assert sys.getrefcount(faces) == before
