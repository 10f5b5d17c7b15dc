"""Signals that ask this process to stop, for runs that must not miss them.

Python drops the KeyboardInterrupt of a signal that comes while a compiled module is imported; one that comes while a
worker is started would leave it half made. So the command line's handler notes it here too, and a run looks, between
batches and after what is `held`. What breaks it: a `held` block that takes long, in which Ctrl-C seems to do nothing.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import SimpleNamespace

STATE = SimpleNamespace(asked=False, held=False)
"""State of signals: asked, if one has come; held, if it has to wait."""


def ask() -> None:
    """Ask to stop: raises KeyboardInterrupt at once, or at the end of what is `held`."""
    STATE.asked = True
    check()


def check() -> None:
    """Raise the KeyboardInterrupt of a signal that has come, unless it is to wait."""
    if STATE.asked and not STATE.held:
        raise KeyboardInterrupt


@contextmanager
def held() -> Iterator[None]:
    """Let signals that stop the run wait until the end of what is done inside; they come to the main thread alone."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before, STATE.held = STATE.held, True
    try:
        yield
    finally:
        STATE.held = before
    check()
