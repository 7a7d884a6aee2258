"""Rust source as the checks read it: the files of a tree, comments and literals blanked, test code blanked.

Blanking replaces every character except line ends by a space, so that offsets and line numbers stay valid.
"""

import re
import subprocess
from pathlib import Path

# A line comment, the start of a block comment, a raw string, a string or a character. A lifetime such as 'a matches nothing here.
LITERAL = re.compile(
    r"""(?P<line>//[^\n]*)
      | (?P<block>/\*)
      | (?P<raw>(?<![A-Za-z0-9_])[bc]?r(?P<hashes>\#*)".*?"(?P=hashes))
      | (?P<string>"(?:[^"\\]|\\.)*")
      | (?P<char>'(?:[^'\\\n]|\\[^\n][^'\n]*)')""",
    re.VERBOSE | re.DOTALL,
)
BLOCK_EDGE = re.compile(r"/\*|\*/")
TEST_ATTRIBUTE = re.compile(r"#\s*\[\s*cfg\s*\(\s*(?:all\s*\(\s*)?test\b")
TEST_FILE = re.compile(r"#!\s*\[\s*cfg\s*\(\s*test\s*\)\s*\]")
ATTRIBUTE = re.compile(r"\s*#\s*\[")


def files(root: Path) -> list[str]:
    """Returns the paths of all files that git tracks or would track below `root`, sorted."""
    command = ["git", "-C", str(root), "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    listed = subprocess.run(command, check=True, capture_output=True).stdout.decode().split("\0")
    return sorted(path for path in listed if path and (root / path).is_file())


def is_test_file(path: str) -> bool:
    """Checks whether a path names test code: `tests.rs`, or a file below a folder `tests`."""
    return Path(path).name == "tests.rs" or "tests" in Path(path).parts[:-1]


def line_of(text: str, offset: int) -> int:
    """Returns the line number of an offset, from 1."""
    return text.count("\n", 0, offset) + 1


def blank(text: str) -> str:
    """Returns as many spaces as `text` has characters, with its line ends."""
    return re.sub(r"[^\n]", " ", text)


def without_comments(text: str, literals: bool) -> str:
    """Blanks comments, and string and character literals, too, where `literals` is set."""
    parts, position = [], 0
    while match := LITERAL.search(text, position):
        start, end = match.span()
        if match["block"]:
            end = block_end(text, end)
        is_comment = match["line"] is not None or match["block"] is not None
        keep = not is_comment and not literals
        parts += [text[position:start], text[start:end] if keep else blank(text[start:end])]
        position = end
    return "".join(parts) + text[position:]


def block_end(text: str, position: int) -> int:
    """Returns the end of a block comment, which may contain others. `position` is behind its start."""
    depth = 1
    while depth and (edge := BLOCK_EDGE.search(text, position)):
        depth += 1 if edge[0] == "/*" else -1
        position = edge.end()
    return position if depth == 0 else len(text)


def without_tests(text: str, structure: str) -> str:
    """Blanks the items of `text` that stand behind `#[cfg(test)]`.

    `structure` is the same text without comments and literals: it decides where an item ends.
    """
    if TEST_FILE.search(structure):
        return blank(text)
    position = 0
    while match := TEST_ATTRIBUTE.search(structure, position):
        end = item_end(structure, match.start())
        text = text[: match.start()] + blank(text[match.start() : end]) + text[end:]
        position = end
    return text


def item_end(structure: str, position: int) -> int:
    """Returns the end of the item whose first attribute is at `position`."""
    while attribute := ATTRIBUTE.match(structure, position):
        position = bracket_end(structure, attribute.end() - 1)
    for i in range(position, len(structure)):
        # Parameters and array types are passed over as a whole.
        if i < position:
            continue
        if structure[i] in "([":
            position = bracket_end(structure, i)
        elif structure[i] == "{":
            end = bracket_end(structure, i)
            return end + 1 if structure[end : end + 1] == ";" else end  # `use a::{b};`
        elif structure[i] in ";,":
            return i + 1
    return len(structure)


def bracket_end(structure: str, position: int) -> int:
    """Returns the offset behind the bracket that closes the one at `position`."""
    depth = 0
    for i in range(position, len(structure)):
        if structure[i] in "([{":
            depth += 1
        elif structure[i] in ")]}":
            depth -= 1
            if depth == 0:
                return i + 1
    return len(structure)


def code(text: str, literals: bool) -> str:
    """Returns the code of a file outside tests; its string and character literals are blanked where `literals` is set."""
    structure = without_comments(text, literals=True)
    return without_tests(structure if literals else without_comments(text, literals=False), structure)
