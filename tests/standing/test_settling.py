"""A robot at rest lies on three contacts around its centre of mass, wherever the field is and however it is turned."""

from __future__ import annotations

import re
from dataclasses import replace
from math import asin, degrees, hypot, pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks import rests
from rsegen.errors import TooLarge
from rsegen.field.stepfield import Array, Ints
from rsegen.robots.base import ROBOTS
from rsegen.standing.body import Body
from rsegen.standing.ground import PaddedGround
from rsegen.standing.pushing import sample_heights
from rsegen.standing.resting import has_stood, resting_poses
from rsegen.standing.settling import Settled, outer_radius, settle
from tests.standing.stands import BODIES, field_of, settled

KINDS = sorted(BODIES)
HEADINGS = st.floats(-pi, pi)
EXACT = [kind for kind in KINDS if kind != "jackal"]
"""The Jackal's centre of mass is above both diagonals of its wheels, so it rests in either of two ways."""

UNITS = {kind: unit / 100 for kind, unit in rests.UNITS.items()}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("level", [0, 3])
@given(yaw=HEADINGS)
@settings(max_examples=20, deadline=None)
def test_on_a_plane_a_robot_stands_level_at_its_own_height(kind: str, level: int, yaw: float) -> None:
    field = field_of(np.full((20, 20), level))
    found = resting_poses(field, BODIES[kind], np.array([0.0]), np.array([0.0]), np.array([yaw]))
    assert found.z[0] == pytest.approx(0.01 * level, abs=5e-4)
    assert np.degrees([found.roll[0], found.pitch[0]]) == pytest.approx([0, 0], abs=0.2)
    assert np.array([found.x[0], found.y[0]]) == pytest.approx([0, 0], abs=1e-3)
    assert found.stands.all()
    assert found.holds.all()
    assert found.pushes.all()


@pytest.mark.parametrize("height", [0.01, 0.02, 0.03])
def test_with_its_front_wheels_on_a_block_the_jackal_is_as_steep_as_its_wheelbase_says(height: float) -> None:
    levels = np.zeros((20, 20), int)
    levels[10:] = 1
    found = resting_poses(field_of(levels, height), BODIES["jackal"], np.array([0.0]), np.array([0.0]), np.array([0.0]))
    base = 0.262
    assert degrees(found.pitch[0]) == pytest.approx(-degrees(asin(height / base)), abs=0.2)
    assert degrees(found.roll[0]) == pytest.approx(0, abs=0.05)


@pytest.mark.parametrize("height", [0.002, 0.005])
def test_with_one_wheel_on_a_block_the_burger_rolls_as_its_track_says(height: float) -> None:
    levels = np.zeros((20, 20), int)
    levels[:, 10:] = 1
    # Its caster is 8 cm behind the axle; beside the edge, so that it and the other wheel are on the ground.
    found = resting_poses(
        field_of(levels, height), BODIES["burger"], np.array([0.0]), np.array([-0.02]), np.array([0.0])
    )
    between = 0.160
    assert degrees(abs(found.roll[0])) == pytest.approx(degrees(asin(height / between)), abs=0.3)


@pytest.mark.parametrize("kind", EXACT)
def test_a_field_that_is_turned_moved_or_mirrored_turns_moves_or_mirrors_the_poses(kind: str) -> None:
    body, unit, rng = BODIES[kind], UNITS[kind], np.random.default_rng(8)
    levels, (x, y, yaw) = (
        rng.integers(0, 5, (40, 40)),
        rng.uniform([[-1.5], [-1.5], [-pi]], [[1.5], [1.5], [pi]], (3, 300)),
    )
    rest = poses_on(levels, unit, body, x, y, yaw)
    up_x, up_y = rest.axes[:, :2, 2].T
    still = has_stood(rest) & (rest.turn < 1e-4)
    moved = np.pad(levels, ((6, 0), (0, 2)))
    for other, expected in (
        (poses_on(np.rot90(levels), unit, body, -y, x, yaw + pi / 2), (-up_y, up_x)),
        (poses_on(levels[:, ::-1], unit, body, x, -y, -yaw), (up_x, -up_y)),
        (poses_on(moved, unit, body, x + 0.3, y - 0.1, yaw), (up_x, up_y)),
    ):
        wanted = np.stack([rest.z, *expected], axis=1)
        found = np.concatenate([other.z[:, None], other.axes[:, :2, 2]], axis=1)
        # Here and there a robot can rest in two ways, or a sample is just at the edge of a block.
        assert (np.abs(found - wanted)[still].max(axis=1) < 2e-3).mean() > 0.95
        assert has_stood(other)[still].mean() > 0.99


