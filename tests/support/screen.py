"""A screen without a screen for programs with windows: Xvfb."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator
from shutil import which
from typing import NoReturn

import pytest


def xvfb() -> Iterator[str]:
    """The number of a display as long as this lasts; the test is skipped, and in CI fails, if there can be none."""
    if not which("Xvfb"):
        missing("no Xvfb: apt-get install xvfb")
    read, write = os.pipe()
    server = subprocess.Popen(
        ["Xvfb", "-displayfd", str(write), "-screen", "0", "1280x800x24", "-nolisten", "tcp", "-noreset"],
        pass_fds=[write],
        stderr=subprocess.DEVNULL,
    )
    os.close(write)
    with os.fdopen(read) as pipe:
        number = pipe.readline().strip()
    yield f":{number}" if number else missing("Xvfb did not start")
    server.terminate()
    server.wait()


def missing(why: str) -> NoReturn:
    """Skip the test, and say why; in CI nothing may be missing."""
    if os.environ.get("CI") == "true":
        pytest.fail(why)
    pytest.skip(why)
