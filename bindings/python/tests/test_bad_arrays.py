"""Invalid meshes, which must raise clear exceptions, and unusual arrays, which must work."""

from __future__ import annotations

import array
import datetime
import decimal
import resource
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pytest

import meshes
import oracle
import tristrip

MESH = meshes.torus(6, 5)


class Wrong(NamedTuple):
    """An argument and its expected error: where, what was found, what was expected."""

    name: str
    make: Callable[[], Any]
    error: type[tristrip.TristripError]
    text: str


def masked(values: Any, mask: Any) -> Any:
    return np.ma.MaskedArray(values, mask=mask)


def at(values: Any, place: Any, value: Any) -> Any:
    """Return a copy with one changed value."""
    changed = np.array(values)
    changed[place] = value
    return changed


class Lying:
    """An object whose conversion to an array fails."""

    def __array__(self, dtype: object = None, copy: object = None) -> Any:
        raise ValueError("not today")


MESH_ERROR, TYPE_ERROR = tristrip.MeshError, tristrip.ArrayTypeError
SHAPE = r"faces: found shape {}, expected shape \(n, 3\), \(n, k\) with k ≥ 3, or \(3 n,\)"
DTYPE = "faces: found dtype {}, expected an integer dtype"

WRONG_FACES = [
    Wrong("0-d", lambda: np.array(5), MESH_ERROR, SHAPE.format(r"\(\)")),
    Wrong("int", lambda: 5, TYPE_ERROR, "faces: found int, expected an array"),
    Wrong("two columns", lambda: MESH.faces[:, :2], MESH_ERROR, SHAPE.format(r"\(60, 2\)")),
    Wrong("one column", lambda: MESH.faces[:, :1], MESH_ERROR, SHAPE.format(r"\(60, 1\)")),
    Wrong("a face of nothing", lambda: [[]], MESH_ERROR, SHAPE.format(r"\(1, 0\)")),
    Wrong("no columns", lambda: np.zeros((4, 0), dtype=int), MESH_ERROR, SHAPE.format(r"\(4, 0\)")),
    Wrong("3-d", lambda: MESH.faces.reshape(6, 10, 3), MESH_ERROR, SHAPE.format(r"\(6, 10, 3\)")),
    Wrong(
        "flat, one left", lambda: MESH.faces.ravel()[:-2], MESH_ERROR, "faces: found 178 indices, expected three per"
    ),
    Wrong("float64", lambda: MESH.faces.astype(float), TYPE_ERROR, DTYPE.format("float64")),
    Wrong("float32", lambda: MESH.faces.astype(np.float32), TYPE_ERROR, DTYPE.format("float32")),
    Wrong("NaN", lambda: np.full((4, 3), np.nan), TYPE_ERROR, DTYPE.format("float64")),
    Wrong("complex", lambda: MESH.faces.astype(complex), TYPE_ERROR, DTYPE.format("complex128")),
    Wrong("bool", lambda: np.zeros((2, 3), dtype=bool), TYPE_ERROR, DTYPE.format("bool")),
    Wrong("text", lambda: MESH.faces.astype(str), TYPE_ERROR, DTYPE.format("<U21")),
    Wrong("bytes", lambda: MESH.faces.astype("S4"), TYPE_ERROR, DTYPE.format(r"\|S4")),
    Wrong("object", lambda: MESH.faces.astype(object), TYPE_ERROR, DTYPE.format("object")),
    Wrong("datetime", lambda: MESH.faces.astype("datetime64[s]"), TYPE_ERROR, DTYPE.format(r"datetime64\[s\]")),
    Wrong("timedelta", lambda: MESH.faces.astype("timedelta64[s]"), TYPE_ERROR, DTYPE.format(r"timedelta64\[s\]")),
    Wrong("records", lambda: np.zeros(3, dtype=[("a", int), ("b", int)]), TYPE_ERROR, r"faces: found dtype \[\('a'"),
    Wrong("negative", lambda: at(MESH.faces, (7, 2), -1), MESH_ERROR, "faces: found index -1 at face 7, corner 2, exp"),
    Wrong(
        "lowest", lambda: at(MESH.faces, (0, 1), -(2**63)), MESH_ERROR, "index -9223372036854775808 at face 0, corner 1"
    ),
    Wrong("2^32 - 1", lambda: at(MESH.faces, (3, 0), 2**32 - 1), MESH_ERROR, "index 4294967295 at face 3, corner 0"),
    Wrong(
        "2^63", lambda: at(MESH.faces.astype("u8"), (3, 0), 2**63), MESH_ERROR, "index 9223372036854775808 at face 3"
    ),
    Wrong(
        "flat, negative", lambda: at(MESH.faces.ravel(), 8, -9), MESH_ERROR, "faces: found index -9 at 8, expected 0 or"
    ),
    Wrong("huge int", lambda: [[0, 1, 2**70]], TYPE_ERROR, "faces: found dtype object, expected an integer dtype"),
    Wrong("None", lambda: None, TYPE_ERROR, "faces: found NoneType, expected an array"),
    Wrong("str", lambda: "0 1 2", TYPE_ERROR, "faces: found str, expected an array"),
    Wrong("dict", lambda: {0: [0, 1, 2]}, TYPE_ERROR, "faces: found dict, expected an array"),
    Wrong("set", lambda: {0, 1, 2}, TYPE_ERROR, "faces: found set, expected an array"),
    Wrong("generator", lambda: iter(MESH.faces), TYPE_ERROR, "faces: found iterator, expected an array"),
    Wrong("class", lambda: int, TYPE_ERROR, "faces: found type, expected an array"),
    Wrong("dates", lambda: [[datetime.date(2000, 1, 1)] * 3], TYPE_ERROR, "faces: found dtype object"),
    Wrong("decimals", lambda: [[decimal.Decimal(1)] * 3], TYPE_ERROR, "faces: found dtype object"),
    Wrong("Nones", lambda: [[0, 1, None]], TYPE_ERROR, "faces: found dtype object"),
    Wrong("texts", lambda: [["0", "1", "2"]], TYPE_ERROR, "faces: found dtype <U1"),
    Wrong("floats", lambda: [[0.0, 1.0, 2.0]], TYPE_ERROR, "faces: found dtype float64"),
    Wrong(
        "masked",
        lambda: masked(MESH.faces, MESH.faces == 3),
        MESH_ERROR,
        "faces: found masked values, expected an array",
    ),
    Wrong("fails", Lying, TYPE_ERROR, "faces: found Lying, expected an array: not today"),
    Wrong(
        "ragged, text",
        lambda: [[0, 1, 2], [0, 1, 2, "3"]],
        TYPE_ERROR,
        r"faces\[1\]: found dtype <U21, expected an int",
    ),
    Wrong("ragged, negative", lambda: [[0, 1, 2], [0, 1, 2, -3]], MESH_ERROR, r"faces\[1\]: found index -3 at 3"),
    Wrong("ragged, 2-d", lambda: [[0, 1, 2], [[0], [1], [2], [3]]], MESH_ERROR, r"faces\[1\]: found shape \(4, 1\)"),
    Wrong(
        "ragged, deep", lambda: [[[0, 1, 2]], [[0, 1], [2]]], MESH_ERROR, r"faces\[0\]: found shape \(1, 3\), expect"
    ),
    Wrong("mixed", lambda: [[0, 1, 2], 3], TYPE_ERROR, "faces: found list, expected an array"),
    Wrong("out of range", lambda: at(MESH.faces, (5, 1), 30), MESH_ERROR, "30"),
    Wrong("repeats 2^31", lambda: np.broadcast_to(np.int64(1), (2**31 // 3, 3)), MESH_ERROR, "view that repeats items"),
    Wrong("repeats rows", lambda: np.broadcast_to(np.array([0, 1, 2]), (2**30, 3)), MESH_ERROR, "view that repeats"),
    Wrong(
        "repeats flat", lambda: np.broadcast_to(np.uint32(1), (3 * 2**40,)), MESH_ERROR, "view that repeats items, of"
    ),
]

WRONG_VERTICES = [
    Wrong("0-d", lambda: np.array(5.0), MESH_ERROR, r"vertices: found shape \(\), expected two dimensions"),
    Wrong("1-d", lambda: MESH.vertices.ravel(), MESH_ERROR, r"vertices: found shape \(90,\), expected two dimensions"),
    Wrong(
        "3-d", lambda: MESH.vertices[None], MESH_ERROR, r"vertices: found shape \(1, 30, 3\), expected two dimensions"
    ),
    Wrong(
        "two columns",
        lambda: MESH.vertices[:, :2],
        MESH_ERROR,
        r"vertices: found shape \(30, 2\), expected shape \(n, 3\)",
    ),
    Wrong(
        "four columns",
        lambda: np.zeros((30, 4)),
        MESH_ERROR,
        r"vertices: found shape \(30, 4\), expected shape \(n, 3\)",
    ),
    Wrong(
        "NaN",
        lambda: at(MESH.vertices, (4, 1), np.nan),
        MESH_ERROR,
        "vertices: found nan at vertex 4, coordinate 1, ex",
    ),
    Wrong(
        "inf",
        lambda: at(MESH.vertices, (0, 2), -np.inf),
        MESH_ERROR,
        "vertices: found -inf at vertex 0, coordinate 2, e",
    ),
    Wrong(
        "1e39",
        lambda: at(MESH.vertices.astype(float), (9, 0), 1e39),
        MESH_ERROR,
        "found 1e.39 at vertex 9, coordinate 0",
    ),
    Wrong("complex", lambda: MESH.vertices * 1j, TYPE_ERROR, "vertices: found dtype complex64, expected numbers"),
    Wrong("text", lambda: MESH.vertices.astype(str), TYPE_ERROR, "vertices: found dtype <U32, expected numbers"),
    Wrong("object", lambda: MESH.vertices.astype(object), TYPE_ERROR, "vertices: found dtype object, expected numbers"),
    Wrong("bool", lambda: np.zeros((30, 3), dtype=bool), TYPE_ERROR, "vertices: found dtype bool, expected numbers"),
    Wrong(
        "datetime",
        lambda: np.zeros((30, 3), dtype="M8[s]"),
        TYPE_ERROR,
        r"vertices: found dtype datetime64\[s\], expect",
    ),
    Wrong("too few", lambda: MESH.vertices[:20], MESH_ERROR, "20"),
    Wrong("none", lambda: MESH.vertices[:0], MESH_ERROR, "0"),
    Wrong("ragged", lambda: [[0, 0, 0], [0, 0]], TYPE_ERROR, "vertices: found list, expected an array"),
    Wrong("str", lambda: "x", TYPE_ERROR, "vertices: found str, expected an array"),
    Wrong("dict", lambda: {"x": [1.0]}, TYPE_ERROR, "vertices: found dict, expected an array"),
    Wrong("masked", lambda: masked(MESH.vertices, MESH.vertices > 1), MESH_ERROR, "vertices: found masked values"),
    Wrong(
        "repeats", lambda: np.broadcast_to(np.float32(1), (2**31, 3)), MESH_ERROR, "vertices: found a view that repeats"
    ),
]

WRONG_INDICES = [
    Wrong("2-d", lambda: MESH.faces, MESH_ERROR, r"indices: found shape \(60, 3\), expected shape \(n,\)"),
    Wrong("0-d", lambda: np.array(5), MESH_ERROR, r"indices: found shape \(\), expected shape \(n,\)"),
    Wrong("float", lambda: np.zeros(6), TYPE_ERROR, "indices: found dtype float64, expected an integer dtype"),
    Wrong("negative", lambda: [0, 1, -1, 2], MESH_ERROR, "indices: found index -1 at 2, expected 0 or more"),
    Wrong(
        "wide",
        lambda: np.array([0, 1, 2**32]),
        MESH_ERROR,
        "indices: found index 4294967296 at 2, expected a 32-bit index",
    ),
    Wrong("None", lambda: None, TYPE_ERROR, "indices: found NoneType, expected an array"),
    Wrong(
        "repeats",
        lambda: np.broadcast_to(np.uint8(1), (2**31,)),
        MESH_ERROR,
        "indices: found a view that repeats items",
    ),
]


def raises(wrong: Wrong, call: Callable[[Any], object]) -> None:
    """Check that a call fails as expected, without allocating the size that an array declares."""
    argument = wrong.make()
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(wrong.error, match=wrong.text) as caught:
        call(argument)
    assert caught.type is wrong.error
    assert issubclass(wrong.error, (TypeError, ValueError))
    # Kilobytes on Linux. Other systems have larger or smaller units, which only shift the limit.
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - memory < 50_000


@pytest.mark.parametrize("wrong", WRONG_FACES, ids=lambda wrong: wrong.name)
def test_wrong_faces(wrong: Wrong) -> None:
    raises(wrong, lambda faces: tristrip.stripify(faces, MESH.vertices))
    if wrong.name != "out of range":
        raises(wrong, tristrip.stripify)
        raises(wrong, tristrip.stripify([[0, 1, 2]]).verify)


@pytest.mark.parametrize("wrong", WRONG_VERTICES, ids=lambda wrong: wrong.name)
def test_wrong_vertices(wrong: Wrong) -> None:
    raises(wrong, lambda vertices: tristrip.stripify(MESH.faces, vertices))
    raises(wrong, lambda vertices: tristrip.stripify([[0, 1, 2, 29], [0, 1, 2]], vertices))
    strips = tristrip.stripify(MESH.faces)
    raises(wrong, lambda vertices: strips.verify(MESH.faces, vertices))


@pytest.mark.parametrize("layout", ["list", "degenerate"])
@pytest.mark.parametrize("wrong", WRONG_INDICES, ids=lambda wrong: wrong.name)
def test_wrong_index_buffers(wrong: Wrong, layout: Any) -> None:
    raises(wrong, lambda indices: tristrip.Strips.from_indices(indices, layout))


def test_a_list_has_three_indices_per_triangle() -> None:
    with pytest.raises(tristrip.MeshError, match="5"):
        tristrip.Strips.from_indices([0, 1, 2, 3, 4], "list")


def strided(faces: Any) -> Any:
    wide = np.zeros((len(faces) * 2, 7), dtype=faces.dtype)
    wide[::2, 1:7:2] = faces
    return wide[::2, 1:7:2]


def read_only(faces: Any) -> Any:
    faces = faces.copy()
    faces.setflags(write=False)
    return faces


def unaligned(faces: Any) -> Any:
    data = np.zeros(faces.nbytes + 1, dtype=np.uint8)
    view = data[1:].view(faces.dtype).reshape(faces.shape)
    view[...] = faces
    return view


class Subclass(np.ndarray[Any, Any]):
    """A subclass of arrays."""


class Convertible:
    """An object that NumPy converts."""

    def __init__(self, values: Any) -> None:
        self.values = values

    def __array__(self, dtype: Any = None, copy: object = None) -> Any:
        return np.array(self.values, dtype=dtype)


UNUSUAL: dict[str, Callable[[Any], Any]] = {
    "strided": strided,
    "reversed": lambda faces: faces[::-1, ::-1][::-1, ::-1],
    "Fortran": np.asfortranarray,
    "transposed": lambda faces: np.ascontiguousarray(faces.T).T,
    "big-endian": lambda faces: faces.astype(">i4"),
    "big-endian, 64 bits": lambda faces: faces.astype(">u8"),
    "read-only": read_only,
    "read-only uint32": lambda faces: read_only(faces.astype(np.uint32)),
    "unaligned": lambda faces: unaligned(faces.astype(np.uint32)),
    "subclass": lambda faces: faces.view(Subclass),
    "matrix": lambda faces: faces.view(np.matrix),
    "masked nowhere": lambda faces: masked(faces, np.zeros(faces.shape, dtype=bool)),
    "masked without a mask": np.ma.MaskedArray,
    "memoryview": lambda faces: memoryview(faces.astype(np.int32)),
    "array.array": lambda faces: array.array("I", faces.ravel().tolist()),
    "bytearray": lambda faces: np.frombuffer(bytearray(faces.astype(np.uint8).tobytes()), dtype=np.uint8),
    "lists": lambda faces: faces.tolist(),
    "list of arrays": list,
    "tuple of lists": lambda faces: tuple(faces.tolist()),
    "list of tuples": lambda faces: [tuple(face) for face in faces.tolist()],
    "convertible": Convertible,
    "NumPy integers": lambda faces: [[np.int16(corner) for corner in face] for face in faces],
}


@pytest.mark.parametrize("name", UNUSUAL)
def test_unusual_faces_work(name: str) -> None:
    faces = UNUSUAL[name](MESH.faces)
    expected = tristrip.stripify(MESH.faces)
    assert tristrip.stripify(faces) == expected
    assert expected.verify(faces)["triangles"] == len(MESH.faces)


@pytest.mark.parametrize(
    "name", ["strided", "reversed", "Fortran", "read-only", "unaligned", "subclass", "matrix", "lists"]
)
@pytest.mark.parametrize("dtype", ["float32", "float64", ">f4"])
def test_unusual_vertices_work(name: str, dtype: str) -> None:
    vertices = UNUSUAL[name](MESH.vertices.astype(dtype))
    expected = tristrip.stripify(MESH.faces, MESH.vertices)
    assert tristrip.stripify(MESH.faces, vertices) == expected
    expected.verify(MESH.faces, vertices)


@pytest.mark.parametrize(
    "faces",
    [[], (), np.zeros((0, 3)), np.zeros((0, 3), dtype=np.uint32), np.zeros(0), np.zeros((0, 2))],
    ids=["list", "tuple", "no rows", "no rows of uint32", "flat", "2 columns"],
)
@pytest.mark.parametrize("vertices", [None, np.zeros((0, 3)), [], MESH.vertices])
def test_nothing_works(faces: Any, vertices: Any) -> None:
    strips = tristrip.stripify(faces, vertices, verify=True)
    assert len(strips) == 0
    assert strips.indices().tolist() == []
    assert strips.triangles().shape == (0, 3)
    assert strips.offsets.tolist() == [0]
    assert dict(strips.verify(faces, vertices)) == {"faces": 0, "triangles": 0}


@pytest.mark.parametrize("layout", ["restart", "degenerate", "list", "separate"])
@pytest.mark.parametrize("indices", [[], np.zeros(0, dtype=np.uint8), np.zeros(0)], ids=["list", "uint8", "float64"])
def test_an_empty_index_buffer(layout: Any, indices: Any) -> None:
    assert len(tristrip.Strips.from_indices(indices, layout)) == 0


@pytest.mark.parametrize("highest", [10**6, 2**31, 2**32 - 3])
def test_sparse_vertex_numbers(highest: int) -> None:
    """Few faces with large vertex indices take memory proportional to the number of faces."""
    faces = MESH.faces.copy()
    faces[faces == 29] = highest
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    strips = tristrip.stripify(faces, verify=True)
    oracle.assert_same_triangles(strips.triangles(), faces)
    assert strips.metrics()["strips"] == tristrip.stripify(MESH.faces).metrics()["strips"]
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - memory < 100_000
