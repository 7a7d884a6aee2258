#!/usr/bin/env python3
"""Fails where a library has a public item with two paths, or a public module without items.

    python3 .ci/check_api.py [ROOT]

Reads the JSON that rustdoc writes of each library in LIBRARIES, beside its pages. That format belongs to the unstable part of rustdoc,
which `rustdoc_unstable` opens on a stable toolchain; where the format has changed, the check fails and says so.

A path is a way to name an item from outside: through public modules and re-exports.
"""

import json
import os
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

LIBRARIES = ["tristrip", "tristrip-io", "tristrip-pipeline", "tristrip-lab", "tristrip-render", "tristrip-serve", "tristrip-cli"]
RUSTDOC = Path(__file__).parent.resolve() / "rustdoc_unstable"


class Api:
    """The public items of a library."""

    def __init__(self, document: dict) -> None:
        self.items = document["index"]
        # From an item to its paths, and from a module to the number of its public items.
        self.paths: dict[str, set[str]] = defaultdict(set)
        self.sizes: dict[str, int] = {}
        root = str(document["root"])
        self.visit(root, self.items[root]["name"], set())

    def visit(self, module: str, path: str, above: set[str]) -> None:
        """Collects the items of a module under a path."""
        if module in above:
            return
        self.sizes.setdefault(path, 0)
        for child in map(str, self.items[module]["inner"]["module"]["items"]):
            item = self.items.get(child)
            if item is None or "impl" in item["inner"]:
                continue
            self.sizes[path] += 1
            if "use" in item["inner"]:
                self.visit_use(item["inner"]["use"], path, above | {module})
            else:
                self.add(child, path, item["name"], above | {module})

    def visit_use(self, use: dict, path: str, above: set[str]) -> None:
        """Collects what a re-export names."""
        target = str(use["id"])
        if use["is_glob"]:
            self.visit(target, path, above)
        elif target in self.items:
            self.add(target, path, use["name"], above)

    def add(self, item: str, path: str, name: str, above: set[str]) -> None:
        """Collects an item, or the items of a module."""
        path = f"{path}::{name}"
        if "module" in self.items[item]["inner"]:
            self.visit(item, path, above)
        else:
            self.paths[item].add(path)


def problems(document: dict) -> list[str]:
    """Returns a message for every item with two paths, and every empty module."""
    api = Api(document)
    found = [f"{' and '.join(sorted(paths))}: two paths" for paths in api.paths.values() if len(paths) > 1]
    found += [f"{path}: no public items" for path, size in api.sizes.items() if size == 0]
    return sorted(found)


def document(root: Path, library: str) -> dict:
    """Returns the JSON of a library."""
    command = ["cargo", "rustdoc", "--quiet", "--package", library, "--lib", "--all-features"]
    command += ["--", "-Z", "unstable-options", "--output-format", "json"]
    subprocess.run(command, cwd=root, env=os.environ | {"RUSTDOC": str(RUSTDOC)}, check=True)
    target = root / os.environ.get("CARGO_TARGET_DIR", "target")
    return json.loads((target / "doc" / f"{library.replace('-', '_')}.json").read_text(encoding="utf-8"))


def main() -> int:
    """Checks all libraries."""
    root = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
    found = []
    for library in LIBRARIES:
        text = document(root, library)
        try:
            found += problems(text)
        except (KeyError, TypeError) as error:
            version = text.get("format_version")
            found.append(f"{library}: rustdoc's JSON, version {version}, is not as this check knows it: {error!r}")
    print("\n".join([*found, f"api: {len(found)} problems"]))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
