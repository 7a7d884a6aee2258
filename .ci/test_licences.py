"""Tests of tools/licences: what it must refuse, and which licence and texts it chooses."""

import importlib.util
import shutil
import sys
import tempfile
import unittest
from importlib.machinery import SourceFileLoader
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LOADER = SourceFileLoader("licences", str(ROOT / "tools" / "licences"))
licences = importlib.util.module_from_spec(importlib.util.spec_from_loader("licences", LOADER))
sys.dont_write_bytecode = True
LOADER.exec_module(licences)

MIT = "Copyright (c) 2020 A. Author\n\nPermission is hereby granted, free of charge, to any person"
ZLIB = "This software is provided 'as-is', without any express or implied\nwarranty."


class Expressions(unittest.TestCase):
    def test_alternatives(self) -> None:
        for expression, expected in {
            "MIT": [{"MIT"}],
            "MIT/Apache-2.0": [{"MIT"}, {"Apache-2.0"}],
            "Apache-2.0 WITH LLVM-exception OR MIT": [{"Apache-2.0 WITH LLVM-exception"}, {"MIT"}],
            "MIT OR ISC AND Zlib": [{"MIT"}, {"ISC", "Zlib"}],
            "(MIT OR ISC) AND Zlib": [{"MIT", "Zlib"}, {"ISC", "Zlib"}],
        }.items():
            self.assertEqual(licences.alternatives(expression), expected, expression)

    def test_wrong_expressions(self) -> None:
        for expression in ["", "MIT OR", "(MIT", "MIT)", "MIT ISC", "AND MIT", "MIT WITH"]:
            with self.assertRaises(licences.Problem, msg=expression):
                licences.alternatives(expression)


class Packages(unittest.TestCase):
    def setUp(self) -> None:
        self.folder = Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.folder)

    def chosen(self, licence: str | None, files: dict[str, str]) -> tuple[set[str], list[str]]:
        for name, text in files.items():
            (self.folder / name).write_text(text, encoding="utf-8")
        manifest = str(self.folder / "Cargo.toml")
        package = {"name": "a", "version": "1.0.0", "license": licence, "authors": ["B. Author <b@example.org>"], "manifest_path": manifest}
        return licences.chosen_texts(package, {})

    def test_a_licence_that_is_not_allowed(self) -> None:
        for licence in ["GPL-3.0-only", "MIT AND GPL-3.0-only", "MPL-2.0", None]:
            with self.assertRaisesRegex(licences.Problem, "^a 1.0.0: "):
                self.chosen(licence, {})

    def test_apache_is_preferred_and_has_no_text_of_its_own(self) -> None:
        files = {"LICENSE-MIT": MIT, "LICENSE-APACHE": "Apache License\nVersion 2.0"}
        self.assertEqual(self.chosen("MIT OR Apache-2.0 OR LGPL-2.1-or-later", files), ({"Apache-2.0"}, []))

    def test_a_licence_whose_text_is_in_the_package_is_preferred(self) -> None:
        self.assertEqual(self.chosen("MIT OR Zlib", {"LICENSE": ZLIB}), ({"Zlib"}, [ZLIB]))

    def test_texts_of_all_licences(self) -> None:
        files = {"LICENSE": "See the other files.", "LICENSE-MIT": MIT, "COPYING": ZLIB}
        self.assertEqual(self.chosen("MIT AND Zlib", files), ({"MIT", "Zlib"}, [ZLIB, "See the other files.", MIT]))

    def test_missing_texts(self) -> None:
        choice, (text,) = self.chosen("MIT", {})
        self.assertEqual(choice, {"MIT"})
        self.assertIn("Copyright (c) B. Author\n", text)
        with self.assertRaisesRegex(licences.Problem, "no text of ISC"):
            self.chosen("ISC", {})


if __name__ == "__main__":
    unittest.main()
