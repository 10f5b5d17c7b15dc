"""The simulated robots of benchmarks/rating: their curves are as they say, and the record is what the page shows."""

from __future__ import annotations

import json
from dataclasses import replace
from math import exp, log

import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks import rating
from rsegen.rating.judges import Asked
from rsegen.rating.rate import usual_fields

RECORD = json.loads(rating.FILE.read_text("utf-8"))


@given(st.sampled_from(rating.CURVES), st.floats(-2, 3), st.floats(0.05, 0.9))
def test_places_of_shares_are_where_these_are_crossed(curve: rating.Curve, middle: float, share: float) -> None:
    assert curve.share(curve.place(share, middle), middle) == pytest.approx(share, abs=1e-9)


@pytest.mark.parametrize("form", rating.FORMS)
def test_all_forms_cross_half_at_the_middle_and_fall_alike_there(form: str) -> None:
    curve = rating.FORMS[form]
    assert curve(0.0) == pytest.approx(0.5)
    assert (curve(0.01) - curve(-0.01)) / 0.02 == pytest.approx(-0.25, rel=0.07)
    assert (curve(-60.0), curve(60.0)) == pytest.approx((1, 0), abs=1e-6)


def test_a_simulated_robot_crosses_as_often_as_its_curve_says() -> None:
    curve = rating.Curve("logistic", 0.2, 0.0)
    robot = rating.Simulated(name="", title="", cost=1, curve=curve, middle=log(2.0), seed=4)
    recipe = replace(usual_fields(), seed=1)
    level = exp(curve.place(0.7, log(2.0)))
    crossed = sum(bool(robot.trial(recipe, Asked(index, level)).crossed) for index in range(600))
    assert crossed / 600 == pytest.approx(0.7, abs=0.07)


@pytest.mark.slow
@pytest.mark.long(reason="thirty ratings")
def test_most_intervals_hold_the_truth() -> None:
    held, _, errors, trials = zip(
        *(rating._simulated_run(rating.CURVES[1], 1000 + run) for run in range(30)), strict=True
    )
    assert sum(held) >= 25  # of 30 with 95 %: fewer come once in 600
    assert abs(sum(errors) / 30) < 0.03
    assert all(48 <= count < 400 for count in trials)


def test_the_record_is_of_all_robots_and_keeps_what_is_promised() -> None:
    assert [tuple(row[name] for name in rating.Robot._fields) for row in RECORD["robots"]] == [*rating.ROBOTS]
    assert [tuple(row[name] for name in rating.Curve._fields) for row in RECORD["simulated"]] == [*rating.CURVES]
    for row in RECORD["simulated"]:
        assert row["runs"] == rating.RUNS
        assert row["half"] / row["runs"] > 0.9
        assert row["most"] / row["runs"] > 0.9
    lines = list(rating.table(RECORD))
    rows = [line for text in lines for line in text.splitlines() if line.startswith("|")]
    assert len(rows) == 4 + len(rating.ROBOTS) + len(RECORD["makers"]) + len(rating.CURVES)


def test_two_seeds_of_a_robot_have_intervals_that_overlap() -> None:
    first, second = ({row["kind"]: row["half"] for row in rows} for rows in rating.pairs(RECORD))
    assert len(first) == len(second) == 3 + len({row["kind"] for row in RECORD["makers"]}) > 6
    for kind, (_, low, high) in first.items():
        assert low < second[kind][2]
        assert second[kind][1] < high
