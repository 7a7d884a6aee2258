#!/usr/bin/env python3
"""Checks that modules import only from lower layers: the order stands in layers.txt.

    python3 .ci/check_layers.py [ROOT]

It fails on
- an import of a module of higher or equal rank, and of one that a line `module !other` forbids,
- a circle of modules at any depth, within a layer, too,
- a module or crate that has no place in layers.txt, and an entry of layers.txt that names nothing,
- a dependency between crates of the workspace against their order.

# Algorithm
1. The modules of a crate are found from its root along its `mod` lines. Code behind `#[cfg(test)]` is left out.
2. Each file is a node. Paths in `use` declarations and in the code (`crate::a::b`, `super::c`, `a::b` with `a` a module or an import) are
   resolved through re-exports to the file that defines the item. That is an edge from the file that names it.
3. No edges are: a line `mod child;`, an import of a module as such (what is named through it counts), and a re-export of a descendant,
   unless the re-exported name is used in the same file.
4. Edges between modules of different entries of layers.txt are held to the ranks; strongly connected components of the graph are circles.

Calls of methods name no module, and are not seen.
"""

import re
import sys
import tomllib
from dataclasses import dataclass, field
from pathlib import Path

from rust_source import bracket_end, code, line_of

LAYERS = ".ci/layers.txt"
TOKEN = re.compile(r"\$crate|[A-Za-z_][A-Za-z0-9_]*|::|\.\.|\S")
NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*$")
DEFINES = {"fn", "struct", "enum", "trait", "type", "const", "static", "union"}
TOP = sys.maxsize  # the rank of main.rs and other roots that nothing imports
LIBRARY = TOP - 1  # the rank of lib.rs


# ---- layers.txt ------------------------------------------------------------------------------------------------------------


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


# ---- modules ---------------------------------------------------------------------------------------------------------------


@dataclass
class Node:
    """A file of a crate."""

    crate: "Crate"
    name: str  # `lod::filter`; the name of a root is `lib`, `main`, `bin::name` …
    path: str
    edges: dict["Node", list[tuple[int, str]]] = field(default_factory=dict)  # imported file -> (line, path as written)
    crates: list[tuple[str, int]] = field(default_factory=list)  # crates of the workspace that its code names

    def __hash__(self) -> int:
        return id(self)

    def __eq__(self, other: object) -> bool:
        return self is other

    def is_above(self, other: "Node") -> bool:
        """Checks whether `other` is a descendant in the module tree."""
        return other is not self and (self.is_root or other.name.startswith(self.name + "::"))

    @property
    def is_root(self) -> bool:
        return any(self is root.node for root in self.crate.roots)


@dataclass
class Use:
    """One name that a `use` declaration binds, or `*`."""

    name: str
    path: list[str]
    line: int
    is_public: bool


@dataclass
class Scope:
    """A module, a file or a `mod name { … }`, as names are looked up in it."""

    node: Node
    parent: "Scope | None"
    root: "Scope | None" = None
    modules: dict[str, "Scope"] = field(default_factory=dict)
    items: set[str] = field(default_factory=set)
    uses: list[Use] = field(default_factory=list)
    paths: list[tuple[list[str], int]] = field(default_factory=list)
    names: dict[str, int] = field(default_factory=dict)  # single names that the code uses, with their first lines

    def __post_init__(self) -> None:
        self.root = self.parent.root if self.parent else self


@dataclass
class Crate:
    """A package of the workspace: its library or command, and further roots."""

    package: str
    manifest: str
    library: str  # the name in paths
    dependencies: dict[str, int] = field(default_factory=dict)  # package -> line in the manifest
    roots: list[Scope] = field(default_factory=list)
    scopes: list[Scope] = field(default_factory=list)
    nodes: list[Node] = field(default_factory=list)


def read_workspace(root: Path) -> list[Crate]:
    """Reads all members of a workspace."""
    members = tomllib.loads((root / "Cargo.toml").read_text())["workspace"]["members"]
    folders = [folder for member in members for folder in sorted(root.glob(member))]
    return [read_crate(root, folder) for folder in folders]


def read_crate(root: Path, folder: Path) -> Crate:
    manifest = (folder / "Cargo.toml").read_text()
    data = tomllib.loads(manifest)
    package = data["package"]["name"]
    library = data.get("lib", {}).get("name", package.replace("-", "_"))
    crate = Crate(package, str((folder / "Cargo.toml").relative_to(root)), library)
    for table in ("dependencies", "build-dependencies", "dev-dependencies"):
        for name in data.get(table, {}):
            match = re.search(rf"(?m)^{re.escape(name)}\b", manifest)
            crate.dependencies[name] = line_of(manifest, match.start()) if match else 1
    for name, path in crate_roots(folder):
        node = Node(crate, name, str(path.relative_to(root)))
        scope = Scope(node, None)
        crate.roots.append(scope)
        read_module(root, path, path.parent, scope)
    return crate


