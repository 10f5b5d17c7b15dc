"""One side of a robot slips up a step: Classic's friction then holds it across more firmly than a real one."""

from __future__ import annotations

import pytest

from rsegen.driving.drive import driven_robot
from rsegen.driving.recording import DriveRecording, record_drive, record_embedded
from rsegen.driving.robot_runs import robot_runs
from rsegen.recipe.codec import decode
from rsegen.robots.lookup import robot_of
from rsegen.scene.scene import compose
from rsegen.simulators.base import Installation
from rsegen.simulators.embedded import EMBEDDED
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
