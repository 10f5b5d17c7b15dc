"""Step fields: frames, chunks, metres."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given

import rsegen
from rsegen import Recipe, StepField, boxes, build
from rsegen.errors import ParameterError
from rsegen.field.stepfield import framed
from tests.support.strategies import fields, recipes


def test_divided_is_a_single_outer_and_a_double_inner_boundary() -> None:
    _, frame = framed(np.ones((4, 4), dtype=np.int16), 2, "divided")
    line = "x..xx..x"
    rows = ["x" * 8 if mark == "x" else line for mark in line]
    assert ["".join("x" if cell else "." for cell in row) for row in frame] == rows


def test_outer_is_one_frame_round_the_map() -> None:
    levels, frame = framed(np.ones((2, 4), dtype=np.int16), 2, "outer")
    assert frame.shape == (4, 6)
    np.testing.assert_array_equal(levels == 1, ~frame)
    np.testing.assert_array_equal(np.argwhere(~frame).min(axis=0), [1, 1])


@given(recipes())
def test_pallets_put_together_are_the_map(recipe: Recipe) -> None:
    field = build(recipe)
    rebuilt = np.full(field.shape, -1)
    for pallet in field.chunks(recipe.chunk_size):
        low = [
            round((centre + whole / 2 - part / 2) / field.block_width)
            for centre, whole, part in zip(pallet.centre, field.extent, pallet.field.extent, strict=True)
        ]
        window = tuple(slice(at, at + cells) for at, cells in zip(low, pallet.field.shape, strict=True))
        assert (rebuilt[window] == -1).all()
        rebuilt[window] = pallet.field.levels
    np.testing.assert_array_equal(rebuilt, field.levels)


@given(recipes())
def test_every_chunk_has_a_pallet_with_all_its_blocks(recipe: Recipe) -> None:
    pallets = list(build(recipe).chunks(recipe.chunk_size))
    assert len(pallets) == recipe.chunks[0] * recipe.chunks[1]
    assert {pallet.field.blocks.shape for pallet in pallets} == {(recipe.chunk_size, recipe.chunk_size)}


@given(fields())
def test_counts_are_of_all_blocks(field: StepField) -> None:
    counts = field.level_counts()
    assert sum(counts.values()) == (~field.frame).sum()
    assert sum(level * count for level, count in counts.items()) == field.levels[~field.frame].sum(dtype=int)


def test_heights_of_equal_length_are_equal_numbers() -> None:
    field = build(Recipe(frame_height_cm=30, obstacles=()))
    tall = StepField(
        levels=np.full((1, 1), 3, dtype=np.int16),
        frame=np.zeros((1, 1), dtype=bool),
        block_width=0.1,
        unit=0.1,
        frame_height=0.3,
    )
    assert tall.heights[0, 0] == field.heights[0, 0] == 0.3


def test_arrays_are_read_only() -> None:
    field = build(Recipe())
    filled, mesh = boxes(field), rsegen.mesh(field)
    for array in (field.levels, field.frame, filled.low, filled.high, mesh.places, mesh.faces):
        with pytest.raises(ValueError, match="read-only"):
            array[0, 0] = 1


def test_the_map_is_centred_on_the_origin() -> None:
    x, y = build(Recipe(chunks=(2, 1), block_width_cm=8.5)).edges()
    assert x[0] == -x[-1] == -24 * 0.085 / 2
    assert y[0] == -y[-1] == -12 * 0.085 / 2


GOOD = {
    "levels": np.ones((2, 3), dtype=np.int16),
    "frame": np.zeros((2, 3), dtype=bool),
    "block_width": 0.1,
    "unit": 0.1,
    "frame_height": 0.0,
}


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("levels", [[1, 1, 1], [1, 1, 1]]),
        ("levels", np.ones((2, 3))),
        ("levels", -np.ones((2, 3), dtype=np.int16)),
        ("levels", np.ones(6, dtype=np.int16)),
        ("levels", np.ones((0, 3), dtype=np.int16)),
        ("frame", np.zeros((3, 2), dtype=bool)),
        ("frame", np.zeros((2, 3))),
        ("block_width", 0),
        ("block_width", float("nan")),
        ("unit", -0.1),
        ("unit", "10"),
        ("frame_height", -0.1),
    ],
)
def test_what_is_no_field_is_refused(name: str, value: object) -> None:
    StepField(**GOOD)  # type: ignore[arg-type]  # of these types
    with pytest.raises(ParameterError, match=f"^{name}: .+ is ") as refusal:
        StepField(**(GOOD | {name: value}))  # type: ignore[arg-type]  # other types on purpose
    assert "\n" not in str(refusal.value)
