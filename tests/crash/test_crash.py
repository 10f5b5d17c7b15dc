"""The trials of `make crash`, which makes more of them."""

from __future__ import annotations

import os
import random

import pytest

from rsegen.writing import swap
from tests.crash.commands import TURNS
from tests.crash.disks import DISKS, Disk, NotMounted
from tests.crash.injection import missing
from tests.crash.running import OWN, OWN_ASIDE, numbers, run
from tests.support.long import long_unless

FEW = 30
"""Trials on this machine's own disk, which have each command that is not rare; the other disks share so many."""


@pytest.mark.slow
@pytest.mark.skipif(bool(missing()), reason=missing() or "nothing is missing")
def test_a_run_that_is_disturbed_at_any_call_leaves_the_old_or_the_new() -> None:
    assert {TURNS[number].name for number in numbers(FEW)} == {run.name for run in TURNS if not run.rare}
    seed = 7 if os.environ.get("CI") == "true" else random.SystemRandom().randrange(10**6)
    tried = run(seed, numbers(FEW), 1, lambda done, new: None)
    assert {each.disk for each in tried} == {OWN, OWN_ASIDE}
    assert [str(problem) for each in tried for problem in each.problems] == [], f"seed {seed}"


@pytest.mark.slow
@pytest.mark.skipif(bool(missing()), reason=missing() or "nothing is missing")
@pytest.mark.parametrize(
    "disk",
    long_unless(lambda disk: disk.name == "FUSE (bindfs)", DISKS, reason="another disk"),
    ids=lambda disk: disk.name,
)
def test_a_run_that_is_disturbed_on_another_disk_leaves_the_old_or_the_new(disk: Disk) -> None:
    seed = 7 if os.environ.get("CI") == "true" else random.SystemRandom().randrange(10**6)
    try:
        those = numbers(FEW)[DISKS.index(disk) :: len(DISKS)]
        tried = run(seed, those, 1, lambda done, new: None, disk)
    except NotMounted as error:
        pytest.skip(f"{disk.name}: {error}")
    assert len(tried) == len(those) == 6
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
