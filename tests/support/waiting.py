"""Waiting for what a window does in threads."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from PySide6.QtWidgets import QWidget

ROUNDS = 10_000
"""Minutes, and longer on a busy machine: no test fails for being slow, only for hanging."""

MINUTES = 600_000
"""The same for Qt's own waiting, in milliseconds."""


def until(holds: Callable[[], bool], every: int = 25) -> None:
    """Let the window work, with short rests in which threads get their turn, until something holds."""
    from PySide6.QtTest import QTest

    for _ in range(ROUNDS):
        if holds():
            return
        QTest.qWait(every)
        time.sleep(0.005)
    pytest.fail("it never came")


def exposed(widget: QWidget) -> None:
    """Wait until a window is on the screen."""
    from PySide6.QtTest import QTest

    assert QTest.qWaitForWindowExposed(widget, MINUTES)
