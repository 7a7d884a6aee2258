"""Arrays shared by all conversions: positions, faces or strips, and named attributes."""

from __future__ import annotations

import importlib
import inspect
import warnings
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from tristrip._errors import ArrayTypeError, MeshError
from tristrip._native import Strips

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

NORMAL = "NORMAL"
UV = "TEXCOORD_0"
COLOUR = "COLOR_0"
TANGENT = "TANGENT"

Array: TypeAlias = npt.NDArray[Any]


class ConversionWarning(UserWarning):
    """Data that a conversion drops. The text names them, with counts."""


def warn(text: str) -> None:
    """Warn about dropped data, attributed to the line where the user called the conversion."""
    package = __name__.rsplit(".", 2)[0] + "."
    depth = 1
    frame = inspect.currentframe()
    while frame is not None and str(frame.f_globals.get("__name__", "")).startswith(package):
        frame, depth = frame.f_back, depth + 1
    warnings.warn(text, ConversionWarning, stacklevel=depth)


def required(name: str, install: str | None = None) -> Any:
    """Import another package, or raise an error with the install command."""
    try:
        return importlib.import_module(name)
    except ImportError as error:
        package = name.split(".", maxsplit=1)[0]
        raise ImportError(
            f"{package} cannot be imported ({error}); install it with: pip install {install or package}", name=package
        ) from error


@dataclass
class Faces:
    """Faces of any size: face i has `corners[offsets[i]:offsets[i + 1]]`."""

    offsets: npt.NDArray[np.int64]
    corners: npt.NDArray[np.int64]

    @classmethod
    def of(cls, name: str, given: Any) -> Faces:
        """Read faces in any form that `stripify` accepts."""
        if isinstance(given, Faces):
            return given
        if isinstance(given, list | tuple) and len({len(face) for face in given if hasattr(face, "__len__")}) > 1:
            rows = [_integers(f"{name}[{i}]", np.asarray(face)).ravel() for i, face in enumerate(given)]
            sizes = np.array([len(row) for row in rows], np.int64)
            return cls(_ends(sizes), np.concatenate(rows))
        array = np.asarray(given)
        if array.size == 0:
            return cls(np.zeros(1, np.int64), np.empty(0, np.int64))
        array = _integers(name, array)
        if array.ndim == 1 and len(array) % 3 == 0:
            array = array.reshape(-1, 3)
        if array.ndim != 2 or array.shape[1] < 3:
            raise MeshError(f"{name}: found shape {array.shape}, expected shape (n, 3), (n, k) with k ≥ 3, or (3 n,)")
        return cls(np.arange(len(array) + 1, dtype=np.int64) * array.shape[1], array.ravel())

    def __len__(self) -> int:
        return len(self.offsets) - 1

    @property
    def sizes(self) -> npt.NDArray[np.int64]:
        return np.diff(self.offsets)

    def triangles(self) -> npt.NDArray[np.int64]:
        """Return the triangles, shape (n, 3), polygons as fans around their first corner."""
        sizes = self.sizes
        counts = np.maximum(sizes - 2, 0)
        starts = np.repeat(self.offsets[:-1], counts)
        second = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts) + 1
        return np.column_stack([self.corners[starts + i * second + j] for i, j in ((0, 0), (1, 0), (1, 1))])

    def by_size(self) -> Iterator[tuple[int, npt.NDArray[np.int64], npt.NDArray[np.int64]]]:
        """Yield each face size, the indices of its faces, and their corners as one array."""
        for size in np.unique(self.sizes):
            numbers = np.flatnonzero(self.sizes == size)
            yield int(size), numbers, self.corners[self.offsets[numbers, None] + np.arange(size)]

    def reordered(self, order: npt.NDArray[np.int64]) -> Faces:
        """Return the faces at these indices."""
        sizes = self.sizes[order]
        ends = _ends(sizes)
        within = np.arange(ends[-1]) - np.repeat(ends[:-1], sizes)
        return Faces(ends, self.corners[np.repeat(self.offsets[order], sizes) + within])

    def turned_over(self) -> Faces:
        """Return the faces with reversed corners, starting at the same first corner."""
        sizes = self.sizes
        first = np.repeat(self.offsets[:-1], sizes)
        within = np.arange(len(self.corners)) - first
        return Faces(self.offsets, self.corners[first + (np.repeat(sizes, sizes) - within) % np.repeat(sizes, sizes)])

    def as_argument(self) -> Any:
        """Return the faces in a form that `stripify` accepts."""
        sizes = self.sizes
        if len(sizes) == 0:
            return np.empty((0, 3), np.int64)
        if (sizes == sizes[0]).all() and sizes[0] >= 3:
            return self.corners.reshape(-1, int(sizes[0]))
        return np.split(self.corners, self.offsets[1:-1])