def crate_roots(folder: Path) -> list[tuple[str, Path]]:
    """Returns the roots of a package: its library or command, then what nothing can import."""
    roots = [(name, folder / "src" / f"{name}.rs") for name in ("lib", "main")]
    for name, pattern in [("bin", "src/bin/*.rs"), ("example", "examples/*.rs"), ("bench", "benches/*.rs")]:
        roots += [(f"{name}::{path.stem}", path) for path in sorted(folder.glob(pattern))]
    return [(name, path) for name, path in roots if path.is_file()]


def read_module(root: Path, path: Path, folder: Path, scope: Scope) -> None:
    """Reads a file into its scope, then the files of its modules, which are in `folder`."""
    scope.node.crate.nodes.append(scope.node)
    text = code(path.read_text(encoding="utf-8"), literals=True)
    reader = Reader(text, scope)
    reader.read()
    for name, parent, inner in reader.files:
        below = folder.joinpath(*inner)
        file = next((file for file in (below / f"{name}.rs", below / name / "mod.rs") if file.is_file()), None)
        if file is None:
            continue  # a `#[path]`, which the project does not use
        prefix = "" if scope.node.is_root else scope.node.name + "::"
        node = Node(scope.node.crate, prefix + "::".join([*inner, name]), str(file.relative_to(root)))
        child = Scope(node, parent)
        parent.modules[name] = child
        read_module(root, file, below / name, child)


class Reader:
    """Reads the tokens of a file: modules, items, `use` declarations and paths."""

    def __init__(self, text: str, scope: Scope) -> None:
        self.text = text
        self.tokens = [(match[0], match.start()) for match in TOKEN.finditer(text)]
        self.scope = scope
        self.blocks: list[Scope | None] = [scope]  # a scope for a module, None for any other block
        self.files: list[tuple[str, Scope, list[str]]] = []  # `mod name;`, its scope, the modules around it in this file
        self.inner: list[str] = []
        scope.node.crate.scopes.append(scope)

    def word(self, i: int) -> str:
        return self.tokens[i][0] if 0 <= i < len(self.tokens) else ""

    def line(self, i: int) -> int:
        return line_of(self.text, self.tokens[i][1])

    def read(self) -> None:
        i = 0
        while i < len(self.tokens):
            i = self.step(i)

    def step(self, i: int) -> int:
        """Reads what begins at token `i`, and returns the token behind it."""
        word, after = self.word(i), self.word(i + 1)
        if word == "pub" and after == "(":
            end = bracket_end(self.text, self.tokens[i + 1][1])
            while i < len(self.tokens) and self.tokens[i][1] < end:
                i += 1
            return i
        if word == "mod" and NAME.match(after):
            return self.module(i)
        if word == "use" and self.word(i - 1) != "." and (NAME.match(after) or after in ("{", "::", "*", "$crate")):
            return self.use(i)
        if word == "{":
            self.blocks.append(None)
        elif word == "}" and len(self.blocks) > 1:
            if self.blocks.pop() is not None:
                self.inner.pop()
                self.scope = next(block for block in reversed(self.blocks) if block)
        elif word in DEFINES and self.blocks[-1] is not None:
            return self.definition(i)
        elif NAME.match(word) or word == "$crate":
            return self.path(i)
        return i + 1

    def module(self, i: int) -> int:
        name = self.word(i + 1)
        if self.word(i + 2) == ";":
            self.files.append((name, self.scope, list(self.inner)))
        elif self.word(i + 2) == "{":
            child = Scope(self.scope.node, self.scope)
            child.node.crate.scopes.append(child)
            self.scope.modules[name] = child
            self.scope = child
            self.blocks.append(child)
            self.inner.append(name)
        return i + 3

    def definition(self, i: int) -> int:
        name = i + 1
        while self.word(name) in ("mut", "unsafe", "extern", "async", "fn"):
            name += 1
        if NAME.match(self.word(name)):
            self.scope.items.add(self.word(name))
        return name + 1

    def use(self, i: int) -> int:
        is_public = self.word(i - 1) == "pub" or (self.word(i - 1) == ")" and "pub" in [self.word(i - n) for n in range(2, 8)])
        found, end = self.use_tree(i + 1, [])
        for name, path, line in found:
            self.scope.uses.append(Use(name, path, line, is_public))
        return end + 1

    def use_tree(self, i: int, prefix: list[str]) -> tuple[list[tuple[str, list[str], int]], int]:
        """Reads `a::b`, `a::b as c`, `a::*` or `a::{…}`. Returns the names that it binds, and the token behind it."""
        path = list(prefix)
        while True:
            word = self.word(i)
            if word == "{":
                found, i = [], i + 1
                while self.word(i) not in ("}", ""):
                    more, i = self.use_tree(i, path)
                    found += more
                    i += self.word(i) == ","
                return found, i + 1
            if word == "*":
                return [("*", path, self.line(i))], i + 1
            if word == "::":
                if not path:
                    path.append("::")
                i += 1
                continue
            if not (NAME.match(word) or word == "$crate"):
                return [], i + 1
            if word != "self" or not path:
                path.append(word)
            if self.word(i + 1) == "::":
                i += 2
            elif self.word(i + 1) == "as":
                return [(self.word(i + 2), path, self.line(i))], i + 3
            else:
                return [(path[-1], path, self.line(i))], i + 1

    def path(self, i: int) -> int:
        """Reads a path, or a single name, from its first segment on."""
        start, segments = i, [self.word(i)]
        while self.word(i + 1) == "::" and NAME.match(self.word(i + 2)):
            i += 2
            segments.append(self.word(i))
        if self.word(start - 1) in (".", "'", "::"):
            return i + 1  # a field or method, a lifetime, what follows a generic argument
        if len(segments) > 1:
            self.scope.paths.append((segments, self.line(start)))
        # A name in lower case may be a local variable; it counts where it is called.
        if segments[0][0].isupper() or self.word(i + 1) in ("(", "!") or len(segments) > 1:
            self.scope.names.setdefault(segments[0], self.line(start))
        return i + 1


