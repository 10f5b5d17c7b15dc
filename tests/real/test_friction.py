"""Friction is felt inside the simulator: what is pushed slides on slippery blocks and frames, and stays elsewhere.

Gazebo Sim's default engine gives meshes a coefficient of 1, whatever the file says, and boxes their own.
"""

from __future__ import annotations

from pathlib import Path

import pytest

import rsegen
from rsegen.simulators.base import Installation
from tests.real.bodies import SIZE, body, furnished, tilt
from tests.real.maps import few_short, generated, lanes, map_name, slippery
from tests.simulators.simulated import simulated


@pytest.mark.parametrize("recipe", few_short(slippery()), ids=map_name)
def test_a_cube_that_is_pushed_slides_where_it_is_slippery_alone(
    recipe: rsegen.Recipe, gazebo: Installation, tmp_path: Path
) -> None:
    made = generated(recipe, tmp_path)
    beside = ("ground", (-made.scene.field.extent[0], 0.0, 0.0), False)
    meshes_slide = gazebo.backend == "classic" or has_boxes(recipe)
    cubes = {name: (place, slides and meshes_slide) for name, place, slides in [*lanes(made.scene), beside]}
    world = furnished(made.world, [body(name, "cube", place) for name, (place, _) in cubes.items()])
    tilt(world)

    run = simulated(gazebo, world, steps=400)

    assert not run.errors
    assert {slides for _, slides in cubes.values()} == ({True, False} if meshes_slide else {False})
    for name, ((x, y, top), slides) in cubes.items():
        at = run.poses[name]
        assert at.z == pytest.approx(top + SIZE / 2, abs=0.001), name
        assert at.y == pytest.approx(y, abs=0.01), name
        assert 0.15 < at.x - x < 0.25 if slides else abs(at.x - x) < 0.002, name


def has_boxes(recipe: rsegen.Recipe) -> bool:
    """Return whether its blocks are boxes for the physics engine."""
    return recipe.mesh_type == "multi" or recipe.collision != "mesh"
