"""A real Gazebo Classic loads what rsegen writes, without an error, and has in it what the recipe says."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

import rsegen
from rsegen.simulation.simulators import Installation
from rsegen.simulation.simulators.live_world import Pose
from tests.simulation.real.bodies import SIZE, body
from tests.simulation.real.maps import examples, generated, kinds, map_name, textured, variants
from tests.simulation.simulated import simulated

Place = tuple[float, float, float]


@pytest.mark.parametrize("recipe", [*examples(), *variants(), *textured(), *kinds()], ids=map_name)
def test_gazebo_loads_every_map(recipe: rsegen.Recipe, gazebo: Installation, tmp_path: Path) -> None:
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


def test_a_missing_mesh_is_an_error_in_the_log(gazebo: Installation, tmp_path: Path) -> None:
    made = generated(next(iter(variants())), tmp_path)
    for mesh in made.folder.glob("meshes/*.obj"):
        mesh.unlink()

    assert simulated(gazebo, made.world, steps=1).errors


def places(poses: Mapping[str, Pose]) -> dict[str, Place]:
    """To the micrometre."""
    return {name: micrometres(pose.x, pose.y, pose.z) for name, pose in poses.items()}


def expected_places(scene: rsegen.Scene) -> dict[str, Place]:
    """The ground, and the one mesh, or the pallets, or a box for each cell above the ground."""
    models = {"single": mesh, "pallet": pallets, "multi": boxes}[scene.recipe.mesh_type](scene)
    return {"ground_plane": (0.0, 0.0, 0.0)} | models


def mesh(scene: rsegen.Scene) -> dict[str, Place]:
    return {scene.name: (0.0, 0.0, 0.0)}


def pallets(scene: rsegen.Scene) -> dict[str, Place]:
    found = scene.field.chunks(scene.recipe.chunk_size)
    return {"pallet_{}_{}".format(*pallet.index): micrometres(*pallet.centre, 0) for pallet in found}


def boxes(scene: rsegen.Scene) -> dict[str, Place]:
    field = scene.field
    blocks = np.ndindex(*field.blocks.shape)
    x, y = (((line[:-1] + line[1:]) / 2).tolist() for line in field.edges())
    heights = field.heights.tolist()
    found = {}
    for i, j in np.ndindex(*field.shape):
        name = f"frame_{i}_{j}" if field.frame[i, j] else "block_{}_{}".format(*next(blocks))
        if heights[i][j]:
            found[name] = micrometres(x[i], y[j], heights[i][j] / 2)
    return found


def micrometres(x: float, y: float, z: float) -> Place:
    return round(x, 6), round(y, 6), round(z, 6)
