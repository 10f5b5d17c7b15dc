"""Ends of lanes: parts that are held, steps that stop a robot, falls, and the room beside a lane."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from rsegen.field.stepfield import Array, Ints
from rsegen.robots.base import ROBOTS
from rsegen.robots.drives import Wheels
from rsegen.standing.body import Body
from rsegen.standing.careful_lanes import _energy_left, careful
from rsegen.standing.ground import PaddedGround
from rsegen.standing.lanes import (
    FALL_ROOM,
    End,
    Lanes,
    _grip,
    drive_lanes,
    entry_distance,
    step_of,
    straight,
    surely_passed,
)
from rsegen.standing.lattice import Lattice
from rsegen.standing.planner import Planner
from rsegen.standing.settling import Settled, outer_radius, settle, settle_from
from tests.standing.stands import BODIES, cart, field_of, settled

BURGER = BODIES["burger"]
FLAT = field_of(np.zeros((12, 7), int))


def ridge() -> Ints:
    """Levels of a ridge along the middle line, one block wide: a burger's wheels are beside it, its caster is not."""
    levels = np.zeros((12, 7), int)
    levels[4:, 3] = 1
    return levels


def end_of(lanes: Lanes) -> End:
    """Reason why the only lane ends."""
    return End(int(lanes.end[0]))


@pytest.mark.parametrize("mu", [0.0, 1.0])
@pytest.mark.parametrize(("rise", "end"), [(0.004, End.NONE), (0.007, End.HELD)])
def test_a_caster_is_held_at_a_rise_above_its_radius(rise: float, end: End, mu: float) -> None:
    """A burger's ball has a radius of 5 mm, and its hull is 10 mm above the ground."""
    field = field_of(ridge(), rise)
    (caster,) = (number for number, part in enumerate(BURGER.parts) if part.name == "base::caster")
    parts = [part._replace(mu=mu, mu2=mu) if number == caster else part for number, part in enumerate(BURGER.parts)]
    body = replace(BURGER, parts=tuple(parts))
    lanes = straight(field, body, 0, np.zeros(1))
    assert end_of(lanes) is end
    assert end_of(straight(field, replace(body, reaction=False), 0, np.zeros(1))) is End.NONE, "Gazebo Classic lifts it"
    if end:
        front = float(body.points[body.part == caster, 0].max())
        origin = float(lanes.last[0]) / (lanes.drops.shape[1] - 1) * (2 * 0.6 + body.length) - entry_distance(
            field, body, 0
        )
        assert origin + front == pytest.approx(-0.2, abs=0.006)


def test_a_larger_caster_rolls_over_the_step_that_holds_a_smaller_one() -> None:
    """As a cart's, of 10 mm."""
    body, field = cart(0.1, base=0.25, speed=0.2), field_of(ridge(), 0.007)
    assert end_of(straight(field, body, 0, np.zeros(1))) is End.NONE
    assert end_of(straight(field_of(ridge(), 0.012), body, 0, np.zeros(1))) is End.HELD


def test_the_grip_of_a_robot_is_the_load_on_its_wheels() -> None:
    """By the rule of the lever, from the axle in its middle to the caster 81 mm behind it."""
    rest = settled(FLAT, BURGER, 0.0, 0.0, 0.0)
    assert _grip(BURGER, rest)[0] == pytest.approx(1 + BURGER.centre[0] / 0.081, abs=0.02)
    assert _grip(BODIES["jackal"], settled(FLAT, BODIES["jackal"], 0.0, 0.0, 0.0))[0] == pytest.approx(0.5)


@pytest.mark.parametrize("kind", sorted(BODIES))
@pytest.mark.parametrize("height", [0.15, 0.5])
def test_a_robot_at_a_wall_does_not_tip_over(kind: str, height: float) -> None:
    """Its pose on top of the wall, or half up it, would be none in which it stands; it stays before it."""
    levels = np.zeros((12, 7), int)
    levels[7:] = 1
    lanes = straight(field_of(levels, height), BODIES[kind], 0)
    assert (lanes.last > 10).all(), "it drives up to there"
    assert not (lanes.end == End.TIPS).any()
    if kind != "crawler" or height > 0.2:  # which it climbs
        assert (lanes.end != End.NONE).all()


def test_a_robot_that_drives_off_a_tower_tips_over() -> None:
    levels = np.zeros((12, 7), int)
    levels[:6] = 1
    field = field_of(levels, 0.3)
    ground = PaddedGround.of(field, outer_radius(BURGER))
    lanes = drive_lanes(ground, BURGER, np.array([-0.3]), np.zeros(1), np.zeros(1), 0.6)
    assert end_of(lanes) is End.TIPS
    assert "tips over" in end_of(lanes).words


