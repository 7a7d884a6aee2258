"""Progress of a computation: what a callback receives, and bars of tqdm as callbacks."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, TypeAlias


class Progress(NamedTuple):
    """The state of a computation.

    stage: what is done now, in the words of the command: "stripify", "simplify", "verify", …
    steps: steps of a search done so far; effort is counted in steps. Of a simplification, the triangles removed.
    step_limit: the number of steps after which the search or the simplification ends; None where it is not known.
    strips: the current number of strips; 0 where none are searched.
    cost: the cost of the best result so far, which the search minimizes; 0 likewise.
    """

    stage: str
    steps: int
    step_limit: int | None
    strips: int
    cost: int


Callback: TypeAlias = Callable[[str, int, int | None, int, int], None]
#: The argument `progress` of functions: True for a bar of tqdm, such a bar, or a function.
ProgressArgument: TypeAlias = Any


def adapt(progress: Any) -> Callback | None:
    """Turn the argument `progress` of a function into the callback that the native code calls."""
    if progress is None or progress is False:
        return None
    if progress is True:
        from tqdm.auto import tqdm

        return _for_bar(tqdm(unit="step", unit_scale=True, leave=False))
    if hasattr(progress, "update") and hasattr(progress, "set_description_str"):
        return _for_bar(progress)
    if callable(progress):

        def call(stage: str, steps: int, step_limit: int | None, strips: int, cost: int) -> None:
            progress(Progress(stage, steps, step_limit, strips, cost))

        return call
    from ._errors import ParameterError

    raise ParameterError(f"progress: found {type(progress).__name__}, expected True, a bar of tqdm, or a function")


def _for_bar(bar: Any) -> Callback:
    def update(stage: str, steps: int, step_limit: int | None, strips: int, cost: int) -> None:
        if step_limit is not None and bar.total != step_limit:
            bar.total = step_limit
        text = f"{stage}: {strips:,} strips, cost {cost:,}" if strips else stage
        bar.set_description_str(text, refresh=False)
        bar.update(steps - bar.n)

    return update
