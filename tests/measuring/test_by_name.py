"""A metric by its name is the figure of that name in the table of all metrics."""

from __future__ import annotations

import math
from typing import Any, cast

import pytest
from hypothesis import given

import rsegen
from rsegen import Metric, StepField, StepLimits
from rsegen.errors import UserError
from rsegen.measuring.catalogue import OF_A_ROBOT, UNITS, flattened, metric_by, nested
from tests.support.strategies import fields

LIMITS = StepLimits(climb_cm=15, width_cm=20)
NOT_MEASURED = ("steps.unit", "_is_weak", "ruggedness.cells", "reach.limits.", ".crosses", ".reason", ".at")
"""Columns of the table besides figures by which maps may be ordered."""


@given(fields())
def test_every_name_is_that_of_the_table(field: StepField) -> None:
    if field.frame.all():
        return
    table = dict(flattened(nested(rsegen.metrics(field, LIMITS))))
    table.update(flattened({"opening": nested(rsegen.metrics(field).opening)}))
    figures = {name for name in table if not any(part in name for part in NOT_MEASURED)}
    assert figures == {name for name in UNITS if not name.endswith((".tilt", ".margin")) and ".poses." not in name}
    for name in figures:
        found = metric_by(name, LIMITS if name in OF_A_ROBOT else None)(field)
        assert found == pytest.approx(math.nan if table[name] is None else table[name], abs=1e-9, nan_ok=True)


@pytest.mark.slow
@pytest.mark.long(reason="the names of poses in make test")
def test_every_name_of_a_robot_is_that_of_its_table() -> None:
    recipe = rsegen.Recipe(seed=1, chunk_size=5, unit_cm=2, boundary="none", obstacles=[rsegen.Random(levels=3)])
    field, jackal = rsegen.build(recipe), rsegen.robot_of("jackal")
    table = dict(flattened({"reach": nested(jackal.reach(field))}))
    figures = {name for name in table if not any(part in name for part in NOT_MEASURED)}
    assert figures < OF_A_ROBOT
    assert {name for name in figures if name.endswith(".tilt")}
    for name in figures:
        assert metric_by(name, jackal)(field) == pytest.approx(table[name])
    with pytest.raises(UserError, match=r"by: reach\.west_east\.cost is measured with limits of steps"):
        metric_by("reach.west_east.cost", jackal)(field)
    with pytest.raises(UserError, match=r"by: reach\.west_east\.tilt is measured with a robot"):
        metric_by("reach.west_east.tilt", LIMITS)(field)


def test_an_opening_has_the_width_of_the_robot() -> None:
    recipe = rsegen.Recipe(seed=3, boundary="none", obstacles=[rsegen.Random(levels=9)])
    field = rsegen.build(recipe)
    wide = metric_by("opening.west_east", StepLimits(climb_cm=1, width_cm=30))(field)
    assert wide == rsegen.metrics(field, StepLimits(climb_cm=1, width_cm=30)).opening.west_east
    assert wide != metric_by("opening.west_east")(field)


def test_a_function_is_a_metric_and_a_metric_is_itself() -> None:
    def cells(field: StepField) -> float:
        return field.levels.size

    found = metric_by(cells)
    assert (found.name, found(rsegen.build(rsegen.Recipe(seed=1, boundary="none")))) == ("cells", 100)
    own = Metric(name="own", unit="m", help="", measure=cells)
    assert metric_by(own) is own


@pytest.mark.parametrize(
    ("by", "robot", "message"),
    [
        ("steps.rsm", None, r"by: unknown metric 'steps.rsm'; did you mean 'steps.rms'\? \(known: opening"),
        (7, None, "by: unknown metric 7"),
        (["steps.rms"], None, "by: unknown metric"),
        (min(OF_A_ROBOT), None, f"by: {min(OF_A_ROBOT)} needs a robot; set robot too"),
        (
            "steps.rms",
            LIMITS,
            "robot: steps.rms does not depend on a robot; use by='reach.west_east.cost', or",
        ),
        (len, LIMITS, "robot: a function does not depend on a robot"),
        (
            "steps.rms",
            "burger",
            r"robot: 'burger' is neither a robot nor limits of steps; use rsegen.robot_of",
        ),
    ],
)
def test_an_unknown_metric_is_refused(by: Any, robot: Any, message: str) -> None:
    with pytest.raises(UserError, match=message):
        metric_by(by, robot)


def test_a_robot_s_name_is_refused_with_the_way_to_get_the_robot() -> None:
    with pytest.raises(
        UserError, match=r"^robot: 'burger' is neither a robot nor limits of steps; use rsegen.robot_of"
    ):
        rsegen.metrics(rsegen.build(rsegen.Recipe(seed=1)), cast("Any", "burger"))
