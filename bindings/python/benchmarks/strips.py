"""Compare strips by this package, PyFFI and VTK in one run, prove each result, and write a table.

    TRISTRIP_MODELS=models python benchmarks/strips.py   # some minutes, mostly for PyFFI on the dragon
    TRISTRIP_MODELS=models python benchmarks/strips.py --models bunny --output -

Each program gets the input in its native form: NumPy arrays, a `PolyData` or lists of tuples.
Conversions are not timed. PyFFI runs once; the time of the others is the minimum of `--repeat`
runs.
"""

from __future__ import annotations

import argparse
import os
import platform
import sys
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import pyffi
import pyffi.utils.tristrip
import pyvista
import vtk
from common import ROOT, folder_of_models, timed

import tristrip
import tristrip.compat.pyffi

Triangles = npt.NDArray[np.int64]


class Row(NamedTuple):
    """The measurements of one program on one model."""

    program: str
    seconds: float
    strips: int
    indices: int
    proof: str
    is_exact: bool


def triangles_of(vertices: Triangles, offsets: Triangles) -> Triangles:
    """Return the triangles of strips, shape (n, 3), without code of the package."""
    sizes = np.diff(offsets)
    counts = np.maximum(sizes - 2, 0)
    within = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    start = np.repeat(offsets[:-1], counts) + within
    odd = within % 2
    drawn = np.column_stack([vertices[start], vertices[start + 1 + odd], vertices[start + 2 - odd]])
    a, b, c = drawn.T
    return drawn[(a != b) & (b != c) & (c != a)]


def sorted_triangles(triangles: Triangles, *, keep_winding: bool) -> Triangles:
    """Return triangles in a canonical order, each starting at its lowest corner."""
    if keep_winding:
        first = np.argmin(triangles, axis=1)
        columns = (first[:, None] + np.arange(3)) % 3
        triangles = np.take_along_axis(triangles, columns, axis=1)
    else:
        triangles = np.sort(triangles, axis=1)
    return triangles[np.lexsort(triangles.T[::-1])]


def proof_of(vertices: Triangles, offsets: Triangles, faces: Triangles) -> tuple[str, bool]:
    """Prove strips twice: with this package, and by sorting the triangles with NumPy."""
    restarts = np.insert(vertices, offsets[1:-1], np.iinfo(np.uint32).max).astype(np.uint32)
    try:
        tristrip.Strips.from_indices(restarts).verify(faces)
        is_verified = True
    except tristrip.NotProvenError:
        is_verified = False
    drawn = triangles_of(vertices, offsets)
    is_exact = np.array_equal(sorted_triangles(drawn, keep_winding=True), sorted_triangles(faces, keep_winding=True))
    if is_exact != is_verified:
        raise SystemExit("the two proofs disagree")
    if is_exact:
        return "yes", True
    if np.array_equal(sorted_triangles(drawn, keep_winding=False), sorted_triangles(faces, keep_winding=False)):
        known = {tuple(face) for face in sorted_triangles(faces, keep_winding=True).tolist()}
        flipped = sum(tuple(face) not in known for face in sorted_triangles(drawn, keep_winding=True).tolist())
        return f"no: {flipped:,} triangles flipped", False
    return f"no: draws {len(drawn):,} triangles", False


def row(program: str, seconds: float, strips: list[Any], faces: Triangles) -> Row:
    """Count and prove the strips of a program."""
    vertices = np.concatenate([np.asarray(strip, np.int64) for strip in strips])
    offsets = np.concatenate([[0], np.cumsum([len(strip) for strip in strips])]).astype(np.int64)
    proof, is_exact = proof_of(vertices, offsets, faces)
    return Row(program, seconds, len(strips), len(vertices) + len(strips) - 1, proof, is_exact)