def poses_on(levels: Ints, unit: float, body: Body, x: Array, y: Array, yaw: Array) -> Settled:
    """Robots at rest on a field."""
    return settle(PaddedGround.of(field_of(levels, unit), outer_radius(body)), body, x, y, yaw)


@pytest.mark.parametrize("kind", KINDS)
def test_nothing_is_below_the_ground_and_three_contacts_bear_the_robot(kind: str) -> None:
    body, rng = BODIES[kind], np.random.default_rng(4)
    field = field_of(rng.integers(0, 5, (30, 30)), UNITS[kind])
    x, y, yaw = (rng.uniform(-most, most, 300) for most in (1.0, 1.0, pi))
    ground = PaddedGround.of(field, outer_radius(body))
    rest = settle(ground, body, x, y, yaw)
    stood = np.flatnonzero(has_stood(rest))
    assert len(stood) > 250
    # Against the side of a block a part never comes to rest at the very edge, and the last round still turns it.
    resting = stood[rest.turn[stood] < 1e-4]
    assert len(resting) > 0.8 * len(stood)
    _, above = sample_heights(ground, body, rest, resting)
    assert above.min() > -1e-3
    contacts = np.take_along_axis(above, rest.contacts[resting], axis=1)
    assert (np.abs(contacts).max(axis=1) < 1e-3).mean() > 0.99  # or it is just at the edge of a block
    loads = resting_poses(field, body, x, y, yaw).loads[resting]
    assert (loads > -1e-6).all()
    assert loads.sum(axis=1) == pytest.approx(1)


@pytest.mark.parametrize("kind", KINDS)
def test_a_pose_does_not_depend_on_the_poses_that_are_found_with_it(kind: str) -> None:
    body, rng = BODIES[kind], np.random.default_rng(5)
    field = field_of(rng.integers(0, 5, (30, 30)), UNITS[kind])
    x, y, yaw = (rng.uniform(-most, most, 40) for most in (1.4, 1.4, pi))
    together = settle(PaddedGround.of(field, outer_radius(body)), body, x, y, yaw)
    for k in range(0, 40, 3):
        alone = settled(field, body, x[k], y[k], yaw[k])
        assert (alone.contacts[0] == together.contacts[k]).all()
        assert (alone.z[0], *alone.slope[0]) == pytest.approx((together.z[k], *together.slope[k]), abs=1e-9)


