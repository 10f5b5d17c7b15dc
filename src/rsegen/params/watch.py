"""Tell whoever watches how far a long search is: a bar of the command line, for every command that makes a map.

A search deep in the core tells its share; nobody has to hand a callback down to it. In workers nobody watches.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

Watcher = Callable[[str, float], None]

_WATCHER: ContextVar[Watcher | None] = ContextVar("who watches a search", default=None)


def tell(what: str, share: float) -> None:
    """Tell that a share of a search is done, 0..1; at 1 it has ended. `what`: the search, in words."""
    if watcher := _WATCHER.get():
        watcher(what, share)


@contextmanager
def watched(watcher: Watcher) -> Iterator[None]:
    """Let searches inside tell a watcher how far they are."""
    token = _WATCHER.set(watcher)
    try:
        yield
    finally:
        _WATCHER.reset(token)
