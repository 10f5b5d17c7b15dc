"""Friction in Gazebo Classic, which acts as in no real robot: it holds across what slips, and turns what has belts."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import ClassVar

import numpy as np
import pytest

from rsegen.driving.drive import driven_robot
from rsegen.driving.recording import DriveRecording, RobotRun, record_drive, record_embedded
from rsegen.driving.robot_runs import robot_runs
from rsegen.driving.routes import Motion, Route
from rsegen.recipe.codec import decode
from rsegen.robots.lookup import robot_of
from rsegen.scene.scene import compose
from rsegen.simulators.base import Installation
from rsegen.simulators.embedded import EMBEDDED
from rsegen.simulators.poses import DROP_HEIGHT, Pose
from rsegen.writing.target_worlds import world_of

HALF = [*["0 0 0 1 1 1 1 1 1 1"] * 10, *["0 0 0 0 0 0 0 0 0 0"] * 10]
"""A step in front of one side of the robot, and none in front of the other."""

SECONDS = 7.0


@pytest.mark.parametrize(("robot", "unit_cm", "friction", "turns"), [("crawler", 3, 0.3, 0.08), ("jackal", 5, 1, 0.15)])
def test_what_slips_holds_sideways_in_classic_as_in_mujoco_with_its_motors(
    gazebo_classic: Installation, robot: str, unit_cm: float, friction: float, turns: float
) -> None:
    recipe = {"name": "half", "unit_cm": unit_cm, "friction": friction, "chunks": [1, 2], "boundary": "none"}
    scene = compose(decode({**recipe, "obstacles": [{"kind": "matrix", "rows": HALF}]}), 0)
    (run,) = robot_runs(scene.field, robot_of(robot), "straight", count=1, seed=1)
    with world_of(scene, None).on_disk() as file:
        recordings = {"Classic": record_drive(gazebo_classic, file, [run], SECONDS)}
    for motors in ("classic", "reaction"):
        recordings[motors] = record_embedded(EMBEDDED["mujoco"], scene, [run], SECONDS, motors=motors)

    def crossed_and_turned(recording: DriveRecording) -> tuple[float | None, float]:
        drive = driven_robot(run, scene, recording, "straight")
        rows = drive.trajectory.rows
        assert rows[rows[:, 0] <= 2, 3].max() > 0.005  # it is on the step
        return drive.metrics.crossed, float(abs(rows[rows[:, 0] <= 2, 6]).max())

    found = {name: crossed_and_turned(recording) for name, recording in recordings.items()}
    assert found["Classic"][0] is not None
    assert found["classic"][0] == pytest.approx(found["Classic"][0], abs=0.15)
    assert max(found["Classic"][1], found["classic"][1]) < turns < found["reaction"][1]


@dataclass(kw_only=True, slots=True)
class Constant(Route):
    """A route of one motion."""

    always: Motion
    period: ClassVar[float] = 0.5

    def motion(self, at: Pose) -> Motion:
        return self.always

    def is_done(self, at: Pose) -> bool:
        return False


MOTIONS = [Motion(0.0, 0.75), Motion(0.1, 0.5), Motion(0.2, 0.5), Motion(0.4, 0.8), Motion(-0.4, 0.5)]


def test_belts_turn_in_classic_as_in_mujoco_with_its_motors(gazebo_classic: Installation) -> None:
    scene = compose(decode({"name": "flat", "boundary": "none"}), 0)
    runs = [
        RobotRun(
            name=f"crawler_{number}",
            robot=robot_of("crawler"),
            start=Pose(x=0, y=4 * number, z=DROP_HEIGHT),
            route=partial(Constant, always=motion),
        )
        for number, motion in enumerate(MOTIONS)
    ]
    with world_of(scene, None).on_disk() as file:
        recordings = [record_drive(gazebo_classic, file, runs, 2.5, contacts=False)]
    recordings += [
        record_embedded(EMBEDDED["mujoco"], scene, runs, 2.5, motors=motors, contacts=False)
        for motors in ("classic", "reaction")
    ]

    def rates(recording: DriveRecording) -> list[float]:
        """Return the rates of turn from half a second on, rad/s."""
        tracks = [recording.trajectories[run.name].rows[10:] for run in runs]
        return [float(np.ptp(np.unwrap(rows[:, 6])) / np.ptp(rows[:, 0])) for rows in tracks]

    real, classic, reaction = map(rates, recordings)
    assert classic == pytest.approx(real, abs=0.02)
    assert real[1] < 0.1 < reaction[1]
