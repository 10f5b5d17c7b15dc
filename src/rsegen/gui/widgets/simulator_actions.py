"""Menu entries: simulators that open the map, commands that are enabled while possible, and recent files."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import NamedTuple, cast

from PySide6.QtCore import QObject, QProcess, QProcessEnvironment, QSettings, Signal
from PySide6.QtGui import QAction, QKeySequence
from PySide6.QtWidgets import QMenu, QWidget

from rsegen.gui.model.simulation import (
    Installed,
    LaunchCommand,
    how_to_install,
    installed,
    launch_of,
    simulator_titles,
    why_it_cannot_open,
)
from rsegen.gui.workers import LatestOnly, failure_text
from rsegen.recipe.recipe import Recipe


class SimulatorActions(QObject):
    """An action per simulator, to be put into a menu.

    requested: the name of the simulator that was chosen; message: what is done and how it ended. An opened simulator
    stays open when the window is closed.
    """

    requested = Signal(str)
    message = Signal(str)

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self._installed: Installed = {}
        self._folder = tempfile.TemporaryDirectory(prefix="rsegen-", ignore_cleanup_errors=True)
        self._recipe: Recipe | None = None
        self._is_valid = True
        self._titles = simulator_titles()
        self.actions = {name: QAction(self) for name in self._titles}
        for name, action in self.actions.items():
            action.setObjectName(f"Open in {self._titles[name]}")
            action.triggered.connect(partial(self.requested.emit, name))
        self._finder, self._writer = LatestOnly(self), LatestOnly(self)
        self._finder.result.connect(self._take_installed)
        self._writer.result.connect(self._launch)

    def add_to(self, menu: QMenu) -> None:
        """Put the actions into a menu, which shows their tooltips; simulators are searched when it is first opened."""
        menu.setToolTipsVisible(True)
        menu.aboutToShow.connect(self._find)
        menu.addActions(list(self.actions.values()))

    def show_recipe(self, recipe: Recipe, *, is_valid: bool = True) -> None:
        """Enable the simulators that can open the maps of a recipe; the text of the others says why they cannot.

        None can while what is shown is not valid, and `recipe` is the last one that was.
        """
        self._recipe, self._is_valid = recipe, is_valid
        for name, action in self.actions.items():
            reason = self._reason(name)
            action.setText(f"Open in {self._titles[name]}" + (f" ({reason})" if reason else ""))
            action.setToolTip(how_to_install(name) if reason else "open the map that is shown")
            action.setEnabled(not reason)

    def open(self, name: str, recipe: Recipe, index: int) -> None:
        """Write one map to a temporary folder, and open it."""
        if here := self._installed[name]:
            shown = recipe.alone(index)
            self.message.emit(f"Writing {shown.map_name(index)}...")
            self._writer.submit(lambda: (str(here), *launch_of(here, shown, Path(self._folder.name))))

    def stop(self) -> None:
        """Wait for what is being written, and delete it."""
        self._finder.stop()
        self._writer.stop()
        self._folder.cleanup()

    def _reason(self, name: str) -> str:
        """Return why a simulator cannot be opened; empty if it can."""
        if name not in self._installed:
            return "searching"
        reason = why_it_cannot_open(self._installed[name])
        return reason or ("" if self._is_valid else "the recipe has an error")

    def _find(self) -> None:
        if not self._installed:
            self._finder.submit(installed)

    def _take_installed(self, result: object) -> None:
        if isinstance(result, Mapping):
            self._installed = result
        if self._recipe:
            self.show_recipe(self._recipe, is_valid=self._is_valid)

    def _launch(self, result: object) -> None:
        if isinstance(result, tuple):
            title, launch, world = result
            started = _started(launch)
            self.message.emit(
                f"{title} opens {world.stem}" if started else f"{title}: cannot start {launch.command[0]}"
            )
        else:
            self.message.emit(failure_text(result))


def _started(launch: LaunchCommand) -> bool:
    """Start a command as a program that outlives the window; gives whether it started."""
    program, environment = QProcess(), QProcessEnvironment.systemEnvironment()
    for name, value in launch.environment.items():
        environment.insert(name, value)
    program.setProcessEnvironment(environment)
    program.setWorkingDirectory(str(launch.folder))
    program.setProgram(launch.command[0])
    program.setArguments(list(launch.command[1:]))
    return cast(bool, program.startDetached())  # its stub says it returns a pair


def _always() -> bool:
    return True


class Command(NamedTuple):
    """What a menu entry is called, what it does, its shortcut, and when it is enabled."""

    text: str
    run: Callable[[], object]
    keys: QKeySequence.StandardKey | str = ""
    is_possible: Callable[[], bool] = _always


class CommandMenus:
    """The commands of all menus as actions of a widget, in which their shortcuts work.

    `before` is called before a command runs; it may make the command impossible, which is then not run.
    """

    def __init__(self, parent: QWidget, before: Callable[[], object] = lambda: None) -> None:
        self._parent, self._before = parent, before
        self._actions: list[tuple[QAction, Callable[[], bool]]] = []

    def add(self, menu: QMenu, *commands: Command) -> None:
        """Add commands at the end of a menu."""
        for command in commands:
            action = QAction(command.text, self._parent)
            action.setObjectName(command.text.replace("&", "").rstrip("."))
            action.setShortcut(QKeySequence(command.keys))
            action.triggered.connect(lambda _=False, command=command: self._run(command))
            menu.addAction(action)
            self._actions.append((action, command.is_possible))

    def _run(self, command: Command) -> None:
        self._before()
        if command.is_possible():
            command.run()

    def refresh(self) -> None:
        """Enable the commands that can be done now."""
        for action, is_possible in self._actions:
            action.setEnabled(is_possible())


REMEMBERED = 8
"""The number of files in the menu."""


class RecentFiles(QMenu):
    """An entry per recent file; `chosen` gives its path."""

    chosen = Signal(Path)

    def __init__(self, parent: QWidget) -> None:
        super().__init__("Open &recent", parent)
        self.aboutToShow.connect(self.fill)

    def remember(self, path: Path) -> None:
        """Put a file at the top of the list."""
        names = [str(path.resolve()), *(name for name in _names() if name != str(path.resolve()))]
        QSettings("rsegen", "rsegen").setValue("recent", names[:REMEMBERED])

    def fill(self) -> None:
        """Replace the entries by the files of now."""
        self.clear()
        for name in _names():
            self.addAction(name, partial(self.chosen.emit, Path(name)))
        if self.isEmpty():
            self.addAction("none yet").setEnabled(False)


def _names() -> list[str]:
    found = QSettings("rsegen", "rsegen").value("recent")
    return [found] if isinstance(found, str) else [str(name) for name in found] if isinstance(found, list) else []
