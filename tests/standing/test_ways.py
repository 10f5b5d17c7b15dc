"""Ways of robots: lanes that pass, lanes that end for a reason, and ways around what cannot be passed."""

from __future__ import annotations

import copy
import itertools
import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components, dijkstra

import rsegen
from rsegen.cli.edge import main
from rsegen.errors import ParameterError
from rsegen.field.stepfield import Ints, StepField
from rsegen.standing import lattice
from rsegen.standing import reach as reaching
from rsegen.standing.lanes import End, straight
from rsegen.standing.lattice import BEST, Lattice
from rsegen.standing.planner import Planner, best_way
from rsegen.standing.reach import reach, region_of
from rsegen.standing.ways import events, no_way
from tests.standing.stands import BODIES, field_of

KINDS = sorted(BODIES)
BURGER = BODIES["burger"]


def test_copies_of_ways_and_bodies_are_read_only_too() -> None:
    found = reach(field_of(np.zeros((6, 5), int)), BURGER)
    for value, name in ((found, "region"), (found.west_east, "points"), (BURGER, "points")):
        array, again = (getattr(each, name) for each in (value, copy.deepcopy(value)))
        assert not array.flags.writeable
        assert not again.flags.writeable
        assert np.array_equal(array, again)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("axis", [0, 1])
def test_on_flat_ground_every_lane_passes(kind: str, axis: int) -> None:
    lanes = straight(field_of(np.zeros((8, 5), int)), BODIES[kind], axis)
    assert len(lanes.passed) == (5, 8)[axis]
    assert lanes.passed.all()
    assert np.degrees(lanes.tilt) == pytest.approx(0, abs=0.3)
    assert not lanes.drops.any()
    assert not lanes.slips.any()


@pytest.mark.parametrize("kind", KINDS)
def test_a_wall_of_30_cm_stops_every_robot_for_a_reason(kind: str) -> None:
    levels = np.zeros((12, 6), int)
    levels[6] = 1
    field = field_of(levels, 0.3)
    lanes = straight(field, BODIES[kind], 0)
    assert not lanes.passed.any()
    assert (lanes.end != End.NONE).all()
    way = no_way(lanes, BODIES[kind])
    assert not way.crosses
    assert way.reason in {end.words for end in End if end}
    assert way.at is not None
    assert way.at[0] < 0.1


def test_on_a_flat_field_all_is_reached_and_the_way_is_straight() -> None:
    found = reach(field_of(np.zeros((6, 5), int)), BURGER)
    assert found.coverage == 1
    assert found.region.all()
    for way in (found.west_east, found.south_north):
        assert way.crosses
        assert way.length_ratio == pytest.approx(1, abs=1e-9)
        assert way.tilt == pytest.approx(0, abs=0.005)


def test_a_way_over_a_high_edge_tells_where_the_robot_falls() -> None:
    levels = np.zeros((16, 8), int)
    levels[4:8], levels[8:11] = 9, 18
    way = best_way(field_of(levels), BODIES["crawler"], 0)
    assert way.crosses
    edge = 1.1 - 0.8
    assert way.drops
    assert all(edge < x < edge + BODIES["crawler"].length for x, _ in way.drops)
    assert events(way)[0].startswith("drops at 0.")
    flat = best_way(field_of(np.zeros((16, 8), int)), BODIES["crawler"], 0)
    assert (flat.drops, flat.slips, events(flat)) == ((), (), [])


def test_a_way_tells_where_the_robot_is_nearest_to_tipping_over() -> None:
    """The map has a single edge, so it is about that one."""
    levels, body = np.zeros((30, 6), int), BODIES["crawler"]
    levels[22:] = 1
    way = best_way(field_of(levels, 0.08), body, 0)
    level = best_way(field_of(np.zeros((30, 6), int)), body, 0)
    assert way.margin is not None
    assert level.margin is not None
    assert way.margin < level.margin - 0.01
    assert way.margin_at is not None
    assert abs(way.margin_at[0] - 0.7) < body.length
    assert no_way(straight(field_of(levels, 5.0), body, 0), body).margin_at is None


