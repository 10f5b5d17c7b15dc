"""A largest step and a stock of blocks together: as many blocks as can be, near the field that was designed."""

from __future__ import annotations

import json
import operator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import rsegen
from rsegen.cli.edge import main
from rsegen.field.steps import differences
from rsegen.gazebo.constraint_report import block_warnings, constraint_report, describe_constraints
from tests.support.complaints import the_line
from tests.support.long import long_unless

COUNTS = (9, 27, 33, 21, 10)
RANDOM = (rsegen.Random(levels=5),)


def recipe(seed: int = 3, **values: object) -> rsegen.Recipe:
    return rsegen.Recipe(seed=seed, **{"obstacles": RANDOM, **values})  # type: ignore[arg-type]


def blocks_used(field: rsegen.StepField) -> int:
    return int(np.count_nonzero(field.levels))


@pytest.mark.parametrize(
    ("inventory", "max_step", "used"),
    [((27, 33, 21, 10), 1, 91), ((0, 0, 50, 50), 2, 100), ((27, 33, 21, 10), 2, 91), ((20, 20, 20, 20), 1, 80)],
)
def test_all_timber_is_used_that_can_be(inventory: tuple[int, ...], max_step: int, used: int) -> None:
    for seed in range(3):
        made = recipe(seed, inventory=inventory, max_step=max_step)
        field, free = rsegen.build(made), rsegen.build(recipe(seed))
        assert blocks_used(field) == used
        assert differences(field).max() <= max_step
        assert all(field.level_counts().get(level, 0) <= there for level, there in enumerate(inventory, 1))
        sorted_along_x = np.sort(field.blocks, axis=None).reshape(field.blocks.shape)
        assert np.abs(field.blocks - free.blocks).mean() < np.abs(sorted_along_x - free.blocks).mean()


@pytest.mark.slow
@given(
    st.lists(st.integers(0, 25), min_size=1, max_size=5).filter(operator.itemgetter(0)),
    st.integers(1, 3),
    st.sampled_from(["none", "divided"]),
    st.none() | st.sampled_from([(10.0, 10.0, 20.0), (20.0, 10.0, 0.0)]),
    st.integers(0, 99),
)
@settings(max_examples=12)
def test_every_constraint_is_met(
    owned: list[int], max_step: int, boundary: str, robot: tuple[float, float, float] | None, seed: int
) -> None:
    made = recipe(
        seed, chunk_size=4, chunks=(2, 1), boundary=boundary, inventory=owned, max_step=max_step, crossable_by=robot
    )
    field = rsegen.build(made)
    assert field.levels.any()
    assert differences(field).max() <= max_step
    used = field.level_counts()
    assert all(count <= owned[level - 1] for level, count in used.items() if level)
    if made.crosser:
        assert all(made.crosser.crossing(field, axis).crosses for axis in (0, 1))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("inventory", "least"),
    long_unless(
        lambda case: case[1] != 70,
        [((27, 33, 21, 10), 91), ((31, 28, 9, 30), 70), ((40, 33, 21, 10), 95)],
        reason="few low blocks take twelve seconds",
    ),
)
def test_the_way_of_a_robot_costs_few_blocks(inventory: tuple[int, ...], least: int) -> None:
    made = recipe(0, inventory=inventory, max_step=1, crossable_by=(10.0, 10.0, 53.0))
    field = rsegen.build(made)
    assert blocks_used(field) >= least
    assert all(made.crosser.crossing(field, axis).crosses for axis in (0, 1) if made.crosser)


def test_a_map_that_loses_no_block_to_its_largest_step_stays_as_it_is() -> None:
    free = rsegen.build(recipe(inventory=(40, 40, 40, 40)))
    highest = int(differences(free).max())
    assert rsegen.build(recipe(inventory=(40, 40, 40, 40), max_step=highest)) == free


