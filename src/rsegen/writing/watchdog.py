"""A program that ends a session of processes as soon as the process that started it is gone.

python watchdog.py: its standard input names the session; when that closes, for whatever reason, the session is ended.
It is a session and not a process group, because `gz sim` puts its server and its window into groups of their own. It is
run by its path and imports nothing of rsegen, so that it starts at once.
"""

from __future__ import annotations

import os
import signal
import sys
import time
from contextlib import suppress

TIMEOUT = 5.0
"""Seconds between SIGINT and SIGKILL: a server closes its log in this time; a hanging one delays rsegen's end by it."""

_PAUSE = 0.02
"""Seconds between two looks at what still runs: each reads the table of processes, and most servers end at once."""


def main() -> None:
    """Wait, then end the session."""
    session = sys.stdin.readline()
    sys.stdin.read()
    if session:
        end(int(session))


def end(session: int) -> None:
    """Send SIGINT to every process of a session, and SIGKILL to those that still run after some seconds."""
    for word in (signal.SIGINT, signal.SIGKILL):
        for process in members(session):
            with suppress(ProcessLookupError):
                os.kill(process, word)
        deadline = time.monotonic() + TIMEOUT
        while members(session):
            if time.monotonic() > deadline:
                break
            time.sleep(_PAUSE)


def members(session: int) -> list[int]:
    """Return the ids of the processes of a session that still run."""
    import psutil

    running = []
    for process in psutil.process_iter():
        with suppress(ProcessLookupError, PermissionError, psutil.Error):
            if os.getsid(process.pid) == session and process.status() != psutil.STATUS_ZOMBIE:
                running.append(process.pid)
    return running


if __name__ == "__main__":
    main()
