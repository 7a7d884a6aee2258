"""The types of the native module, which implements the functions and classes of the package."""

from collections.abc import Iterator, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, TypeAlias, TypedDict, final, overload

import numpy as np
import numpy.typing as npt
from typing_extensions import NotRequired

from ._progress import ProgressArgument
from ._streams import Packed, Unpacked

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
#: An object with bytes.
Buffer: TypeAlias = bytes | bytearray | memoryview
Path: TypeAlias = str | PathLike[str]
ReadFormat: TypeAlias = Literal["obj", "ply", "off", "stl", "gltf", "glb"]
WrittenFormat: TypeAlias = Literal["glb", "gltf", "ply", "obj"]
#: A file, or the bytes of one.
Input: TypeAlias = Path | Buffer

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
    def interrupted(self) -> bool: ...
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
    fit: bool = False,
    measure: bool = True,
    verify: bool = True,
    progress: ProgressArgument = None,
    on_interrupt: OnInterrupt = "raise",
) -> Simplified: ...

# --- levels of detail

LevelModel: TypeAlias = Literal["progressive-mesh", "naive", "progressive", "sets", "blocks", "skip"]

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

class PackReport(TypedDict):
    proven: bool | None
    parts: int
    meshes: int
    chunks: int | None
    vertices: int
    triangles: int
    base_triangles: int
    bytes: int
    base_bytes: int
    bits_per_vertex: float | None
    position_error: float | None
    notes: list[str]
    output: str | None

class UnpackReport(TypedDict):
    proven: bool | None
    parts: int
    level: int
    levels: int
    triangles: int
    triangles_full: int
    surface_error: float
    bytes: int
    chunks: int
    ended_early: bool
    notes: list[str]
    output: str | None

class ComponentBits(TypedDict):
    name: str
    bits: float
    per_vertex: float

class ChunkReport(TypedDict):
    mesh: int
    end: int
    level: int
    triangles: int
    surface_error: float

class InspectReport(TypedDict):
    meshes: int
    vertices: int
    triangles: int
    levels: int
    position_bits: int
    base_bytes: int
    chunk_bytes: int
    bits_per_vertex: float
    components: list[ComponentBits]
    chunks: list[ChunkReport]
    notes: list[str]

def pack(
    input: Input | Scene,
    output: Path | None = None,
    *,
    format: ReadFormat | str | None = None,
    eye: Vector | None = None,
    position_bits: int | None = None,
    verify: bool = True,
    progress: ProgressArgument = None,
) -> Packed: ...
def unpack(
    input: Input,
    output: Path | None = None,
    *,
    level: int | str | None = None,
    triangles: int | None = None,
    bytes: int | None = None,
    to: WrittenFormat | str | None = None,
    verify: bool = True,
    progress: ProgressArgument = None,
) -> Unpacked: ...
def inspect(input: Input) -> InspectReport: ...

@final
class Decoder:
    def __new__(
        cls, *, strips: bool = False, max_bytes: int | None = None, max_triangles: int | None = None
    ) -> Decoder: ...
    def update(self, data: Buffer) -> int: ...
    def finish(self) -> None: ...
    @property
    def offset(self) -> int: ...
    @property
    def is_complete(self) -> bool: ...
    @property
    def has_base(self) -> bool: ...
    @property
    def chunk_start(self) -> int | None: ...
    @property
    def chunk_end(self) -> int | None: ...
    @property
    def chunk_count(self) -> int: ...
    @property
    def parts(self) -> list[StreamedPart]: ...
    @property
    def level(self) -> int: ...
    @property
    def full_level(self) -> int: ...
    @property
    def triangle_count(self) -> int: ...
    @property
    def full_triangle_count(self) -> int: ...
    @property
    def error(self) -> float | None: ...
    def scene(self) -> Scene | None: ...
    def __copy__(self) -> Decoder: ...
    def __deepcopy__(self, memo: dict[int, Any], /) -> Decoder: ...
    def _repr_html_(self) -> str: ...

@final
class StreamedPart:
    @property
    def number(self) -> int: ...
    @property
    def level(self) -> int: ...
    @property
    def full_level(self) -> int: ...
    @property
    def triangle_count(self) -> int: ...
    @property
    def full_triangle_count(self) -> int: ...
    @property
    def vertex_count(self) -> int: ...
    @property
    def full_vertex_count(self) -> int: ...
    @property
    def error(self) -> float: ...
    @property
    def position_bits(self) -> int: ...
    @property
    def vertices(self) -> Float32Array: ...
    @property
    def faces(self) -> Uint32Array: ...
    @property
    def attributes(self) -> dict[str, npt.NDArray[Any]]: ...
    def strips(self) -> Strips: ...
    @property
    def fingerprint(self) -> int: ...

