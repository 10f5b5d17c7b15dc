"""Predictions: a robot crosses a floor and no wall, a spread has the errors that it states, and ways lead around."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.stats import norm

import rsegen
from rsegen.cli.edge import main
from rsegen.driving.planning import SURE, _way_back, northward, predict_way, predictions, predictor_for
from rsegen.driving.prediction import Prediction, Predictor, spread_drive, until_decided
from rsegen.driving.recording import RobotRun
from rsegen.driving.robot_runs import robot_runs
from rsegen.driving.routes import planned_way
from rsegen.driving.spread import (
    BEARING,
    FIRST,
    FRICTION,
    HEADING,
    HEIGHT,
    MOST,
    POSITION,
    START,
    Mislocated,
    spread_run,
)
from rsegen.errors import NoSimulator, SimulatorFailed
from rsegen.robots.base import ROBOTS
from rsegen.robots.files.sdf_file import from_file
from rsegen.robots.parameters import MOTORS
from rsegen.scene.scene import Scene, compose
from rsegen.simulators.embedded import EMBEDDED
from rsegen.standing.body import Body
from rsegen.standing.lanes import across
from rsegen.standing.lanes import straight as straight_lanes
from tests.robots.urdf_robots import two_wheels_urdf
from tests.support.long import long_unless

pytestmark = pytest.mark.skipif(not EMBEDDED, reason="the capability mujoco is not here")


def scene_of(rows: list[list[int]], unit_cm: float = 5.0, **given: Any) -> Scene:
    """Return the scene of a matrix of levels, its rows from north to south."""
    matrix = rsegen.Matrix(rows=tuple(" ".join(map(str, row)) for row in rows))
    return compose(
        rsegen.Recipe(
            name="given", boundary="none", seed=1, unit_cm=unit_cm, chunk_size=len(rows), obstacles=[matrix], **given
        )
    )


def predictor() -> Predictor:
    """Return what predicts for robots in MuJoCo."""
    found = predictor_for(None)
    assert found is not None
    return found


FLOOR = scene_of([[1] * 8] * 8, unit_cm=0.1)
WALL = scene_of([[6 if i == 4 else 0 for i in range(8)]] * 8)
"""A wall of 30 cm from north to south, 10 cm thick."""

PASSAGE = scene_of([[6 if i == 5 and row > 6 else 0 for i in range(14)] for row in range(14)])
"""A wall whose north half is open."""


def straight(scene: Scene, robot: str = "burger") -> Prediction:
    """Return the prediction of a straight drive."""
    (run,) = robot_runs(scene.field, ROBOTS[robot], "straight", count=1, seed=1)
    return predictor().predict(scene, run)


def ends_early(run: RobotRun, v: float, w: float) -> bool:
    """Return whether the drive of a robot that goes on and turns so, m/s and rad/s, ends within ten seconds."""
    route = until_decided(run, "reaction").route()
    times = np.arange(0, 10, route.period)
    return any(route.is_done(replace(run.start, x=run.start.x + v * t, yaw=run.start.yaw + w * t)) for t in times)


@pytest.mark.parametrize(
    "robot", long_unless(lambda robot: robot == "burger", ["burger", "crawler"], reason="another robot")
)
def test_robots_cross_a_floor_and_no_wall(robot: str) -> None:
    crosses, held = straight(FLOOR, robot), straight(WALL, robot)
    assert (crosses.crossed, crosses.drives, held.crossed, held.drives) == (FIRST, FIRST, 0, FIRST)
    assert crosses.probability > 0.9
    assert held.probability < 0.1
    across = FLOOR.field.extent[0]
    assert all(outcome.path[-1, 0] - outcome.path[0, 0] > across for outcome in crosses.outcomes)
    (end, *_) = held.ends
    assert end.reason.startswith(("gets stuck on its", "tips over"))
    assert -1.0 < end.x < 0.05, "before the wall, which begins at its middle"
    assert crosses.seconds is not None
    assert crosses.seconds > across / ROBOTS[robot].driving_speed
    assert f"crosses with probability {held.probability:.2f} (0 of {FIRST} drives" in str(held)
    assert "; so few cannot prove 0.00);" in str(held)
    assert str(crosses).endswith("; so few cannot prove 1.00)")


def test_a_part_on_a_fixed_joint_of_urdf_has_the_name_of_its_link(tmp_path: Path) -> None:
    """The wall meets the hull of `base`, which hangs on a base_footprint."""
    (tmp_path / "mine.urdf").write_text(two_wheels_urdf())
    (run,) = robot_runs(WALL.field, from_file(tmp_path / "mine.urdf"), "straight", count=1, seed=1)
    (end,) = predictor().tried(WALL, run, 1).ends
    assert end.reason == "gets stuck on its base"


def test_the_same_drive_has_the_same_outcome_and_another_one_other_errors() -> None:
    (run,) = robot_runs(FLOOR.field, ROBOTS["jackal"], "straight", count=1, seed=1)
    first, again, other = (spread_drive(EMBEDDED["mujoco"], FLOOR, run, number, "reaction") for number in (0, 0, 1))
    assert first.path.tobytes() == again.path.tobytes()
    assert np.abs(first.path[0] - other.path[0]).max() > 1e-4


def test_a_spread_has_the_errors_that_it_states() -> None:
    scene = scene_of([[(i + row) % 3 for i in range(30)] for row in range(30)])
    (run,) = robot_runs(scene.field, ROBOTS["jackal"], "straight", count=1, seed=1)
    drives = [spread_run(scene, run, number) for number in range(400)]
    starts = np.array([[erring.start.y - run.start.y, erring.start.yaw] for erring, _ in drives])
    friction = np.log([built.friction for _, built in drives])
    heights = np.concatenate([np.ravel(built.heights) for _, built in drives if built.heights is not None])
    for values, deviation in ((starts[:, 0], START), (starts[:, 1], HEADING), (friction, FRICTION)):
        assert values.std() == pytest.approx(deviation, rel=0.15)
        assert abs(values.mean()) < deviation / 5
    near = heights[np.isfinite(heights)]
    assert 0 < len(near) < len(heights), "blocks that it cannot touch are as drawn"
    assert near.std() == pytest.approx(HEIGHT, rel=0.05)


@pytest.mark.parametrize(
    "group", [range(FIRST), range(FIRST, MOST), range(MOST, 2 * MOST), range(50 * MOST, 51 * MOST)]
)
def test_drives_that_decide_together_have_an_error_in_each_of_its_parts(group: range) -> None:
    """Else six of them may all have more friction than usual, and say that a robot crosses for certain."""
    (run,) = robot_runs(FLOOR.field, ROBOTS["jackal"], "straight", count=1, seed=1)
    errors = []
    for number in group:
        erring, built = spread_run(FLOOR, run, number)
        route = erring.route()
        assert isinstance(route, Mislocated)
        start = (erring.start.y - run.start.y) / START, erring.start.yaw / HEADING
        errors.append((*start, route.aside / POSITION, route.turn / BEARING, np.log(built.friction) / FRICTION))
    parts = np.floor(norm.cdf(errors) * len(group)).astype(int)
    assert np.array_equal(np.sort(parts, axis=0), np.tile(np.arange(len(group))[:, None], 5))
    assert len(np.unique(parts, axis=1).T) == 5, "errors are independent of each other"


@pytest.mark.parametrize(
    ("v", "w", "is_held"),
    [
        (0.0, 0.0, True),
        (0.03, 0.0, False),
        (0.005, 0.0, False),
        (0.003, 0.0, True),
        (0.0, 0.1, False),
        (0.0, 0.01, True),
    ],
)
def test_a_robot_is_held_that_neither_comes_on_nor_turns(v: float, w: float, is_held: bool) -> None:
    (run,) = robot_runs(FLOOR.field, ROBOTS["burger"], "straight", count=1, seed=1)
    assert ends_early(run, v, w) == is_held


@pytest.mark.parametrize(("motors", "seconds"), [("reaction", 3.0), ("classic", 6.0)])
def test_a_robot_whose_motors_do_not_act_back_may_stand_longer(motors: str, seconds: float) -> None:
    (run,) = robot_runs(FLOOR.field, ROBOTS["burger"], "straight", count=1, seed=1)
    route = until_decided(run, motors).route()
    ended = next(number for number in range(200) if route.is_done(run.start))
    assert ended * route.period == pytest.approx(seconds)


def test_a_slow_robot_is_held_by_less() -> None:
    burger = ROBOTS["burger"]
    slow = replace(burger, drive=replace(burger.drive, speed=0.005))
    (run,) = robot_runs(FLOOR.field, slow, "straight", count=1, seed=1)
    assert not ends_early(run, 0.004, 0.0)
    assert ends_early(run, 0.0, 0.0)


def test_a_robot_that_swings_is_not_held() -> None:
    (run,) = robot_runs(FLOOR.field, ROBOTS["burger"], "straight", count=1, seed=1)
    route = until_decided(run, "reaction").route()
    period = route.period
    poses = [replace(run.start, yaw=0.2 * np.sin(2 * np.pi * turn * period / 3.0)) for turn in range(40)]
    assert not any(map(route.is_done, poses)), "after three seconds it has its heading again"


def test_a_robot_that_crosses_by_chance_is_driven_more_often(monkeypatch: pytest.MonkeyPatch) -> None:
    told = iter([True, False] * 10)

    def by_turns(simulator: object, scene: Scene, run: Any, number: int, motors: str) -> rsegen.Outcome:
        path = np.array([[-1.0, 0.0], [float(number), 0.0]])
        return (
            rsegen.Outcome(seconds=3.0, path=path)
            if next(told)
            else rsegen.Outcome(seconds=None, path=path, reason="tips over")
        )

    monkeypatch.setattr("rsegen.driving.prediction.spread_drive", by_turns)
    (run,) = robot_runs(FLOOR.field, ROBOTS["jackal"], "straight", count=1, seed=1)
    found = predictor().predict(FLOOR, run)
    assert (found.crossed, found.drives) == (10, 20)
    assert found.probability == pytest.approx(0.5)
    (end,) = found.ends
    assert (end.reason, end.drives) == ("tips over", 10)
    assert end.x == 9.0, "where a drive ended, in the middle of all"
    assert "cannot prove" not in str(found)


def test_drives_without_a_result_count_neither_way(monkeypatch: pytest.MonkeyPatch) -> None:

    def failing(*given: object) -> rsegen.Outcome:
        raise SimulatorFailed("MuJoCo: the physics failed after 1 s, so this drive has no result")

    (run,) = robot_runs(FLOOR.field, ROBOTS["jackal"], "straight", count=1, seed=1)
    monkeypatch.setattr("rsegen.driving.prediction.spread_drive", failing)
    with pytest.raises(SimulatorFailed, match="none of 6 drives has a result"):
        predictor().predict(FLOOR, run)


def test_a_way_leads_around_what_holds_the_robot() -> None:
    found = predict_way(predictor(), PASSAGE, ROBOTS["jackal"], "safe")
    assert found.probability > 0.9
    assert found.way is not None
    at_wall = found.way.points[np.abs(found.way.points[:, 0] + 0.15).argmin()]
    assert at_wall[1] > 0.1, "north of the wall"
    assert found.way.length is not None
    assert found.way.length > PASSAGE.field.extent[0]


def ways_by_script(
    monkeypatch: pytest.MonkeyPatch,
    crosses: Callable[[int, int], bool],
    drives: int = MOST,
    scene: Scene = PASSAGE,
    robot: tuple[str, str] = ("jackal", MOTORS[0]),
) -> tuple[Prediction, list[bytes], list[tuple[int, int]]]:
    """Return what is found, the ways that were tried, and which drives there were: numbers of the way and of the drive.

    crosses: which drives do; the others end in the middle of their ways
    robot: its kind and its motors
    """
    kind, model = robot
    ways: list[bytes] = []
    driven: list[tuple[int, int]] = []

    def scripted(_simulator: object, _scene: Scene, run: RobotRun, number: int, _motors: str) -> rsegen.Outcome:
        assert run.way is not None
        points = run.way.points.tobytes()
        if points not in ways:
            ways.append(points)
        driven.append((ways.index(points), number))
        if crosses(*driven[-1]):
            return rsegen.Outcome(seconds=9.0, path=run.way.points)
        path = run.way.points[[0, len(run.way.points) // 2]]
        return rsegen.Outcome(seconds=None, path=path, reason="makes no progress")

    monkeypatch.setattr("rsegen.driving.prediction.spread_drive", scripted)
    found = predict_way(replace(predictor(), drives=drives, motors=model), scene, ROBOTS[kind], "safe")
    assert len(set(driven)) == len(driven), "no drive is done twice"
    return found, ways, driven


def test_a_later_way_is_sure_only_by_all_drives(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first way holds the robot, the second one lets it across in the first drives alone, the third always."""
    found, ways, driven = ways_by_script(monkeypatch, lambda way, number: way > 1 or (way == 1 and number < FIRST))
    first, second, third = (sum(way == number for way, _ in driven) for number in range(3))
    assert first == 1
    assert FIRST < second < MOST, "given up before all drives of a spread are done"
    assert third == MOST
    assert found.way is not None
    assert found.way.points.tobytes() == ways[2]
    assert (found.crossed, found.drives) == (MOST, MOST)


