"""The program: one window, until it is closed."""

from __future__ import annotations

import signal
import sys
from pathlib import Path

from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication

from rsegen.examples import EXAMPLES
from rsegen.gui.session import Session
from rsegen.gui.window import Window


def run(recipe: Path | None) -> int:
    """Show the window, of a recipe if one is given; gives the exit code."""
    session = Session.new() if recipe is None else _session_of(recipe)
    application = QApplication(sys.argv[:1])
    application.setApplicationName("rsegen")
    window = Window(session)
    window.show()
    signal.signal(signal.SIGINT, lambda *_: application.quit())
    awake = QTimer(interval=200)  # Python hears of Ctrl-C only when it is asked something
    awake.timeout.connect(lambda: None)
    awake.start()
    return application.exec()


def _session_of(recipe: Path) -> Session:
    """A file is bound to the session; an example is copied, and stays as it is."""
    return Session.copied(recipe) if recipe in EXAMPLES.values() else Session.opened(recipe)