def test_beside_a_lane_with_drops_there_is_room_to_fall() -> None:
    fallen = 0
    for seed in (0, 2, 3):
        field = field_of(np.random.default_rng(seed).integers(0, 3, (8, 14)), 0.05)
        body, middles = BODIES["crawler"], field.middles()[1]
        lanes = straight(field, body, 0, middles)
        drops = lanes.drops.any(axis=1)
        chosen = surely_passed(lanes, field, body, 0, middles) & drops
        for beside in (-FALL_ROOM, FALL_ROOM):
            if chosen.any():
                assert straight(field, body, 0, middles[chosen] + beside).passed.all()
        fallen += int(chosen.sum())
    assert fallen > 0


def pieces(points: Array) -> list[tuple[Array, Array]]:
    """The ends of the straight pieces of a way."""
    ahead = np.diff(points, axis=0)
    ahead /= np.hypot(*ahead.T)[:, None]
    turns = np.flatnonzero(np.abs(np.diff(ahead, axis=0)).max(axis=1) > 1e-6) + 1
    return [(points[a], points[b]) for a, b in pairwise([0, *turns.tolist(), len(points) - 1])]


@pytest.mark.parametrize(("kind", "unit"), [("burger", 0.005), ("jackal", 0.03), ("crawler", 0.05)])
def test_the_poses_of_an_answer_follow_from_those_before_them(kind: str, unit: float) -> None:
    """At each jump the robot comes to rest so too if it is put down as it stood before; put down level it may not."""
    body, (ground, starts, lengths) = BODIES[kind], rough_lanes(kind, unit)
    level, followed = (drive_lanes(ground, body, *starts, lengths, follows=follows) for follows in (False, True))
    jumps = others = poses = 0
    for number, last in enumerate(followed.last.tolist()):
        slope = followed.lane(number).poses.slope[: last + 1]
        jump = np.flatnonzero(np.abs(np.diff(slope, axis=0)).max(axis=1) > 0.01)
        after = followed.lane(number).poses.some(jump + 1)
        again = settle_from(ground, body, after.x, after.y, after.yaw, slope[jump])
        assert np.allclose(again.slope, after.slope, atol=2e-3)
        put = level.lane(number).poses.slope[: last + 1]
        jumps, poses = jumps + len(jump), poses + len(slope)
        others += int((np.abs(slope - put).max(axis=1) > 0.01).sum())
    assert jumps > 100
    assert 10 < others < poses / 3


@pytest.mark.slow
def test_straight_pieces_of_ways_are_driven_and_the_lanes_3_mm_beside_them() -> None:
    driven = bends = 0
    for kind, unit in (("burger", 0.004), ("jackal", 0.035)):
        body, field = BODIES[kind], field_of(np.random.default_rng(4).integers(0, 4, (8, 8)), unit)
        way, ground = Planner(Lattice(field, body)).way(0), PaddedGround.of(field, outer_radius(body))
        ends = pieces(way.points) if way else []
        for begin, end in ends:
            yaw = np.arctan2(*(end - begin)[::-1])
            x, y = begin[:, None] + np.array([[-np.sin(yaw)], [np.cos(yaw)]]) * np.array([-0.003, 0, 0.003])
            length = float(np.hypot(*(end - begin)))
            assert drive_lanes(ground, body, x, y, np.full(3, yaw), length).passed.all()
        driven, bends = driven + len(ends), bends + len(ends[1:])
    assert driven > 4
    assert bends > 0


@pytest.mark.parametrize("again", [False, True])
def test_beside_pieces_of_ways_with_drops_there_is_room_to_fall(again: bool) -> None:
    """Also where it is known from a way before. On the last field it falls on a lane, and 3 mm beside it does not."""
    fallen = 0
    for seed, unit in ((0, 0.05), (2, 0.05), (3, 0.05), (32, 0.03)):
        field = field_of(np.random.default_rng(seed).integers(0, 3, (8, 14)), unit)
        body, middles, planner = BODIES["crawler"], field.middles()[1], Planner(Lattice(field, BODIES["crawler"]))
        begin, lanes = -entry_distance(field, body, 0), straight(field, body, 0, middles)
        length = field.extent[0] / 2 - min(float(body.low[0]), 0.0) + step_of(body) - begin
        for middle, drops in zip(middles.tolist(), np.asarray(lanes.drops.any(axis=1)).tolist(), strict=True):
            for _ in range(1 + again):
                (share,) = planner._surely_driven(np.array([[begin, middle]]), np.zeros(1), np.array([length]))
            if drops and share == 1:
                assert straight(field, body, 0, middle + np.array([-FALL_ROOM, FALL_ROOM])).passed.all()
                fallen += 1
    assert fallen > 0


def rough_lanes(kind: str, unit: float) -> tuple[PaddedGround, tuple[Array, Array, Array], Array]:
    """A rough field, the starts of 60 lanes on it, and their lengths, which differ."""
    rng = np.random.default_rng(4)
    ground = PaddedGround.of(field_of(rng.integers(0, 4, (12, 12)), unit), outer_radius(BODIES[kind]))
    starts = rng.uniform(-0.5, 0.5, 60), rng.uniform(-0.5, 0.5, 60), rng.uniform(-np.pi, np.pi, 60)
    return ground, starts, rng.uniform(0.1, 0.9, 60)


