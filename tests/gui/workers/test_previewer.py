"""Previews of the window's map: large ones do not block it, and only the latest is shown."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

pytest.importorskip("PySide6", reason="the window needs pip install 'rsegen[gui]'")

from PySide6.QtCore import QTimer
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QSpinBox

from rsegen import build
from rsegen.gui.model.session import Session
from rsegen.gui.window import Window
from tests.support.clicking import shown
from tests.support.waiting import until


@pytest.fixture
def window(app: QApplication) -> Iterator[Window]:
    window = Window(Session.new())
    window.resize(1280, 720)
    window.session.add({"kind": "random", "levels": 5})
    with shown(window):
        yield window


def test_a_large_map_comes_while_the_window_goes_on(window: Window) -> None:
    window.session.set("chunk_size", 1000)
    until(lambda: window.previewer.busy, every=2)
    beats, beat = [], QTimer(interval=2)
    beat.timeout.connect(lambda: beats.append(window.previewer.busy))
    beat.start()
    until(lambda: window.previewer.scene is not None and window.previewer.scene.field.shape[0] > 1000)
    assert window.previewer.scene is not None
    assert window.previewer.scene.field == build(window.session.recipe)
    assert sum(beats) > 5


def test_of_changes_in_a_hurry_the_last_is_shown(window: Window) -> None:
    for side in (300, 200, 250, 150):
        window.session.set("chunk_size", side)
        QTest.qWait(30)
    until(lambda: window.previewer.scene is not None and window.previewer.scene.field.blocks.shape == (150, 150))
    window.session.set("chunk_size", 400)
    until(lambda: window.previewer.busy, every=2)
    window.session.set("chunk_size", 7)
    until(lambda: window.previewer.scene is not None and window.previewer.scene.field.blocks.shape == (7, 7))
    until(lambda: not window.previewer.busy)
    assert window.previewer.scene is not None
    assert window.previewer.scene.field.blocks.shape == (7, 7)


def test_costs_and_warnings_follow(window: Window) -> None:
    until(lambda: "1 model, " in window.status.costs.text())
    assert window.forms.warning.isHidden()
    (box,) = window.forms.basic.findChildren(QSpinBox, "chunk_size_field")
    box.setValue(50)
    window.session.set("mesh_type", "multi")
    until(window.forms.warning.isVisible)
    assert window.forms.warning.text().startswith("Warning: ")
    assert "models: Gazebo Classic needs about" in window.forms.warning.text()
    window.session.undo()
    until(window.forms.warning.isHidden)


def test_the_bar_of_levels_says_how_many_blocks_each_has(window: Window) -> None:
    until(lambda: window.previewer.scene is not None and len(window.previewer.scene.field.level_counts()) == 5)
    assert window.previewer.scene is not None
    counts = window.previewer.scene.field.level_counts().items()
    assert window.status.levels.toolTip().splitlines() == [
        f"{10 * level} cm: {count} blocks" for level, count in counts
    ]
    image = window.status.levels.grab().toImage()
    row = [image.pixelColor(x, 3).rgb() for x in range(1, image.width() - 1)]
    shown = sum(row.count(colour) > 3 for colour in set(row))
    assert shown >= 5
