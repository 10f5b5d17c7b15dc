"""The smallest case that still fails alike: files, arguments, lines and bytes are left out as long as it does."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

from tests.fuzz.case import Case

TRIALS = 300
"""Of smaller cases at most."""


def minimised(case: Case, fails: Callable[[Case], bool]) -> Case:
    """A case as small as possible for which `fails` holds, as it does for the given one."""
    left = TRIALS
    found = True
    while found and left > 0:
        found = False
        for smaller in _smaller(case):
            left -= 1
            if fails(smaller):
                case, found = smaller, True
                break
            if left <= 0:
                break
    return case


def _smaller(case: Case) -> Iterator[Case]:
    for name in case.files:
        yield replace(case, files={other: content for other, content in case.files.items() if other != name})
    for number in range(1, len(case.argv)):
        yield replace(case, argv=case.argv[:number] + case.argv[number + 1 :])
    for name, content in case.files.items():
        if isinstance(content, bytes):
            for less in _less(content):
                yield replace(case, files={**case.files, name: less})


def _less(content: bytes) -> Iterator[bytes]:
    """With a half, a quarter, ... left out."""
    size = len(content)
    part = size // 2
    while part >= max(1, size // 16):
        for start in range(0, size, part):
            yield content[:start] + content[start + part :]
        part //= 2
