"""Obstacles beyond rows at level 0, and cartons in rooms: no part of a field, and no box, is taken for a field."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import rsegen
from rsegen.cli.edge import main
from rsegen.errors import ScanError
from rsegen.field.stepfield import Array, Ints, StepField
from rsegen.params.sorts import Cell
from rsegen.scanning.extent import extent_of
from rsegen.scanning.levels import Reading
from rsegen.scanning.scan import Scan
from tests.support.long import long_unless


def apart(first: Ints, rows: int, second: Ints) -> StepField:
    """Two obstacles with rows at level 0 between them, blocks of 10 cm."""
    levels = np.concatenate([first, np.zeros((rows, first.shape[1]), int), second]).astype(np.int16)
    return StepField(levels=levels, frame=np.zeros(levels.shape, bool), block_width=0.1, unit=0.1, frame_height=0.0)


def two_of_random_blocks() -> StepField:
    rng = np.random.default_rng(33)
    return apart(rng.integers(0, 4, (6, 10)), 2, rng.integers(1, 4, (5, 10)))


def pyramid_and_random_blocks() -> StepField:
    """Steps of the pyramid are two blocks wide, so that only the other obstacle shows the blocks."""
    half = np.minimum(np.arange(8), np.arange(8)[::-1])
    return apart(np.minimum.outer(half, half) // 2 + 1, 2, np.random.default_rng(3).integers(0, 2, (3, 8)))


def from_above(field: StepField, noise: float = 0.004) -> Array:
    """Points all over a field and half a metre of floor, turned about the vertical."""
    rng = np.random.default_rng(5)
    half = np.array(field.shape) / 2 * field.block_width
    places = rng.uniform(-half - 0.5, half + 0.5, (60_000, 2))
    heights = np.pad(field.heights, 6)
    i, j = (np.floor((places + half) / field.block_width).astype(int) + 6).clip(0, np.array(heights.shape) - 1).T
    z = heights[i, j] + rng.normal(0, noise, len(places))
    return np.column_stack([places @ np.array([[0.8, 0.6], [-0.6, 0.8]]), z])


def beside(points: Array, low: tuple[float, ...], high: tuple[float, ...]) -> Array:
    """The points with those of a box's surface instead of the floor that it stands on, all within these corners [m]."""
    is_covered = ((points[:, :2] > low[:2]) & (points[:, :2] < high[:2])).all(axis=1)
    return np.concatenate([points[~is_covered], np.random.default_rng(6).uniform(low, high, (4_000, 3))])


def as_found(scan: Scan, field: StepField) -> bool:
    """Return whether all blocks that were seen are right, nearly all of the field."""
    turned = [np.rot90(scan.levels, turns) for turns in range(4)]
    return scan.seen.mean() > 0.95 and any(
        levels.shape == field.shape and bool((levels == field.levels)[levels >= 0].all()) for levels in turned
    )


def test_obstacles_beyond_rows_at_level_0_are_warned_of_and_found_by_the_size(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    field = two_of_random_blocks()
    np.save(tmp_path / "field.npy", from_above(field))
    arguments = ["scan", str(tmp_path / "field.npy"), "-o", str(tmp_path / "worlds"), "--force"]
    assert main(arguments) == 0
    said = capsys.readouterr().out
    near = np.count_nonzero(field.levels[2:6])  # six rows around the larger obstacle, of which two are at level 0
    assert f"warning: {near} cells near the field are as high as blocks" in said
    assert main([*arguments, "--size", "13x10"]) == 0
    assert "near the field are as high" not in capsys.readouterr().out
    assert as_found(rsegen.scan(from_above(field), rsegen.ScanOptions(size=(13, 10))).scan, field)


def test_a_part_is_refused_if_the_field_in_all_of_the_cloud_is() -> None:
    field = pyramid_and_random_blocks()
    with pytest.raises(ScanError, match=r"may be a part of the field: \d+ cells near them are as high as blocks"):
        rsegen.scan(from_above(field))
    assert as_found(rsegen.scan(from_above(field), rsegen.ScanOptions(size=(13, 8))).scan, field)


def test_walls_near_a_field_are_no_part_of_it() -> None:
    rng = np.random.default_rng(8)
    cloud = from_above(apart(rng.integers(0, 4, (5, 10)), 0, rng.integers(1, 4, (5, 10))))
    assert rsegen.scan(cloud).scan.beside == 0
    walled = beside(cloud, (-2, 0.95, 0), (2, 1.05, 2.5))
    assert rsegen.scan(walled).scan.beside == 0
    boxed = beside(cloud, (-0.2, 0.93, 0.2), (0.2, 1.2, 0.2))
    assert 4 <= rsegen.scan(boxed).scan.beside <= 15  # of 10.8 cells


def room_with_cartons() -> Array:
    """Floor, two walls, a desk and a carton."""
    rng = np.random.default_rng(9)
    cloud = np.column_stack([rng.uniform(-2, 2, (60_000, 2)), np.zeros(60_000)])
    for low, high in (
        ((0.9, 0.2, 0.3), (1.3, 0.5, 0.3)),
        ((-1.6, -0.2, 0.7), (-1.0, 0.6, 0.7)),
        ((-2.0, 1.95, 0.0), (2.0, 2.0, 2.5)),
        ((1.95, -2.0, 0.0), (2.0, 2.0, 2.5)),
    ):
        cloud = beside(cloud, low, high)
    return cloud + rng.normal(0, 0.004, cloud.shape)


@pytest.mark.parametrize(
    "known", long_unless("size".__eq__, ["size", "block_width_cm"], reason="a known size is in make test")
)
def test_a_carton_in_a_room_is_no_field_if_only_its_blocks_are_known(known: str) -> None:
    options = {"size": rsegen.ScanOptions(size=(10, 10)), "block_width_cm": rsegen.ScanOptions(block_width_cm=10)}
    with pytest.raises(ScanError):
        rsegen.scan(room_with_cartons(), options[known])


@pytest.mark.parametrize(("raised", "rows"), [((9, 8), [1]), ((8, 7), [1, 2])])
def test_a_field_of_a_given_size_is_around_the_middle_of_what_is_raised(raised: Cell, rows: list[int]) -> None:
    """Along x, in which there are several such places, and along y."""
    heights = np.pad(np.full(raised, 0.1), 5)
    ones = np.ones(heights.shape, int)
    reading = Reading(heights=heights, counts=ones, slopes=0.0 * ones, strays=0.0 * ones, spread=0.01, first=(0, 0))
    corner, shape = extent_of(reading, 0.1, (10, 10))
    assert shape == (10, 10)
    assert 5 - corner[1] in rows


def test_a_scan_says_that_the_place_of_a_given_size_is_assumed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Stairs whose first step is at level 0 have it on either side: what is raised is in the middle."""
    stairs = np.repeat(np.arange(10)[:, None], 10, axis=1) // 2
    np.save(tmp_path / "stairs.npy", from_above(apart(stairs[:9], 0, stairs[9:])))
    for size, said in (("10x10", "rows at level 0 look like floor, here at "), ("8x10", "")):
        main(
            ["scan", str(tmp_path / "stairs.npy"), "-o", str(tmp_path / size), "--size", size, "--block-width-cm", "10"]
        )
        lines = [line for line in "".join(capsys.readouterr()).splitlines() if "in the middle of the field" in line]
        assert len(lines) == bool(said)
        assert all(said in line for line in lines)
