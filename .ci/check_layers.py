#!/usr/bin/env python3
"""Checks that modules import only from lower layers: the order stands in layers.txt.

    python3 .ci/check_layers.py [ROOT]

It fails on
- an import of a module of higher or equal rank, and of one that a line `module !other` forbids,
- a circle of modules at any depth, within a layer, too,
- a module or crate that has no place in layers.txt, and an entry of layers.txt that names nothing,
- a dependency between crates of the workspace against their order.

# Algorithm
1. Each file of a crate is a node (rust_modules.py). An edge leads from a file to each other one that defines what it names
   (rust_names.py).
2. Edges between modules of different entries of layers.txt are held to the ranks; strongly connected components of the graph are circles.

Calls of methods name no module, and are not seen.
"""

import sys
from dataclasses import dataclass, field
from pathlib import Path

from rust_modules import Crate, Node, read_workspace
from rust_names import add_edges

LAYERS = ".ci/layers.txt"
TOP = sys.maxsize  # the rank of main.rs and other roots that nothing imports
LIBRARY = TOP - 1  # the rank of lib.rs


@dataclass
class Section:
    """The order of one crate's modules, or of the crates."""

    ranks: dict[str, int] = field(default_factory=dict)  # entry -> line number: a higher line is a lower layer
    forbidden: list[tuple[str, str, int]] = field(default_factory=list)  # (module, what it may not import, line)

    def entry(self, module: str) -> str | None:
        """Returns the entry that a module belongs to: itself or the nearest ancestor that is listed."""
        while module not in self.ranks:
            if "::" not in module:
                return None
            module = module.rpartition("::")[0]
        return module


def read_layers(text: str) -> dict[str, Section]:
    """Returns the sections of layers.txt. Modules on one line have the same rank."""
    sections: dict[str, Section] = {}
    section = Section()
    for number, line in enumerate(text.splitlines(), 1):
        words = line.partition("#")[0].split()
        if not words:
            continue
        if words[0].startswith("["):
            section = sections.setdefault(words[0].strip("[]"), Section())
        elif any(word.startswith("!") for word in words):
            section.forbidden += [(words[0], word.lstrip("!"), number) for word in words[1:]]
        else:
            section.ranks.update(dict.fromkeys(words, number))
    return sections


def check_crates(crates: list[Crate], order: Section) -> list[str]:
    """Holds dependencies, and names of crates in the code, to the order of the crates."""
    found = []
    packages = {crate.package for crate in crates}
    by_library = {crate.library: crate.package for crate in crates}

    def refuse(package: str, other: str) -> str:
        if package not in order.ranks or other not in order.ranks or order.ranks[other] < order.ranks[package]:
            return ""
        return f"which is not below it in the section [crates] of {LAYERS}"

    for crate in crates:
        if crate.package not in order.ranks:
            found.append(f"{crate.manifest}: crate {crate.package} has no place in the section [crates] of {LAYERS}")
        for name, line in crate.dependencies.items():
            if name in packages and (why := refuse(crate.package, name)):
                found.append(f"{crate.manifest}:{line}: {crate.package} depends on {name}, {why}")
        for node in crate.nodes:
            for library, line in node.crates:
                if why := refuse(crate.package, by_library[library]):
                    found.append(f"{node.path}:{line}: {crate.package} uses {by_library[library]}, {why}")
    found += [f"{LAYERS}:{line}: no crate {name}" for name, line in order.ranks.items() if name not in packages]
    return found


