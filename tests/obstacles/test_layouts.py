"""Kinds laid out block by block: equal steps, even slopes, gaps as wide and pits as deep as asked, rings, boxes."""

from __future__ import annotations

from dataclasses import replace
from itertools import groupby
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rsegen import (
    DiscreteObstacles,
    Noise,
    Obstacle,
    Pit,
    Rails,
    Random,
    Recipe,
    Slope,
    Stairs,
    Stones,
    Waves,
    build,
    build_many,
)
from rsegen.errors import ParameterError
from rsegen.field.graphs import component_labels, neighbours
from rsegen.field.stepfield import Ints

SIDES = st.tuples(st.integers(1, 24), st.integers(1, 24))
WIDTHS, LEVELS = st.integers(1, 5), st.integers(2, 9)
GROUND = 20


def _laid(obstacle: Obstacle, shape: tuple[int, int], *below: Obstacle) -> Ints:
    """The levels of an obstacle of this size from the ground, (n_x, n_y), with three cells of ground on all sides."""
    side = max(shape) + 6
    last = (shape[0] + 2, shape[1] + 2)
    placed = replace(obstacle, first=(3, 3), last=last)
    recipe = Recipe(seed=1, chunk_size=side, boundary="none", ground_level=GROUND, obstacles=(*below, placed))
    return build(recipe).levels.astype(int)[: shape[0] + 6, : shape[1] + 6] - GROUND


def _lengths(line: Any) -> list[tuple[int, int]]:
    """Each run of equal values of a line, and its length."""
    return [(int(value), len(list(run))) for value, run in groupby(line)]


def _pieces(mask: Any) -> int:
    """Number of pieces of a mask whose cells share sides."""
    a, b = neighbours(mask.shape)
    both = mask.ravel()[a] & mask.ravel()[b]
    return len(np.unique(component_labels(mask.size, a[both], b[both])[mask.ravel()]))


@given(SIDES, LEVELS, WIDTHS, st.data())
def test_all_steps_of_a_flight_are_equal_and_end_in_a_landing(
    shape: tuple[int, int], levels: int, width: int, data: st.DataObject
) -> None:
    height = data.draw(st.integers(1, levels - 1))
    for axis, along in enumerate("xy"):
        stairs = Stairs(levels=levels, shape=along, step_width=width, step_height=height)
        inner = _laid(stairs, shape)[3:-3, 3:-3]
        assert (inner == inner.take([0], axis=1 - axis)).all()
        runs = _lengths(inner.take(0, axis=1 - axis))
        *steps, landing = runs
        assert [level for level, _ in runs] == [height * (k + 1) for k in range(len(runs))]
        assert all(cells == width for _, cells in steps)
        assert landing[0] <= levels - 1
        if landing[1] > width:
            assert landing[0] + height > levels - 1
        down = _laid(replace(stairs, direction="down"), shape)
        np.testing.assert_array_equal(down[3:-3, 3:-3], -inner)


def test_a_flight_climbs_from_first_to_last() -> None:
    stairs = Stairs(levels=5, shape="x", first=(9, 9), last=(0, 0))
    levels = build(Recipe(seed=1, boundary="none", obstacles=(stairs,))).levels
    assert levels[:, 0].tolist() == [4, 4, 4, 4, 4, 4, 4, 3, 2, 1]


