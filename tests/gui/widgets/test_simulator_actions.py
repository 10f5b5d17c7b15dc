"""Open in Gazebo, with stand-ins for the simulators' programs."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

pytest.importorskip("PySide6", reason="the window needs pip install 'rsegen[gui]'")

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QApplication, QMenu

from rsegen import load
from rsegen.gui.model.session import Session
from rsegen.gui.window import Window
from tests.simulation.simulators.standins import PROGRAMS, alone_on_path, put, start
from tests.support.clicking import shown
from tests.support.waiting import until


@pytest.fixture
def programs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder on PATH that stand-ins can be put into."""
    return alone_on_path(tmp_path, monkeypatch)


@contextmanager
def opened(app: QApplication) -> Iterator[Window]:
    window = Window(Session.new())
    with shown(window):
        run = next(menu for menu in window.menuBar().findChildren(QMenu) if menu.title() == "&Run")
        run.popup(window.pos())
        until(lambda: "searching" not in action(window, "Gazebo Sim").text())
        run.close()
        yield window


def action(window: Window, title: str) -> QAction:
    (found,) = window.findChildren(QAction, f"Open in {title}")
    return found


def test_without_a_simulator_the_entries_say_so_and_how_to_get_one(app: QApplication, programs: Path) -> None:
    with opened(app) as window:
        for title in ("Gazebo Sim", "Gazebo Classic"):
            assert action(window, title).text() == f"Open in {title} (not found on this machine)"
            assert not action(window, title).isEnabled()
        assert "apt-get install gz-harmonic" in action(window, "Gazebo Sim").toolTip()


@pytest.mark.parametrize(
    ("name", "title", "program"), [("sim", "Gazebo Sim", "gz"), ("classic", "Gazebo Classic", "gazebo")]
)
def test_the_map_that_is_shown_is_opened(
    name: str, title: str, program: str, app: QApplication, programs: Path
) -> None:
    put(programs, PROGRAMS[name])
    with opened(app) as window:
        window.session.set("maps", 3)
        window.status.index.setValue(2)
        action(window, title).trigger()
        until((programs / f"{program}.started").exists)
        began = start(programs / program)
        world = began.folder / Path(began.command[-1]).name
        assert world.name == "rse_0002.world"
        assert world.is_file()
        assert load(world.with_name("recipe.json")).seed == window.session.recipe.seed
        until(lambda: "Writing" not in window.forms.note.text())
        assert "opens rse_0002" in window.forms.note.text()


def test_a_classic_without_its_window_is_not_offered(app: QApplication, programs: Path) -> None:
    put(programs, {name: program for name, program in PROGRAMS["classic"].items() if name in ("gzserver", "gz")})
    with opened(app) as window:
        assert action(window, "Gazebo Classic").text() == "Open in Gazebo Classic (installed without its window)"