@dataclass
class Part:
    """One mesh with its original positions, and texture coordinates with v up.

    material: a dictionary as in `tristrip.Part`.
    """

    vertices: Array
    faces: Faces | Strips
    attributes: dict[str, Array] = field(default_factory=dict)
    name: str | None = None
    material: dict[str, Any] | None = None

    def triangles(self) -> npt.NDArray[np.int64]:
        if isinstance(self.faces, Strips):
            return self.faces.triangles().astype(np.int64)
        return self.faces.triangles()

    def placed(self, transform: Array) -> Part:
        """Return the transformed part with its normals and tangents; flip mirrored faces."""
        if np.array_equal(transform, np.eye(4)):
            return self
        linear = transform[:3, :3]
        faces, attributes = self.faces, dict(self.attributes)
        vertices = (self.vertices @ linear.T + transform[:3, 3]).astype(self.vertices.dtype)
        is_mirrored = np.linalg.det(linear) < 0
        if is_mirrored:
            faces = self.polygons().turned_over()
        if NORMAL in attributes:
            # The cofactor matrix: the inverse transpose up to scale, defined even if there is no
            # inverse.
            a, b, c = linear.T
            cofactors = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)]) * (-1 if is_mirrored else 1)
            attributes[NORMAL] = _unit(attributes[NORMAL] @ cofactors).astype(attributes[NORMAL].dtype)
        if TANGENT in attributes:
            given = attributes[TANGENT]
            turned = _unit(given[:, :3] @ linear.T)
            side = given[:, 3:] * (-1 if is_mirrored else 1)
            attributes[TANGENT] = np.concatenate([turned, side], axis=1).astype(given.dtype)
        return Part(vertices, faces, attributes, self.name, self.material)

    def polygons(self) -> Faces:
        return Faces.of("faces", self.triangles()) if isinstance(self.faces, Strips) else self.faces

    def other_attributes(self) -> Iterator[tuple[str, Array]]:
        """Yield the attributes except normals, texture coordinates and colours."""
        yield from ((name, values) for name, values in self.attributes.items() if name not in (NORMAL, UV, COLOUR))


def part_of(
    mesh: Any,
    faces: Any = None,
    *,
    normals: Any = None,
    uv: Any = None,
    colors: Any = None,
    attributes: Mapping[str, Any] | None = None,
) -> Part:
    """Read one mesh: vertices and faces or strips, a pair of them, or an object with both."""
    found: dict[str, Any] = {}
    name = material = None
    if hasattr(mesh, "vertices") and hasattr(mesh, "faces"):
        found.update(mesh.attributes)
        if UV in found and mesh.uv is not None:
            # The `uv` of a part has v up, as in other packages.
            found[UV] = mesh.uv
        name, material = getattr(mesh, "name", None), _material_of(mesh)
        vertices, faces = mesh.vertices, _faces_of(mesh) if faces is None else faces
    elif faces is None:
        try:
            vertices, faces = mesh
        except (TypeError, ValueError):
            expected = "vertices and faces, a pair of them, or an object with both"
            raise ArrayTypeError(f"mesh: found {type(mesh).__name__}, expected {expected}") from None
    else:
        vertices = mesh
    vertices = _numbers("vertices", vertices)
    if vertices.ndim != 2 or vertices.shape[1] != 3:
        raise MeshError(f"vertices: found shape {vertices.shape}, expected shape (n, 3)")
    if not np.isfinite(vertices).all():
        raise MeshError("vertices: found a non-finite coordinate")
    named = {NORMAL: ("normals", normals), UV: ("uv", uv), COLOUR: ("colors", colors)}
    found.update({name: values for name, (_, values) in named.items() if values is not None})
    found.update(attributes or {})
    arguments = {key: named[key][0] if key in named else key for key in found}
    arrays = {key: _numbers(arguments[key], values) for key, values in found.items()}
    for key, values in arrays.items():
        if values.ndim not in (1, 2) or len(values) != len(vertices):
            expected = f"{len(vertices)} rows, one per vertex"
            raise MeshError(f"{arguments[key]}: found shape {values.shape}, expected {expected}")
    kept = faces if isinstance(faces, Strips) else Faces.of("faces", faces)
    corners = kept.vertices if isinstance(kept, Strips) else kept.corners
    # Other packages don't check this and would read out of bounds.
    if len(corners) and (corners.max() >= len(vertices) or corners.min() < 0):
        wrong = corners.max() if corners.max() >= len(vertices) else corners.min()
        raise MeshError(f"faces: found vertex {wrong}, expected 0 to {len(vertices) - 1}")
    return Part(vertices, kept, arrays, name, material)


