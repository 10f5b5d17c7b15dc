"""Waiting for what a window does behind itself."""

from __future__ import annotations

import time
from collections.abc import Callable

import pytest


def until(holds: Callable[[], bool], seconds: float = 30, every: int = 25) -> None:
    """Let the window do its work, with short rests in which threads get their turn, until something holds."""
    from PySide6.QtTest import QTest

    end = time.monotonic() + seconds
    while not holds():
        if time.monotonic() > end:
            pytest.fail("it never came")
        QTest.qWait(every)
        time.sleep(0.005)
