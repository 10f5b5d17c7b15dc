"""Boxes rebuild the field, exactly, and never overlap."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given

from rsegen import StepField
from rsegen.geometry import Boxes, box_per_block, boxes
from tests.geometry.grids import GRIDS
from tests.support.strategies import fields


def stacked(found: Boxes, field: StepField) -> np.ndarray:
    """Number of boxes at every place between lines: (n_x, n_y, heights)."""
    heights = np.unique(np.append(field.heights, 0.0))
    lines = (*field.edges(), heights)
    counts = np.zeros([len(line) - 1 for line in lines], dtype=int)
    for low, high in zip(found.low, found.high, strict=True):
        part = [slice(*np.searchsorted(line, pair)) for line, *pair in zip(lines, low, high, strict=True)]
        assert [line[k.start] for line, k in zip(lines, part, strict=True)] == low.tolist()
        assert [line[k.stop] for line, k in zip(lines, part, strict=True)] == high.tolist()
        counts[tuple(part)] += 1
    return counts


@given(fields())
def test_boxes_rebuild_the_field_and_never_overlap(field: StepField) -> None:
    heights = np.unique(np.append(field.heights, 0.0))
    for found in (boxes(field), box_per_block(field)):
        np.testing.assert_array_equal(stacked(found, field), field.heights[:, :, None] > heights[:-1])


@pytest.mark.parametrize(("levels", "count"), [([[5]], 1), ([[3, 3], [3, 3]], 1), ([[2, 5, 2]], 2), ([[4, 0, 4]], 2)])
def test_layers_of_one_shape_are_one_box(levels: list[list[int]], count: int) -> None:
    heights = np.array(levels, dtype=np.int16)
    field = StepField(levels=heights, frame=heights < 0, block_width=0.1, unit=0.1, frame_height=0.0)
    assert len(boxes(field)) == count


@given(fields())
def test_merged_boxes_are_no_more_than_the_blocks(field: StepField) -> None:
    assert len(boxes(field)) <= len(box_per_block(field)) == (field.heights > 0).sum()


@pytest.mark.parametrize(("kind", "most"), [("uniform", 0.72), ("normal", 0.45), ("obstacles", 0.06), ("smooth", 0.06)])
def test_merged_boxes_are_few(kind: str, most: float) -> None:
    levels = GRIDS[kind](80, np.random.default_rng(1)).astype(np.int16)
    field = StepField(levels=levels, frame=levels < 0, block_width=0.1, unit=0.1, frame_height=0.1)
    assert len(boxes(field)) <= most * levels.size


def test_a_pyramid_is_a_box_for_every_step() -> None:
    levels = GRIDS["pyramid"](40, np.random.default_rng(1)).astype(np.int16)
    field = StepField(levels=levels, frame=levels < 0, block_width=0.1, unit=0.1, frame_height=0.1)
    assert len(boxes(field)) == 5
