"""What a robot can do, in space: lines lie on the blocks, and what hides blocks covers just those that it hides."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from rsegen import Random, Recipe, compose
from rsegen.gui.model.reach import Reach, Way, dashes, draped, reach_shape
from rsegen.gui.model.simulation import reach
from rsegen.gui.model.solid import solid
from rsegen.standing.spots import Outline

RECIPE = Recipe(seed=5, chunk_size=6, chunks=(3, 2), obstacles=[Random(levels=4)])
FIELD = compose(RECIPE).field
OUTLINE = Outline(-0.1, -0.1, 0.1, 0.1)


def under(x: float, y: float) -> float:
    """The height of the map at a place."""
    i, j = np.floor(np.array([x, y]) / FIELD.block_width + np.array(FIELD.shape) / 2).astype(int)
    inside = 0 <= i < FIELD.shape[0] and 0 <= j < FIELD.shape[1]
    return float(FIELD.heights[i, j]) if inside else 0.0


@pytest.mark.parametrize("points", [[(-1.2, 0.03), (1.2, 0.03)], [(-1.5, -1.1), (0.31, 0.2), (0.3, 0.93)]])
def test_a_line_lies_on_the_blocks_with_vertical_parts_between(points: list[tuple[float, float]]) -> None:
    line = draped(FIELD, np.array(points))
    flat = np.linalg.norm(np.diff(line[:, :2], axis=0), axis=1)
    assert np.isclose(flat.sum(), np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    assert np.allclose(line[[0, -1], :2], [points[0], points[-1]])
    for (start, end), length in zip(pairwise(line), flat, strict=True):
        if length > 1e-9:
            assert start[2] == end[2] == under(*(start[:2] + end[:2]) / 2)


def test_dashes_are_every_second_part() -> None:
    line = np.array([(0, 0, 0), (0.35, 0, 0), (0.35, 0, 0.25), (1, 0, 0.25)], dtype=float)
    found = dashes(line, 0.1)
    ends = found.points[found.pairs]
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    assert np.isclose(lengths.sum(), 0.65)
    assert lengths.max() < 0.1 + 1e-9


def area(points: np.ndarray, *, level: bool) -> float:
    """The area of faces of four points each that are level, or of those that are not."""
    corners = points.reshape(-1, 4, 3).astype(float)
    flat = np.ptp(corners[..., 2], axis=1) == 0
    kept = corners[flat if level else ~flat]
    return float(np.linalg.norm(np.cross(kept[:, 1] - kept[:, 0], kept[:, 3] - kept[:, 0]), axis=1).sum())


def test_the_veil_is_as_large_as_the_blocks_that_are_not_reached() -> None:
    scene = compose(RECIPE)
    found = reach(FIELD, "burger", 5)
    veil = reach_shape(scene, found).veil
    hidden = (~found.region & ~FIELD.frame).sum()
    assert hidden > 0
    assert np.isclose(area(veil.points, level=True), hidden * FIELD.block_width**2, rtol=1e-4)


def test_a_veil_over_everything_is_the_surface_of_all_blocks() -> None:
    scene = compose(replace(RECIPE, boundary="none"))
    nothing = np.zeros(scene.field.shape, dtype=bool)
    shape = reach_shape(scene, Reach("", nothing, (), (), OUTLINE))
    assert np.isclose(area(shape.veil.points, level=False), area(solid(scene).points, level=False), rtol=1e-4)
    assert not shape.ways
    assert not shape.spots


def test_spots_and_paths_match_the_plan() -> None:
    scene = compose(replace(RECIPE, unit_cm=0.1))
    found = reach(scene.field, "burger", 5)
    shape = reach_shape(scene, found)
    assert [spot.name for spot in shape.spots] == ["S", "G"][: len(found.spots)]
    assert found.spots
    for spot, place in zip(shape.spots, found.spots, strict=True):
        assert spot.middle[2] >= place.z
    assert [way.is_eastward for way in shape.ways] == [way.is_eastward for way in found.ways]


def test_a_way_that_is_too_steep_is_dashed() -> None:
    scene = compose(RECIPE)
    nothing = np.zeros(scene.field.shape, dtype=bool)
    points = np.array([(-0.6, 0.0), (0.6, 0.0)])
    shapes = [
        reach_shape(scene, Reach("", nothing, (Way(points, is_eastward=True, is_too_steep=steep),), (), OUTLINE))
        for steep in (False, True)
    ]
    solid_line, dashed = (
        np.linalg.norm(np.diff(shape.ways[0].lines.points[shape.ways[0].lines.pairs], axis=1), axis=2).sum()
        for shape in shapes
    )
    assert dashed == pytest.approx(solid_line / 2, rel=0.1)
