"""Cases of a test of which `make test` runs a few, and `make test-all` all."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, TypeVar

import pytest

Case = TypeVar("Case")


def long_unless(is_short: Callable[[Case], bool], cases: Iterable[Case], *, reason: str) -> list[Any]:
    """Return all cases as `parametrize` takes them; those that are not short are marked long, for a reason.

    A case of several arguments is a tuple.
    """
    long = pytest.mark.long(reason=reason)

    def marked(case: Case) -> Any:
        return pytest.param(*(case if isinstance(case, tuple) else (case,)), marks=long)

    return [case if is_short(case) else marked(case) for case in cases]
