"""Starts are counted once, and are good only if the robot stays upright when it is driven."""

from __future__ import annotations

from typing import Any

import pytest

from benchmarks import starts
from benchmarks.starts import Start, _Rested, table
from rsegen.driving.recording import RobotRun
from rsegen.driving.routes import STOP, Motion, Straight
from rsegen.robots.base import ROBOTS
from rsegen.scene.scene import Scene
from rsegen.simulators.base import SIMULATORS, Installation
from rsegen.simulators.poses import Pose

CLASSIC = Installation(simulator=SIMULATORS["classic"], version="11", commands={})


def start(seed: int, *, tilt: float | None = 0.0, upright: bool | None = True, **other: Any) -> Start:
    fall = None if tilt is None else 0.005
    given = {"simulator": "classic", "example": "peak", "robot": "burger", "route": "random", **other}
    return Start(**given, seed=seed, tilt=tilt, fall=fall, upright=upright)


def test_starts_of_several_seeds_that_are_one_pose_are_driven_once(monkeypatch: pytest.MonkeyPatch) -> None:
    driven: list[RobotRun] = []

    def drive(here: Installation, scene: Scene, run: RobotRun) -> tuple[float, float, bool]:
        driven.append(run)
        return 0.0, 0.005, True

    monkeypatch.setattr(starts, "_driven", drive)
    monkeypatch.setattr(starts, "ROBOTS", {"burger": ROBOTS["burger"]})
    found = list(starts.starts(CLASSIC, ["peak"], (1, 2)))
    routes = [(each.robot, each.route, each.seed) for each in found if each.route != "random"]
    assert routes == [("burger", route, 1) for route in ("straight", "way")]
    assert len({run.start for run in driven if "random" in run.name}) == len(driven) - len(routes) == 2


def test_a_map_without_a_place_is_one_trial_that_is_not_driven(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(starts, "_driven", lambda *_: (0.0, 0.005, True))
    monkeypatch.setattr(starts, "ROBOTS", {"crawler": ROBOTS["crawler"]})
    found = list(starts.starts(CLASSIC, ["diagonal-barrier"], (1, 2), ["random"]))
    assert [(each.route, each.tilt, each.upright) for each in found] == [("random", None, None)]


@pytest.mark.parametrize(
    ("found", "level", "good"),
    [
        (start(1), True, True),
        (start(1, upright=False), True, False),
        (start(1, upright=None), True, False),
        (start(1, tilt=6.0), False, False),
        (start(1, tilt=None, upright=None), False, False),
    ],
)
def test_a_start_is_good_if_it_is_level_and_the_robot_stays_upright(found: Start, level: bool, good: bool) -> None:
    assert (found.is_level, found.is_good) == (level, good)


def test_the_table_counts_starts_those_that_are_level_and_those_that_are_good() -> None:
    found = [start(1), start(2, upright=False), start(3, tilt=None, upright=None, example="figure-7")]
    found += [start(1, upright=None, simulator="sim")]
    rows = list(table({"starts": [vars_of(each) for each in found], "simulators": ["any"]}))
    assert rows[2] == "| Gazebo Classic | burger | random | 2 | 2 | 1 | 0.0 degrees | 0.5 cm | figure-7 |"
    assert rows[3] == "| Gazebo Sim | burger | random | 1 | 1 | not driven | 0.0 degrees | 0.5 cm | none |"


def vars_of(found: Start) -> dict[str, Any]:
    return {name: getattr(found, name) for name in Start.__slots__}


def test_a_robot_rests_before_it_drives() -> None:
    route = _Rested(route=Straight(speed=0.2, turn=1, line=0, goal=9))
    motions = [route.motion(Pose(x=0, y=0, z=0)) for _ in range(4)]
    assert motions == [STOP, STOP, Motion(0.2, 0.0), Motion(0.2, 0.0)]
