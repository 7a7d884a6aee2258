#!/usr/bin/env python3
"""Draws the figures of the manual into src/figures, and the image of the README.

    docs/manual/figures.py          write them
    docs/manual/figures.py --check  fail if a figure is missing, differs, or has no generator

Diagrams are SVG, written by this file. Images of models are drawn by the command that TRISTRIP_COMMAND names
(default: target/debug/tristrip) from testdata/models. The same input gives the same bytes on every machine.
"""

import math
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
FIGURES = "manual/src/figures"
TARGET = Path(os.environ.get("CARGO_TARGET_DIR") or ROOT / "target")
COMMAND = Path(os.environ.get("TRISTRIP_COMMAND") or TARGET / "debug" / "tristrip").resolve()

Point = tuple[float, float]
INK, FAINT = "#1b2a3a", "#9aa7b4"
FILLS = ["#bcd7f2", "#f6cfa3", "#c3e3bd", "#e5c3e8", "#f3e3a0"]
LINES = ["#1f6fb8", "#c8701a", "#3b8a36", "#8c3f96", "#a08612"]


def number(value: float) -> str:
    return f"{value:.1f}".removesuffix(".0")


class Drawing:
    """An SVG image on a white ground, which readers see with light and dark themes."""

    def __init__(self, width: int, height: int, title: str) -> None:
        self.parts = [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" '
            f'height="{height}" font-family="sans-serif" font-size="14" role="img">',
            f"<title>{title}</title>",
            f'<rect width="{width}" height="{height}" fill="#ffffff"/>',
        ]

    def polygon(self, points: Iterable[Point], fill: str, line: str = INK) -> None:
        corners = " ".join(f"{number(x)},{number(y)}" for x, y in points)
        self.parts.append(f'<polygon points="{corners}" fill="{fill}" stroke="{line}" stroke-linejoin="round"/>')

    def line(self, points: Sequence[Point], color: str = INK, width: float = 1, dash: str = "", arrow: bool = False) -> None:
        corners = " ".join(f"{number(x)},{number(y)}" for x, y in points)
        dashes = f' stroke-dasharray="{dash}"' if dash else ""
        self.parts.append(
            f'<polyline points="{corners}" fill="none" stroke="{color}" stroke-width="{number(width)}"{dashes}'
            ' stroke-linecap="round" stroke-linejoin="round"/>'
        )
        if arrow:
            (x0, y0), (x1, y1) = points[-2:]
            angle = math.atan2(y1 - y0, x1 - x0)
            back = [(x1 - 11 * math.cos(angle + turn), y1 - 11 * math.sin(angle + turn)) for turn in (0.4, -0.4)]
            self.polygon([(x1, y1), *back], color, color)

    def dot(self, at: Point, fill: str = INK, radius: float = 3.5) -> None:
        self.parts.append(f'<circle cx="{number(at[0])}" cy="{number(at[1])}" r="{number(radius)}" fill="{fill}" stroke="{INK}"/>')

    def text(self, at: Point, text: str, color: str = INK, size: int = 14, anchor: str = "middle", weight: str = "normal") -> None:
        escaped = text.replace("&", "&amp;").replace("<", "&lt;")
        self.parts.append(
            f'<text x="{number(at[0])}" y="{number(at[1])}" fill="{color}" font-size="{size}" '
            f'text-anchor="{anchor}" font-weight="{weight}">{escaped}</text>'
        )

    def row(self, at: Point, entries: Sequence[str], marked: Iterable[int] = (), fill: str = "#eef2f6") -> None:
        """Draws an index buffer: one cell per entry, marked ones in another colour."""
        marks = set(marked)
        for i, entry in enumerate(entries):
            x = at[0] + 30 * i
            self.polygon([(x, at[1]), (x + 30, at[1]), (x + 30, at[1] + 26), (x, at[1] + 26)], FILLS[1] if i in marks else fill)
            self.text((x + 15, at[1] + 18), entry)

    def bytes(self) -> bytes:
        return ("\n".join([*self.parts, "</svg>"]) + "\n").encode()


def center(points: Sequence[Point]) -> Point:
    return sum(x for x, _ in points) / len(points), sum(y for _, y in points) / len(points)


