"""The last messages of each topic, which a thread receives and others wait for.

One condition guards everything that a transport client learns, messages and connections: whoever waits is woken by each
change and looks again. Cost: a wake per message, fine for hundreds per second and a few who wait.
"""

from __future__ import annotations

import threading
from collections import defaultdict, deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from functools import cache, partial
from itertools import islice
from typing import Any

from rsegen.errors import NoMessage, SimulatorFailed
from rsegen.simulators.patience import Patience

_KEPT = 64
"""Messages of a topic that are kept: a second of Gazebo's poses, so that none that is waited for is pushed out."""

_LOOK = 0.1
"""Seconds between two looks whether patience is over: each reads a file."""


class Inbox:
    """Messages by topic, the base of a client of a simulator; `title`: of the simulator, for errors."""

    def __init__(self, title: str, patience: Patience) -> None:
        self.patience = patience
        self.title = title
        self._types: dict[str, str] = {}
        self._takers: dict[str, Callable[[dict[str, Any]], None]] = {}
        self._failure = ""
        self._changed = threading.Condition()
        self._messages: dict[str, deque[Callable[[], dict[str, Any] | None]]] = defaultdict(lambda: deque(maxlen=_KEPT))

    def full_name(self, topic: str) -> str:
        """Return the name under which the messages of a topic are sent."""
        return topic

    def subscribe(self, topic: str, type_name: str, on_message: Callable[[dict[str, Any]], None] | None = None) -> None:
        """Subscribe to a topic, if it is not subscribed yet; `on_message` takes its messages, else they are kept."""
        full = self.full_name(topic)
        if full not in self._types:
            self._types[full] = type_name
            if on_message:
                self._takers[full] = on_message
            self._subscribe(full)

    def _subscribe(self, full: str) -> None:
        """Have the messages of a topic of this full name sent."""

    def add(self, full: str, decode: Callable[[], dict[str, Any]]) -> None:
        """Hand on a message of a topic of this full name if somebody takes them, else keep it.

        What is kept is decoded when somebody looks at it.
        """
        if taker := self._takers.get(full):
            with suppress(NoMessage):
                taker(decode())
        else:
            self.update(lambda: self._messages[full].append(cache(partial(_decoded, decode))))

    def clear(self, topic: str) -> None:
        """Delete the messages of a topic that were received until now."""
        self.update(self._messages[self.full_name(topic)].clear)

    def update(self, change: Callable[[], object]) -> None:
        """Change what others may wait for."""
        with self._changed:
            change()
            self._changed.notify_all()

    def fail(self, why: str) -> None:
        """End all waiting, now and later, with a SimulatorFailed."""
        self.update(lambda: setattr(self, "_failure", why))

    @property
    def is_connected(self) -> bool:
        """Return whether the server still answers."""
        return not self._failure

    def wait(self, why: str, until: Callable[[], bool], patience: Patience | None = None) -> None:
        """Wait until something holds that messages change; SimulatorFailed with the reason when patience is over."""
        patience = patience or self.patience
        wait = patience.begin()
        with self._changed:
            while not (self._failure or until()):
                if wait.is_over:
                    raise SimulatorFailed(f"{self.title}: {why} within {patience}")
                self._changed.wait(min(_LOOK, patience.seconds))
            if self._failure:
                raise SimulatorFailed(f"{self.title}: {self._failure}")

    def messages(self, topic: str) -> list[dict[str, Any]]:
        """Return the messages of a topic that are kept, the oldest first."""
        with self._changed:
            return list(self._newest_first(self.full_name(topic)))[::-1]

    def last(self, topic: str) -> dict[str, Any] | None:
        """Return the last message of a topic; None if none has come yet."""
        with self._changed:
            return next(self._newest_first(self.full_name(topic)), None)

    def wait_for_message(
        self, topic: str, wanted: Callable[[Mapping[str, Any]], bool] = lambda _: True
    ) -> dict[str, Any]:
        """Return the last message of a topic that `wanted` accepts; waits for one if none has come yet."""
        full = self.full_name(topic)
        accepted: list[dict[str, Any]] = []

        def has_come() -> bool:
            accepted.extend(islice(filter(wanted, self._newest_first(full)), 1))
            return bool(accepted)

        self.wait(f"no message on {full}", has_come)
        return accepted[0]

    def wait_until(self, topic: str, count: Callable[[Mapping[str, Any]], int], target: int) -> dict[str, Any]:
        """Return a message of a topic whose count has reached a target, if it grows within patience each time."""
        reached = -1  # each larger count is progress, and begins the wait anew
        while True:
            message = self.wait_for_message(topic, lambda message: count(message) > reached)
            if (reached := count(message)) >= target:
                return message

    def _newest_first(self, full: str) -> Iterator[dict[str, Any]]:
        """Yield the messages of a topic, which are decoded as far as they are taken."""
        for decoded in reversed(self._messages[full]):
            if (message := decoded()) is not None:
                yield message


def _decoded(decode: Callable[[], dict[str, Any]]) -> dict[str, Any] | None:
    """Return a message; None if it is none of its type, as what others send may be anything."""
    with suppress(NoMessage):
        return decode()
    return None
