"""Strategies of hypothesis: fields, obstacles and recipes within the method's ranges, small enough to be quick."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from rsegen import KINDS, Obstacle, Recipe, StepField
from rsegen.recipe.codec import decode_obstacle

SEEDS = st.integers(0, 2**63 - 1)


@st.composite
def fields(draw: st.DrawFn) -> StepField:
    """Any levels 0..4 and any frame cells, of up to 7 x 7 cells."""
    shape = draw(st.tuples(st.integers(1, 7), st.integers(1, 7)))
    cells = shape[0] * shape[1]
    levels = np.array(draw(st.lists(st.integers(0, 4), min_size=cells, max_size=cells)), dtype=np.int16).reshape(shape)
    frame = np.array(draw(st.lists(st.booleans(), min_size=cells, max_size=cells))).reshape(shape)
    frame &= draw(st.booleans())
    return StepField(
        levels=np.where(frame, np.int16(0), levels),
        frame=frame,
        block_width=draw(st.sampled_from([0.1, 0.085, 1.0])),
        unit=draw(st.sampled_from([0.1, 0.01, 0.07])),
        frame_height=draw(st.sampled_from([0.0, 0.1, 0.15])),
    )


def _place(cells_x: int, cells_y: int) -> st.SearchStrategy[object]:
    x = st.one_of(st.just("random"), st.integers(0, cells_x - 1))
    y = st.one_of(st.just("random"), st.integers(0, cells_y - 1))
    return st.one_of(st.none(), st.just("random"), st.tuples(x, y).map(list))


@st.composite
def obstacles(draw: st.DrawFn, cells_x: int = 8, cells_y: int = 8) -> Obstacle:
    """Any kind, with places that it accepts."""
    kind = draw(st.sampled_from(sorted(KINDS)))
    first, last = draw(_place(cells_x, cells_y)), draw(_place(cells_x, cells_y))
    if kind == "horizontal_barrier" and isinstance(first, list) and isinstance(last, list):
        last = [first[0], last[1]]
    return decode_obstacle(
        {
            "kind": kind,
            "levels": draw(st.integers(2, 9)),
            "softness": draw(st.integers(0, 100)),
            "first": first,
            "last": last,
            "blend": draw(st.sampled_from(["replace", "max", "add", "min"])),
        }
    )


@st.composite
def recipes(draw: st.DrawFn) -> Recipe:
    """A recipe of maps of at least 8 x 8 blocks, on ground high enough for its pits, or a bit higher."""
    chunk_size, chunks = draw(st.sampled_from([(8, (1, 1)), (4, (2, 3)), (3, (4, 3)), (12, (1, 2))]))
    rows = tuple(draw(st.lists(obstacles(), max_size=4)))
    deepest = max((-obstacle.level_range[0] for obstacle in rows), default=0)
    return Recipe(
        chunk_size=chunk_size,
        chunks=chunks,
        unit_cm=draw(st.sampled_from([10, 1, 8.5])),
        boundary=draw(st.sampled_from(["none", "divided", "outer"])),
        mesh_type=draw(st.sampled_from(["single", "multi", "pallet"])),
        seed=draw(SEEDS),
        ground_level=deepest + draw(st.sampled_from([0, 0, 3])),
        obstacles=rows,
    )
