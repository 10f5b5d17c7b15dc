"""Predictions of crossings are counted with their rivals, and none that is wrong is left out."""

from __future__ import annotations

import json
from dataclasses import asdict, replace
from typing import Any

import numpy as np
import pytest

from benchmarks import crossings
from benchmarks.crossings import FILE, Drive, best_limit, highest_step, merged, pairs, table
from rsegen.robots.base import ROBOTS
from tests.standing.stands import field_of


def drive(*, foreseen: bool, crosses: bool, step: float = 0.01, **other: Any) -> Drive:
    given: dict[str, Any] = {
        "simulator": "classic",
        "robot": "burger",
        "field": "random, 4 levels",
        "unit_cm": 0.5,
        "seed": 1,
        "line": 0.0,
        "reason": "goes on" if foreseen else "tips over",
        "at": None if foreseen else 0.1,
        "seconds": 8.0 if crosses else None,
        "end_x": 0.7 if crosses else 0.1,
        "turned": 2.0,
        "tipped": 0,
        "incidents": (),
    }
    return Drive(**{**given, **other}, foreseen=foreseen, step=step)


DRIVES = [
    drive(foreseen=True, crosses=True, step=0.005),
    drive(foreseen=True, crosses=True, step=0.005),
    drive(foreseen=True, crosses=False, step=0.02, turned=-40.0),
    drive(foreseen=False, crosses=True, step=0.01),
    drive(foreseen=False, crosses=False, step=0.02, tipped=1),
]


def test_the_table_has_precision_recall_rivals_and_every_wrong_prediction() -> None:
    lines = list(table({"drives": [asdict(each) for each in DRIVES]}))
    assert lines[2] == "| Gazebo Classic | burger | 5 | 3 | 60 % | 60 % | 100 % (1 cm) | 67 % | 67 % |"
    assert "| Gazebo Classic | burger, 0.5 cm | 5 | 3 | 2 | 2 | 1 |" in lines
    assert lines[-2:] == [
        "| Gazebo Classic | burger | crosses | is stopped | 1 |",
        "| Gazebo Classic | burger | tips over | crosses | 1 |",
    ]


OUTCOMES = [(True, True, True), (True, True, False), (True, False, False), (False, False, True), (False, False, False)]
"""A drive: whether it was predicted to cross, and whether it crossed in Classic and in MuJoCo."""

TWICE = [
    drive(foreseen=foreseen, crosses=crosses, line=float(line), simulator=simulator)
    for line, (foreseen, *both) in enumerate(OUTCOMES)
    for simulator, crosses in zip(("classic", "mujoco"), both, strict=True)
]


def test_each_simulator_has_its_rows_and_a_table_says_how_often_they_agree() -> None:
    lines = list(table({"drives": [asdict(each) for each in (*TWICE, drive(foreseen=True, crosses=True, line=9.0))]}))
    assert lines[2].startswith("| Gazebo Classic | burger | 6 | 3 | 83 % |")
    assert lines[3].startswith("| MuJoCo | burger | 5 | 2 | 40 % |")
    row = lines.index(next(line for line in lines if "simulators agree" in line)) + 2
    # The lane that was driven in Classic alone does not count.
    assert lines[row] == "| burger | 5 | 1 | 1 | 1 | 2 | 60 % | 80 % | 40 % | 67 % |"
    assert lines[row + 1] == "\nBy the unit of the blocks:\n"


def test_all_robots_of_two_simulators_have_a_row_of_their_agreement() -> None:
    other = [replace(each, robot="jackal") for each in TWICE[:2]]
    lines = list(table({"drives": [asdict(each) for each in (*TWICE, *other)]}))
    assert "| jackal | 1 | 1 | 0 | 0 | 0 | 100 % | 100 % | 100 % | 100 % |" in lines
    assert "| all | 6 | 2 | 1 | 1 | 2 | 67 % | 83 % | 50 % | 75 % |" in lines


def test_drives_that_were_not_predicted_alike_are_not_compared() -> None:
    with pytest.raises(ValueError, match="predicted otherwise in mujoco"):
        pairs("classic", "mujoco", [TWICE[0], replace(TWICE[1], foreseen=False)])


def test_new_drives_replace_those_of_the_same_robots_in_the_same_simulator() -> None:
    old = [*TWICE, replace(TWICE[1], robot="jackal")]
    record = {"simulators": {"classic": "Classic 1"}, "drives": [asdict(each) for each in old]}
    new = [replace(TWICE[1], line=5.0)]
    found = merged(record, "mujoco", "MuJoCo 2", new)
    assert found["simulators"] == {"classic": "Classic 1", "mujoco": "MuJoCo 2"}
    assert [Drive(**each) for each in found["drives"]] == [*TWICE[::2], *new, old[-1]]


def test_the_record_has_every_robot_on_the_same_lanes_in_both_simulators() -> None:
    found = [Drive(**each) for each in json.loads(FILE.read_text("utf-8"))["drives"]]
    lanes = {name: {one.lane for one in found if one.simulator == name} for name in ("classic", "mujoco")}
    assert lanes["classic"] == lanes["mujoco"]
    assert len(pairs("classic", "mujoco", found)) == len(lanes["classic"]) > 0


def test_mujoco_drives_on_the_lanes_that_are_known_already() -> None:
    pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    scene = crossings._scene("normal, 4 levels", 1.0, 8000)
    lines = [-0.9, -0.4, 0.1, 0.6, 1.1]
    found = list(crossings._driven("mujoco", ROBOTS["jackal"], scene, "normal, 4 levels", lines))
    assert [each.line for each in found] == lines
    assert {each.simulator for each in found} == {"mujoco"}
    assert all(each.crossed for each in found)


def test_a_limit_below_all_steps_is_always_no() -> None:
    lines = list(table({"drives": [asdict(drive(foreseen=True, crosses=False))]}))
    assert "| 100 % (always no) |" in lines[2]


def test_the_best_limit_is_chosen_by_the_outcome() -> None:
    assert best_limit(DRIVES) == (0.01, 5)
    assert best_limit([drive(foreseen=True, crosses=False)]) == (-1.0, 1)


@pytest.mark.parametrize(("line", "width", "step"), [(0.0, 0.15, 0.03), (0.2, 0.05, 0.01), (-0.2, 0.05, 0.02)])
def test_the_highest_step_is_that_below_the_robot_with_the_ground_before_and_after(
    line: float, width: float, step: float
) -> None:
    levels = np.zeros((4, 5), int)
    levels[1:, 4], levels[3, 0], levels[1, 2] = 1, 2, 3
    assert highest_step(field_of(levels), line, width) == pytest.approx(step)


def test_a_drive_has_its_outcome_in_words() -> None:
    assert DRIVES[0].outcome == "crosses"
    assert DRIVES[2].outcome == "is stopped"
    assert DRIVES[4].outcome == "tips over"
