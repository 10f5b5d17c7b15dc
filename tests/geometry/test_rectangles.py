"""Rectangles cover the squares exactly, and are nearly the fewest."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from rsegen.field.stepfield import StepField
from rsegen.geometry import surface
from rsegen.geometry.rectangles import Rectangles, independent_set, merge, merge_hanging
from tests.geometry.grids import GRIDS
from tests.geometry.minimum import counted, searched


def grids(top: int, side: int) -> st.SearchStrategy[np.ndarray]:
    shapes = st.tuples(st.integers(1, side), st.integers(1, side))
    return arrays.arrays(np.int64, shapes, elements=st.integers(0, top))


def rows(found: Rectangles) -> Iterator[tuple[int, ...]]:
    return zip(*(column.tolist() for column in found), strict=True)


@given(grids(top=3, side=9))
def test_rectangles_cover_every_labelled_square_once(labels: np.ndarray) -> None:
    painted, times = np.zeros_like(labels), np.zeros_like(labels)
    for label, u0, u1, v0, v1 in rows(merge(labels)):
        painted[u0:u1, v0:v1] = label
        times[u0:u1, v0:v1] += 1
    np.testing.assert_array_equal(painted, labels)
    np.testing.assert_array_equal(times, labels != 0)


@given(grids(top=2, side=3))
def test_the_theorem_agrees_with_an_exhaustive_search(labels: np.ndarray) -> None:
    assert counted(labels) == searched(labels)


@given(grids(top=2, side=4))
@settings(max_examples=200)
def test_small_grids_are_cut_into_the_fewest(labels: np.ndarray) -> None:
    assert len(merge(labels).label) == counted(labels)


@given(intersects=arrays.arrays(bool, st.tuples(st.integers(1, 9), st.integers(1, 9))), draw=st.data())
def test_chords_are_chosen_as_by_rounds_over_all_intersections(intersects: np.ndarray, draw: st.DataObject) -> None:
    along_u, along_v = intersects.shape
    lengths = draw.draw(arrays.arrays(np.int64, along_u + along_v, elements=st.integers(1, 4)))
    a, b = np.nonzero(intersects)
    assert set(np.flatnonzero(independent_set(a, b + along_u, lengths))) == by_rounds(a, b + along_u, lengths)


def by_rounds(a: np.ndarray, b: np.ndarray, lengths: np.ndarray) -> set[int]:
    """Chords that are kept, if every round looks at every intersection."""
    rank = np.argsort(np.argsort(lengths, kind="stable")).tolist()
    kept, pairs = set(range(len(lengths))), list(zip(a.tolist(), b.tolist(), strict=True))
    while pairs:
        met = Counter(chord for pair in pairs for chord in pair)
        both = pairs + [(y, x) for x, y in pairs]
        gone = {y for x, y in both if met[x] == 1 and (met[y] > 1 or rank[x] < rank[y])}
        if not gone:
            worse = {x for x, y in both if (met[x], rank[x]) > (met[y], rank[y])}
            gone = {y for x, y in both if x not in worse}
        kept -= gone
        pairs = [pair for pair in pairs if not gone.intersection(pair)]
    return kept


@pytest.mark.parametrize("kind", GRIDS)
@pytest.mark.parametrize("size", [10, 80])
def test_surfaces_are_within_3_percent_of_the_fewest_rectangles(kind: str, size: int) -> None:
    levels = GRIDS[kind](size, np.random.default_rng(3))
    assert len(surface(field_of(levels)).faces) <= 1.03 * fewest_faces(levels)


def field_of(levels: np.ndarray) -> StepField:
    frame = np.zeros(levels.shape, dtype=bool)
    return StepField(levels=levels.astype(np.int16), frame=frame, block_width=0.1, unit=0.1, frame_height=0.1)


def fewest_faces(levels: np.ndarray) -> int:
    """Of tops, and of the risers on every line between cells, each kept apart by the level of its block."""
    found = counted(levels)
    for turned in (levels, levels.T):
        around = np.pad(turned, ((1, 1), (0, 0)))
        for one, other in [*pairwise(around), *pairwise(around[::-1])]:
            heights = np.arange(1, levels.max() + 1)[:, None]
            found += counted(np.where((heights <= one) & (heights > other), one, 0))
    return found


@given(st.lists(st.integers(0, 5), min_size=1, max_size=12))
def test_hanging_pieces_are_cut_into_the_fewest(low: list[int]) -> None:
    top = 6
    starts = [0] + [k for k in range(1, len(low)) if low[k] != low[k - 1]]
    u0 = np.array(starts)
    strips = Rectangles(0 * u0, u0, np.append(u0[1:], len(low)), np.array(low)[u0], np.full(len(u0), top))

    found = merge_hanging(strips)

    painted = np.zeros((len(low), top), dtype=int)
    for _, a, b, c, d in rows(found):
        painted[a:b, c:d] += 1
    np.testing.assert_array_equal(painted, np.arange(top) >= np.array(low)[:, None])
    assert len(found.label) == counted(painted)


def test_a_lane_is_one_rectangle_whatever_its_neighbours() -> None:
    labels = np.full((9, 40), 2)
    labels[2:7] = 1
    labels[1, 1::3] = labels[7, 1::4] = 1
    lane = [row for row in rows(merge(labels)) if row[1:] == (2, 7, 0, 40)]
    assert len(lane) == 1
