"""Reads the modules of the crates of a workspace: their files, items, `use` declarations and paths. Used by check_layers.py.

The modules of a crate are found from its root along its `mod` lines. Code behind `#[cfg(test)]` is left out.
"""

import re
import tomllib
from dataclasses import dataclass, field
from pathlib import Path

from rust_source import bracket_end, code, line_of

TOKEN = re.compile(r"\$crate|[A-Za-z_][A-Za-z0-9_]*|::|\.\.|\S")
NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*$")
DEFINES = {"fn", "struct", "enum", "trait", "type", "const", "static", "union"}


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
        folders = sorted(folder.glob(pattern.replace("*.rs", "*/main.rs")))
        roots += [(f"{name}::{path.parent.name}", path) for path in folders]
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
        prefix = "" if scope.node.name in ("lib", "main") else scope.node.name + "::"
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
