"""What the 3D view shows, without the view."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from rsegen import Random, Recipe, Scene, compose
from rsegen.field.stepfield import Array, coarse, coarse_window, coarseness
from rsegen.geometry import NORMALS, surface
from rsegen.gui.model.colours import GROUND, bright, cells, legend, palette
from rsegen.gui.model.solid import (
    SOUTH_EAST,
    VIEW_ANGLE,
    block_edges,
    box_edges,
    lit,
    round_numbers,
    tick_marks,
    viewpoint,
)

BOUNDS = (-2.0, 2.0, -1.0, 1.0, 0.0, 0.4)


def scene(boundary: str = "divided", levels: int = 5) -> Scene:
    obstacles = [Random(levels=levels)]
    return compose(Recipe(seed=1, chunk_size=4, boundary=boundary, unit_cm=7, obstacles=obstacles))


def test_tops_have_the_colours_of_the_legend() -> None:
    made = lit(scene()).blocks
    tops = surface(scene().field).normals == [*map(tuple, NORMALS)].index((0, 0, 1))
    assert {tuple(colour) for colour in made.colours[tops].tolist()} == {colour for colour, _ in legend(scene())}


def test_a_flat_map_has_no_faces_and_can_be_outlined() -> None:
    flat = compose(Recipe(seed=1, boundary="none"))
    assert len(lit(flat).blocks.faces) == 0
    assert len(block_edges(flat.field).pairs) == 4 * 100


def test_every_block_has_a_ring_as_high_as_it_is() -> None:
    field = scene().field
    rings = block_edges(field).points[: 4 * field.levels.size].reshape(-1, 4, 3)
    assert np.allclose(rings[..., 2], field.heights.ravel()[:, None])
    assert np.allclose(np.ptp(rings[..., :2], axis=1), field.block_width)


def test_a_post_stands_where_a_block_does() -> None:
    field = scene("none").field
    edges = block_edges(field)
    posts = edges.points[4 * field.levels.size :].reshape(-1, 2, 3)
    assert (posts[:, 0, 2] == 0).all()
    assert set(posts[:, 1, 2]) <= set(field.heights.ravel())
    assert edges.pairs.max() == len(edges.points) - 1


def test_a_box_encloses_its_window() -> None:
    field = scene().field
    box = box_edges(field, (slice(1, 3), slice(2, 5)))
    lines = [line[part] for line, part in zip(field.edges(), ([1, 3], [2, 5]), strict=True)]
    assert set(map(tuple, box.points[:, :2])) == set(itertools.product(*(line.tolist() for line in lines)))
    assert box.points[:, 2].max() > field.heights[1:3, 2:5].max()
    assert len(box.pairs) == 12


def test_the_legend_names_every_height_and_the_frame() -> None:
    assert [name for _, name in legend(scene())] == ["28 cm", "21 cm", "14 cm", "7 cm", "frame, 10 cm"]
    assert [name for _, name in legend(scene("none"))] == ["28 cm", "21 cm", "14 cm", "7 cm"]


def test_the_legend_of_many_levels_stays_small() -> None:
    assert len(legend(compose(Recipe(seed=1, obstacles=[Random(levels=90)])))) <= 25


def test_cells_have_the_colour_of_their_level() -> None:
    shown = scene()
    colours, frame, levels = cells(shown), shown.field.frame, shown.field.levels
    assert (colours[frame] == palette(shown)[0]).all()
    assert (colours[(levels == 0) & ~frame] == GROUND).all()
    assert (colours[levels == 4] == palette(shown)[4]).all()


def test_ink_is_dark_on_bright_ground() -> None:
    assert bright(np.array([[255, 255, 255], [0, 0, 60]], dtype=np.uint8)).tolist() == [True, False]


@pytest.mark.parametrize("extent", [0.003, 0.8, 2.4, 60, 1234.5])
def test_axes_have_a_few_round_numbers(extent: float) -> None:
    found = round_numbers(-extent / 2, extent / 2)
    assert 3 <= len(found) <= 9
    assert 0 in found
    assert max(map(abs, found)) <= extent / 2 + 1e-9


def test_marks_are_outside_the_map() -> None:
    found = tick_marks(BOUNDS, 0.3)
    assert {"x = 2 m", "y = 1 m", "-2", "0"} <= set(found.texts)
    assert all(x > 2 or y < -1 for x, y, _ in found.places)
    assert len(found.lines.pairs) == len(found.texts) == len(found.places)


def test_a_short_side_has_few_numbers() -> None:
    found = tick_marks((-30.0, 30.0, -0.6, 0.6, 0.0, 0.5), 3.0)
    assert found.texts[-3:] == ["-0.5", "0", "y = 0.5 m"]


@pytest.mark.parametrize("aspect", [0.5, 1.0, 2.5])
@pytest.mark.parametrize("direction", [SOUTH_EAST, np.array([0.0, 0.0, 1.0]), np.array([-1.0, 3.0, 0.1])])
def test_the_whole_map_is_in_sight_and_fills_the_view(aspect: float, direction: Array) -> None:
    position, focus = viewpoint(BOUNDS, direction, margin=0.1, aspect=aspect)
    back = (position - focus) / np.linalg.norm(position - focus)
    assert np.allclose(back, direction / np.linalg.norm(direction))
    across = np.cross((0, 0, 1), back) if np.any(back[:2]) else np.array([1.0, 0, 0])
    across = across / np.linalg.norm(across)
    corners = np.array(list(itertools.product((-2.1, 2.1), (-1.1, 1.1), (0, 0.4)))) - position
    depth, tangent = -corners @ back, np.tan(np.radians(VIEW_ANGLE / 2))
    beside = np.abs(corners @ across) / depth / tangent / aspect
    above = np.abs(corners @ np.cross(back, across)) / depth / tangent
    assert max(beside.max(), above.max()) == pytest.approx(1.0)


@pytest.mark.parametrize("factor", [1, 2, 3, 5])
def test_a_coarse_field_has_the_highest_of_the_cells_it_stands_for(factor: int) -> None:
    field = scene().field
    made = coarse(field, factor)
    for i, j in np.ndindex(*made.shape):
        part = field.heights[i * factor : (i + 1) * factor, j * factor : (j + 1) * factor]
        assert made.heights[i, j] == part.max()
    assert made.shape == (6 // factor, 6 // factor)
    assert made.block_width == pytest.approx(factor * field.block_width)


@pytest.mark.parametrize(("most", "factor"), [(6, 1), (5, 2), (3, 2), (2, 3), (1, 6)])
def test_a_field_becomes_no_finer_than_asked_for(most: int, factor: int) -> None:
    assert coarseness(scene().field, most) == factor


def test_a_window_is_found_again_among_coarse_cells() -> None:
    assert coarse_window(scene().field, (slice(1, 3), slice(2, 5)), 2) == (slice(0, 2), slice(1, 3))
    assert coarse_window(scene().field, (slice(5, 6), slice(0, 6)), 4) == (slice(0, 1), slice(0, 1))
