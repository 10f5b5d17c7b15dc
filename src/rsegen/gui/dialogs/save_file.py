"""Asking where to save a file; a name without the suffix of its format gets one."""

from __future__ import annotations

import re
from pathlib import Path

from PySide6.QtWidgets import QFileDialog, QWidget

from rsegen.gui.widgets.run_form import may_replace


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
    if path.exists() and not may_replace(parent, f"{path.name} already exists. Replace it?"):
        return None  # Qt has asked for the name without the suffix only
    return path


def _suffixes(formats: str) -> list[str]:
    return re.findall(r"\*(\.\w+)", formats)
