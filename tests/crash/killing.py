"""Kills the processes of a command at a moment, for commands with a simulator."""

from __future__ import annotations

import os
import random
import subprocess
import sys
import time
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import psutil

_LONGEST = 600


def started(command: Sequence[str], folder: Path) -> subprocess.Popen[str]:
    """A command that writes into a folder, as a session of processes of its own."""
    arguments = [sys.executable, "-m", "rsegen", *command, "-o", str(folder)]
    return subprocess.Popen(
        arguments, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, start_new_session=True
    )


def ended(process: subprocess.Popen[str]) -> tuple[int, str]:
    """Its exit code and what it said on stderr, at its end."""
    _, err = process.communicate(timeout=_LONGEST)
    return process.returncode, err


def kill_after(process: subprocess.Popen[str], seconds: float, rng: random.Random) -> None:
    """Kill a run by a signal that it cannot handle; return when none of its processes is left."""
    with suppress(subprocess.TimeoutExpired):
        process.wait(seconds)
    with suppress(psutil.NoSuchProcess):
        processes = [psutil.Process(process.pid), *psutil.Process(process.pid).children(recursive=True)]
        if rng.random() < 0.5:
            processes = [rng.choice(processes)]
        for each in processes:
            with suppress(psutil.NoSuchProcess):
                each.kill()
    ended(process)
    while _session_lives(process.pid):
        time.sleep(0.01)


def _session_lives(session: int) -> bool:
    try:
        os.killpg(session, 0)
    except ProcessLookupError:
        return False
    return True
