"""Robots with wheels driven over a field in MuJoCo, and the record of their poses, as `record_drive` does in a Gazebo.

Their routes decide at the same poses and times as in a Gazebo, and wheels turn as Gazebo Classic is told to turn them.
All robots are in one world, and may touch each other. Tracks cannot be driven: MuJoCo has no belt that moves.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import astuple
from math import inf
from typing import Any

import numpy as np

from benchmarks.mujoco_robots import STEP, blocks, free_robot, model, motors, pose_of, wheels_of
from rsegen.driving.drive_metrics import COLUMNS, Trajectory
from rsegen.driving.recording import PERIOD, DriveRecording, RobotRun
from rsegen.driving.routes import Motion
from rsegen.errors import SimulatorFailed
from rsegen.field.stepfield import Array, StepField
from rsegen.robots.base import Robot
from rsegen.robots.drives import Wheels
from rsegen.simulators.poses import Pose


def drive_recording(field: StepField, runs: Sequence[RobotRun], seconds: float) -> DriveRecording:
    """Return the recording of robots that drive for `seconds`, or until all routes are done."""
    world = _World(field, runs)
    routes = {run.name: run.route() for run in runs}
    period = min(route.period for route in routes.values())
    rows: dict[str, list[Array]] = {run.name: [] for run in runs}
    world.append_to(rows)
    while world.seconds < seconds - STEP / 2:
        poses = world.poses()
        if all(route.is_done(poses[name]) for name, route in routes.items()):
            break
        world.command({name: route.motion(poses[name]) for name, route in routes.items()})
        for _ in range(round(min(period, seconds - world.seconds) / PERIOD)):
            world.step(round(PERIOD / STEP))
            world.append_to(rows)
    trajectories = {name: Trajectory(rows=np.array(own)) for name, own in rows.items()}
    return DriveRecording(trajectories=trajectories, samples=[], errors=[])


def rim_speeds(drive: Wheels, motion: Motion) -> tuple[float, float]:
    """Return the speeds of the left and right wheels' rims, m/s, as Classic's plug-in makes of the drive's command."""
    aside = motion.w * drive.slip * drive.separation / 2
    return motion.v - aside, motion.v + aside


class _World:
    """A world of MuJoCo with robots at the starts of their runs."""

    def __init__(self, field: StepField, runs: Sequence[RobotRun]) -> None:
        import mujoco

        self._mujoco = mujoco
        self._robots = {run.name: _robot_of(run) for run in runs}
        bodies = [
            free_robot(robot, astuple(run.start), run.name, (*wheels_of(robot).left, *wheels_of(robot).right))
            for run, robot in zip(runs, self._robots.values(), strict=True)
        ]
        driven = [motors(robot, name) for name, robot in self._robots.items()]
        # With several contacts of two shapes MuJoCo 4.0 takes the edge of a block under a wheel for an upright face:
        # the wheel is held at steps that it would roll up. With one contact it has the direction of the edge.
        text = model([blocks(field), *bodies], driven, multiccd=False)
        self._model: Any = mujoco.MjModel.from_xml_string(text)
        self._state: Any = mujoco.MjData(self._model)
        self._wanted = np.zeros(self._model.nu)
        self._most = np.array([_most(robot) for robot in self._robots.values() for _ in _sides(robot)])

    @property
    def seconds(self) -> float:
        return float(self._state.time)

    def poses(self) -> Mapping[str, Pose]:
        states = {name: pose_of(self._mujoco, self._state, name).tolist() for name in self._robots}
        return {name: Pose(**dict(zip(COLUMNS[1:], state, strict=True))) for name, state in states.items()}

    def append_to(self, rows: Mapping[str, list[Array]]) -> None:
        for name, own in rows.items():
            own.append(np.array([round(self.seconds, 3), *pose_of(self._mujoco, self._state, name)]))

    def command(self, motions: Mapping[str, Motion]) -> None:
        wanted = []
        for name, robot in self._robots.items():
            rims = rim_speeds(wheels_of(robot), motions[name])
            wanted += [rims[side] / robot.drive.radius for side in _sides(robot)]
        self._wanted = np.array(wanted)

    def step(self, steps: int) -> None:
        for _ in range(steps):
            self._state.ctrl += np.clip(self._wanted - self._state.ctrl, -self._most, self._most)
            self._mujoco.mj_step(self._model, self._state)
        # MuJoCo would begin anew where a pose is no number.
        if any(warning.number for warning in self._state.warning):
            raise SimulatorFailed("MuJoCo warns of a state or of its memory: see MUJOCO_LOG.TXT")


def _robot_of(run: RobotRun) -> Robot:
    if not isinstance(run.robot, Robot):
        raise TypeError(f"{run.robot.kind} is not an included robot")
    return run.robot


def _sides(robot: Robot) -> Sequence[int]:
    """Return 0 for each left wheel and 1 for each right one, in the order of the motors."""
    drive = wheels_of(robot)
    return [0] * len(drive.left) + [1] * len(drive.right)


def _most(robot: Robot) -> float:
    """Return by how much the speed of a wheel may change in a step, rad/s.

    The drive's acceleration counts, as in Gazebo Sim: a light robot would tip over backwards by the torque of its
    motors. In Classic none acts on its body.
    """
    acceleration = wheels_of(robot).acceleration
    return inf if acceleration is None else acceleration * STEP / robot.drive.radius
