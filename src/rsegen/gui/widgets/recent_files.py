"""The menu of recently opened files."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from PySide6.QtCore import QSettings, Signal
from PySide6.QtWidgets import QMenu, QWidget

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