# --- views

Filter: TypeAlias = Literal["none", "stss", "dtfs", "linked"]
Vector: TypeAlias = Sequence[float] | npt.NDArray[np.floating[Any]]

class BuildReport(TypedDict):
    method: str
    cost: NotRequired[str]
    effort: NotRequired[int]
    order: Literal["quadric", "shortest-edge"] | None
    proven: bool | None
    parts: int | None
    vertices: int
    triangles: int
    strips: int
    collapses: int
    levels: int | None
    height: int
    bytes: int | None
    stopped: Literal["budget", "interrupt"] | None
    notes: list[str]

class UpdateReport(TypedDict):
    triangles: int
    active_vertices: int
    collapses: int
    splits: int
    looked_at: int
    segments: int
    complete: bool

class ViewModelMemory(TypedDict):
    strips: int
    tree: int

@final
class ViewModel:
    @classmethod
    def build(
        cls,
        vertices: npt.ArrayLike,
        faces: Faces,
        *,
        method: Method | str = "best",
        effort: int | None = None,
        cost: Cost | None = None,
        order: Literal["quadric", "shortest-edge"] = "quadric",
        normals: npt.ArrayLike | None = None,
        uv: npt.ArrayLike | None = None,
        colors: npt.ArrayLike | None = None,
        attributes: dict[str, npt.ArrayLike] | None = None,
        verify: bool = True,
        budget: float | None = None,
        progress: ProgressArgument = None,
        **options: Any,
    ) -> ViewModel: ...
    @classmethod
    def from_scene(
        cls,
        input: Input | Scene,
        *,
        format: ReadFormat | str | None = None,
        method: Method | str = "best",
        effort: int | None = None,
        cost: Cost | None = None,
        order: Literal["quadric", "shortest-edge"] = "quadric",
        verify: bool = True,
        budget: float | None = None,
        progress: ProgressArgument = None,
        **options: Any,
    ) -> ViewModel: ...
    @classmethod
    def load(cls, input: Input) -> ViewModel: ...
    def to_bytes(self) -> bytes: ...
    def save(self, path: Path) -> None: ...
    @property
    def vertices(self) -> Float32Array: ...
    @property
    def faces(self) -> Uint32Array: ...
    @property
    def attributes(self) -> dict[str, npt.NDArray[Any]]: ...
    @property
    def strips(self) -> Strips: ...
    @property
    def triangle_count(self) -> int: ...
    @property
    def base_triangle_count(self) -> int: ...
    @property
    def collapse_count(self) -> int: ...
    @property
    def height(self) -> int: ...
    @property
    def memory(self) -> ViewModelMemory: ...
    @property
    def report(self) -> BuildReport: ...
    @property
    def notes(self) -> list[str]: ...
    def view(self, filter: Filter | Literal["repair"] = "dtfs") -> View: ...
    def _repr_html_(self) -> str: ...

@final
class View:
    def set_view(
        self,
        eye: Vector,
        look_at: Vector | None = None,
        *,
        direction: Vector | None = None,
        up: Vector = (0.0, 1.0, 0.0),
        field_of_view: float = 45.0,
        image: tuple[int, int] = (1920, 1080),
        pixels: float = 1.0,
        triangles: int | None = None,
        steps: int | None = None,
        frustum: bool = True,
        back_faces: bool = True,
        silhouettes: bool = True,
        light: Vector | None = None,
        foveation: float | None = None,
        attention: Vector = (0.5, 0.5),
    ) -> UpdateReport: ...
    @property
    def triangle_count(self) -> int: ...
    @property
    def active_vertex_count(self) -> int: ...
    @property
    def surface_error(self) -> float: ...
    @property
    def filter(self) -> str: ...
    @property
    def memory(self) -> int: ...
    def strips(self) -> Strips: ...
    def indices(self, layout: Layout = "restart", dtype: npt.DTypeLike | None = None) -> IndexArray: ...
    def update(self, dtype: npt.DTypeLike | None = None) -> tuple[IndexArray, list[tuple[int, int]]]: ...
    def triangles(self) -> Uint32Array: ...
    def verify(self) -> int: ...
    def picture(self, *, shaded: bool = False) -> bytes: ...
    def __copy__(self) -> View: ...
    def __deepcopy__(self, memo: dict[int, Any], /) -> View: ...
    def _repr_png_(self) -> bytes | None: ...

# --- scenes

UvOrigin: TypeAlias = Literal["bottom", "top"]
Price: TypeAlias = Literal["distance", "planes", "quadric"]

