"""Exceptions, by who must act: whoever chose an option, made the mesh, or wrote the file."""

from __future__ import annotations

from typing import Any


class TristripError(Exception):
    """The base of all errors of this package."""


class ParameterError(TristripError, ValueError):
    """An option is unknown, has a wrong value, or does not fit the others."""


class MeshError(TristripError, ValueError):
    """Arrays are no mesh: a wrong shape, an index out of range, a coordinate that is not finite."""


class ArrayTypeError(TristripError, TypeError):
    """An argument is no array, or has a dtype that cannot be used."""


class FormatError(TristripError, ValueError):
    """The bytes of a file do not conform to its format; the text tells where, what was found and what was expected."""


class LimitError(TristripError, ValueError):
    """An input is too large, or states a size that is."""


class FileError(TristripError, OSError):
    """A file could not be read or written: an `OSError` with `errno`, `strerror` and `filename`."""


class NotProvenError(TristripError):
    """A result does not draw exactly the expected faces; it was not returned or written."""


class InternalError(TristripError, RuntimeError):
    """A defect of this package, or an array that another thread changed while it was in use."""


class Interrupted(KeyboardInterrupt):
    """Ctrl-C during a search. `best` is the best result so far, which is complete and can be used."""

    def __init__(self, best: Any = None) -> None:
        super().__init__("interrupted: the attribute `best` has the best result so far")
        self.best = best

    def __reduce__(self) -> tuple[type[Interrupted], tuple[Any]]:
        return (type(self), (self.best,))


# The public names, which tracebacks show and pickles hold.
for _error in [TristripError, *TristripError.__subclasses__(), Interrupted]:
    _error.__module__ = "tristrip"
