#!/usr/bin/env python3
"""Calls the package with arbitrary arguments, and fails on crashes, panics and wrong results.

    python tests/fuzz.py                                  1,000 examples of each target
    python tests/fuzz.py --target strips --examples 100000 --seed 7

The examples run in separate processes with limited memory, so that crashes are detected; the last
call is then printed. Every exception must be one of this package, or Python's for an argument of
the wrong type, and have a message. A target is a function that draws its arguments; `@target` adds
it.
"""

from __future__ import annotations

import argparse
import math
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeAlias

FOLDER = Path(__file__).resolve().parent
for _folder in (FOLDER.parent / "python", FOLDER):
    if str(_folder) not in sys.path:
        sys.path.insert(0, str(_folder))

import hypothesis  # noqa: E402
import numpy as np  # noqa: E402
from hypothesis import strategies as st  # noqa: E402
from hypothesis.extra import numpy as arrays  # noqa: E402

import meshes  # noqa: E402
import oracle  # noqa: E402
import tristrip  # noqa: E402
from stub import choices  # noqa: E402

#: Examples per process. Each process has another seed.
BATCH = 5_000
#: The memory limit of a process. An array that declares more must be rejected before allocation.
MEMORY_BYTES = 4 << 30
#: Health checks of hypothesis to suppress.
SLOW_BY_DESIGN = [
    hypothesis.HealthCheck.too_slow,
    hypothesis.HealthCheck.data_too_large,
    hypothesis.HealthCheck.filter_too_much,
]
#: The CPU time limit of an example in seconds. All examples are tiny.
SLOWEST = 20

Target: TypeAlias = Callable[[st.DataObject], None]
TARGETS: dict[str, Target] = {}

#: The file in which a process records the example before it runs, if any.
_note = int(os.environ.get("TRISTRIP_FUZZ_NOTE", "-1"))


def target(function: Target) -> Target:
    """Add a target under its name."""
    TARGETS[function.__name__] = function
    return function


def attempt(call: Callable[..., Any], *arguments: Any, **options: Any) -> Any:
    """Call something, and return its result, or None if it rejects the arguments as it should."""
    if _note >= 0:
        text = f"{call}(*{arguments!r}, **{options!r})\n".encode(errors="backslashreplace")
        os.ftruncate(_note, 0)
        os.pwrite(_note, text[:100_000], 0)
    started = time.process_time()
    try:
        return call(*arguments, **options)
    except tristrip.InternalError:
        raise
    except (tristrip.TristripError, TypeError, OverflowError, IndexError) as error:
        if not str(error):
            raise
        return None
    finally:
        assert time.process_time() - started < SLOWEST, "took too long"


# --- arguments

_SMALL = st.integers(0, 12)
_INTEGERS = st.one_of(
    _SMALL, st.integers(-3, 300), st.sampled_from([-1, 2**16, 2**31, 2**32 - 1, 2**63, -(2**63), 2**70])
)
_NUMBERS = st.one_of(_INTEGERS, st.floats(), st.sampled_from([1e39, -0.0, 1e-46]))
_SCALARS: st.SearchStrategy[Any] = st.one_of(
    st.none(),
    st.booleans(),
    _NUMBERS,
    st.text(max_size=4),
    st.binary(max_size=4),
    st.complex_numbers(),
    st.just(object()),
)
#: Objects of all kinds, mostly not arrays.
ANYTHING: st.SearchStrategy[Any] = st.recursive(
    _SCALARS, lambda inner: st.lists(inner, max_size=4) | st.tuples(inner, inner), max_leaves=8
)


def mostly(right: st.SearchStrategy[Any], wrong: st.SearchStrategy[Any] = ANYTHING) -> st.SearchStrategy[Any]:
    """Draw a valid value nine times out of ten."""
    return st.integers(0, 9).flatmap(lambda number: wrong if number == 9 else right)


_LISTS = st.lists(st.lists(_SMALL | _INTEGERS, max_size=6), max_size=12)
_SHAPES = st.one_of(
    st.tuples(st.integers(0, 30), st.just(3)),
    st.tuples(st.integers(0, 30)),
    arrays.array_shapes(min_dims=0, max_dims=4, min_side=0, max_side=6),
)