@given(SIDES, LEVELS, WIDTHS, WIDTHS)
def test_a_pyramid_has_equal_steps_around_its_platform(
    shape: tuple[int, int], levels: int, width: int, platform: int
) -> None:
    stairs = Stairs(levels=levels, step_width=width, platform_width=platform)
    inner = _laid(stairs, shape)[3:-3, 3:-3]
    top = inner.max()
    for line in (inner[:, shape[1] // 2], inner[shape[0] // 2]):
        rising = _lengths(line)[: top - 1]
        assert rising == [(level, width) for level in range(1, top)]
    for flip in (inner[::-1], inner[:, ::-1]):
        np.testing.assert_array_equal(inner, flip)
    on_top = [np.ptp(indices) + 1 for indices in np.nonzero(inner == top)]
    assert min(on_top) >= min(platform, *shape)
    if top < levels - 1:  # one step more would leave too small a platform
        assert min(on_top) - 2 * width < platform
    np.testing.assert_array_equal(_laid(replace(stairs, direction="down"), shape)[3:-3, 3:-3], -inner)


@given(SIDES, LEVELS, st.none() | WIDTHS, st.none() | WIDTHS, st.sampled_from("xy"))
def test_a_pit_is_as_deep_as_asked_and_keeps_its_island_and_beam(
    shape: tuple[int, int], levels: int, gap: int | None, beam: int | None, along: str
) -> None:
    pit = Pit(levels=levels, gap_width=gap, beam_width=beam, beam_along=along)
    rough = Random(levels=3)
    inner, before = _laid(pit, shape, rough)[3:-3, 3:-3], _laid(replace(pit, enabled=False), shape, rough)[3:-3, 3:-3]
    kept = np.zeros(shape, bool)
    if gap is not None:
        kept[gap : max(shape[0] - gap, 0), gap : max(shape[1] - gap, 0)] = True
    if beam is not None:
        across = shape[1 if along == "x" else 0]
        start = max(across - beam, 0) // 2
        (kept if along == "y" else kept.T)[start : start + beam] = True
    assert (inner[~kept] == 1 - levels).all()
    np.testing.assert_array_equal(inner[kept], before[kept])


def test_a_beam_lies_across_its_pit_in_one_piece() -> None:
    levels = _laid(Pit(levels=4, beam_width=2), (9, 7))
    assert levels[:, 5:7].tolist() == [[0, 0]] * 15
    assert _pieces(levels == -3) == 2
    assert _pieces(_laid(Pit(levels=4, gap_width=2), (9, 7)) == 0) == 2


@given(SIDES, LEVELS, WIDTHS, WIDTHS)
def test_gaps_between_stones_are_as_wide_as_asked(shape: tuple[int, int], levels: int, stone: int, gap: int) -> None:
    inner = _laid(Stones(levels=levels, stone_width=stone, stone_distance=gap), shape)[3:-3, 3:-3]
    deep = 1 - levels
    assert set(np.unique(inner)) <= {0, deep}
    for line in (*inner, *inner.T):
        runs = _lengths(line)
        if len(runs) == 1:
            assert runs[0][0] == deep or runs[0][1] <= stone  # a line along a gap, or less than a stone
            continue
        asked = {deep: gap, 0: stone}
        assert all(cells == asked[level] for level, cells in runs[1:-1])
        assert all(cells <= asked[level] for level, cells in (runs[0], runs[-1]))
        if runs[0][0] == runs[-1][0]:
            assert abs(runs[0][1] - runs[-1][1]) <= 1  # in the middle


@given(LEVELS, st.integers(1, 3), st.data())
def test_each_uneven_stone_has_one_top_within_the_range(levels: int, stone: int, data: st.DataObject) -> None:
    uneven = data.draw(st.integers(1, levels - 1))
    inner = _laid(Stones(levels=levels, stone_width=stone, uneven=uneven), (4 * (stone + 1) + 1, 3 * (stone + 1) + 1))
    tops = inner[3:-4, 3:-4].reshape(4, stone + 1, 3, stone + 1)[:, 1:, :, 1:]
    assert (tops == tops[:, :1, :, :1]).all()
    assert -uneven <= tops.min()
    assert tops.max() <= 0


def test_tops_of_uneven_stones_are_uniform() -> None:
    stones = Stones(levels=9, stone_width=1, uneven=3)
    levels = build(Recipe(seed=1, chunk_size=201, boundary="none", ground_level=8, obstacles=(stones,))).levels
    counts = np.bincount(8 - levels[1::2, 1::2].ravel(), minlength=4)
    assert counts.sum() == 100 * 100
    assert np.abs(counts - 2500).max() < 5 * (10_000 * 0.25 * 0.75) ** 0.5


def test_a_platform_amid_stones_is_level() -> None:
    levels = _laid(Stones(levels=4, uneven=3, platform_width=4), (12, 10))
    assert (levels[7:11, 6:10] == 0).all()


@given(SIDES, LEVELS, WIDTHS, WIDTHS, st.sampled_from("xy"))
def test_rails_are_straight_and_at_equal_distances(
    shape: tuple[int, int], levels: int, rails: int, width: int, along: str
) -> None:
    inner = _laid(Rails(levels=levels, shape=along, rails=rails, rail_width=width), shape)[3:-3, 3:-3]
    lines = inner if along == "x" else inner.T
    assert (lines == lines[:, :1]).all()
    runs = _lengths(lines[:, 0])
    raised = [cells for level, cells in runs if level]
    assert {level for level, _ in runs} <= {0, levels - 1}
    if len(lines) >= rails * (width + 1):
        assert raised == [width] * rails
    else:
        assert 1 <= len(raised) <= rails
    between = [cells for level, cells in runs[1:-1] if not level]
    assert not between or max(between) - min(between) <= 1


@given(SIDES, LEVELS, WIDTHS, WIDTHS)
def test_rings_are_closed(shape: tuple[int, int], levels: int, rings: int, width: int) -> None:
    raised = _laid(Rails(levels=levels, rails=rings, rail_width=width), shape) == levels - 1
    pieces = _pieces(raised)
    assert 1 <= pieces <= rings
    if (min(shape) + 1) // 2 >= rings * (width + 1):
        assert pieces == rings
        # Each closed ring parts the ground in two; diagonal neighbours do not connect.
        assert _pieces(~raised) == rings + 1


@given(SIDES, LEVELS, WIDTHS, WIDTHS, st.sampled_from(["x", "y", "rings"]), st.data())
def test_each_uneven_rail_or_gap_has_one_height_within_the_range(
    shape: tuple[int, int], levels: int, rails: int, width: int, along: str, data: st.DataObject
) -> None:
    uneven = data.draw(st.integers(1, max(levels - 2, 1)))
    alike = Rails(levels=levels, shape=along, rails=rails, rail_width=width)
    for direction, sign in (("up", 1), ("down", -1)):
        covered = _laid(replace(alike, direction=direction), shape) == sign * (levels - 1)
        inner = sign * _laid(replace(alike, direction=direction, uneven=uneven), shape)
        assert covered.any()
        assert (inner[~covered] == 0).all()
        assert levels - 1 - uneven <= inner[covered].min()
        assert inner.max() <= levels - 1
        if along != "rings":
            lines = inner if along == "x" else inner[: shape[0] + 6, : shape[1] + 6].T
            assert (lines[:, 3:4] == lines[:, 3:-3]).all()


def test_a_rail_wider_than_its_rectangle_fills_it() -> None:
    assert (_laid(Rails(levels=3, shape="x", rails=1, rail_width=5), (3, 4))[3:-3, 3:-3] == 2).all()


def test_heights_of_uneven_hurdles_are_uniform() -> None:
    hurdles = Rails(levels=9, shape="x", rails=1000, rail_width=1, uneven=3)
    recipe = Recipe(seed=1, chunk_size=200, chunks=(10, 1), boundary="none", obstacles=(hurdles,))
    heights = build(recipe).levels[:, 0]
    counts = np.bincount(8 - heights[heights > 0], minlength=4)
    assert counts.sum() == 1000
    assert np.abs(counts - 250).max() < 5 * (1000 * 0.25 * 0.75) ** 0.5


@given(SIDES, LEVELS, WIDTHS, st.sampled_from(["pyramid", "x", "y"]))
def test_a_slope_rises_evenly_to_its_highest_level(
    shape: tuple[int, int], levels: int, platform: int, way: str
) -> None:
    slope = Slope(levels=levels, shape=way, platform_width=platform)
    inner = _laid(slope, shape)[3:-3, 3:-3]
    assert inner.max() == levels - 1
    if way == "pyramid":
        line = inner[: (shape[0] + 1) // 2, shape[1] // 2]
        on_top = [np.ptp(indices) + 1 for indices in np.nonzero(inner == levels - 1)]
        assert min(on_top) >= min(platform, *shape)
        for flip in (inner[::-1], inner[:, ::-1]):
            np.testing.assert_array_equal(inner, flip)
    else:
        lines = inner if way == "x" else inner.T
        assert (lines == lines[:, :1]).all()
        line = lines[:, 0]
        # The straight line from the ground to the top of the last cell, to less than a unit.
        exact = (levels - 1) * (np.arange(len(line)) + 1) / len(line)
        assert ((exact - line > -1e-9) & (exact - line < 1)).all()
    steps = np.diff(line)
    assert (steps >= 0).all()
    assert np.ptp(steps[: max(int(np.argmax(line == line.max())), 1)]) <= 1 if len(steps) else True
    np.testing.assert_array_equal(_laid(replace(slope, direction="down"), shape)[3:-3, 3:-3], -inner)


@given(st.integers(2, 60), LEVELS, WIDTHS, st.sampled_from(["x", "y"]))
def test_waves_have_as_many_crests_as_asked(cells: int, levels: int, waves: int, way: str) -> None:
    shape = (cells, 3) if way == "x" else (3, cells)
    inner = _laid(Waves(levels=levels, shape=way, waves=waves), shape)[3:-3, 3:-3]
    lines = inner if way == "x" else inner.T
    assert (lines == lines[:, :1]).all()
    line = lines[:, 0]
    assert line.min() >= 0
    assert line.max() <= levels - 1
    np.testing.assert_array_equal(line, line[::-1])
    if cells >= 8 * waves:  # crests are as high and troughs as low as half a cell beside them allows
        assert line.min() == 0
        assert line.max() == levels - 1
        high = line > (levels - 1) / 2
        assert (np.diff(high.astype(int)) == 1).sum() == waves


def test_waves_across_both_axes_are_the_mean_of_the_two() -> None:
    both, x, y = (_laid(Waves(levels=10_001, shape=way), (20, 14))[3:-3, 3:-3] for way in ("both", "x", "y"))
    assert np.abs(both - (x + y) / 2).max() <= 1
    assert both.max() > 9000


@given(SIDES, LEVELS, WIDTHS)
def test_noise_has_straight_slopes_between_its_points(shape: tuple[int, int], levels: int, spacing: int) -> None:
    inner = _laid(Noise(levels=levels, spacing=spacing), shape)[3:-3, 3:-3]
    assert inner.min() >= 0
    assert inner.max() <= levels - 1
    points = inner[::spacing, ::spacing]
    for i, j in np.ndindex(points.shape[0] - 1, points.shape[1] - 1):
        corners = points[i : i + 2, j : j + 2].astype(float)
        part = inner[i * spacing : (i + 1) * spacing + 1, j * spacing : (j + 1) * spacing + 1]
        along = np.linspace(0, 1, spacing + 1)
        x = corners[0] + (corners[1] - corners[0]) * along[:, None]
        between = x[:, :1] + (x[:, 1:] - x[:, :1]) * along
        assert (np.abs(part - between) < 1).all()  # both of heights rounded down


def test_noise_of_spacing_1_is_uniform_and_of_wider_spacing_smooth() -> None:
    recipe = Recipe(seed=1, chunk_size=200, boundary="none", obstacles=(Noise(levels=5, spacing=1),))
    counts = np.bincount(build(recipe).levels.ravel(), minlength=5)
    assert np.abs(counts - 8000).max() < 5 * (40_000 * 0.2 * 0.8) ** 0.5
    smooth = build(replace(recipe, obstacles=(Noise(levels=5, spacing=8),))).levels.astype(int)
    assert np.abs(np.diff(smooth, axis=0)).max() <= 1
    assert np.ptp(smooth) == 4


@given(st.integers(6, 24), LEVELS, st.integers(1, 4), st.integers(0, 2), st.integers(0, 3), st.data())
def test_one_box_has_sides_and_a_height_within_the_range_and_is_whole(
    side: int, levels: int, least: int, more: int, platform: int, data: st.DataObject
) -> None:
    direction = data.draw(st.sampled_from(["up", "down", "both"]))
    boxes = DiscreteObstacles(levels=levels, count=1, least_width=least, most_width=least + more, direction=direction)
    inner = _laid(boxes, (side, side))[3:-3, 3:-3]
    x, y = np.nonzero(inner)
    assert len(x)
    height = inner[x[0], y[0]]
    assert 1 <= abs(height) <= levels - 1
    assert direction == "both" or (height > 0) == (direction == "up")
    assert (inner[x.min() : x.max() + 1, y.min() : y.max() + 1] == height).all()
    assert {np.ptp(x) + 1, np.ptp(y) + 1} <= set(range(least, least + more + 1))
    free = _laid(replace(boxes, count=50, platform_width=platform), (side, side))[3:-3, 3:-3]
    low = (side - platform) // 2
    assert (free[low : low + platform, low : low + platform] == 0).all()
    assert free.any()


def test_boxes_are_uniform_in_side_height_and_place() -> None:
    boxes = DiscreteObstacles(levels=5, count=1, least_width=2, most_width=4, direction="both")
    maps = build_many(Recipe(seed=1, chunk_size=12, boundary="none", ground_level=4, obstacles=(boxes,)), range(4000))
    relative = maps.astype(int) - 4
    covered = relative != 0
    widths, depths = covered.any(axis=2).sum(axis=1), covered.any(axis=1).sum(axis=1)
    heights = np.array([one[one != 0][0] for one in relative])
    for found, shares in ((widths, [1 / 3] * 3), (depths, [1 / 3] * 3), (heights, [1 / 8] * 8)):
        counts = np.unique(found, return_counts=True)[1]
        assert len(counts) == len(shares)
        assert np.abs(counts - 4000 * np.array(shares)).max() < 5 * (4000 * max(shares)) ** 0.5
    corner, middle = covered[:, 0, 0].mean(), covered[:, 6, 6].mean()
    assert 0 < corner < middle


def test_softness_lowers_a_layout_towards_the_ground() -> None:
    for cls in (Stairs, Pit, Stones, Rails, Slope, Waves, Noise, DiscreteObstacles):
        hard, soft, level = (_laid(cls(levels=9, softness=softness, key="same"), (12, 12)) for softness in (0, 50, 100))
        assert not level.any()
        np.testing.assert_array_equal(np.abs(soft), np.abs(hard) // 2)
        assert (soft * hard >= 0).all()


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Stairs(levels=3, step_height=3), "step_height: 3 is more than the highest level, 2"),
        (lambda: Stones(levels=3, uneven=3), "uneven: 3 is more than the depth of the gaps, 2"),
        (lambda: Rails(levels=3, uneven=3), "uneven: 3 is more than the highest level, 2"),
        (lambda: DiscreteObstacles(levels=3, least_width=5), "least_width: 5 is more than the largest, 4"),
        (lambda: Pit(levels=3, beam_along="z"), "beam_along: 'z' is not one of x, y"),
    ],
)
def test_what_does_not_go_together_is_refused(make: Any, message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        make()