def rows_of(path: Path, repeat: int, *, with_pyffi: bool) -> tuple[int, list[Row]]:
    """Measure all programs on one model."""
    mesh = pyvista.read(path).triangulate()
    mesh.clear_data()
    faces = np.ascontiguousarray(mesh.regular_faces, np.uint32)
    wide = faces.astype(np.int64)
    rows = []
    for method in ("best", "sequential"):
        seconds, strips = timed(lambda method=method: tristrip.stripify(faces, method=method), repeat)
        rows.append(row(f"tristrip.stripify, method {method}", seconds, list(strips), wide))
    length = 1_000_000
    seconds, stripped = timed(lambda: mesh.strip(max_length=length), repeat)
    rows.append(row(f"vtkStripper, max_length={length:,}", seconds, list(tristrip.strips_from_pyvista(stripped)), wide))
    given = [tuple(face) for face in faces.tolist()]
    seconds, strips = timed(lambda: tristrip.compat.pyffi.stripify(given), repeat)
    rows.append(row("tristrip.compat.pyffi.stripify", seconds, strips, wide))
    if with_pyffi:
        seconds, strips = timed(lambda: pyffi.utils.tristrip.stripify(given), 1)
        rows.append(row("pyffi.utils.tristrip.stripify", seconds, strips, wide))
    return len(faces), rows


def table(name: str, triangle_count: int, rows: list[Row]) -> str:
    """Return the table of one model."""
    lines = [
        f"## {name}: {triangle_count:,} triangles",
        "",
        "| program | time | strips | indices with restarts | per triangle | winding exact? |",
        "|---|---:|---:|---:|---:|---|",
    ]
    for one in rows:
        share = one.indices / triangle_count
        lines.append(
            f"| {one.program} | {one.seconds:.3f} s | {one.strips:,} | {one.indices:,} | {share:.3f} | {one.proof} |"
        )
    return "\n".join([*lines, ""])


def comparisons(rows: list[Row]) -> list[str]:
    """Compare the methods of this package with the other programs."""
    own = [one for one in rows if one.program.startswith("tristrip.stripify")]
    peers = [one for one in rows if not one.program.startswith("tristrip")]
    said = []
    for peer in peers:
        for one in own:
            ratio = peer.seconds / one.seconds
            speed = f"{ratio:,.0f} times as fast" if ratio >= 10 else f"{ratio:.2f} times as fast"
            fewer = 1 - one.indices / peer.indices
            said.append(f"- {one.program}: {speed} as {peer.program}, with {fewer:.1%} fewer indices")
    return said


def main() -> int:
    """Measure, print and write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--models", nargs="+", default=["bunny", "dragon"], help="names of PLY files without .ply")
    parser.add_argument("--repeat", type=int, default=3, help="runs of all programs except PyFFI")
    parser.add_argument("--without-pyffi", action="store_true", help="skip PyFFI, which is slow")
    parser.add_argument("--remark", help="a sentence to add to the page, such as on other load of the machine")
    parser.add_argument("--output", default=str(ROOT / "docs/python-strips.md"), help='output file, "-" for none')
    options = parser.parse_args()
    texts = [
        "# Strips in Python",
        "",
        "Written by `bindings/python/benchmarks/strips.py`. Each result is proven by `Strips.verify` and,",
        "independently, by sorting the drawn triangles with NumPy. Times are the minimum of",
        f"{options.repeat} runs, for PyFFI one run, without the conversion of the input.",
        "",
        f"Python {platform.python_version()}, NumPy {np.__version__}, tristrip {tristrip.__version__},",
        f"PyFFI {pyffi.__version__}, VTK {vtk.VTK_VERSION} through PyVista {pyvista.__version__},",
        f"{os.cpu_count()} processors.",
        *([options.remark] if options.remark else []),
        "",
    ]
    is_good = True
    for name in options.models:
        triangle_count, rows = rows_of(
            folder_of_models() / f"{name}.ply", options.repeat, with_pyffi=not options.without_pyffi
        )
        text = table(name, triangle_count, rows) + "\n" + "\n".join(comparisons(rows)) + "\n"
        print(text, flush=True)
        texts.append(text)
        is_good &= all(one.is_exact for one in rows if one.program.startswith("tristrip"))
    if options.output != "-":
        Path(options.output).write_text("\n".join(texts), encoding="utf-8")
    return 0 if is_good else 1


if __name__ == "__main__":
    sys.exit(main())
