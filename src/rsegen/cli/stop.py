"""Ctrl-C, a polite kill and a closed terminal: they stop a command once, undisturbed, and it says what is left."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # rsegen --help needs none of it
    from rsegen.recipe.recipe import Recipe

_AGAIN = 0.02
"""Seconds until a stop that Python lost is tried again."""
_IMPORT = 50
"""How many of these an import may take: what stops it after that stops it at any line."""


class Stop:
    """The signals that stop a command by a KeyboardInterrupt, from `heed` on; all that follow the first are ignored."""

    def __init__(self) -> None:
        names = ("SIGINT", "SIGTERM", "SIGHUP")
        found = [getattr(signal, name) for name in names if hasattr(signal, name)]
        if threading.current_thread() is not threading.main_thread():
            found = []
        self._before = {each: signal.getsignal(each) for each in found if signal.getsignal(each) is not signal.SIG_IGN}
        self._put_off = 0
        self._repeating: threading.Timer | None = None
        self.happened: bool = False

    def heed(self) -> None:
        """From now on a signal raises a KeyboardInterrupt."""
        self._set(self._stop)

    def _stop(self, signal_: int, frame: FrameType | None) -> None:
        self._set(signal.SIG_IGN)
        self.happened = True
        if self._put_off == _IMPORT or not _importing(frame):
            raise KeyboardInterrupt
        self._put_off += 1
        self.again()

    def _set(self, handler: Callable[[int, FrameType | None], object] | signal.Handlers) -> None:
        for each in self._before:
            signal.signal(each, handler)

    def restore(self) -> None:
        """What the signals did before."""
        if self._repeating:
            self._repeating.cancel()
        for each, before in self._before.items():
            signal.signal(each, before)

    def again(self) -> None:
        """Stop once more, in a moment."""
        self.heed()
        self._repeating = threading.Timer(_AGAIN, _signal_to_main, [next(iter(self._before))])
        self._repeating.daemon = True
        self._repeating.start()


def _signal_to_main(number: int) -> None:
    """Wake the main thread by a signal, wherever it waits; where the system can't, once it waits no more."""
    if hasattr(signal, "pthread_kill") and (main := threading.main_thread().ident):
        signal.pthread_kill(main, number)
    else:
        signal.raise_signal(number)


def _importing(frame: FrameType | None) -> bool:
    """Whether a module is being imported: compiled ones drop every exception that comes in some of their lines."""
    while frame and not frame.f_code.co_filename.startswith("<frozen importlib"):
        frame = frame.f_back
    return frame is not None


@contextmanager
def stoppable() -> Iterator[Stop]:
    """Signals that stop what runs inside, once it asks for it; afterwards they are as they were.

    Python drops an exception that comes while it calls back for itself, as when a module has been imported, and tells
    `sys.unraisablehook`; a stop that is lost so is repeated.
    """
    stop, usual = Stop(), sys.unraisablehook

    def repeat(lost: sys.UnraisableHookArgs) -> None:
        if stop.happened and lost.exc_type is KeyboardInterrupt:
            stop.again()
        else:
            usual(lost)

    sys.unraisablehook = repeat
    try:
        yield stop
    finally:
        sys.unraisablehook = usual
        stop.restore()


@contextmanager
def told_what_is_left(left: Callable[[], str]) -> Iterator[None]:
    """Who stops what runs inside hears what it leaves, and how to go on."""
    try:
        yield
    except KeyboardInterrupt:
        raise KeyboardInterrupt(f"stopped; {left()}") from None


def how_to_go_on(*recipes: Recipe, what: str = "the others") -> str:
    """The end of what is said of a run that can be resumed; of several recipes one seed is named if all have it."""
    seeds = {recipe.seed for recipe in recipes}
    seed = f"--seed {seeds.pop()} " if len(seeds) == 1 else ""
    return f"the same command with {seed}--resume makes {what}"