def strip() -> bytes:
    """A strip of six triangles, with the winding of each."""
    image = Drawing(640, 230, "A triangle strip")
    at = [(60 + 75 * i, 150 if i % 2 == 0 else 40) for i in range(8)]
    for i in range(6):
        corners = at[i : i + 3]
        image.polygon(corners, FILLS[i % 2])
        image.text((center(corners)[0], center(corners)[1] + 5), f"T{i}")
    for i, (x, y) in enumerate(at):
        image.dot((x, y))
        image.text((x, y + (20 if i % 2 == 0 else -10)), str(i), weight="bold")
    image.row((60, 188), [str(i) for i in range(8)])
    image.text((320, 206), "T0 = (0 1 2), T1 = (2 1 3), T2 = (2 3 4), …", anchor="start")
    return image.bytes()


def swap() -> bytes:
    """A strip that turns to the same side twice, by a repeated vertex."""
    image = Drawing(640, 250, "A swap")
    # Around vertex 1: 0, 2, 3, 4.
    at = {0: (70, 150), 2: (110, 40), 1: (215, 160), 3: (250, 35), 4: (360, 95)}
    for i, triangle in enumerate([(0, 1, 2), (2, 1, 3), (3, 1, 4)]):
        corners = [at[v] for v in triangle]
        image.polygon(corners, FILLS[i % 2])
        image.text((center(corners)[0], center(corners)[1] + 5), f"T{i}")
    for v, (x, y) in at.items():
        image.dot((x, y))
        image.text((x, y + (22 if v in (0, 1, 4) else -10)), str(v), weight="bold")
    image.row((60, 200), ["0", "1", "2", "1", "3", "4"], [3])
    image.text((270, 218), "the second 1 is the swap: (1 2 1) is degenerate", anchor="start")
    image.text((400, 70), "T0, T1 and T2 turn around vertex 1.", anchor="start", size=13)
    image.text((400, 90), "A plain strip alternates sides.", anchor="start", size=13)
    return image.bytes()


def layouts() -> bytes:
    """Two strips in the four layouts."""
    image = Drawing(640, 330, "Two strips in four layouts")
    first = [(40, 90), (95, 20), (120, 100), (180, 30)]
    second = [(280, 95), (330, 25), (380, 100)]
    for i in range(2):
        image.polygon(first[i : i + 3], FILLS[0])
    image.polygon(second, FILLS[2])
    for v, (x, y) in enumerate([*first, *second]):
        image.dot((x, y))
        image.text((x, y + (19 if y > 60 else -7)), str(v), weight="bold")
    rows = [
        ("degenerate", ["0", "1", "2", "3", "3", "4", "4", "5", "6"], [4, 5]),
        ("restart", ["0", "1", "2", "3", "R", "4", "5", "6"], [4]),
        ("separate", ["0", "1", "2", "3", "", "4", "5", "6"], []),
        ("list", ["0", "1", "2", "2", "1", "3", "4", "5", "6"], []),
    ]
    for i, (name, entries, marked) in enumerate(rows):
        y = 135 + 46 * i
        image.text((120, y + 18), name, anchor="end", weight="bold")
        if name == "separate":
            image.row((140, y), entries[:4])
            image.row((140 + 30 * 5, y), entries[5:])
        else:
            image.row((140, y), entries, marked)
    notes = ["one strip, repeated vertices", "R is the restart index", "two draw calls", "three indices per triangle"]
    for i, note in enumerate(notes):
        image.text((430, 153 + 46 * i), note, anchor="start", size=13)
    return image.bytes()


