"""A real Gazebo Classic loads what rsegen writes, without an error, and has in it what the recipe says.

test_resting has more maps, of every example, mesh type and boundary.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import rsegen
from rsegen.errors import SimulatorFailed
from rsegen.simulators.base import Installation
from tests.real.bodies import SIZE, body
from tests.real.maps import every_kind, few, few_short, generated, map_name, textured, variants
from tests.real.places import expected_places, places
from tests.simulators.simulated import simulated


@pytest.mark.parametrize("recipe", few_short([*few(textured()), every_kind()]), ids=map_name)
def test_gazebo_loads_every_look_and_kind(recipe: rsegen.Recipe, gazebo: Installation, tmp_path: Path) -> None:
    made = generated(recipe, tmp_path)

    run = simulated(gazebo, made.world, steps=100)

    assert not run.errors
    assert places(run.poses) == expected_places(made.scene)


def test_gazebo_finds_the_model_package_by_its_name(gazebo: Installation, tmp_path: Path) -> None:
    recipe = next(recipe for recipe in variants() if recipe.mesh_type == "single")
    made = generated(recipe, tmp_path / "models")
    field = made.scene.field
    i, j = np.unravel_index(int(field.heights.argmax()), field.shape)
    x, y = ((line[k] + line[k + 1]) / 2 for line, k in zip(field.edges(), (i, j), strict=True))
    included = f"<include><uri>model://{made.scene.name}</uri><pose>3 -2 0 0 0 0</pose></include>\n"
    dropped = body("cube", "cube", (3 + x, -2 + y, field.heights.max() + 0.01))
    world = tmp_path / "other.world"
    world.write_text(f'<sdf version="1.6">\n  <world name="other">\n{included}{dropped}  </world>\n</sdf>\n')

    run = simulated(gazebo, world, steps=500, models=made.folder.parent)

    assert not run.errors
    assert run.poses["cube"].z == pytest.approx(field.heights.max() + SIZE / 2, abs=0.001)


def test_a_missing_mesh_is_an_error(gazebo: Installation, tmp_path: Path) -> None:
    """Of the log; Harmonic ends."""
    made = generated(next(iter(variants())), tmp_path)
    for mesh in made.folder.glob("meshes/*.obj"):
        mesh.unlink()

    try:
        errors = simulated(gazebo, made.world, steps=1).errors
    except SimulatorFailed as error:
        errors = str(error).splitlines()
    assert any("Err" in line for line in errors)
