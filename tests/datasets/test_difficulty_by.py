"""The difficulty of a map by any metric: as near to a value as the map comes, and no further than it goes."""

from __future__ import annotations

from dataclasses import replace
from math import isnan

import numpy as np
import pytest

import rsegen
from rsegen import Random, Recipe, StepField, StepLimits
from rsegen.datasets.difficulty_tiles import Span, eased, mean_span, share_of, span_of
from rsegen.errors import ParameterError
from rsegen.measuring.catalogue import metric_by

RUBBLE = Recipe(seed=3, unit_cm=2, boundary="none", obstacles=[Random(levels=20)])
ROBOT = StepLimits(climb_cm=7)
OPENING, COVER = metric_by("opening.west_east"), metric_by("reach.coverage", ROBOT)
COST = metric_by("reach.west_east.cost", ROBOT)


def test_values_go_from_level_ground_to_the_whole_map() -> None:
    found = span_of(RUBBLE, 4, OPENING)
    assert found == Span(0.0, OPENING(rsegen.build(RUBBLE, 4)), 1.0)
    framed = replace(RUBBLE, boundary="outer", frame_height_cm=6)
    assert span_of(framed, 4, OPENING).level == 0.06


def test_the_hardest_map_is_the_last_that_the_robot_crosses() -> None:
    found = span_of(RUBBLE, 4, COST)
    assert isnan(COST(rsegen.build(RUBBLE, 4)))
    assert 0 < found.hardest < 1
    assert found.full == COST(rsegen.build(eased(RUBBLE, found.hardest), 4)) > found.level == pytest.approx(1.1)
    assert isnan(COST(rsegen.build(eased(RUBBLE, found.hardest + 2**-12), 4)))


@pytest.mark.parametrize("metric", [OPENING, COVER, COST], ids=lambda metric: metric.name)
@pytest.mark.parametrize("index", range(3))
def test_a_map_comes_as_near_as_one_step_of_the_metric(metric: rsegen.Metric, index: int) -> None:
    own = span_of(RUBBLE, index, metric)
    every = [metric(rsegen.build(eased(RUBBLE, share), index)) for share in np.linspace(0, own.hardest, 100)]
    apart = np.nanmax(np.abs(np.diff(every)))
    for difficulty in (0, 0.2, 0.5, 0.8, 1):
        share = share_of(RUBBLE, index, metric, own, own, difficulty)
        assert 0 <= share <= own.hardest
        value = metric(rsegen.build(eased(RUBBLE, share), index))
        assert value == pytest.approx(own.value(difficulty), abs=apart / 2 + 1e-9)
    assert share_of(RUBBLE, index, metric, own, own, 0) == 0
    assert share_of(RUBBLE, index, metric, own, own, 1) == own.hardest


def test_a_map_goes_no_further_than_it_is() -> None:
    own = span_of(RUBBLE, 0, OPENING)
    above = Span(0.0, 2 * own.full)
    assert share_of(RUBBLE, 0, OPENING, own, above, 0.9) == 1.0
    assert share_of(RUBBLE, 0, OPENING, own, Span(-1.0, own.full), 0.1) == 0.0


def test_a_map_of_equal_values_has_the_difficulty_itself() -> None:
    def two(field: StepField) -> float:
        return 2.0

    metric = metric_by(two)
    own = span_of(RUBBLE, 0, metric)
    assert share_of(RUBBLE, 0, metric, own, Span(2.0, 3.0), 0.3) == 0.3


def test_several_maps_rise_by_their_mean() -> None:
    assert mean_span([Span(0, 1), Span(1, 4, 0.5)], "cost") == Span(0.5, 2.5)
    with pytest.raises(ParameterError, match="by: cost is 2 at difficulty 0 and at 1; choose a metric that changes"):
        mean_span([Span(2, 1), Span(2, 3)], "cost")


def test_level_ground_without_a_value_is_refused() -> None:
    framed = replace(RUBBLE, boundary="outer", frame_height_cm=10)
    with pytest.raises(ParameterError, match=r"by: reach.west_east.cost of rse_0002 has no value even at difficulty 0"):
        span_of(framed, 2, COST)