@pytest.mark.parametrize(("kind", "unit"), [("burger", 0.005), ("jackal", 0.03), ("crawler", 0.05)])
def test_lanes_of_many_lengths_that_are_driven_together_end_as_each_alone(kind: str, unit: float) -> None:
    body, (ground, starts, lengths) = BODIES[kind], rough_lanes(kind, unit)
    lanes = drive_lanes(ground, body, *starts, lengths)
    assert 0 < lanes.passed.sum() < len(lanes.end)
    for number in range(0, len(lengths), 5):
        row = slice(number, number + 1)
        x, y, yaw = (values[row] for values in starts)
        alone = drive_lanes(ground, body, x, y, yaw, float(lengths[number]))
        assert (alone.end, alone.last, alone.count) == (lanes.end[row], lanes.last[row], lanes.count[row])
        driven = int(alone.last[0]) + 1
        assert np.allclose(alone.poses.z[:driven], lanes.lane(number).poses.z[:driven], atol=1e-6)
        assert (alone.drops[0, :driven] == lanes.drops[number, :driven]).all()


def test_poses_at_both_ends_of_lanes_that_are_known_are_not_found_again(monkeypatch: pytest.MonkeyPatch) -> None:
    body, (ground, (x, y, yaw), lengths) = BODIES["jackal"], rough_lanes("jackal", 0.03)
    asked = np.zeros(1, int)

    def counted(ground: PaddedGround, body: Body, x: Array, y: Array, yaw: Array) -> Settled:
        asked[0] += len(x)
        return settle(ground, body, x, y, yaw)

    at = x + np.cos(yaw) * lengths, y + np.sin(yaw) * lengths
    ends = settle(ground, body, x, y, yaw), settle(ground, body, *at, yaw)
    monkeypatch.setattr("rsegen.standing.lanes.settle", counted)
    lanes = drive_lanes(ground, body, x, y, yaw, lengths)
    whole, asked[0] = int(asked[0]), 0
    known = drive_lanes(ground, body, x, y, yaw, lengths, ends=ends)
    assert (known.end == lanes.end).all()
    assert (known.last == lanes.last).all()
    assert asked[0] <= whole - len(x)


def test_no_poses_are_found_behind_the_section_in_which_lanes_end(monkeypatch: pytest.MonkeyPatch) -> None:
    levels = np.zeros((40, 40), int)
    levels[3:] = 30
    body, asked = BODIES["jackal"], np.zeros(1, int)

    def counted(ground: PaddedGround, body: Body, x: Array, y: Array, yaw: Array) -> Settled:
        asked[0] += len(x)
        return settle(ground, body, x, y, yaw)

    monkeypatch.setattr("rsegen.standing.lanes.settle", counted)
    lanes = straight(field_of(levels, 0.03), body, 0)
    assert not lanes.passed.any()
    assert asked[0] < lanes.count.sum() / 2


@pytest.mark.parametrize("height", [0.01, 0.03, 0.05, 0.08])
def test_a_wheel_at_an_edge_keeps_the_velocity_across_the_line_to_its_axle(height: float) -> None:
    jackal = ROBOTS["jackal"]
    assert isinstance(jackal.drive, Wheels)
    kept = (1 - height / jackal.drive.radius) ** 2
    assert _energy_left(jackal.body, height) == pytest.approx(kept, abs=0.08)


def test_no_wheel_climbs_an_edge_above_its_axle_by_momentum() -> None:
    assert _energy_left(BODIES["jackal"], 0.12) == 0.0


@pytest.mark.parametrize(("unit", "climbs"), [(0.02, True), (0.05, False)])
def test_a_robot_that_needs_more_momentum_than_an_edge_leaves_has_no_room_to_spare(unit: float, climbs: bool) -> None:
    """The jackal climbs 4.5 cm in MuJoCo; with all of its momentum its poses climb 5 cm."""
    field = field_of(np.ones((10, 10), int), unit)
    body = BODIES["jackal"]
    assert straight(field, body, 0).passed.all()
    robot = careful(field, body)
    assert (robot is not None) == climbs
    if robot is not None:
        assert robot.speed < body.speed


@pytest.mark.parametrize("kind", BODIES)
def test_with_less_room_to_spare_a_robot_is_driven_with_more_of_what_it_has(kind: str) -> None:
    body = BODIES[kind]
    field = field_of(np.ones((10, 10), int), 0.002)
    robots = [careful(field, body, room) for room in (0.0, 0.5, 1.0)]
    speeds = [robot.speed for robot in robots if robot]
    assert len(speeds) == 3
    assert speeds[0] == body.speed > speeds[1] > speeds[2]
    assert [part.mu for part in robots[0].parts] == [part.mu for part in body.parts]  # type: ignore[union-attr]
    assert speeds[1] ** 2 == pytest.approx((speeds[0] ** 2 + speeds[2] ** 2) / 2)
