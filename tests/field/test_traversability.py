"""Traversability for a robot, held to scipy's graphs and to fields small enough to be walked by eye."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components, dijkstra

import rsegen
from rsegen import StepField, StepLimits
from rsegen.field.graphs import component_labels, strongly_connected
from rsegen.field.stepfield import Ints
from rsegen.field.traversability import PathGround, Traversability, ground, lane, traversability
from rsegen.params.sorts import NANOMETRES
from tests.measuring.test_families import field, turned
from tests.support.strategies import fields

CLIMBERS = st.builds(
    StepLimits,
    climb_cm=st.sampled_from([0.0, 1.0, 7.0, 10.0, 20.0, 40.0]),
    drop_cm=st.sampled_from([None, 0.0, 10.0, 20.0, 40.0]),
    width_cm=st.sampled_from([0.0, 10.0, 17.8, 30.0, 1000.0]),
)


def graph(carrying: PathGround, climber: StepLimits, tread: int) -> csr_array:
    """Every move that a robot can make, with its cost."""
    heights, (climb, drop) = carrying.heights.ravel(), climber.limits
    one, other = carrying.moves()
    tails, heads = np.concatenate([one, other]), np.concatenate([other, one])
    rise = heights[heads] - heights[tails]
    can = (rise <= climb) & (-rise <= drop)
    return csr_array((tread + np.abs(rise[can]), (tails[can], heads[can])), shape=(heights.size,) * 2)


@given(fields(), CLIMBERS)
def test_the_cheapest_way_is_scipy_s(found: StepField, climber: StepLimits) -> None:
    assume(not found.frame.all())
    tread = round(found.block_width * NANOMETRES)
    for axis, crossing in enumerate(
        (traversability(found, climber).west_east, traversability(found, climber).south_north)
    ):
        carrying = lane(found, climber.width, axis)
        cells = np.arange(carrying.heights.size).reshape(carrying.heights.shape)
        costs = dijkstra(graph(carrying, climber, tread), indices=cells[0], min_only=True)
        least = costs[cells[-1]].min() / NANOMETRES
        assert crossing.crosses == np.isfinite(least)
        assert crossing.cost == (pytest.approx(least) if crossing.crosses else None)


@given(fields(), CLIMBERS)
def test_of_equally_cheap_ways_the_shortest_is_taken(found: StepField, climber: StepLimits) -> None:
    """scipy's cheapest way, if every move costs a bit more."""
    assume(not found.frame.all())
    carrying = lane(found, climber.width, 0)
    moves = graph(carrying, climber, round(found.block_width * NANOMETRES))
    moves.data = moves.data * 1024 + 1
    cells = np.arange(carrying.heights.size).reshape(carrying.heights.shape)
    least = dijkstra(moves, indices=cells[0], min_only=True)[cells[-1]].min()
    crossing = traversability(found, climber).west_east
    if crossing.length is None:
        assert np.isinf(least)
    else:
        assert crossing.length == pytest.approx(least % 1024 * found.block_width)


def test_a_mirrored_field_has_the_same_length() -> None:
    limits = StepLimits(climb_cm=40)
    recipe = rsegen.Recipe(seed=1, obstacles=[rsegen.Random(levels=5)])
    detours = 0
    for index in range(30):
        made = rsegen.build(recipe, index)
        lengths = {
            traversability(replace(made, levels=levels.copy()), limits).west_east.length or 0.0
            for levels in (made.levels, made.levels[::-1], made.levels[:, ::-1], made.levels[::-1, ::-1])
        }
        assert len(lengths) == 1
        detours += lengths.pop() > 1.3
    assert detours > 10


@given(fields(), CLIMBERS)
def test_the_region_is_scipy_s_largest(found: StepField, climber: StepLimits) -> None:
    assume(not found.frame.all())
    """Of those with the most blocks that are as high as all that is below a robot on them."""
    carrying, blocks = ground(found, climber.width), ~found.frame
    _, group = connected_components(graph(carrying, climber, 1), connection="strong")
    carries = blocks & (np.abs(found.heights - carrying.heights / NANOMETRES) < 1e-9)
    counts = [
        tuple(np.count_nonzero(those.ravel() & (group == each)) for those in (carries, blocks)) for each in set(group)
    ]
    result = traversability(found, climber)
    (chosen,) = set(group[result.region.ravel()])
    assert counts[list(set(group)).index(chosen)] == max(counts)
    assert np.array_equal(result.region, blocks & (group == chosen).reshape(found.shape))
    assert result.coverage == pytest.approx(result.region.sum() / blocks.sum())