#: A name, or a dictionary with any of the keys of `MaterialProperties` and "name".
Material: TypeAlias = str | Mapping[str, object]

class MaterialProperties(TypedDict):
    base_color: tuple[float, float, float, float]
    base_color_image: bytes | None
    metallic: float
    roughness: float
    blend: bool

class MeshCounts(TypedDict):
    vertices: int
    faces: int
    triangles: int
    components: int
    boundary_edges: int
    non_manifold_edges: int
    inconsistent_edges: int
    isolated_faces: int
    degenerate_faces: int
    duplicate_faces: int
    unreferenced_vertices: int
    cut_polygons: int
    fanned_polygons: int
    welded_vertices: int

class BoundGap(TypedDict):
    figure: str
    found: int
    bound: int
    gap: int
    optimal: bool

class Bounds(TypedDict):
    strips: int
    vertices_sent: int
    gl_cost: int
    indices_restart: int
    indices_degenerate: int

class ComponentBound(TypedDict):
    part: int
    triangles: int
    strips: int
    vertices_sent: int
    proof: Literal["leaves", "matching", "subproblems", "exact", "one-strip"]

class BoundReport(TypedDict):
    mesh: MeshCounts
    parts: int
    bound: Bounds
    sequential: list[bool]
    components: list[ComponentBound]
    notes: list[str]

class StoredFigures(TypedDict):
    drawn: Literal["list", "strips", "fans", "mixed"]
    triangles: int
    vertices: int
    indices: int
    restarts: int
    degenerate: int
    strips: int | None
    isolated: int | None
    swaps: int | None
    vertices_sent: int | None

class PartStatistics(StoredFigures):
    name: str | None
    material: str | None
    misses: list[int]

class CacheRow(TypedDict):
    vertex_cache: str
    misses: int
    acmr: float
    atvr: float

LengthBin = TypedDict("LengthBin", {"from": int, "to": int, "strips": int, "triangles": int})

class AnalyzeReport(StoredFigures):
    indices_per_triangle: float
    lengths: list[LengthBin]
    flushed: bool
    vertex_caches: list[CacheRow]
    parts: int
    by_part: list[PartStatistics]
    notes: list[str]

class MethodSeconds(TypedDict):
    stripify: float | None
    verify: float | None

class MethodOptions(TypedDict, total=False):
    triangulation: str
    ties: str
    last_tie: str
    patches: str
    cutoff: int
    cost: str
    vertex_cache: str
    objective: str
    effort: int
    tunnel_length: int
    threshold: int
    start: str
    acceptance: str
    localization: str
    seed: int

class MethodRow(MethodOptions, Metrics):
    method: str
    proven: bool
    seconds: MethodSeconds
    stopped: Literal["budget", "interrupt"] | None
    error: str | None

class SceneProof(TypedDict):
    proven: bool
    faces: int
    triangles: int
    notes: list[str]

class FileReport(TypedDict):
    output: str
    proven: bool | None
    faces: int | None
    bytes: int
    beside: list[str]
    layout: Layout | None
    notes: list[str]

class ConvertReport(FileReport):
    triangles: int
    strips: int | None
    parts: int

class FileFigures(TypedDict):
    indices: int
    acmr_fifo_16: float
    bytes: int | None

class DrawnParts(TypedDict):
    found: int
    stored: int
    list: int

class VertexOrder(TypedDict):
    parts: list[int]
    vertices: int
    moved: int
    new_to_old: Uint32Array
    kept: str | None

class StripFileReport(FileReport):
    drawn: DrawnParts
    before: FileFigures
    after: FileFigures
    vertex_order: list[VertexOrder] | None

class NormalCounts(TypedDict):
    kept: int
    repaired: int
    flat: int
    creased: int

class KeptVertices(TypedDict):
    error: int
    locked: int
    seam: int
    non_manifold: int
    topology: int
    fold_over: int

class SimplifyReport(TypedDict):
    target_triangles: int | None
    target_error: float | None
    reached: bool
    triangles_before: int
    triangles_after: int
    vertices_before: int
    vertices_after: int
    collapses: int
    moved_positions: NotRequired[int]
    surface_error: float
    surface_error_percent: float
    largest_deviation: float | None
    largest_deviation_percent: float | None
    rms_deviation: float | None
    rms_deviation_percent: float | None
    normal_deviation_degrees: float | None
    uv_deviation_percent: float | None
    uv_deviation_texels: float | None
    normals: NormalCounts
    diagonal: float
    vanished_components: int
    locked_vertices: int
    parts: int
    vertices_kept: KeptVertices | None
    warning: str | None

