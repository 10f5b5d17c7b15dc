"""A map is compared with the map that the obstacles ask for, and with what other constraints make of that one."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import rsegen
from rsegen.gazebo.constraint_report import block_warnings, constraint_report, describe_constraints

STOCK = (164, 296, 171, 19, 41)
"""Blocks of 10, 20, ... cm."""

ROUGH = rsegen.Recipe(chunk_size=20, boundary="none", seed=861102, obstacles=[rsegen.Random(levels=5)])


def blocks(field: rsegen.StepField) -> dict[int, int]:
    return {level: count for level, count in field.level_counts().items() if level}


def distance(a: rsegen.StepField, b: rsegen.StepField) -> int:
    return int(np.abs(a.levels.astype(int) - b.levels).sum())


def test_blocks_that_the_obstacles_ask_for_are_missing_although_a_largest_step_needs_none_of_them() -> None:
    scene = rsegen.compose(replace(ROUGH, max_step=2, crossable_by=(25, 25, 30), inventory=STOCK))
    report, asked = constraint_report(scene), rsegen.build(ROUGH)
    assert (blocks(asked)[4], STOCK[3]) == (87, 19)
    assert distance(scene.field, asked) == 169
    assert report["obstacles"] == {"blocks": blocks(asked), "differs_units": 169}
    assert report["limited"] == {
        "by": ["max_step", "crossable_by"],
        "blocks": blocks(scene.field),
        "differs_units": 0,
        "missing": {},
    }
    assert report["inventory"]["missing"] == {4: 68}
    assert list(block_warnings(scene)) == ["blocks missing for the map that the obstacles ask for: 68 of 40 cm"]
    assert list(describe_constraints(scene, constraint_report(scene)))[-1] == (
        "levels differ by 169 units in total from the map that the obstacles ask for, and by 0 from the map that "
        "max_step and crossable_by make of it, the least that these blocks allow"
    )


@pytest.mark.parametrize(
    ("limits", "names"),
    [
        ({"max_step": 1}, "max_step makes of it"),
        ({"crossable_by": (10, 10, 30)}, "crossable_by makes of it"),
        ({"max_step": 3, "crossable_by": (20, 20, 30)}, "max_step and crossable_by make of it"),
    ],
)
@pytest.mark.parametrize("stock", [(30, 40, 50, 9), (400, 400, 400, 400), (40, 0, 30, 90)])
def test_both_maps_are_said_of_all_limits_with_an_inventory(
    limits: dict[str, Any], names: str, stock: tuple[int, ...]
) -> None:
    made = replace(ROUGH, seed=7, chunk_size=12, inventory=stock, **limits)
    scene, asked = rsegen.compose(made), rsegen.build(replace(ROUGH, seed=7, chunk_size=12))
    limited = rsegen.build(replace(made, inventory=None))
    report = constraint_report(scene)
    there = dict(enumerate(stock, 1))
    for name, other in (("obstacles", asked), ("limited", limited)):
        assert report[name]["blocks"] == blocks(other)
        assert report[name]["differs_units"] == distance(scene.field, other)
    for missing, other in ((report["inventory"]["missing"], asked), (report["limited"]["missing"], limited)):
        assert missing == {level: n - there[level] for level, n in blocks(other).items() if n > there[level]}
    apart, from_limited = distance(scene.field, asked), distance(scene.field, limited)
    said = f"by {apart:,} units in total from the map that the obstacles ask for, and by {from_limited:,} from the map"
    assert f"{said} that {names}" in list(describe_constraints(scene, constraint_report(scene)))[-1]
    assert apart > 0


def test_without_an_inventory_the_distance_is_that_which_the_limits_make() -> None:
    scene, asked = rsegen.compose(replace(ROUGH, max_step=1)), rsegen.build(ROUGH)
    report = constraint_report(scene)
    assert report["obstacles"]["differs_units"] == distance(scene.field, asked) > 100
    assert "limited" not in report
    said = f"levels differ by {distance(scene.field, asked):,} units in total from the map that the obstacles ask for"
    assert list(describe_constraints(scene, constraint_report(scene)))[-1] == said


def test_with_an_inventory_alone_missing_blocks_are_said_once() -> None:
    scene = rsegen.compose(replace(ROUGH, inventory=STOCK))
    assert "limited" not in constraint_report(scene)
    assert list(block_warnings(scene)) == ["missing blocks, replaced by others: 68 of 40 cm"]
