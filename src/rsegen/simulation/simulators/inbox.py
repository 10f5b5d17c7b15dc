"""The last messages of each topic, which a thread receives and others wait for.

One condition guards everything that a transport client learns, messages and connections: whoever waits is woken by each
change and looks again. Cost: a wake per message, fine for hundreds per second and a few who wait.
"""

from __future__ import annotations

import threading
from collections import defaultdict, deque
from collections.abc import Callable, Mapping
from typing import Any

from rsegen.errors import SimulatorFailed

_KEPT = 64
"""Messages of a topic that are kept: a second of Gazebo's poses, so that none that is waited for is pushed out."""


class Inbox:
    """Messages by topic; `title`: of the simulator, for errors."""

    def __init__(self, title: str) -> None:
        self._title = title
        self._failure = ""
        self._changed = threading.Condition()
        self._messages: dict[str, deque[dict[str, Any]]] = defaultdict(lambda: deque(maxlen=_KEPT))

    def add(self, topic: str, message: dict[str, Any]) -> None:
        """Keep a message."""
        self.update(lambda: self._messages[topic].append(message))

    def clear(self, topic: str) -> None:
        """Delete the messages of a topic that were received until now."""
        self.update(self._messages[topic].clear)

    def update(self, change: Callable[[], object]) -> None:
        """Change what others may wait for."""
        with self._changed:
            change()
            self._changed.notify_all()

    def fail(self, why: str) -> None:
        """End all waiting, now and later, with a SimulatorFailed."""
        self.update(lambda: setattr(self, "_failure", why))

    def wait(self, why: str, until: Callable[[], bool], timeout: float) -> None:
        """Wait until a condition holds; SimulatorFailed with the reason after `timeout` seconds."""
        with self._changed:
            has_come = self._changed.wait_for(lambda: bool(self._failure) or until(), timeout)
            if self._failure or not has_come:
                raise SimulatorFailed(f"{self._title}: {self._failure or why}")

    def last(self, topic: str) -> dict[str, Any] | None:
        """Return the last message of a topic; None if there is none yet."""
        with self._changed:
            return next(reversed(self._messages[topic]), None)

    def wait_for_message(
        self, topic: str, wanted: Callable[[Mapping[str, Any]], bool], timeout: float
    ) -> dict[str, Any]:
        """Return the last message of a topic that `wanted` accepts; waits for one if there is none yet."""
        self.wait(f"no message on {topic}", lambda: any(map(wanted, self._messages[topic])), timeout)
        with self._changed:
            return [message for message in self._messages[topic] if wanted(message)][-1]
