"""Tests of the checks in this folder, on small made-up trees.

    python3 -m unittest discover --start-directory .ci --pattern 'test_*.py'
"""

import subprocess
import tempfile
import unittest
from pathlib import Path

import check_api
import check_layers
import check_words
import rust_source

MEMBERS = '[workspace]\nmembers = ["low", "high"]\n'
LAYERS = """
[crates]
low
high

[low]
base  # the lowest
left right
top
top !right

[high]
work
"""
# A clean workspace. Each test of the layers changes one file of it.
CLEAN = {
    "Cargo.toml": MEMBERS,
    ".ci/layers.txt": LAYERS,
    "low/Cargo.toml": '[package]\nname = "low"\n',
    "low/src/lib.rs": "pub mod base;\npub mod left;\npub mod right;\npub mod top;\npub use base::Point;\npub use left::Left;\n",
    "low/src/base.rs": "pub struct Point;\npub const NONE: u32 = 0;\n",
    "low/src/left.rs": "mod deep;\npub use deep::Deep;\nuse crate::Point;\npub struct Left(pub Point);\n",
    "low/src/left/deep.rs": "pub struct Deep(crate::base::Point);\n",
    "low/src/right.rs": "//! Unlike [`crate::top::run`].\nuse crate::base::{self, Point};\npub fn right(_: &Point) -> u32 { base::NONE }\n",
    "low/src/top.rs": "use crate::left::{Deep, Left};\npub fn run(_: Left, _: Deep) {}\n"
    "#[cfg(test)]\nmod tests {\n    use crate::right::right;\n    use super::*;\n}\n",
    "high/Cargo.toml": '[package]\nname = "high"\n\n[dependencies]\nlow = { path = "../low" }\n',
    "high/src/main.rs": "mod work;\nfn main() { work::work() }\n",
    "high/src/work.rs": "use low::Left;\npub fn work() { low::top::run(todo!(), todo!()) }\n",
}


class Tree(unittest.TestCase):
    """A temporary tree that git knows."""

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = Path(folder.name)
        subprocess.run(["git", "init", "--quiet", str(self.root)], check=True)

    def write(self, tree: dict[str, str]) -> None:
        for path, text in tree.items():
            (self.root / path).parent.mkdir(parents=True, exist_ok=True)
            (self.root / path).write_text(text, encoding="utf-8")