class ChainLevel(TypedDict):
    level: int
    ratio: float
    target_triangles: int
    triangles: int
    vertices: int
    surface_error: float
    surface_error_percent: float
    screen_coverage: float
    reached: bool
    bytes: int | None
    output: str | None

class ChainReport(MethodOptions):
    method: str
    proven: bool | None
    target_error: float | None
    triangles_before: int
    vertices_before: int
    diagonal: float
    chain: list[ChainLevel]
    locked_vertices: int
    parts: int
    warning: str | None
    notes: list[str]

class ChainFileReport(TypedDict):
    output: str | None
    layout: Layout
    proven: bool | None
    chain: list[ChainLevel]
    notes: list[str]
    beside: list[str]

@final
class Part:
    def __new__(
        cls,
        vertices: npt.ArrayLike,
        faces: Faces,
        *,
        normals: npt.ArrayLike | None = None,
        uv: npt.ArrayLike | None = None,
        colors: npt.ArrayLike | None = None,
        attributes: Mapping[str, npt.ArrayLike] | None = None,
        name: str | None = None,
        material: Material | None = None,
        uv_origin: UvOrigin = "bottom",
        normalized: Sequence[str] | None = None,
    ) -> Part: ...
    @property
    def name(self) -> str | None: ...
    @property
    def material(self) -> str | None: ...
    @property
    def material_properties(self) -> MaterialProperties | None: ...
    @property
    def vertices(self) -> Float32Array: ...
    @property
    def faces(self) -> Uint32Array: ...
    @property
    def polygons(self) -> tuple[npt.NDArray[np.int64], Uint32Array] | None: ...
    @property
    def attributes(self) -> dict[str, npt.NDArray[Any]]: ...
    @property
    def normalized(self) -> list[str]: ...
    @property
    def normals(self) -> npt.NDArray[Any] | None: ...
    @property
    def uv(self) -> npt.NDArray[Any] | None: ...
    @property
    def uv_origin(self) -> UvOrigin | None: ...
    @property
    def colors(self) -> npt.NDArray[Any] | None: ...
    @property
    def strips(self) -> Strips | None: ...

@final
class Scene:
    @classmethod
    def from_bytes(cls, data: bytes | bytearray | memoryview, format: ReadFormat | str | None = None) -> Scene: ...
    @classmethod
    def from_arrays(
        cls,
        vertices: npt.ArrayLike,
        faces: Faces,
        *,
        normals: npt.ArrayLike | None = None,
        uv: npt.ArrayLike | None = None,
        colors: npt.ArrayLike | None = None,
        attributes: Mapping[str, npt.ArrayLike] | None = None,
        name: str | None = None,
        material: Material | None = None,
        uv_origin: UvOrigin = "bottom",
        normalized: Sequence[str] | None = None,
    ) -> Scene: ...
    @classmethod
    def from_parts(cls, parts: Sequence[Part]) -> Scene: ...
    @property
    def parts(self) -> list[Part]: ...
    @property
    def placements(self) -> list[tuple[range, npt.NDArray[np.float64]]]: ...
    @property
    def notes(self) -> list[str]: ...
    @property
    def format(self) -> ReadFormat | None: ...
    def strip(
        self,
        *,
        method: Method | str = "best",
        effort: int | None = None,
        cost: Cost | None = None,
        weld: bool = False,
        verify: bool = True,
        budget: float | None = None,
        progress: ProgressArgument = None,
        on_interrupt: OnInterrupt = "raise",
        **options: Any,
    ) -> StrippedScene: ...
    def simplify(
        self,
        *,
        ratio: float | None = None,
        triangles: int | None = None,
        error: float | str | None = None,
        weight: str | None = None,
        price: Price = "distance",
        permissive: bool = False,
        lock_borders: bool = False,
        weld_distance: float | str | None = None,
        normals: Literal["auto", "keep", "rebuild"] = "auto",
        fit: bool = False,
        compact: bool = False,
        measure: bool = True,
        verify: bool = True,
        progress: ProgressArgument = None,
        on_interrupt: OnInterrupt = "raise",
    ) -> SimplifiedScene: ...
    def chain(
        self,
        ratios: str | Sequence[float] = "100%,50%,25%,10%",
        *,
        error: float | str | None = None,
        weight: str | None = None,
        price: Price = "distance",
        permissive: bool = False,
        lock_borders: bool = False,
        weld_distance: float | str | None = None,
        layout: Layout | None = None,
        method: Method | str | None = None,
        effort: int | None = None,
        cost: Cost | None = None,
        weld: bool = False,
        verify: bool = True,
        budget: float | None = None,
        progress: ProgressArgument = None,
        **options: Any,
    ) -> Chain: ...
    def levels(
        self,
        *,
        model: LevelModel = "blocks",
        base: float | None = None,
        price: Price = "distance",
        method: Method | str = "best",
        effort: int | None = None,
        cost: Cost | None = None,
        verify: bool = True,
        progress: ProgressArgument = None,
        **options: Any,
    ) -> Levels: ...
    def pack(
        self,
        output: Path | None = None,
        *,
        eye: Vector | None = None,
        position_bits: int | None = None,
        verify: bool = True,
        progress: ProgressArgument = None,
    ) -> Packed: ...
    def bound(self, weld: bool = False) -> BoundReport: ...
    def analyze(self, vertex_caches: str | Sequence[str] | None = None, flush: bool = False) -> AnalyzeReport: ...
    def compare(
        self,
        *,
        all: bool = False,
        effort: int | None = None,
        cost: Cost = "restart",
        seed: int = 0,
        weld: bool = False,
        budget: float | None = None,
        progress: ProgressArgument = None,
        on_interrupt: OnInterrupt = "raise",
    ) -> list[MethodRow]: ...
    def verify(self, result: Scene | Path) -> SceneProof: ...
    def save(
        self,
        path: Path,
        *,
        format: WrittenFormat | str | None = None,
        layout: Layout | None = None,
        verify: bool = True,
    ) -> ConvertReport: ...
    def to_bytes(
        self, format: WrittenFormat | str = "glb", *, layout: Layout | None = None, verify: bool = True
    ) -> bytes: ...
    def picture(
        self,
        width: int = 1200,
        height: int = 900,
        *,
        mode: Literal["textured", "normals", "uv", "shaded"] = "textured",
    ) -> bytes: ...
    def _repr_html_(self) -> str: ...

