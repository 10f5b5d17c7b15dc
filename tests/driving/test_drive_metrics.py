"""Metrics of tracks that are known by heart, and incidents that no track may hide."""

from __future__ import annotations

import json
from dataclasses import asdict, replace
from math import pi
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from rsegen.driving.drive_metrics import (
    Course,
    DriveMetrics,
    Incident,
    Trajectory,
    drive_metrics,
    possible_part,
)

T = np.round(np.arange(0, 10.01, 0.05), 3)
SIZE = (0.2, 0.1, 0.2)
"""Of a robot whose diagonal is 0.3 m."""
MAP = Course(extent=(2.0, 1.0), top=0.3, finish_x=1.1)
"""Two metres long, a metre wide, with blocks up to 0.3 m."""


def trajectory(x: np.ndarray, **columns: np.ndarray | float) -> Trajectory:
    names = ("y", "z", "roll", "pitch", "yaw")
    columns_of = np.broadcast_arrays(T, x, *(columns.get(name, 0.0) for name in names))
    return Trajectory(rows=np.stack(columns_of, axis=1).astype(float))


def measured(track: Trajectory, speed: float = 0.4, course: Course = MAP) -> DriveMetrics:
    return drive_metrics(track, speed, SIZE, course)


def told(metrics: DriveMetrics) -> list[str]:
    return [str(incident) for incident in metrics.incidents]


ACROSS = 0.4 * T - 1.3
"""From 0.3 m west of the map to beyond it, after 6.05 s."""


def test_a_way_at_half_a_metre_a_second() -> None:
    found = measured(trajectory(0.5 * T - 1, z=0.01 * T), 0.5, Course(finish_x=2.0))
    assert (found.seconds, found.distance, found.stuck, found.tipped, found.tilt) == (10, 5, 0, 0, 0)
    assert found.crossed == pytest.approx(6.0, abs=0.051)
    assert found.climbed == pytest.approx(0.1)
    assert found.incidents == ()


def test_the_fall_at_the_start_is_no_climb() -> None:
    fall = np.maximum(0.2 - 9.81 / 2 * T**2, 0.0)
    hill = 0.03 * np.exp(-((T - 5) ** 2))
    assert measured(trajectory(0.1 * T, z=fall), 0.1).climbed == 0
    assert measured(trajectory(0.1 * T, z=fall + hill), 0.1).climbed == pytest.approx(0.03, abs=1e-3)
    assert measured(trajectory(0.1 * T, z=0.2 - hill), 0.1).climbed == pytest.approx(0, abs=1e-3)


def test_nothing_is_minus_zero() -> None:
    found = measured(trajectory(0.1 * T, z=np.where(T > 5, -0.0, 0.0)), 0.1)
    assert "-0.0" not in json.dumps(asdict(found))
    found = measured(trajectory(0.1 * T, z=np.full_like(T, -0.0)), 0.1)
    assert "-0.0" not in json.dumps(asdict(found))
    assert "-0," not in "".join(trajectory(0.1 * T, z=-1e-6).csv())


def test_a_way_that_ends_before_the_far_side_did_not_cross() -> None:
    found = measured(trajectory(np.minimum(0.5 * T, 2.0)), 0.5, Course(finish_x=2.5))
    assert found.crossed is None
    assert found.stuck == 6
    assert measured(trajectory(0.5 * T), 0.5, Course()).crossed is None


def test_a_robot_that_waits_beyond_the_map_is_not_stuck() -> None:
    held = np.where(T < 4, ACROSS, np.maximum(ACROSS - 0.4 * 2, ACROSS[80]))  # for 2 s
    assert measured(trajectory(np.minimum(held, 1.2))).stuck == 2
    assert measured(trajectory(np.minimum(held, 1.2), y=5.0)).stuck == 2  # it went round the map
    assert measured(trajectory(np.minimum(held, 1.05))).stuck > 2


@pytest.mark.parametrize("seconds", [0.05, 0.5, 0.95, 1.0, 1.25, 3.7])
def test_time_stuck_is_exact_in_drives_of_any_length(seconds: float) -> None:
    rows = trajectory(np.zeros_like(T)).rows
    still = Trajectory(rows=rows[rows[:, 0] <= seconds + 1e-9])
    assert measured(still).stuck == pytest.approx(seconds)
    moving = Trajectory(rows=still.rows + np.outer(still.rows[:, 0], [0, 0.4, 0, 0, 0, 0, 0]))
    assert measured(moving).stuck == 0
    assert measured(Trajectory(rows=rows[:1])).stuck == 0


def test_a_robot_that_shakes_at_its_place_is_stuck() -> None:
    assert measured(trajectory(0.01 * (np.arange(len(T)) % 2))).stuck == pytest.approx(10)


