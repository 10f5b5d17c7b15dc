"""The spread of a drive: the errors that differ each time that somebody drives the same robot over the same map.

    run, number --spread_run--> run with its start moved, its position known wrongly; map with errors as built

Every error is drawn from a normal distribution of its own, by the map's seed and the number of the drive, so the same
drive has the same errors wherever it is simulated. The drives that decide a prediction are a Latin hypercube (McKay,
Beckman and Conover 1979), and so are those that follow: each error is once in each of its equally probable parts.

    friction of six drives  |  x  | x   |    x|x    |   x |  x  |
    their headings          |x    |   x | x   |  x  |    x| x   |     which drive is in which part is random

Assume that a robot slips at a sixth of all frictions: six independent drives would miss them once in three times. Or
that half of all headings hold it: they would all end alike once in 32 times. Either would look certain.

No error is fitted to a simulator or a robot:

    START, HEADING      the robot is put down by hand at a mark: within 1 cm and 2 degrees in 95 of 100 cases
    POSITION, BEARING   it knows by its sensors where it is, within some millimetres (Roewekaemper et al., On the
                        position accuracy of mobile robot localization, IROS 2012) and below a degree (Costa et al.,
                        Robust and accurate localization system for mobile manipulators, 2015)
    FRICTION            of one pair of materials differs by some 10 % from place to place and day to day
    HEIGHT              blocks are cut within 1 mm (EN 336, tolerance class 2, for sides up to 100 mm): three deviations

What breaks it: other errors, such as a flat battery, a loose block, wet wood.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import chain, pairwise, repeat
from math import radians
from statistics import NormalDist

import numpy as np

from rsegen.driving.recording import RobotRun
from rsegen.driving.routes import Motion, Route
from rsegen.field.stepfield import Array, StepField
from rsegen.params.streams import generator
from rsegen.scene.scene import Scene
from rsegen.simulators.embedded import AsBuilt
from rsegen.simulators.poses import Pose

START, HEADING = 0.005, radians(1)
"""Metres by which a start is aside, and radians by which it is turned: standard deviations, as all here."""

POSITION, BEARING = 0.005, radians(0.5)
"""Metres to the side, and radians, by which the robot's estimate of its pose is wrong all along a drive."""

FRICTION = 0.1
"""Standard deviation of the logarithm of friction."""

HEIGHT = 0.001 / 3
"""Metres by which a block is higher or lower than drawn."""

FIRST, MOST = 6, 20
"""Drives of a prediction that decide if they all end alike, and drives at most: the probability is then known within
0.2."""

_LEAST = 1e-9
"""Least share of the normal distribution that is drawn: at 0 its value would be infinite."""

_SHORT = 1e-12
"""Squared length, m^2, of a piece of a way that is a point."""

_BESIDE = 0.3
"""Metres next to the outline of a robot up to which blocks differ: what it may touch as it is turned aside."""


def spread_run(scene: Scene, run: RobotRun, number: int) -> tuple[RobotRun, AsBuilt]:
    """Return the drive of a number, from 0 on, out of the spread of a run, and the map as it was built for it."""
    rng = generator(scene.recipe.seed, scene.index, f"drive {number}")
    aside, turned, wrong_aside, wrong_turn, rough = _stratified(scene, number, rng.random(5))
    start = replace(run.start, y=run.start.y + START * aside, yaw=run.start.yaw + HEADING * turned)
    wrong = {"aside": POSITION * wrong_aside, "turn": BEARING * wrong_turn}
    errors = np.where(_near(scene.field, run), HEIGHT * normals(rng, scene.field.shape), np.nan)
    mislocated = replace(run, start=start, route=lambda: Mislocated(route=run.route(), **wrong))
    return mislocated, AsBuilt(heights=errors, friction=float(np.exp(FRICTION * rough)))


def _stratified(scene: Scene, number: int, within: Array) -> list[float]:
    """Return normally distributed errors of a drive out of a Latin hypercube with the drives that decide with it.

    within: (n,), where each error is in its part, 0..1
    """
    # A random permutation for each error says which drive of the group is in which part.
    group = next(group for group in _groups() if number in group)
    rng = generator(scene.recipe.seed, scene.index, f"drives from {group.start}")
    part = rng.random((len(within), len(group))).argsort(axis=1)[:, number - group.start]
    shares = np.clip((part + within) / len(group), _LEAST, 1 - _LEAST)
    return [NormalDist().inv_cdf(share) for share in shares.tolist()]


def _groups() -> Iterator[range]:
    """Yield the numbers of drives that decide together: the first ones, the other ones of a prediction, and so on."""
    begin, sizes = 0, chain((FIRST, MOST - FIRST), repeat(MOST))
    for size in sizes:
        yield range(begin, begin + size)
        begin += size


def normals(rng: np.random.Generator, shape: int | tuple[int, ...]) -> Array:
    """Return normally distributed numbers from uniform ones (Box and Muller 1958), the same in every numpy."""
    size = int(np.prod(shape))
    radius, angle = np.sqrt(-2 * np.log1p(-rng.random(size))), 2 * np.pi * rng.random(size)
    return np.asarray((radius * np.cos(angle)).reshape(shape))


def _near(field: StepField, run: RobotRun) -> Array:
    """Return which blocks the robot may touch on its run, (n_x, n_y): the ones next to its line or its way."""
    points = run.way.points if run.way else np.array([(-field.extent[0], run.start.y), (field.extent[0], run.start.y)])
    reach = float(np.linalg.norm(run.robot.body_or_box.points[:, :2], axis=1).max()) + _BESIDE
    x, y = np.meshgrid(*field.middles(), indexing="ij")
    near = np.zeros(field.shape, bool)
    for start, end in pairwise(points):
        # The distance of each block's middle from the piece, at its nearest point.
        along = end - start
        share = (x - start[0]) * along[0] + (y - start[1]) * along[1]
        share = np.clip(share / max(float(along @ along), _SHORT), 0, 1)
        near |= np.hypot(x - start[0] - share * along[0], y - start[1] - share * along[1]) < reach
    return near


@dataclass(kw_only=True, slots=True)
class Mislocated(Route):
    """The route of a robot that estimates its pose wrongly, by `aside` metres along y and `turn` radians."""

    route: Route
    aside: float
    turn: float

    @property
    def period(self) -> float:  # type: ignore[override]  # not of the class, as its route has it
        """Seconds between decisions."""
        return self.route.period

    def motion(self, at: Pose) -> Motion:
        """Return the motion for the next period."""
        return self.route.motion(replace(at, y=at.y + self.aside, yaw=at.yaw + self.turn))

    def is_done(self, at: Pose) -> bool:
        """Return whether the robot is at the goal, which is seen from outside."""
        return self.route.is_done(at)
