"""Opening the map that is shown in whichever simulators are here; where one is not, its entry says why."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import cast

from PySide6.QtCore import QObject, QProcess, QProcessEnvironment, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QMenu

from rsegen.gui.newest import Newest
from rsegen.io.worlds import generate
from rsegen.recipe.recipe import Recipe
from rsegen.simulation.simulators import SIMULATORS, Installation, LaunchCommand, OpenRequest


class InGazebo(QObject):
    """An action for every simulator, to be put into a menu.

    asked: one was chosen, by its name. told: what came of it, for the status bar. A simulator that was opened stays
    open when the window is closed.
    """

    asked = Signal(str)
    told = Signal(str)

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self._here: Mapping[str, Installation | None] = {}
        self._folder = tempfile.TemporaryDirectory(prefix="rsegen-", ignore_cleanup_errors=True)
        self._recipe: Recipe | None = None
        self.actions = {name: QAction(self) for name in SIMULATORS}
        for name, action in self.actions.items():
            action.setObjectName(f"Open in {SIMULATORS[name].title}")
            action.triggered.connect(partial(self.asked.emit, name))
        self._finding, self._writing = Newest(self), Newest(self)
        self._finding.came.connect(self._found)
        self._writing.came.connect(self._written)

    def fill(self, menu: QMenu) -> None:
        """Put the actions into a menu, which shows their tips; simulators are looked for when it is opened first."""
        menu.setToolTipsVisible(True)
        menu.aboutToShow.connect(self._find)
        menu.addActions(list(self.actions.values()))

    def show_recipe(self, recipe: Recipe) -> None:
        """Enable what can open the maps of a recipe, and say of the rest why it cannot."""
        self._recipe = recipe
        for name, action in self.actions.items():
            reason = self._hindrance(name)
            action.setText(f"Open in {SIMULATORS[name].title}" + (f" ({reason})" if reason else ""))
            action.setToolTip("\n".join(SIMULATORS[name].how_to_install) if reason else "the map that is shown")
            action.setEnabled(not reason)

    def open(self, name: str, recipe: Recipe, index: int) -> None:
        """Write one map to a place for the time being, and open it."""
        here = self._here[name]
        shown = recipe.alone(index)
        self.told.emit(f"Writing {shown.map_name(index)}...")
        self._writing.order(lambda: (here, _world(shown, Path(self._folder.name))))

    def end(self) -> None:
        """Forget what was written."""
        self._finding.end()
        self._writing.end()
        self._folder.cleanup()

    def _hindrance(self, name: str) -> str:
        """Why the simulator cannot be opened; nothing where it can."""
        if name not in self._here:
            return "looking for it"
        here = self._here[name]
        if here is None:
            return "not found on this machine"
        if self._recipe and not here.simulator.can_open(self._recipe.simulator):
            return f"the recipe says simulator {self._recipe.simulator}"
        return "" if here.simulator.with_gui(here, OpenRequest(world=Path("any.world"))) else "here without its window"

    def _find(self) -> None:
        if not self._here:
            self._finding.order(lambda: {name: simulator.installation() for name, simulator in SIMULATORS.items()})

    def _found(self, here: object) -> None:
        if isinstance(here, Mapping):
            self._here = here
        if self._recipe:
            self.show_recipe(self._recipe)

    def _written(self, came: object) -> None:
        if isinstance(came, Exception):
            self.told.emit(str(came))
        elif isinstance(came, tuple):
            here, world = came
            launch = here.simulator.with_gui(here, OpenRequest(world=world, shared=True))
            self.told.emit(_started(here, launch, world))


def _world(recipe: Recipe, folder: Path) -> Path:
    return generate(recipe, folder, force=True).maps[0].world


def _started(here: Installation, launch: LaunchCommand, world: Path) -> str:
    """Start it as a program of its own, and say so."""
    program, environment = QProcess(), QProcessEnvironment.systemEnvironment()
    for name, value in launch.environment.items():
        environment.insert(name, value)
    program.setProcessEnvironment(environment)
    program.setWorkingDirectory(str(launch.folder))
    program.setProgram(launch.command[0])
    program.setArguments(list(launch.command[1:]))
    started = cast(bool, program.startDetached())  # its stub tells of a pair
    return f"{here} opens {world.stem}" if started else f"{here}: {launch.command[0]} cannot be started"
