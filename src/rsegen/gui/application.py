"""The program: one window, until it is closed."""

from __future__ import annotations

import signal
import sys
from pathlib import Path

from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication

from rsegen.gui.files import choose_map
from rsegen.gui.session import Session
from rsegen.gui.window import Window
from rsegen.io.dataset.manifest import read_manifest
from rsegen.io.dataset.map_reference import dataset_at
from rsegen.recipe.examples import EXAMPLES


def run(recipe: Path | None) -> int:
    """Show the window, of a recipe or a map of a data set if one is given; gives the exit code."""
    dataset = dataset_at(recipe) if recipe else None
    if dataset:
        read_manifest(dataset)  # what is wrong with it is said without a window
    session = _session_of(recipe) if recipe and not dataset else Session.new()
    application = QApplication(sys.argv[:1])
    application.setApplicationName("rsegen")
    window = Window(session)
    window.show()
    if dataset:
        choose_map(window, dataset)
    signal.signal(signal.SIGINT, lambda *_: application.quit())
    awake = QTimer(interval=200)  # Python hears of Ctrl-C only when it is asked something
    awake.timeout.connect(lambda: None)
    awake.start()
    return application.exec()


def _session_of(recipe: Path) -> Session:
    """A file is bound to the session; an example is copied, and stays as it is."""
    return Session.copied(recipe) if recipe in EXAMPLES.values() else Session.opened(recipe)