def walled(*, has_gap: bool) -> Ints:
    """Levels of a wall across the field, with a gap of three blocks at its end."""
    levels = np.zeros((5, 7), int)
    levels[2] = 1
    levels[2, 4:] = 0 if has_gap else 1
    return levels


def test_a_robot_goes_through_the_gap_of_a_wall_and_nowhere_else() -> None:
    way = Planner(Lattice(field_of(walled(has_gap=True), 0.1), BURGER)).way(0)
    assert way is not None
    assert way.crosses
    at_wall = way.points[np.abs(way.points[:, 0]) < 0.06]
    assert ((at_wall[:, 1] > 0.05) & (at_wall[:, 1] < 0.35)).all()
    assert not best_way(field_of(walled(has_gap=False), 0.1), BURGER, 0).crosses


def test_a_tower_in_the_way_is_gone_around() -> None:
    levels = np.zeros((5, 9), int)
    levels[2, 3:6] = 1
    field = field_of(levels, 0.1)
    passed = straight(field, BURGER, 0).passed
    assert passed.tolist() == [True, True, *[False] * 5, True, True]
    way = best_way(field, BURGER, 0)
    assert way.crosses
    assert way.length_ratio == pytest.approx(1)
    assert np.abs(way.points[:, 1]).min() > 0.2


@pytest.mark.slow
def test_a_robot_crosses_frames_but_does_not_drive_along_them() -> None:
    """Along frames as wide as these, around the field and across it, it would get around every block."""
    frame, levels = np.zeros((6, 7), bool), np.zeros((6, 7), int)
    frame[[0, -1]] = frame[:, [0, -1]] = frame[:, 2:4] = True
    field = StepField(levels=levels.astype(np.int16), frame=frame, block_width=0.25, unit=0.3, frame_height=0.002)
    found = reach(field, BURGER)
    for way, across in ((found.west_east, 1), (found.south_north, 0)):
        assert way.crosses
        line = np.rint((way.points[:, across] / 0.25) + (field.shape[across] - 1) / 2).astype(int)
        assert field.inside(across)[line].all()
    assert found.region[~frame].all()
    blocked = replace(field, levels=np.where(frame, 0, np.arange(6)[:, None] == 3).astype(np.int16))
    assert not best_way(blocked, BURGER, 0).crosses
    assert best_way(blocked, BURGER, 1).crosses


@pytest.mark.slow
def test_the_best_way_is_the_shortest_the_most_level_or_that_with_the_largest_margin() -> None:
    """Straight across is a low ridge; around it is longer and level."""
    levels = np.zeros((5, 7), int)
    levels[2, 2:] = 1
    field = field_of(levels, 0.008)
    by = {best: best_way(field, BURGER, 0, best) for best in BEST}
    assert all(way.crosses for way in by.values())
    assert by["length"].length_ratio == pytest.approx(1)
    assert (by["tilt"].length or 0) >= (by["length"].length or 0) - 1e-9
    assert by["tilt"].tilt == pytest.approx(0, abs=1e-3)
    assert (by["margin"].margin or 0) >= max(by["length"].margin or 0, by["tilt"].margin or 0) - 1e-6


@pytest.mark.slow
def test_no_way_is_better_than_the_best_one() -> None:
    """On a map of which each best way is another one."""
    field = field_of(np.random.default_rng(3).integers(0, 3, (6, 6)), 0.02)
    by = {best: Planner(Lattice(field, BODIES["crawler"], best)).way(0) for best in ("length", "tilt", "margin")}
    ways = [way for way in by.values() if way]
    assert len(ways) == len({way.points.tobytes() for way in ways}) == 3
    # What a way is best of is asked of its moves, and told of poses on it: a little differs.
    assert (by["length"] or ways[0]).length == pytest.approx(min(way.length or 0 for way in ways))
    assert (by["tilt"] or ways[0]).tilt == pytest.approx(min(way.tilt or 0 for way in ways), abs=0.02)
    assert (by["margin"] or ways[0]).margin == pytest.approx(max(way.margin or 0 for way in ways), abs=0.02)


