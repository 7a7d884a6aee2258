"""The wheel of tristrip, which the add-on needs in Blender's Python."""

from __future__ import annotations

import importlib
import sys


class MissingWheelError(Exception):
    """tristrip cannot be imported; the text says how to install it."""


def command() -> str:
    """Return the command that installs the wheel into the Python that runs."""
    return f'"{sys.executable}" -m pip install tristrip'


def problem() -> str | None:
    """Say why tristrip cannot be used; None if it can."""
    try:
        importlib.import_module("tristrip")
    except ImportError as error:
        advice = "Install it into Blender's Python, then restart Blender:"
        return f"tristrip cannot be imported ({error}). {advice} {command()}"
    return None


def check() -> None:
    """Raise an error if tristrip cannot be used.

    Raises:
        MissingWheelError: with the command that installs it.
    """
    found = problem()
    if found is not None:
        raise MissingWheelError(found)
