"""Tell whoever watches how far long work is: a bar of the command line, for every command that makes a map.

Work deep in the core tells its share; nobody has to hand a callback down to it. In workers nobody watches.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

Watcher = Callable[[str, float], None]

_WATCHER: ContextVar[Watcher | None] = ContextVar("who watches long work", default=None)


def report_share(what: str, share: float) -> None:
    """Tell that a share of some work is done, 0..1; at 1 it has ended. `what`: the work, in words."""
    if watcher := _WATCHER.get():
        watcher(what, share)


LARGE = 10**6
"""Corners or lines of a mesh from which on its steps are shown: they take about a second."""


@contextmanager
def watched(watcher: Watcher) -> Iterator[None]:
    """Let work inside report its progress to a watcher."""
    token = _WATCHER.set(watcher)
    try:
        yield
    finally:
        _WATCHER.reset(token)
