"""A few kills of `make crash`, which makes hundreds."""

from __future__ import annotations

import random
import time
from pathlib import Path

import pytest

from tests.crash.commands import RUNS, Run
from tests.crash.trials import can_mount, killed, on_a_full_disk

SAMPLE = [run for run in RUNS if run.name in ("generate --force", "export to worlds", "dataset")]


@pytest.mark.slow
@pytest.mark.parametrize("run", SAMPLE, ids=lambda run: run.name)
def test_a_run_that_is_killed_goes_on_and_loses_nothing(tmp_path: Path, run: Run) -> None:
    start = time.monotonic()
    whole = run.whole(tmp_path / "whole")
    seconds = time.monotonic() - start
    rng = random.Random(run.name)  # noqa: S311  # a moment, not a secret
    assert killed(run, tmp_path / "out", whole, seconds, rng) == []


@pytest.mark.slow
def test_a_run_on_a_full_disk_goes_on_and_loses_nothing(tmp_path: Path) -> None:
    if not can_mount(tmp_path / "disk"):
        pytest.skip("this user may not mount a disk in memory")
    run, rng = RUNS[0], random.Random(7)  # noqa: S311  # a size, not a secret
    assert on_a_full_disk(run, tmp_path / "disk", run.whole(tmp_path / "whole"), rng) == []
