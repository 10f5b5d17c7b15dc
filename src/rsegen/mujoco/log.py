"""MuJoCo's log, switched off while rsegen simulates: a drive that fails says so itself, in one line.

By default MuJoCo prints each warning, and appends it to MUJOCO_LOG.TXT in the current folder, which is the user's.
Whether it does is a setting of the whole process, which a user's own worlds share, so it is restored after each
simulation. With threads the first one that simulates switches the log off, and the last one that ends restores it.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock
from typing import Any

import mujoco

from rsegen.errors import SimulatorFailed


class _Log:
    """The log of this process: how many threads need it to be silent, and its settings before the first one."""

    def __init__(self) -> None:
        self._lock, self._count = Lock(), 0
        self._before: tuple[bool, bool] = (True, True)

    @contextmanager
    def silent(self) -> Iterator[None]:
        with self._lock:
            if not self._count:
                config = mujoco.MjLogConfig.get()
                self._before = config.logto_console, config.logto_file
                _set(config, (False, False))
            self._count += 1
        try:
            yield
        finally:
            with self._lock:
                self._count -= 1
                if not self._count:
                    _set(mujoco.MjLogConfig.get(), self._before)


def _set(config: Any, values: tuple[bool, bool]) -> None:
    config.logto_console, config.logto_file = values
    config.set()


_LOG = _Log()


@contextmanager
def without_log() -> Iterator[None]:
    """Keep MuJoCo from printing or writing a log inside, and raise its fatal errors as SimulatorFailed."""
    with _LOG.silent():
        try:
            yield
        except mujoco.FatalError as error:
            raise SimulatorFailed(f"MuJoCo: {str(error).splitlines()[0]}") from None
