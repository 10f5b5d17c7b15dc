"""The window's map in a running Gazebo Classic."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

pytest.importorskip("PySide6", reason="the window needs pip install 'rsegen[gui]'")
if sys.platform == "linux" and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

from PySide6.QtCore import QSettings, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from rsegen import generate
from rsegen.gui.model.session import Session
from rsegen.gui.window import Window
from rsegen.recipe.recipe import Recipe
from rsegen.simulation.simulators import Installation
from rsegen.simulation.simulators.server import running_server
from tests.support.waiting import until

pytestmark = pytest.mark.long(reason="a window and a server")


def test_a_map_is_sent_and_the_next_one_takes_its_place(
    gazebo: Installation, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    QSettings.setPath(QSettings.Format.NativeFormat, QSettings.Scope.UserScope, str(tmp_path / "settings"))
    app = QApplication.instance() or QApplication([])
    world = generate(Recipe(name="bare", seed=1, boundary="none"), tmp_path).maps[0].world
    with running_server(gazebo, world) as server:
        for name, value in server.environment.items():
            monkeypatch.setenv(name, value)
        window = Window(Session.new())
        window.show()
        QTest.qWaitForWindowExposed(window)
        message = window.forms.note.text
        window.session.add({"kind": "peak", "levels": 5, "first": [2, 2], "last": [7, 7]})
        for told in ("rse_0000-1 is in the simulation", "rse_0000-2 is in the simulation, in place of rse_0000-1"):
            QTest.keyClick(window, Qt.Key.Key_F6)
            until(lambda told=told: message() == told)  # type: ignore[misc]
            window.session.set("unit_cm", 5)
        with server.connect() as live:
            there = set(live.poses())
        window.document.open(Session.new())
        window.close()
    assert app
    assert "rse_0000-2" in there
    assert "rse_0000-1" not in there


def test_without_a_running_simulation_the_window_shows_an_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    app = QApplication.instance() or QApplication([])
    monkeypatch.setenv("GAZEBO_MASTER_URI", "http://127.0.0.1:9")
    window = Window(Session.new())
    window.show()
    QTest.qWaitForWindowExposed(window)
    QTest.keyClick(window, Qt.Key.Key_F6)
    until(lambda: "no simulation runs" in window.forms.note.text())
    window.document.open(Session.new())
    window.close()
    assert app
