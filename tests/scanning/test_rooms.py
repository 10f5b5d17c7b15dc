"""Fields in rooms: clouds that MuJoCo's rays bring of walls, furniture and people too."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

import rsegen
from benchmarks.rooms import FIELDS, ON_TABLE, field_in, room, visit
from rsegen.cli.edge import main
from rsegen.errors import ScanError
from rsegen.field.stepfield import Array
from rsegen.scanning.finding import find_field
from rsegen.scanning.scan import SURE
from rsegen.scanning.scans import ScannedMap
from tests.scanning.test_find_field import cloud_of, field_of, right_turn
from tests.support.long import long_unless

pytest.importorskip("mujoco", reason="MuJoCo is not installed")

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def cubes() -> tuple[rsegen.Recipe, Array]:
    """A field and the cloud of a room in which nothing is found as a whole."""
    cloud = room(1, "cubes")
    with pytest.raises(ScanError, match="no grid of blocks fits the cloud"):
        find_field(cloud)
    return field_in(1, "cubes"), cloud


@pytest.fixture(scope="module")
def scanned(cubes: tuple[rsegen.Recipe, Array]) -> ScannedMap:
    """The field that is found in it."""
    return rsegen.scan(cubes[1])


@pytest.mark.parametrize("kind", long_unless({"cubes", ON_TABLE}.__contains__, FIELDS, reason="other fields"))
@pytest.mark.parametrize("seed", long_unless((1).__eq__, [1, 2, 3, 4], reason="other rooms"))
def test_a_field_in_a_room_is_found(kind: str, seed: int) -> None:
    found = visit(seed, kind)
    assert found.found
    assert found.seen > 0.5 * found.cells
    assert found.wrong == 0


@pytest.mark.parametrize("seed", long_unless((1).__eq__, range(1, 9), reason="other rooms"))
def test_in_a_room_without_a_field_none_is_found(seed: int) -> None:
    assert not visit(seed, "").found


def test_points_of_other_things_are_left_out_and_counted(
    cubes: tuple[rsegen.Recipe, Array],
    scanned: ScannedMap,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    _, cloud = cubes
    assert len(scanned.points) + scanned.left_out == len(cloud)
    assert scanned.left_out > 0.2 * len(cloud)
    near = scanned.scan.placed(scanned.points)
    assert np.abs(near[:, :2]).max() < 2.5  # of a cloud that is 6 m wide and more
    np.save(tmp_path / "room.npy", cloud)
    assert main(["scan", str(tmp_path / "room.npy"), "-o", str(tmp_path / "worlds")]) == 0
    assert f"left out: {scanned.left_out:,} of {len(cloud):,} points" in capsys.readouterr().out
    np.save(tmp_path / "thin.npy", cloud[::4])
    assert main(["scan", str(tmp_path / "thin.npy"), "-o", str(tmp_path / "thin"), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)["scan"]
    assert said["points"] + said["points_left_out"] == len(cloud[::4])
    assert said["points_left_out"] == pytest.approx(scanned.left_out / 4, rel=0.1)


def test_a_map_is_compared_with_a_field_in_a_room(cubes: tuple[rsegen.Recipe, Array]) -> None:
    recipe, cloud = cubes
    compared = rsegen.compare(cloud, recipe)
    assert compared.scan is not None
    assert (compared.scan.confidence > SURE).mean() > 0.5
    assert not compared.comparison.wrong.any()


def test_far_outliers_and_points_that_are_no_numbers_change_nothing(
    cubes: tuple[rsegen.Recipe, Array], scanned: ScannedMap
) -> None:
    _, cloud = cubes
    others = np.array([[np.nan, 0, 0], [1e6, 0, 0], [0, -1e6, 3]])
    scan = rsegen.scan(np.concatenate([others, cloud])).scan
    assert np.array_equal(scan.levels, scanned.scan.levels)


@pytest.mark.parametrize("seed", [1, 2])
def test_a_carton_next_to_a_field_does_not_change_its_unit(seed: int) -> None:
    field = field_of(seed, boundary="none")
    heights = np.zeros((18, 10))
    heights[:10] = field.heights
    heights[13:17, 3:8] = 0.33
    both = rsegen.StepField(
        levels=np.rint(heights * 1000).astype(np.int16),
        frame=np.zeros(heights.shape, bool),
        block_width=0.1,
        unit=0.001,
        frame_height=0,
    )
    cloud = cloud_of(both)
    assert abs(find_field(cloud).measured_unit / field.unit - 1) > 0.004
    scanned = rsegen.scan(cloud)
    assert scanned.scan.measured_unit == pytest.approx(field.unit, rel=0.002)
    assert 0.03 < scanned.left_out / len(cloud) < 0.6
    assert scanned.scan.whole is None
    right_turn(scanned.scan, field)


def _plane(rng: np.random.Generator, half: float, hole: float, height: float, points: int) -> Array:
    """Points of a level square with a square hole, both about the origin: halves of their sides, and its height [m]."""
    places = rng.uniform(-half, half, (points, 2))
    places = places[np.abs(places).max(axis=1) > hole]
    return np.column_stack([places, height + rng.normal(0, 0.004, len(places))])


@pytest.mark.parametrize(
    "planes",
    [[(8, 1, 0, 150_000)], [(2.2, 1, 0, 50_000), (2.2, 0, 2.5, 50_000)], [(1.9, 0.95, -0.14, 30_000)]],
    ids=["the only thing on a wide floor", "below a ceiling", "on a low stage"],
)
def test_a_field_is_found_among_planes(planes: Sequence[tuple[float, float, float, int]]) -> None:
    field, rng = field_of(4), np.random.default_rng(4)
    near = cloud_of(field)
    near = near[np.abs(near[:, :2]).max(axis=1) < max(hole for _, hole, _, _ in planes)]
    scan = rsegen.scan(np.concatenate([near, *(_plane(rng, *each) for each in planes)])).scan
    right_turn(scan, field)
    assert scan.seen.mean() > 0.8
