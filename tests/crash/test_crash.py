"""The trials of `make crash`, which makes more of them."""

from __future__ import annotations

import os
import random

import pytest

from tests.crash.injection import missing
from tests.crash.running import numbers, run

FEW, ALL = 20, 80
"""Trials of `make test`, and those of which `make test-all` has every other one."""


@pytest.mark.slow
@pytest.mark.skipif(bool(missing()), reason=missing() or "nothing is missing")
@pytest.mark.parametrize(
    "those",
    [slice(FEW), pytest.param(slice(FEW, ALL, 2), marks=pytest.mark.long(reason="half a minute"))],
    ids=str,
)
def test_a_run_that_is_disturbed_at_any_call_leaves_the_old_or_the_new(those: slice) -> None:
    seed = 7 if os.environ.get("CI") == "true" else random.SystemRandom().randrange(10**6)
    found = run(seed, numbers(ALL)[those], min(2, os.cpu_count() or 1), lambda done, new: None)
    assert [str(problem) for problem in found] == [], f"seed {seed}"