# ---- names -----------------------------------------------------------------------------------------------------------------


@dataclass
class Target:
    """What a path leads to: a module, an item defined in a module, or another crate."""

    scope: Scope | None
    is_module: bool = False
    crate: str = ""


class Resolver:
    """Follows paths through modules, imports and re-exports."""

    def __init__(self, crate: Crate, libraries: set[str]) -> None:
        self.libraries = libraries - {crate.library}
        # Further roots, such as main.rs beside lib.rs, name the library as another crate.
        self.library = next((root for root in crate.roots if root.node.name == "lib"), None)
        self.own = crate.library

    def resolve(self, scope: Scope, path: list[str], seen: frozenset = frozenset()) -> Target | None:
        first, rest = path[0], path[1:]
        if first in ("crate", "$crate"):
            return self.walk(scope.root, rest, seen)
        if first == "self":
            return self.walk(scope, rest, seen)
        if first == "super":
            return self.walk(scope.parent, rest, seen) if scope.parent else None
        if first == "::":
            return self.extern(rest)
        return self.lookup(scope, path, seen) or self.extern(path)

    def extern(self, path: list[str]) -> Target | None:
        if path and path[0] in self.libraries:
            return Target(None, crate=path[0])
        if path and path[0] == self.own and self.library:
            return self.walk(self.library, path[1:], frozenset())
        return None

    def walk(self, scope: Scope, path: list[str], seen: frozenset) -> Target | None:
        """Follows the segments of a path from a module on."""
        if not path:
            return Target(scope, is_module=True)
        if path[0] == "super":
            return self.walk(scope.parent, path[1:], seen) if scope.parent else None
        # A name that is not found stands for something that a macro defines there.
        return self.lookup(scope, path, seen) or Target(scope)

    def lookup(self, scope: Scope, path: list[str], seen: frozenset) -> Target | None:
        """Looks the first segment up in a module, then follows the rest; `None` where the module does not have it."""
        first, rest = path[0], path[1:]
        key = (id(scope), first, len(path))
        if key in seen:
            return None
        seen |= {key}
        if rest and first in scope.modules:
            return self.walk(scope.modules[first], rest, seen)
        if first in scope.items:
            return Target(scope)
        for use in scope.uses:
            if use.name == first and (target := self.resolve(scope, use.path + rest, seen)):
                return target
        if first in scope.modules:
            return Target(scope.modules[first], is_module=True)
        for use in scope.uses:
            if use.name == "*" and (target := self.through_glob(scope, use, path, seen)):
                return target
        return None

    def through_glob(self, scope: Scope, use: Use, path: list[str], seen: frozenset) -> Target | None:
        target = self.resolve(scope, use.path, seen)
        if target is None or not target.is_module or target.scope is scope:
            return None
        return self.lookup(target.scope, path, seen)


def add_edges(crate: Crate, libraries: set[str]) -> None:
    """Resolves all paths of a crate, and adds the edges between its files."""
    resolver = Resolver(crate, libraries)

    def add(scope: Scope, target: Target | None, line: int, written: str) -> None:
        if target and target.crate:
            scope.node.crates.append((target.crate, line))
        elif target and not target.is_module and target.scope.node is not scope.node:
            scope.node.edges.setdefault(target.scope.node, []).append((line, written))

    for scope in crate.scopes:
        for use in scope.uses:
            target = resolver.resolve(scope, use.path)
            if target is None or target.crate:
                add(scope, target, use.line, "::".join(use.path))
            elif use.name == "*":
                continue  # the names that the code uses are looked up below
            elif use.is_public and target.scope and scope.node.is_above(target.scope.node):
                if use.name in scope.names:
                    add(scope, target, scope.names[use.name], "::".join(use.path))
            else:
                add(scope, target, use.line, "::".join(use.path))
        for path, line in scope.paths:
            add(scope, resolver.resolve(scope, path), line, "::".join(path))
        globs = [use for use in scope.uses if use.name == "*"]
        for name, line in scope.names.items():
            if name not in scope.items and not any(use.name == name for use in scope.uses):
                for use in globs:
                    target = resolver.through_glob(scope, use, [name], frozenset())
                    add(scope, target, line, "::".join([*use.path, name]))


# ---- checks ----------------------------------------------------------------------------------------------------------------


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