def test_a_way_that_failed_once_is_tried_again_where_others_are_worse(monkeypatch: pytest.MonkeyPatch) -> None:
    found, ways, driven = ways_by_script(monkeypatch, lambda way, number: way == 0 and number > 0)
    assert [way for way, _ in driven][:2] == [0, 1], "another one first"
    assert len(ways) > 2
    assert found.way is not None
    assert found.way.points.tobytes() == ways[0]
    assert (found.crossed, found.drives) == (MOST - 1, MOST)


def test_straight_lanes_are_tried_where_a_way_is_not_sure(monkeypatch: pytest.MonkeyPatch) -> None:
    """On level ground a way holds the robot, and so does the lane in the middle; the next lane does not."""
    found, ways, driven = ways_by_script(monkeypatch, lambda way, _number: way == 2, scene=FLOOR)
    assert [sum(way == number for way, _ in driven) for number in range(3)] == [1, 2, MOST]
    lines = [np.frombuffer(way).reshape(-1, 2)[:, 1] for way in ways]
    assert [len(line) for line in lines[1:]] == [2, 2], "lanes are straight"
    across = FLOOR.field.middles()[1]
    assert np.abs([line[0] for line in lines[1:]]).tolist() == np.sort(np.abs(across))[:2].tolist(), "the middle first"
    assert found.way is not None
    assert found.way.crosses, "poses get to its end"
    assert found.way.points.tobytes() == ways[2]
    assert (found.crossed, found.drives) == (MOST, MOST), "chosen by its first drives, which are not enough"