def test_the_command_knows_what_a_way_is_the_best_of(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(ParameterError, match="best: 'speed' is not one of safe, length, tilt, margin"):
        rsegen.drive("peak", route="way", best="speed")
    with pytest.raises(ParameterError, match="best: is for route way, not for straight"):
        rsegen.drive("peak", best="tilt")
    assert main(["schema", "drive"]) == 0
    assert json.loads(capsys.readouterr().out)["properties"]["best"]["enum"] == list(BEST)


@pytest.mark.parametrize("seed", range(5))  # of a place where a robot has two rests, its mirror may have the other
def test_a_mirrored_field_has_mirrored_lanes(seed: int) -> None:
    levels = np.random.default_rng(seed).integers(0, 3, (6, 8))
    lines = np.random.default_rng(seed).uniform(-0.3, 0.3, 6)
    for kind, unit in (("burger", 0.004), ("crawler", 0.02)):
        lanes = straight(field_of(levels, unit), BODIES[kind], 0, lines)
        mirrored = straight(field_of(levels[:, ::-1], unit), BODIES[kind], 0, -lines)
        assert (lanes.end != mirrored.end).sum() <= 1  # a sample may be just at the edge of a block
        assert np.median(np.abs(lanes.poses.z - mirrored.poses.z)) < 1e-4


@pytest.mark.slow
@pytest.mark.parametrize(("best", "seed"), [*zip(BEST, (0, 1, 2, 4), strict=True)])
def test_a_way_between_places_that_is_searched_for_is_that_of_a_lattice_that_is_all_known(best: str, seed: int) -> None:
    levels = np.random.default_rng(seed).integers(0, 4, (6, 5))
    field, body = field_of(levels, 0.03), BODIES["jackal"]
    start, goal = (-0.25, -0.2), (0.25, 0.2)
    known = Lattice(field, body, best)
    region_of(known)
    searched, expected = (Planner(lattice).between(start, goal) for lattice in (Lattice(field, body, best), known))
    assert searched is not None
    assert expected is not None
    assert searched.length == pytest.approx(expected.length)
    assert np.hypot(np.diff(searched.poses.x), np.diff(searched.poses.y)).max() < 0.1
    assert all(searched.poses.stands)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_a_region_and_ways_are_those_that_scipy_finds_on_the_same_lattice(seed: int) -> None:
    field, body = field_of(np.random.default_rng(seed).integers(0, 4, (7, 6)), 0.03), BODIES["jackal"]
    lattice = Lattice(field, body)
    region = region_of(lattice)
    lattice.drive_from(np.arange(lattice.moves.size))
    lattice.turn_at(np.arange(lattice.moves.size))
    places, edges = np.arange(lattice.moves.size).reshape(lattice.moves.shape), dict[tuple[int, int], float]()
    for i, j, k in np.argwhere(lattice.moves).tolist():
        x, y = round(np.cos(k * np.pi / 4)), round(np.sin(k * np.pi / 4))
        edges[places[i, j, k], places[i + x, j + y, k]] = field.block_width * np.hypot(x, y)
    for i, j, k in np.argwhere(lattice.turns).tolist():
        low, high = places[i, j, k], places[i, j, (k + 1) % 8]
        edges[low, high] = edges[high, low] = body.width / 2 * np.pi / 4
    graph = coo_array((list(edges.values()), np.array(list(edges)).T), (places.size, places.size)).tocsr()
    _, group = connected_components(graph, connection="strong")
    cells = [set((np.flatnonzero(group == name) // 8).tolist()) for name in np.unique(group)]
    assert set(np.flatnonzero(region).tolist()) in [each for each in cells if len(each) == max(map(len, cells))]
    ends = [(0, 0), (6, 0), (3, 2), (6, 5), (0, 5)]
    for start, goal in itertools.pairwise(ends):
        there = [(float(lattice.x[i]), float(lattice.y[j])) for i, j in (start, goal)]
        found = Planner(lattice).between(there[0], there[1])
        lengths = dijkstra(graph, indices=places[start], min_only=True)[places[goal]]
        assert (found.length if found else np.inf) == pytest.approx(lengths.min())


@pytest.mark.slow
@pytest.mark.parametrize(("unit", "most"), [(0.02, 0.4), (0.06, 0.7), (0.1, 1.0)])
def test_a_region_is_that_of_all_moves_but_needs_few_where_a_robot_gets_around(unit: float, most: float) -> None:
    lattice = Lattice(field_of(np.random.default_rng(7).integers(0, 4, (8, 7)), unit), BODIES["crawler"])
    region, driven = region_of(lattice), lattice.is_driven.mean()
    lattice.drive_from(np.arange(lattice.moves.size))
    lattice.turn_at(np.arange(lattice.moves.size))
    assert np.array_equal(region_of(lattice), region)
    assert driven < most


def test_on_flat_ground_a_way_between_places_is_straight_and_from_a_place_to_itself_none_is_driven() -> None:
    planner = Planner(Lattice(field_of(np.zeros((8, 5), int)), BURGER))
    way = planner.between((-0.35, 0.0), (0.35, 0.0))
    assert way is not None
    assert way.length == pytest.approx(0.7)
    assert (way.drops, way.slips) == ((), ())
    assert way.poses.y == pytest.approx(0, abs=1e-6)
    there = planner.between((0.04, 0.0), (0.06, 0.01))
    assert there is not None
    assert there.length == 0
    assert np.ptp(there.poses.x) == pytest.approx(0, abs=1e-6)


def test_no_way_leads_to_where_a_robot_tips_over() -> None:
    levels = np.zeros((8, 5), int)
    levels[6, 2] = 1
    assert Planner(Lattice(field_of(levels, 0.3), BURGER)).between((-0.35, 0.0), (0.33, 0.03)) is None


def test_a_search_for_a_way_can_be_ended_before_the_first_way_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lattice, "_REPORT_EVERY", 5)
    monkeypatch.setattr(Lattice, "settle_at", lambda *_: pytest.fail("a way was found before"))

    def stop(_: float) -> None:
        raise InterruptedError

    planner = Planner(Lattice(field_of(np.zeros((12, 8), int)), BODIES["crawler"], watch=stop))
    with pytest.raises(InterruptedError):
        planner.way(0)


@pytest.mark.slow
def test_a_search_tells_its_share_and_is_ended_by_what_it_tells(monkeypatch: pytest.MonkeyPatch) -> None:
    field, shares = field_of(np.random.default_rng(2).integers(0, 3, (8, 6)), 0.02), list[float]()
    whole = region_of(Lattice(field, BODIES["crawler"]))
    monkeypatch.setattr(reaching, "_TURNS_AT_ONCE", 40)
    monkeypatch.setattr(reaching, "_MOVES_AT_ONCE", 40)
    assert np.array_equal(region_of(Lattice(field, BODIES["crawler"], watch=shares.append)), whole)
    assert shares == sorted(set(shares))
    assert shares[-1] == 1

    def stop(share: float) -> None:
        if share > 0.5:
            raise InterruptedError

    stopped = Lattice(field, BODIES["crawler"], watch=stop)
    with pytest.raises(InterruptedError):
        region_of(stopped)
    stopped.watch = shares.append
    assert np.array_equal(region_of(stopped), whole), "what was found before the stop still holds"
