"""What still runs of what a test has started: all of it is known by a variable."""

from __future__ import annotations

import os
from contextlib import suppress

import psutil
import pytest

from tests.support.patience import until

MARK = "RSEGEN_TEST"
"""The variable."""


def left(mark: str) -> list[psutil.Process]:
    """What still runs with that mark, beside this process."""
    found = []
    for process in psutil.process_iter():
        with suppress(psutil.Error):
            ours = process.environ().get(MARK) == mark and process.pid != os.getpid()
            if ours and process.status() != psutil.STATUS_ZOMBIE:
                found.append(process)
    return found


def left_in_the_end(mark: str) -> list[psutil.Process]:
    """What still runs with that mark after a long wait, or nothing as soon as there is nothing."""
    with suppress(pytest.fail.Exception):
        until(lambda: not left(mark))
    return left(mark)