@pytest.mark.parametrize("exchanges", [2, 3, 6])
def test_robots_whose_contacts_are_not_found_in_time_have_poses_too(
    exchanges: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    body, rng = BODIES["crawler"], np.random.default_rng(7)
    ground = PaddedGround.of(field_of(rng.integers(0, 5, (30, 30)), UNITS["crawler"]), outer_radius(body))
    places = [rng.uniform(-most, most, 400) for most in (1.4, 1.4, pi)]
    found = settle(ground, body, *places)
    monkeypatch.setattr("rsegen.standing.settling._EXCHANGES", exchanges)
    rest = settle(ground, body, *places)
    assert (rest.z != found.z).any(), "some took more exchanges"
    assert np.isfinite(rest.z).all()
    assert np.isfinite(rest.slope).all()


@pytest.mark.parametrize("kind", KINDS)
def test_a_robot_is_below_the_ground_by_no_more_than_the_turn_that_it_would_still_make(kind: str) -> None:
    body, rng = BODIES[kind], np.random.default_rng(6)
    field = field_of(rng.integers(0, 8, (20, 20)), 0.05)
    x, y, yaw = (rng.uniform(-most, most, 200) for most in (0.9, 0.9, pi))
    ground = PaddedGround.of(field, outer_radius(body))
    rest = settle(ground, body, x, y, yaw)
    stood = np.flatnonzero(has_stood(rest))
    # With blocks like these many go to and fro over an edge.
    assert (rest.turn[stood] > 1e-4).mean() > 0.1
    _, above = sample_heights(ground, body, rest, stood)
    assert ((above.min(axis=1) > -rest.turn[stood] * outer_radius(body) - 1e-3).mean()) > 0.99  # or just at an edge


@pytest.mark.parametrize("kind", KINDS)
def test_groups_hold_every_sample_and_are_of_neighbours(kind: str) -> None:
    body = BODIES[kind]
    assert set(body.groups.ravel().tolist()) == set(range(len(body.points)))
    sizes = np.linalg.norm(np.ptp(body.points[body.groups], axis=1), axis=1)
    assert np.median(sizes) < body.length / 6


def test_a_robot_that_is_all_on_one_side_of_its_centre_of_mass_tips_over() -> None:
    few = replace(BODIES["burger"], points=BODIES["burger"].points[:5], groups=np.arange(5)[None])
    rest = settled(field_of(np.zeros((9, 9), int)), few, 0.0, 0.0, 0.3)
    assert not has_stood(rest)[0]


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_mujoco_agrees(kind: str) -> None:
    pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    robot, body = ROBOTS[kind], BODIES[kind]
    scene = rests._scene(1, rests.UNITS[kind])
    ground = PaddedGround.of(scene.field, outer_radius(body))
    found = [
        rests._rest("mujoco", robot, 1, number, ground, start, rests._in_mujoco(scene, robot, start))
        for number, start in enumerate(rests._starts(scene, body, 1)[:20])
    ]
    assert np.median([rest.height for rest in found]) < 1.0
    assert np.median([rest.angle for rest in found]) < (0.3 if kind in EXACT else 0.5)


def test_no_place_at_all_gives_no_poses() -> None:
    nothing = np.empty(0)
    assert resting_poses(
        field_of(np.zeros((3, 3), int)), BODIES["burger"], nothing, nothing, nothing
    ).support.shape == (
        0,
        11,
        3,
    )


def test_the_margin_on_a_plane_is_that_of_the_nearest_edge() -> None:
    found = resting_poses(field_of(np.zeros((20, 20), int)), BODIES["jackal"], *np.zeros((3, 1)))
    centre = BODIES["jackal"].centre
    # From axle to axle 26.2 cm, less than across; of a wheel the samples next to the lowest one are in contact too.
    high, aside = float(centre[2]), 0.131 - abs(float(centre[0]))
    assert np.tan(found.tip_angle[0]) == pytest.approx(aside / high, rel=0.04)
    energy = BODIES["jackal"].mass * 9.81 * (hypot(high, aside) - high)
    assert found.tip_energy[0] == pytest.approx(energy, rel=0.08)


@pytest.mark.parametrize(("kind", "cells"), [("crawler", 12), ("burger", 300)])
def test_blocks_too_narrow_for_a_robot_are_refused_with_a_width_that_will_do(kind: str, cells: int) -> None:
    """No heights are asked for before that: those of a crawler on blocks of 0.01 mm would be hundreds of GiB."""
    radius, narrow = outer_radius(BODIES[kind]), replace(field_of(np.zeros((cells, cells), int)), block_width=1e-5)
    with pytest.raises(TooLarge, match=r"too narrow for a robot that is [\d.]+ m across; blocks of") as refused:
        PaddedGround.of(narrow, radius)
    least = re.search(r"blocks of ([\d.]+) cm are wide enough", str(refused.value))
    assert least
    ground = PaddedGround.of(replace(narrow, block_width=float(least[1]) / 100), radius)
    assert 1 << 24 < len(ground.heights) < 1 << 27
