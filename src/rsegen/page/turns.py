"""Turns of what takes seconds: one at a time of each sort for a document, and of those that wait the newest alone."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from rsegen.errors import UserError


@dataclass(slots=True)
class _Queue:
    """The number of the newest request, and the lock of the one that is worked on."""

    asked: int = 0
    works: threading.Lock = field(default_factory=threading.Lock)


_QUEUES: dict[tuple[str, str], _Queue] = {}
_LOCK = threading.Lock()


@contextmanager
def newest_turn(doc: str, name: str) -> Iterator[Callable[[], None]]:
    """Wait until nothing of this name is done for a document; a UserError for a request that a newer one replaced.

    Yields a function that raises it too, for what takes seconds to call now and then.
    """
    queue, number = _ask(doc, name)

    def check() -> None:
        if queue.asked != number:
            raise UserError("a newer request took its place, or it was stopped")

    with queue.works:
        check()
        yield check


def stop(doc: str, name: str | None = None) -> None:
    """Stop what is done, or waits, of a name for a document; without a name, everything."""
    for of, which in [*_QUEUES]:
        if of == doc and name in (None, which):
            _ask(of, which)


def _ask(doc: str, name: str) -> tuple[_Queue, int]:
    with _LOCK:
        queue = _QUEUES.setdefault((doc, name), _Queue())
        queue.asked += 1
        return queue, queue.asked
