"""Names of widgets: for programs, for screen readers, and tooltips."""

from __future__ import annotations

from html import escape
from typing import TypeVar

from PySide6.QtWidgets import QWidget

_Widget = TypeVar("_Widget", bound=QWidget)

_LINE = 80
"""Letters of a tooltip in one line; Qt wraps a longer one only if it is rich text."""


def named(widget: _Widget, name: str, *, title: str = "", tip: str = "") -> _Widget:
    """The widget with an object name, an accessible name (by default the same), and a tooltip that is also spoken."""
    widget.setObjectName(name)
    widget.setAccessibleName(title or name.replace("_", " "))
    widget.setToolTip(tooltip(tip))
    if tip:
        widget.setAccessibleDescription(tip)
    return widget


def tooltip(text: str) -> str:
    """A text as a tooltip that shows it letter by letter, also one that looks like HTML, in lines that fit a screen."""
    return f"<p>{escape(text)}</p>" if "<" in text or len(text) > _LINE else text
