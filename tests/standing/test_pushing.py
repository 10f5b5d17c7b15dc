"""Forces at contacts balance a robot and leave it some to push on with, as a solver of linear programmes says."""

from __future__ import annotations

from math import acos, cos, degrees, radians, tan

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rsegen.field.stepfield import Array
from rsegen.standing.ground import PaddedGround
from rsegen.standing.lanes import End, drive_lanes, step_of
from rsegen.standing.pushing import SLIDING, _largest_margin, force_margin
from rsegen.standing.settling import outer_radius, settle
from tests.standing.stands import BODIES, cart, field_of

FLAT = field_of(np.zeros((20, 20), int))


def wrenches(seed: int, contacts: int) -> Array:
    """Forces and moments (6, 4 n) along the edges of friction pyramids at random contacts below a robot."""
    rng = np.random.default_rng(seed)
    at = np.concatenate([rng.uniform(-1, 1, (contacts, 2)), rng.uniform(-0.6, -0.2, (contacts, 1))], axis=1)
    normal = np.concatenate([rng.uniform(-0.5, 0.5, (contacts, 2)), np.ones((contacts, 1))], axis=1)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    along = np.array([1.0, 0, 0]) - normal * normal[:, :1]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    across, mu = np.cross(normal, along), rng.uniform(0, 1, (contacts, 1))
    edges = np.concatenate([normal + i * mu * along + j * mu * across for i in (-1, 1) for j in (-1, 1)])
    return np.concatenate([edges, np.cross(np.tile(at, (4, 1)), edges)], axis=1).T


@pytest.mark.slow
@given(seed=st.integers(0, 2**32 - 1), contacts=st.integers(3, 11))
@settings(max_examples=200, deadline=None)
def test_the_largest_margin_is_that_of_another_solver(seed: int, contacts: int) -> None:
    linprog = pytest.importorskip("scipy.optimize", reason="SciPy is not installed").linprog
    columns = wrenches(seed, contacts)
    count, right = columns.shape[1], [0, 0, 1, 0, 0, 0]
    every = np.hstack([columns, np.array([[-1.0], [0], [0], [0], [0], [0]])])
    bounds = [*[(0, None)] * count, (None, None)]
    solved = linprog(c=[*np.zeros(count), -1.0], A_eq=every, b_eq=right, bounds=bounds)
    (found,) = _largest_margin(columns[None])
    if solved.status == 0:
        assert found == pytest.approx(-solved.fun, abs=1e-4)
        return
    assert solved.status == 2
    # What lacks costs a thousand, so a thousandth of the weight may lack.
    helping = np.hstack([every, np.eye(6), -np.eye(6)])
    lacking = linprog(
        c=[*np.zeros(count + 1), *np.ones(12)], A_eq=helping, b_eq=right, bounds=bounds + [(0, None)] * 12
    )
    assert found < 0 or lacking.fun < 2e-3


def test_all_programmes_together_are_those_one_by_one() -> None:
    columns = np.stack([wrenches(seed, 8) for seed in range(60)])
    together = _largest_margin(columns)
    assert together == pytest.approx(np.concatenate([_largest_margin(one[None]) for one in columns]))
    assert (together == SLIDING).any()
    assert (together > 0).any()


@pytest.mark.parametrize("kind", sorted(BODIES))
def test_on_level_ground_no_force_lacks(kind: str) -> None:
    body = BODIES[kind]
    ground = PaddedGround.of(FLAT, outer_radius(body))
    rest = settle(ground, body, np.zeros(8), np.zeros(8), np.arange(8) * np.pi / 4)
    assert (force_margin(ground, body, rest) >= 0).all()
    assert (force_margin(ground, body, rest, is_moving=False) >= 0).all()


@pytest.mark.parametrize("mu", [1.0, 0.5])
@pytest.mark.parametrize("share", [0.85, 1.15])
def test_a_wheel_climbs_a_step_as_high_as_its_friction_says(mu: float, share: float) -> None:
    """At an edge the wheel's contact leans back by an angle a, and pushes on if tan a <= mu."""
    radius = 0.1
    highest = radius * (1 - cos(np.arctan(mu)))
    levels = np.zeros((20, 20), int)
    levels[10:] = 1
    field, body = field_of(levels, share * highest), cart(radius, mu=mu)
    ground = PaddedGround.of(field, outer_radius(body))
    lanes = drive_lanes(ground, body, np.array([-0.3]), np.zeros(1), np.zeros(1), 0.6)
    assert bool(lanes.passed[0]) == (share < 1)
    if share > 1:
        assert lanes.end[0] == End.STUCK
        lean = acos(1 - share * highest / radius)
        assert tan(lean) > mu
        # It is stuck where the wheel meets the edge, sin a of its radius before the axle.
        axle = -0.3 + float(lanes.last[0]) * 0.6 / (round(0.6 / step_of(body)))
        assert axle == pytest.approx(-radius * np.sin(lean), abs=3 * step_of(body))


def test_momentum_carries_a_robot_over_a_little_more() -> None:
    levels = np.zeros((20, 20), int)
    levels[10:] = 1
    highest = 0.1 * (1 - cos(radians(45)))
    field = field_of(levels, 1.05 * highest)
    results = []
    for speed in (0.01, 1.5):
        body = cart(0.1, speed=speed)
        ground = PaddedGround.of(field, outer_radius(body))
        results.append(bool(drive_lanes(ground, body, np.array([-0.3]), np.zeros(1), np.zeros(1), 0.6).passed[0]))
    assert results == [False, True]
    assert degrees(acos(1 - 1.05 * highest / 0.1)) == pytest.approx(46.2, abs=0.1)
