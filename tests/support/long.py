"""Cases of a test of which `make test` runs a few, and `make test-all` all."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, TypeVar

import pytest

Case = TypeVar("Case")


def long_unless(is_short: Callable[[Case], bool], cases: Iterable[Case], *, reason: str) -> list[Any]:
    """Return all cases as `parametrize` takes them; those that are not short are marked long, for a reason."""
    long = pytest.mark.long(reason=reason)
    return [case if is_short(case) else pytest.param(case, marks=long) for case in cases]
