"""Drives decide where the next way leads: over what they passed, and around what held them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rsegen.standing.evidence import MOVE, Evidence
from rsegen.standing.lattice import BEST, Lattice
from rsegen.standing.planner import Planner
from tests.standing.stands import BODIES, field_of

SHAPE = (2, 2, 8)
BURGER = BODIES["burger"]


def metres(passed: float, held: float, weighted: float = 0.3) -> float:
    """Return the metres as which a move of 0.3 weighted metres counts."""
    evidence = Evidence(SHAPE)
    evidence.passed[MOVE], evidence.held[MOVE] = passed, held
    (found,) = evidence.metres(MOVE, np.array([3]), np.array([weighted]))
    return float(found)


def test_what_nobody_has_tried_counts_as_poses_know_it() -> None:
    assert metres(0, 0) == pytest.approx(0.3)
    assert metres(0, 0, 1.7) == pytest.approx(1.7)


def test_what_held_a_drive_counts_as_metres_and_what_was_passed_as_less() -> None:
    assert metres(1, 0) == pytest.approx(0.1, rel=0.1)
    assert metres(5, 0) < metres(2, 0) < metres(1, 0)
    assert 3 < metres(0, 1) < 5
    assert metres(0, 2) > metres(0, 1) > metres(1, 1) > metres(5, 1) > metres(0, 0)
    assert metres(9, np.inf) == np.inf


@given(passed=st.integers(0, 40), weighted=st.floats(1e-3, 2.0), longest=st.floats(1e-3, 4.0))
def test_no_move_counts_less_than_the_least_share_of_it(passed: int, weighted: float, longest: float) -> None:
    evidence = Evidence(SHAPE)
    evidence.passed[MOVE, 0, 0, 0] = passed
    share, weighted = evidence.least_share(longest), min(weighted, longest)
    counted = evidence.metres(MOVE, slice(None), np.full(np.prod(SHAPE), weighted))
    assert counted.min() >= share * weighted * (1 - 1e-9)
    assert share <= 1 + 1e-9


@pytest.mark.parametrize("best", BEST)
def test_a_way_leads_around_a_place_that_held_a_drive(best: str) -> None:
    planner = Planner(Lattice(field_of(np.zeros((12, 7), int)), BURGER, best))
    first = planner.way(0, checked=False)
    assert first is not None
    line = first.points[0, 1]
    assert np.all(first.points[:, 1] == line), "straight over a level floor"
    planner.learn(first.points, (0.0, line))
    second = planner.way(0, checked=False)
    assert second is not None
    across = np.interp(0.0, *second.points.T)
    assert abs(across - line) > planner.field.block_width / 2
    assert second.crosses


def test_a_way_that_was_crossed_is_kept_and_its_beginning_too() -> None:
    """All lines over a level floor are alike: the one that a drive crossed is taken, and its first half for another."""
    planner = Planner(Lattice(field_of(np.zeros((12, 7), int)), BURGER, "safe"))
    first = planner.way(0, checked=False)
    assert first is not None
    line, aside = first.points[0, 1], first.points.copy()
    aside[:, 1] += planner.field.block_width
    planner.learn(aside, None)
    kept = planner.way(0, checked=False)
    assert kept is not None
    assert np.allclose(kept.points[:, 1], aside[0, 1])
    planner.learn(aside, (0.3, float(aside[0, 1])))
    planner.learn(aside, (0.3, float(aside[0, 1])))
    around = planner.way(0, checked=False)
    assert around is not None
    assert around.points[0, 1] == pytest.approx(aside[0, 1]), "it comes in where drives did"
    assert abs(np.interp(0.3, *around.points.T) - aside[0, 1]) > planner.field.block_width / 2
    assert line != aside[0, 1]


@pytest.mark.parametrize("best", BEST)
def test_of_closed_ways_there_is_an_end(best: str) -> None:
    planner, ways = Planner(Lattice(field_of(np.zeros((4, 3), int), 0.1), BURGER, best)), set[bytes]()
    for _ in range(40):
        way = planner.way(0, checked=False)
        if way is None:
            break
        assert way.points.tobytes() not in ways, "what is closed is not planned again"
        ways.add(way.points.tobytes())
        middle = way.points[len(way.points) // 2]
        planner.learn(way.points, (float(middle[0]), float(middle[1])), held=np.inf)
    else:
        pytest.fail("more ways than the map has")
    assert len(ways) >= 2
