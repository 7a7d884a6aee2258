"""Compare simplification by tristrip, fast_simplification and VTK, and write a table.

    TRISTRIP_MODELS=models python benchmarks/simplify.py   # some minutes
    TRISTRIP_MODELS=models python benchmarks/simplify.py --models cow --output -

All programs simplify to 5 % of the triangles. VTK, not this package, measures the distances between
the surfaces: from points sampled uniformly on each surface to the nearest point of the other.
"""

from __future__ import annotations

import argparse
import os
import platform
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import fast_simplification
import numpy as np
import numpy.typing as npt
import pyvista
import vtk
from common import ROOT, folder_of_models, timed

import tristrip

if TYPE_CHECKING:
    from collections.abc import Callable

SHARE = 0.05
#: Sample points per surface.
POINTS = 200_000
Points = npt.NDArray[np.float64]


class Row(NamedTuple):
    """The measurements of one program on one model. Distances are in percent of the diagonal."""

    program: str
    seconds: float
    triangles: int
    rms: float
    largest: float


def spread(vertices: Points, faces: npt.NDArray[Any], count: int) -> Points:
    """Sample points uniformly on triangles."""
    random = np.random.default_rng(0)
    corners = vertices[faces]
    sides = corners[:, 1:] - corners[:, :1]
    areas = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    chosen = random.choice(len(faces), count, p=areas / areas.sum())
    shares = np.sort(random.random((count, 2)), axis=1)
    a, b, c = shares[:, :1], shares[:, 1:] - shares[:, :1], 1 - shares[:, 1:]
    triangles = corners[chosen]
    points: Points = a * triangles[:, 0] + b * triangles[:, 1] + c * triangles[:, 2]
    return points


def distances(points: Points, vertices: Points, faces: npt.NDArray[Any]) -> Points:
    """Return the distance of each point from a surface."""
    surface = pyvista.PolyData.from_regular_faces(vertices, faces)
    _, nearest = surface.find_closest_cell(points, return_closest_point=True)
    found: Points = np.linalg.norm(nearest - points, axis=1)
    return found


def row(program: str, seconds: float, first: tuple[Any, Any], second: tuple[Any, Any]) -> Row:
    """Measure the distances between two surfaces, in both directions."""
    surfaces = [(np.asarray(points, np.float64), np.asarray(faces, np.int64)) for points, faces in (first, second)]
    found = [distances(spread(*surface, POINTS), *other) for surface, other in (surfaces, surfaces[::-1])]
    both = np.concatenate(found)
    percent = 100 / np.linalg.norm(np.ptp(surfaces[0][0], axis=0))
    rms, largest = percent * np.sqrt(np.mean(both**2)), percent * both.max()
    return Row(program, seconds, len(second[1]), float(rms), float(largest))


def rows_of(path: Path, repeat: int) -> tuple[int, list[Row]]:
    """Measure all programs on one model."""
    mesh = pyvista.read(path).triangulate()
    mesh.clear_data()
    vertices = np.ascontiguousarray(mesh.points, np.float32)
    faces = np.ascontiguousarray(mesh.regular_faces, np.uint32)
    goal = round(SHARE * len(faces))
    own: dict[str, Any] = {"triangles": goal, "error": "100%", "measure": False}

    def decimated() -> tuple[Any, Any]:
        small = mesh.decimate(1 - SHARE)
        return small.points, small.regular_faces

    def fast(aggression: int) -> tuple[Any, Any]:
        small: tuple[Any, Any] = fast_simplification.simplify(
            vertices, faces.astype(np.int32), target_count=goal, agg=aggression
        )
        return small

    programs: dict[str, Callable[[], Any]] = {
        "tristrip.simplify, fit=True": lambda: tristrip.simplify(vertices, faces, fit=True, **own),
        "tristrip.simplify": lambda: tristrip.simplify(vertices, faces, **own),
        'tristrip.simplify, fit=True, price="planes"': lambda: tristrip.simplify(
            vertices, faces, fit=True, price="planes", **own
        ),
        "fast_simplification, agg=7": lambda: fast(7),
        "fast_simplification, agg=3": lambda: fast(3),
        "pyvista.decimate": decimated,
    }
    rows = []
    for program, run in programs.items():
        seconds, small = timed(run, repeat)
        rows.append(row(program, seconds, (vertices, faces), tuple(small)))
    return len(faces), rows


def table(name: str, triangle_count: int, rows: list[Row]) -> str:
    """Return the table of one model."""
    lines = [
        f"## {name}: {triangle_count:,} triangles",
        "",
        "| program | time | triangles | RMS | largest |",
        "|---|---:|---:|---:|---:|",
        *(
            f"| {one.program} | {one.seconds:.3f} s | {one.triangles:,} | {one.rms:.4f} % | {one.largest:.3f} % |"
            for one in rows
        ),
        "",
    ]
    return "\n".join(lines)


def main() -> int:
    """Measure, print and write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    usual = ["cow", "fandisk", "bunny", "horse", "armadillo_43k", "dragon"]
    parser.add_argument("--models", nargs="+", default=usual, help="names of PLY files without .ply")
    parser.add_argument("--repeat", type=int, default=3, help="runs of each program")
    parser.add_argument("--remark", help="a sentence to add to the page, such as on other load of the machine")
    parser.add_argument("--output", default=str(ROOT / "docs/python-simplify.md"), help='output file, "-" for none')
    options = parser.parse_args()
    texts = [
        "# Simplification in Python",
        "",
        f"Written by `bindings/python/benchmarks/simplify.py`. Target: {100 * SHARE:.0f} % of the triangles. Distances",
        f"are in percent of the diagonal, measured by VTK from {POINTS:,} points of each surface to the other. Times",
        "are from one run." if options.repeat == 1 else f"are the minimum of {options.repeat} runs.",
        "",
        f"Python {platform.python_version()}, NumPy {np.__version__}, tristrip {tristrip.__version__},",
        f"fast_simplification {fast_simplification.__version__}, VTK {vtk.VTK_VERSION} through PyVista",
        f"{pyvista.__version__}, {os.cpu_count()} processors.",
        *([options.remark] if options.remark else []),
        "",
    ]
    closest = 0
    for name in options.models:
        triangle_count, rows = rows_of(folder_of_models() / f"{name}.ply", options.repeat)
        text = table(name, triangle_count, rows)
        print(text, flush=True)
        texts.append(text)
        # Skip programs that left many more triangles.
        most = 1.01 * SHARE * triangle_count + 1
        peers = [one for one in rows if not one.program.startswith("tristrip") and one.triangles <= most]
        closest += all(rows[0].rms <= one.rms for one in peers)
    of_models = f"{closest} of {len(options.models)} models"
    texts += [
        f"Among programs that reach the target, `tristrip.simplify` has the lowest RMS on {of_models}.",
        "",
    ]
    print(texts[-2])
    if options.output != "-":
        Path(options.output).write_text("\n".join(texts), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
