"""Signals that wait until something is complete."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor

import pytest

from rsegen.cli.edge import Signals
from rsegen.writing import stop


def test_a_signal_waits_for_the_end_of_the_outermost_of_what_is_held() -> None:
    done = []

    def interrupted() -> None:
        with stop.held():
            with stop.held():
                stop.ask()
            done.append("inner")

    with Signals().stop_it(), pytest.raises(KeyboardInterrupt):
        interrupted()
    assert done == ["inner"]
    stop.check()


def test_threads_that_hold_at_the_same_time_leave_nothing_held() -> None:
    """As `rsegen sim`, which asks all simulators at once for their versions."""
    first_is_in, second_is_in = threading.Event(), threading.Event()

    def first() -> None:
        with stop.held():
            first_is_in.set()
            assert second_is_in.wait(60)

    def second() -> None:
        assert first_is_in.wait(60)
        with stop.held():
            second_is_in.set()
            ended.result(60)

    with ThreadPoolExecutor() as pool:
        ended = pool.submit(first)
        pool.submit(second).result(60)
    with Signals().stop_it(), pytest.raises(KeyboardInterrupt):
        stop.ask()
