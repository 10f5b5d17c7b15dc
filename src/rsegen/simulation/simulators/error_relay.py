"""Error lines that are passed on once each: an old Gazebo Sim prints some at every step."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable

_NUMBER = re.compile(r"(?<!\w)[-+]?\d[\d.:]*(?:e[-+]?\d+)?(?!\w)")
"""A number that stands alone, as an id or a time does; those in names such as rse_0001.obj do not."""


class ErrorRelay:
    """Passes on the first of all error lines that differ in numbers alone, and counts them."""

    def __init__(self, on_error: Callable[[str], None]) -> None:
        self._on_error = on_error
        self._first: dict[str, str] = {}
        self._counts: Counter[str] = Counter()

    @property
    def first(self) -> str | None:
        """The first line that was passed on."""
        return next(iter(self._first.values()), None)

    @property
    def lines(self) -> tuple[str, ...]:
        """Every line that was passed on, with the count of its like if there are several."""
        return tuple(_with_count(line, self._counts[kind]) for kind, line in self._first.items())

    def add(self, line: str) -> None:
        """Count a line, and pass it on if it is the first of its kind."""
        kind = _NUMBER.sub("#", line)
        self._counts[kind] += 1
        if kind not in self._first:
            self._first[kind] = line
            self._on_error(line)

    def finish(self) -> None:
        """Pass on every line that has come more than once again, with its count."""
        for kind, line in self._first.items():
            if self._counts[kind] > 1:
                self._on_error(_with_count(line, self._counts[kind]))


def counted(lines: Iterable[str]) -> tuple[str, ...]:
    """The first of all lines that differ in numbers alone, each with the count of its like if there are several."""
    relay = ErrorRelay(lambda _: None)
    for line in lines:
        relay.add(line)
    return relay.lines


def _with_count(line: str, count: int) -> str:
    return f"{line} ({count} times)" if count > 1 else line
