"""Processes that a test has started and that still run, known by a variable."""

from __future__ import annotations

import os
from contextlib import suppress

import psutil
import pytest

from tests.support.patience import until

MARK = "RSEGEN_TEST"
"""The variable."""


def left(mark: str) -> list[psutil.Process]:
    """Processes with that mark that still run, without this one."""
    found = []
    for process in psutil.process_iter():
        with suppress(psutil.Error):
            ours = process.environ().get(MARK) == mark and process.pid != os.getpid()
            if ours and process.status() != psutil.STATUS_ZOMBIE:
                found.append(process)
    return found


def left_in_the_end(mark: str) -> list[psutil.Process]:
    """Processes with that mark that still run after a long wait; none as soon as all have ended."""
    with suppress(pytest.fail.Exception):
        until(lambda: not left(mark))
    return left(mark)
