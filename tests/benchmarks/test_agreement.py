"""Simulators are compared on the same lanes, and MuJoCo ends where the record says."""

from __future__ import annotations

from dataclasses import asdict, replace

import pytest

from benchmarks import agreement
from benchmarks.agreement import (
    CLASSIC,
    COURSES,
    FRESH,
    MUJOCO,
    RECORDED,
    SIDES,
    SIM,
    Outcome,
    World,
    climbs,
    loaded,
    outcomes,
    pairs,
    recorded_lanes,
    runs_of,
    summary,
    table,
    text_of,
)
from rsegen.driving.many import wilson
from rsegen.driving.recording import drive_in_steps
from rsegen.simulators.embedded import EMBEDDED
from tests.support.long import long_unless

OUTCOME = Outcome(
    course=FRESH,
    robot="burger",
    field="random, 4 levels",
    unit_cm=0.5,
    seed=91000,
    line=0.0,
    simulator=CLASSIC,
    aside=0.0,
    seconds=6.0,
    end_x=0.7,
    end_y=0.0,
    tipped=0,
)

REPLAYED = [
    ("burger", MUJOCO[0], 0.5),
    ("jackal", MUJOCO[1], 2.0),
    ("crawler", MUJOCO[0], 3.0),
]
"""A field for each robot, and for both models of motors, on which some cross and some do not, if there is one."""


@pytest.mark.parametrize(
    ("robot", "simulator", "unit"), long_unless(lambda case: case[0] == "jackal", REPLAYED, reason="a robot more")
)
def test_mujoco_ends_as_recorded(robot: str, simulator: str, unit: float) -> None:
    pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    kept = [Outcome(**drive) for drive in loaded()["drives"]]
    own = [drive for drive in kept if (drive.robot, drive.simulator, drive.unit_cm) == (robot, simulator, unit)]
    seed = next(drive.seed for drive in own if drive.course == RECORDED)
    world = World(course=COURSES[RECORDED], robot=robot, field=own[0].field, unit_cm=unit, seed=seed)
    found = list(outcomes(simulator, world, {}))
    expected = {drive.line: drive for drive in own if drive.seed == seed and not drive.aside}
    moved = {drive.line: drive for drive in own if drive.seed == seed and drive.aside}
    assert len(found) == len(expected) == COURSES[RECORDED].plans[robot].robots
    # A lane that ends otherwise if its start is moved by 0.5 mm may end otherwise on another machine too.
    steady = [
        drive for drive in found if expected[drive.line].crossed == moved.get(drive.line, expected[drive.line]).crossed
    ]
    assert len(steady) > len(found) / 2
    for drive in steady:
        assert drive.end_x > -0.7, "it drove up to the map at least"
        assert drive.crossed == expected[drive.line].crossed
        assert (drive.tipped > 0) == (expected[drive.line].tipped > 0)
        if drive.seconds is not None:
            assert drive.seconds == pytest.approx(expected[drive.line].seconds, abs=0.5)


def test_a_replayed_robot_touches_the_map_and_moves() -> None:
    pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    world = World(course=COURSES[RECORDED], robot="jackal", field="normal, 4 levels", unit_cm=1.0, seed=8000)
    runs = runs_of(world, world.scene, {}, 0.0)
    simulated = EMBEDDED["mujoco"].world(world.scene, runs)
    drive_in_steps(simulated, runs, 2.0, simulated.step_seconds)
    shares = simulated.shares()[runs[0].name]
    assert sum(shares.values()) > 0.5
    assert {part.partition("::")[0] for part in shares} <= {
        "base",
        *(f"{end}_{side}_wheel" for end in ("front", "rear") for side in ("left", "right")),
    }
    assert simulated.poses()[runs[0].name].x > runs[0].start.x + 0.5


def test_the_record_has_every_lane_of_classic_in_mujoco_too() -> None:
    found = [*recorded_lanes(), *(Outcome(**drive) for drive in loaded()["drives"])]
    for robot, simulator in {(drive.robot, drive.simulator) for drive in found if drive.simulator in MUJOCO}:
        own = [drive for drive in found if drive.robot == robot]
        classic = [drive for drive in own if drive.simulator == CLASSIC and not drive.aside]
        assert len(pairs(own, CLASSIC, simulator)) == len(classic) > 0


def test_a_record_is_the_same_after_it_is_kept() -> None:
    assert text_of(loaded()) == agreement.FILE.read_text("utf-8")


def test_a_row_counts_lanes_that_cross_agree_and_tip() -> None:
    lanes = [replace(OUTCOME, line=float(line)) for line in range(4)]
    other = [replace(lane, simulator=MUJOCO[1], seconds=6.25) for lane in lanes]
    other[3] = replace(other[3], seconds=None, tipped=1)
    moved = [replace(lane, aside=0.0005) for lane in other]
    moved[2] = replace(moved[2], seconds=None)
    record = {"drives": list(map(asdict, [*lanes, *other, *moved])), "climbs": [], "speeds": []}
    rows = [line for line in table(record, []) if line.startswith(f"| {FRESH}")]
    assert rows == [
        "| fresh lanes | burger | Classic, MuJoCo, motors `classic` | 4 | 4, 3 | 3 of 4: 75 % (30 to 95) | 75 % "
        "| 3 of 4 (0, 1 tip) | +0.25 s |  | 3 of 4 |"
    ]


def test_the_interval_of_a_share_is_wilsons() -> None:
    assert wilson(0, 10) == pytest.approx((0.0, 0.278), abs=1e-3)
    assert wilson(81, 263) == pytest.approx((0.255, 0.366), abs=1e-3)  # Newcombe 1998, table I


def test_the_summary_has_a_pair_of_simulators_per_column() -> None:
    lanes = [replace(OUTCOME, line=float(line)) for line in range(4)]
    others = [replace(lane, simulator=name) for lane in lanes for name in (SIM, *MUJOCO)]
    record = {"drives": list(map(asdict, [*lanes, *others])), "climbs": [], "speeds": []}
    _, _, row = summary(record)
    assert row.count("4 of 4: 100 % (51 to 100); by chance 100 %") == 4


def test_steps_that_a_robot_climbs_are_those_up_to_the_first_that_holds_it() -> None:
    steps = [
        {"robot": "jackal", "sides": SIDES[0], "simulator": CLASSIC, "height": height, "climbed": height != 0.03}
        for height in (0.02, 0.03, 0.04)
    ]
    lines = list(table({"drives": [], "climbs": steps, "speeds": []}, []))
    assert "| jackal | both sides | Classic | 2 cm | 3 cm | 2 to 4 cm |" in lines


def test_a_robot_is_upon_a_low_step_and_held_by_a_high_one(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    monkeypatch.setitem(agreement.STEPS, "jackal", agreement.Steps(2.0, range(1, 6, 4), 6))
    assert [(step["height"], step["climbed"]) for step in climbs(MUJOCO[0], "jackal")] == [(0.02, True), (0.1, False)]
    (held,) = [step for step in climbs(MUJOCO[0], "jackal", SIDES[1]) if step["height"] == 0.1]
    assert held["sides"] == SIDES[1]
    assert not held["climbed"]