def _integer_arrays(dtype: np.dtype[Any]) -> st.SearchStrategy[Any]:
    information = np.iinfo(dtype)
    low, high = int(information.min), int(information.max)
    elements = _SMALL | st.integers(low, high) if high > 12 else st.integers(low, high)
    return arrays.arrays(dtype, _SHAPES, elements=elements if low else _SMALL)


_DTYPES = arrays.integer_dtypes(endianness="?") | arrays.unsigned_integer_dtypes(endianness="?")
_ARRAYS: st.SearchStrategy[Any] = st.one_of(
    _DTYPES.flatmap(_integer_arrays),
    _DTYPES.flatmap(lambda dtype: arrays.arrays(dtype, _SHAPES, elements=_SMALL)),
    arrays.arrays(arrays.floating_dtypes(endianness="?"), _SHAPES),
    arrays.arrays(arrays.scalar_dtypes(), _SHAPES),
    arrays.arrays(np.dtype(object), _SHAPES, elements=_SCALARS),
)


def _unaligned(array: Any) -> Any:
    if array.dtype.hasobject or not array.nbytes:
        return array
    view = np.zeros(array.nbytes + 1, dtype=np.uint8)[1:].view(array.dtype).reshape(array.shape)
    view[...] = array
    return view


def _read_only(array: Any) -> Any:
    array = array.copy()
    array.setflags(write=False)
    return array


class Subclass(np.ndarray[Any, Any]):
    """A subclass of arrays."""


_VIEWS: list[Callable[[Any], Any]] = [
    lambda array: array,
    lambda array: array[::-1] if array.ndim else array,
    lambda array: array[::2] if array.ndim else array,
    lambda array: array.T,
    lambda array: np.asfortranarray(array),
    lambda array: np.broadcast_to(array, (2, *array.shape)),
    lambda array: np.broadcast_to(array[:1], (2**33, *array.shape[1:])) if array.ndim and array.size else array,
    lambda array: np.ma.MaskedArray(array),
    lambda array: (
        np.ma.MaskedArray(array, mask=array == array.max()) if array.dtype.kind in "iu" and array.size else array
    ),
    lambda array: array.view(Subclass),
    lambda array: array.tolist(),
    list,
    _unaligned,
    _read_only,
]


@st.composite
def array_like(draw: st.DrawFn) -> Any:
    """Draw an array of any type, shape and layout, or something similar."""
    array = draw(_ARRAYS)
    if array.ndim == 0:
        return array
    return draw(st.sampled_from(_VIEWS))(array)


@st.composite
def faces_and_vertices(draw: st.DrawFn) -> tuple[Any, Any]:
    """Draw faces, and positions or None. Two thirds of them form meshes."""
    kind = draw(st.integers(0, 5))
    if kind <= 2:
        mesh = draw(meshes.meshes())
        faces: Any = draw(st.sampled_from(_VIEWS))(mesh.faces.astype(draw(st.sampled_from(["uint32", "int64", ">i4"]))))
        return faces, draw(st.sampled_from([None, mesh.vertices, mesh.vertices.astype(float).tolist()]))
    if kind == 3:
        vertices, polygons = draw(meshes.polygon_meshes())
        return polygons, draw(st.sampled_from([vertices, None, vertices[:-1]]))
    faces = draw(st.one_of(array_like(), _LISTS, ANYTHING))
    positions = st.one_of(
        arrays.arrays(np.float32, (13, 3), elements=st.floats(-4, 4, width=32)),
        arrays.arrays(np.float32, (13, 3), elements=st.floats(width=32)),
        array_like(),
        ANYTHING,
    )
    return faces, draw(st.none() | positions)


@st.composite
def strip_options(draw: st.DrawFn) -> dict[str, Any]:
    """Draw options of `stripify`, each valid, invalid, or of another method."""
    options: dict[str, Any] = {"method": draw(mostly(st.sampled_from(choices("Method"))))}
    names = st.sampled_from(OF_METHOD.get(str(options["method"]), ["seed"]) + EVERYWHERE)
    for name in sorted(
        draw(st.sets(mostly(names, st.sampled_from(sorted(_OPTIONS)) | st.text(max_size=6)), max_size=3))
    ):
        options[name] = draw(mostly(_OPTIONS.get(name, ANYTHING)))
    return options