def check_modules(crate: Crate, section: Section) -> list[str]:
    """Holds the edges between modules to their ranks, and looks for circles."""
    found = []
    names = {node.name for node in crate.nodes}
    for node in crate.nodes:
        # Only the outermost of several that have no place.
        if not node.is_root and section.entry(node.name) is None and node.name.rpartition("::")[0] not in names:
            found.append(f"{node.path}: module {node.name} has no place in the section [{crate.package}] of {LAYERS}")
        for other, evidence in node.edges.items():
            if why := why_forbidden(node, other, section):
                line, written = min(evidence)
                more = f" (and {len(evidence) - 1} more)" if len(evidence) > 1 else ""
                found.append(f"{node.path}:{line}: {node.name} imports {other.name} as `{written}`{more}: {why}")
    listed = [(name, line) for name, line in section.ranks.items()]
    listed += [(name, line) for *pair, line in section.forbidden for name in pair]
    unknown = dict.fromkeys((name, line) for name, line in listed if name not in names)
    found += [f"{LAYERS}:{line}: {crate.package} has no module {name}" for name, line in unknown]
    return found + [describe_circle(circle) for circle in circles(crate.nodes)]


def why_forbidden(node: Node, other: Node, section: Section) -> str:
    """Returns why a module may not import another; an empty text where it may."""
    for module, forbidden, line in section.forbidden:
        if is_within(node.name, module) and is_within(other.name, forbidden):
            return f"{LAYERS}:{line} forbids {module} to import {forbidden}"
    mine, theirs = place(node, section), place(other, section)
    if mine is None or theirs is None or mine[0] == theirs[0] or theirs[1] < mine[1]:
        return ""
    if theirs[1] >= LIBRARY:
        return f"{other.name} is the root of the crate; move the item into a module"
    relation = "the same rank" if mine[1] == theirs[1] else "a higher rank"
    return f"{theirs[0]} has {relation} ({LAYERS}:{theirs[1]}; {mine[0]}: line {mine[1]})"


def is_within(name: str, module: str) -> bool:
    return name == module or name.startswith(module + "::")


def place(node: Node, section: Section) -> tuple[str, int] | None:
    """Returns entry and rank of a module. A root that is not listed is above all others."""
    if node.is_root and node.name not in section.ranks:
        return node.name, LIBRARY if node.name == "lib" else TOP
    entry = section.entry(node.name)
    return (entry, section.ranks[entry]) if entry else None


def circles(nodes: list[Node]) -> list[list[Node]]:
    """Returns the strongly connected components of two or more files (Tarjan 1972)."""
    index: dict[Node, int] = {}
    low: dict[Node, int] = {}
    stack: list[Node] = []
    on_stack: set[Node] = set()
    found: list[list[Node]] = []

    def visit(node: Node) -> None:
        index[node] = low[node] = len(index)
        stack.append(node)
        on_stack.add(node)
        for other in node.edges:
            if other not in index:
                visit(other)
                low[node] = min(low[node], low[other])
            elif other in on_stack:
                low[node] = min(low[node], index[other])
        if low[node] == index[node]:
            component = []
            while not component or component[-1] is not node:
                component.append(stack.pop())
                on_stack.remove(component[-1])
            if len(component) > 1:
                found.append(sorted(component, key=lambda node: node.name))

    for node in nodes:
        if node not in index:
            visit(node)
    return found


def describe_circle(circle: list[Node]) -> str:
    """Returns a message with a line of evidence for every edge within a circle."""
    lines = [f"circle of {len(circle)} modules in {circle[0].crate.package}: {', '.join(node.name for node in circle)}"]
    for node in circle:
        for other in (other for other in node.edges if other in circle):
            line, written = min(node.edges[other])
            lines.append(f"    {node.path}:{line}: {node.name} imports {other.name} as `{written}`")
    return "\n".join(lines)


def problems(root: Path) -> list[str]:
    """Returns a message for everything that is against the order."""
    layers = read_layers((root / LAYERS).read_text(encoding="utf-8"))
    crates = read_workspace(root)
    found = check_crates(crates, layers.get("crates", Section()))
    libraries = {crate.library for crate in crates}
    for crate in crates:
        add_edges(crate, libraries)
        found += check_modules(crate, layers.get(crate.package, Section()))
    return found


def main() -> int:
    root = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parent.parent)
    found = problems(root.resolve())
    print("\n".join(found + [f"layers: {len(found)} problems"]))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
