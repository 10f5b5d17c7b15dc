"""Asking where to save a file; a name without the suffix of its format gets one."""

from __future__ import annotations

import re
from pathlib import Path

from PySide6.QtWidgets import QFileDialog, QMessageBox, QWidget


def ask_where_to_save(parent: QWidget, title: str, default: str, formats: str) -> Path | None:
    """The file that the user chooses, with a suffix of the formats; None if the user cancels.

    formats: as in Qt, such as `PNG (*.png);;JPEG (*.jpg *.jpeg)`.
    """
    name, chosen = QFileDialog.getSaveFileName(parent, title, default, formats)
    if not name:
        return None
    path = Path(name)
    if path.suffix.lower() in _suffixes(formats):
        return path
    path = path.with_name(path.name + _suffixes(chosen or formats)[0])
    return path if not path.exists() or _may_replace(parent, path) else None


def _suffixes(formats: str) -> list[str]:
    return re.findall(r"\*(\.\w+)", formats)


def _may_replace(parent: QWidget, path: Path) -> bool:
    """Qt has asked for the name without the suffix only."""
    yes, no = QMessageBox.StandardButton.Yes, QMessageBox.StandardButton.No
    return QMessageBox.question(parent, "rsegen", f"{path.name} already exists. Replace it?", yes | no, no) == yes