def _faces_of(mesh: Any) -> Any:
    polygons = getattr(mesh, "polygons", None)
    if polygons is None:
        return mesh.faces
    offsets, corners = polygons
    return Faces(offsets.astype(np.int64), corners.astype(np.int64))


def _material_of(mesh: Any) -> dict[str, Any] | None:
    properties = getattr(mesh, "material_properties", None)
    return None if properties is None else {**properties, "name": mesh.material}


def _ends(sizes: Array) -> npt.NDArray[np.int64]:
    return np.concatenate([np.zeros(1, np.int64), np.cumsum(sizes, dtype=np.int64)])


def _unit(vectors: Array) -> Array:
    lengths = np.linalg.norm(vectors, axis=1)
    unit: Array = vectors / np.maximum(lengths, np.finfo(np.float64).tiny)[:, None]
    return unit


def _integers(name: str, array: Array) -> npt.NDArray[np.int64]:
    if array.size and array.dtype.kind not in "iu":
        raise ArrayTypeError(f"{name}: found dtype {array.dtype}, expected an integer dtype")
    if array.size and array.dtype == np.uint64 and array.max() > np.iinfo(np.int64).max:
        raise MeshError(f"{name}: found vertex {array.max()}, expected a 32-bit index")
    return array.astype(np.int64, copy=False)


def _numbers(name: str, given: Any) -> Array:
    try:
        array = np.asarray(given)
    except ValueError as error:
        raise ArrayTypeError(f"{name}: expected an array: {error}") from None
    if array.dtype.kind not in "fiu":
        raise ArrayTypeError(f"{name}: found dtype {array.dtype}, expected numbers")
    return array


def bytes_of_colours(colours: Array) -> npt.NDArray[np.uint8]:
    """Convert colours, floats from 0 to 1 or integers, to 8 bits per component."""
    if colours.dtype == np.uint8:
        return colours
    highest = 1.0 if colours.dtype.kind == "f" else float(np.iinfo(colours.dtype).max)
    return np.rint(np.clip(colours / highest, 0, 1) * 255).astype(np.uint8)


def warn_of_rounding(colours: Array) -> None:
    """Warn if colours need more than 8 bits."""
    if colours.dtype != np.uint8:
        highest = 1.0 if colours.dtype.kind == "f" else float(np.iinfo(colours.dtype).max)
        if np.abs(bytes_of_colours(colours) / 255 - colours / highest).max(initial=0) > 1e-6:
            warn(f"{COLOUR}: {colours.dtype} values are rounded to 8 bits per component")


def check_range(name: str, faces: Sequence[int] | Array, vertex_count: int) -> None:
    """Validate indices from another package."""
    array = np.asarray(faces)
    if array.size and (array.min() < 0 or array.max() >= vertex_count):
        wrong = array.min() if array.min() < 0 else array.max()
        raise MeshError(f"{name}: found vertex {wrong}, expected 0 to {vertex_count - 1}")


def attributes_of(given: Mapping[str, Any], names: Mapping[Any, str], left_out: list[str]) -> dict[str, Array]:
    """Read arrays with one row per vertex as attributes, optionally renamed.

    Names of unsupported arrays are appended to the list `left_out`.
    """
    found: dict[str, Array] = {}
    for key, array in given.items():
        values = _narrowed(np.asarray(array))
        name = names.get(key, key)
        if name == UV and values.ndim == 2 and values.shape[1] == 3:
            left_out.append(f"the third texture coordinate of {key}")
            values = values[:, :2]
        if name in found or not _fits(name, values):
            # The values do not match the name; store them under another name.
            name = key if key != name else f"{key}_OTHER"
        if (
            values.dtype.kind not in "fiu"
            or (values.dtype.kind != "f" and values.dtype.itemsize == 8)
            or not values.size
        ):
            left_out.append(f"{key} of {values.dtype}")
        else:
            found[name] = values
    return found


