"""Rays that meet cells, and obstacles chosen by a cell."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from rsegen import Peak, Random, Recipe, build, compose
from rsegen.gui.model.document import Document
from rsegen.gui.model.painting import cell_hit, is_inside
from rsegen.gui.model.session import Session

FIELD = build(Recipe(seed=1, chunk_size=6, chunks=(2, 1), obstacles=[Random(levels=5)]))
EAST, HIGH = np.array([10.0, 0.0, 0.0]), np.array([0.0, 0.0, 5.0])


def top(i: int, j: int) -> np.ndarray:
    """The middle of the top of a cell."""
    x, y = (np.array([i, j]) + 0.5) * FIELD.block_width - np.array(FIELD.extent) / 2
    return np.array([x, y, FIELD.heights[i, j]])


def test_from_above_every_cell_is_met() -> None:
    for i, j in np.ndindex(*FIELD.shape):
        point = top(i, j)
        assert cell_hit(FIELD, point + HIGH, point - HIGH) == (i, j)


@pytest.mark.parametrize("direction", [(0.45, -0.85, 0.75), (-1.0, 0.2, 0.3), (0.0, 1.0, 0.43)])
def test_along_a_slant_the_first_cell_is_met_as_by_small_steps(direction: tuple[float, float, float]) -> None:
    for i, j in itertools.product(range(0, FIELD.shape[0], 3), range(FIELD.shape[1])):
        start, stop = top(i, j) + 4 * np.array(direction), top(i, j) - 0.5 * np.array(direction)
        way = start + np.linspace(0, 1, 40_000)[:, None] * (stop - start)
        cells = np.floor((way[:, :2] + np.array(FIELD.extent) / 2) / FIELD.block_width).astype(int)
        inside = ((cells >= 0) & (cells < FIELD.shape)).all(axis=1)
        x, y = np.clip(cells, 0, np.array(FIELD.shape) - 1).T
        first = int(np.argmax(inside & (way[:, 2] <= FIELD.heights[x, y])))
        assert cell_hit(FIELD, start, stop) == (x[first], y[first])


def test_a_ray_past_or_over_the_map_meets_nothing() -> None:
    assert cell_hit(FIELD, EAST + HIGH, EAST - HIGH) is None
    assert cell_hit(FIELD, EAST + HIGH, HIGH - EAST) is None


def test_a_cell_is_in_a_window_but_not_at_its_end() -> None:
    window = (slice(1, 3), slice(0, 2))
    assert is_inside((1, 1), window)
    assert not is_inside((3, 1), window)
    assert not is_inside((1, 2), window)
    assert not is_inside((1, 1), None)


def test_the_last_obstacle_around_a_cell_is_chosen_and_none_outside_all() -> None:
    obstacles = [
        Random(levels=3, first=(0, 0), last=(9, 9)),
        Peak(levels=4, first=(2, 2), last=(5, 5)),
        Peak(levels=4, first=(8, 8), last=(7, 6)),
    ]
    recipe = Recipe(seed=1, boundary="none", obstacles=obstacles, chunks=(2, 1))
    document = Document(Session.imported(recipe))
    field = compose(recipe).field
    for cell, row in (((0, 0), 0), ((3, 5), 1), ((7, 7), 2), ((6, 7), 0), ((15, 3), -1), (None, -1)):
        document.select_at(cell, field)
        assert document.selected == row
    document.session.enable(1, enabled=False)
    document.select_at((3, 5), field)
    assert document.selected == 0
