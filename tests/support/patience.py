"""Waits of tests: limits of CPU time, which a busy machine does not use up, and a long limit of wall time last.

`run` is `subprocess.run` within such limits, `within_limits` the command that sets them for a `Popen`. `until` waits
for what another process or thread does. `limit_cpu_of_tests` gives every test the same limit.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from itertools import count
from typing import Any, NoReturn

import psutil
import pytest

CPU_SECONDS = 300
"""CPU time that a test, or a process that it starts, may use: many times what any of them needs."""
PATIENCE = 30 * 60
"""Wall time in seconds after which a test that waits gives up: the last resort, for what hangs and uses no CPU."""
LOOKS = 100
"""Number of looks of `until` before it asks for the CPU time again, which takes some itself."""


def within_limits(*command: object, cpu_seconds: int = CPU_SECONDS) -> list[str]:
    """The command, which the system ends with SIGXCPU once it, or any process it starts, has used this CPU time."""
    words = [str(word) for word in command]
    if sys.platform == "win32":
        return words
    return ["/bin/sh", "-c", f'ulimit -t {cpu_seconds}; exec "$@"', "sh", *words]


def run(
    command: Sequence[object], *, cpu_seconds: int = CPU_SECONDS, **options: Any
) -> subprocess.CompletedProcess[Any]:
    """`subprocess.run` of a command within the limits."""
    return subprocess.run(  # noqa: PLW1510  # `check` is the caller's
        within_limits(*command, cpu_seconds=cpu_seconds), timeout=PATIENCE, **options
    )


def rest() -> None:
    """Let other threads and processes work."""
    time.sleep(0.002)


def until(holds: Callable[[], object], *, cpu_seconds: int = CPU_SECONDS) -> None:
    """Return as soon as something holds; fail if this process and its children have used that much CPU time before."""
    limit, began, looks = cpu_used() + cpu_seconds, time.monotonic(), count(1)
    while not holds():
        if next(looks) % LOOKS == 0 and (cpu_used() > limit or time.monotonic() > began + PATIENCE):
            pytest.fail("what the test waits for did not happen")
        rest()


def cpu_used() -> float:
    """CPU time in seconds that this process and its children, ended or not, have used."""
    return sum(os.times()[:4]) + sum(map(_cpu_used_by, psutil.Process().children(recursive=True)))


def _cpu_used_by(process: psutil.Process) -> float:
    with suppress(psutil.Error):
        return sum(process.cpu_times()[:2])
    return 0.0


@contextmanager
def limit_cpu_of_tests(cpu_seconds: int = CPU_SECONDS) -> Iterator[None]:
    """Fail the test that runs inside where it uses more CPU time than that, in whatever loop it is."""

    def stop(*_: object) -> NoReturn:
        pytest.fail(f"used more than {cpu_seconds} s of CPU time")

    if sys.platform == "win32":
        yield
        return
    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, cpu_seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)
