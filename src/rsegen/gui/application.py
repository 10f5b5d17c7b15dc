"""The program `rsegen gui`: one window, until it is closed."""

from __future__ import annotations

import signal
import sys
from pathlib import Path

from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication

from rsegen.gui.model.session import Session
from rsegen.gui.window import Window
from rsegen.io.dataset.layout import read_manifest
from rsegen.io.targets import dataset_at
from rsegen.recipe.examples import EXAMPLES
from rsegen.recipe.recipe import Recipe


def run(recipe: Path | Recipe | None) -> int:
    """Show the window until it is closed, with a recipe or a map of a data set if one is given; gives the exit code."""
    dataset = dataset_at(recipe) if isinstance(recipe, Path) else None
    if dataset:
        read_manifest(dataset)  # an invalid one is refused without a window
    session = session_of(recipe) if recipe and not dataset else Session.new()
    application = QApplication(sys.argv[:1])
    application.setApplicationName("rsegen")
    window = Window(session)
    window.show()
    if dataset:
        window.files.choose_map(dataset)
    signal.signal(signal.SIGINT, lambda *_: application.quit())
    heartbeat = QTimer(interval=200)  # Python sees Ctrl-C only when one of its functions is called
    heartbeat.timeout.connect(lambda: None)
    heartbeat.start()
    return application.exec()


def session_of(recipe: Path | Recipe) -> Session:
    """A session that is bound to a recipe file; an example is copied, so that it stays unchanged, as is a recipe."""
    if isinstance(recipe, Recipe):
        return Session.imported(recipe)
    return Session.copied(recipe) if recipe in EXAMPLES.values() else Session.opened(recipe)
