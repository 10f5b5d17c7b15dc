"""The factor by which a robot's sides must run faster than its separation says, to turn at the commanded rate.

A robot that skids turns less than its wheels roll, and a wide wheel turns on its outer edge. The gain is measured, once
for each robot and process, in this very simulator: the robot turns on flat ground at half of its turn rate, and the
gain is the commanded angle over the turned one; then once more with that gain, as skidding need not be linear. By
statics it is 1 + (L / B)^2 for four thin wheels, L apart along the robot and B across. Cost: two simulated seconds or
twice that, a tenth of a second of CPU. What breaks it: a ground of less friction, on which the gain is another one.
"""

from __future__ import annotations

from functools import lru_cache

from rsegen.errors import SimulatorFailed
from rsegen.mujoco.settings import STEP
from rsegen.mujoco.world import MujocoWorld
from rsegen.recipe.recipe import Recipe
from rsegen.robots.lookup import DrivableRobot
from rsegen.scene.scene import compose
from rsegen.simulators.embedded import PlacedRobot
from rsegen.simulators.poses import DROP_HEIGHT, Pose, wrapped

ROBOT = "robot"
"""The name of a robot that is alone on the ground."""

_SETTLES, _TURNS = 0.5, 2.0
"""Seconds in which the robot comes down and begins to turn, and in which its turn is measured."""

_LOOK = 0.05
"""Seconds between two looks, within which no robot turns by half of a turn."""

_GAINS = (0.5, 8.0)
"""Gains that are believed: a robot that does not turn on flat ground has none."""

_TURNS_AS_TOLD, _ROLLS = 0.01, 0.005
"""Share by which a measured turn may be off, and by which a gain may differ from 1, of wheels that roll, and be 1."""

_MOST = 3
"""Measurements at most."""


@lru_cache(maxsize=64)
def turn_gain(robot: DrivableRobot) -> float:
    """Return the gain of a robot; 1 for wheels that do not skid, and for a robot that hardly turns."""
    w, gain = robot.turn / 2, 1.0
    for _ in range(_MOST):
        try:
            turned = _turned(robot, w, gain)
        except SimulatorFailed:
            return 1.0
        missing = w * _TURNS / turned if turned > 0 else 0.0
        gain *= missing
        if not _GAINS[0] <= gain <= _GAINS[1]:
            return 1.0
        if abs(missing - 1) < _TURNS_AS_TOLD:
            break
    return gain if abs(gain - 1) > _ROLLS else 1.0


def _turned(robot: DrivableRobot, w: float, gain: float) -> float:
    """Return the radians that a robot turns within _TURNS on flat ground at a commanded rate, with a gain."""
    world = on_flat_ground(robot, gain)
    world.drive(ROBOT, robot, 0.0, w)
    world.step(round(_SETTLES / STEP))
    return turned_within(world, _TURNS)


def on_flat_ground(robot: DrivableRobot, gain: float = 1.0) -> MujocoWorld:
    """Return a world of flat ground with a robot at the origin."""
    flat, start = compose(Recipe(name="flat", boundary="none")), Pose(x=0, y=0, z=DROP_HEIGHT)
    return MujocoWorld(flat, [PlacedRobot(name=ROBOT, robot=robot, start=start)], gains=[gain])


def turned_within(world: MujocoWorld, seconds: float) -> float:
    """Simulate for some seconds, and return the radians by which the robot has turned, counterclockwise."""
    before, turned = world.poses()[ROBOT].yaw, 0.0
    for _ in range(round(seconds / _LOOK)):
        world.step(round(_LOOK / STEP))
        now = world.poses()[ROBOT].yaw
        turned += wrapped(now - before)
        before = now
    return turned
