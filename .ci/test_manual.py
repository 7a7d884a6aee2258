"""Tests of docs/manual/check: what it must find in wrong pages."""

import contextlib
import importlib.util
import io
import shutil
import sys
import tempfile
import unittest
import unittest.mock
from importlib.machinery import SourceFileLoader
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LOADER = SourceFileLoader("manual_check", str(ROOT / "docs" / "manual" / "check"))
check = importlib.util.module_from_spec(importlib.util.spec_from_loader("manual_check", LOADER))
sys.modules["manual_check"] = check
sys.dont_write_bytecode = True
LOADER.exec_module(check)


class Pages(unittest.TestCase):
    def setUp(self) -> None:
        self.folder = Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.folder)
        (self.folder / "testdata" / "models").mkdir(parents=True)
        for name, value in {"ROOT": self.folder.resolve(), "MANUAL": self.folder.resolve() / "docs" / "manual"}.items():
            self.addCleanup(setattr, check, name, getattr(check, name))
            setattr(check, name, value)

    def page(self, text: str, name: str = "page.md") -> Path:
        path = self.folder.resolve() / name
        path.write_text(text, encoding="utf-8")
        return path

    def links(self, text: str) -> list[str]:
        return check.check_links([self.page(text)])[0]

    def run_page(self, text: str, python: str | None = None) -> tuple[list[str], list[str]]:
        """Returns the problems and the skipped blocks of a page."""
        runner = check.Runner(Path("/bin/echo"), python)
        return runner.run(self.page(text)), runner.skipped

    def test_links(self) -> None:
        self.page("# One & two\n\n## Again\n\n## Again\n", "other.md")
        good = "[a](other.md) [b](other.md#one--two) [c](other.md#again-1) [d](https://example.org/x) `[e](none.md)`\n"
        self.assertEqual(self.links(good + "```text\n[f](none.md)\n```\n"), [])
        self.assertIn("page.md:1: none.md: no such file", self.links("[a](none.md)")[0])
        self.assertIn("page.md:2: other.md#three: no such heading", self.links("x\n[a](other.md#three)")[0])
        self.assertIn("figure.svg: no such file", self.links("![a](figure.svg)")[0])
        self.assertIn("../outside: no such file", self.links("[a](../outside)")[0])
        self.assertIn("#nowhere: no such heading", self.links("[a](#nowhere)")[0])

    def test_blocks_run_in_order(self) -> None:
        page = "```sh\necho 1 > a\n```\n\n```sh\ncat a\n```\n\n<!-- output -->\n```text\n1\n```\n"
        self.assertEqual(self.run_page(page), ([], []))
        problems, _ = self.run_page(page.replace("text\n1", "text\n2"))
        self.assertIn("page.md:10: the block before did not print this line here: 2", problems[0])

    def test_blocks_that_fail(self) -> None:
        problems, _ = self.run_page("```sh\nfalse\ntrue\n```\n")
        self.assertIn("page.md:1: exit code 1", problems[0])
        problems, _ = self.run_page("```python\n1 / 0\n```\n", sys.executable)
        self.assertIn("ZeroDivisionError", problems[0])
        problems, _ = self.run_page("```rust\nlet a = 1;\n```\n")
        self.assertIn("includes an anchor of an example", problems[0])
        problems, _ = self.run_page("- item\n\n  ```sh\n  true\n  ```\n")
        self.assertIn("a code block is indented", problems[0])
        problems, _ = self.run_page("```toml\na = 1\n```\n")
        self.assertIn("a block of toml needs a comment", problems[0])

    def test_skipped_blocks_are_named(self) -> None:
        page = "<!-- not run: needs the network -->\n```sh\nfalse\n```\n\n```python\n1 / 0\n```\n"
        problems, skipped = self.run_page(page)
        self.assertEqual(problems, [])
        self.assertEqual(skipped, ["page.md:2: sh: needs the network", "page.md:6: python: no --python is given"])

    def test_rust_blocks_are_in_examples(self) -> None:
        (self.folder / "crates" / "a" / "examples").mkdir(parents=True)
        self.page("// ANCHOR: b\nfn b() {}\n// ANCHOR_END: b\n", "crates/a/examples/b.rs")
        block = "```rust\n{{#include crates/a/examples/b.rs:ANCHOR}}\n```\n"
        self.assertEqual(self.run_page(block.replace("ANCHOR", "b")), ([], []))
        self.assertIn("has no anchor c", self.run_page(block.replace("ANCHOR", "c"))[0][0])

    def test_a_missing_command_is_a_problem(self) -> None:
        with contextlib.redirect_stdout(io.StringIO()), unittest.mock.patch.dict("os.environ", TRISTRIP_COMMAND="/none"):
            self.assertIn("/none is missing", check.run_blocks(None)[0])


if __name__ == "__main__":
    unittest.main()
