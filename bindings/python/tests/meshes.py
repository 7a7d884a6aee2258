"""Meshes for tests: read from files, generated, or drawn by hypothesis."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt
from hypothesis import strategies as st

Positions: TypeAlias = npt.NDArray[np.float32]
Triangles: TypeAlias = npt.NDArray[np.int64]
Polygons: TypeAlias = list[list[int]]


@dataclass(frozen=True)
class GeneratedMesh:
    """A triangle mesh and its origin."""

    name: str
    vertices: Positions
    faces: Triangles

    def __repr__(self) -> str:
        return f"GeneratedMesh({self.name}, vertices={self.vertices.tolist()}, faces={self.faces.tolist()})"


# --- files

_PLY_TYPES = {
    "char": "i1",
    "int8": "i1",
    "uchar": "u1",
    "uint8": "u1",
    "short": "i2",
    "int16": "i2",
    "ushort": "u2",
    "uint16": "u2",
    "int": "i4",
    "int32": "i4",
    "uint": "u4",
    "uint32": "u4",
    "float": "f4",
    "float32": "f4",
    "double": "f8",
    "float64": "f8",
}


def read_model(path: Path) -> tuple[Positions, Polygons]:
    """Read positions and polygons of an OBJ or a binary little-endian PLY (a subset)."""
    return _read_obj(path) if path.suffix == ".obj" else _read_ply(path)


def _read_obj(path: Path) -> tuple[Positions, Polygons]:
    positions: list[list[float]] = []
    polygons: Polygons = []
    for line in path.read_text(encoding="utf-8").splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            positions.append([float(word) for word in words[1:4]])
        elif words[:1] == ["f"]:
            polygons.append([int(word.split("/")[0]) - 1 for word in words[1:]])
    return np.array(positions, dtype=np.float32), polygons


def _read_ply(path: Path) -> tuple[Positions, Polygons]:
    data = path.read_bytes()
    at = data.index(b"end_header\n") + len(b"end_header\n")
    header = [line.split() for line in data[:at].decode("ascii").splitlines()]
    assert ["format", "binary_little_endian", "1.0"] in header
    positions: Positions = np.zeros((0, 3), dtype=np.float32)
    polygons: Polygons = []
    elements: list[tuple[str, int, list[list[str]]]] = []
    for words in header:
        if words[0] == "element":
            elements.append((words[1], int(words[2]), []))
        elif words[0] == "property":
            elements[-1][2].append(words[1:])
    for name, count, properties in elements:
        if name == "vertex":
            row = np.dtype([(words[1], "<" + _PLY_TYPES[words[0]]) for words in properties])
            rows = np.frombuffer(data, row, count, at)
            positions = np.column_stack([rows["x"], rows["y"], rows["z"]]).astype(np.float32)
            at += row.itemsize * count
        elif name == "face":
            ((_, size_type, index_type, _),) = properties
            size, index = np.dtype("<" + _PLY_TYPES[size_type]), np.dtype("<" + _PLY_TYPES[index_type])
            for _ in range(count):
                corners = int(np.frombuffer(data, size, 1, at)[0])
                at += size.itemsize
                polygons.append(np.frombuffer(data, index, corners, at).tolist())
                at += index.itemsize * corners
    return positions, polygons


def triangles_of(polygons: Polygons) -> Triangles:
    """Return polygons that are all triangles as an array."""
    return np.array(polygons, dtype=np.int64).reshape(-1, 3)


# --- generated


def grid(width: int, height: int) -> GeneratedMesh:
    """Build an open grid of width × height squares, each of two triangles."""
    corners = grid_quads(width, height)
    x, y = np.meshgrid(np.arange(width + 1), np.arange(height + 1))
    vertices = np.column_stack([x.ravel(), y.ravel(), np.sin(x.ravel()) * np.cos(y.ravel())])
    return GeneratedMesh(f"grid {width} x {height}", vertices.astype(np.float32), _halves(corners))


def grid_quads(width: int, height: int) -> Triangles:
    """Return the squares of the grid: shape (width height, 4)."""
    x, y = np.meshgrid(np.arange(width), np.arange(height))
    corner = (y * (width + 1) + x).ravel().astype(np.int64)
    return np.column_stack([corner, corner + 1, corner + width + 2, corner + width + 1])


def _halves(quads: Triangles) -> Triangles:
    return np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]], axis=1).reshape(-1, 3)


def torus(width: int, height: int) -> GeneratedMesh:
    """Build a closed torus with width × height squares, where width and height are at least 3."""
    x, y = (part.ravel() for part in np.meshgrid(np.arange(width), np.arange(height)))

    def at(right: int, up: int) -> Triangles:
        return ((y + up) % height * width + (x + right) % width).astype(np.int64)

    quads = np.column_stack([at(0, 0), at(1, 0), at(1, 1), at(0, 1)])
    u, v = 2 * np.pi * x / width, 2 * np.pi * y / height
    ring = 2 + np.cos(v)
    vertices = np.column_stack([ring * np.cos(u), ring * np.sin(u), np.sin(v)])
    return GeneratedMesh(f"torus {width} x {height}", vertices.astype(np.float32), _halves(quads))


def sphere(divisions: int) -> GeneratedMesh:
    """Build a closed sphere by subdividing an octahedron this many times."""
    points: list[tuple[float, ...]] = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
    faces = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
    for _ in range(divisions):
        middles: dict[tuple[int, int], int] = {}

        def middle(a: int, b: int, known: dict[tuple[int, int], int] = middles) -> int:
            key = (min(a, b), max(a, b))
            if key not in known:
                point = np.add(points[a], points[b])
                points.append(tuple(point / np.linalg.norm(point)))
                known[key] = len(points) - 1
            return known[key]

        divided = []
        for a, b, c in faces:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            divided += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        faces = divided
    return GeneratedMesh(f"sphere {divisions}", np.array(points, dtype=np.float32), np.array(faces, dtype=np.int64))


def fan(triangles: int) -> GeneratedMesh:
    """Build triangles that share one edge, which is non-manifold if there are more than two."""
    apexes = np.arange(2, triangles + 2)
    faces = np.column_stack([np.zeros_like(apexes), np.ones_like(apexes), apexes]).astype(np.int64)
    angles = np.linspace(0, np.pi, triangles)
    ring = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(triangles)])
    vertices = np.concatenate([np.array([[0, 0, 0], [0, 0, 1]]), ring])
    return GeneratedMesh(f"fan {triangles}", vertices.astype(np.float32), faces)


def empty() -> GeneratedMesh:
    """Build a mesh without vertices and faces."""
    return GeneratedMesh("empty", np.zeros((0, 3), dtype=np.float32), np.zeros((0, 3), dtype=np.int64))


def soup(triangles: int, vertices: int, seed: int) -> GeneratedMesh:
    """Build random triangles over few vertices: non-manifold, degenerate, repeated, any winding."""
    random = np.random.default_rng(seed)
    points = random.normal(size=(vertices, 3)).astype(np.float32)
    return GeneratedMesh(
        f"soup {triangles} over {vertices}", points, random.integers(0, vertices, (triangles, 3), dtype=np.int64)
    )


def joined(meshes: list[GeneratedMesh]) -> GeneratedMesh:
    """Combine meshes as separate components."""
    faces, points, base = [empty().faces], [empty().vertices], 0
    for number, mesh in enumerate(meshes):
        faces.append(mesh.faces + base)
        points.append(mesh.vertices + np.float32(4 * number))
        base += len(mesh.vertices)
    name = " + ".join(mesh.name for mesh in meshes) or "nothing"
    return GeneratedMesh(name, np.concatenate(points), np.concatenate(faces))


# --- modifications that keep a mesh a list of triangles


def flipped(mesh: GeneratedMesh, random: np.random.Generator) -> GeneratedMesh:
    """Flip the winding of a third of the faces."""
    faces = mesh.faces.copy()
    chosen = random.random(len(faces)) < 1 / 3
    faces[chosen] = faces[chosen][:, [0, 2, 1]]
    return GeneratedMesh(f"{mesh.name}, flipped", mesh.vertices, faces)


def with_duplicates(mesh: GeneratedMesh, random: np.random.Generator) -> GeneratedMesh:
    """Repeat some faces."""
    chosen = random.random(len(mesh.faces)) < 0.2
    return GeneratedMesh(f"{mesh.name}, duplicates", mesh.vertices, np.concatenate([mesh.faces, mesh.faces[chosen]]))


def with_degenerates(mesh: GeneratedMesh, random: np.random.Generator) -> GeneratedMesh:
    """Make some faces repeat a vertex, so that they draw nothing."""
    faces = mesh.faces.copy()
    chosen = random.random(len(faces)) < 0.2
    faces[chosen, 1] = faces[chosen, 0]
    return GeneratedMesh(f"{mesh.name}, degenerates", mesh.vertices, faces)


def with_holes(mesh: GeneratedMesh, random: np.random.Generator) -> GeneratedMesh:
    """Remove half of the faces, so that some are isolated."""
    return GeneratedMesh(f"{mesh.name}, holes", mesh.vertices, mesh.faces[random.random(len(mesh.faces)) < 0.5])


def shuffled(mesh: GeneratedMesh, random: np.random.Generator) -> GeneratedMesh:
    """Shuffle the faces, and rotate each to a random first corner."""
    faces = random.permutation(mesh.faces, axis=0) if len(mesh.faces) else mesh.faces
    first = random.integers(0, 3, (len(faces), 1))
    return GeneratedMesh(
        f"{mesh.name}, shuffled", mesh.vertices, np.take_along_axis(faces, (first + np.arange(3)) % 3, axis=1)
    )


def sparse(mesh: GeneratedMesh, random: np.random.Generator) -> GeneratedMesh:
    """Renumber the vertices with gaps."""
    count = len(mesh.vertices)
    numbers = np.sort(random.choice(3 * count + 1, count, replace=False)).astype(np.int64)
    points = np.zeros((3 * count + 1, 3), dtype=np.float32)
    points[numbers] = mesh.vertices
    return GeneratedMesh(f"{mesh.name}, sparse", points, numbers[mesh.faces])


CHANGES = [flipped, with_duplicates, with_degenerates, with_holes, shuffled, sparse]


def examples() -> list[GeneratedMesh]:
    """Return one small mesh of each kind, for parametrized tests."""
    random = np.random.default_rng(1)
    plain = [empty(), grid(1, 1), grid(7, 5), torus(5, 4), sphere(2), fan(5), soup(40, 12, seed=2)]
    plain.append(joined([grid(3, 2), sphere(1), fan(3), grid(1, 1)]))
    return plain + [change(torus(6, 5), random) for change in CHANGES]


# --- hypothesis

_SIZES = st.integers(1, 6)
_SEEDS = st.integers(0, 2**32 - 1)
_PLAIN: st.SearchStrategy[GeneratedMesh] = st.one_of(
    st.builds(empty),
    st.builds(grid, _SIZES, _SIZES),
    st.builds(torus, st.integers(3, 7), st.integers(3, 7)),
    st.builds(sphere, st.integers(0, 2)),
    st.builds(fan, st.integers(1, 8)),
    st.builds(soup, st.integers(0, 40), st.integers(1, 20), _SEEDS),
)


@st.composite
def meshes(draw: st.DrawFn) -> GeneratedMesh:
    """Draw a mesh with one to three components and up to three modifications."""
    mesh = joined(draw(st.lists(_PLAIN, min_size=1, max_size=3)))
    random = np.random.default_rng(draw(_SEEDS))
    for change in draw(st.lists(st.sampled_from(CHANGES), max_size=3, unique_by=lambda change: change.__name__)):
        mesh = change(mesh, random)
    return mesh


@st.composite
def polygon_meshes(draw: st.DrawFn) -> tuple[Positions, Polygons]:
    """Draw a grid of triangles, squares, and larger polygons, convex or concave."""
    width, height = draw(st.integers(1, 6)), draw(st.integers(1, 4))
    mesh = grid(width, height)
    polygons: Polygons = []
    for y in range(height):
        x = 0
        while x < width:
            length = draw(st.integers(1, width - x))
            low = [y * (width + 1) + i for i in range(x, x + length + 1)]
            high = [corner + width + 1 for corner in low]
            if length == 1 and draw(st.booleans()):
                polygons += [[low[0], low[1], high[1]], [low[0], high[1], high[0]]]
            else:
                polygons.append([*low, *reversed(high)])
            x += length
    return mesh.vertices, polygons


def as_dtype(faces: npt.NDArray[Any], dtype: str) -> npt.NDArray[Any]:
    """Convert faces, which must fit."""
    converted = faces.astype(dtype)
    assert np.array_equal(converted, faces)
    return converted
