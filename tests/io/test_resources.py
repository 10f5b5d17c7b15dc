"""What a run needs, in numbers that a person can read."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rsegen import Placement, Random, Recipe
from rsegen.errors import TooLarge
from rsegen.io import resources
from rsegen.io.importers import imported, importer_for
from rsegen.io.resources import check_needs, format_bytes


@pytest.mark.parametrize(
    ("size", "text"),
    [
        (0, "0 bytes"),
        (999, "999 bytes"),
        (1000, "1.0 kB"),
        (200_000, "200.0 kB"),
        (1_300_000, "1.3 MB"),
        (23_500_000_000, "23.5 GB"),
        (150_000_000_000_000, "150.0 TB"),
        (10**15, "a million GB or more"),
        (10**400, "a million GB or more"),
        (math.inf, "a million GB or more"),
    ],
)
def test_bytes_are_in_the_unit_that_fits(size: float, text: str) -> None:
    assert format_bytes(size) == text


def test_a_disk_that_is_too_small_is_refused_in_the_unit_that_fits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(resources, "_free_disk", lambda _: 200_000)
    with pytest.raises(TooLarge, match=r"maps: 106 maps need 1\.3 MB of disk or more, 200\.0 kB are free; give fewer"):
        check_needs([Recipe(seed=1)], 106, tmp_path)


def test_more_obstacles_than_a_large_map_can_take_are_refused_before_the_work() -> None:
    rows = (Placement(obstacle=Random(max_height=5)),) * 20_001
    recipe = Recipe(seed=1, chunk_size=1000, boundary="none", obstacles=rows)
    with pytest.raises(TooLarge, match=r"obstacles: 20,001 of them on .* cells .* give 20,000 or fewer"):
        resources.refuse_too_large(recipe)
    resources.refuse_too_large(replace(recipe, obstacles=rows[:-1]))


def test_heights_that_do_not_fit_into_memory_are_refused_before_they_are_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    np.save(tmp_path / "heights.npy", np.zeros((100, 200)))
    monkeypatch.setattr(resources, "_free_memory", lambda: 1_000_000)
    with pytest.raises(TooLarge, match=r"100 x 200 cells need about 1\.2 MB of memory, 1\.0 MB are free$"):
        imported(tmp_path / "heights.npy", importer_for(tmp_path / "heights.npy")())
