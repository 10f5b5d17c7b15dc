"""Work behind the window: it never waits for it, and only the newest counts."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from threading import Event, current_thread, main_thread

import pytest

pytest.importorskip("PySide6", reason="the window needs pip install 'rsegen[gui]'")

from PySide6.QtCore import QObject, QTimer
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QSpinBox

from rsegen import build
from rsegen.gui.newest import Newest
from rsegen.gui.session import Session
from rsegen.gui.window import Window
from tests.support.clicking import shown
from tests.support.waiting import until


@pytest.fixture
def window(app: QApplication) -> Iterator[Window]:
    window = Window(Session.new())
    window.resize(1280, 720)
    window.session.add({"kind": "random", "max_height": 5})
    with shown(window):
        yield window


@pytest.fixture
def newest(app: QApplication) -> Iterator[Newest]:
    owner = QObject()
    newest = Newest(owner)
    yield newest
    newest.end()


def waited_for(event: Event, said: str, begun: list[str]) -> str:
    begun.append(said)
    event.wait(10)
    return said


def test_of_many_orders_the_first_and_the_newest_are_begun_and_the_newest_counts(newest: Newest) -> None:
    begun: list[str] = []
    came: list[object] = []
    gate = Event()
    newest.came.connect(came.append)
    for said in "abcde":
        newest.order(partial(waited_for, gate, said, begun))
    gate.set()
    until(lambda: bool(came))
    assert came == ["e"]
    assert begun == ["a", "e"]


def test_what_is_done_at_once_is_not_overtaken_by_what_was_ordered_before(newest: Newest) -> None:
    came: list[object] = []
    gate = Event()
    newest.came.connect(came.append)
    newest.order(partial(waited_for, gate, "slow", []))
    newest.order(lambda: "quick", at_once=True)
    assert came == ["quick"]
    gate.set()
    until(lambda: newest._thread is None)
    assert came == ["quick"]


def test_work_is_done_elsewhere_and_an_error_is_told_here(newest: Newest) -> None:
    threads: list[object] = []
    came: list[object] = []
    newest.came.connect(came.append)
    newest.came.connect(lambda _: threads.append(current_thread()))

    def fail() -> None:
        threads.append(current_thread())
        raise ValueError("no")

    newest.order(fail)
    until(lambda: bool(came))
    assert isinstance(came[0], ValueError)
    assert threads[0] is not main_thread()
    assert threads[1] is main_thread()


def test_a_large_map_comes_while_the_window_goes_on(window: Window) -> None:
    window.session.set("chunk_size", 1000)
    until(lambda: window.looking._thread is not None, every=2)
    beats, beat = [], QTimer(interval=2)
    beat.timeout.connect(lambda: beats.append(window.looking._thread is not None))
    beat.start()
    until(lambda: window.scene is not None and window.scene.field.shape[0] > 1000)
    assert window.scene is not None
    assert window.scene.field == build(window.session.recipe)
    assert sum(beats) > 5


def test_of_changes_in_a_hurry_the_last_is_shown(window: Window) -> None:
    for side in (300, 200, 250, 150):
        window.session.set("chunk_size", side)
        QTest.qWait(30)
    until(lambda: window.scene is not None and window.scene.field.blocks.shape == (150, 150))
    window.session.set("chunk_size", 400)
    QTest.qWait(40)
    window.session.set("chunk_size", 7)
    until(lambda: window.scene is not None and window.scene.field.blocks.shape == (7, 7))
    QTest.qWait(300)
    assert window.scene is not None
    assert window.scene.field.blocks.shape == (7, 7)


def test_costs_and_warnings_follow(window: Window) -> None:
    until(lambda: "1 model, " in window.costs.text())
    assert window.warning.isHidden()
    (box,) = window.often.findChildren(QSpinBox, "chunk_size_field")
    box.setValue(50)
    window.session.set("mesh_type", "multi")
    until(window.warning.isVisible)
    assert window.warning.text().startswith("Warning: ")
    assert "models: Gazebo Classic needs about" in window.warning.text()
    window.session.undo()
    until(window.warning.isHidden)


def test_the_bar_of_levels_says_how_many_blocks_each_has(window: Window) -> None:
    until(lambda: window.scene is not None and len(window.scene.field.level_counts()) == 5)
    assert window.scene is not None
    counts = window.scene.field.level_counts().items()
    assert window.levels.toolTip().splitlines() == [f"{10 * level} cm: {count} blocks" for level, count in counts]
    image = window.levels.grab().toImage()
    row = [image.pixelColor(x, 3).rgb() for x in range(1, image.width() - 1)]
    shown = sum(row.count(colour) > 3 for colour in set(row))
    assert shown >= 5