def test_lanes_are_tried_where_the_physics_of_a_way_fail(monkeypatch: pytest.MonkeyPatch) -> None:
    def crosses(way: int, _number: int) -> bool:
        if way == 0:
            raise SimulatorFailed("no numbers")
        return True

    found, ways, driven = ways_by_script(monkeypatch, crosses, scene=FLOOR)
    assert [sum(way == number for way, _ in driven) for number in range(2)] == [FIRST, MOST]
    assert found.way is not None
    assert found.way.points.tobytes() == ways[1]


def test_of_ways_that_cross_now_and_then_the_best_is_found_by_further_drives(monkeypatch: pytest.MonkeyPatch) -> None:
    """The second and the third way are given up alike, with one of three drives; then the third does better."""
    found, ways, _ = ways_by_script(
        monkeypatch, lambda way, number: (way in (1, 2) and number == 1) or (way == 2 and number > 4)
    )
    assert found.way is not None
    assert found.way.points.tobytes() == ways[2]
    assert (found.crossed, found.drives) == (16, MOST)


def test_lanes_are_those_of_the_motors_by_which_the_way_was_planned(monkeypatch: pytest.MonkeyPatch) -> None:
    """Only with motors as Gazebo Classic's does a burger climb a step of 1.2 cm."""
    step = scene_of([[1 if i > 5 else 0 for i in range(8)]] * 8, unit_cm=1.2)
    assert not straight_lanes(step.field, ROBOTS["burger"].body, 0).passed.any()
    burger = ("burger", MOTORS[1])
    found, ways, _ = ways_by_script(monkeypatch, lambda way, _number: way == 1, scene=step, robot=burger)
    assert len(np.frombuffer(ways[1]).reshape(-1, 2)) == 2, "a straight lane is next"
    assert (found.crossed, found.drives) == (MOST, MOST)


