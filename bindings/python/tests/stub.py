"""Names in the stub of the native module that have no values at run time."""

from __future__ import annotations

import ast
from pathlib import Path

import tristrip

PACKAGE = Path(tristrip.__file__).parent
STUB = PACKAGE / "_native.pyi"


def choices(name: str) -> list[str]:
    """Return the strings of a `Literal` of the stub, such as `Method`."""
    for statement in ast.parse(STUB.read_text(encoding="utf-8")).body:
        if (
            isinstance(statement, ast.AnnAssign)
            and isinstance(statement.target, ast.Name)
            and statement.target.id == name
        ):
            assert isinstance(statement.value, ast.Subscript)
            texts = ast.literal_eval(statement.value.slice)
            return list(texts) if isinstance(texts, tuple) else [texts]
    raise LookupError(name)


def only_types() -> list[str]:
    """Return the names of the stub that exist only for type checkers."""
    names = []
    for statement in ast.parse(STUB.read_text(encoding="utf-8")).body:
        if isinstance(statement, ast.AnnAssign) and isinstance(statement.annotation, ast.Name):
            if statement.annotation.id == "TypeAlias" and isinstance(statement.target, ast.Name):
                names.append(statement.target.id)
        elif isinstance(statement, ast.Assign) and isinstance(statement.value, ast.Call):
            # A typed dictionary with keys that are not identifiers.
            names.extend(target.id for target in statement.targets if isinstance(target, ast.Name))
        elif isinstance(statement, ast.ClassDef):
            bases = {base.id for base in statement.bases if isinstance(base, ast.Name)}
            if "TypedDict" in bases or bases & set(names):
                names.append(statement.name)
    return names
