"""The maps that simulators are given: every example, every mesh type and boundary, every obstacle kind."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import cycle, product
from pathlib import Path
from typing import Any

import numpy as np

import rsegen
from rsegen.gazebo import MESH_TYPES
from rsegen.recipe.examples import EXAMPLES
from tests.real.bodies import SIDEWAYS
from tests.support.long import long_unless

BOUNDARIES = ("none", "divided", "outer")


@dataclass(frozen=True, kw_only=True, slots=True)
class Map:
    """One map of a recipe, made and on disk."""

    scene: rsegen.Scene
    folder: Path

    @property
    def world(self) -> Path:
        """The file that a simulator opens."""
        return self.folder / f"{self.scene.name}.world"


def variants() -> Iterator[rsegen.Recipe]:
    """A small random map of two chunks in every mesh type with every boundary."""
    random = rsegen.Random(levels=4)
    for mesh_type, boundary in product(MESH_TYPES, BOUNDARIES):
        yield rsegen.Recipe(
            name=f"{mesh_type}-{boundary}",
            chunk_size=5,
            chunks=(2, 1),
            mesh_type=mesh_type,
            boundary=boundary,
            seed=1,
            obstacles=(random,),
        )


def few(recipes: Iterable[rsegen.Recipe]) -> list[rsegen.Recipe]:
    """Return the recipes with every mesh type, boundary and look once, or of few sorts of friction."""
    return [recipe for recipe in recipes if map_name(recipe) in FEW]


def example_of_each_shape() -> Iterator[rsegen.Recipe]:
    """Return the smallest of the examples in each shape."""
    found = sorted(examples(), key=lambda recipe: math.prod(recipe.chunks) * recipe.chunk_size**2)
    taken = {
        (recipe.mesh, recipe.collision, recipe.tile, recipe.simulator, recipe.look): recipe for recipe in found[::-1]
    }
    return iter(taken.values())


def textured() -> Iterator[rsegen.Recipe]:
    """A small map of two friction coefficients in every mesh type, with every look, shadows and a sky."""
    random = rsegen.Random(levels=4)
    for mesh_type, look in product(MESH_TYPES, ("levels", "wood", "friction")):
        yield rsegen.Recipe(
            name=f"{mesh_type}-{look}",
            chunk_size=4,
            chunks=(2, 1),
            mesh_type=mesh_type,
            look=look,
            shadows=True,
            sky=True,
            level_friction=(0.3,),
            seed=1,
            obstacles=(random,),
        )


Shape = Mapping[str, Any]
"""Parameters of a recipe that say what is seen and touched, where they are not the default ones."""

SHAPES: tuple[Shape, ...] = (
    {},
    {"mesh": "watertight"},
    {"mesh": "blocks"},
    {"collision": "boxes"},
    {"collision": "blocks"},
    {"tile": 7},
    {"simulator": "classic"},
    {"look": "wood"},
)


def shape_name(shape: Shape) -> str:
    """Name of a test."""
    return "-".join(f"{name}-{value}" for name, value in shape.items()) or "default"


def examples() -> Iterator[rsegen.Recipe]:
    """The first map of every example, the first in the default shape, each in another shape than the one before it.

    Every example in every shape is rebuilt from its files in tests/gazebo/test_rebuilt.py.
    """
    for recipe, shape in zip(map(rsegen.load, EXAMPLES.values()), cycle(SHAPES)):
        name = f"{recipe.name}-{shape_name(shape)}" if shape else recipe.name
        yield replace(recipe, name=name, maps=1, **shape)


def slippery() -> Iterator[rsegen.Recipe]:
    """Two plateaus along x in one frame, of which one and the frame are slippery, in every shape and mesh type; last,
    in the default shape, the other plateau alone is slippery.
    """
    levels = np.tile(np.repeat([1, 2], 4), (8, 1))
    low = rsegen.Recipe(
        name="slippery",
        chunk_size=4,
        chunks=(2, 2),
        boundary="outer",
        seed=1,
        friction=0.9,
        frame_friction=0.05,
        level_friction=(0.05,),
        obstacles=(rsegen.Matrix.of(levels),),
    )
    for shape in (*SHAPES, {"mesh_type": "pallet"}, {"mesh_type": "multi"}):
        yield replace(low, name=f"slippery-{shape_name(shape)}", **shape)
    yield replace(low, name="slippery-high", frame_friction=None, level_friction=(0.9, 0.05))


def lanes(scene: rsegen.Scene) -> Iterator[tuple[str, tuple[float, float, float], bool]]:
    """On each plateau of a slippery map, and on the frame: a name, a place near the west end, and whether it slides."""
    x, y = ((line[:-1] + line[1:]) / 2 for line in scene.field.edges())
    for name, material, row in (("frame", 0, 0), ("low", 1, 3), ("high", 2, 7)):
        place = float(x[1]), float(y[row]), float(scene.field.heights[1, row])
        yield name, place, scene.friction_of(material) < SIDEWAYS / 10


def every_kind() -> rsegen.Recipe:
    """A map of a chunk per kind with an obstacle of it; kinds differ in levels alone."""
    side, obstacles = 6, []
    for number, kind in enumerate(rsegen.KINDS.values()):
        first, end = (number * side, 0), (number * side + side - 1, side - 1)
        last = (end[0], 0) if kind is rsegen.HorizontalBarrier else end
        obstacles.append(kind(levels=4, softness=40, first=first, last=last))
    return rsegen.Recipe(
        name="kinds",
        chunk_size=side,
        chunks=(len(obstacles), 1),
        ground_level=max(-obstacle.level_range[0] for obstacle in obstacles),  # a pit reaches below the ground
        seed=1,
        obstacles=tuple(obstacles),
    )


FEW = {
    *("diagonal-barrier_0000", "single-divided_0000", "pallet-outer_0000", "multi-none_0000"),
    *("single-friction_0000", "pallet-levels_0000", "multi-wood_0000"),
    *("slippery-default_0000", "slippery-collision-boxes_0000", "slippery-mesh_type-multi_0000"),
}
"""Maps that stand for others: every mesh type, boundary and look, and friction."""


def few_short(recipes: Iterable[rsegen.Recipe]) -> list[Any]:
    """Return the recipes for `parametrize`, all but a few of them long."""
    return long_unless(lambda recipe: map_name(recipe) in FEW, recipes, reason="a server per map")


def map_name(recipe: rsegen.Recipe) -> str:
    """Name of a test."""
    return recipe.map_name(recipe.first_map)


def generated(recipe: rsegen.Recipe, folder: Path) -> Map:
    """The first map of a recipe, written into a folder."""
    made = rsegen.generate(recipe, folder).maps[0]
    return Map(scene=rsegen.compose(recipe, made.index), folder=made.folder)
