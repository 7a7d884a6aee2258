"""Documentation as tests: examples in docstrings, and the code of the READMEs."""

from __future__ import annotations

import doctest
import importlib
import inspect
import pkgutil
import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

import tristrip
from conftest import REPOSITORY, SHIPPED
from tristrip import _native

READMES = [REPOSITORY / "bindings" / "python" / "README.md", REPOSITORY / "README.md"]


def modules() -> Iterator[ModuleType]:
    """Import all modules of the package that can be imported here."""
    yield tristrip
    for found in pkgutil.walk_packages(tristrip.__path__, "tristrip."):
        if found.name.endswith("__main__") or "blender" in found.name:
            continue
        yield importlib.import_module(found.name)


def documented() -> Iterator[tuple[str, Any]]:
    """Return all objects with their own docstrings, by qualified name."""
    for module in modules():
        yield module.__name__, module
        for name, item in vars(module).items():
            own = getattr(item, "__module__", None) in {module.__name__, "tristrip"}
            native = module is _native and not name.startswith("_")
            if not (native or own) or not (inspect.isclass(item) or inspect.isroutine(item)):
                continue
            if module is tristrip and hasattr(_native, name):
                continue
            yield f"{module.__name__}.{name}", item
            if inspect.isclass(item):
                for member, value in vars(item).items():
                    if not member.startswith("_"):
                        yield f"{module.__name__}.{name}.{member}", value


DOCUMENTED = dict(documented())
EXAMPLES = {
    name: test
    for name, item in DOCUMENTED.items()
    if (text := inspect.getdoc(item))
    and (test := doctest.DocTestParser().get_doctest(text, {}, name, name, 0)).examples
}


@pytest.mark.parametrize("name", EXAMPLES)
def test_examples_of_docstrings(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stage_models(tmp_path)
    monkeypatch.chdir(tmp_path)
    report: list[str] = []
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS)
    results = runner.run(EXAMPLES[name], out=report.append)
    assert results.failed == 0, "".join(report)


def stage_models(folder: Path) -> None:
    """Put the models of the repository where examples look for them."""
    for model in SHIPPED.iterdir():
        shutil.copy(model, folder / model.name)
    (folder / "testdata").mkdir()
    (folder / "testdata" / "models").symlink_to(SHIPPED)


def test_there_are_examples() -> None:
    names = {name.removeprefix("tristrip._native.") for name in EXAMPLES}
    assert {"tristrip", "stripify", "Strips", "Strips.indices", "Strips.verify", "set_threads"} <= names


@pytest.mark.parametrize("name", [name for name in DOCUMENTED if re.fullmatch(r"tristrip\._native\.\w+(\.\w+)?", name)])
def test_public_items_are_documented(name: str) -> None:
    """Each has a summary that ends with a full stop, and functions name all their arguments."""
    text = inspect.getdoc(DOCUMENTED[name])
    if name.endswith((".VERSION", ".__doc__")):
        return
    assert text, "no docstring"
    assert re.search(r"[.:]$", text.split("\n\n")[0].strip()), "the summary has no full stop"
    item = DOCUMENTED[name]
    if inspect.isroutine(item) and "Args:" in text:
        arguments = re.findall(r"^    (.*?):(?: |$)", text[text.index("Args:") :], re.MULTILINE)
        named = set(re.findall(r"\w+", " ".join(arguments)))
        for parameter in inspect.signature(item).parameters.values():
            if parameter.name not in {"self", "cls"}:
                assert parameter.name in named, f"{parameter.name} is not described"


def blocks() -> Iterator[Any]:
    """Return the Python code of the READMEs."""
    for readme in READMES:
        text = readme.read_text(encoding="utf-8")
        for match in re.finditer(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL):
            line = text.count("\n", 0, match.start()) + 2
            name = f"{readme.relative_to(REPOSITORY)}:{line}"
            yield pytest.param("\n" * (line - 1) + match[1], str(readme), id=name)


@pytest.mark.parametrize(("code", "file"), blocks())
def test_readme(code: str, file: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for needed in re.findall(r"^(?:from|import) (\w+)", code, re.MULTILINE):
        pytest.importorskip(needed)
    stage_models(tmp_path)
    monkeypatch.chdir(tmp_path)
    exec(compile(code, file, "exec"), {"__name__": "__main__"})


def test_the_readmes_have_code() -> None:
    files = [parameters.values[1] for parameters in blocks()]
    assert all(str(readme) in files for readme in READMES)


def test_license_files_are_those_of_the_repository() -> None:
    """The package has copies, because license files must lie in its directory."""
    for name in ("LICENSE-APACHE", "LICENSE-MIT"):
        assert (REPOSITORY / "bindings" / "python" / name).read_bytes() == (REPOSITORY / name).read_bytes()
