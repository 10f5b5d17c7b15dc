"""Fields found in clouds of a ray caster: the levels, the frames and the place, whatever the cloud's own frame is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rsegen
from benchmarks.depth_camera import DepthCamera, Flaws, scanned, turned
from rsegen import Matrix, Random, Recipe, Stairs, StepField, Stones
from rsegen.cli.edge import main
from rsegen.errors import ScanError
from rsegen.field.stepfield import Array, Ints
from rsegen.scanning import finding
from rsegen.scanning.finding import find_field
from rsegen.scanning.grid import CloudGrid, _Tops, find_grid
from rsegen.scanning.levels import _agreement, _raised, find_unit, read_cells
from rsegen.scanning.scan import SURE, Scan, ScanSettings
from tests.support.long import long_unless

KINDS: Mapping[str, Mapping[str, Any]] = {
    "cubes in a frame": {"boundary": "outer"},
    "half-cubes": {"boundary": "none", "unit_cm": 5, "chunks": (1, 2), "chunk_size": 6},
    "pallets of 3.5 inches": {
        "boundary": "divided",
        "chunks": (2, 1),
        "chunk_size": 6,
        "unit_cm": 8.89,
        "block_width_cm": 8.89,
        "frame_height_cm": 8.89,
    },
}
VIEW = DepthCamera(place=(0.6, 0.2, 2.2), columns=160, rows=120, focal=140)
"""A coarse one: most of the time of these tests is finding, which takes as long as it has points."""
TWO_VIEWS = (VIEW, replace(VIEW, place=(-0.5, -0.4, 2.2)))
FINER_VIEWS = tuple(replace(view, columns=192, rows=144, focal=168) for view in TWO_VIEWS)


def field_of(seed: int = 1, **values: Any) -> StepField:
    recipe = Recipe(seed=seed, obstacles=(Random(levels=5),), **values)
    return rsegen.build(recipe, 0)


USUAL = Flaws(noise=0.005, missing=0.2, outliers=0.02)


def cloud_of(field: StepField, seed: int = 1, flaws: Flaws = USUAL, views: Sequence[DepthCamera] = TWO_VIEWS) -> Array:
    return scanned(field, views, flaws, np.random.default_rng(seed))


def right_turn(scan: Scan, field: StepField) -> int:
    """By how many quarter turns the scan has to be turned so that all cells that were seen are right."""
    for turns in range(4):
        levels, seen = np.rot90(scan.levels, turns), np.rot90(scan.seen, turns)
        if levels.shape == field.levels.shape and (levels == field.levels)[seen].all():
            return turns
    raise AssertionError(f"{scan.levels}\nis not\n{field.levels}")


@pytest.mark.slow
@pytest.mark.parametrize("seed", long_unless(lambda seed: seed == 0, range(2), reason="a cloud more per kind"))
@pytest.mark.parametrize("kind", KINDS)
def test_every_block_that_is_seen_is_right_at_any_heading_and_tilt(kind: str, seed: int) -> None:
    field = field_of(seed, **KINDS[kind])
    scan = find_field(turned(cloud_of(field, seed), np.random.default_rng(seed)))
    right_turn(scan, field)
    assert scan.seen.mean() > 0.85
    assert abs(scan.unit - field.unit) < 0.003
    assert abs(scan.block_width - field.block_width) < 0.002
    assert scan.boundary == KINDS[kind]["boundary"]
    assert scan.base == 0, "it is on no board"
    assert scan.open_sides == ()
    if scan.boundary != "none":
        assert abs(scan.frame_height - field.frame_height) < 0.003


@pytest.mark.slow
def test_a_known_field_is_laid_on_the_scan_as_it_stands() -> None:
    """Points of the cloud, however it was turned and moved, come back to where they are on the map."""
    field = field_of(4, boundary="outer")
    cloud = cloud_of(field, flaws=Flaws(noise=0.003))
    scan = find_field(turned(cloud, np.random.default_rng(7)), known=field)
    assert (scan.levels == field.levels)[scan.seen].all()
    assert np.array_equal(scan.frame, field.frame)
    placed = scan.placed(turned(cloud, np.random.default_rng(7)))
    assert np.abs(placed - cloud).max() < 0.03
    assert np.sqrt(((placed - cloud) ** 2).sum(axis=1).mean()) < 0.01


@pytest.mark.slow
def test_a_block_that_differs_from_the_known_field_is_seen() -> None:
    field = field_of(4, boundary="none")
    levels = field.levels.copy()
    levels[3, 4] = (levels[3, 4] + 2) % 5
    built = replace(field, levels=levels)
    scan = find_field(turned(cloud_of(built), np.random.default_rng(3)), known=field)
    assert (scan.levels == built.levels)[scan.seen].all()
    assert scan.seen[3, 4]


@pytest.mark.slow
def test_a_rim_at_ground_level_is_found_by_the_size() -> None:
    """Level ground beside a field looks like floor: only the number of blocks tells them apart."""
    levels = np.zeros((10, 10), dtype=np.int16)
    levels[2:8, 2:8] = field_of(2).blocks[:6, :6]
    levels[[2, 7], [3, 3]] = 3
    levels[[3, 3], [2, 7]] = 3
    field = rsegen.build(Recipe(seed=1, boundary="none", obstacles=(Matrix.of(levels),)), 0)
    cloud = cloud_of(field)
    assert max(find_field(cloud).levels.shape) <= 6
    scan = find_field(cloud, ScanSettings(blocks=(10, 10), boundary="none"))
    assert right_turn(scan, field) in range(4)


@pytest.mark.slow
def test_holes_in_a_deck_are_found_down_to_the_floor() -> None:
    stones = Stones(levels=5, stone_width=3, stone_distance=2, uneven=1, first=(1, 1), last=(10, 10))
    stairs = Stairs(levels=3, first=(4, 4), last=(9, 9))
    field = rsegen.build(Recipe(seed=2, chunk_size=12, boundary="none", ground_level=4, obstacles=(stones, stairs)), 0)
    # A rim one block wide looks like a frame, and few edges tell the width of a block.
    known = ScanSettings(boundary="none", block_width=0.1, unit=0.1)
    scan = find_field(turned(cloud_of(field), np.random.default_rng(5)), known)
    seen = np.rot90(scan.seen, right_turn(scan, field))
    assert seen.mean() > 0.9
    assert set(field.levels[seen].tolist()) == {0, 3, 4, 5, 6}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("boundary", "chunks", "side"),
    long_unless(lambda case: case[0] == "outer", [("outer", (1, 1), 10), ("divided", (2, 1), 6)], reason="more frames"),
)
def test_a_size_counts_the_blocks_and_not_their_frames(boundary: str, chunks: tuple[int, int], side: int) -> None:
    field = field_of(2, boundary=boundary, chunks=chunks, chunk_size=side)
    blocks = (chunks[0] * side, chunks[1] * side)
    cloud = cloud_of(field)
    quarter_turned = cloud[:, [1, 0, 2]] * (-1, 1, 1)
    for points in (cloud,) if chunks == (1, 1) else (cloud, quarter_turned):
        scan = find_field(points, ScanSettings(blocks=blocks))
        right_turn(scan, field)
        assert scan.boundary == boundary
        assert scan.blocks.shape == blocks


@pytest.mark.slow
def test_a_board_below_the_blocks_is_no_part_of_their_height() -> None:
    field = field_of(3, boundary="none")
    cloud = cloud_of(field)
    on_it = (np.abs(cloud[:, :2]) < np.array(field.extent) / 2 + 0.02).all(axis=1)
    cloud[on_it, 2] += 0.03
    right_turn(find_field(cloud, ScanSettings(base=0.03)), field)


@pytest.mark.slow
def test_the_camera_or_a_direction_says_where_up_is() -> None:
    """A cloud of blocks alone, cut out of its floor and upside down."""
    field = field_of(5, boundary="none")
    cloud = cloud_of(field)
    alone = cloud[(np.abs(cloud[:, :2]) < np.array(field.extent) / 2).all(axis=1)]
    upside_down = alone * (1, -1, -1)
    eye = ScanSettings(eye=(0.6, -0.2, -2.2))
    for settings in (eye, ScanSettings(up=(0, 0, -1))):
        right_turn(find_field(upside_down, settings), field)


def test_confidence_is_lower_where_points_are_few_and_far_from_a_level() -> None:
    from rsegen.scanning.levels import Reading

    heights = np.array([[0.1, 0.1, 0.149], [np.nan, 0.2, 0.1]])
    counts = np.array([[400, 5, 5], [0, 400, 400]])
    level = np.zeros((2, 3))
    reading = Reading(heights=heights, counts=counts, slopes=level, strays=level, spread=0.02, first=(0, 0))
    found = reading.confidence(0.1)
    sloping = replace(reading, slopes=np.full((2, 3), 0.04)).confidence(0.1)
    assert (sloping[reading.seen] < 0.9).all()
    assert found[1, 0] == 0
    assert found[0, 2] < 0.6 < found[0, 1]
    assert ((found >= 0) & (found <= 1)).all()
    assert reading.levels(0.1)[1, 0] == -1


def overhead(field: StepField) -> tuple[DepthCamera, ...]:
    """Two cameras over each third of a field, on opposite sides."""
    third = field.extent[0] / 3
    places = [(x, y) for x in (-third, 0.0, third) for y in (-0.7, 0.7)]
    return tuple(DepthCamera(place=(x, y, 2.2), target=(x, 0, 0), columns=400, rows=300, focal=330) for x, y in places)


@pytest.mark.slow
@pytest.mark.long(reason="a large scan")
def test_a_field_of_three_metres_is_found_from_six_views() -> None:
    """Edges are more in some parts of it, so that two metres were its strongest period."""
    field = field_of(301, boundary="none", chunks=(5, 2), chunk_size=6)
    rng = np.random.default_rng(301)
    cloud = scanned(field, overhead(field), Flaws(noise=0.01, missing=0.2, outliers=0.02), rng)
    scan = find_field(turned(cloud, rng, 0.5))
    right_turn(scan, field)
    assert scan.seen.mean() > 0.95


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", long_unless(lambda seed: seed == 1, range(1, 3), reason="a cloud more"))
def test_a_single_coarse_image_is_enough(kind: str, seed: int) -> None:
    """160 x 120 pixels, one per 14 mm: six points in a pixel of 47 mm, half of a block."""
    field = field_of(seed, **KINDS[kind])
    camera = DepthCamera(place=(0.5, 0.45, 2.2), columns=160, rows=120, focal=132)
    rng = np.random.default_rng(seed)
    scan = find_field(turned(scanned(field, [camera], Flaws(noise=0.005, missing=0.2, outliers=0.02), rng), rng, 0.5))
    right_turn(scan, field)
    assert scan.seen.mean() > 0.7


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_six_thousand_points_are_enough(kind: str) -> None:
    field = field_of(1, **KINDS[kind])
    rng = np.random.default_rng(1)
    views = [replace(view, columns=320, rows=240, focal=280.0) for view in TWO_VIEWS]
    cloud = turned(scanned(field, views, USUAL, np.random.default_rng(1)), rng, 0.5)
    scan = find_field(cloud[rng.permutation(len(cloud))[:6000]])
    right_turn(scan, field)
    assert scan.seen.mean() > 0.5


ASIDE = DepthCamera(place=(1.0, -0.6, 1.9), columns=400, rows=300, focal=330)


def hiding(boundary: str) -> tuple[StepField, Array]:
    """A field whose farthest row is hidden by the one before it, which is four units high, and what is seen of it."""
    levels = field_of(2, boundary="none").blocks.copy()
    if boundary == "outer":
        levels[0] = 4
    else:
        levels[:2] = [[1], [4]]
    field = rsegen.build(Recipe(seed=1, boundary=boundary, obstacles=(Matrix.of(levels),)), 0)
    rng = np.random.default_rng(2)
    return field, turned(scanned(field, [ASIDE], Flaws(noise=0.005, missing=0.2, outliers=0.02), rng), rng, 0.3)


@pytest.mark.slow
def test_a_frame_of_which_a_side_is_hidden_is_found() -> None:
    field, cloud = hiding("outer")
    scan = find_field(cloud)
    assert scan.boundary == "outer"
    assert len(scan.open_sides) == 1  # the floor behind it is hidden too, so that the frame may be farther away
    right_turn(scan, field)
    assert (~scan.seen[scan.frame]).sum() > 8  # of the frame's 12 in a row


@pytest.mark.slow
def test_a_side_of_a_frame_that_may_be_elsewhere_is_open(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """A person stands between the camera and two rows: the frame could be at any of them, or farther away."""
    field = field_of(2, boundary="outer")
    cloud = cloud_of(field)
    cloud = cloud[cloud[:, 1] > -0.4]  # of 12 rows of 10 cm two are hidden, and the floor next to them
    scan = find_field(cloud)
    assert sorted(scan.levels.shape) == [11, 12]
    assert scan.boundary == "outer"
    assert len(scan.open_sides) == 1
    np.save(tmp_path / "hidden.npy", cloud)
    assert main(["scan", str(tmp_path / "hidden.npy"), "-o", str(tmp_path)]) == 0
    side = scan.open_sides[0]
    assert f"almost no cells next to the {side} side were seen" in capsys.readouterr().out


@pytest.mark.slow
@pytest.mark.long(reason="a scan more")
def test_a_side_next_to_which_nothing_was_seen_is_open() -> None:
    _, cloud = hiding("none")
    scan = find_field(cloud)
    assert sorted(scan.levels.shape) == [9, 10]
    assert scan.open_sides
    assert find_field(cloud, ScanSettings(blocks=(10, 10))).open_sides == ()


@pytest.mark.slow
@pytest.mark.parametrize(("blocks", "points"), [(4, 3000), (4, 9000)])
@pytest.mark.parametrize("seed", [3, 5, 7])
def test_a_small_field_without_noise_has_its_own_blocks(blocks: int, points: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    side = blocks + 8
    heights = np.pad(rng.integers(0, 4, (blocks, blocks)), 4) / 10
    heights[4, 4] = heights[-5, -5] = 0.3  # so that its extent is seen
    cloud = rng.random((points, 3)) * (side / 10, side / 10, 0)
    i, j = (cloud[:, :2].T * 10).astype(int)
    cloud[:, 2] = heights[i, j]
    scan = find_field(cloud)
    assert scan.block_width == 0.1
    assert scan.levels.shape == (blocks, blocks)


@pytest.mark.slow
@pytest.mark.parametrize("boundary", long_unless("outer".__eq__, ["outer", "none"], reason="a scan more"))
def test_blocks_are_found_of_which_halves_were_taken(monkeypatch: pytest.MonkeyPatch, boundary: str) -> None:
    """As in clouds whose edges have as much power at half the width: every second line then has no steps."""
    widths: list[float | None] = []

    def halves(points: Array, unit: float, noise: float, pixel: float, width: float | None = None) -> CloudGrid:
        grid = find_grid(points, unit, noise, pixel, width)
        widths.append(width)
        return grid if width else replace(grid, width=grid.width / 2)

    monkeypatch.setattr(finding, "find_grid", halves)
    field = field_of(2, boundary=boundary)
    scan = find_field(cloud_of(field))
    assert widths == [None, 0.1]
    assert scan.block_width == 0.1
    right_turn(scan, field)


@pytest.mark.slow
def test_no_level_of_a_smoothed_cloud_is_wrong_and_sure() -> None:
    """Depth images after a Gauss filter of two pixels, as of a phone: slopes in place of edges."""
    field = field_of(3, boundary="outer")
    views = [replace(camera, columns=400, rows=300, focal=330.0) for camera in TWO_VIEWS]
    rng = np.random.default_rng(3)
    cloud = scanned(field, views, Flaws(blur=2, noise=0.003, missing=0.2, outliers=0.02), rng)
    scan = find_field(turned(cloud, rng, 0.5))
    assert scan.levels.shape == field.levels.shape
    sure = replace(scan, heights=np.where(scan.confidence >= SURE, scan.heights, np.nan))
    right_turn(sure, field)
    assert sure.seen.mean() > 0.3


@pytest.mark.slow
@pytest.mark.parametrize(("x", "y"), long_unless((1.4, 0.2).__eq__, [(1.4, 0.2), (0.9, -1.1)], reason="a scan more"))
def test_smoothed_depths_behind_blocks_are_no_blocks(x: float, y: float) -> None:
    """They hang between the edges of blocks and the floor behind them, as if cells had two heights."""
    field = field_of(11, **KINDS["half-cubes"])
    cameras = [DepthCamera(place=at, columns=640, rows=480, focal=580) for at in ((x, y, 1.5), (-x, -y, 1.4))]
    rng = np.random.default_rng(2)
    cloud = scanned(field, cameras, Flaws(blur=1.5, noise=0.004, missing=0.2, outliers=0.01), rng)
    scan = find_field(turned(cloud, rng, 0.5))
    assert sorted(scan.levels.shape) == sorted(field.levels.shape)
    sure = replace(scan, heights=np.where(scan.confidence >= SURE, scan.heights, np.nan))
    right_turn(sure, field)
    assert sure.seen.mean() > 0.5


@pytest.mark.parametrize(("rise", "noise", "is_top"), [(0, 0.002, True), (0, 0.02, True), (0.1, 0.002, False)])
def test_points_that_rise_over_a_cell_are_of_no_top(rise: float, noise: float, *, is_top: bool) -> None:
    rng = np.random.default_rng(4)
    across = rng.uniform(0, 0.5, (20_000, 2))
    cloud = np.column_stack([across, 0.2 + rise / 0.1 * (across[:, 0] % 0.1 - 0.05) + rng.normal(0, noise, 20_000)])
    grid = CloudGrid(heading=0.0, origin=np.zeros(2), width=0.1)
    reading = read_cells(cloud, np.ones(len(cloud), bool), grid, 0.1, noise)
    assert reading.heights.shape == (5, 5)
    assert reading.seen.all() == is_top
    assert reading.seen.any() == is_top


@pytest.mark.slow
def test_posts_of_three_and_a_half_inches_are_not_9_cm_wide() -> None:
    scan = find_field(turned(cloud_of(field_of(1, **KINDS["pallets of 3.5 inches"])), np.random.default_rng(1)))
    assert (scan.block_width, scan.unit, scan.frame_height) == (0.0889, 0.0889, 0.0889)
    scan = find_field(turned(cloud_of(field_of(1, unit_cm=9, block_width_cm=9)), np.random.default_rng(1)))
    assert (scan.block_width, scan.unit) == (0.09, 0.09)


@pytest.mark.slow
@pytest.mark.parametrize("stretch", long_unless(lambda stretch: stretch != 1, [1.0, 1.02], reason="a scan more"))
def test_lengths_as_measured_are_told_beside_those_of_the_map(stretch: float) -> None:
    """Of timber that swells in rain, or a depth camera that is not calibrated."""
    known = ScanSettings(boundary="none", block_width=0.1, unit=0.1)
    scan = find_field(turned(cloud_of(field_of(1, boundary="none")) * stretch, np.random.default_rng(1)), known)
    assert (scan.block_width, scan.unit) == (0.1, 0.1)
    assert scan.measured_width == pytest.approx(0.1 * stretch, rel=0.003)
    assert scan.measured_unit == pytest.approx(0.1 * stretch, rel=0.01)


def points_of(**values: Any) -> Array:
    return cloud_of(field_of(**values))


@pytest.mark.slow
def test_zeros_of_points_that_were_not_measured_are_left_out() -> None:
    """As drivers of lidars and depth cameras write them, in the frame of the sensor."""
    cloud = cloud_of(field_of()) - (0.6, 0.2, 2.2)
    scan = find_field(np.concatenate([cloud, np.zeros((len(cloud) // 8, 3))]))
    right_turn(scan, field_of())


BAD: Mapping[str, tuple[Any, ScanSettings, str]] = {
    "few points": (lambda: np.ones((20, 3)), ScanSettings(), "too few points for a field: 20"),
    "another shape": (lambda: np.zeros((900, 2)), ScanSettings(), r"shape \(900, 2\)"),
    "no numbers": (lambda: np.full((900, 3), np.nan), ScanSettings(), "too few points for a field: 0;"),
    "places of a map in 32 bits": (
        lambda: (points_of() + np.array([5e5, 5.4e6, 400])).astype(np.float32),
        ScanSettings(),
        "m from the origin, where numbers of 32 bits are 0.5 m apart; write them in 64 bits",
    ),
    "millimetres": (lambda: 1000 * points_of(), ScanSettings(), "set the unit of its numbers"),
    "no plane": (lambda: np.random.default_rng(1).random((5000, 3)), ScanSettings(), "no ground plane"),
    "a floor alone": (
        lambda: np.random.default_rng(1).random((9000, 3)) * (2, 2, 0.004),
        ScanSettings(),
        "nothing is above the ground",
    ),
    "one point, many times": (lambda: np.ones((900, 3)), ScanSettings(), "the cloud is 0 m wide"),
    "another unit": (points_of, ScanSettings(unit=0.07), "blocks rise by 10 cm in the cloud, not 7 cm"),
    "another width": (points_of, ScanSettings(block_width=0.13), "no grid of blocks"),
    "a smaller field": (
        lambda: points_of(boundary="none"),
        ScanSettings(blocks=(7, 7)),
        "10 x 10 cells are raised, not 7 x 7",
    ),
    "no frames": (lambda: points_of(boundary="none"), ScanSettings(boundary="outer"), "no outer frames"),
    "a direction along which nothing is level": (
        points_of,
        ScanSettings(up=(1, 0, 0)),
        "no (ground )?plane|no grid|whole multiples|rise by|hardly",
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("what", BAD)
def test_a_cloud_that_shows_no_such_field_is_refused(what: str) -> None:
    points, settings, said = BAD[what]
    with pytest.raises(ScanError, match=said) as refused:
        find_field(points(), settings)
    assert "\n" not in str(refused.value)


@pytest.mark.slow
def test_another_map_is_refused() -> None:
    with pytest.raises(ScanError, match="shows another map"):
        find_field(points_of(seed=1), known=field_of(2))


@pytest.mark.parametrize("points", [20, 60, 150])
def test_a_cloud_of_few_points_above_the_ground_is_refused_in_a_line(points: int) -> None:
    """No two of them are of one height, as in a cloud that is thinned out until nearly nothing is left."""
    heights = np.concatenate([np.zeros(400), np.linspace(0.05, 0.4, points)])
    with pytest.raises(ScanError, match="too few points are above the ground plane"):
        find_unit(heights, noise=0.002)


def test_heights_that_agree_with_no_unit_at_all_are_refused() -> None:
    """As those of a wood from above, of which no unit has a mean cosine above 0."""
    heights = 4 * np.sqrt(-np.log(np.linspace(1, 0, 20_001)[1:-1])) / 3
    values, weights = _raised(heights, 0.04, None)
    assert _agreement(values, weights, np.geomspace(0.1, 4.0, 500)).max() < 0.05
    with pytest.raises(ScanError, match="no whole multiples of a unit; set unit_cm"):
        find_unit(heights, noise=0.04)
    assert find_unit(heights, noise=0.04, given=0.1) == 0.1


@pytest.mark.parametrize("width", [0.04, 0.1, 0.37])
def test_points_off_and_words_of_a_grid_are_counted_cell_by_cell(width: float) -> None:
    rng = np.random.default_rng(3)
    levels = rng.integers(0, 4, 800)
    tops = _Tops(levels=levels, places=rng.normal(0, 0.3, (2, 800)))
    grid = CloudGrid(heading=0.4, width=width, origin=np.array([0.01, -0.02]))
    cells = np.floor((grid.rotation @ tops.places - grid.origin[:, None]) / width).T
    off = raised = 0
    for cell in np.unique(cells, axis=0):
        counts = np.bincount(levels[(cells == cell).all(axis=1)])
        off += int(counts.sum() - counts.max())
        raised += int(counts.argmax() > 0)
    assert off > 0
    assert raised > 3
    assert (tops.off(grid), tops.words(grid)) == (off, off + raised)


def plain(levels: Ints) -> StepField:
    """A field of these levels, of blocks of 10 cm without frames."""
    none = np.zeros(levels.shape, bool)
    return StepField(levels=levels.astype(np.int16), frame=none, block_width=0.1, unit=0.1, frame_height=0)


BARRIER, DECK, CROSS = (np.zeros((10, 10), int) for _ in range(3))
BARRIER[4:6] = 1  # from side to side
DECK[:], DECK[4:6] = 1, 2
CROSS[:, 3], CROSS[5] = 2, 1
TOWER = 1 + np.pad(1 + np.pad(np.ones((2, 2), int), 2), 2)  # levels 1, 2 and 3


@pytest.mark.slow
@pytest.mark.parametrize("levels", [BARRIER, DECK, CROSS, TOWER], ids=["barrier", "deck", "cross", "tower"])
def test_blocks_of_few_obstacles_are_as_wide_as_the_size_says(levels: Ints) -> None:
    """Steps of a barrier are at every second line, and those of blocks twice as wide are too."""
    scan = find_field(cloud_of(plain(levels), views=FINER_VIEWS), ScanSettings(blocks=(10, 10)))
    assert scan.block_width == 0.1
    right_turn(scan, plain(levels))


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_halved_width_is_doubled_to_the_size(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    field = plain(np.random.default_rng(seed).integers(1, 5, (8, 6)))
    asked = []

    def halved(points: Array, unit: float, noise: float, pixel: float, width: float | None = None) -> CloudGrid:
        asked.append(width)
        return find_grid(points, unit, noise, pixel, width or 0.05)

    monkeypatch.setattr(finding, "find_grid", halved)
    scan = find_field(cloud_of(field), ScanSettings(blocks=(8, 6)))
    assert asked[:2] == [None, 0.1]
    right_turn(scan, field)


@pytest.mark.slow
def test_a_size_of_which_no_width_makes_the_blocks_is_refused() -> None:
    field = plain(np.random.default_rng(4).integers(1, 5, (8, 8)))
    with pytest.raises(ScanError, match="8 x 8 cells are raised, not 5 x 5"):
        find_field(cloud_of(field), ScanSettings(blocks=(5, 5)))


def stepped_cloud(levels: Ints, side: float = 0.1) -> Array:
    """A cloud of square blocks from above, each a tenth of a metre per level high, with floor around them."""
    rng, margin = np.random.default_rng(0), 3
    heights = np.pad(levels, margin) / 10
    cloud = rng.random((60_000, 3)) * (side * len(heights), side * len(heights), 0)
    i, j = (cloud[:, :2].T / side).astype(int)
    cloud[:, 2] = heights[i, j] + rng.normal(0, 0.003, len(cloud))
    return cloud


def pyramid(side: int, step: int) -> Ints:
    rings = np.minimum(np.arange(side), np.arange(side)[::-1]) // step + 1
    return np.asarray(np.minimum.outer(rings, rings))


@pytest.mark.slow
@pytest.mark.parametrize(
    "levels",
    [
        pyramid(12, 2),
        pytest.param(pyramid(16, 2), marks=pytest.mark.long(reason="a scan more")),
        5 - pyramid(16, 2),
        np.pad(np.random.default_rng(1).integers(1, 4, (6, 6)), 3),
    ],
    ids=["a pyramid", "a larger one", "a hollow", "random blocks in the middle"],
)
def test_steps_of_two_blocks_that_fill_the_given_size_are_blocks_of_that_width(levels: Ints) -> None:
    scan = find_field(stepped_cloud(levels), ScanSettings(blocks=(len(levels), len(levels))))
    assert scan.block_width == 0.1
    assert any((np.rot90(scan.levels, turns) == levels).all() for turns in range(4))


@pytest.mark.slow
def test_the_width_that_a_size_makes_of_steps_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    np.save(tmp_path / "pyramid.npy", stepped_cloud(pyramid(12, 2)))
    assert main(["scan", str(tmp_path / "pyramid.npy"), "-o", str(tmp_path / "worlds"), "--size", "12"]) == 0
    said = "assumed: blocks 10 cm wide, as what is raised then reaches from side to side, though steps are wider"
    assert f"{said} (--block-width-cm 20 if they are not)" in capsys.readouterr().out
