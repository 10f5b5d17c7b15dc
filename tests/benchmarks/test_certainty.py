"""Totals of the record of predictions: every drive is counted once, and a told probability is judged by Brier."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from benchmarks import certainty
from benchmarks.certainty import BINS, COLUMNS, KINDS, PLANS, brier, fields, loaded, table


def test_brier_is_the_mean_squared_difference() -> None:
    rows = [{"told": 0.9, "crossed": 2, "of": 3}, {"told": 0.1, "crossed": 0, "of": 1}]
    assert brier(rows) == pytest.approx((2 * 0.01 + 0.81 + 0.01) / 4)


def test_every_prediction_of_the_record_is_in_one_bin() -> None:
    rows = [dict(zip(COLUMNS, row, strict=True)) for row in loaded()["rows"] if row[-1]]
    found = [certainty._Bin.of(rows, low, high) for low, high in BINS]
    assert sum(part.predictions for part in found if part) == len(rows) > 50
    assert sum(part.drives for part in found if part) == sum(row["of"] for row in rows)
    told = [int(line.split(" predictions")[0].split()[-1]) for line in table(loaded()) if " predictions, " in line]
    assert sum(told) == len(rows)


def test_records_are_counted_together() -> None:
    record = loaded()
    alone, every = (_counts({**record, "earlier": record["earlier"][:most]}) for most in (0, certainty.RECORDS))
    twice = _counts({**record, "earlier": [certainty._sums(record)]})
    assert twice["all"] == [2 * count for count in alone["all"]]
    assert all(more > few > 0 for few, more in zip(alone["all"], every["all"], strict=True))
    robots = {key: counts for key, counts in every.items() if key != "all" and "," not in key}
    assert set(robots) >= set(PLANS)
    assert [sum(counts) for counts in zip(*robots.values(), strict=True)] == every["all"]


def test_a_robot_that_was_judged_in_one_simulator_has_empty_cells_for_the_others() -> None:
    record = loaded()
    new = dict(zip(COLUMNS, record["rows"][0], strict=True)) | {"robot": "new", "judge": "mujoco"}
    lines = list(certainty._together({**record, "rows": [[*new.values()]]}))
    (head,) = (line for line in lines if line.startswith("| of |"))
    (line,) = (line for line in lines if line.startswith("| new |"))
    assert line.count("|") == head.count("|")
    assert line.endswith("|  |  |  |  |")


def test_the_summary_names_groups_that_are_less_often_right() -> None:
    row = dict(zip(COLUMNS, loaded()["rows"][0], strict=True)) | {"judge": "mujoco", "route": "straight", "of": 3}
    ends = [("good", 0.96, 3), ("good", 0.04, 0), ("poor", 0.96, 1), ("poor", 0.04, 1), ("open", 0.5, 3)]
    rows = [[*(row | {"robot": robot, "told": told, "crossed": crossed}).values()] for robot, told, crossed in ends]
    lines = list(certainty.summary({"seed": 1, "earlier": [], "rows": rows}))
    assert "| MuJoCo | 5 | 80% | 9 of 12 (75%) | 9 of 12 (75%) |  | 4 of 6 | 1 of 6 |" in lines
    named = [line for line in lines if re.match(r"\| (good|poor|open)", line)]
    alone = f"| poor, {row['unit_cm']:g} cm | MuJoCo | 3 of 6 (50%) | 3 of 6 (50%) |"
    assert named == ["| poor | MuJoCo | 3 of 6 (50%) | 3 of 6 (50%) |", alone]


def _counts(record: Mapping[str, Any]) -> dict[str, list[int]]:
    """Drives of sure predictions that were as told, and all, simulator by simulator, of the groups of records."""
    rows = [line for line in certainty._together(record) if " of " in line and line.startswith("|")]
    return {
        row.split("|")[1].strip(): [int(one) for one in re.findall(r"\d+(?= of )|(?<= of )\d+", row)]
        for row in rows[1:]
    }


def test_fields_are_fresh_and_the_same_for_a_seed() -> None:
    first, again, other = (fields(PLANS, seed, 2) for seed in (5, 5, 900))
    assert first == again
    assert not {field.seed for field in first} & {field.seed for field in other}
    assert {(field.robot, field.unit_cm) for field in first} == {(kind, unit) for kind in PLANS for unit in PLANS[kind]}
    assert {field.field for field in first} == set(KINDS)
    levels = first[0].scene.field.levels
    assert levels.any()
    assert levels.shape != other[0].scene.field.shape or (levels != other[0].scene.field.levels).any()


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("unit_cm", [0.3, 10])
def test_every_kind_has_steps_of_whole_units(kind: str, unit_cm: float) -> None:
    field = certainty.Field("crawler", kind, unit_cm, 7).scene.field
    steps = np.diff(np.unique(field.heights)) / (unit_cm / 100)
    assert steps.size
    assert steps == pytest.approx(steps.round())
