"""A belt that slips up a step: how firmly it then holds sideways is what MuJoCo's models of motors differ in."""

from __future__ import annotations

from rsegen.driving.drive import driven_robot
from rsegen.driving.recording import DriveRecording, record_drive, record_embedded
from rsegen.driving.robot_runs import robot_runs
from rsegen.recipe.codec import decode
from rsegen.robots.lookup import robot_of
from rsegen.scene.scene import compose
from rsegen.simulators.base import Installation
from rsegen.simulators.embedded import EMBEDDED
from rsegen.writing.target_worlds import world_of

STEP = {
    "name": "half",
    "unit_cm": 3,
    "friction": 0.3,
    "chunks": [1, 2],
    "boundary": "none",
    "obstacles": [{"kind": "matrix", "rows": [*["0 0 0 1 1 1 1 1 1 1"] * 10, *["0 0 0 0 0 0 0 0 0 0"] * 10]}],
}
"""A step of 3 cm in front of one belt, and none in front of the other."""

SECONDS = 7.0


def test_a_belt_that_slips_holds_sideways_in_classic_as_in_mujoco_with_its_motors(gazebo_classic: Installation) -> None:
    scene = compose(decode(STEP), 0)
    (run,) = robot_runs(scene.field, robot_of("crawler"), "straight", count=1, seed=1)
    with world_of(scene, None).on_disk() as file:
        recordings = {"Classic": record_drive(gazebo_classic, file, [run], SECONDS)}
    for motors in ("classic", "reaction"):
        recordings[motors] = record_embedded(EMBEDDED["mujoco"], scene, [run], SECONDS, motors=motors)

    def crossed_and_turned(recording: DriveRecording) -> tuple[bool, float]:
        drive = driven_robot(run, scene, recording, "straight")
        rows = drive.trajectory.rows
        assert rows[rows[:, 0] <= 2, 3].max() > 0.005  # it is on the step
        return drive.metrics.crossed is not None, float(abs(rows[rows[:, 0] <= 2, 6]).max())

    found = {name: crossed_and_turned(recording) for name, recording in recordings.items()}
    assert [found[name][0] for name in ("Classic", "classic", "reaction")] == [True, True, False]
    assert max(found["Classic"][1], found["classic"][1]) < 0.05
    assert found["reaction"][1] > 0.08