def dual_graph() -> bytes:
    """A mesh, its dual graph, and a cover of three paths."""
    image = Drawing(700, 260, "A mesh, its dual graph and a path cover")
    columns, rows, side = 3, 3, 62
    cells = [(c, r) for r in range(rows) for c in range(columns)]
    triangles = []
    for c, r in cells:
        a, b, d, e = (c, r), (c + 1, r), (c, r + 1), (c + 1, r + 1)
        triangles += [(a, b, d), (b, e, d)]
    edges: dict[frozenset[tuple[int, int]], list[int]] = {}
    for t, corners in enumerate(triangles):
        for i in range(3):
            edges.setdefault(frozenset((corners[i], corners[(i + 1) % 3])), []).append(t)
    arcs = [pair for pair in edges.values() if len(pair) == 2]
    # The rows are paths; the last two are joined at the right border, where a swap turns the strip around.
    paths = [list(range(6)), list(range(6, 12)) + list(range(17, 11, -1))]
    owner = {t: i for i, path in enumerate(paths) for t in path}
    neighbours = {frozenset(pair) for pair in arcs}
    broken = [(a, b) for path in paths for a, b in zip(path, path[1:]) if frozenset((a, b)) not in neighbours]
    if broken:
        paths = [list(range(6)), list(range(6, 12)), list(range(12, 18))]
        owner = {t: i for i, path in enumerate(paths) for t in path}
    for panel, name in enumerate(["mesh", "dual graph", "path cover: 3 strips"]):
        left = 25 + 230 * panel

        def place(corner: tuple[int, int], left: int = left) -> Point:
            # The rows are sheared a little, so that triangles look general.
            return left + side * corner[0] + 5 * corner[1] - 4, 28 + side * corner[1] + 4 * math.sin(2.0 * corner[0])

        middles = [center([place(v) for v in corners]) for corners in triangles]
        for t, corners in enumerate(triangles):
            fill = ["#eef2f6", "#f7f9fb", FILLS[owner[t]]][panel]
            image.polygon([place(v) for v in corners], fill, INK if panel == 0 else FAINT)
        if panel == 1:
            for a, b in arcs:
                image.line([middles[a], middles[b]], LINES[0], 1.5)
        if panel == 2:
            for i, path in enumerate(paths):
                image.line([middles[t] for t in path], LINES[i], 2.5)
        if panel > 0:
            for t, middle in enumerate(middles):
                image.dot(middle, LINES[0] if panel == 1 else LINES[owner[t]])
        image.text((left + 100, 250), name, weight="bold")
    return image.bytes()


def collapse() -> bytes:
    """A half-edge collapse: a vertex takes the place of its neighbour."""
    image = Drawing(640, 270, "A half-edge collapse")
    ring = [(40, 120), (95, 35), (205, 40), (255, 125), (190, 205), (90, 200)]
    removed, kept = (140, 125), 3
    fan = [(i, (i + 1) % 6) for i in range(6)]
    for i, (a, b) in enumerate(fan):
        vanishing = kept in (a, b)
        image.polygon([ring[a], ring[b], removed], FILLS[1] if vanishing else FILLS[0])
    image.line([removed, (243, 125)], LINES[1], 2.5, arrow=True)
    shift = 345
    moved = [(x + shift, y) for x, y in ring]
    for a, b in fan:
        if kept not in (a, b):
            image.polygon([moved[a], moved[b], moved[kept]], FILLS[0])
    image.line([(285, 120), (345, 120)], INK, 1.5, arrow=True)
    for points in (ring, moved):
        for point in points:
            image.dot(point)
    image.dot(removed, "#ffffff", 5)
    image.text((140, 115), "v", weight="bold")
    image.text((270, 118), "u", weight="bold", anchor="start")
    image.text((615, 118), "u", weight="bold", anchor="start")
    image.text((150, 235), "6 triangles around v")
    image.text((490, 235), "4 triangles; v is renamed to u")
    image.text((320, 260), "The two orange triangles have v and u as corners. They become degenerate and are removed.", size=13)
    return image.bytes()


