"""Names of widgets: for programs, for screen readers, and tooltips."""

from __future__ import annotations

from typing import TypeVar

from PySide6.QtWidgets import QWidget

_Widget = TypeVar("_Widget", bound=QWidget)


def named(widget: _Widget, name: str, *, title: str = "", tip: str = "") -> _Widget:
    """The widget with an object name, an accessible name (by default the same) and a tooltip."""
    widget.setObjectName(name)
    widget.setAccessibleName(title or name.replace("_", " "))
    widget.setToolTip(tip)
    return widget
