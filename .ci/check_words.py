#!/usr/bin/env python3
"""Fails where a tracked text file contains an expression of words.txt.

    python3 .ci/check_words.py [ROOT]

A line of words.txt is a regular expression (Python, without regard to case), then, where it helps, ` => ` and what to write instead.
Lines that begin with `#` are comments. Not checked: words.txt itself, licences, lock files, and the table of renamed
names in CHANGELOG.md, between the markers `<!-- renamed: begin -->` and `<!-- renamed: end -->`.
"""

import re
import sys
from pathlib import Path

from rust_source import files

SUFFIXES = {".rs", ".md", ".py", ".sh", ".toml", ".json", ".js", ".mjs", ".html", ".css", ".txt", ".svg"}
SCRIPTS = {
    "test", "bindings/python/check", "bindings/python/test", "docs/manual/check", "tools/licences", "tools/publish-check",
    ".ci/run", ".ci/wasm32",
}
WORDS = ".ci/words.txt"
BEGIN, END = "<!-- renamed: begin -->", "<!-- renamed: end -->"


def is_checked(path: str) -> bool:
    """Checks whether a file is text of the project."""
    name = Path(path).name
    if path == WORDS or name.startswith(("LICENSE", "THIRD_PARTY_LICENSES")) or name == "package-lock.json":
        return False
    return path in SCRIPTS or Path(path).suffix in SUFFIXES


def read_words(text: str) -> list[tuple[re.Pattern, str]]:
    """Returns the expressions of words.txt with their hints."""
    words = []
    for line in text.splitlines():
        if line.strip() and not line.startswith("#"):
            expression, _, hint = line.partition(" => ")
            words.append((re.compile(expression.strip(), re.IGNORECASE), hint.strip()))
    return words


def without_renamed(text: str) -> str:
    """Blanks the table of renamed names, and keeps the numbers of the lines behind it."""
    table = re.compile(f"{re.escape(BEGIN)}.*?{re.escape(END)}", re.DOTALL)
    return table.sub(lambda match: "\n" * match[0].count("\n"), text)


def problems(root: Path) -> list[str]:
    """Returns a message for every match."""
    words = read_words((root / WORDS).read_text(encoding="utf-8"))
    found = []
    for path in filter(is_checked, files(root)):
        text = (root / path).read_text(encoding="utf-8", errors="replace")
        if Path(path).name == "CHANGELOG.md":
            text = without_renamed(text)
        for number, line in enumerate(text.split("\n"), 1):
            for expression, hint in words:
                for match in expression.finditer(line):
                    advice = f": write {hint}" if hint else ""
                    found.append(f"{path}:{number}: `{match[0]}`{advice}")
    return found


def main() -> int:
    root = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parent.parent)
    found = problems(root)
    print("\n".join(found + [f"words: {len(found)} problems"]))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
