"""Things below, on and next to a field in a cloud: boards, objects on blocks, furniture."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest

import rsegen
from benchmarks.depth_camera import DepthCamera, Flaws, scanned, turned, with_flaws
from benchmarks.rooms import cast_by_mujoco
from rsegen import StepField
from rsegen.errors import ScanError
from rsegen.field.stepfield import Array, Ints
from rsegen.scanning.commands import _doubt, _width
from rsegen.scanning.evidence import CERTAIN, bits_saved, cells_per_block, lines_of, stepped_lines
from rsegen.scanning.finding import find_field
from rsegen.scanning.levels import board_below, units_per_level
from rsegen.scanning.scan import SURE, Scan, ScanSettings
from rsegen.scanning.scan_report import scan_content
from tests.scanning.test_find_field import TWO_VIEWS, cloud_of, field_of, right_turn
from tests.support.long import long_unless

USUAL = Flaws(noise=0.005, missing=0.2, outliers=0.02)


def on_a_board(field: StepField, thickness: float) -> Array:
    """A cloud of a field whose blocks all stand on a board of its size."""
    raised = field.heights + thickness
    nanometre = StepField(
        levels=np.rint(raised * 1000).astype(np.int16),
        frame=np.zeros(field.shape, bool),
        block_width=field.block_width,
        unit=0.001,
        frame_height=0.0,
    )
    return turned(cloud_of(nanometre), np.random.default_rng(1), 0.3)


@pytest.mark.slow
@pytest.mark.parametrize("thickness", long_unless((0.018).__eq__, [0.018, 0.05], reason="a thicker board"))
def test_a_board_below_the_blocks_is_found(thickness: float) -> None:
    field = field_of(2, boundary="outer")
    cloud = on_a_board(field, thickness)
    scan = find_field(cloud)
    assert scan.base == pytest.approx(thickness, abs=0.004)
    assert (scan.unit, scan.frame_height) == (0.1, 0.1)
    right_turn(scan, field)
    known = find_field(cloud, known=field)
    assert (known.levels == field.levels)[known.seen].all()


@pytest.mark.slow
def test_a_given_board_is_not_searched() -> None:
    cloud = on_a_board(field_of(2, boundary="outer"), 0.05)
    assert find_field(cloud, ScanSettings(base=0)).base == 0
    with pytest.raises(ScanError, match=r"blocks rise by 5(\.\d+)? cm in the cloud, not 10 cm"):
        find_field(cloud, ScanSettings(base=0), known=field_of(2, boundary="outer"))


def test_boards_and_units_follow_from_the_levels_of_tops() -> None:
    def board(levels: Ints, unit: float, thickness: float = 0.0) -> float:
        return board_below(np.asarray(levels * unit + thickness, dtype=np.float64), levels, unit)

    levels = np.repeat(np.arange(5), 10)
    assert board(levels, 0.1) == 0
    assert board(levels, 0.1, 0.02) == pytest.approx(0.02)
    odd = 2 * levels + 1
    assert board(odd, 0.05) == pytest.approx(0.05)
    assert board(np.append(odd, 0), 0.05) == 0  # a top at the floor: on no board
    assert board(np.full(20, 1), 0.1, 0.02) == 0  # one level says nothing
    assert (units_per_level(levels), units_per_level(2 * levels), units_per_level(odd)) == (1, 2, 1)
    assert units_per_level(np.append(2 * levels, [1, 1])) == 2  # two cells were misread
    assert units_per_level(np.zeros(9, int)) == 1


def with_objects(field: StepField, cells: Array, heights: Array) -> Scan:
    """A scan of a field on some of whose cells are other things of some heights [m]."""
    tops = field.heights.copy()
    tops[tuple(cells.T)] += heights
    own = replace(
        field,
        levels=np.rint(tops * 1000).astype(np.int16),
        frame=np.zeros(field.shape, bool),
        unit=0.001,
    )
    return find_field(cloud_of(own), ScanSettings(block_width=0.1, unit=0.1))


@pytest.mark.slow
def test_an_object_on_a_block_is_not_taken_for_a_level_that_is_sure() -> None:
    field = field_of(4, boundary="outer")
    cells = np.array([(3, 3), (5, 8), (8, 4), (9, 9)])
    scan = with_objects(field, cells, np.array([0.07, 0.065, 0.12, 0.13]))
    assert scan.levels.shape == field.levels.shape
    wrong = scan.seen & (scan.levels != field.levels)
    assert wrong.sum() >= 3  # a top of 7 or 13 cm more is nearer to another level
    assert (scan.confidence[wrong] < SURE).all()
    others = scan.seen & ~wrong & ~scan.frame
    assert (scan.confidence[others] > SURE).mean() > 0.95


@pytest.mark.slow
@pytest.mark.long(reason="three scans of a large field")
def test_sides_of_which_little_is_raised_are_named() -> None:
    field = field_of(5, boundary="outer")
    plain = find_field(cloud_of(field), ScanSettings(boundary="none"))
    assert plain.sparse_edges == {}
    wide = np.zeros((14, 12), np.int16)
    wide[:12] = np.where(field.frame, 1, field.levels)
    wide[13, 4] = 2  # a box two cells away
    apart = rsegen.StepField(levels=wide, frame=np.zeros((14, 12), bool), block_width=0.1, unit=0.1, frame_height=0.0)
    scan = find_field(cloud_of(apart))
    assert scan.levels.shape == (14, 12)
    assert scan.sparse_edges == {"east": (1, 12)}
    assert find_field(cloud_of(apart), ScanSettings(blocks=(10, 10))).boundary == "outer"


@pytest.mark.slow
@pytest.mark.parametrize("degrees", [2, 5])
def test_missing_turned_and_shifted_blocks_are_right(degrees: float) -> None:
    """Blocks stand up to some 4 mm and three times these degrees off, as a standard deviation allows."""
    field = field_of(6, boundary="none")
    rng = np.random.default_rng(6)
    levels = field.levels.copy()
    levels.flat[rng.permutation(levels.size)[:12]] = 0
    edges_x, edges_y = field.edges()
    boxes = ""
    for i, j in np.argwhere(levels > 0):
        x, y = rng.normal((edges_x[i] + 0.05, edges_y[j] + 0.05), 0.004)
        half, turn = levels[i, j] * field.unit / 2, rng.normal(0, degrees)
        boxes += f'<geom type="box" size="0.05 0.05 {half}" pos="{x} {y} {half}" euler="0 0 {turn}"/>'
    pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    cloud = with_flaws(cast_by_mujoco(boxes, TWO_VIEWS), USUAL, rng)
    right_turn(find_field(turned(cloud, rng, 0.3)), replace(field, levels=levels))


def bent_corner(rng: np.random.Generator, x: Array, y: Array) -> Array:
    return np.where(np.hypot(x + 0.5, y + 0.5) < 0.17, 0.017, 0) + rng.normal(0, 0.0015, x.shape)


def cup(rng: np.random.Generator, x: Array, y: Array) -> Array:
    return np.where(np.hypot(x, y) < 0.12, 0.03, 0) + rng.normal(0, 0.001, x.shape)


def parcel(rng: np.random.Generator, x: Array, y: Array) -> Array:
    u, v = 0.8 * x + 0.6 * y, 0.8 * y - 0.6 * x
    return np.where((np.abs(u) < 0.2) & (np.abs(v) < 0.13), 0.15, 0) + rng.normal(0, 0.003, x.shape)


@pytest.mark.slow
@pytest.mark.parametrize("heights", [bent_corner, cup, parcel])
@pytest.mark.parametrize("seed", [1, 2])
def test_one_thing_on_the_floor_is_no_field(heights: Callable[..., Array], seed: int) -> None:
    rng = np.random.default_rng(seed)
    x, y = rng.uniform(-0.5, 0.5, (2, 60_000))
    with pytest.raises(ScanError, match=r"one raised patch of one height|no grid of blocks"):
        find_field(np.column_stack([x, y, heights(rng, x, y)]))


def boxes(x: Array, y: Array, *heights: float) -> Array:
    """Heights of boxes of 20 x 27 cm that stand next to each other along x, with gaps of 7 cm."""
    tops = np.zeros(x.shape)
    for number, height in enumerate(heights):
        left = 0.27 * (number - len(heights) / 2)
        tops[(x > left) & (x < left + 0.2) & (np.abs(y) < 0.135)] = height
    return tops


def hill(x: Array, y: Array) -> Array:
    """Return a body without flat tops, with a low arm, as an animal of plaster."""
    body = 0.12 * np.sqrt(np.clip(1 - (x / 0.14) ** 2 - (y / 0.2) ** 2, 0, None))
    return np.maximum(body, np.where((np.abs(x - 0.22) < 0.12) & (np.abs(y) < 0.04), 0.05 + 0.1 * (x - 0.22), 0))


@pytest.mark.slow
@pytest.mark.parametrize(
    "heights", [(0.07, 0.14), (0.07, 0.14, 0.07), (0.14, 0.07, 0.21)], ids=lambda each: f"{len(each)} boxes"
)
@pytest.mark.parametrize("turn", [0.0, np.pi / 2])
def test_a_few_boxes_next_to_each_other_are_no_field(heights: Sequence[float], turn: float) -> None:
    rng = np.random.default_rng(1)
    x, y = rng.uniform(-0.6, 0.6, (2, 80_000))
    u, v = x * np.cos(turn) + y * np.sin(turn), y * np.cos(turn) - x * np.sin(turn)
    cloud = np.column_stack([x, y, boxes(u, v, *heights) + rng.normal(0, 0.001, x.shape)])
    with pytest.raises(ScanError, match=r"too few sides to tell blocks from boxes|no grid of blocks"):
        find_field(cloud)


TABLE = DepthCamera(place=(0.1, -0.55, 0.75), columns=160, rows=120, focal=165)
"""A camera that looks down at a table from its side."""


def on_a_table(*boxes: tuple[float, float, float, float, float]) -> StepField:
    """Boxes from x to x, from y to y, of a height [m], on a table of 80 cm, as a field of blocks of a centimetre."""
    middles = (np.arange(80) + 0.5) / 100 - 0.4
    levels = np.zeros((80, 80), np.int16)
    for left, right, near, far, height in boxes:
        inside = np.outer((middles > left) & (middles < right), (middles > near) & (middles < far))
        levels[inside] = np.maximum(levels[inside], round(height * 1000))
    return StepField(levels=levels, frame=np.zeros((80, 80), bool), block_width=0.01, unit=0.001, frame_height=0)


@pytest.mark.slow
@pytest.mark.parametrize(
    "boxes",
    [
        pytest.param([(-0.15, 0.13, -0.09, 0.15, 0.053), (-0.1, 0.1, -0.06, 0.07, 0.107)], id="one on the other"),
        pytest.param([(-0.13, 0.13, -0.05, 0.13, 0.055), (-0.03, 0.03, -0.16, -0.1, 0.15)], id="a high and a wide one"),
    ],
)
def test_boxes_before_a_camera_on_a_table_are_no_field(
    boxes: Sequence[tuple[float, float, float, float, float]],
) -> None:
    """Grids go through their sides at whole levels, but few sides of many lines."""
    rng = np.random.default_rng(1)
    cloud = scanned(on_a_table(*boxes), [TABLE], Flaws(noise=0.0015), rng)
    cloud = turned(cloud[np.abs(cloud[:, :2]).max(axis=1) < 0.45], rng, 0.5)
    with pytest.raises(ScanError, match="too few sides to tell blocks from boxes"):
        find_field(cloud)


def scan_of(levels: Ints, confidence: float = 1.0) -> Scan:
    """A scan in which all cells were seen, at exact levels of 10 cm."""
    return Scan(
        levels=levels,
        heights=levels / 10,
        confidence=np.full(levels.shape, confidence),
        counts=np.full(levels.shape, 50),
        strays=np.zeros(levels.shape),
        frame=np.zeros(levels.shape, bool),
        boundary="none",
        chunk_size=None,
        block_width=0.05,
        unit=0.1,
        measured_width=0.05,
        measured_unit=0.1,
        frame_height=0,
        noise=0.001,
        base=0,
        rotation=np.eye(3),
        translation=np.zeros(3),
    )


def test_a_line_between_cells_has_the_steps_between_levels_that_are_sure() -> None:
    scan = scan_of(np.array([[1, 1, 2], [1, 1, 1]]))
    along_x, along_y = (lines.steps for lines in lines_of(scan))
    assert (along_x.tolist(), along_y.tolist()) == ([3, 1, 3], [2, 0, 1, 2])
    unsure = replace(scan, confidence=np.array([[1, 1, 0.9], [1, 1, 1]]))
    along_x, along_y = (lines.steps for lines in lines_of(unsure))
    assert (along_x.tolist(), along_y.tolist()) == ([2, 0, 3], [2, 0, 0, 1])


def test_random_blocks_are_told_more_shortly_by_their_grid_and_boxes_are_not() -> None:
    rng = np.random.default_rng(1)
    saved = [bits_saved(scan_of(rng.integers(1, 6, (size, size)))) for size in (4, 6, 10)]
    assert 20 < saved[0] < saved[1] < saved[2]
    box = np.ones((6, 4), np.int64)
    assert bits_saved(scan_of(box)) < 0
    box[2:4, 1:3] = 2
    assert bits_saved(scan_of(box)) < 16


def test_blocks_are_as_wide_as_the_lines_with_steps_are_apart() -> None:
    rng = np.random.default_rng(2)
    blocks = rng.integers(0, 5, (8, 6))
    for cells in (1, 2, 3):
        wide = np.kron(blocks, np.ones((cells, cells), np.int64))
        assert cells_per_block(scan_of(wide)) == cells
        wide[4, 5] += 1  # a cell that was misread
        assert cells_per_block(scan_of(wide)) == cells
    assert cells_per_block(scan_of(np.kron(blocks, np.ones((2, 1), np.int64)))) == 1
    assert cells_per_block(scan_of(np.ones((12, 12), np.int64))) == 1  # a box has two lines


@pytest.mark.slow
@pytest.mark.parametrize("scale", [1.0, 1.6])
def test_what_has_no_tops_of_a_unit_is_no_field(scale: float) -> None:
    rng = np.random.default_rng(2)
    x, y = rng.uniform(-0.5, 0.5, (2, 60_000))
    cloud = scale * np.column_stack([x, y, hill(x, y) + rng.normal(0, 0.0005, x.shape)])
    problem = "whole multiples of a unit|no grid of blocks|too few sides|one raised patch"
    with pytest.raises(ScanError, match=problem):
        find_field(cloud)


@pytest.mark.slow
@pytest.mark.parametrize("cells", [3, 12])
def test_a_grid_of_whose_cells_many_have_two_heights_is_no_field(cells: int) -> None:
    """A part of a machine may have edges on a grid, and others between them; on a field few things lie on blocks."""
    rng = np.random.default_rng(cells)
    field = replace(field_of(3, boundary="none"), unit=0.04)
    across = rng.uniform(-0.2, 1.2, (2, 150_000))
    (i, j), (x, y) = np.floor(across / 0.1).astype(int), across % 0.1 / 0.1
    outside = (np.minimum(i, j) < 0) | (np.maximum(i, j) > 9)
    heights = np.where(outside, 0, field.heights[i.clip(0, 9), j.clip(0, 9)])
    rib = (np.abs(x - 0.58) < 0.11) & (np.abs(y - 0.45) < 0.3)  # neither on the lines of the cells, nor halfway
    has_rib = np.zeros(100, bool)
    has_rib[rng.choice(100, cells, replace=False)] = True
    heights = heights + 0.08 * (rib & ~outside & has_rib.reshape(10, 10)[i.clip(0, 9), j.clip(0, 9)])
    cloud = np.column_stack([*across, heights + rng.normal(0, 0.001, len(heights))])
    if cells == 3:
        right_turn(find_field(cloud), field)
        return
    with pytest.raises(ScanError, match=r"no field: \d+% of its cells have two heights, where a block has one"):
        find_field(cloud)
    assert find_field(cloud, ScanSettings(block_width=0.1)).levels.shape == (10, 10)


@pytest.mark.slow
def test_stairs_of_many_blocks_are_a_field() -> None:
    levels = np.repeat(np.arange(8, dtype=np.int16)[:, None], 8, axis=1)
    stairs = replace(field_of(1, boundary="none"), levels=levels, frame=np.zeros((8, 8), bool))
    scan = find_field(cloud_of(stairs))
    assert sorted(np.unique(scan.levels[scan.seen])) == [1, 2, 3, 4, 5, 6, 7]  # the first step is the floor


@pytest.mark.slow
def test_one_patch_of_blocks_is_found_if_their_width_is_given() -> None:
    rng = np.random.default_rng(3)
    x, y = rng.uniform(-0.5, 0.5, (2, 60_000))
    heights = np.where((np.abs(x) < 0.2) & (np.abs(y) < 0.3), 0.1, 0) + rng.normal(0, 0.002, x.shape)
    cloud = np.column_stack([x, y, heights])
    with pytest.raises(ScanError, match="one raised patch of one height"):
        find_field(cloud)
    scan = find_field(cloud, ScanSettings(block_width=0.1, boundary="none"))
    assert scan.levels.tolist() == np.ones((4, 6)).tolist()


@pytest.mark.parametrize(
    ("levels", "width", "says"),
    [
        (np.random.default_rng(1).integers(1, 6, (6, 6)), 0.1, []),
        (np.ones((6, 4), np.int64), 0.1, ["assumed: blocks 10 cm wide, though too few"]),
        (np.random.default_rng(2).integers(1, 6, (6, 6)), 0.008, ["warning: blocks 10 cm wide: if they are not"]),
        (np.ones((6, 4), np.int64), 8.0, ["assumed: blocks 10 cm wide, though", "warning: blocks 10 cm wide: if"]),
    ],
    ids=["blocks", "one patch", "millimetres", "metres"],
)
def test_a_report_says_if_little_shows_the_width_or_nobody_builds_with_it(
    levels: Ints, width: float, says: Sequence[str]
) -> None:
    lines = list(_width(replace(scan_of(levels), measured_width=width), "10 cm"))
    assert len(lines) == len(says)
    assert all(line.startswith(start) for line, start in zip(lines, says, strict=True))


def heat_sink() -> Ints:
    """Return fins of a centimetre on a plate, one part of a machine."""
    levels = np.ones((20, 12), np.int64)
    levels[::2] = 4
    return levels


def pins() -> Ints:
    """Return pins that stand apart on a floor, as the houses of a town do."""
    levels = np.zeros((9, 9), np.int64)
    levels[::2, ::2] = np.random.default_rng(1).integers(1, 5, (5, 5))
    return levels


def desk() -> Ints:
    """Return things on a desk: long flat tops whose sides are on a grid of 10 cm."""
    levels = np.full((12, 8), 7)
    levels[1:4, 1:3], levels[6:8, 2:6], levels[9:11, 5:7] = 9, 8, 10
    return levels


@pytest.mark.parametrize(
    ("levels", "stepped", "seen", "says"),
    [
        (heat_sink(), 19, 30, "heights change at only 19 of 30 lines between cells"),
        (pins(), 16, 16, "no two raised cells touch"),
        (desk(), 12, 18, "heights change at only 12 of 18 lines between cells"),
        (np.repeat(np.repeat(np.arange(1, 9), 2)[:, None], 7, axis=1), 7, 21, "heights change at only 7 of 21"),
        (np.random.default_rng(1).integers(0, 5, (10, 10)), 18, 18, None),
        (np.random.default_rng(1).integers(0, 2, (10, 10)), 18, 18, None),
    ],
    ids=["heat sink", "pins", "desk", "stairs of a house", "random blocks", "random blocks of two levels"],
)
def test_what_may_be_no_field_is_said_first_with_its_confidence(
    levels: Ints, stepped: int, seen: int, says: str | None
) -> None:
    scan = scan_of(levels)
    assert bits_saved(scan) >= 16  # it is found
    lines = stepped_lines(scan)
    assert lines == (stepped, seen, says == "no two raised cells touch")
    assert scan_content(scan, 1)["confidence_of_field"] == pytest.approx(lines.confidence, abs=1e-4)
    assert (lines.confidence >= CERTAIN) == (says is None)
    doubts = list(_doubt(scan))
    assert len(doubts) == (says is not None)
    assert all(doubt.startswith(f"warning: perhaps no field of blocks: {says}") for doubt in doubts)


def test_lines_of_which_little_was_seen_count_by_what_was_seen() -> None:
    levels = np.random.default_rng(2).integers(1, 6, (10, 10))
    unseen = np.random.default_rng(3).random(levels.shape) < 0.45
    confidence = np.where(unseen, 0.0, 1.0)
    confidence[4] = 0.0  # no neighbours are known across two lines
    lines = stepped_lines(replace(scan_of(levels), confidence=confidence))
    assert lines.seen == 16
    assert lines.confidence > CERTAIN
