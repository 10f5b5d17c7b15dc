"""The trials of `make crash`, which makes more of them."""

from __future__ import annotations

import os
import random

import pytest

from rsegen.writing import swap
from tests.crash.disks import DISKS, Disk, NotMounted
from tests.crash.injection import missing
from tests.crash.running import OWN, OWN_ASIDE, numbers, run

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
    tried = run(seed, numbers(ALL)[those], min(2, os.cpu_count() or 1), lambda done, new: None)
    assert {each.disk for each in tried} == {OWN, OWN_ASIDE}
    assert [str(problem) for each in tried for problem in each.problems] == [], f"seed {seed}"


@pytest.mark.slow
@pytest.mark.skipif(bool(missing()), reason=missing() or "nothing is missing")
@pytest.mark.parametrize("disk", DISKS, ids=lambda disk: disk.name)
def test_a_run_that_is_disturbed_on_another_disk_leaves_the_old_or_the_new(disk: Disk) -> None:
    seed = 7 if os.environ.get("CI") == "true" else random.SystemRandom().randrange(10**6)
    try:
        tried = run(seed, numbers(FEW), 1, lambda done, new: None, disk)
    except NotMounted as error:
        pytest.skip(f"{disk.name}: {error}")
    assert len(tried) == FEW
    assert [str(problem) for each in tried for problem in each.problems] == [], f"seed {seed}"


@pytest.mark.parametrize("disk", DISKS, ids=lambda disk: disk.name)
def test_a_disk_exchanges_two_names_as_it_says(disk: Disk) -> None:
    try:
        with disk.mounted() as folder:
            for name in ("a", "b"):
                (folder / name).mkdir()
            assert swap._renamed(folder / "a", folder / "b", swap._EXCHANGE) == disk.exchanges
    except NotMounted as error:
        pytest.skip(f"{disk.name}: {error}")
