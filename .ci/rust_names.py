"""Follows the paths in Rust code to the files that define what they name. Used by check_layers.py.

Paths in `use` declarations and in the code (`crate::a::b`, `super::c`, `a::b` with `a` a module or an import) are resolved through
re-exports. No edges between files are: a line `mod child;`, an import of a module as such (what is named through it counts), and a
re-export of a descendant, unless the re-exported name is used in the same file.
"""

from dataclasses import dataclass

from rust_modules import Crate, Scope, Use


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