def test_a_robot_that_lies_on_its_side_has_tipped_over_and_one_that_gets_up_again_twice() -> None:
    found = trajectory(0.1 * T, roll=np.where(T > 3, pi / 2, 0.0))
    assert measured(found, 0.1).tipped == 1
    assert found.has_tipped
    again = trajectory(0.1 * T, pitch=np.where((T > 3) & (T < 4) | (T > 6) & (T < 7), pi, 0.0))
    assert measured(again, 0.1).tipped == 2
    assert not again.has_tipped
    assert measured(again, 0.1).tilt == pytest.approx(pi, abs=1e-3)


@given(st.floats(-pi, pi), st.floats(-pi / 2, pi / 2), st.floats(-pi, pi))
def test_the_tilt_is_the_angle_between_both_uprights(roll: float, pitch: float, yaw: float) -> None:
    upright = Rotation.from_euler("xyz", [roll, pitch, yaw]).apply([0, 0, 1])  # about fixed axes, as SDF has them
    (tilt,) = Trajectory(rows=np.array([[0, 0, 0, 0, roll, pitch, yaw]])).tilt
    assert tilt == pytest.approx(np.arctan2(np.hypot(*upright[:2]), upright[2]), abs=1e-6)


def test_a_robot_that_drives_over_the_map_crosses_it() -> None:
    hills = 0.15 * (1 + np.sin(3 * T)) * (np.abs(ACROSS) < 1)
    found = measured(trajectory(ACROSS, z=hills, pitch=np.sin(3 * T)))
    assert found.crossed == pytest.approx(6.0, abs=0.051)
    assert found.incidents == ()


@pytest.mark.parametrize(
    ("columns", "incidents"),
    [
        ({"y": 5.0}, ["off the map after 0.8 s: north of it"]),
        ({"y": -0.6 * np.exp(-((T - 3.5) ** 2))}, ["off the map after 3.1 s: south of it"]),
        ({"z": 100.0 * (T > 2)}, ["impossible after 2.05 s: above all blocks by more than its diagonal"]),
        ({"z": np.minimum(0, 2.02 - T)}, ["impossible after 2.15 s: below the ground"]),
        ({"roll": pi}, []),
        ({"roll": np.where((T > 3) & (T < 4), pi / 2, 0)}, []),
        ({"yaw": np.where(T > 5.5, np.nan, 0)}, ["impossible after 5.55 s: its pose is no number"]),
        ({"x": np.where(T > 1, 1.5, ACROSS)}, ["impossible after 1.05 s: up to 2.78 m in 1 s, at a commanded 0.4 m/s"]),
    ],
)
def test_no_other_way_over_the_map_is_a_crossing(columns: dict[str, Any], incidents: list[str]) -> None:
    found = measured(trajectory(columns.pop("x", ACROSS), **columns))
    assert found.crossed is None
    assert told(found) == incidents


@pytest.mark.parametrize(
    "columns",
    [
        {"y": np.where(T > 6, 5.0 * (T - 6) / 4, 0)},
        {"y": 0.3},
        {"roll": np.where(T > 7, pi, 0)},
        {"z": np.clip(T - 1, 0, 0.5)},
    ],
)
def test_what_comes_after_the_crossing_does_not_undo_it(columns: dict[str, Any]) -> None:
    assert measured(trajectory(ACROSS, **columns)).crossed == pytest.approx(6.0, abs=0.051)


def test_a_robot_that_shall_stay_on_the_map_has_left_it_over_any_side() -> None:
    course = replace(MAP, finish_x=None)
    for x, y, side in ((0.4, 0, "east"), (-0.4, 0, "west"), (0, 0.4, "north"), (0, -0.4, "south")):
        (incident,) = measured(trajectory(x * T, y=y * T), course=course).incidents
        assert (incident.kind, incident.reason) == (Incident.OFF, f"{side} of it")
        assert incident.seconds == pytest.approx(2.5 if x else 1.25, abs=0.051)
    assert measured(trajectory(0.2 * np.sin(T), y=0.2), course=course).incidents == ()
    assert measured(trajectory(-3 - 0.1 * T), course=course).incidents == ()  # larger than the map, it was never on it
    assert measured(trajectory(0.1 * T), course=Course()).incidents == ()


def test_figures_end_with_what_cannot_be() -> None:
    """As links of a gram do: 15 m/s, into the ground."""
    flight = np.maximum(T - 0.5, 0)
    track = trajectory(0.2 * T + 15 * flight, z=-50 * flight)
    found = measured(track, 0.22, Course())
    assert found.distance == pytest.approx(0.1)
    assert found.seconds == 0.5
    assert (found.climbed, found.tipped) == (0, 0)
    (incident,) = found.incidents
    assert incident.kind == Incident.IMPOSSIBLE
    assert incident.seconds == pytest.approx(0.55)
    kept, same = possible_part(track, 0.22, SIZE)
    assert same == incident
    assert len(kept.rows) == 11


