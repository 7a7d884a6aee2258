"""Exceptions by cause: an option, the arrays of a mesh, or a file."""

from __future__ import annotations

from typing import Any


class TristripError(Exception):
    """The base class of all errors of this package."""


class ParameterError(TristripError, ValueError):
    """An option is unknown, has an invalid value, or conflicts with another option."""


class MeshError(TristripError, ValueError):
    """Arrays do not form a mesh: invalid shape, index out of range, or non-finite coordinate."""


class ArrayTypeError(TristripError, TypeError):
    """An argument is not an array, or has an unsupported dtype."""


class FormatError(TristripError, ValueError):
    """Bytes do not conform to a format. The text has the offset, what was found and expected."""


class LimitError(TristripError, ValueError):
    """An input is too large, or declares a size above the limits."""


class FileError(TristripError, OSError):
    """A file could not be read or written: an `OSError` with `errno`, `strerror` and `filename`."""


class NotProvenError(TristripError):
    """A result does not draw exactly the expected faces. It was not returned or written."""


class InternalError(TristripError, RuntimeError):
    """A bug in this package, or an array that another thread modified while it was in use."""


class Interrupted(KeyboardInterrupt):
    """Ctrl-C during a computation. `best` is the best result so far; it is complete and valid."""

    def __init__(self, best: Any = None) -> None:
        super().__init__("interrupted: the attribute `best` has the best result so far")
        self.best = best

    def __reduce__(self) -> tuple[type[Interrupted], tuple[Any]]:
        return (type(self), (self.best,))


# The public module name, for tracebacks and pickles.
for _error in [TristripError, *TristripError.__subclasses__(), Interrupted]:
    _error.__module__ = "tristrip"