def test_a_shape_is_arranged_where_it_was_designed() -> None:
    """A ridge along the middle, of fewer blocks than its slopes need: the high blocks stay on it."""
    ridge = rsegen.HorizontalBarrier(levels=5, first=(0, 5), last=(9, 5))
    field = rsegen.build(recipe(obstacles=[ridge], inventory=(25, 10, 0, 0), max_step=1))
    assert field.level_counts() == {0: 65, 1: 25, 2: 10}
    assert (field.blocks[:, 5] == 2).sum() >= 8
    assert not field.blocks[:, :3].any()
    assert not field.blocks[:, 8:].any()


def test_counted_blocks_are_all_kept_if_the_largest_step_allows_it(capsys: pytest.CaptureFixture[str]) -> None:
    counted = (rsegen.Random(levels=5, counts=COUNTS),)
    made = recipe(obstacles=counted, max_step=1)
    field = rsegen.build(made)
    assert field.level_counts() == dict(enumerate(COUNTS))
    assert differences(field).max() == 1
    assert not list(block_warnings(rsegen.compose(made)))
    uneven = (rsegen.Random(levels=5, counts=(40, 3, 3, 4, 50)),)
    assert list(block_warnings(rsegen.compose(replace(made, obstacles=uneven)))) == [
        "no order of the counted blocks keeps to max_step 1: the map has others"
    ]


def test_the_remaining_blocks_are_reported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    asked = ["--seed", "3", "--obstacle", "random levels=5", "--max-step", "1", "--inventory", "10,4,20,40"]
    assert main(["generate", *asked, "-o", str(tmp_path)]) == 0
    said = capsys.readouterr().out
    found = json.loads((tmp_path / "rse_0000/constraints.json").read_text())["inventory"]
    left = {level: found["owned"][level] - found["used"].get(level, 0) for level in found["owned"]}
    assert {level: count for level, count in left.items() if count} == found["left"]
    lengths = ", ".join(f"{count} of {int(level) * 10} cm" for level, count in found["left"].items())
    assert f"warning: left in the box: {lengths}\n" in said
    assert f"uses {sum(found['used'].values())} of the 74 blocks of the inventory" in said


@given(seed=st.integers(0, 1000), stock=st.lists(st.integers(0, 40), min_size=1, max_size=5))
@settings(max_examples=15)
def test_the_distance_from_the_design_is_never_below_that_of_an_independent_solver(seed: int, stock: list[int]) -> None:
    """Every cell is matched with a block by scipy's assignment, at the cost of the difference of their levels."""
    assume(sum(stock))
    optimize = pytest.importorskip("scipy.optimize", reason="SciPy is not installed")
    design = rsegen.Recipe(seed=seed, boundary="none", obstacles=(rsegen.Random(levels=5),))
    levels = rsegen.build(design).blocks.ravel()
    wished = levels[levels > 0]
    blocks = np.repeat(np.arange(len(stock) + 1), [max(len(wished) - sum(stock), 0), *stock])
    costs = np.abs(wished[:, None] - blocks)
    least = costs[optimize.linear_sum_assignment(costs + 1000 * (blocks == 0))].sum()
    made = replace(design, inventory=tuple(stock))
    scene = rsegen.compose(made)
    differs = np.abs(scene.field.blocks.ravel().astype(int) - levels).sum()
    *_, said = describe_constraints(scene, constraint_report(scene))
    assert differs == least
    assert said == (
        f"levels differ by {least} units in total from the map that the obstacles ask for, "
        "the least that these blocks allow"
    )


def test_an_inventory_without_a_block_is_refused() -> None:
    with pytest.raises(rsegen.UserError, match="inventory: has no block; list the number of blocks of level 1, 2"):
        recipe(inventory=(0, 0))


def test_an_inventory_that_cannot_be_used_at_all_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    asked = ["--seed", "3", "--obstacle", "random levels=5", "--max-step", "2", "--inventory", "0,0,0,50"]
    assert main(["generate", *asked, "-o", str(tmp_path / "out")]) == 2
    assert (
        "inventory: none of its 50 blocks can be used on 100 cells with a max_step of 2; "
        "add lower ones, or one for each cell" in the_line(capsys.readouterr().err)
    )
    assert not (tmp_path / "out").exists()
