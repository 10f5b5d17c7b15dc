"""A robot that hardly moves is noted where no block can be the reason, and nobody else is."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from math import inf, nan, pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rsegen
from rsegen.cli.edge import main
from rsegen.driving.drive import DriveResult, drive_notes, driven_robot, frame_notes, solver_notes, still_notes
from rsegen.driving.drive_metrics import Trajectory
from rsegen.driving.plots import trajectory_plot
from rsegen.driving.recording import DriveRecording, RobotRun, send_commands
from rsegen.driving.robot_runs import robot_runs
from rsegen.driving.routes import STOP
from rsegen.robots.files.sdf_file import from_file
from rsegen.robots.lookup import DrivableRobot, robot_of_kind
from rsegen.scene.scene import compose
from rsegen.simulators.base import SIMULATORS, Installation
from rsegen.simulators.embedded import embedded_simulator
from rsegen.simulators.poses import Pose
from tests.robots.two_wheels import ROS_1, two_wheels

SCENE = compose(rsegen.Recipe(name="course", seed=1, boundary="none", obstacles=(rsegen.Random(levels=2),)))
CLASSIC = Installation(simulator=SIMULATORS["classic"], version="11.1.0", commands={})
MUJOCO = embedded_simulator(None)
T = np.arange(0, 10.01, 0.05)
BURGER = robot_of_kind("burger")


def run_of(route: str, model: DrivableRobot = BURGER) -> RobotRun:
    return robot_runs(SCENE.field, model, route, count=1, seed=1)[0]


def driven(run: RobotRun, along: Callable[[np.ndarray], np.ndarray], roll: float = 0.0) -> Trajectory:
    """A robot that comes from its start as far as `along` says."""
    columns = np.broadcast_arrays(T, run.start.x + along(T), run.start.y, run.start.z, roll, 0.0, run.start.yaw)
    return Trajectory(rows=np.stack(columns, axis=1).astype(float))


def notes(run: RobotRun, track: Trajectory, route: str, attempts: int = 1) -> Sequence[str]:
    recording = DriveRecording(trajectories={run.name: track}, samples=[], errors=[], attempts=attempts)
    of_drive = drive_notes(CLASSIC, [run], recording, contacts=False, picture=False)
    return [*of_drive, *still_notes(CLASSIC, [run], recording, route, None)]


@pytest.mark.parametrize(("height", "said"), [(10, "10 cm"), (2.5, "2.5 cm")])
def test_a_frame_that_stops_a_robot_is_named(height: float, said: str) -> None:
    recipe = replace(SCENE.recipe, boundary="outer", frame_height_cm=height)
    framed = compose(recipe)
    run = robot_runs(framed.field, BURGER, "straight", count=1, seed=1)[0]
    gap = -framed.field.extent[0] / 2 - BURGER.size[0] / 2 - run.start.x
    stopped = driven(run, lambda t: np.minimum(0.22 * t, gap))

    def noted(track: Trajectory, on: rsegen.Scene = framed) -> list[str]:
        return list(frame_notes(on, [run], DriveRecording(trajectories={run.name: track}, samples=[], errors=[])))

    assert noted(stopped) == [
        f"the frame, {said} high, stopped burger_0; use robot='crawler', which climbs 10 cm, "
        "or boundary='none', which makes the map without frames"
    ]
    # Not one that moves on, nor one that has not come to it, nor one on a map without a frame.
    assert noted(driven(run, lambda t: np.minimum(0.22 * t, 1))) == []
    assert noted(Trajectory(rows=stopped.rows[:8])) == []
    assert noted(Trajectory(rows=stopped.rows[:0])) == []
    assert noted(stopped, compose(replace(recipe, boundary="none", chunk_size=12))) == []


@pytest.mark.parametrize(
    ("kind", "changes", "said"),
    [
        ("burger", {"frame_height_cm": 30}, "30 cm high, stopped burger_0; use boundary='none', which makes"),
        ("crawler", {"frame_height_cm": 9}, "9 cm high, stopped crawler_0; use boundary='none', which makes"),
        (
            "burger",
            {"frame_height_cm": 5.08, "units": "in"},
            "2 in high, stopped burger_0; use robot='crawler', which climbs 3.937 in,",
        ),
    ],
)
def test_a_robot_that_helps_no_more_is_not_advised(kind: str, changes: dict[str, Any], said: str) -> None:
    framed, robot = compose(replace(SCENE.recipe, boundary="outer", **changes)), robot_of_kind(kind)
    run = robot_runs(framed.field, robot, "straight", count=1, seed=1)[0]
    gap = -framed.field.extent[0] / 2 - robot.size[0] / 2 - run.start.x
    track = driven(run, lambda t: np.minimum(0.22 * t, gap))
    recording = DriveRecording(trajectories={run.name: track}, samples=[], errors=[])
    (note,) = frame_notes(framed, [run], recording)
    assert note.startswith(f"the frame, {said}")


def test_a_robot_that_was_likely_to_cross_and_is_held_in_gazebo_sim_has_a_note_on_its_solver() -> None:
    run = run_of("straight")
    held, on = driven(run, lambda t: np.minimum(0.22 * t, 0.4)), driven(run, lambda t: 0.22 * t)
    crosses, fails = (rsegen.Outcome(seconds=seconds, path=np.zeros((1, 2))) for seconds in (9.0, None))
    told = [rsegen.Prediction(outcomes=(each,) * 6, simulator="MuJoCo", motors="reaction") for each in (fails, crosses)]

    def noted(track: Trajectory, backend: str = "sim", share: int = 1, solver: str = "dantzig") -> list[str]:
        recording = DriveRecording(trajectories={run.name: track}, samples=[], errors=[])
        scene = compose(replace(SCENE.recipe, solver=solver))
        robots = [driven_robot(run, scene, recording, "straight")]
        return list(solver_notes(backend, scene, told[share], robots))

    says = "burger_0 may be held by the solver of contacts; solver='pgs' makes the map with another one"
    assert noted(held) == noted(held, "fortress") == [says]
    assert noted(on) == noted(held, "classic") == noted(held, "mujoco") == noted(held, solver="pgs") == []
    assert noted(held, share=0) == []


def test_a_note_of_a_shell_names_flags(capsys: pytest.CaptureFixture[str]) -> None:
    recipe = ["--obstacle", "random levels=3", "--chunk-size", "3", "--seed", "1"]
    assert main(["drive", *recipe, "--boundary", "outer", "--duration", "4", "--no-predict"]) == 0
    advice = "use --robot crawler, which climbs 10 cm, or --boundary none, which makes the map without frames"
    assert f"note: the frame, 10 cm high, stopped burger_0; {advice}" in capsys.readouterr().out.splitlines()


def test_pictures_and_contacts_are_not_in_what_a_notebook_prints_of_a_drive(tmp_path: Path) -> None:
    result = rsegen.drive(SCENE.recipe, duration=0.2, predict=False, seed=1, picture=True, output=tmp_path / "drive")
    assert len(result.image) > 10_000
    assert len(repr(result)) < 5_000


@pytest.mark.parametrize("route", ["straight", "way"])
def test_a_robot_that_hardly_moves_before_it_reaches_the_map_is_noted(route: str) -> None:
    run = run_of(route)
    said = "burger_0 moved 0.04 m in 10 s, 2.0% of what was commanded, on the level ground before the map: perhaps "
    (note,) = notes(run, driven(run, lambda t: 0.02 * 0.22 * t), route)
    assert note.startswith(said)
    assert "left_axle, right_axle" in note
    (spinning,) = notes(run, driven(run, lambda t: 0.001 * (np.arange(len(t)) % 2)), route)
    assert "moved 0.00 m" in spinning


@pytest.mark.parametrize(
    ("here", "motors", "is_light"),
    [
        (MUJOCO, None, False),
        (MUJOCO, "reaction", False),
        (MUJOCO, "classic", True),
        (CLASSIC, None, True),
        (replace(CLASSIC, simulator=SIMULATORS["sim"]), None, False),
    ],
)
def test_light_wheels_are_doubted_only_where_motors_have_no_torque(
    tmp_path: Path, here: Any, motors: str | None, *, is_light: bool
) -> None:
    (tmp_path / "mine.sdf").write_text(two_wheels(ROS_1).replace("<izz>0.0008</izz>", "<izz>1e-5</izz>"))
    run = run_of("straight", from_file(tmp_path / "mine.sdf"))
    recording = DriveRecording(trajectories={run.name: driven(run, lambda t: 0.001 * t)}, samples=[], errors=[])
    (note,) = still_notes(here, [run], recording, "straight", motors)
    assert "perhaps left_hub, right_hub do not turn" in note
    assert ("its wheels are light" in note) == is_light


@pytest.mark.parametrize("route", ["straight", "way"])
def test_a_robot_that_is_stuck_on_blocks_is_not_accused(route: str) -> None:
    run = run_of(route)
    for metres in (0.15, 0.1, 0.09, 0.06):  # it has reached the blocks, or stands with its front at them
        assert notes(run, driven(run, lambda t, far=metres: np.minimum(0.22 * t, far)), route) == []  # type: ignore[misc]
    assert notes(run, driven(run, lambda t: 0.22 * t), route) == []
    assert notes(run, driven(run, np.zeros_like, roll=pi / 2), route) == []


def test_a_short_drive_is_no_reason_for_a_note() -> None:
    run = run_of("straight")
    track = driven(run, np.zeros_like)
    assert notes(run, Trajectory(rows=track.rows[:19]), "straight") == []


def test_on_a_random_route_a_robot_may_be_stuck_where_it_started() -> None:
    run = run_of("random")
    (note,) = notes(run, driven(run, lambda t: 0.002 * t), "random")
    assert "0.9% of what was commanded: it is stuck where it started, or perhaps" in note
    assert notes(run, driven(run, lambda t: 0.1 * np.sin(t)), "random") == []


def test_the_joints_of_a_file_s_robot_are_named(tmp_path: Path) -> None:
    (tmp_path / "mine.sdf").write_text(robot_of_kind("jackal").file("mine", "classic"))
    run = run_of("straight", from_file(tmp_path / "mine.sdf"))
    note = notes(run, driven(run, np.zeros_like), "straight")[-1]
    assert "perhaps front_left_axle, rear_left_axle, front_right_axle" in note


def test_a_server_that_was_started_again_is_noted() -> None:
    run = run_of("straight")
    assert notes(run, driven(run, lambda t: 0.2 * t), "straight", attempts=3) == [
        "Gazebo Classic 11.1.0 failed and was started again; this is attempt 3"
    ]


def result_of(run: RobotRun, track: Trajectory) -> DriveResult:
    recording = DriveRecording(trajectories={run.name: track}, samples=[], errors=[])
    return DriveResult(
        scene=SCENE,
        simulator=str(CLASSIC),
        route="straight",
        seed=1,
        robots=(driven_robot(run, SCENE, recording, "straight"),),
        errors=(),
        contact_samples=(),
    )


def test_incidents_are_in_the_printed_line_and_in_the_json() -> None:
    run = run_of("straight")
    track = driven(run, lambda t: 0.22 * t + 15 * np.maximum(t - 0.3, 0))
    found = result_of(run, track)
    _, line = found.report()
    what = "impossible after 0.35 s: up to 15.22 m in 1 s, at a commanded 0.22 m/s"
    assert line == f"  burger_0: 0.07 m in 0.3 s, did not cross the map, stuck 0 s; {what}"
    content = json.loads(json.dumps(found.as_json()))
    assert content == found.as_json()
    (told,) = content["robots"]
    assert [{**each, "seconds": 0} for each in told["incidents"]] == [
        {"kind": "impossible", "seconds": 0, "reason": "up to 15.22 m in 1 s, at a commanded 0.22 m/s"}
    ]


def test_a_robot_beside_the_map_does_not_cross_it() -> None:
    run = replace(run_of("straight"), start=Pose(x=-1.2, y=3.0, z=0.0))
    _, line = result_of(run, driven(run, lambda t: 0.3 * t)).report()
    assert "did not cross the map" in line
    assert line.endswith("s: north of it")


@pytest.mark.slow
def test_poses_that_are_no_numbers_are_drawn_and_answered_by_a_stop() -> None:
    run = run_of("way")
    track = driven(run, lambda t: np.where(t > 3, nan, 0.2 * t))
    assert trajectory_plot(SCENE, {"burger_0": track})[:4] == b"\x89PNG"
    assert trajectory_plot(SCENE, {"burger_0": driven(run, lambda t: nan * t)})[:4] == b"\x89PNG"
    sent: list[object] = []

    class World:
        def drive(self, name: str, robot: DrivableRobot, v: float, w: float) -> None:
            sent.append((name, robot.kind, v, w))

    for strange in (nan, inf):
        pose = replace(run.start, yaw=strange, x=strange)
        send_commands(World(), [run], {run.name: run.route()}, {run.name: pose})  # type: ignore[arg-type]  # as much of it
    assert sent == [(run.name, "burger", *STOP)] * 2
