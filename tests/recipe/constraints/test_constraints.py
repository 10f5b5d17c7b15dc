"""Maps keep to what their recipe asks for, and to nothing else."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import product
from math import ceil
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linear_sum_assignment

import rsegen
from rsegen.cli.edge import main
from rsegen.field.steps import differences
from rsegen.field.traversability import crossing
from rsegen.gazebo.constraint_report import block_warnings, constraint_report, describe_constraints
from rsegen.params.streams import generator
from rsegen.pictures.preview import preview
from rsegen.recipe.constraints import meeting
from rsegen.recipe.constraints.inventory import fitted_to_inventory, nearest_blocks
from rsegen.recipe.constraints.meeting import crossing_caps
from rsegen.recipe.inventory_file import inventory_in
from rsegen.robots.base import ROBOTS
from rsegen.standing import kinds, planner
from rsegen.standing.lanes import driven_lanes, straight
from tests.support.complaints import the_line
from tests.support.long import long_unless
from tests.support.strategies import fields, recipes

BURGER, CRAWLER = (1, 1, 17.8), (20, 20, 53)
RANDOM = (rsegen.Random(levels=5),)


def recipe(**values: object) -> rsegen.Recipe:
    return rsegen.Recipe(**{"seed": 3, "obstacles": RANDOM, **values})  # type: ignore[arg-type]


def crosses(field: rsegen.StepField, climb: float, drop: float, width: float) -> bool:
    climber = rsegen.StepLimits(climb_cm=climb, drop_cm=drop, width_cm=width)
    return all(crossing(field, climber, axis).crosses for axis in (0, 1))


@given(recipes(), st.integers(1, 3))
def test_no_step_is_larger(made: rsegen.Recipe, limit: int) -> None:
    field = rsegen.build(replace(made, max_step=limit), 0)
    assert differences(field).max(initial=0) <= limit
    free = rsegen.build(made, 0)
    if differences(free).max(initial=0) <= limit:
        assert field == free


@given(recipes(), st.floats(0, 3), st.floats(0, 3), st.floats(0, 4))
def test_a_robot_gets_across(made: rsegen.Recipe, climb: float, drop: float, wide: float) -> None:
    made = replace(made, boundary="none")
    robot = climb * made.unit_cm, drop * made.unit_cm, wide * made.block_width_cm
    free, field = rsegen.build(made, 0), rsegen.build(replace(made, crossable_by=robot), 0)
    assert crosses(field, *robot)
    assert (field.levels <= free.levels).all()
    if crosses(free, *robot):
        assert field == free


@pytest.mark.parametrize("limits", [(5, 5), (9, 15), (25, 4)])
def test_a_robot_that_cannot_climb_a_block_gets_a_level_way_at_once(
    limits: tuple[float, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    """In a round per direction, where more rounds would each clear another way and take minutes."""
    counted = Mock(side_effect=crossing_caps)
    monkeypatch.setattr(meeting, "crossing_caps", counted)
    robot = (*limits, 30)
    for index in range(5):
        field = rsegen.build(recipe(chunk_size=20, boundary="none", crossable_by=robot), index)
        assert crosses(field, *robot)
        assert field.levels.any()
    assert counted.call_count <= 5 * 3


@pytest.mark.parametrize("boundary", ["outer", "divided"])
def test_a_robot_gets_across_frames(boundary: str) -> None:
    made = recipe(chunks=(3, 2), boundary=boundary, crossable_by=(10, 10, 53), maps=20)
    for index in made.indices:
        assert crosses(rsegen.build(made, index), 10, 10, 53)
        assert not crosses(rsegen.build(recipe(chunks=(3, 2), boundary=boundary), index), 10, 10, 53)


def test_frames_that_a_path_cannot_go_over_are_refused() -> None:
    with pytest.raises(rsegen.UserError, match=r"crossable_by: the path goes over 5 cm, and the frames are 10 cm high"):
        recipe(crossable_by=(20, 5, 0))
    assert crosses(rsegen.build(recipe(crossable_by=(20, 5, 0), frame_height_cm=5)), 20, 5, 0)
    assert crosses(rsegen.build(recipe(crossable_by=(20, 5, 0), boundary="none")), 20, 5, 0)


@given(fields(), st.lists(st.integers(0, 12), min_size=1, max_size=6), st.integers(0, 99))
def test_no_hole_is_made_while_a_block_is_left_and_levels_are_the_nearest(
    field: rsegen.StepField, owned: list[int], seed: int
) -> None:
    """As an exact solver of assignments has it: the least sum of differences, and with it the least largest one."""
    levels, left = fitted_to_inventory(field, owned, generator(seed, 0, "k"))
    there = np.array([*owned, *[0] * len(left)])[: len(left) - 1]
    assert (left[1:] == there - np.bincount(levels[~field.frame], minlength=len(left))[1:]).all()
    assert (left[1:] >= 0).all()
    designed = field.levels > 0
    assert (levels[~designed] == 0).all()
    stock = np.repeat(np.arange(1, len(left)), there)
    stock = np.concatenate([stock, np.zeros(max(int(designed.sum()) - len(stock), 0), dtype=int)])
    apart = np.abs(field.levels[designed].astype(int)[:, None] - stock)
    least = apart[linear_sum_assignment(apart)].sum()
    differences = np.abs(levels - field.levels)[designed]
    assert differences.sum() == least
    if designed.any():
        nearer = np.where(apart < differences.max(), apart, 10**6)
        assert nearer[linear_sum_assignment(nearer)].sum() > least


def _differences(wished: tuple[int, ...], used: tuple[int, ...]) -> tuple[int, int]:
    """The sum and the largest of the differences between cells and blocks, both in the order of their levels."""
    cells, blocks = (np.repeat(np.arange(len(counts)), counts) for counts in (wished, used))
    apart = np.abs(cells - blocks)
    return int(apart.sum()), int(apart.max())


@pytest.mark.parametrize(
    ("wished", "given_blocks"), [((1, 0, 2, 1, 0), (3, 1, 0, 1, 2)), ((0, 1, 2, 2, 0, 0), (3, 0, 1, 1, 2, 3))]
)
def test_of_equal_sums_the_one_of_the_least_largest_difference_is_taken(
    wished: tuple[int, ...], given_blocks: tuple[int, ...]
) -> None:
    """Of all counts of blocks that there are; fields that are drawn seldom have such a choice."""
    every = product(*(range(count + 1) for count in given_blocks))
    sums = {_differences(wished, used) for used in every if sum(used) == sum(wished)}
    least = min(sums)
    assert any(one[0] == least[0] and one[1] > least[1] for one in sums)
    assert _differences(wished, tuple(nearest_blocks(np.array(wished), np.array(given_blocks)))) == least


@pytest.mark.parametrize(
    ("design", "used"),
    [
        ({"seed": 3, "obstacles": [rsegen.NormalRandom(levels=4)], "inventory": (20, 50, 30)}, 88),
        (
            {
                "seed": 4,
                "boundary": "none",
                "obstacles": [rsegen.NormalRandom(levels=5)],
                "difficulty": 0.7,
                "max_step": 2,
                "inventory": (32, 25, 37, 2),
            },
            87,
        ),
    ],
)
def test_every_cell_that_is_designed_with_a_block_has_one(design: dict[str, Any], used: int) -> None:
    made = rsegen.Recipe(**design)
    designed = rsegen.build(replace(made, inventory=None))
    assert np.count_nonzero(designed.levels) == np.count_nonzero(rsegen.build(made).levels) == used


def test_a_block_that_is_missing_is_replaced_by_the_nearest() -> None:
    matrix = rsegen.Matrix(levels=5, rows=("4 4 4 4",))
    made = rsegen.Recipe(seed=1, chunk_size=1, chunks=(4, 1), boundary="none", obstacles=[matrix])
    scene = rsegen.compose(replace(made, inventory=(1, 0, 1, 1)))
    assert sorted(scene.field.levels.ravel()) == [0, 1, 3, 4]
    assert constraint_report(scene)["inventory"] == {
        "owned": {1: 1, 2: 0, 3: 1, 4: 1},
        "used": {1: 1, 3: 1, 4: 1},
        "missing": {4: 3},
    }
    assert list(block_warnings(scene)) == ["missing blocks, replaced by others: 3 of 40 cm"]


def test_all_of_it_at_once() -> None:
    made = recipe(chunks=(4, 4), max_step=2, crossable_by=(10, 20, 53), inventory=(300, 200, 200, 100), maps=5)
    for index in made.indices:
        field = rsegen.build(made, index)
        assert differences(field).max() <= 2
        assert crosses(field, 10, 20, 53)
        used = field.level_counts()
        assert all(used.get(level, 0) <= there for level, there in enumerate((300, 200, 200, 100), 1))


@pytest.mark.slow
def test_the_proof_is_written_and_measured_on_the_field(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    searches = Mock(wraps=planner.best_way)
    monkeypatch.setattr(kinds, "best_way", searches)
    asked = ["--chunk-size", "5", "--boundary", "none", "--crossable-by", "crawler", "--inventory", "10,8,5,3"]
    assert main(["generate", "--seed", "3", "--obstacle", "random levels=5", *asked, "-o", str(tmp_path)]) == 0
    assert searches.call_count == 2, "one for each axis, though the ways are written to a file and printed"
    told = json.loads((tmp_path / "rse_0000/constraints.json").read_text())
    assert told["crossable_by"]["robot"] == "crawler"
    again = rsegen.load(tmp_path / "rse_0000/recipe.json")
    field = rsegen.build(again)
    for name, axis in (("west_east", 0), ("south_north", 1)):
        assert told["crossable_by"][name]["crosses"]
        assert len(driven_lanes(field, ROBOTS["crawler"].body, axis))
    assert sum(told["inventory"]["used"].values()) <= 25
    assert again.crossable_by == "crawler"


def test_the_constraints_that_the_map_meets_are_reported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    asked = ["--max-step", "1", "--inventory", "1,1,1,1", "--crossable-by", "10,12.5,30"]
    assert main(["generate", "--seed", "3", "--obstacle", "random levels=5", *asked, "-o", str(tmp_path)]) == 0
    said = capsys.readouterr().out
    assert "largest step between neighbours in units: 1, allowed: 1" in said
    assert "a path of steps of 10 cm up and 12.5 cm down, 30 cm wide, leads across from west to east" in said
    assert "warning: blocks missing for the map that the obstacles ask for: " in said
    assert "warning: blocks missing for the map that max_step and crossable_by make of it, replaced by others" in said
    assert "constraints.json" not in said


def test_of_many_maps_it_is_said_where_their_constraints_are_reported(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    where = "how each map meets its constraints: constraints.json in its folder"
    rows = ["generate", "--seed", "3", "--maps", "2", "--obstacle", "random levels=5"]
    assert main([*rows, "--max-step", "1", "-o", str(tmp_path / "limited")]) == 0
    assert where in capsys.readouterr().out.splitlines()
    assert len(list((tmp_path / "limited").glob("*/constraints.json"))) == 2
    assert main([*rows, "-o", str(tmp_path / "free")]) == 0
    assert where not in capsys.readouterr().out.splitlines()


def test_an_inventory_from_a_file(tmp_path: Path) -> None:
    file = tmp_path / "blocks.csv"
    file.write_text("height_cm,count\n10,40\n40,3\n5,9\n\n10,2\n")
    asked = ["--inventory", str(file), "--unit-cm", "5", "--obstacle", "random levels=9", "--seed", "1"]
    assert main(["generate", *asked, "-o", str(tmp_path)]) == 0
    made = rsegen.load(tmp_path / "rse_0000/recipe.json")
    assert made.inventory == (9, 42, 0, 0, 0, 0, 0, 3)
    assert set(rsegen.build(made).level_counts()) <= {0, 1, 2, 8}


def test_an_inventory_with_semicolons(tmp_path: Path) -> None:
    (tmp_path / "blocks.csv").write_text("height_cm;count\n2,5;40\n7,5;3\n")
    assert inventory_in(tmp_path / "blocks.csv", 2.5) == (40, 0, 3)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("10,40\n", "does not begin with the line height_cm,count"),
        ("height_cm,count\n12,40\n", "line 2: a block of 12 cm is not a whole number of units of 10 cm"),
        ("height_cm,count\n0,40\n", "line 2: a block of 0 cm is not a whole number of units of 10 cm"),
        ("height_cm;count\n10;2,5\n", "line 2: '2.5' is not a whole number"),
        ("height_cm,count\n10\n", "line 2: '10' is not a height and a count"),
        ("height_cm,count\n10,-1\n", "line 2: -1 is outside 0..1000000000"),
        ("height_cm,count\nnan,1\n", "line 2: nan is not a finite number"),
        ("height_cm,count\n10,many\n", "line 2: 'many' is not a whole number"),
    ],
)
def test_a_file_that_is_no_inventory(tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str, says: str) -> None:
    file = tmp_path / "blocks.csv"
    file.write_text(text)
    assert main(["generate", "--inventory", str(file), "-o", str(tmp_path / "out")]) == 2
    assert says in the_line(capsys.readouterr().err)
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "unit_cm", "levels", "side"),
    long_unless(
        lambda case: case[0] == "jackal",
        [("burger", 1, 4, 5), ("jackal", 3, 5, 6), ("crawler", 7, 6, 6)],
        reason="a robot more",
    ),
)
def test_a_robot_crosses_the_maps_that_were_made_for_it(kind: str, unit_cm: float, levels: int, side: int) -> None:
    """It does on few of them as they were designed; and as few blocks are lowered as one lane and another one have."""
    rough = recipe(boundary="none", unit_cm=unit_cm, chunk_size=side, obstacles=(rsegen.Random(levels=levels),))
    free, made = (rsegen.build(replace(rough, crossable_by=robot)) for robot in (None, kind))
    body = ROBOTS[kind].body
    assert all(straight(made, body, axis).passed.any() for axis in (0, 1))
    assert not all(straight(free, body, axis).passed.any() for axis in (0, 1))
    assert (made.levels <= free.levels).all()
    lanes = 2 * (2 * ceil(body.width / made.block_width / 2) + 1) * made.shape[0]
    assert (made.levels != free.levels).sum() <= lanes


@pytest.mark.slow
def test_lanes_stay_as_rough_as_a_robot_takes_them() -> None:
    """Of blocks of 2 cm a jackal climbs many, and a few are in its way."""
    rough = recipe(seed=610100, boundary="none", unit_cm=2)
    scene = rsegen.compose(replace(rough, crossable_by="jackal"))
    free, made = rsegen.build(rough), scene.field
    lowered = free.levels > made.levels
    assert (made.levels <= free.levels).all()
    assert 0 < lowered.sum() < 30
    report = constraint_report(scene)["crossable_by"]
    assert report["west_east"]["crosses"]
    assert report["south_north"]["crosses"]
    assert report["roughness"]["on_ways"]["level_0"] < 0.5
    assert report["roughness"]["on_ways"]["mean_step"] > 0.5
    tilts = [report[side]["tilt"] for side in ("west_east", "south_north")]
    ways_of = [ROBOTS["jackal"].crossing(made, axis) for axis in (0, 1)]
    assert tilts == [pytest.approx(way.tilt, abs=1e-4) for way in ways_of]
    assert max(tilts) > 0.05
    said = "\n".join(describe_constraints(scene, constraint_report(scene)))
    assert f"on its ways the jackal tilts by up to {np.degrees(max(tilts)):.0f} degrees" in said


def test_with_more_room_than_usual_lanes_are_level() -> None:
    made = recipe(boundary="none", chunk_size=6, unit_cm=0.1, crossable_by="burger", crossable_room=2)
    usual = rsegen.compose(replace(made, crossable_room=1))
    reports = [constraint_report(scene) for scene in (rsegen.compose(made), usual)]
    report = reports[0]["crossable_by"]
    assert report["roughness"]["on_ways"] == {"mean_step": 0.0, "level_0": 1.0}
    assert report["lowered"]["blocks"] == report["lowered"]["to_level_0"] > 0
    assert reports[1]["crossable_by"]["lowered"]["blocks"] == 0
    across = "by its poses, the burger can get across from west to east and from south to north"
    driven = "; rsegen predict drives it, and says how surely"
    assert f"{across}, on level lanes{driven}" in list(describe_constraints(rsegen.compose(made), reports[0]))
    assert f"{across}{driven}" in list(describe_constraints(usual, reports[1]))


def test_a_path_of_steps_is_said_without_a_robot() -> None:
    scene = rsegen.compose(recipe(boundary="none", chunk_size=6, unit_cm=1, crossable_by=(2, 2, 10)))
    path = (
        "a path of steps of 2 cm up and 2 cm down, 10 cm wide, leads across from west to east and from south to north"
    )
    assert path in list(describe_constraints(scene, constraint_report(scene)))


@pytest.mark.slow
def test_less_room_to_spare_leaves_ways_rougher() -> None:
    obstacles = (rsegen.Random(levels=5),)
    made = recipe(seed=2, boundary="none", unit_cm=5, chunk_size=7, obstacles=obstacles, crossable_by="crawler")
    usual, tight = (rsegen.compose(replace(made, crossable_room=room)) for room in (1.0, 0.0))
    lowered = [constraint_report(scene)["crossable_by"]["lowered"]["blocks"] for scene in (usual, tight)]
    assert 0 < lowered[1] < lowered[0]
    reports = [constraint_report(scene) for scene in (usual, tight)]
    assert "room" not in reports[0]["crossable_by"]
    assert reports[1]["crossable_by"]["room"] == 0
    assert all(reports[1]["crossable_by"][side]["crosses"] for side in ("west_east", "south_north"))
    assert "with 0% of the usual room to spare" in "\n".join(describe_constraints(tight, reports[1]))


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "kind", "unit_cm"), [(55500004, "jackal", 3), (264885663, "crawler", 10)])
def test_lanes_are_lowered_until_one_keeps_its_blocks(seed: int, kind: str, unit_cm: float) -> None:
    """On the first map the first two lanes from west to east would both be nearly level, on the other one all lanes."""
    rough = recipe(seed=seed, boundary="none", unit_cm=unit_cm, obstacles=(rsegen.Random(levels=5),))
    made = rsegen.build(replace(rough, crossable_by=kind))
    body = ROBOTS[kind].body
    middle = driven_lanes(made, body, 0)[0]
    y = made.edges()[1]
    under = (y[1:] > middle - body.width / 2) & (y[:-1] < middle + body.width / 2)
    assert (made.levels[:, under] > 0).mean() > 0.5


@pytest.mark.slow
@pytest.mark.long(reason="lanes are lowered in make test")
def test_a_robot_that_climbs_no_block_gets_level_lanes() -> None:
    made = recipe(boundary="none", chunk_size=5, crossable_by="burger")
    report = constraint_report(rsegen.compose(made))["crossable_by"]
    assert report["roughness"]["on_ways"] == {"mean_step": 0.0, "level_0": 1.0}
    assert report["roughness"]["beside"]["mean_step"] > 0


def test_the_roughness_of_ways_is_that_of_their_cells() -> None:
    scene = rsegen.compose(recipe(crossable_by=(10, 20, 10)))
    report = constraint_report(scene)["crossable_by"]
    cells = {tuple(cell) for way in ("west_east", "south_north") for cell in report[way]["cells"]}
    blocks = set(zip(*np.nonzero(~scene.field.frame), strict=True))
    levels = {cell: int(scene.field.levels[cell]) for cell in cells & blocks}
    steps = [abs(level - levels[i + 1, j]) for (i, j), level in levels.items() if (i + 1, j) in levels]
    steps += [abs(level - levels[i, j + 1]) for (i, j), level in levels.items() if (i, j + 1) in levels]
    on_ways = report["roughness"]["on_ways"]
    assert len(steps) > 10
    assert on_ways["mean_step"] == pytest.approx(np.mean(steps), abs=1e-3)
    assert on_ways["level_0"] == pytest.approx(np.mean([level == 0 for level in levels.values()]), abs=1e-3)
    assert report["roughness"]["beside"]["mean_step"] > on_ways["mean_step"]


@pytest.mark.slow
@pytest.mark.long(reason="frames that hold a robot are refused in ratings in make test")
def test_frames_that_a_robot_does_not_get_over_are_refused() -> None:
    with pytest.raises(rsegen.UserError, match="crossable_by: burger cannot cross frames of 10 cm; use boundary"):
        rsegen.build(recipe(chunk_size=5, crossable_by="burger"))
    assert straight(rsegen.build(recipe(chunk_size=5, crossable_by="crawler")), ROBOTS["crawler"].body, 0).passed.any()


def test_a_robot_that_is_unknown(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["generate", "--crossable-by", "buger", "-o", str(tmp_path / "out")]) == 2
    assert "--crossable-by: unknown robot 'buger'; did you mean 'burger'?" in the_line(capsys.readouterr().err)


def test_a_map_of_blocks_higher_than_its_obstacles_is_drawn_and_coloured(tmp_path: Path) -> None:
    made = recipe(inventory=(0, 0, 0, 0, 200, 0))
    scene = rsegen.compose(made)
    assert (made.top_level, made.highest_level) == (4, 5)
    assert set(scene.field.level_counts()) == {0, 5}
    assert scene.colour(5) == scene.colour(4)
    assert len(preview(scene)) > 10_000
    (one,) = rsegen.generate(made, tmp_path).maps
    text = (one.folder / "meshes" / f"{scene.name}.obj").read_text()
    used = {line.split()[1] for line in text.splitlines() if line.startswith("usemtl")}
    assert used <= set((one.folder / "meshes" / f"{scene.name}.mtl").read_text().split())
    assert "level_5" in used
