"""Long searches: progress, budgets, Ctrl-C, and exceptions in callbacks."""

from __future__ import annotations

import io
import pickle
import signal
import threading
from typing import Any

import pytest
from tqdm.auto import tqdm

import meshes
import oracle
import tristrip
from interrupts import interrupt_after

Hand = tuple[meshes.Positions, meshes.Triangles]
#: A search of many seconds, which every test here stops.
LONG: dict[str, Any] = {"effort": 9}


class FoundEnoughError(Exception):
    """Raised by a callback of a test."""


def test_progress_of_a_function(hand: Hand) -> None:
    calls: list[tristrip.Progress] = []
    strips = tristrip.stripify(hand[1], effort=5, progress=calls.append)
    oracle.assert_same_triangles(strips.triangles(), hand[1])
    assert calls
    assert all(type(call) is tristrip.Progress and call.stage == "stripify" for call in calls)
    steps = [call.steps for call in calls]
    assert steps == sorted(steps)
    limits = [call.step_limit for call in calls if call.step_limit is not None]
    assert limits
    assert max(steps) <= max(limits)
    costs = [call.cost for call in calls if call.cost]
    assert strips.metrics()["indices_restart"] <= min(costs)
    assert strips == tristrip.stripify(hand[1], effort=5)


def test_progress_of_a_bar(hand: Hand) -> None:
    shown = io.StringIO()
    with tqdm(file=shown) as bar:
        tristrip.stripify(hand[1], effort=4, progress=bar)
        assert bar.n > 0
        assert bar.total >= bar.n
        assert bar.desc.startswith("stripify: ")
    assert "stripify: " in shown.getvalue()


def test_progress_makes_a_bar(hand: Hand, capsys: pytest.CaptureFixture[str]) -> None:
    tristrip.stripify(hand[1], effort=4, progress=True)
    assert "stripify" in capsys.readouterr().err
    tristrip.stripify(hand[1], effort=2, progress=False)
    assert not capsys.readouterr().err


def test_an_exception_of_the_callback_ends_the_search(hand: Hand) -> None:
    def stop(progress: tristrip.Progress) -> None:
        raise FoundEnoughError(progress.stage)

    with pytest.raises(FoundEnoughError, match="stripify") as caught:
        tristrip.stripify(hand[1], progress=stop, **LONG)
    # The result so far is available.
    best = vars(caught.value)["best"]
    oracle.assert_same_triangles(best.triangles(), hand[1])


def test_a_budget_ends_the_search(hand: Hand) -> None:
    strips = tristrip.stripify(hand[1], budget=0.2, **LONG)
    assert strips.stopped == "budget"
    assert strips.notes == ["the time budget ended the search: another run may give a different result"]
    oracle.assert_same_triangles(strips.triangles(), hand[1])
    restored = pickle.loads(pickle.dumps(strips))
    assert (restored.stopped, restored.notes) == (strips.stopped, strips.notes)


def test_a_budget_that_is_not_reached_changes_nothing(hand: Hand) -> None:
    strips = tristrip.stripify(hand[1], effort=2, budget=1e6)
    assert (strips.stopped, strips.notes) == (None, [])
    assert strips == tristrip.stripify(hand[1], effort=2)


def test_a_budget_of_zero_is_enough_for_a_result(hand: Hand) -> None:
    for method in ["best", "fewest", "cache"]:
        strips = tristrip.stripify(hand[1], method=method, budget=0)
        oracle.assert_same_triangles(strips.triangles(), hand[1])


@pytest.mark.parametrize("options", [LONG, {**LONG, "progress": lambda _: None}], ids=["alone", "with progress"])
def test_ctrl_c_raises_with_the_best_result(hand: Hand, options: dict[str, Any]) -> None:
    with pytest.raises(tristrip.Interrupted, match="best") as caught, interrupt_after(0.3):
        tristrip.stripify(hand[1], **options)
    assert isinstance(caught.value, KeyboardInterrupt)
    best = caught.value.best
    assert best.stopped == "interrupt"
    assert best.notes
    assert best.verify(hand[1])["triangles"] == len(hand[1])
    oracle.assert_same_triangles(best.triangles(), hand[1])
    # A longer search is not worse than a short one that was not stopped.
    assert len(best.indices()) <= len(tristrip.stripify(hand[1], effort=0).indices())
    restored = pickle.loads(pickle.dumps(caught.value))
    assert restored.best == best


def test_ctrl_c_can_return_the_best_result(hand: Hand) -> None:
    with interrupt_after(0.3):
        strips = tristrip.stripify(hand[1], on_interrupt="return", **LONG)
    assert strips.stopped == "interrupt"
    oracle.assert_same_triangles(strips.triangles(), hand[1])


def test_ctrl_c_in_the_callback(hand: Hand) -> None:
    def interrupt(_: tristrip.Progress) -> None:
        signal.raise_signal(signal.SIGINT)

    with pytest.raises(tristrip.Interrupted) as caught:
        tristrip.stripify(hand[1], progress=interrupt, **LONG)
    oracle.assert_same_triangles(caught.value.best.triangles(), hand[1])


def test_ctrl_c_runs_the_handler_of_the_user(hand: Hand) -> None:
    def handler(number: int, _: object) -> None:
        raise FoundEnoughError(number)

    previous = signal.signal(signal.SIGINT, handler)
    try:
        with pytest.raises(FoundEnoughError), interrupt_after(0.2):
            tristrip.stripify(hand[1], on_interrupt="return", **LONG)
    finally:
        signal.signal(signal.SIGINT, previous)


def test_other_threads_run_during_a_search(hand: Hand) -> None:
    counted, ended = 0, threading.Event()

    def count() -> None:
        nonlocal counted
        while not ended.wait(0.001):
            counted += 1

    thread = threading.Thread(target=count)
    thread.start()
    tristrip.stripify(hand[1], budget=0.3, **LONG)
    ended.set()
    thread.join()
    assert counted > 20