def _narrowed(values: Array) -> Array:
    """Return values as rows; convert booleans to 8 bits, and 64-bit integers to 32 if they fit."""
    if values.ndim > 2:
        values = values.reshape(len(values), -1)
    if values.dtype.kind == "b":
        return values.astype(np.uint8)
    if values.dtype.kind in "iu" and values.dtype.itemsize == 8:
        for narrow in (np.int32, np.uint32):
            limits = np.iinfo(narrow)
            if limits.min <= values.min(initial=0) and values.max(initial=0) <= limits.max:
                return values.astype(narrow)
    return values


def _fits(name: str, values: Array) -> bool:
    """Check the columns and values of normals, texture coordinates and colours."""
    columns = {NORMAL: (3,), UV: (2,), COLOUR: (3, 4)}.get(name)
    if columns is None:
        return True
    if values.ndim != 2 or values.shape[1] not in columns or values.dtype.kind not in "fiu":
        return False
    if name != COLOUR:
        return True
    if values.dtype.kind == "f":
        return bool(values.min(initial=0) >= 0 and values.max(initial=0) <= 1)
    return values.dtype in (np.uint8, np.uint16)


def split_corners(
    corners: Array, vertex_count: int, values: Array
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Split vertices whose face corners have different values.

    Args:
        corners: the vertex of each corner, shape (n,).
        vertex_count: the number of vertices.
        values: one row per corner, shape (n, k).

    Returns:
        The split vertex of each corner, the source vertex of each split vertex, and a corner with
        its value, or -1 for vertices without faces. Copies of a vertex are adjacent, so unsplit
        vertices keep their order.
    """
    corners = np.asarray(corners, np.int64)
    count = len(corners) + 1
    numbers = np.unique(values, axis=0, return_inverse=True)[1].ravel() if count > 1 else corners
    unused = np.setdiff1d(np.arange(vertex_count), corners)
    keys, first, new = np.unique(
        np.concatenate([corners * count + numbers, unused * count]), return_index=True, return_inverse=True
    )
    corner = np.where(first < len(corners), first, -1)
    return new.ravel()[: len(corners)].astype(np.int64), keys // count, corner


def joined(parts: Sequence[Part]) -> tuple[Part, npt.NDArray[np.int64]]:
    """Join parts into one, and return the part index of each face.

    Attributes that differ between parts are dropped with a warning.
    """
    if len(parts) == 1:
        return parts[0], np.zeros(len(parts[0].polygons()), np.int64)
    faces = [part.polygons() for part in parts]
    first_vertices = _ends(np.array([len(part.vertices) for part in parts], np.int64))
    first_corners = _ends(np.array([len(one.corners) for one in faces], np.int64))
    offsets = [one.offsets[1:] + first for one, first in zip(faces, first_corners, strict=False)]
    corners = [one.corners + first for one, first in zip(faces, first_vertices, strict=False)]
    names = {name for part in parts for name in part.attributes}
    kinds = {
        name: {(values.shape[1:], values.dtype) for part in parts if (values := part.attributes.get(name)) is not None}
        for name in names
    }
    shared = {name for name in names if len(kinds[name]) == 1 and all(name in part.attributes for part in parts)}
    if names - shared:
        warn(f"dropped attributes that only some parts have: {', '.join(sorted(names - shared))}")
    attributes = {name: np.concatenate([part.attributes[name] for part in parts]) for name in sorted(shared)}
    empty: list[Any] = [np.empty(0, np.int64)]
    together = Faces(np.concatenate([np.zeros(1, np.int64), *offsets]), np.concatenate(corners or empty))
    vertices = np.concatenate([part.vertices for part in parts] or [np.empty((0, 3), np.float32)])
    numbers = np.repeat(np.arange(len(parts)), [len(one) for one in faces])
    return Part(vertices, together, attributes), numbers