class Layers(Tree):
    def problems(self, **changes: str) -> list[str]:
        """Returns the problems of the clean tree with some files changed; `low_src_top` names low/src/top.rs."""
        self.write(CLEAN)
        self.write({path.replace("_", "/") + ".rs": text for path, text in changes.items()})
        return check_layers.problems(self.root)

    def assert_one(self, found: list[str], *parts: str) -> None:
        self.assertEqual(len(found), 1, found)
        for part in parts:
            self.assertIn(part, found[0])

    def test_clean_tree_passes(self) -> None:
        self.assertEqual(self.problems(), [])

    def test_upward_import(self) -> None:
        found = self.problems(low_src_base="pub struct Point;\npub const NONE: u32 = 0;\n\nfn f() { crate::right::right(&Point); }\n")
        self.assertEqual(len(found), 2, found)
        self.assertTrue(found[0].startswith("low/src/base.rs:4: base imports right as `crate::right::right`: right has a higher rank"))
        self.assertIn("circle of 2 modules in low: base, right", found[1])

    def test_upward_import_through_re_export(self) -> None:
        found = self.problems(low_src_base="pub struct Point;\npub const NONE: u32 = 0;\nuse crate::Left as Other;\n")
        self.assertTrue(found[0].startswith("low/src/base.rs:3: base imports left as `crate::Left`"), found)

    def test_module_alias(self) -> None:
        found = self.problems(low_src_left_deep="use crate::right as other;\npub struct Deep;\nfn f() { other::right(todo!()); }\n")
        self.assert_one(found, "low/src/left/deep.rs:3: left::deep imports right as `other::right`", "right has the same rank")

    def test_same_rank(self) -> None:
        found = self.problems(low_src_right="use crate::left::Left;\npub fn right(_: &Left) -> u32 { 0 }\n")
        self.assert_one(found, "low/src/right.rs:1: right imports left", "left has the same rank")

    def test_forbidden_import(self) -> None:
        found = self.problems(low_src_top="pub fn run(_: u8, _: u8) { crate::right::right(todo!()); }\n")
        self.assert_one(found, "low/src/top.rs:1: top imports right", ".ci/layers.txt:10 forbids top to import right")

    def test_circle_in_a_folder(self) -> None:
        found = self.problems(
            low_src_left="mod deep;\nmod other;\npub use deep::Deep;\npub use other::Left;\n",
            low_src_left_deep="pub struct Deep(Vec<super::other::Left>);\n",
            low_src_left_other="use super::Deep;\npub struct Left(Option<Deep>);\n",
        )
        self.assert_one(
            found,
            "circle of 2 modules in low: left::deep, left::other",
            "low/src/left/deep.rs:1: left::deep imports left::other as `super::other::Left`",
            "low/src/left/other.rs:1: left::other imports left::deep as `super::Deep`",
        )

    def test_circle_in_a_command_of_several_files(self) -> None:
        found = self.problems(
            high_src_bin_chart_main="mod axis;\nmod line;\nfn main() {}\n",
            high_src_bin_chart_axis="pub struct Axis(Vec<crate::line::Line>);\n",
            high_src_bin_chart_line="pub struct Line(Option<crate::axis::Axis>);\n",
        )
        self.assert_one(found, "circle of 2 modules in high: bin::chart::axis, bin::chart::line")

    def test_circle_through_super(self) -> None:
        found = self.problems(
            low_src_left="mod deep;\npub use deep::Deep;\nconst NONE: u32 = 0;\npub struct Left(pub Vec<Deep>);\n",
            low_src_left_deep="pub struct Deep;\nfn f() -> u32 { super::NONE }\n",
        )
        self.assert_one(found, "circle of 2 modules in low: left, left::deep", "as `super::NONE`", "low/src/left.rs:4")

    def test_circle_through_globs(self) -> None:
        found = self.problems(
            low_src_left="mod deep;\npub use deep::*;\npub struct Shared;\npub struct Left(pub Vec<Deep>);\n",
            low_src_left_deep="use super::*;\npub struct Deep(Shared);\n",
        )
        self.assert_one(found, "circle of 2 modules in low: left, left::deep", "as `super::Shared`", "as `deep::Deep`")

    def test_re_export_of_a_child_alone_is_no_edge(self) -> None:
        found = self.problems(low_src_left_deep="use super::Left;\npub struct Deep(Vec<Left>);\n")
        self.assertEqual(found, [])

    def test_inline_modules(self) -> None:
        found = self.problems(low_src_base="pub struct Point;\npub const NONE: u32 = 0;\nmod inner {\n    use super::super::top::run;\n}\n")
        self.assertTrue(found[0].startswith("low/src/base.rs:4: base imports top as `super::super::top::run`"), found)

    def test_item_of_the_root(self) -> None:
        root = CLEAN["low/src/lib.rs"] + "pub struct Limit;\n"
        found = self.problems(low_src_lib=root, low_src_base="pub struct Point(crate::Limit);\npub const NONE: u32 = 0;\n")
        self.assert_one(found, "low/src/base.rs:1: base imports lib as `crate::Limit`", "root of the crate")

    def test_unlisted_module(self) -> None:
        found = self.problems(low_src_lib=CLEAN["low/src/lib.rs"] + "mod stray;\n", low_src_stray="mod inner;\n", low_src_stray_inner="")
        self.assert_one(found, "low/src/stray.rs: module stray has no place in the section [low]")

    def test_unknown_entry(self) -> None:
        self.write(CLEAN | {".ci/layers.txt": LAYERS.replace("top !right", "top !rigth")})
        self.assert_one(check_layers.problems(self.root), ".ci/layers.txt:10: low has no module rigth")

    def test_crate_dependency_upward(self) -> None:
        self.write(CLEAN | {"low/Cargo.toml": '[package]\nname = "low"\n\n[dev-dependencies]\nhigh = { path = "../high" }\n'})
        self.assert_one(check_layers.problems(self.root), "low/Cargo.toml:5: low depends on high")

    def test_crate_without_a_place(self) -> None:
        self.write(CLEAN | {".ci/layers.txt": LAYERS.replace("low\nhigh\n", "low\n")})
        self.assert_one(check_layers.problems(self.root), "high/Cargo.toml: crate high has no place")

    def test_tests_are_left_out(self) -> None:
        upward = "use crate::top::run;\n"
        base = "pub struct Point;\npub const NONE: u32 = 0;\n#[cfg(test)]\n#[allow(unused)]\nmod tests;\n#[cfg(test)]\n" + upward
        self.assertEqual(self.problems(low_src_base=base, low_src_base_tests=upward), [])


