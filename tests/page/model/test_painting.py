"""Matrices are as large as what is painted."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from rsegen import Recipe, build
from rsegen.page.model.actions import UNPAINTED, can_paint, painted
from rsegen.recipe.codec import decode

CELLS = st.tuples(st.integers(0, 9), st.integers(0, 9))


def levels(entry: dict[str, object]) -> np.ndarray:
    recipe: Recipe = decode({"boundary": "none", "seed": 1, "obstacles": [entry]})
    return build(recipe).levels


@given(
    strokes=st.lists(
        st.tuples(st.lists(CELLS, min_size=1, max_size=5), st.integers(UNPAINTED, 40)), min_size=1, max_size=8
    )
)
def test_painted_levels_are_built(strokes: list[tuple[list[tuple[int, int]], int]]) -> None:
    wanted, entry = np.full((10, 10), UNPAINTED), None
    for cells, level in strokes:
        entry = painted(entry, cells, level)
        assert can_paint(entry)
        wanted[tuple(zip(*cells, strict=True))] = level
    assert np.array_equal(levels(entry or {}), np.maximum(wanted, 0))
    covered = np.argwhere(wanted >= 0)
    if entry and len(covered):
        assert entry["first"] == covered.min(axis=0).tolist()
        assert entry["last"] == covered.max(axis=0).tolist()


def test_painting_keeps_the_other_parameters_of_the_row() -> None:
    entry = {"kind": "matrix", "levels": 9, "rows": ["1 2"], "first": [3, 3], "key": "mine", "blend": "max"}
    after = painted(entry, [(4, 4)], 5)
    assert (after["levels"], after["key"], after["blend"]) == (9, "mine", "max")
    assert after["rows"] == [". 5", "1 2"]


def test_cells_are_put_only_into_a_matrix_in_its_own_size_and_place() -> None:
    entry = {"kind": "matrix", "levels": 5, "rows": ["1 2"]}
    assert can_paint(entry)
    assert can_paint({**entry, "first": [3, 3], "last": [4, 3]})
    assert not can_paint({**entry, "first": [3, 3], "last": [6, 3]})
    assert not can_paint({**entry, "first": ["random", 3]})
    assert not can_paint({**entry, "softness": 50})
    assert not can_paint({**entry, "rows": []})
    assert not can_paint({"kind": "peak", "levels": 5})
