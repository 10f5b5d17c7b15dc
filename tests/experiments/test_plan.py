"""Plans: those that come along, mixed fairly, and refused with their place where they are wrong."""

from __future__ import annotations

import json
import re
from collections import Counter
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pytest

import rsegen
from rsegen import build, load
from rsegen.errors import NoSpot, ParameterError, UserError
from rsegen.experiments.plan import PLANS, ExperimentPlan, TableRow, load_plan, read_plan
from rsegen.experiments.report import published_figures
from rsegen.experiments.run import _robot_files
from rsegen.experiments.trial import refuse_undrivable
from rsegen.experiments.trial_server import placed, runs_of_row, trial_server
from rsegen.field.steps import steps
from rsegen.recipe.examples import EXAMPLES
from rsegen.robots.lookup import robot_of_kind
from rsegen.scene.scene import compose
from rsegen.simulators.embedded import EMBEDDED

ROWS = "rows:\n  - {robot: burger, sizes: [0, 10]}\n"


@pytest.mark.parametrize("name", sorted(PLANS))
def test_every_plan_that_comes_along_is_whole(name: str) -> None:
    plan = load_plan(name)
    assert plan.name == name
    for cell in plan.cells:
        recipe = plan.rows[cell.row].map_of(cell.size, plan.seed)
        assert recipe.grid.shape == (max(cell.size, 10),) * 2
        framed = bool(cell.size) and name == "paper" and plan.rows[cell.row].maps != "random"
        assert recipe.boundary == ("divided" if framed else "none")


SINGLE = ("horizontal_barrier", "diagonal_barrier", "peak")


def test_the_paper_s_plan_has_the_paper_s_rows() -> None:
    """Its tables 1 and 2: an empty world, a single obstacle of each kind on 10 x 10 blocks, then 20 to 80 blocks."""
    plan = load_plan("paper")
    for robot, robots, unit_cm in (("burger", 3, 1), ("crawler", 1, 10)):
        rows = [row for row in plan.rows if row.robot == robot]
        assert {(row.robots, row.unit_cm) for row in rows} == {(robots, unit_cm)}
        worlds = [(size, row.maps, row.levels) for row in rows if published_figures(row) for size in row.sizes]
        high = 5 if robot == "burger" else 10
        assert worlds == [
            (0, "horizontal_barrier", 5),
            *((10, maps, 5) for maps in SINGLE),
            (20, "barriers and peaks", 5),
            *((size, "barriers and peaks", high) for size in (40, 60, 80)),
        ]
        ours = [(size, row.maps, row.levels) for row in rows if not published_figures(row) for size in row.sizes]
        assert ours == [(10, "random", 5), (20, "random", 5), *((size, "random", high) for size in (40, 60, 80))]


@pytest.mark.parametrize("kind", SINGLE)
def test_the_single_obstacles_of_the_paper_s_plan_are_its_figures_1_to_3(kind: str) -> None:
    (row,) = [row for row in load_plan("paper").rows if row.maps == kind and row.robot == "crawler"]
    made, figure = row.map_of(10, seed=3), load(EXAMPLES[kind.replace("_", "-")])
    assert build(made) == build(figure)
    assert build(made).frame.sum() == 44


