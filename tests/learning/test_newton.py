"""A map in Newton: its shapes are the map's boxes or surface, each with its own friction."""

from __future__ import annotations

import numpy as np
import pytest

from rsegen import Placement, Random, Recipe, compose
from rsegen.errors import UnknownName

newton = pytest.importorskip("newton", reason="Newton is not installed")
from rsegen.learning.newton import add_map  # noqa: E402  # it needs Newton

SCENE = compose(
    Recipe(
        seed=3,
        chunk_size=6,
        unit_cm=5,
        boundary="none",
        level_friction=(0.2, 0.4, 0.6),
        obstacles=[Placement(obstacle=Random(max_height=4))],
    )
)


@pytest.mark.parametrize("shape", ["boxes", "mesh"])
def test_every_level_has_its_friction(shape: str) -> None:
    builder = newton.ModelBuilder()
    shapes = add_map(builder, SCENE, shape=shape)
    frictions = {round(builder.shape_material_mu[number], 6) for number in shapes}
    assert frictions == {0.2, 0.4, 0.6}
    assert builder.body_count == 0
    assert (len(shapes) == 3) == (shape == "mesh")
    assert builder.finalize(device="cpu").shape_count == len(shapes)


def test_boxes_are_the_heights_of_the_cells() -> None:
    builder = newton.ModelBuilder()
    shapes = add_map(builder, SCENE, pos=(1, 2, 0.5))
    found = np.zeros(SCENE.field.shape)
    x, y = ((edges[:-1] + edges[1:]) / 2 for edges in SCENE.field.edges())
    for number in shapes:
        centre, half = (
            np.array(builder.shape_transform[number][:3]) - (1, 2, 0.5),
            np.array(builder.shape_scale[number]),
        )
        inside = np.ix_(np.abs(x - centre[0]) < half[0], np.abs(y - centre[1]) < half[1])
        assert not found[inside].any()
        assert centre[2] - half[2] == pytest.approx(0, abs=1e-6)
        found[inside] = centre[2] + half[2]
    assert np.allclose(found, SCENE.field.heights, atol=1e-6)


def test_an_unknown_shape_is_said() -> None:
    with pytest.raises(UnknownName, match=r"unknown shape 'hfield' .*boxes, mesh"):
        add_map(newton.ModelBuilder(), SCENE, shape="hfield")
