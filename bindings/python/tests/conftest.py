"""Options and fixtures of all tests."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path

import hypothesis
import pytest

import meshes
import tristrip

REPOSITORY = Path(__file__).resolve().parents[3]
SHIPPED = REPOSITORY / "testdata" / "models"

# Programs that tests start also find the package.
_PATHS = [str(Path(tristrip.__file__).parents[1]), *filter(None, [os.environ.get("PYTHONPATH")])]
os.environ["PYTHONPATH"] = os.pathsep.join(_PATHS)

# Examples take longer on a busy machine; that is not an error. Failures print the input that
# reproduces them.
hypothesis.settings.register_profile(
    "default", max_examples=25, deadline=None, print_blob=True, database=None, derandomize=True
)
hypothesis.settings.load_profile("default")


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the number of examples of the fuzz targets."""
    parser.addoption("--examples", type=int, default=150, help="examples per fuzz target (default: %(default)s)")


def shared_models() -> Path:
    """Return the directory of large models, which are not in the repository."""
    named = os.environ.get("TRISTRIP_MODELS")
    return Path(named) if named else REPOSITORY.parent / "shared" / "models"


@pytest.fixture(scope="session")
def models() -> Path:
    """The directory of the models in the repository."""
    return SHIPPED


@pytest.fixture(scope="session")
def model() -> Callable[[str], Path]:
    """A function that finds a model by name, and skips the test if it is not available."""

    def find(name: str) -> Path:
        folders = [SHIPPED, shared_models()]
        for folder in folders:
            if (folder / name).is_file():
                return folder / name
        pytest.skip(f"{name} is in none of {', '.join(map(str, folders))}")

    return find


@pytest.fixture(scope="session")
def hand() -> tuple[meshes.Positions, meshes.Triangles]:
    """A closed scan of 15,982 triangles."""
    vertices, polygons = meshes.read_model(SHIPPED / "hand.ply")
    return vertices, meshes.triangles_of(polygons)


@pytest.fixture
def default_threads() -> Iterator[None]:
    """Restores the number of threads after a test that changes it."""
    yield
    tristrip.set_threads(None)