def test_larger_worlds_have_every_kind_for_every_pallet_along_a_side_and_frames_of_a_unit() -> None:
    for row in load_plan("paper").rows:
        for size in row.sizes:
            made = row.map_of(size, seed=1)
            field = build(made)
            assert field.frame.any() == (size > 0 and row.maps != "random")
            assert row.maps == "random" or not size or field.frame_height == pytest.approx(field.unit)
            if row.maps == "barriers and peaks":
                assert Counter(obstacle.kind for obstacle in made.obstacles) == dict.fromkeys(SINGLE, size // 10)
                assert field.levels.max() == row.levels - 1
                assert (field.levels != build(row.map_of(size, seed=2)).levels).any()


def test_a_single_obstacle_is_on_ten_blocks() -> None:
    with pytest.raises(ParameterError, match="sizes: 20: a single peak is on 10 x 10 blocks"):
        TableRow(maps="peak", sizes=(10, 20))


def test_an_empty_world_has_nothing_whatever_the_maps_of_its_row_have() -> None:
    for recipe in ({"boundary": "outer"}, {"obstacles": [{"kind": "peak", "levels": 5}], "boundary": "divided"}):
        empty = build(TableRow(maps="peak", sizes=(0, 10), recipe=recipe).map_of(0, 1))
        assert not empty.levels.any()
        assert not empty.frame.any()


def test_a_plan_with_more_robots_than_its_smallest_map_holds_is_refused_before_any_trial() -> None:
    rows = [{"sizes": [0, 10]}, {"robot": "crawler", "robots": 9, "sizes": [0, 80, 20]}]
    with pytest.raises(ParameterError, match=r"^rows\[1\].robots: found spots for \d of 9"):
        refuse_undrivable(read_plan("crowd", {"rows": rows}))
    refuse_undrivable(read_plan("alone", {"rows": [{"robot": "crawler", "robots": 1, "sizes": [0, 10]}]}))


def test_an_experiment_with_too_many_robots_names_the_file_and_the_row_in_it(tmp_path: Path) -> None:
    plan = tmp_path / "crowd.yaml"
    plan.write_text("rows: [{sizes: [0], simulator: mujoco}, {robots: 99, sizes: [10]}]\n")
    place = re.escape(f"{plan}: rows[1].robots: found spots for ")
    with pytest.raises(NoSpot, match=f"^{place}"):
        rsegen.experiment(plan, tmp_path / "out", simulator=["mujoco"])
    with pytest.raises(NoSpot, match=r"^rows\[1\].robots: found spots for "):
        rsegen.experiment(load_plan(str(plan)), tmp_path / "out", simulator=["mujoco"])


def test_a_larger_map_without_room_names_the_row_and_its_size() -> None:
    plan = read_plan("crowd", {"rows": [{"robots": 99, "sizes": [10], "simulator": "mujoco"}]})
    server = trial_server(plan, plan.cells[0], 1, EMBEDDED["mujoco"], lambda: None)
    with pytest.raises(NoSpot, match=r"^row 1, 10, real: robots: found spots for "), server:
        pass


@pytest.mark.parametrize(("robot", "robots"), [("jackal", 2), ("crawler", 3), ("burger", 20)])
def test_an_empty_world_has_room_for_all_robots(robot: str, robots: int) -> None:
    row = TableRow(robot=robot, robots=robots, sizes=(0,))
    for seed in (2, 3):
        with pytest.raises(NoSpot):  # not on the ground of 10 x 10 blocks
            runs_of_row(row, compose(row.map_of(0, seed)), seed)
        scene, runs = placed(row, 0, seed)
        assert len(runs) == robots
        assert not scene.field.levels.any()


def test_an_empty_world_of_few_robots_is_as_large_as_the_smallest_map() -> None:
    scene, _ = placed(TableRow(), 0, 1)
    assert scene.field.shape == (10, 10)


@pytest.mark.parametrize("rows", [load_plan("driven").rows, load_plan("quick").rows, (TableRow(),)])
def test_no_step_of_the_default_plans_and_rows_is_too_high_for_their_robots(rows: tuple[TableRow, ...]) -> None:
    for row in rows:
        found = steps(build(row.map_of(80, seed=1)))
        assert found.share_above(robot_of_kind(row.robot).climbs) == 0


def test_half_of_the_steps_of_random_blocks_in_the_paper_s_plan_are_too_high() -> None:
    (row,) = [row for row in load_plan("paper").rows if row.robot == "burger" and row.maps == "random"]
    paper = steps(build(row.map_of(80, seed=1)))
    assert paper.share_above(0.01) == pytest.approx(12 / 25, abs=0.02)


def test_trials_are_mixed_and_each_cell_comes_once_in_every_repeat() -> None:
    plan = ExperimentPlan(name="p", rows=(TableRow(), TableRow(robot="jackal")), repeats=4)
    order = list(plan.order())
    assert Counter(cell for cell, _ in order) == dict.fromkeys(plan.cells, 4)
    assert [repeat for _, repeat in order] == sorted(repeat for _, repeat in order)
    firsts = {order[repeat * len(plan.cells)][0] for repeat in range(4)}
    assert len(firsts) > 1
    assert list(plan.order()) == order


def test_a_map_is_random_in_the_levels_that_the_row_says() -> None:
    field = build(TableRow(levels=10, unit_cm=10).map_of(40, seed=3))
    assert sorted(field.level_counts()) == list(range(10))
    assert field.unit == 0.1
    assert not build(TableRow().map_of(0, seed=3)).levels.any()


@pytest.fixture
def jackal_file(tmp_path: Path) -> str:
    file = tmp_path / "my, own.sdf"
    file.write_text(robot_of_kind("jackal").file("mine", "classic"))
    return str(file)


def test_a_row_may_name_the_file_of_any_robot(jackal_file: str) -> None:
    rows = [{"robot": jackal_file, "robots": 1, "sizes": [0, 10], "speed": 0.3, "size": [0.5, 0.45, 0.3]}]
    plan = read_plan("mine", {"rows": rows})
    assert plan.rows[0].label == "1 my, own.sdf, unit 0.3 cm, 3 levels"
    assert plan.rows[0].model.kind == "mine"
    assert (plan.rows[0].model.speed, plan.rows[0].model.size) == (0.3, (0.5, 0.45, 0.3))
    refuse_undrivable(plan)
    (driven,) = runs_of_row(plan.rows[0], compose(plan.rows[0].map_of(10, 1)), 1)
    assert driven.name == "mine_0"
    again = read_plan("mine", json.loads(json.dumps(asdict(plan))))
    assert again == plan


@pytest.mark.parametrize(
    ("row", "said"),
    [
        ({"robot": "gone.sdf"}, "gone.sdf: "),
        ({"robot": "burger", "speed": 0.2}, "rows[0].speed: is for the robot of a file; 'burger' has its own"),
        ({"robot": "FILE", "wheels": "left,right"}, "left"),
    ],
)
def test_a_robot_that_cannot_be_driven_is_refused_before_any_trial(
    row: dict[str, Any], said: str, jackal_file: str
) -> None:
    row = {**row, "robot": jackal_file if row["robot"] == "FILE" else row["robot"]}
    with pytest.raises(UserError) as refused:
        refuse_undrivable(read_plan("mine", {"rows": [row]}))
    assert said in str(refused.value)


def test_a_changed_file_of_a_robot_is_another_plan(jackal_file: str) -> None:
    plan = read_plan("mine", {"rows": [{"robot": jackal_file}, {}]})
    before = _robot_files(plan)
    Path(jackal_file).write_text(robot_of_kind("jackal").file("other", "classic"))
    assert before.keys() == {"robot_files"}
    assert before != _robot_files(plan)
    assert _robot_files(load_plan("paper")) == {}


def test_a_row_names_its_obstacles_by_their_kinds() -> None:
    obstacles = [{"kind": "peak", "levels": 7}, {"kind": "random", "levels": 3}]
    row = TableRow(maps="horizontal_barrier", sizes=(10,), recipe={"obstacles": obstacles, "mesh": "blocks"})
    assert row.label == "3 burger, unit 0.3 cm, obstacles peak and random, mesh blocks"
    assert row.robots_and_maps == "3 burger, unit 0.3 cm"


def test_a_plan_in_two_simulators_has_each_row_in_both_and_a_table_of_both() -> None:
    plan = ExperimentPlan(name="p", rows=(TableRow(), TableRow(robot="jackal", simulator="classic"), TableRow()))
    both = plan.in_simulators(["sim", "classic"])
    assert [(row.robot, row.simulator) for row in both.rows] == [
        ("burger", "sim"),
        ("burger", "classic"),
        ("jackal", "classic"),
        ("burger", "sim"),
        ("burger", "classic"),
    ]
    assert both.tables == [[0, 1], [2], [3, 4]]
    assert both.in_simulators(["sim"]) == both


def test_a_plan_of_a_file_is_named_after_it(tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_text(ROWS, "utf-8")
    assert load_plan(str(tmp_path / "mine.yaml")).name == "mine"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[]", "not a plan of an experiment"),
        ("rows: 3", "not a plan of an experiment"),
        ("rows: []", "rows: is empty; add a row"),
        ("rows: [3]", "rows[0]: 3 is not a row"),
        (ROWS + "secnds: 3", "unknown key 'secnds'; did you mean 'seconds'?"),
        (ROWS + "paces: [fast]", "paces[0]: 'fast' is not one of real, free"),
        (ROWS + "repeats: 0", "repeats: 0 is outside 1..1000"),
        (
            "rows: [{robot: burgr}]",
            "rows[0].robot: 'burgr' is not one of burger, crawler, jackal, or an SDF, URDF, Xacro or MJCF file",
        ),
        (
            "rows: [{robot: 7}]",
            "rows[0].robot: 7 is not one of burger, crawler, jackal, or an SDF, URDF, Xacro or MJCF file",
        ),
        ("rows: [{robot: a.sdf, speed: -1}]", "rows[0].speed: -1 is outside 0.001..100 m/s"),
        ("rows: [{sizes: [15]}]", "rows[0].sizes: 15 is no multiple of 10 blocks"),
        ("rows: [{sizes: []}]", "rows[0].sizes: [] is not 0..4000 blocks, or a list of these"),
        ("rows: [{colour: red}]", "rows[0]: unknown key of a row 'colour'"),
        ("rows: [{recipe: {chunks: 4}}]", "rows[0].recipe: chunks follows from the sizes of the row; leave it out"),
        ("rows: [{recipe: {chunk_size: 5}}]", "rows[0].recipe: chunk_size follows from the sizes of the row"),
        ("rows: [{recipe: {unit_cm: 5}}]", "rows[0].recipe: unit_cm follows from that of the row; leave it out"),
        ("rows: [{recipe: {seed: 3}}]", "rows[0].recipe: seed follows from that of the plan, plus 1 for each repeat"),
        ("rows: [{recipe: {mesh_type: mutli}}]", "rows[0].recipe.mesh_type: 'mutli' is not one of"),
    ],
)
def test_a_wrong_plan_is_refused_with_its_place(text: str, said: str, tmp_path: Path) -> None:
    (tmp_path / "wrong.yaml").write_text(text, "utf-8")
    with pytest.raises(UserError) as refused:
        load_plan(str(tmp_path / "wrong.yaml"))
    assert str(refused.value).startswith(f"{tmp_path / 'wrong.yaml'}: {said}")


def test_an_unknown_plan_is_refused_with_the_known_ones() -> None:
    with pytest.raises(UserError, match="unknown plan 'papr'; did you mean 'paper'"):
        load_plan("papr")
