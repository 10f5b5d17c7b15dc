"""The time that a simulator is waited for.

Idea: a machine on which fifty programs want two processors takes 25 times as long for everything, and a large world
takes minutes on any. So the seconds of a wait count by the share of a processor that a program gets at the moment, and
not at all while the program that is waited for works. Source: the system's count of programs that want to run (the
fourth figure of /proc/loadavg on Linux, at once; elsewhere the mean of a minute). Cost: a file is read per look. What
breaks it: a program that works for ever without an end in sight, which is given up after thirty times the seconds.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

SECONDS = 20.0
"""Seconds by default: a server that loads a map of 320 x 320 blocks answers nothing for 5 to 8 on a quiet machine."""

_MOST = 30
"""Times of the seconds after which a program is given up although it works: 10 minutes by default.

80 x 80 single models take Gazebo Classic 87 s to load, 160 x 160 boxes more than 100; a program in a loop never ends.
"""

_LOOK = 1.0
"""Seconds between two looks at what the program has done: the look reads the table of processes."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Patience:
    """Seconds, as on a quiet machine, for which a program may show no progress.

    sign: seconds within which it must give any sign of being there; works: whether it has worked since this was asked
    before, by default unknown, which counts as no
    """

    seconds: float = SECONDS
    sign: float = SECONDS
    works: Callable[[], bool] = lambda: False

    def begin(self) -> Wait:
        """Begin to wait."""
        return Wait(self)

    def __str__(self) -> str:
        return f"{self.seconds:g} s"


class Wait:
    """A wait that has begun."""

    def __init__(self, patience: Patience) -> None:
        self._patience = patience
        self._last = time.monotonic()
        self._idle = self._unseen = self._all = 0.0

    @property
    def is_over(self) -> bool:
        """Return whether the wait has ended; to be asked again and again."""
        now = time.monotonic()
        passed, self._last = (now - self._last) * share(), now
        self._unseen += passed
        self._all += passed
        if self._unseen >= min(_LOOK, self._patience.seconds):
            self._idle = 0.0 if self._patience.works() else self._idle + self._unseen
            self._unseen = 0.0
        return self._idle >= self._patience.seconds or self._all >= _MOST * self._patience.seconds


def share() -> float:
    """Return the share of a processor that a program gets now: 1 on a quiet machine, 0.04 if fifty want two."""
    processors = os.cpu_count() or 1
    return processors / max(_programs_that_run(), processors)


def _programs_that_run() -> float:
    with suppress(OSError, ValueError, IndexError):  # not Linux
        return float(Path("/proc/loadavg").read_text("ascii").split()[3].partition("/")[0])
    import psutil

    return float(psutil.getloadavg()[0])
