"""Light and shadow of the 3D view, and its scale bar, without the view."""

from __future__ import annotations

import numpy as np
import pytest

from rsegen import Matrix, Random, Recipe, Scene, compose
from rsegen.field.stepfield import StepField
from rsegen.gui.model.solid import SUN, Shading, border, foot, length_text, lit, round_length, shading


def scene(*rows: str) -> Scene:
    matrix = Matrix(levels=9, rows=rows)
    return compose(Recipe(seed=1, chunk_size=len(rows), boundary="none", obstacles=[matrix]))


def tower() -> StepField:
    """A block of 30 cm in the middle of 9 x 9 flat cells of 10 cm."""
    return scene(*["0 0 0 0 0 0 0 0 0"] * 4, "0 0 0 0 3 0 0 0 0", *["0 0 0 0 0 0 0 0 0"] * 4).field


def at(found: Shading, x: float, y: float) -> float:
    """The light at a place of the map, metres."""
    places = (np.array([x, y]) - found.low) / np.subtract(found.high, found.low) * found.light.shape
    i, j = places.astype(int)
    return float(found.light[i, j])


def test_a_tower_throws_its_shadow_away_from_the_sun() -> None:
    found, (x, y, _) = shading(tower(), 0.1), np.array(SUN) / np.hypot(*SUN[:2])
    assert at(found, -0.15 * x, -0.15 * y) < 0.75
    assert at(found, 0.2 * x, 0.2 * y) > 0.9
    assert at(found, -0.4, 0.4) == 1


def test_tops_above_everything_have_full_light() -> None:
    assert at(shading(tower(), 0.1), 0, 0) == 1


def test_the_foot_of_a_wall_is_darker_than_the_ground_a_block_away() -> None:
    found = shading(tower(), 0.1)
    assert at(found, 0.055, 0) < at(found, 0.2, 0) == pytest.approx(1, abs=0.02)
    assert foot(np.array([0.0, 0.5, 1.5, 9.0])).tolist() == pytest.approx([0.664, 0.850667, 1, 1])


def test_flat_ground_is_lit_evenly() -> None:
    assert (shading(scene("0").field, 0.1).light == 1).all()


def test_the_rim_is_lit_too_and_lies_around_the_field() -> None:
    found = shading(tower(), 0.15)
    assert found.high == pytest.approx((0.65, 0.65))
    assert found.low == pytest.approx((-0.65, -0.65))


def test_the_light_map_of_a_huge_map_is_not_huge() -> None:
    sides = [
        shading(compose(Recipe(seed=1, chunk_size=side, boundary="none")).field, 0.1).light.shape for side in (9, 400)
    ]
    assert [side[0] for side in sides] == [110, 402]


def test_every_corner_of_a_top_is_at_its_own_place_of_the_light_map() -> None:
    random = compose(Recipe(seed=1, chunk_size=4, obstacles=[Random(levels=5)]))
    made, rim = lit(random), border(random.field)
    found = shading(random.field, rim)
    top = made.blocks.points[made.blocks.faces][np.ptp(made.blocks.points[made.blocks.faces][..., 2], axis=1) == 0]
    places = made.blocks.places[made.blocks.faces][np.ptp(made.blocks.points[made.blocks.faces][..., 2], axis=1) == 0]
    share = found.light.shape[1] / made.light.shape[1]
    wanted = (top[..., :2] - np.array(found.low)) / np.subtract(found.high, found.low) * (1, share)
    assert np.allclose(places, wanted, atol=1e-5)
    assert np.array_equal(made.light[:, : found.light.shape[1]], found.light)


def test_walls_are_darkest_at_their_foot() -> None:
    made = lit(compose(Recipe(seed=1, chunk_size=4, obstacles=[Random(levels=5)])))
    corners = made.blocks.points[made.blocks.faces]
    walls = np.ptp(corners[..., 2], axis=1) > 0
    rows = made.light[0, (made.blocks.places[made.blocks.faces][walls][..., 1] * made.light.shape[1]).astype(int)]
    low = corners[walls][..., 2] == corners[walls][..., 2].min(axis=1, keepdims=True)
    assert rows[low].max() < rows[~low].min()


@pytest.mark.parametrize(("most", "length"), [(0.7, 0.5), (1.0, 1.0), (49.0, 20.0), (0.051, 0.05), (1000.0, 1000.0)])
def test_a_scale_bar_has_a_round_length(most: float, length: float) -> None:
    assert round_length(most) == length


def test_short_lengths_are_in_centimetres() -> None:
    assert [length_text(length) for length in (0.05, 0.5, 1.0, 20.0)] == ["5 cm", "50 cm", "1 m", "20 m"]