EVERYWHERE = ["verify", "budget", "on_interrupt", "progress"]
OF_METHOD = {
    "best": ["effort", "cost", "seed"],
    "fewest": ["effort", "seed"],
    "cache": ["effort", "vertex_cache", "objective", "seed"],
    "tunnel": ["tunnel_length"],
    "eta": ["tunnel_length", "threshold", "seed"],
    "guided-tunnels": ["tunnel_length", "threshold", "seed"],
    "quad-rows": ["cutoff", "seed"],
    "stripe-global": ["cutoff", "seed"],
}
_OPTIONS: dict[str, st.SearchStrategy[Any]] = {
    "effort": st.integers(0, 4),
    "cost": st.sampled_from(choices("Cost")),
    "weld": st.booleans(),
    "verify": st.booleans(),
    "budget": st.floats(0, 0.01) | _NUMBERS,
    "on_interrupt": st.sampled_from(choices("OnInterrupt")),
    "progress": st.sampled_from([None, False, str]),
    "seed": _INTEGERS,
    "vertex_cache": st.sampled_from(["fifo:16", "lru:3", "fifo:0", "lru"]),
    "objective": st.sampled_from(["balanced", "misses", "indices"]),
    "tunnel_length": _INTEGERS,
    "threshold": _INTEGERS,
    "cutoff": _INTEGERS,
}
_LAYOUTS = mostly(st.sampled_from(choices("Layout")))
_INDEX_DTYPES = mostly(st.sampled_from(["uint8", "uint16", "uint32", None]))


# --- targets


@target
def strips(data: st.DataObject) -> None:
    """Draw arguments of `stripify`, and use its result."""
    faces, vertices = data.draw(faces_and_vertices())
    options = data.draw(strip_options())
    result = attempt(tristrip.stripify, faces, vertices, **options)
    if result is None:
        return
    drawn = result.triangles()
    given = None if _is_ragged(faces) else np.ma.getdata(np.asarray(faces))
    if given is not None and (given.ndim == 1 or given.size == 0 or given.shape[1] == 3) and not options.get("weld"):
        oracle.assert_same_triangles(drawn, given.astype(np.int64) if given.size else [])
    assert result.verify(faces, vertices)["triangles"] == len(drawn)
    _use(result, data)


def _is_ragged(faces: Any) -> bool:
    return isinstance(faces, (list, tuple)) and len({len(face) for face in faces if hasattr(face, "__len__")}) > 1


@target
def index_buffers(data: st.DataObject) -> None:
    """Draw arguments of `Strips.from_indices`, and use its result."""
    flat = st.lists(_SMALL | st.sampled_from([255, 65535, 2**32 - 1]), max_size=40)
    indices = data.draw(st.one_of(flat, flat.map(lambda rows: np.array(rows, dtype=np.int64)), array_like(), ANYTHING))
    layout = data.draw(_LAYOUTS)
    result = attempt(tristrip.Strips.from_indices, indices, layout)
    if result is None:
        return
    array = np.asarray(indices)
    if layout == "list" and array.size:
        oracle.assert_same_triangles(result.triangles(), array.astype(np.int64))
    attempt(result.verify, data.draw(st.just(result.triangles()) | array_like()))
    _use(result, data)


def _use(result: Any, data: st.DataObject) -> None:
    """Call every method of strips."""
    layout, dtype = data.draw(_LAYOUTS), data.draw(_INDEX_DTYPES)
    indices = attempt(result.indices, layout, dtype=dtype)
    if indices is not None:
        oracle.assert_same_triangles(oracle.expand(indices, layout, result.offsets), result.triangles())
    assert result.metrics()["triangles"] == len(result.triangles())
    assert sum(map(len, result)) == len(result.vertices)
    attempt(result.vertex_cache, data.draw(mostly(st.sampled_from(["fifo:16", "lru:3"]))))
    attempt(result.__getitem__, data.draw(st.integers(-len(result), len(result)) | _INTEGERS))
    assert repr(result).startswith("Strips(")
    assert result == result.__reduce__()[0](*result.__reduce__()[1])


