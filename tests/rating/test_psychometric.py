"""The estimator, judged by robots whose curve is known, and by what any posterior must keep to."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import exp, log

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import expit

from rsegen.driving.many import wilson
from rsegen.params.streams import generator
from rsegen.rating.axes import AXES
from rsegen.rating.psychometric import LAPSES, SPREADS, Posterior, next_places, posterior

LOW, HIGH = log(0.05), log(100)
OUTCOMES = st.lists(st.tuples(st.floats(LOW, HIGH), st.booleans()), max_size=40)


def known(outcomes: Sequence[tuple[float, bool]]) -> Posterior:
    return posterior([u for u, _ in outcomes], [crossed for _, crossed in outcomes], LOW, HIGH)


@given(OUTCOMES)
def test_weights_are_probabilities_and_intervals_hold_their_medians(outcomes: Sequence[tuple[float, bool]]) -> None:
    curves = known(outcomes)
    assert curves.weights.min() >= 0
    assert curves.weights.sum() == pytest.approx(1)
    for share in (0.5, 0.8):
        middle, low, high = curves.at_share(share)
        assert low <= middle <= high
        assert curves.below(share, low) < 0.06
        assert curves.below(share, high) > 0.94
    half, most = curves.at_share(0.5), curves.at_share(0.8)
    assert all(easier < harder for easier, harder in zip(most, half, strict=True))


@given(OUTCOMES, st.floats(LOW, HIGH))
def test_an_outcome_at_a_level_makes_that_outcome_more_likely_there(
    outcomes: Sequence[tuple[float, bool]], u: float
) -> None:
    at = np.array([u])
    before, up, down = (known([*outcomes, *more]).expected(at)[0] for more in ([], [(u, True)], [(u, False)]))
    slack = 0.02  # of the grid, which is another one each time
    assert down - slack <= before <= up + slack
    assert down < up


@given(OUTCOMES, st.randoms())
def test_the_order_of_trials_does_not_matter(outcomes: list[tuple[float, bool]], random: object) -> None:
    shuffled = list(outcomes)
    random.shuffle(shuffled)  # type: ignore[attr-defined]  # hypothesis's Random
    assert known(shuffled).at_share(0.5) == pytest.approx(known(outcomes).at_share(0.5), abs=1e-9)


@given(st.floats(-1.0, 1.0), OUTCOMES)
def test_shifted_levels_shift_the_result(by: float, outcomes: list[tuple[float, bool]]) -> None:
    here = posterior([u for u, _ in outcomes], [c for _, c in outcomes], LOW, HIGH)
    there = posterior([u + by for u, _ in outcomes], [c for _, c in outcomes], LOW + by, HIGH + by)
    assert np.subtract(there.at_share(0.5), by) == pytest.approx(here.at_share(0.5), abs=1e-6)


def test_expected_shares_fall_within_their_band() -> None:
    curves = known([(log(2.0), True)] * 5 + [(log(4.0), False)] * 5)
    u = np.linspace(log(1.5), log(5), 30)
    low, high = curves.band(u)
    expected = curves.expected(u)
    assert (np.diff(expected) <= 1e-12).all()
    assert ((low <= expected) & (expected <= high)).all()


def test_many_trials_find_the_curve_that_made_them() -> None:
    u = np.repeat(np.linspace(log(1), log(9), 9), 400)
    rng = np.random.default_rng(5)
    crossed = rng.random(len(u)) < expit((log(3) - u) / 0.3)
    curves = posterior(u, crossed, LOW, HIGH)
    middle, low, high = curves.at_share(0.5)
    assert low < log(3) < high
    assert high - low < 0.1
    assert curves.spread()[1] < 0.3 < curves.spread()[2]
    # The interval is about as wide as that of a maximum likelihood fit: 2 * 1.96 standard deviations of the estimate.
    share = expit((log(3) - u) / 0.3)
    deviation = 0.3 / np.sqrt((share * (1 - share)).sum())
    assert high - low == pytest.approx(2 * 1.96 * deviation, rel=0.35)
    assert middle == pytest.approx(log(3), abs=4 * deviation)


def test_at_one_level_the_band_is_that_of_a_share() -> None:
    """With all trials at a level, its share is known as by Wilson's interval, which has no curve."""
    u = np.full(60, log(3.0))
    crossed = np.arange(60) < 30
    low, high = posterior(u, crossed, LOW, HIGH).band(np.array([log(3.0)]))
    assert (low[0], high[0]) == pytest.approx(wilson(30, 60), abs=0.05)


@given(OUTCOMES, st.integers(1, 12), st.integers(0, 2**31))
def test_places_are_candidates_and_depend_on_the_seed_alone(
    outcomes: Sequence[tuple[float, bool]], count: int, seed: int
) -> None:
    candidates = AXES["unit"].candidates
    chosen = [next_places(known(outcomes), candidates, count, generator(seed, 0, "places")) for _ in range(2)]
    assert chosen[0] == chosen[1]
    assert len(chosen[0]) == count
    assert np.isin(chosen[0], candidates).all()


def test_the_next_place_is_where_the_outcome_is_open() -> None:
    curves = known([(log(1.0), True)] * 20 + [(log(4.0), False)] * 20)
    (place,) = next_places(curves, AXES["unit"].candidates, 1, generator(1, 0, "places"))
    assert 1.3 < exp(place) < 3.2
    assert 0.1 < float(curves.expected(np.array([place]))[0]) < 0.9


def test_the_first_places_are_far_apart() -> None:
    places = next_places(known([]), AXES["unit"].candidates, 8, generator(1, 0, "places"))
    assert max(places) - min(places) > log(10)


def test_the_grid_holds_what_is_documented() -> None:
    assert LAPSES[0] == 0
    assert LAPSES[-1] == 0.08
    assert all(low < high for low, high in pairwise(SPREADS))


def test_before_any_trial_a_larger_lapse_is_less_likely() -> None:
    assert all(small > large for small, large in pairwise(known([]).weights.sum((0, 1))))
