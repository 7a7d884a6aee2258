"""Tests of tools/publish-check: what it must find in wrong READMEs, manifests and wheels."""

import importlib.util
import shutil
import sys
import tempfile
import unittest
import zipfile
from importlib.machinery import SourceFileLoader
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LOADER = SourceFileLoader("publish_check", str(ROOT / "tools" / "publish-check"))
publish_check = importlib.util.module_from_spec(importlib.util.spec_from_loader("publish_check", LOADER))
sys.dont_write_bytecode = True
LOADER.exec_module(publish_check)

LICENCES = ["LICENSE-APACHE", "LICENSE-MIT", "THIRD_PARTY_LICENSES.md"]


class Folder(unittest.TestCase):
    def setUp(self) -> None:
        self.folder = Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.folder)


class Crates(Folder):
    def problems(self, comment: str, readme: str) -> list[str]:
        (self.folder / "src").mkdir()
        (self.folder / "src" / "lib.rs").write_text(comment, encoding="utf-8")
        (self.folder / "README.md").write_text(readme, encoding="utf-8")
        return publish_check.readme_problems(self.folder)

    def test_an_example_without_its_hidden_lines(self) -> None:
        comment = "//! ```\n//! # use a::b;\n//! b();\n//!\n//! b();\n//! # Ok(())\n//! ```\n"
        self.assertEqual(self.problems(comment, "# A\n\n```rust\nb();\n\nb();\n```\n"), [])

    def test_an_example_that_differs(self) -> None:
        (problem,) = self.problems("/// ```\n/// b();\n/// ```\n", "```rust\nc();\n```\n")
        self.assertIn("no doc comment contains the example `c(); …`", problem)

    def test_no_example(self) -> None:
        self.assertIn("no example", self.problems("", "# A\n")[0])

    def test_metadata(self) -> None:
        manifest = dict.fromkeys(publish_check.KEYS, "a") | {"name": "a"}
        self.assertEqual(publish_check.metadata_problems(manifest), [])
        self.assertEqual(publish_check.metadata_problems(manifest | {"keywords": []}), ["a: no keywords in its manifest"])


    def test_versions(self) -> None:
        problems = publish_check.version_problems("0.0.1")
        self.assertEqual([problem.split(":")[0] for problem in problems], list(publish_check.VERSIONS))


class Wheels(Folder):
    def problems(self, platforms: str, *, without: str = "", added: str = "", tag: str = "cp310-abi3") -> list[str]:
        path = self.folder / f"tristrip-0.1.0-{tag}-{platforms}.whl"
        sources = (ROOT / "bindings" / "python" / "python").glob("**/*.py*")
        files = [file.relative_to(ROOT / "bindings" / "python" / "python").as_posix() for file in sources if file.suffix in (".py", ".pyi")]
        files += ["tristrip/py.typed", "tristrip/_native.abi3.so", "tristrip-0.1.0.dist-info/RECORD"]
        files += [f"tristrip-0.1.0.dist-info/licenses/{name}" for name in LICENCES]
        with zipfile.ZipFile(path, "w") as wheel:
            for name in [*files, added]:
                if name and name != without:
                    wheel.writestr(name, "")
        return publish_check.wheel_problems(path)

    def test_right_wheels(self) -> None:
        for platforms in ["manylinux_2_28_x86_64", "manylinux_2_17_x86_64.manylinux2014_x86_64", "musllinux_1_2_x86_64"]:
            self.assertEqual(self.problems(platforms), [])

    def test_wrong_tags(self) -> None:
        self.assertIn("needs glibc 2.34", self.problems("manylinux_2_34_x86_64")[0])
        self.assertIn("expected manylinux", self.problems("linux_x86_64")[0])
        self.assertIn("expected a wheel for cp310-abi3", self.problems("musllinux_1_2_x86_64", tag="cp311-cp311")[0])

    def test_wrong_files(self) -> None:
        self.assertIn("missing ['tristrip/py.typed']", self.problems("musllinux_1_2_x86_64", without="tristrip/py.typed")[0])
        self.assertIn("unexpected ['tests/a.py']", self.problems("musllinux_1_2_x86_64", added="tests/a.py")[0])
        licence = "tristrip-0.1.0.dist-info/licenses/LICENSE-MIT"
        self.assertIn("licences: missing ['LICENSE-MIT']", self.problems("musllinux_1_2_x86_64", without=licence)[0])

    def test_size(self) -> None:
        largest, publish_check.LARGEST_WHEEL = publish_check.LARGEST_WHEEL, 100
        self.addCleanup(setattr, publish_check, "LARGEST_WHEEL", largest)
        self.assertIn("expected at most 100", self.problems("musllinux_1_2_x86_64")[0])


if __name__ == "__main__":
    unittest.main()