def merge_tree() -> bytes:
    """A merge tree, and the vertices that two views draw."""
    image = Drawing(640, 285, "A merge tree and two views of it")
    # Every collapse removes the right child; the parent is the kept vertex at a coarser position.
    depth = 3
    nodes: dict[tuple[int, int], Point] = {}
    for level in range(depth + 1):
        count = 2**level
        for i in range(count):
            nodes[level, i] = (60 + 520 * (i + 0.5) / count, 50 + 58 * level)
    for (level, i), point in nodes.items():
        if level:
            image.line([nodes[level - 1, i // 2], point], FAINT, 1.2)
    near = [(2, 0), (3, 2), (3, 3), (2, 2), (2, 3)]
    coarse = [(1, 0), (1, 1)]
    for cut, color, width in ((near, LINES[1], 3), (coarse, LINES[0], 3)):
        points = [nodes[node] for node in cut]
        line = [(points[0][0] - 45, points[0][1]), *points, (points[-1][0] + 45, points[-1][1])]
        image.line(line, color, width, dash="2 6")
    for node, point in nodes.items():
        fill = FILLS[1] if node in near else FILLS[0] if node in coarse else "#ffffff"
        image.dot(point, fill, 7)
    image.text((10, 54), "base mesh", anchor="start", size=13)
    image.text((10, 250), "full mesh: every leaf is a vertex of the input", anchor="start", size=13)
    image.text((10, 273), "blue: a distant camera draws 2 vertices", LINES[0], 13, "start")
    image.text((330, 273), "orange: a camera close to the left half draws 5", LINES[1], 13, "start")
    return image.bytes()


def stream() -> bytes:
    """The file of a progressive GLB, and what a client draws of it."""
    image = Drawing(680, 215, "A progressive GLB")
    cells = [("glTF JSON", 90, "#eef2f6"), ("base mesh, textures", 140, FILLS[0])]
    cells += [(f"chunk {i}", 62 + 14 * i, FILLS[2]) for i in range(4)] + [("…", 40, FILLS[2])]
    x, ends = 30.0, []
    for name, width, fill in cells:
        image.polygon([(x, 40), (x + width, 40), (x + width, 85), (x, 85)], fill)
        image.text((x + width / 2, 68), name, size=13)
        x += width
        ends.append(x)
    image.text((30, 28), "bytes of the file, in the order in which they arrive", anchor="start", size=13)
    for end, text in ((ends[1], "base mesh"), (ends[3], "992 triangles"), (ends[4], "2,358"), (ends[5], "4,138")):
        image.line([(end, 118), (end, 90)], INK, 1.5, arrow=True)
        image.text((end, 135), text, size=13)
    image.text((30, 168), "After the base mesh, and after each complete chunk, the client has a mesh to draw.", anchor="start", size=13)
    image.text((30, 190), "An interrupted download resumes at the byte where the next chunk starts.", anchor="start", size=13)
    return image.bytes()


def by_command() -> dict[str, bytes]:
    """Returns the images that the command draws, by their paths in docs."""
    models = ROOT / "testdata" / "models"
    with tempfile.TemporaryDirectory() as folder:
        runs = {
            "hand.png": ["simplify", models / "hand.ply", "--ratio", "10%", "--fit", "--picture", "hand.png"],
            f"{FIGURES}/fish-strips.png": ["strip", models / "fish_control.ply", "--picture", "fish-strips.png"],
            "": ["pack", models / "hand.ply", "-o", "hand.glb"],
            f"{FIGURES}/hand-stream.svg": ["inspect", "hand.glb", "--plot", "hand-stream.svg"],
        }
        for arguments in runs.values():
            subprocess.run([COMMAND, "-q", *arguments], cwd=folder, check=True, stdout=subprocess.DEVNULL)
        return {name: (Path(folder) / Path(name).name).read_bytes() for name in runs if name}


def main() -> int:
    if not COMMAND.is_file():
        print(f"{COMMAND} is missing: build it, or name the command in TRISTRIP_COMMAND", file=sys.stderr)
        return 1
    drawn = [strip, swap, layouts, dual_graph, collapse, merge_tree, stream]
    figures = {f"{FIGURES}/{draw.__name__.replace('_', '-')}.svg": draw() for draw in drawn} | by_command()
    if sys.argv[1:] != ["--check"]:
        (DOCS / FIGURES).mkdir(parents=True, exist_ok=True)
        for name, content in figures.items():
            (DOCS / name).write_bytes(content)
        return 0
    problems = []
    for name, content in figures.items():
        path = DOCS / name
        if not path.is_file() or path.read_bytes() != content:
            problems.append(f"{name}: is missing, or differs from what figures.py draws")
    stored = {f"{FIGURES}/{path.name}" for path in (DOCS / FIGURES).iterdir()}
    problems += [f"{name}: figures.py does not draw it" for name in sorted(stored - figures.keys())]
    for problem in problems:
        print(f"docs/{problem}", file=sys.stderr)
    print(f"manual: {len(figures)} figures checked, {len(problems)} problems")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