def test_lanes_that_poses_do_not_pass_are_tried_only_without_a_way(monkeypatch: pytest.MonkeyPatch) -> None:
    """A passage is north of the middle: all lanes elsewhere end at the wall, and without a passage all do."""
    for scene, is_walled in ((PASSAGE, False), (WALL, True)):
        lanes = straight_lanes(scene.field, ROBOTS["jackal"].body, 0)
        assert lanes.passed.any() != is_walled
        _, ways, _ = ways_by_script(monkeypatch, lambda _way, _number: False, scene=scene)
        lines = [np.frombuffer(way).reshape(-1, 2)[:, 1] for way in ways]
        tried = {line[0] for line in lines if len(line) == 2}
        passed = set(across(scene.field, 0)[lanes.passed].tolist())
        assert tried
        assert tried.isdisjoint(passed) if is_walled else tried <= passed


@pytest.mark.parametrize("drives", [1, 3, 10])
def test_of_fewer_drives_a_way_has_no_more(drives: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """One drive that crosses is not sure, and neither is a way of which one of three or of ten fails."""
    found, ways, driven = ways_by_script(monkeypatch, lambda _way, number: number > 0 or drives == 1, drives)
    assert (found.crossed, found.drives) == (max(drives - 1, 1), drives)
    assert found.probability < SURE
    assert max(number for _, number in driven) < drives
    assert (len(ways) == 1) == (drives == 1), "others are tried where one failed"


def test_where_nothing_crosses_the_search_has_an_end(monkeypatch: pytest.MonkeyPatch) -> None:
    found, ways, driven = ways_by_script(monkeypatch, lambda _way, _number: False)
    assert found.probability < 0.1
    assert 4 < len(ways) <= len(driven) < 2 * MOST
    assert max(sum(way == number for way, _ in driven) for number in range(len(ways))) == FIRST


def test_a_scene_that_is_turned_has_its_north_in_the_east() -> None:
    scene = scene_of([[row * 3 + i for i in range(3)] for row in range(3)])
    turned = northward(scene)
    x, y = scene.field.middles()
    for i, j in np.ndindex(scene.field.shape):
        at = turned.field.middles()
        onto = int(np.abs(at[0] - y[j]).argmin()), int(np.abs(at[1] + x[i]).argmin())
        assert turned.field.heights[onto] == scene.field.heights[i, j]


@pytest.mark.slow
def test_both_sides_are_predicted_each_in_its_own_frame() -> None:
    found = predictions(ROBOTS["jackal"], WALL)
    assert set(found) == {"west_east", "south_north"}
    assert found["west_east"].probability < 0.1
    assert found["south_north"].probability > 0.9
    for outcome in found["south_north"].outcomes:
        assert outcome.path[-1, 1] - outcome.path[0, 1] > WALL.field.extent[1], "from south to north"
    assert predictions(rsegen.StepLimits(climb_cm=5), WALL) == {}


def test_places_of_a_way_of_a_scene_that_was_turned_are_those_of_the_scene() -> None:
    """A robot drives north over one edge, in the north of the map."""
    scene = scene_of([[int(row < 3)] * 16 for row in range(16)], unit_cm=8.0)
    turned = planned_way(northward(scene).field, ROBOTS["crawler"].body)
    way = _way_back(turned)
    assert turned.margin_at is not None
    assert way.margin_at is not None
    edge, length = 0.5, ROBOTS["crawler"].body.length
    assert abs(way.margin_at[1] - edge) < length
    assert abs(turned.margin_at[0] - edge) < length
    assert abs(way.margin_at[0] + turned.margin_at[1]) < 1e-9
    wall = planned_way(northward(WALL).field, ROBOTS["jackal"].body)
    named = replace(wall, drops=((0.1, 0.2), (0.3, 0.4)), slips=(), at=(0.5, 0.6), margin_at=None)
    back = _way_back(named)
    assert (back.drops, back.slips, back.at) == (((-0.2, 0.1), (-0.4, 0.3)), (), (-0.6, 0.5))


def test_workers_change_nothing() -> None:
    scene = scene_of([[(3 * i + 5 * row) % 4 for i in range(10)] for row in range(10)], unit_cm=0.35)
    (run,) = robot_runs(scene.field, ROBOTS["burger"], "straight", count=1, seed=1)
    here, there = (replace(predictor(), workers=workers).predict(scene, run) for workers in (1, 2))
    assert [outcome.reason for outcome in here.outcomes] == [outcome.reason for outcome in there.outcomes]
    assert all(
        one.path.tobytes() == other.path.tobytes() for one, other in zip(here.outcomes, there.outcomes, strict=True)
    )


def test_the_shell_predicts_and_draws(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    obstacle, picture = "random levels=2", tmp_path / "drives.png"
    command = ["predict", "--obstacle", obstacle, "--boundary", "none", "--unit-cm", "1", "--seed", "2"]
    flags = ["--robot", "jackal", "--route", "straight"]
    assert main([*command, *flags, "-o", str(picture), "--json"]) == 0
    told: Mapping[str, Any] = json.loads(capsys.readouterr().out)
    assert (told["robot"], told["crossed"], told["drives"]) == ("jackal", FIRST, FIRST)
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert main([*command, "--route", "random"]) == 2
    assert "route" in capsys.readouterr().err


def test_the_shell_says_what_a_file_leaves_to_chance(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bare = '<link name="imu"/><joint name="j" type="fixed"><parent>base</parent><child>imu</child></joint>'
    file = tmp_path / "jackal.sdf"
    file.write_text(ROBOTS["jackal"].file("jackal", "sim").replace("</model>", f"{bare}</model>"))
    command = ["predict", "--obstacle", "random levels=2", "--boundary", "none", "--unit-cm", "1", "--seed", "2"]
    assert main([*command, "--robot", str(file)]) == 0
    told = capsys.readouterr()
    assert "rse_0000, jackal: crosses with probability 0.9" in told.out
    assert "note: jackal: each link without <inertial> weighs 1 kg, with 1 kg m^2, as SDF has it: imu" in (told.out)


def test_without_a_simulator_a_line_says_so(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(type(EMBEDDED["mujoco"]), "version", lambda _: None)
    with pytest.raises(NoSimulator, match="a prediction needs MuJoCo"):
        rsegen.predict(FLOOR, robot="jackal")
    assert predictions(ROBOTS["jackal"], FLOOR) == {}


def test_a_drive_tells_before_how_surely_it_crosses() -> None:
    told = rsegen.drive(FLOOR, robot="jackal", duration=6, seed=1)
    assert told.prediction is not None
    assert told.robots[0].metrics.crossed is not None
    assert any("crosses with probability 0.9" in line for line in told.report())
    assert told.as_json()["prediction"] == told.prediction.as_json()
    assert rsegen.drive(FLOOR, robot="jackal", duration=1, seed=1, predict=False).prediction is None


def test_a_drive_that_is_too_short_says_how_long_it_takes() -> None:
    told = rsegen.drive(FLOOR, robot="jackal", duration=1, seed=1)
    assert told.prediction is not None
    assert told.prediction.seconds is not None
    (note,) = [note for note in told.notes if "duration" in note]
    assert note.startswith(
        f"jackal_0 had 1 s, and the drives of the prediction that crossed took {told.prediction.seconds:.0f} s;"
    )


def test_the_bar_of_a_drive_that_crosses_ends_at_its_end(capsys: pytest.CaptureFixture[str]) -> None:
    flags = ["--obstacle", "random levels=2", "--unit-cm", "0.1", "--boundary", "none", "--robot", "jackal"]
    assert main(["drive", *flags, "--no-predict", "--duration", "25", "--seed", "1", "--progress", "json"]) == 0
    printed = capsys.readouterr()
    assert "crossed the map after" in printed.out
    bar = [json.loads(line) for line in printed.err.splitlines()]
    assert (bar[0]["done"], bar[0]["total"], bar[0]["unit"]) == (0, 25, "s")
    assert 1 < bar[-1]["done"] == bar[-1]["total"] < 25


def test_the_way_of_a_drive_says_where_the_robot_is_nearest_to_tipping_over() -> None:
    told = rsegen.drive(PASSAGE, robot="jackal", route="way", duration=0.2, seed=1, predict=False)
    assert told.way is not None
    assert told.way.margin_at is not None
    x, y = told.way.margin_at
    assert any(f" from tipping over at {x + 0:.2f}, {y + 0:.2f} m" in line for line in told.report())
    assert told.way.as_json()["margin_at"] == pytest.approx([x, y])


def test_metrics_tell_how_surely_a_robot_gets_across(capsys: pytest.CaptureFixture[str]) -> None:
    obstacle = ["--obstacle", "random levels=2", "--boundary", "none", "--unit-cm", "1", "--seed", "2"]
    command = ["metrics", *obstacle, "--chunk-size", "6"]
    assert main([*command, "--robot", "jackal", "--verify", "--json"]) == 0
    ((told),) = json.loads(capsys.readouterr().out)
    assert told["predictions"]["west_east"]["probability"] > 0.9
    assert told["predictions"]["south_north"]["drives"] == FIRST
    assert main([*command, "--robot", "jackal", "--json"]) == 0
    assert "predictions" not in json.loads(capsys.readouterr().out)[0]


@pytest.mark.parametrize(("motors", "reactions"), [(MOTORS[0], [True]), (MOTORS[1], [True, False])])
def test_motors_that_do_not_act_back_are_the_second_choice_of_plans(
    monkeypatch: pytest.MonkeyPatch, motors: str, reactions: list[bool]
) -> None:
    """Casters are lifted by them over edges that hold them else; planned first are ways that need no such lift."""
    asked: list[bool] = []

    def none(_search: object, body: Body, _best: str) -> None:
        asked.append(body.reaction)

    monkeypatch.setattr("rsegen.driving.planning._Search.try_ways", none)
    predictor = predictor_for(None, motors)
    assert predictor is not None
    found = predict_way(replace(predictor, drives=1), FLOOR, ROBOTS["burger"], "safe")
    assert asked == reactions
    assert found.crossed == 1, "of the straight lanes"
