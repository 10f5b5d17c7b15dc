"""`python -m benchmarks.robot_files FILE ...`: how a robot of a file drives in MuJoCo, or drives or stands in Gazebo.

A robot with a drive is driven straight ahead and in a circle on the bare ground, and straight over a field of random
blocks of three levels, for as long each, by what rsegen finds in its file; in Gazebo Classic one without is spawned,
as rsegen spawn does it, and left alone. A row of a table in Markdown says what was commanded and what came of it.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from math import hypot, pi
from pathlib import Path
from typing import ClassVar

import numpy as np

import rsegen
from rsegen import Random, Recipe
from rsegen.driving.recording import RobotRun, record_drive, record_embedded
from rsegen.driving.routes import Motion, Route
from rsegen.errors import UserError
from rsegen.gazebo import sdf
from rsegen.robots.files.sdf_file import SdfRobot, from_file
from rsegen.simulators.base import SIMULATORS, Installation
from rsegen.simulators.embedded import EmbeddedSimulator, embedded_simulator
from rsegen.simulators.poses import DROP_HEIGHT, Pose
from rsegen.simulators.server import running_server

SECONDS = 12.0
"""Simulated seconds of each drive; the first of a circle is not measured, in which the robot starts."""
TURN = 0.5
"""Turn rate of the circle, rad/s, or the most that the robot does; at half of its driving speed."""
LEAP = 0.2
"""Metres between two looks at a robot, 0.05 s apart, which no robot drives."""
NOTHING_HERE = 3
"""Exit code."""
_PLAIN = Recipe(name="plain", chunk_size=10, boundary="none", seed=1)


@dataclass(frozen=True, kw_only=True, slots=True)
class Steady(Route):
    """Always the same speed and turn rate."""

    name: ClassVar[str] = "steady"
    period: ClassVar[float] = 0.5

    v: float
    w: float

    def motion(self, at: Pose) -> Motion:
        """Return the same for every pose."""
        return Motion(self.v, self.w)


def ahead_and_round(robot: SdfRobot, here: Installation | EmbeddedSimulator) -> tuple[str, str]:
    """Drive a robot ahead and in a circle on the bare ground, in metres and in shares of the commanded turn."""
    v, w = robot.driving_speed, min(TURN, robot.turn)
    routes = {"ahead": (v, 0.0), "round": (v / 2, w)}
    runs = [
        RobotRun(name=name, robot=robot, start=Pose(x=0, y=y, z=DROP_HEIGHT), route=partial(Steady, v=speed, w=rate))
        for y, (name, (speed, rate)) in zip((-5, 5), routes.items(), strict=True)
    ]
    scene = rsegen.compose(_PLAIN)
    with tempfile.TemporaryDirectory() as folder:
        if isinstance(here, Installation):
            world = Path(folder, "ground.world")
            world.write_bytes(b"".join(sdf.utf8(sdf.world(scene, ()))))
            recording = record_drive(here, world, runs, SECONDS)
        else:
            recording = record_embedded(here, scene, runs, SECONDS)
    rows = {name: recording.trajectories[name].rows for name in routes}
    leaps = [np.linalg.norm(np.diff(poses[:, 1:4], axis=0), axis=1) for poses in rows.values()]
    if max(leap.max() for leap in leaps) > LEAP or min(map(len, leaps)) < SECONDS:
        return "it leaps: its parts push each other apart, or its masses are too small", "-"
    came = hypot(*(rows["ahead"][-1, 1:3] - rows["ahead"][0, 1:3]))
    circle = rows["round"][rows["round"][:, 0] >= 1]
    turned = np.unwrap(circle[:, 6])[[0, -1]] @ (-1, 1) / (w * np.ptp(circle[:, 0]))
    return f"{came:.2f} of {v * SECONDS:.2f}", f"{turned:.2f}"


def over_blocks(robot: SdfRobot, unit_cm: float, simulator: str) -> str:
    """Drive a robot straight over blocks of three levels, in metres, and what a drive finds amiss."""
    field = Recipe(
        name="blocks", chunks=(6, 6), boundary="none", seed=1, unit_cm=unit_cm, obstacles=(Random(levels=3),)
    )
    result = rsegen.drive(field, robot=robot, duration=SECONDS, seed=1, simulator=simulator)
    metrics = result.robots[0].metrics
    amiss = [str(incident) for incident in metrics.incidents] + list(result.errors)
    amiss += [f"tipped over {metrics.tipped}x"] if metrics.tipped else []
    amiss += [f"stuck {metrics.stuck:g} s"] if metrics.stuck else []
    said = f"{metrics.distance:.2f} of {robot.driving_speed * SECONDS:.2f} (2 x {unit_cm:g} cm)"
    return "; ".join([said, *amiss])


def standing(robot: SdfRobot, here: Installation) -> str:
    """Spawn a robot on the bare ground; by how much it sinks, tilts, slides and turns meanwhile."""
    with tempfile.TemporaryDirectory() as folder:
        world = Path(folder, "ground.world")
        world.write_bytes(b"".join(sdf.utf8(sdf.world(rsegen.compose(_PLAIN), ()))))
        with running_server(here, world) as server, server.connect() as live:
            live.spawn(robot.file("it", here.backend), Pose(x=0, y=0, z=robot.lift + DROP_HEIGHT))
            live.step(1000)
            first = live.poses()["it"]
            live.step(round(1000 * SECONDS))
            last = live.poses()["it"]
    slid = 1000 * hypot(last.x - first.x, last.y - first.y)
    turned = 180 / pi * abs(last.yaw - first.yaw)
    tilt = 180 / pi * max(abs(last.roll), abs(last.pitch))
    fallen = 1000 * (robot.lift - last.z)
    moved = f"{slid:.1f} mm and {turned:.1f} degrees in {SECONDS:g} s"
    return f"stands {fallen:.1f} mm lower, tilted {tilt:.1f} degrees; creeps {moved}"


def row(
    file: str, wheels: str | None, tracks: str | None, unit_cm: float, here: Installation | EmbeddedSimulator
) -> str:
    """Return the row of a robot; a UserError for one that does not drive in an embedded simulator."""
    robot = from_file(file, wheels, tracks)
    if robot.read_drive is None and isinstance(here, Installation):
        return f"| {file} | {' '.join(robot.spawn_notes(here.backend))} | {standing(robot, here)} | - | - |"
    ahead, turned = ahead_and_round(robot, here)
    blocks = over_blocks(robot, unit_cm, "classic" if isinstance(here, Installation) else here.name)
    return f"| {file} | {' '.join(robot.notes(here.backend))} | {ahead} | {turned} | {blocks} |"


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit code: 0, or 3 where the simulator is not here."""
    options = _options(arguments)
    here = SIMULATORS["classic"].installation() if options.simulator == "classic" else embedded_simulator("mujoco")
    if not here:
        print(f"no {options.simulator} here", file=sys.stderr)
        return NOTHING_HERE
    print("| file | what is read and assumed | ahead, m | turn rate, share | over blocks, m |\n|---|---|---|---|---|")
    for file in options.files:
        try:
            print(row(file, options.wheels, options.tracks, options.unit_cm, here), flush=True)
        except UserError as error:
            print(f"| {file} | {error} | - | - | - |", flush=True)
    return 0


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.robot_files", description=__doc__)
    parser.add_argument("files", nargs="+", metavar="FILE", help="SDF, URDF or Xacro files of robots")
    parser.add_argument("--wheels", metavar="LEFT,RIGHT", help="joints of the wheels, as for rsegen drive")
    parser.add_argument("--tracks", metavar="LEFT,RIGHT", help="links of the tracks, as for rsegen drive")
    parser.add_argument("--unit-cm", type=float, default=1.0, metavar="CM", help="height of a level of the blocks")
    parser.add_argument("--simulator", choices=("mujoco", "classic"), default="mujoco", help="default: mujoco")
    return parser.parse_args(arguments)


if __name__ == "__main__":
    sys.exit(main())
