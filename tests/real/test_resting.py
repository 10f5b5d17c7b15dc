"""Maps are true inside the simulator: models are in their places, and what is dropped on a block rests on its top."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import rsegen
from rsegen.cli.edge import main
from rsegen.simulators.base import Installation
from tests.real.falling import FALL, bodies, falling, judge, spots
from tests.real.maps import Map, examples, few, generated, map_name, variants
from tests.real.places import expected_places, places
from tests.simulators.simulated import simulated
from tests.support.long import long_unless


@pytest.mark.parametrize("recipe", few([*examples(), *variants()]), ids=map_name)
def test_models_are_in_their_places_and_bodies_rest_on_their_cells(
    recipe: rsegen.Recipe, gazebo: Installation, tmp_path: Path
) -> None:
    bodies_rest(generated(recipe, tmp_path), gazebo)


GROUND = """<model name="ground_plane"><static>true</static><link name="link"><collision name="collision">
<geometry><plane><normal>0 0 1</normal><size>200 200</size></plane></geometry></collision></link></model>
"""


@pytest.mark.long(reason="thousands of boxes")
def test_bodies_rest_on_every_example(gazebo: Installation, tmp_path: Path) -> None:
    """All of them are in one world, as models by their names, one east of another."""
    east, models, made = 0.0, [GROUND], list[tuple[Map, float]]()
    for recipe in examples():
        example = generated(recipe, tmp_path / "models")
        half = example.scene.field.extent[0] / 2 + 0.5
        made.append((example, east + half))
        name, field = example.scene.name, example.scene.field
        models.append(f"<include><uri>model://{name}</uri><pose>{east + half} 0 0 0 0 0</pose></include>\n")
        models += bodies(field, east + half, f"{name} ")
        east += 2 * half
    world = tmp_path / "examples.world"
    world.write_text(f'<sdf version="1.6">\n  <world name="examples">\n{"".join(models)}  </world>\n</sdf>\n')

    run = simulated(gazebo, world, steps=FALL, models=tmp_path / "models")

    assert not run.errors
    for example, place in made:
        judge(example.scene.field, run.poses, place, f"{example.scene.name} ")


HEIGHTS = np.array([[0, 10, 20, 30], [10, 10, 40, 0], [5, 15, 25, 35]])
"""North up, centimetres."""


@pytest.mark.parametrize(
    "name", long_unless("map.yaml".__eq__, ["heights.csv", "heights.png", "map.yaml"], reason="a server per file")
)
def test_bodies_rest_on_heights_from_elsewhere(name: str, gazebo: Installation, tmp_path: Path) -> None:
    walls = np.where(HEIGHTS > 20, 0, 254).astype(np.uint8)
    np.savetxt(tmp_path / "heights.csv", HEIGHTS, fmt="%d", delimiter=",")
    Image.fromarray((HEIGHTS * 257 * 255 // 40).astype(np.uint16)).save(tmp_path / "heights.png")
    Image.fromarray(walls).save(tmp_path / "map.pgm")
    (tmp_path / "map.yaml").write_text("image: map.pgm\nresolution: 0.2\norigin: [0, 0, 0]\nnegate: 0\n")
    how = {"heights.csv": ["--unit-cm", "5"], "heights.png": ["--unit-cm", "5", "--levels", "9"], "map.yaml": []}

    made = from_command(tmp_path / "worlds", "import", tmp_path / name, *how[name])

    heights = np.where(HEIGHTS > 20, made.scene.field.heights.max(), 0) if name == "map.yaml" else HEIGHTS / 100
    assert np.allclose(made.scene.field.heights.T[::-1], heights)
    bodies_rest(made, gazebo)


def test_bodies_rest_on_the_blocks_of_an_inventory(gazebo: Installation, tmp_path: Path) -> None:
    (tmp_path / "blocks.csv").write_text("height_cm,count\n10,30\n20,20\n30,10\n40,5\n")
    asked = ["--inventory", str(tmp_path / "blocks.csv"), "--max-step", "2"]

    made = from_command(
        tmp_path / "worlds", "generate", "--obstacle", "random levels=5", "--chunk-size", "6", *asked, "--seed", "1"
    )

    counts = made.scene.field.level_counts()
    assert all(counts.get(level, 0) <= owned for level, owned in enumerate((30, 20, 10, 5), 1))
    bodies_rest(made, gazebo)


def from_command(folder: Path, *arguments: str | Path) -> Map:
    """The one map that a command writes."""
    assert main([*map(str, arguments), "-o", str(folder)]) == 0
    (home,) = folder.iterdir()
    recipe = rsegen.load(home / "recipe.json")
    return Map(scene=rsegen.compose(recipe, recipe.first_map), folder=home)


def bodies_rest(made: Map, gazebo: Installation) -> None:
    """Assert that bodies on a few cells of every level and of the frame rest on their tops; nothing else is there."""
    run = simulated(gazebo, falling(made), steps=FALL)
    assert not run.errors
    judge(made.scene.field, run.poses)
    fallen = {name for name, *_ in spots(made.scene.field)}
    models = places({name: pose for name, pose in run.poses.items() if name not in fallen})
    if (
        made.scene.recipe.simulator == "both"
    ):  # for Classic alone a map is a body, which its solver may move by nanometres
        assert models == expected_places(made.scene)
