"""Tasks in a thread, of which only the latest counts."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from threading import Event, current_thread, main_thread

import pytest

pytest.importorskip("PySide6", reason="the window needs pip install 'rsegen[gui]'")

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QApplication

from rsegen.gui.workers import LatestOnly
from tests.support.waiting import until


@pytest.fixture
def worker(app: QApplication) -> Iterator[LatestOnly]:
    owner = QObject()
    worker = LatestOnly(owner)
    yield worker
    worker.stop()


def waited_for(event: Event, said: str, begun: list[str]) -> str:
    begun.append(said)
    event.wait()
    return said


def test_of_many_orders_the_first_and_the_newest_are_begun_and_the_newest_counts(worker: LatestOnly) -> None:
    begun: list[str] = []
    results: list[object] = []
    gate = Event()
    worker.result.connect(results.append)
    for said in "abcde":
        worker.submit(partial(waited_for, gate, said, begun))
    gate.set()
    until(lambda: bool(results))
    assert results == ["e"]
    assert begun == ["a", "e"]


def test_an_immediate_result_is_not_replaced_by_an_earlier_job(worker: LatestOnly) -> None:
    results: list[object] = []
    gate = Event()
    worker.result.connect(results.append)
    worker.submit(partial(waited_for, gate, "slow", []))
    worker.submit(lambda: "quick", at_once=True)
    assert results == ["quick"]
    gate.set()
    until(lambda: not worker.busy)
    assert results == ["quick"]


def test_work_is_done_in_a_thread_and_its_error_is_shown(worker: LatestOnly) -> None:
    threads: list[object] = []
    results: list[object] = []
    worker.result.connect(results.append)
    worker.result.connect(lambda _: threads.append(current_thread()))

    def fail() -> None:
        threads.append(current_thread())
        raise ValueError("no")

    worker.submit(fail)
    until(lambda: bool(results))
    assert isinstance(results[0], ValueError)
    assert threads[0] is not main_thread()
    assert threads[1] is main_thread()
