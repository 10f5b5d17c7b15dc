"""Ctrl-C, a polite kill and a closed terminal: they stop a command once, undisturbed, and it says what is left."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, NoReturn

if TYPE_CHECKING:  # rsegen --help needs none of it
    from rsegen.recipe.recipe import Recipe

_AGAIN = 0.02
"""Seconds until a stop that Python lost is tried again."""


class Stop:
    """The signals that stop a command by a KeyboardInterrupt, from `heed` on; all that follow the first are ignored."""

    def __init__(self) -> None:
        names = ("SIGINT", "SIGTERM", "SIGHUP")
        found = [getattr(signal, name) for name in names if hasattr(signal, name)]
        if threading.current_thread() is not threading.main_thread():
            found = []
        self._before = {each: signal.getsignal(each) for each in found if signal.getsignal(each) is not signal.SIG_IGN}
        self.happened = False

    def heed(self) -> None:
        """From now on a signal raises a KeyboardInterrupt."""
        self._set(self._stop)

    def _stop(self, signal_: int, frame: object) -> NoReturn:
        self._set(signal.SIG_IGN)
        self.happened = True
        raise KeyboardInterrupt

    def _set(self, handler: Callable[[int, object], object] | signal.Handlers) -> None:
        for each in self._before:
            signal.signal(each, handler)

    def restore(self) -> None:
        """What the signals did before."""
        for each, before in self._before.items():
            signal.signal(each, before)

    def again(self) -> None:
        """Stop once more, in a moment."""
        self.heed()
        waiting = threading.Timer(_AGAIN, signal.raise_signal, [next(iter(self._before))])
        waiting.daemon = True
        waiting.start()


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


def how_to_go_on(recipe: Recipe, what: str = "the others") -> str:
    """The end of what is said of a run that can be resumed."""
    return f"the same command with --seed {recipe.seed} --resume makes {what}"