def test_the_region_of_a_wide_robot_is_the_floor_and_not_the_surroundings_of_barriers() -> None:
    """A robot that is three blocks wide would stand on a barrier wherever it is next to it."""
    levels = np.zeros((30, 20), dtype=np.int16)
    levels[[6, 22, 25, 28], :] = levels[:, 19] = 1
    field = StepField(
        levels=levels, frame=np.zeros(levels.shape, dtype=bool), block_width=0.1, unit=0.1, frame_height=0.0
    )
    narrow, wide = (traversability(field, StepLimits(climb_cm=5, width_cm=width)) for width in (0, 30))
    expected = np.zeros(levels.shape, dtype=bool)
    expected[7:22, :19] = True
    assert np.array_equal(narrow.region, expected)
    expected[[7, 21]] = expected[:, 18] = False
    assert np.array_equal(wide.region, expected)


EDGES = st.lists(st.tuples(st.integers(0, 19), st.integers(0, 19), st.booleans(), st.booleans()), max_size=60)


@given(EDGES)
def test_mutual_reach_in_any_graph_is_scipy_s(edges: list[tuple[int, int, bool, bool]]) -> None:
    a, b, onward, back = (np.array(part, dtype=int) for part in (zip(*edges, strict=True) if edges else [[]] * 4))
    found = strongly_connected(20, a, b, onward.astype(bool), back.astype(bool))
    tails, heads = np.concatenate([a[onward > 0], b[back > 0]]), np.concatenate([b[onward > 0], a[back > 0]])
    _, expected = connected_components(
        csr_array((np.ones(len(tails)), (tails, heads)), shape=(20, 20)), connection="strong"
    )
    assert partition(found) == partition(expected)
    _, expected = connected_components(csr_array((np.ones(len(a)), (a, b)), shape=(20, 20)), directed=False)
    assert partition(component_labels(20, a, b)) == partition(expected)


def partition(group: Ints) -> set[frozenset[int]]:
    return {frozenset(np.flatnonzero(group == each).tolist()) for each in set(group.tolist())}


@given(fields(), CLIMBERS)
def test_a_path_is_passable_and_costs_what_is_reported(found: StepField, climber: StepLimits) -> None:
    assume(not found.frame.all())
    crossing = traversability(found, climber).west_east
    assume(crossing.crosses)
    carrying = lane(found, climber.width, 0)
    margin = (len(carrying.heights) - found.shape[0]) // 2
    heights = carrying.heights[crossing.path[:, 0] + margin, crossing.path[:, 1]]
    moves, rise = np.abs(np.diff(crossing.path, axis=0)), np.diff(heights)
    assert (moves.sum(axis=1) == 1).all()
    assert rise.max() <= climber.limits[0]
    assert -rise.min() <= climber.limits[1]
    length = len(moves) * found.block_width
    assert crossing.length == pytest.approx(length)
    assert crossing.cost == pytest.approx(length + np.abs(rise).sum() / NANOMETRES)
    assert (crossing.path[0, 0], crossing.path[-1, 0]) == (-margin, found.shape[0] + margin - 1)


@given(fields(), st.sampled_from([0.0, 10.0, 30.0]))
def test_a_robot_crosses_from_the_opening_on_and_not_below_it(found: StepField, width_cm: float) -> None:
    assume(not found.frame.all())
    at = StepLimits(climb_cm=1e-3, width_cm=width_cm)
    opens = rsegen.metrics(found, at).opening
    for axis, least in (("west_east", opens.west_east), ("south_north", opens.south_north)):
        climbs = StepLimits(climb_cm=round(least * 100, 7), width_cm=width_cm)
        assert getattr(traversability(found, climbs), axis).crosses
        if least > 1e-5:
            below = StepLimits(climb_cm=round(least * 100 - 1e-3, 7), width_cm=width_cm)
            assert not getattr(traversability(found, below), axis).crosses


