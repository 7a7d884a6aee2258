"""Checks that Blender's Python has the package tristrip, which the add-on needs."""

from __future__ import annotations

import importlib
import sys


class MissingWheelError(Exception):
    """tristrip cannot be imported. The text has the install command."""


def command() -> str:
    """Return the command that installs tristrip from a clone into the running Python."""
    return f'"{sys.executable}" -m pip install ./bindings/python'


def problem() -> str | None:
    """Return why tristrip cannot be used, or None if it can."""
    try:
        importlib.import_module("tristrip")
    except ImportError as error:
        advice = "To install it, run this in a clone of tristrip, then restart Blender:"
        return f"tristrip cannot be imported ({error}). {advice} {command()}"
    return None


def check() -> None:
    """Raise an error if tristrip cannot be used.

    Raises:
        MissingWheelError: tristrip cannot be imported; the text has the install command.
    """
    found = problem()
    if found is not None:
        raise MissingWheelError(found)