@target
def simplified(data: st.DataObject) -> None:
    """Draw arguments of `simplify`."""
    faces, vertices = data.draw(faces_and_vertices())
    options: dict[str, Any] = {}
    for name in sorted(data.draw(st.sets(st.sampled_from(sorted(_GOALS)), max_size=3))):
        options[name] = data.draw(mostly(_GOALS[name]))
        small = isinstance(vertices, np.ndarray) and vertices.ndim > 0 and vertices.size < 1000
        if name in _COLUMNS and small and data.draw(st.booleans()):
            rows, columns = len(vertices), _COLUMNS[name]
            options[name] = np.linspace(0, 1, rows * columns).reshape(rows, columns)
    result = attempt(tristrip.simplify, vertices, faces, **options)
    if result is None:
        return
    assert result.faces.shape == (len(result.faces), 3)
    assert not len(result.faces) or result.faces.max() < len(result.vertices)
    assert np.isfinite(result.vertices).all()
    for array in result.attributes.values():
        assert len(array) == len(result.vertices)
    attempt(tristrip.stripify, result.faces, result.vertices, verify=True)
    assert repr(result).startswith("Simplified(")


_COLUMNS = {"normals": 3, "uv": 2, "colors": 4}
_GOALS: dict[str, st.SearchStrategy[Any]] = {
    "ratio": st.floats(0, 1) | _NUMBERS,
    "triangles": _INTEGERS,
    "error": st.floats(0, 1) | _NUMBERS | st.sampled_from(["1%", "100%", "x"]),
    "normals": array_like() | arrays.arrays(np.float32, (13, 3), elements=st.floats(-1, 1, width=32)),
    "uv": array_like() | arrays.arrays(np.float32, (13, 2), elements=st.floats(-1, 1, width=32)),
    "colors": array_like() | arrays.arrays(np.uint8, (13, 4)),
    "attributes": st.dictionaries(st.text(max_size=3), array_like() | arrays.arrays(np.float64, 13), max_size=2),
    "weight": st.text(max_size=8) | st.sampled_from(["normal=0.5,uv=2", "uv=-1", "normal"]),
    "price": st.sampled_from(["distance", "planes", "quadric"]),
    "permissive": st.booleans(),
    "lock_borders": st.booleans(),
    "weld_distance": _NUMBERS | st.just("1%"),
    "normals_mode": st.sampled_from(["auto", "keep", "rebuild"]),
    "measure": st.booleans(),
    "fit": st.booleans(),
    "on_interrupt": st.sampled_from(choices("OnInterrupt")),
}


@target
def levels(data: st.DataObject) -> None:
    """Draw arguments of `Levels`, and change its level."""
    faces, vertices = data.draw(faces_and_vertices())
    options: dict[str, Any] = {}
    for name in sorted(data.draw(st.sets(st.sampled_from(sorted(_OF_LEVELS)), max_size=3))):
        options[name] = data.draw(mostly(_OF_LEVELS[name]))
    result = attempt(tristrip.Levels, vertices, faces, **options)
    if result is None:
        return
    full = result.triangles().astype(np.int64)
    moves = [
        (
            result.set_level,
            [data.draw(mostly(st.integers(0, result.last_level) | st.sampled_from(["0%", "50%", "x"])))],
        ),
        (result.set_triangles, [data.draw(_INTEGERS)]),
        (result.set_error, [data.draw(_NUMBERS | st.just("1%"))]),
        (result.set_pixels, [data.draw(_NUMBERS), data.draw(_NUMBERS)]),
    ]
    for move, arguments in moves:
        attempt(move, *arguments)
        result.verify()
        renamed = result.renaming().astype(np.int64)[full] if len(full) else full
        oracle.assert_same_triangles(result.triangles(), renamed)
        assert result.triangle_count == len(result.triangles())
    attempt(result.update, data.draw(_LAYOUTS), data.draw(_INDEX_DTYPES))
    attempt(result.table, data.draw(_INTEGERS))
    assert repr(result).startswith("Levels(")


_OF_LEVELS: dict[str, st.SearchStrategy[Any]] = {
    "model": st.sampled_from(choices("LevelModel")),
    "base": st.floats(0, 1) | _NUMBERS,
    "price": st.sampled_from(["distance", "planes", "quadric"]),
    "method": st.sampled_from(choices("Method")),
    "effort": st.integers(0, 4),
    "uv": array_like() | arrays.arrays(np.float32, (13, 2), elements=st.floats(-1, 1, width=32)),
    "verify": st.booleans(),
}