class Words(Tree):
    WORDS = "# comment\n\\bblorb(s|ed)?\\b => flush\n\\bquux\\b\n"

    def problems(self, tree: dict[str, str]) -> list[str]:
        self.write({".ci/words.txt": self.WORDS} | tree)
        return check_words.problems(self.root)

    def test_match_with_hint(self) -> None:
        self.assertEqual(self.problems({"a.rs": "// Fine.\n// It Blorbed.\n"}), ["a.rs:2: `Blorbed`: write flush"])
        self.assertEqual(self.problems({"a.rs": "", "b.md": "quux\n"}), ["b.md:1: `quux`"])

    def test_whole_words(self) -> None:
        self.assertEqual(self.problems({"a.rs": "blorbing quuxes\n"}), [])

    def test_left_out_files(self) -> None:
        text = "quux\n"
        self.assertEqual(self.problems(dict.fromkeys(["LICENSE-MIT", "THIRD_PARTY_LICENSES.md", "Cargo.lock", "model.ply", "package-lock.json"], text)), [])
        self.assertEqual(len(self.problems({"test": text, "figure.svg": text})), 2)

    def test_table_of_renamed_names(self) -> None:
        table = "quux\n<!-- renamed: begin -->\n| quux | other |\n<!-- renamed: end -->\nquux\n"
        self.assertEqual(self.problems({"CHANGELOG.md": table}), ["CHANGELOG.md:1: `quux`", "CHANGELOG.md:5: `quux`"])
        self.assertEqual(len(self.problems({"CHANGELOG.md": "", "other.md": table})), 3)

    def test_words_of_the_project_are_valid(self) -> None:
        words = check_words.read_words((Path(__file__).parent / "words.txt").read_text(encoding="utf-8"))
        self.assertGreater(len(words), 10)


class PublicApi(unittest.TestCase):
    """Documents as rustdoc writes them: a crate `low` with a public module `base`."""

    @staticmethod
    def item(name: str | None, inner: dict, docs: str = "", visibility: str = "public") -> dict:
        return {"name": name, "inner": inner, "docs": docs, "visibility": visibility}

    def problems(self, items: dict[str, dict], root: list[int], base: list[int]) -> list[str]:
        modules = {"0": self.item("low", {"module": {"items": root}}), "1": self.item("base", {"module": {"items": base}})}
        return check_api.problems({"root": 0, "index": modules | items})

    def use(self, target: int, name: str, is_glob: bool = False) -> dict:
        return self.item(None, {"use": {"id": target, "name": name, "is_glob": is_glob}})

    def test_one_path(self) -> None:
        items = {"2": self.item("Point", {"struct": {"impls": []}})}
        self.assertEqual(self.problems(items, [1], [2]), [])

    def test_two_paths(self) -> None:
        items = {"2": self.item("Point", {"struct": {"impls": []}})}
        two = ["low::Point and low::base::Point: two paths"]
        self.assertEqual(self.problems(items | {"3": self.use(2, "Point")}, [1, 3], [2]), two)
        self.assertEqual(self.problems(items | {"3": self.use(1, "base", is_glob=True)}, [1, 3], [2]), two)

    def test_empty_module(self) -> None:
        self.assertEqual(self.problems({}, [1], []), ["low::base: no public items"])


class Source(unittest.TestCase):
    def test_comments_and_literals(self) -> None:
        text = "a /* b /* c */ d */ \"e // \\\" f\" 'g' 'h r#\"i \" j\"# // k\n'\\'' l"
        self.assertEqual(rust_source.code(text, literals=True).split(), ["a", "'h", "l"])
        self.assertEqual(rust_source.code(text, literals=False).split(), text.replace("/* b /* c */ d */", "").replace("// k", "").split())
        self.assertEqual(len(rust_source.code(text, literals=True)), len(text))

    def test_items_behind_cfg_test(self) -> None:
        for item in ("mod tests { fn a() { {} } }", "use a::{b};", "fn a(x: [u8; 2]) -> u8 { x[0] }", "#[allow(x)]\nstatic A: [u8; 1] = [0];"):
            self.assertEqual(rust_source.code(f"a #[cfg(test)]\n{item} z", literals=True).split(), ["a", "z"])
        self.assertIn("kept", rust_source.code('#[cfg(feature = "x")]\nmod kept {}', literals=True))


if __name__ == "__main__":
    unittest.main()
