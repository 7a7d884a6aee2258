"""Results of streams, and a decoder as a generator."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from . import _notebook

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from ._native import Buffer, Decoder, Float32Array, PackReport, Scene, Uint32Array, UnpackReport


@dataclass(frozen=True)
class Packed:
    """A packed model, returned by `tristrip.pack`.

    Attributes:
        report: a dictionary with the keys of the command's JSON: "proven", "parts", "meshes",
            "chunks", "vertices", "triangles", "base_triangles", "bytes", "base_bytes",
            "bits_per_vertex", "position_error", "notes", "output".
        bytes: the contents of the file.
    """

    report: PackReport
    bytes: bytes

    def __repr__(self) -> str:
        report = self.report
        size, before = report["bytes"], report["base_bytes"]
        return f"Packed({report['triangles']:,} triangles, {size:,} bytes, {before:,} before the first chunk)"

    def _repr_html_(self) -> str:
        return _notebook.report_html("packed model", self.report)


@dataclass(frozen=True, eq=False)
class Unpacked:
    """A level of a stream, returned by `tristrip.unpack`, with all parts in one mesh.

    It unpacks: `vertices, faces = unpacked`.

    Attributes:
        report: a dictionary with the keys of the command's JSON: "proven", "parts", "level",
            "levels", "triangles", "triangles_full", "surface_error", "bytes", "chunks",
            "ended_early", "notes", "output".
        vertices: positions, float32 of shape (n, 3).
        faces: triangles, uint32 of shape (m, 3).
        attributes: arrays by name: "NORMAL", "TEXCOORD_0", …
        scene: the level as a scene, with the parts, materials and nodes of the file.
    """

    report: UnpackReport
    vertices: Float32Array
    faces: Uint32Array
    attributes: dict[str, Any]
    scene: Scene

    def __iter__(self) -> Iterator[Any]:
        return iter((self.vertices, self.faces))

    def __repr__(self) -> str:
        report = self.report
        level, triangles = f"{report['level']:,} of {report['levels']:,}", f"{report['triangles']:,}"
        return f"Unpacked(level {level}, {triangles} of {report['triangles_full']:,} triangles)"

    def _repr_html_(self) -> str:
        return _notebook.report_html("level of a stream", self.report)


def decode(
    chunks: Iterable[Buffer],
    *,
    strips: bool = False,
    partial: bool = False,
    max_bytes: int | None = None,
    max_triangles: int | None = None,
) -> Iterator[Decoder]:
    r"""Decode a progressive GLB from an iterable of bytes, such as the body of an HTTP response.

    Yields the decoder after each piece.

    Args:
        chunks: the bytes of the file in pieces of any size.
        strips: see `Decoder`.
        partial: whether the bytes may end early. The last decoder is then incomplete.
        max_bytes: see `Decoder`.
        max_triangles: see `Decoder`.

    Raises:
        FormatError: the bytes are invalid, or end early.
        LimitError: the file exceeds the limits.

    >>> import numpy, tristrip
    >>> x, y = numpy.meshgrid(numpy.arange(30), numpy.arange(30))
    >>> lines = [f"v {a} {b} {a * b % 3}" for a, b in zip(x.ravel(), y.ravel())]
    >>> lines += [f"f {i + 1} {i + 2} {i + 32} {i + 31}" for i in range(869) if i % 30 != 29]
    >>> data = tristrip.pack("\n".join(lines).encode(), format="obj").bytes
    >>> counts = [state.triangle_count for state in tristrip.decode([data[:-100], data[-100:]])]
    >>> counts[0] < counts[1], counts[1]
    (True, 1682)
    """
    from ._native import Decoder

    decoder = Decoder(strips=strips, max_bytes=max_bytes, max_triangles=max_triangles)
    for piece in chunks:
        decoder.update(piece)
        yield decoder
    if not partial:
        decoder.finish()