@target
def scenes(data: st.DataObject) -> None:
    """Draw a scene of arrays, and write it in every format."""
    faces, vertices = data.draw(faces_and_vertices())
    options: dict[str, Any] = {}
    for name in sorted(data.draw(st.sets(st.sampled_from(["normals", "uv", "colors"]), max_size=2))):
        options[name] = data.draw(mostly(_GOALS[name]))
    scene = attempt(tristrip.Scene.from_arrays, vertices, faces, **options)
    if scene is None:
        return
    for result in (scene, attempt(scene.strip, method="sequential"), attempt(scene.simplify, ratio=0.5, measure=False)):
        if result is None:
            continue
        written = attempt(result.to_bytes, data.draw(mostly(st.sampled_from(["glb", "ply", "obj"]))))
        if written is not None:
            attempt(tristrip.Scene.from_bytes, written[: data.draw(st.integers(0, len(written)))])


@target
def pickles(data: st.DataObject) -> None:
    """Draw the bytes of a pickle: modified, truncated or arbitrary."""
    mesh = data.draw(meshes.meshes())
    reduced: Any = tristrip.stripify(mesh.faces, effort=0).__reduce__()
    restore, (state,) = reduced
    changed = bytearray(state)
    for _ in range(data.draw(st.integers(1, 4))):
        if changed:
            changed[data.draw(st.integers(0, len(changed) - 1))] = data.draw(st.integers(0, 255))
    cut = data.draw(st.integers(0, len(changed)))
    for given in (bytes(changed), bytes(changed[:cut]), data.draw(st.binary(max_size=20))):
        result = attempt(restore, given)
        if result is not None:
            _use(result, data)


# --- processes


def run_batch(name: str, examples: int, seed: int) -> None:
    """Run examples of a target in this process."""
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, resource.getrlimit(resource.RLIMIT_AS)[1]))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    tristrip.set_threads(2)

    @hypothesis.seed(seed)
    @hypothesis.settings(
        max_examples=examples,
        database=None,
        deadline=None,
        derandomize=False,
        print_blob=False,
        suppress_health_check=SLOW_BY_DESIGN,
    )
    @hypothesis.given(st.data())
    def test(data: st.DataObject) -> None:
        TARGETS[name](data)

    with np.errstate(all="ignore"):
        test()


def run_target(name: str, examples: int, seed: int) -> bool:
    """Run examples of a target in processes, print failures, and return whether all passed."""
    started = time.monotonic()
    for number in range(math.ceil(examples / BATCH)):
        count = min(BATCH, examples - number * BATCH)
        with tempfile.TemporaryFile() as note:
            command = [sys.executable, "-W", "ignore", __file__, "--batch", name, str(count), str(seed + number)]
            environment = {**os.environ, "TRISTRIP_FUZZ_NOTE": str(note.fileno()), "RUST_BACKTRACE": "0"}
            done = subprocess.run(
                command, env=environment, pass_fds=[note.fileno()], capture_output=True, text=True, check=False
            )
            if done.returncode != 0:
                note.seek(0)
                last = note.read().decode(errors="replace")
                print(f"{name}: FAILED with status {done.returncode}, seed {seed + number}, last call:\n{last}")
                print(done.stdout + done.stderr)
                return False
    print(f"{name}: {examples:,} examples, no failure, {time.monotonic() - started:.0f} s", flush=True)
    return True


def main() -> int:
    """Run the command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n\n")[0])
    parser.add_argument("--target", action="append", choices=sorted(TARGETS), help="default: all")
    parser.add_argument("--examples", type=int, default=1000, help="examples per target (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=0, help="of the first process (default: %(default)s)")
    parser.add_argument("--batch", nargs=3, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.batch:
        name, examples, seed = arguments.batch
        run_batch(name, int(examples), int(seed))
        return 0
    passed = [run_target(name, arguments.examples, arguments.seed) for name in arguments.target or TARGETS]
    return 0 if all(passed) else 1


if __name__ == "__main__":
    sys.exit(main())
