"""Worlds of MuJoCo for tests: a robot on the flat ground, or before a single step."""

from __future__ import annotations

from typing import Any

import numpy as np

import rsegen
from rsegen.field.stepfield import StepField
from rsegen.mujoco.turning import turn_gain
from rsegen.mujoco.world import MujocoWorld
from rsegen.robots.lookup import DrivableRobot, robot_of
from rsegen.scene.scene import Scene, compose
from rsegen.simulators.embedded import PlacedRobot
from rsegen.simulators.poses import DROP_HEIGHT, Pose

FLAT = compose(rsegen.Recipe(name="flat", boundary="none"))


def world_of(robot: str | DrivableRobot, scene: Scene = FLAT, at: Pose | None = None, **given: Any) -> MujocoWorld:
    """Return a world with one robot, at the origin by default."""
    placed = PlacedRobot(name="robot", robot=robot_of(robot), start=at or Pose(x=0, y=0, z=DROP_HEIGHT))
    return MujocoWorld(scene, [placed], gains=[turn_gain(placed.robot)], **given)


def step_of(height: float, **recipe: object) -> Scene:
    """Return the scene of a platform of 2 x 2 m, as high as a step, metres."""
    given = rsegen.Recipe(name="step", boundary="none", unit_cm=100 * height, **recipe)  # type: ignore[arg-type]  # named
    levels = np.ones((20, 20), dtype=np.int16)
    frame = np.zeros(levels.shape, dtype=bool)
    field = StepField(levels=levels, frame=frame, block_width=0.1, unit=height, frame_height=0.0)
    return Scene(recipe=given, index=0, field=field)
