#!/usr/bin/env python3
"""Counts the pairs of places in Rust and Python code that share six or more lines, and fails where there are more than allowed.

    python3 .ci/check_duplicates.py --most N [ROOT]

Lines are compared without their indentation. Blank lines, comments, lone punctuation, imports and attributes do not count, and test code is
left out: `#[cfg(test)]` items, files named tests.rs or test_*.py, and files below folders named tests.

# Algorithm
Every window of six lines is hashed, and paired with the latest earlier place of the same window. Pairs of successive windows
at the same distance are one place. Time and memory are linear in the lines of code.
"""

import argparse
import re
import sys
from pathlib import Path

import rust_source

WINDOW = 6
PUNCTUATION = re.compile(r"[^A-Za-z0-9]*$")
ATTRIBUTE = re.compile(r"#!?\[")
USE = re.compile(r"^\s*(?:pub(?:\([^)]*\))? )?use [^;]*;", re.MULTILINE)
PYTHON_LEFT_OUT = re.compile(r"^\s*(?:from [\w.]+ import \([^)]*\)|#.*|import \w.*|from [\w.].*)", re.MULTILINE)


def rust_lines(text: str) -> str:
    """Blanks what does not count in Rust code: comments, tests, attributes and `use` declarations, however many lines they take."""
    structure, text = rust_source.code(text, literals=True), rust_source.code(text, literals=False)
    for match in ATTRIBUTE.finditer(structure):
        end = rust_source.bracket_end(structure, match.end() - 1)
        text = text[: match.start()] + rust_source.blank(text[match.start() : end]) + text[end:]
    return USE.sub(lambda match: rust_source.blank(match[0]), text)


def code_lines(path: str, text: str) -> list[tuple[int, str]]:
    """Returns the lines of code that count, each with its number, their white space folded."""
    is_rust = Path(path).suffix == ".rs"
    text = rust_lines(text) if is_rust else PYTHON_LEFT_OUT.sub("", text)
    lines = [(number, " ".join(line.split())) for number, line in enumerate(text.split("\n"), 1)]
    return [(number, line) for number, line in lines if not PUNCTUATION.match(line)]


def is_checked(path: str) -> bool:
    """Checks whether a file is code outside tests."""
    name = Path(path).name
    return Path(path).suffix in {".rs", ".py"} and not rust_source.is_test_file(path) and not name.startswith("test_")


def shared_windows(sources: dict[str, list[tuple[int, str]]]) -> list[tuple[str, int, str, int]]:
    """Returns file and index of every window that an earlier place has, too, with that place, in the order of the files.

    A place that overlaps the window is passed over: six equal lines in a row are not a duplicate of themselves.
    """
    latest: dict[tuple[str, ...], tuple[str, int]] = {}
    shared = []
    for path, lines in sources.items():
        for i in range(len(lines) - WINDOW + 1):
            window = tuple(line for _, line in lines[i : i + WINDOW])
            earlier = latest.get(window)
            if earlier and earlier[0] == path and i - earlier[1] < WINDOW:
                continue
            if earlier:
                shared.append((*earlier, path, i))
            latest[window] = (path, i)
    return shared


def duplicates(sources: dict[str, list[tuple[int, str]]]) -> list[tuple[str, str]]:
    """Returns the pairs of places, the longest first, each place as `file:first-last`."""
    pairs: list[list] = []
    open_pairs: dict[tuple[str, str, int], list] = {}
    for first, i, second, j in shared_windows(sources):
        pair = open_pairs.get((first, second, j - i))
        if pair and pair[3] == j - 1:
            pair[3] = j
        else:
            pair = [first, second, j, j, j - i]
            open_pairs[first, second, j - i] = pair
            pairs.append(pair)

    def place(path: str, start: int, end: int) -> str:
        lines = sources[path]
        return f"{path}:{lines[start][0]}-{lines[end + WINDOW - 1][0]}"

    pairs.sort(key=lambda pair: pair[2] - pair[3])
    return [(place(a, j - d, last - d), place(b, j, last)) for a, b, j, last, d in pairs]


def read(root: Path) -> dict[str, list[tuple[int, str]]]:
    """Returns the code lines of all files of a tree."""
    paths = filter(is_checked, rust_source.files(root))
    return {path: code_lines(path, (root / path).read_text(encoding="utf-8")) for path in paths}


def main() -> int:
    parser = argparse.ArgumentParser(description="Count the pairs of places that share six or more code lines")
    parser.add_argument("--most", type=int, default=0, help="how many pairs are allowed")
    parser.add_argument("root", nargs="?", type=Path, default=Path(__file__).parent.parent)
    arguments = parser.parse_args()
    pairs = duplicates(read(arguments.root))
    for first, second in pairs:
        print(f"{first} ~ {second}")
    print(f"duplicates: {len(pairs)} pairs of places share {WINDOW} or more lines, at most {arguments.most} are allowed")
    return 1 if len(pairs) > arguments.most else 0


if __name__ == "__main__":
    sys.exit(main())
