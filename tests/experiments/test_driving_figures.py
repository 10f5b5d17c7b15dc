"""Distances of robots on known ways, and cells that they have been over."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import pi

import numpy as np
import pytest

from rsegen import build
from rsegen.driving.drive_metrics import Trajectory
from rsegen.driving.recording import RobotRun, trajectories
from rsegen.driving.routes import Straight
from rsegen.experiments.plan import TableRow
from rsegen.experiments.trial import covered_share, driving_figures
from rsegen.field.stepfield import StepField
from rsegen.robots.lookup import robot_of_kind
from rsegen.simulators.poses import Pose

T = np.arange(0, 10.01, 0.1)
BURGER = robot_of_kind("burger")


@pytest.fixture(scope="module")
def field() -> StepField:
    """Ten by ten blocks of ten centimetres."""
    return build(TableRow().map_of(10, seed=1))


def track(x: np.ndarray, y: np.ndarray | float = 0.0, yaw: float = 0.0, roll: float = 0.0) -> Trajectory:
    columns = np.broadcast_arrays(T, x, y, 0.0, roll, 0.0, yaw)
    return Trajectory(rows=np.stack(columns, axis=1).astype(float))


def run(name: str) -> RobotRun:
    route = Straight(speed=0.2, turn=1, line=0, goal=9)
    return RobotRun(name=name, robot=BURGER, start=Pose(x=0, y=0, z=0), route=lambda: route)


@dataclass(frozen=True)
class Box:
    """As much of a robot as its footprint is."""

    size: tuple[float, float, float]


@pytest.mark.parametrize(
    ("size", "at", "yaw", "cells"),
    [
        ((0.04, 0.04, 1), (0.05, 0.05), 0.0, 1),
        ((0.04, 0.04, 1), (0.0, 0.05), 0.0, 2),
        ((0.04, 0.04, 1), (0.0, 0.0), 0.3, 4),
        ((0.28, 0.08, 1), (0.05, 0.05), 0.0, 3),
        ((0.28, 0.08, 1), (0.05, 0.05), pi / 2, 3),
        ((0.28, 0.28, 1), (0.05, 0.05), 0.0, 9),
        ((0.04, 0.04, 1), (0.45, -0.45), 0.0, 1),
        ((0.04, 0.04, 1), (0.55, 0.05), 0.0, 0),
        ((0.04, 0.04, 1), (-0.55, 0.05), 0.0, 0),
        ((9, 9, 1), (0.0, 0.0), 0.0, 100),
    ],
)
def test_a_robot_that_stands_is_over_the_cells_below_its_footprint(
    size: tuple[float, float, float], at: tuple[float, float], yaw: float, cells: int, field: StepField
) -> None:
    standing = track(np.full_like(T, at[0]), at[1], yaw)
    assert covered_share(standing, Box(size), field) == pytest.approx(cells / 100)  # type: ignore[arg-type]


def test_a_robot_that_drives_across_is_over_its_lane(field: StepField) -> None:
    crossing = track(np.linspace(-0.6, 0.6, len(T)), 0.05)
    assert covered_share(crossing, Box((0.04, 0.04, 1)), field) == pytest.approx(0.1)  # type: ignore[arg-type]


def test_figures_are_means_over_the_robots(field: StepField) -> None:
    tracks = {"moves": track(0.04 * T), "rests": track(np.zeros_like(T), roll=pi / 2)}
    found = driving_figures(tracks, [run("moves"), run("rests")], field)
    shares = [covered_share(each, BURGER, field) for each in tracks.values()]
    means = {"driven": 0.2, "stuck": 0.5, "tipped": 0.5, "covered": sum(shares) / 2, "off": 0, "impossible": 0}
    assert found == pytest.approx(means, abs=1e-5)
    alone = {"driven": 0.4, "stuck": 0.0, "tipped": 0.0, "covered": None, "off": 0.0, "impossible": 0.0}
    assert driving_figures(tracks, [run("moves")], None) == alone


def test_robots_that_nothing_is_known_of_have_no_figures(field: StepField) -> None:
    assert driving_figures({}, [run("moves")], field) == {}


def test_a_robot_that_flies_or_leaves_the_map_is_counted_and_flies_no_distance(field: StepField) -> None:
    tracks = {
        "flies": track(20 * np.maximum(T - 1, 0)),
        "leaves": track(0.2 * T),
        "stays": track(0.04 * T),
        "is no number": track(np.where(T > 4, np.nan, 0.04 * T)),
    }
    found = driving_figures(tracks, [run(name) for name in tracks], field)
    assert (found["off"], found["impossible"]) == (0.25, 0.5)
    assert found["driven"] == pytest.approx((0 + 2 + 0.4 + 0.16) / 4)
    assert found["covered"] is not None
    assert driving_figures(tracks, [run("leaves")], None)["off"] == 0


@pytest.mark.parametrize(("start", "off"), [(-0.4, 1), (-0.8, 0)])
def test_a_robot_that_left_the_map_before_its_first_pose_is_counted(start: float, off: int, field: StepField) -> None:
    """At full speed the first pose is seconds after the start; a robot larger than the map starts next to it."""
    begun = replace(run("leaves"), start=Pose(x=start, y=0, z=0))
    assert driving_figures({"leaves": track(0.7 + 0.04 * T)}, [begun], field)["off"] == off


@pytest.mark.parametrize("seconds", [0.3, 0.9, 1.4])
def test_robots_of_a_trial_shorter_than_a_second_are_stuck_in_all_of_it(seconds: float, field: StepField) -> None:
    still = Trajectory(rows=track(np.zeros_like(T)).rows[: round(seconds / 0.1) + 1])
    assert driving_figures({"rests": still}, [run("rests")], field)["stuck"] == 1


def test_a_record_becomes_the_trajectories_of_its_robots() -> None:
    pose = [1.0, 2, 3, 0, 0, 0]
    found = trajectories([(0.5, {"a": pose}), (0.6, {"a": pose, "b": pose, "map": pose})], [run("a"), run("b")])
    assert {name: each.rows[:, 0].tolist() for name, each in found.items()} == {"a": [0.5, 0.6], "b": [0.6]}


def test_whether_a_robot_was_stuck_is_not_known_of_poses_seconds_apart() -> None:
    second = np.arange(0, 60, 0.1)
    angle = np.pi * second  # a circle in two seconds
    rows = np.zeros((len(second), 7))
    rows[:, 0], rows[:, 1], rows[:, 2], rows[:, 6] = second, 0.1 * np.cos(angle), 0.1 * np.sin(angle), angle
    circles = Trajectory(rows=rows)
    assert driving_figures({"turns": circles}, [run("turns")], None)["stuck"] == 0
    seldom = driving_figures({"turns": Trajectory(rows=rows[::20])}, [run("turns")], None)
    assert seldom["driven"] == 0
    assert seldom["stuck"] is None
