"""Every block is sawn, none from more than there is, and nothing is lost but to the saw."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rsegen import CutSettings, Random, Recipe, build
from rsegen.build_sheets.cut_settings import nanometres
from rsegen.build_sheets.timber import CuttingPlan, frames, materials, plan_cuts, together
from rsegen.errors import ParameterError

CM = nanometres(1)
SAWS = st.builds(
    CutSettings,
    kerf_mm=st.sampled_from([0, 1.5, 3, 40]),
    stock_cm=st.sampled_from([65, 100, 240.5]),
    trim_cm=st.sampled_from([0, 0.5, 2]),
    tolerance_mm=st.sampled_from([0, 0.5]),
)
EXACT = CutSettings(trim_cm=0, tolerance_mm=0)
COUNTS = st.dictionaries(st.integers(1, 60).map(lambda length: length * CM), st.integers(1, 40), max_size=6)


def cut_length(parts: Sequence[int], saw: CutSettings) -> int:
    """Longest length of a piece that these parts need: each may be too long, with a cut between two of them."""
    return sum(parts) + len(parts) * saw.tolerance + (len(parts) - 1) * saw.kerf


def first_fit_decreasing(counts: Mapping[int, int], saw: CutSettings) -> Counter[tuple[tuple[int, int], ...]]:
    """As the books have it, block by block."""
    pieces: list[list[int]] = []
    for length in sorted(Counter(counts).elements(), reverse=True):
        for piece in pieces:
            if cut_length([*piece, length], saw) <= saw.usable:
                piece.append(length)
                break
        else:
            pieces.append([length])
    return Counter(tuple(Counter(piece).items()) for piece in pieces)


@given(COUNTS, SAWS)
def test_blocks_are_sawn_first_fit_decreasing(counts: Mapping[int, int], saw: CutSettings) -> None:
    found: Counter[tuple[tuple[int, int], ...]] = Counter()
    for pattern in plan_cuts(counts, saw).patterns:
        found[pattern.parts] += pattern.pieces
    assert found == first_fit_decreasing(counts, saw)


@given(COUNTS, SAWS)
def test_every_block_is_sawn_and_nothing_is_lost_but_to_the_saw(counts: Mapping[int, int], saw: CutSettings) -> None:
    plan = plan_cuts(counts, saw)
    sawn_of: Counter[int] = Counter()
    for pattern in plan.patterns:
        for length, count in pattern.parts:
            sawn_of[length] += pattern.pieces * count
    assert sawn_of == counts
    assert plan.timber == sum(length * count for length, count in counts.items())
    assert plan.timber + plan.kerf_loss + plan.offcuts + plan.trimmed == plan.pieces * saw.stock
    assert 0 <= plan.kerf_loss <= (saw.kerf + saw.tolerance) * sum(counts.values())
    for pattern in plan.patterns:
        assert cut_length([length for length, count in pattern.parts for _ in range(count)], saw) <= saw.usable


def parts(plan: CuttingPlan) -> list[tuple[int, tuple[tuple[int, int], ...], int]]:
    """Of each pattern: how often, length in cm and number, what is left in mm."""
    return [
        (
            pattern.pieces,
            tuple((length // CM, count) for length, count in pattern.parts),
            pattern.offcut(plan.settings) * 10 // CM,
        )
        for pattern in plan.patterns
    ]


def test_the_saw_costs_a_block() -> None:
    """Twelve blocks of 20 cm are 240 cm, but not with a kerf: after the eleventh 17 cm less 3 mm are left."""
    counts = {20 * CM: 12}
    assert parts(plan_cuts(counts, replace(EXACT, kerf_mm=0))) == [(1, ((20, 12),), 0)]
    assert parts(plan_cuts(counts, EXACT)) == [(1, ((20, 11),), 167), (1, ((20, 1),), 2197)]


def test_a_block_as_long_as_the_stock_is_not_sawn() -> None:
    plan = plan_cuts({240 * CM: 3}, EXACT)
    assert (plan.pieces, plan.kerf_loss, plan.offcuts) == (3, 0, 0)


def test_the_ends_of_stock_and_a_tolerance_are_left_over() -> None:
    """Of 240 cm 238 are used; ten blocks of 20 cm, ten cuts of 3.5 mm, and 3.45 cm of offcut."""
    plan = plan_cuts({20 * CM: 10}, CutSettings())
    assert parts(plan) == [(1, ((20, 10),), 345)]
    assert (plan.kerf_loss, plan.trimmed, plan.offcuts) == (35 * CM // 10, 2 * CM, 345 * CM // 10)
    with pytest.raises(ParameterError, match="trim_cm: nothing is left of 10 cm of stock"):
        CutSettings(stock_cm=10, trim_cm=5)


@pytest.mark.parametrize(
    ("length_cm", "number", "tolerance_mm", "pieces"),
    [
        (118.85, 2, 0, 1),  # 237.7 cm and a cut of 0.3 cm are the 238 cm between the ends
        (118.85, 2, 0.5, 2),  # cut too long both are 238.1 cm
        (118.8, 2, 0.5, 1),
        (118.82, 2, 0.5, 2),
        (79.05, 3, 0.5, 1),  # 237.15, two cuts and three tolerances: 237.9
        (79.1, 3, 0.5, 2),  # 238.05
        (23.45, 10, 0.5, 1),  # 234.5 + 2.7 + 0.5 = 237.7
        (23.5, 10, 0.5, 2),  # 238.2
        (238, 1, 0, 1),
    ],
)
def test_every_part_may_be_too_long(length_cm: float, number: int, tolerance_mm: float, pieces: int) -> None:
    saw = CutSettings(tolerance_mm=tolerance_mm)
    assert plan_cuts({nanometres(length_cm): number}, saw).pieces == pieces


@pytest.mark.parametrize(("length_cm", "fits"), [(237.95, True), (237.96, False), (238, False)])
def test_a_single_part_has_its_tolerance_too(length_cm: float, fits: bool) -> None:
    if fits:
        assert plan_cuts({nanometres(length_cm): 1}, CutSettings()).pieces == 1
        return
    with pytest.raises(ParameterError, match="stock_cm: 240 cm is too short for the longest block"):
        plan_cuts({nanometres(length_cm): 1}, CutSettings())


def test_a_block_longer_than_the_stock_is_refused() -> None:
    said = r"stock_cm: 30 cm is too short for the longest block, 30\.5 cm; use 32\.55 cm or more"
    with pytest.raises(ParameterError, match=said):
        plan_cuts({nanometres(30.5): 1}, CutSettings(stock_cm=30))


def test_the_boards_of_a_nist_pallet_are_120_and_100_cm() -> None:
    known = frames(Recipe(seed=1))
    assert known == {120 * CM: 2, 100 * CM: 2}
    assert together(known) == 440 * CM


def test_frames_have_the_boards_of_their_boundary() -> None:
    recipe = Recipe(seed=1, chunks=(3, 2), chunk_size=4)
    divided, outer = (frames(replace(recipe, boundary=boundary)) for boundary in ("divided", "outer"))
    assert divided == {60 * CM: 12, 40 * CM: 12}
    assert outer == {140 * CM: 2, 80 * CM: 2}
    assert frames(replace(recipe, boundary="none")) == frames(replace(recipe, frame_height_cm=0)) == {}
    assert frames(recipe, 5 * CM // 10) == {605 * CM // 10: 12, 405 * CM // 10: 12}
    equal = frames(Recipe(seed=1, boundary="outer", chunks=(1, 2), chunk_size=2, block_width_cm=7))
    assert equal == {28 * CM: 4}


@pytest.mark.parametrize("boundary", ["none", "divided", "outer"])
def test_blocks_and_frames_weigh_what_their_cells_hold(boundary: str) -> None:
    recipe = Recipe(
        seed=1,
        chunks=(3, 2),
        chunk_size=4,
        boundary=boundary,
        unit_cm=7,
        frame_height_cm=12,
        obstacles=[Random(levels=5)],
    )
    field, saw = build(recipe, 0), CutSettings(density=600)
    needed = materials(field, recipe, saw)
    of_cells = (
        600 * field.block_width**2 * np.array([field.heights[~field.frame].sum(), field.heights[field.frame].sum()])
    )
    assert (needed.block_weight, needed.frame_weight) == pytest.approx(tuple(of_cells))
    along_x, along_y = (
        count * side for count, side in zip((3, 2) if needed.bases == 6 else (1, 1), needed.base, strict=True)
    )
    assert (along_x / 100 / CM, along_y / 100 / CM) == pytest.approx(field.extent)