@given(fields(), CLIMBERS)
def test_a_better_climber_reaches_every_cell_that_another_reaches(found: StepField, climber: StepLimits) -> None:
    assume(not found.frame.all())
    one = traversability(found, climber)
    two = traversability(found, StepLimits(climb_cm=climber.climb_cm + 5, drop_cm=50, width_cm=climber.width_cm))
    assert two.coverage >= one.coverage
    assert (two.west_east.costs <= one.west_east.costs).all()


@given(fields(), CLIMBERS)
def test_a_quarter_turn_swaps_the_directions(found: StepField, climber: StepLimits) -> None:
    """West-east becomes south-north: x has become y."""
    assume(not found.frame.all())
    one, other = traversability(found, climber), traversability(turned(found), climber)
    assert one.west_east.cost == pytest.approx(other.south_north.cost)
    assert one.coverage == other.coverage


def reached(rows: list[str], climb_cm: float, drop_cm: float | None = None, width_cm: float = 0) -> Traversability:
    return traversability(field(*rows), StepLimits(climb_cm=climb_cm, drop_cm=drop_cm, width_cm=width_cm))


def test_a_wall_with_a_door_is_gone_round() -> None:
    """Six moves from the ground to the ground, and no rise: the door is at the southern end."""
    found = reached(["00900", "00900", "00000"], 10).west_east
    assert found.path.tolist() == [[i, 0] for i in range(-1, 6)]
    assert found.length == pytest.approx(0.6)
    assert found.cost == pytest.approx(0.6)


def test_a_step_is_paid_for_up_and_down() -> None:
    found = reached(["01210"], 10).west_east
    assert found.cost == pytest.approx(0.6 + 0.4)
    assert found.length_ratio == pytest.approx(1)
    assert found.cost_ratio == pytest.approx(1 / 0.6)


def test_pits_that_a_robot_would_drop_into_are_not_in_the_region() -> None:
    """A pit of 2 units: a robot that drops 20 cm and climbs 10 cm gets in and not out again."""
    assert reached(["222", "202", "222"], 10, 20).coverage == pytest.approx(8 / 9)
    assert reached(["222", "202", "222"], 20).coverage == 1


def test_two_stairs_that_drop_on_to_one_another_are_one_region() -> None:
    """Up the northern stairs, down by 3 units on to the southern ones, up these, and down on to the northern ones."""
    ring = ["0123", "0990", "3210"]
    assert reached(ring, 10, 30).region.T[::-1].astype(int).tolist() == [[1, 1, 1, 1], [1, 0, 0, 1], [1, 1, 1, 1]]
    assert reached(ring, 10, 20).coverage == pytest.approx(5 / 12)


def test_a_frame_is_crossed_and_not_driven_along() -> None:
    walls = ["#####", "#090#", "#090#", "#####"]
    assert not reached(walls, 10).west_east.crosses
    assert reached(walls, 10).south_north.crosses
    assert not reached(walls, 5).south_north.crosses
    assert reached(walls, 10).coverage == pytest.approx(2 / 6)


def test_a_wide_robot_stands_on_the_highest_cell_below_it() -> None:
    gap = ["99999", "00000", "99999"]
    assert reached(gap, 10, width_cm=10).west_east.crosses
    assert not reached(gap, 10, width_cm=10.1).west_east.crosses


@pytest.mark.slow
@pytest.mark.long(reason="a million cells")
def test_a_million_cells_are_measured_within_seconds_of_cpu_time() -> None:
    """About 4 s on one slow core; a quadratic algorithm would take days."""
    levels = np.random.default_rng(1).integers(0, 5, (1000, 1000)).astype(np.int16)
    large = StepField(levels=levels, frame=levels < 0, block_width=0.1, unit=0.1, frame_height=0.1)
    start = time.process_time()
    rsegen.metrics(large, StepLimits(climb_cm=10, drop_cm=20))
    assert time.process_time() - start < 60
