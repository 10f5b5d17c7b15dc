"""Watches what runs in this process: what it writes and where, what it starts, and how much it uses.

Python tells an audit hook of every file that is opened for writing, and of every process that is started. Once it is
installed it stays, so it is for processes that do nothing else.
"""

from __future__ import annotations

import os
import resource
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NoReturn

import mujoco  # noqa: F401  # the first import of the package asks for the version of glfw in a process

CPU_SECONDS = 10
WALL_SECONDS = 90
"""Of one case: twice what the dearest honest one takes, which scans a mesh by 400,000 points, and for a machine with
much else to do; what waits for what never comes uses no CPU time."""
HONEST_MAPS = 50
"""Maps in a CPU second. A case that makes as many does what it was asked for, and is asked for many."""
MEMORY = 1_500_000_000
"""Bytes that a case may need beyond those of the process before it."""
LARGEST_FILE = 100_000_000

_WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
_PATHS = {"os.mkdir": ((0, 2),), "os.remove": ((0, 1),), "os.rmdir": ((0, 1),), "os.rename": ((0, 2), (1, 3))}
_PATHS |= {"os.symlink": ((1, 2),), "os.link": ((1, 3),), "os.truncate": ((0, -1),), "os.chmod": ((0, 2),)}
"""Event -> for each path that it changes, where it is among its arguments, and the folder that it is relative to."""
_STARTS = {
    "subprocess.Popen",
    "os.exec",
    "os.posix_spawn",
    "os.system",
    "os.fork",
    "os.forkpty",
    "os.kill",
    "os.startfile",
}


class Exceeded(BaseException):
    """More time than a case may use; if `honest`, it needs it because it makes many maps, each of them quickly."""

    def __init__(self, what: str, *, honest: bool = False) -> None:
        super().__init__(what)
        self.honest = honest


class Sandbox:
    """Record of what happens in this process, inside a folder."""

    def __init__(self, root: Path) -> None:
        self._root = f"{os.path.realpath(root)}{os.sep}"
        self._watching = False
        self.may_connect = False
        """True if the case speaks with servers of its own."""
        self.amiss: list[str] = []
        self.maps = 0
        """Built in this case so far; whoever builds them counts."""
        used = (
            int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
            if sys.platform == "linux"
            else 0
        )
        if used:
            resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY, used + MEMORY))
        resource.setrlimit(resource.RLIMIT_FSIZE, (LARGEST_FILE, LARGEST_FILE))
        sys.addaudithook(self._heard)

    @contextmanager
    def watched(self) -> Iterator[None]:
        """Watch what runs inside; Exceeded if it takes too long."""
        self.amiss.clear()
        self.maps = 0
        signal.signal(signal.SIGPROF, self._stop)
        signal.signal(signal.SIGALRM, self._stop)
        signal.setitimer(signal.ITIMER_PROF, CPU_SECONDS)
        signal.setitimer(signal.ITIMER_REAL, WALL_SECONDS)
        self._watching = True
        try:
            yield
        finally:
            self._watching = False
            signal.setitimer(signal.ITIMER_PROF, 0)
            signal.setitimer(signal.ITIMER_REAL, 0)

    def _heard(self, event: str, arguments: tuple[Any, ...]) -> None:
        if not self._watching:
            return
        if event == "open":
            path, _, flags = arguments
            if isinstance(flags, int) and flags & _WRITING and not isinstance(path, int):
                self._check(event, os.path.realpath(os.fsdecode(path)))
        elif event in _PATHS:
            for place, folder in _PATHS[event]:
                base = arguments[folder] if folder >= 0 else -1
                self._check(event, _whole(arguments[place], base))
        elif event in _STARTS:
            self.amiss.append(f"started a process: {event}")
            raise PermissionError(1, "Operation not permitted")
        elif event == "socket.connect" and not self.may_connect:
            raise ConnectionRefusedError(111, "Connection refused")

    def _stop(self, number: int, _: object) -> NoReturn:
        honest = self.maps >= CPU_SECONDS * HONEST_MAPS
        raise Exceeded("CPU time" if number == signal.SIGPROF else "wall time", honest=honest)

    def _check(self, event: str, path: str) -> None:
        if not path.startswith(self._root) and path not in ("/dev/null", "/dev/full"):
            self.amiss.append(f"{event} outside its folder: {path}")
            raise PermissionError(13, "Permission denied", path)


def _whole(path: Any, folder: int) -> str:
    """Path of something that is itself not followed if it is a link."""
    if isinstance(path, int):
        return os.path.realpath(f"/proc/self/fd/{path}")
    base = "." if folder < 0 else f"/proc/self/fd/{folder}"
    whole = os.path.join(base, os.fsdecode(path))
    return os.path.join(os.path.realpath(os.path.dirname(whole)), os.path.basename(whole))
