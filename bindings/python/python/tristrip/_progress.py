"""Progress reports: the argument of a callback, and tqdm bars as callbacks."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, TypeAlias


class Progress(NamedTuple):
    """The state of a computation.

    Attributes:
        stage: the current stage, named as in the command: "stripify", "simplify", "verify", …
        steps: the search steps done so far (the unit of effort), or the triangles removed by a
            simplification.
        step_limit: the step at which the search or simplification ends, or None if unknown.
        strips: the current number of strips, or 0 outside a strip search.
        cost: the cost of the best result so far, or 0 outside a strip search.
    """

    stage: str
    steps: int
    step_limit: int | None
    strips: int
    cost: int


Callback: TypeAlias = Callable[[str, int, int | None, int, int], None]
#: The argument `progress` of functions: True for a tqdm bar, a bar, or a function.
ProgressArgument: TypeAlias = Any


def adapt(progress: Any) -> Callback | None:
    """Convert the argument `progress` to the callback that the native code calls."""
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

    raise ParameterError(f"progress: found {type(progress).__name__}, expected True, a tqdm bar or a function")


def _for_bar(bar: Any) -> Callback:
    def update(stage: str, steps: int, step_limit: int | None, strips: int, cost: int) -> None:
        if step_limit is not None and bar.total != step_limit:
            bar.total = step_limit
        text = f"{stage}: {strips:,} strips, cost {cost:,}" if strips else stage
        bar.set_description_str(text, refresh=False)
        bar.update(steps - bar.n)

    return update
