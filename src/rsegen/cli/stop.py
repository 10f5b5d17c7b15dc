"""Ctrl-C, a polite kill and a closed terminal: the first stops a command in one line, a later one ends it at once.

Ending at once is safe, as nothing half written is ever at its place. The exit code is 128 and the number of the signal,
as shells have it: 130 for Ctrl-C.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import TYPE_CHECKING

from rsegen.errors import Stopped
from rsegen.run import stop

if TYPE_CHECKING:  # rsegen --help needs none of it
    from rsegen.recipe.recipe import Recipe

_ONE_STOP = 1.0
"""Seconds in which further signals are the same stop: Ctrl-C held down, or all that a closing terminal sends."""


class Signals:
    """The signals that stop a command, while this is entered; `number` is that of the one that came."""

    def __init__(self) -> None:
        self.number: int = signal.SIGINT
        self._first: float | None = None

    @contextmanager
    def stop_it(self) -> Iterator[None]:
        """Let a signal raise a KeyboardInterrupt inside; one that was ignored before stays so.

        Python drops one that comes in some callbacks, and would print where: a run looks for it by itself.
        """
        names = ("SIGINT", "SIGTERM", "SIGHUP")
        known = [getattr(signal, name) for name in names if hasattr(signal, name)]
        if threading.current_thread() is not threading.main_thread():
            known = []
        before = {each: signal.getsignal(each) for each in known if signal.getsignal(each) is not signal.SIG_IGN}
        stop.STATE.asked, unraisable = False, sys.unraisablehook
        for each in before:
            signal.signal(each, self._stop)
        sys.unraisablehook = lambda lost: None if lost.exc_type is KeyboardInterrupt else unraisable(lost)
        try:
            yield
        finally:
            sys.unraisablehook = unraisable
            for each, handler in before.items():
                signal.signal(each, handler)

    def _stop(self, number: int, frame: FrameType | None) -> None:
        if self._first is None:
            self._first, self.number = time.monotonic(), number
            stop.ask()
        elif time.monotonic() - self._first > _ONE_STOP:
            if sys.stderr:
                os.write(2, b"rsegen: ended at once; what is complete stays\n")
            os._exit(128 + number)


@contextmanager
def how_to_go_on(*recipes: Recipe, resume: bool = False, then: str = "goes on") -> Iterator[None]:
    """Add to the message of a run that is stopped what the same command does `then`, and with which flags.

    The seed is named if all recipes have the same one.
    """
    try:
        yield
    except Stopped as stopped:
        if not stopped.changed:
            raise
        seeds = {recipe.seed for recipe in recipes}
        flags = [*(f"--seed {seed}" for seed in seeds if len(seeds) == 1), *(["--resume"] if resume else [])]
        given = f" with {' '.join(flags)}" if flags else ""
        raise Stopped(f"{stopped}; the same command{given} {then}") from None
