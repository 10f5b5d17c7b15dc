"""A screen without a screen for programs with windows: Xvfb."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from shutil import which

from tests.support.missing import missing


@contextmanager
def xvfb(frames: Path | None = None) -> Iterator[str]:
    """The number of a free display that is ready; the test is skipped, and in CI fails, if there can be none.

    What is on it lies in `frames`/Xvfb_screen0, in the format of xwd, if a folder is given.
    """
    if not which("Xvfb"):
        missing("no virtual screen: run scripts/screen")
    kept = [] if frames is None else ["-fbdir", str(frames)]
    read, write = os.pipe()
    with (
        os.fdopen(read) as pipe,
        subprocess.Popen(
            ["Xvfb", "-displayfd", str(write), "-screen", "0", "1280x800x24", "-nolisten", "tcp", "-noreset", *kept],
            pass_fds=[write],
            stderr=subprocess.DEVNULL,
        ) as server,
    ):
        os.close(write)
        try:
            number = pipe.readline().strip()
            yield f":{number}" if number else missing("Xvfb did not start")
        finally:
            server.terminate()
