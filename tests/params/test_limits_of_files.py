"""The limits of a flag hold for the same value from a file: it is refused, or what is used is within them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

import rsegen
from rsegen.errors import UserError
from rsegen.experiments.plan import load_plan
from rsegen.field.crossing import SIDE, SPEED, TURN
from rsegen.heights.base import imported, importer_for
from rsegen.params.command import declared
from rsegen.params.sorts import Float, Integer, parameters
from rsegen.recipe.inventory_file import inventory_in
from rsegen.recipe.recipe import Recipe
from rsegen.recipe.recipe_file import load
from rsegen.robots.files.sdf_file import from_file

MODEL = (
    '<sdf version="1.6"><model name="cart"><link name="base"><collision name="c"><geometry><box><size>{side} 0.3 0.1'
    '</size></box></geometry></collision></link><joint name="l" type="revolute">'
    "<parent>base</parent><child>lw</child><axis><xyz>0 1 0</xyz></axis></joint>"
    '<joint name="r" type="revolute"><parent>base</parent><child>rw</child><axis><xyz>0 1 0</xyz></axis></joint>'
    '<link name="lw"/><link name="rw"/><plugin name="d" '
    'filename="libgazebo_ros_diff_drive.so"><left_joint>l</left_joint><right_joint>r</right_joint><wheel_separation>0.3'
    "</wheel_separation><wheel_radius>0.03</wheel_radius><max_linear_velocity>{speed}</max_linear_velocity>"
    "<max_angular_velocity>{turn}</max_angular_velocity></plugin></model></sdf>"
)
SHEET = (
    "# unit_cm: {unit}\n# block_width_cm: {width}\n# boundary: none\n"
    "pallet,order,x,y,height_cm\n1,1,0,0,0\n1,1,1,0,0\n1,1,0,1,0\n1,1,1,1,0\n"
)


def robot(folder: Path, **values: object) -> Any:
    path = folder / "cart.sdf"
    path.write_text(MODEL.format(**{"side": 0.4, "speed": 0.3, "turn": 1} | values), "utf-8")
    return from_file(path)


def heights(folder: Path, name: str, text: str) -> Recipe:
    path = folder / name
    path.write_text(text, "utf-8")
    return imported(path, importer_for(path)())


def ros_map(folder: Path, resolution: float) -> Recipe:
    (folder / "map.pgm").write_bytes(b"P2 2 2 255 0 255 255 0\n")
    return heights(folder, "map.yaml", f"image: map.pgm\nresolution: {resolution!r}\n")


def plan(folder: Path, **row: object) -> Any:
    path = folder / "plan.yaml"
    text = ", ".join(f"{key}: {value}" for key, value in row.items())
    path.write_text(f"rows:\n- {{sizes: [10], {text}}}\n", "utf-8")
    return load_plan(str(path)).rows[0]


def recipe(folder: Path, name: str, value: object) -> Any:
    path = folder / "r.yaml"
    path.write_text(f"{name}: {value}\n", "utf-8")
    return getattr(load(path), name)


def inventory(folder: Path, count: object) -> int:
    path = folder / "inv.csv"
    path.write_text(f"height_cm,count\n10,{count}\n", "utf-8")
    return inventory_in(path, 10)[0]


@dataclass(frozen=True)
class Pair:
    """The sort of a flag, and what is used of the same value from a file."""

    sort: Any
    used: Callable[[Path, Any], Any]


OF_RECIPE = parameters(Recipe)
UNIT, WIDTH = OF_RECIPE["unit_cm"], OF_RECIPE["block_width_cm"]
PAIRS: Mapping[str, Pair] = {
    "--size, SDF": Pair(SIDE, lambda folder, value: robot(folder, side=value).size[0]),
    "--speed, SDF": Pair(SPEED, lambda folder, value: robot(folder, speed=value).speed),
    "--turn, SDF": Pair(TURN, lambda folder, value: robot(folder, turn=value).turn),
    "--unit-cm, a table of levels": Pair(
        UNIT,
        lambda folder, value: heights(folder, "t.csv", f"# block levels in units of {value} cm\n0 1\n1 0\n").unit_cm,
    ),
    "--unit-cm, a build sheet": Pair(
        UNIT, lambda folder, value: heights(folder, "s.csv", SHEET.format(unit=value, width=10)).unit_cm
    ),
    "--block-width-cm, a build sheet": Pair(
        WIDTH, lambda folder, value: heights(folder, "s.csv", SHEET.format(unit=10, width=value)).block_width_cm
    ),
    "--block-width-cm, a map of ROS": Pair(
        WIDTH, lambda folder, value: ros_map(folder, float(value) / 100).block_width_cm
    ),
    "--robots, a plan": Pair(
        declared(rsegen.drive)["robots"].sort, lambda folder, value: plan(folder, robots=value).robots
    ),
    "--unit-cm, a plan": Pair(UNIT, lambda folder, value: plan(folder, unit_cm=value).unit_cm),
    "--inventory, its file": Pair(Integer(0, 10**9), inventory),
} | {
    f"--{name}, a recipe": Pair(sort, lambda folder, value, name=name: recipe(folder, name, value))  # type: ignore[misc]  # of mypy: a lambda with a default
    for name, sort in OF_RECIPE.items()
    if isinstance(sort, (Float, Integer))
}


def edges(sort: Float | Integer) -> list[float]:
    """Numbers at the limits, and beyond them."""
    low, high = sort.low, sort.high if sort.high is not None else 10**6
    if isinstance(sort, Integer):
        return [low, low - 1, high, high + 1, 1000 * high]
    return [low, low / 2 - 1e-6, high, high * 1.001, 1000 * high, 1e37]


@pytest.mark.parametrize("name", PAIRS)
def test_a_file_gives_no_value_that_the_flag_refuses(name: str, tmp_path: Path) -> None:
    pair, sort = PAIRS[name], PAIRS[name].sort
    used = 0
    for value in edges(sort):
        with suppress(UserError):
            found = pair.used(tmp_path, value)
            assert sort.low <= found <= (sort.high or math.inf)
            used += found == pytest.approx(value)
    assert used