def test_of_several_things_that_cannot_be_the_first_ends_the_figures() -> None:
    sunk, risen, lost = (T >= 3) & (T < 6), T >= 6, np.where(T >= 8, np.nan, 0.0)
    found = measured(trajectory(ACROSS, z=9.0 * risen - sunk, yaw=lost))
    assert told(found) == ["impossible after 3 s: below the ground"]
    assert found.seconds == 2.95


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("column", range(7))
@pytest.mark.parametrize("row", [0, 1, 100, 200])
def test_poses_that_are_no_numbers_end_the_figures(value: float, column: int, row: int) -> None:
    rows = trajectory(ACROSS).rows
    rows[row, column] = value
    found = measured(Trajectory(rows=rows))
    text = json.dumps(asdict(found), allow_nan=False)
    assert "its pose is no number" in text
    assert found.seconds == pytest.approx(max(row - 1, 0) * 0.05)
    assert found.has(Incident.IMPOSSIBLE)


LEVEL = {"y": 0.01, "z": -0.0044, "yaw": 0.02}


@pytest.mark.parametrize(
    ("lost", "columns", "says"),
    [
        (0.5, LEVEL, "its pose became 0 0 0 0 0 0"),
        (3.1, LEVEL, "its pose became 0 0 0 0 0 0"),  # where it is 0.06 m from the origin anyway
        (3.0, {"y": 0.2, "z": 0.3, "roll": 0.2}, "its pose became 0 0 0 0 0 0"),
    ],
)
def test_a_pose_that_becomes_zero_is_no_drive(lost: float, columns: dict[str, float], says: str) -> None:
    is_lost = lost <= T
    track = trajectory(np.where(is_lost, 0, ACROSS), **{name: np.where(is_lost, 0, at) for name, at in columns.items()})
    found = measured(track)
    assert [incident.kind for incident in found.incidents] == [Incident.IMPOSSIBLE]
    assert f"impossible after {lost:g} s: {says}" in told(found)[0]
    assert found.distance == pytest.approx(0.4 * (lost - 0.05), abs=0.011)


@pytest.mark.parametrize(("jump", "axis"), [(0.9, "x"), (-0.7, "x"), (0.8, "y"), (0.45, "z")])
def test_a_robot_that_is_at_another_place_at_once_is_impossible(jump: float, axis: str) -> None:
    jumped = np.where(T >= 2, jump, 0.0)
    track = trajectory(ACROSS + jumped) if axis == "x" else trajectory(ACROSS, **{axis: jumped})
    assert any(text.startswith("impossible after 2 s: it jumped 0.") for text in told(measured(track)))


def test_a_robot_that_drives_over_the_origin_is_possible() -> None:
    for x in (ACROSS, np.round(0.4 * T - 1.2, 6)):
        assert told(measured(trajectory(x, z=np.where(T < 1, 0.01, 0)), course=Course())) == []
    still = trajectory(np.zeros_like(T))
    assert told(measured(still, course=Course())) == []


def test_falls_slides_and_tips_of_real_robots_are_possible() -> None:
    fall = np.where(T < 2, 0.3, np.maximum(0.3 - 9.81 / 2 * (T - 2) ** 2, 0))
    slide = 0.4 * T + 0.3 * np.clip((T - 2) / 0.2, 0, 1)
    over = np.where(T < 2, 0, pi)
    assert measured(trajectory(slide, z=fall, pitch=over), course=replace(MAP, extent=(9, 9))).incidents == ()
    on_its_end = 0.3 + 0.29 * (T > 1)
    assert measured(trajectory(0.1 * T, z=on_its_end)).incidents == ()


def test_a_model_whose_origin_is_outside_of_its_shapes_is_possible() -> None:
    for z in (-0.4, 1.5):
        assert measured(trajectory(0.1 * T, z=z)).incidents == ()


@given(
    st.lists(st.tuples(*[st.floats(-1e12, 1e12) | st.sampled_from([np.nan, np.inf, 0.0])] * 6), min_size=1, max_size=8)
)
def test_no_row_is_beyond_the_metrics(poses: list[tuple[float, ...]]) -> None:
    rows = np.array([[0.05 * row, *pose] for row, pose in enumerate(poses)])
    found = measured(Trajectory(rows=rows))
    json.dumps(asdict(found), allow_nan=False)
    assert 0 <= found.stuck <= found.seconds + 1e-9
    limit = (3 * 0.4 + 0.3) * max(found.seconds, 1)
    assert found.distance <= limit + 1e-3


def test_a_track_as_csv_is_read_back() -> None:
    found = trajectory(0.123456 * T)
    text = "".join(found.csv())
    assert text.startswith("t,x,y,z,roll,pitch,yaw\n0,0,0,0,0,0,0\n")
    rows = np.loadtxt(text.splitlines()[1:], delimiter=",")
    assert np.allclose(rows, found.rows, atol=1e-4)