@final
class StrippedScene:
    @property
    def scene(self) -> Scene: ...
    @property
    def parts(self) -> list[Strips]: ...
    @property
    def method(self) -> str: ...
    @property
    def stopped(self) -> Literal["budget", "interrupt"] | None: ...
    @property
    def proven(self) -> bool: ...
    @property
    def mesh(self) -> MeshCounts: ...
    @property
    def bound(self) -> BoundGap | None: ...
    @property
    def notes(self) -> list[str]: ...
    def metrics(self) -> Metrics: ...
    def save(
        self,
        path: Path,
        *,
        format: WrittenFormat | str | None = None,
        layout: Layout | None = None,
        reorder_vertices: bool = False,
        verify: bool = True,
    ) -> StripFileReport: ...
    def to_bytes(
        self,
        format: WrittenFormat | str = "glb",
        *,
        layout: Layout | None = None,
        reorder_vertices: bool = False,
        verify: bool = True,
    ) -> bytes: ...
    def picture(self, width: int = 1200, height: int = 900) -> bytes: ...
    def _repr_html_(self) -> str: ...

@final
class SimplifiedScene:
    @property
    def source(self) -> Scene: ...
    @property
    def scene(self) -> Scene: ...
    @property
    def report(self) -> SimplifyReport: ...
    @property
    def proven(self) -> bool: ...
    @property
    def notes(self) -> list[str]: ...
    @property
    def warning(self) -> str | None: ...
    @property
    def interrupted(self) -> bool: ...
    def save(self, path: Path, *, format: WrittenFormat | str | None = None, verify: bool = True) -> FileReport: ...
    def to_bytes(self, format: WrittenFormat | str = "glb", *, verify: bool = True) -> bytes: ...
    def picture(self, size: int = 256) -> bytes: ...
    def _repr_html_(self) -> str: ...

@final
class Chain:
    @property
    def source(self) -> Scene: ...
    @property
    def levels(self) -> list[ChainLevel]: ...
    @property
    def report(self) -> ChainReport: ...
    @property
    def warning(self) -> str | None: ...
    @property
    def notes(self) -> list[str]: ...
    def save(
        self,
        path: Path,
        *,
        format: WrittenFormat | str | None = None,
        verify: bool = True,
        progress: ProgressArgument = None,
    ) -> ChainFileReport: ...
    def to_bytes(self, *, verify: bool = True) -> bytes: ...
    def __len__(self) -> int: ...
    def _repr_html_(self) -> str: ...

def load(path: Path, format: ReadFormat | str | None = None) -> Scene: ...
def verify(source: Scene | Path, result: Scene | Path) -> SceneProof: ...
def convert(
    input: Path,
    output: Path,
    *,
    format: ReadFormat | str | None = None,
    to: WrittenFormat | str | None = None,
    layout: Layout | None = None,
    verify: bool = True,
) -> ConvertReport: ...
