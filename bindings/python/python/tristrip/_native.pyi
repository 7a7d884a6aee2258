"""The types of the native module, which implements the functions and classes of the package."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Literal, TypeAlias, TypedDict, final, overload

import numpy as np
import numpy.typing as npt
from typing_extensions import NotRequired

from ._progress import ProgressArgument

VERSION: str

Method: TypeAlias = Literal[
    "best",
    "fewest",
    "cache",
    "sequential",
    "input",
    "sgi",
    "stripe-local",
    "stripe-global",
    "quad-rows",
    "tunnel",
    "eta",
    "guided-tunnels",
]
Cost: TypeAlias = Literal["restart", "degenerate", "opengl", "gl"]
Layout: TypeAlias = Literal["restart", "degenerate", "separate", "list"]
OnInterrupt: TypeAlias = Literal["raise", "return"]
Uint32Array: TypeAlias = npt.NDArray[np.uint32]
Float32Array: TypeAlias = npt.NDArray[np.float32]
IndexArray: TypeAlias = npt.NDArray[np.uint8] | npt.NDArray[np.uint16] | npt.NDArray[np.uint32]
Faces: TypeAlias = npt.ArrayLike | Sequence[Sequence[int]]

def run_command(arguments: Sequence[str]) -> int: ...
def set_threads(threads: int | None) -> None: ...

# --- strips

class Proof(TypedDict):
    faces: int
    triangles: int

class Metrics(TypedDict):
    triangles: int
    strips: int
    isolated: int
    swaps: int
    vertices_sent: int
    gl_cost: int
    indices_restart: int
    indices_degenerate: int
    vertices_per_triangle: float
    indices_restart_per_triangle: float
    indices_degenerate_per_triangle: float
    acmr_fifo_16: float
    acmr_fifo_32: float
    atvr_fifo_16: float
    atvr_fifo_32: float
    acmr: NotRequired[float]
    atvr: NotRequired[float]

class CacheStatistics(TypedDict):
    misses: int
    acmr: float
    atvr: float

@final
class Strips:
    @classmethod
    def from_indices(cls, indices: npt.ArrayLike, layout: Layout = "restart") -> Strips: ...
    @property
    def vertices(self) -> Uint32Array: ...
    @property
    def offsets(self) -> npt.NDArray[np.int64]: ...
    @property
    def method(self) -> str | None: ...
    @property
    def stopped(self) -> Literal["budget", "interrupt"] | None: ...
    @property
    def notes(self) -> list[str]: ...
    @property
    def proven(self) -> bool: ...
    @overload
    def indices(
        self, layout: Layout = "restart", *, dtype: type[np.uint8] | Literal["uint8"]
    ) -> npt.NDArray[np.uint8]: ...
    @overload
    def indices(
        self, layout: Layout = "restart", *, dtype: type[np.uint16] | Literal["uint16"]
    ) -> npt.NDArray[np.uint16]: ...
    @overload
    def indices(self, layout: Layout = "restart", *, dtype: type[np.uint32] | Literal["uint32"]) -> Uint32Array: ...
    @overload
    def indices(self, layout: Layout = "restart", dtype: npt.DTypeLike | None = None) -> IndexArray: ...
    def triangles(self) -> Uint32Array: ...
    def verify(self, faces: Faces, vertices: npt.ArrayLike | None = None) -> Proof: ...
    def metrics(self) -> Metrics: ...
    def vertex_cache(self, cache: str = "fifo:16", flush: bool = False) -> CacheStatistics: ...
    def __len__(self) -> int: ...
    def __getitem__(self, index: int, /) -> Uint32Array: ...
    def __iter__(self) -> Iterator[Uint32Array]: ...
    def __eq__(self, other: object, /) -> bool: ...
    def _repr_html_(self) -> str: ...

def stripify(
    faces: Faces,
    vertices: npt.ArrayLike | None = None,
    *,
    method: Method | str = "best",
    effort: int | None = None,
    cost: Cost | None = None,
    weld: bool = False,
    verify: bool = False,
    budget: float | None = None,
    progress: ProgressArgument = None,
    on_interrupt: OnInterrupt = "raise",
    **options: Any,
) -> Strips: ...

# --- simplification

@final
class Simplified:
    @property
    def vertices(self) -> Float32Array: ...
    @property
    def faces(self) -> Uint32Array: ...
    @property
    def normals(self) -> Float32Array | None: ...
    @property
    def uv(self) -> Float32Array | None: ...
    @property
    def colors(self) -> npt.NDArray[Any] | None: ...
    @property
    def attributes(self) -> dict[str, npt.NDArray[Any]]: ...
    @property
    def sources(self) -> Uint32Array: ...
    @property
    def surface_error(self) -> float: ...
    @property
    def rms_deviation(self) -> float | None: ...
    @property
    def largest_deviation(self) -> float | None: ...
    @property
    def diagonal(self) -> float: ...
    @property
    def warning(self) -> str | None: ...
    @property
    def notes(self) -> list[str]: ...
    def __iter__(self) -> Iterator[npt.NDArray[Any]]: ...
    def _repr_html_(self) -> str: ...

def simplify(
    vertices: npt.ArrayLike,
    faces: Faces,
    *,
    ratio: float | None = None,
    triangles: int | None = None,
    error: float | str | None = None,
    normals: npt.ArrayLike | None = None,
    uv: npt.ArrayLike | None = None,
    colors: npt.ArrayLike | None = None,
    attributes: Mapping[str, npt.ArrayLike] | None = None,
    weight: str | None = None,
    price: Literal["distance", "planes", "quadric"] = "distance",
    permissive: bool = False,
    lock_borders: bool = False,
    weld_distance: float | str | None = None,
    normals_mode: Literal["auto", "keep", "rebuild"] = "auto",
    fit: bool = True,
    measure: bool = False,
    verify: bool = True,
    progress: ProgressArgument = None,
) -> Simplified: ...

# --- levels of detail

LevelModel: TypeAlias = Literal[
    "progressive-mesh", "naive", "progressive", "mts", "sets", "lod-strips", "blocks", "skip"
]

class LevelRow(TypedDict):
    level: int
    triangles: int
    surface_error: float
    strips: int
    indices_restart: int
    indices_restart_per_triangle: float

class LevelMemory(TypedDict):
    model: int
    cursor: int

@final
class Levels:
    def __new__(
        cls,
        vertices: npt.ArrayLike,
        faces: Faces,
        *,
        model: LevelModel = "blocks",
        base: float | None = None,
        price: Literal["distance", "planes", "quadric"] = "distance",
        normals: npt.ArrayLike | None = None,
        uv: npt.ArrayLike | None = None,
        colors: npt.ArrayLike | None = None,
        attributes: Mapping[str, npt.ArrayLike] | None = None,
        method: Method | str = "best",
        effort: int | None = None,
        cost: Cost | None = None,
        verify: bool = True,
        progress: ProgressArgument = None,
        **options: Any,
    ) -> Levels: ...
    @property
    def level(self) -> int: ...
    @property
    def last_level(self) -> int: ...
    @property
    def part_count(self) -> int: ...
    @property
    def model(self) -> LevelModel: ...
    @property
    def triangle_count(self) -> int: ...
    @property
    def surface_error(self) -> float: ...
    @property
    def diagonal(self) -> float: ...
    @property
    def notes(self) -> list[str]: ...
    @property
    def stopped(self) -> Literal["budget", "interrupt"] | None: ...
    @property
    def memory(self) -> LevelMemory: ...
    def vertices(self, part: int = 0) -> Float32Array: ...
    def set_level(self, level: int | str) -> int: ...
    def set_triangles(self, triangles: int) -> int: ...
    def set_error(self, error: float | str) -> int: ...
    def set_pixels(
        self, pixels: float, distance: float, *, field_of_view: float = 45.0, rows: float = 1080.0
    ) -> int: ...
    def strips(self, part: int = 0) -> Strips: ...
    def indices(
        self, layout: Layout = "restart", dtype: npt.DTypeLike | None = None, *, part: int = 0
    ) -> IndexArray: ...
    def triangles(self, part: int = 0) -> Uint32Array: ...
    def update(
        self, layout: Layout = "restart", dtype: npt.DTypeLike | None = None, *, part: int = 0
    ) -> tuple[IndexArray, list[tuple[int, int]]]: ...
    def renaming(self, part: int = 0) -> Uint32Array: ...
    def verify(self) -> None: ...
    def another(self) -> Levels: ...
    def table(self, steps: int = 20) -> list[LevelRow]: ...
    def _repr_html_(self) -> str: ...

# --- streams

# --- scenes
