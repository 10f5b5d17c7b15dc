"""A recipe: everything that determines a set of maps.

    Run              number of maps, first index, name
    MapDesign        size, obstacles, constraints, seed: nothing else decides the levels of a map
    Representation   meshes, collision shapes, friction, colours: the map in a simulator

All three are one flat list of parameters in files, flags, Python and the page, and a `Recipe` checks them together;
what builds levels takes a `MapDesign` only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated

from rsegen.errors import ParameterError, refuse_other, shown
from rsegen.params.sorts import Choice, Flag, Float, Integer, Json, ListOf, Text, changed, parameters, plain, validate
from rsegen.params.streams import SEEDS
from rsegen.recipe.map_design import MapDesign

__all__ = ["MapDesign", "Recipe", "Representation", "Run"]


@dataclass(frozen=True, kw_only=True)
class Run:
    """Number of maps to make, index of the first one, and their name."""

    name: Annotated[
        str,
        Text(
            r"[A-Za-z0-9_][A-Za-z0-9_.\-]{0,63}",
            "1..64 letters, digits, _ . -; not first: . or -",
            help="name of the maps",
        ),
    ] = "rse"
    description: Annotated[
        str, Text(r"[^\x00-\x1f]{0,500}", "one line of up to 500 characters", help="free-text description")
    ] = ""
    maps: Annotated[int, Integer(1, help="number of maps to generate")] = 1
    first_map: Annotated[int, Integer(0, SEEDS - 1, help="index of the first map")] = 0

    @property
    def indices(self) -> range:
        """Indices of the maps of this run."""
        return range(self.first_map, self.first_map + self.maps)

    def map_name(self, index: int) -> str:
        """Return the name of map `index`, on disk and in the simulator."""
        return f"{self.name}_{index:04d}"


_FRICTION = Float(0, 1000, usual=(0, 1.5), help="friction coefficient of blocks, frames and ground")
_COLOUR = Text("#[0-9A-Fa-f]{6}", "#rrggbb, in quotes")


@dataclass(frozen=True, kw_only=True)
class Representation:
    """Representation of a map in a simulator; no parameter of it changes the level of a block."""

    mesh_type: Annotated[
        str, Choice(("single", "multi", "pallet"), help="one model per map, per block, or per chunk")
    ] = "single"
    simulator: Annotated[
        str,
        Choice(
            ("both", "classic"),
            help="target simulator: both, or classic for smoother floors in Gazebo Classic; a map opens in both",
        ),
    ] = "both"
    solver: Annotated[
        str,
        Choice(
            ("dantzig", "pgs"),
            help="solver of contacts in Gazebo Sim: dantzig, its default, holds some robots at edges; pgs does not",
        ),
    ] = "dantzig"
    mesh: Annotated[
        str,
        Choice(
            ("merged", "watertight", "blocks"),
            help="mesh: the exposed surface in few rectangles, closed and without gaps, or 6 faces per block",
        ),
    ] = "merged"
    collision: Annotated[
        str,
        Choice(
            ("mesh", "boxes", "blocks"),
            help="collision shape: the visual mesh, a few merged boxes, or one box per block",
        ),
    ] = "mesh"
    tile: Annotated[
        int,
        Integer(
            0, 100_000, unit="cells", help="cut the mesh into square parts of this side, one file each; 0: one mesh"
        ),
    ] = 0
    friction: Annotated[float, _FRICTION] = 1.0
    frame_friction: Annotated[float | None, replace(_FRICTION, help="friction of the frames, if different")] = None
    level_friction: Annotated[
        Sequence[float] | None,
        ListOf(_FRICTION, help="friction of blocks of level 1, 2, ...; higher levels have that of the map"),
    ] = None
    units: Annotated[
        str,
        Choice(("cm", "in"), help="units of length on build sheets and in reports: cm and m, or in and ft"),
    ] = "cm"
    look: Annotated[
        str,
        Choice(
            ("plain", "levels", "wood", "friction"),
            help="surface of the blocks: plain, one colour per level; levels, the same with the edges of every block; "
            "wood, pine with end grain and long grain; friction, one colour per coefficient, with edges",
        ),
    ] = "plain"
    shadows: Annotated[bool, Flag(help="cast shadows in the world")] = False
    sky: Annotated[bool, Flag(help="show a sky in the world")] = False
    frame_colour: Annotated[str | None, replace(_COLOUR, help="colour of the frames")] = None
    level_colours: Annotated[
        Sequence[str] | None,
        ListOf(_COLOUR, help="colours of blocks of level 1, 2, ...; higher levels keep the default ones"),
    ] = None

    @property
    def is_textured(self) -> bool:
        """Return whether the blocks have textures."""
        return self.look != "plain"

    @property
    def is_of_one_friction(self) -> bool:
        """Return whether blocks, frames and ground all have the same coefficient."""
        own = (self.frame_friction, *(self.level_friction or ()))
        return all(friction in (None, self.friction) for friction in own)

    def _check_representation(self) -> None:
        """Raise a ParameterError for a shape that models of this mesh type cannot have."""
        if self.mesh_type == "multi" and self.mesh != "merged":
            raise ParameterError("mesh", f"'{self.mesh}' is for mesh_type single and pallet; multi is made of boxes")
        if self.mesh_type == "multi" and self.collision == "boxes":
            raise ParameterError("collision", "'boxes' is for mesh_type single and pallet; in multi every block is one")
        if self.simulator == "classic" and self.mesh_type != "single":
            raise ParameterError("simulator", f"'classic' is for mesh_type single; use both with {self.mesh_type}")
        if self.tile and self.mesh_type != "single":
            raise ParameterError("tile", f"{self.tile} is for mesh_type single; use 0 with mesh_type {self.mesh_type}")
        if self.tile and self.mesh == "watertight":
            raise ParameterError("tile", f"{self.tile} would cut a watertight mesh open; use 0, or mesh merged")


@dataclass(frozen=True, kw_only=True)
class Recipe(Representation, MapDesign, Run):
    """The maps to generate; every field is a global parameter of the method, in the words of the recipe file.

    Parameters
    ----------
    obstacles : sequence of Obstacle, default ()
        The obstacles, of which later ones are imposed on earlier ones.
    """

    def __post_init__(self) -> None:
        validate(self)
        if self.first_map + self.maps > SEEDS:
            raise ParameterError("maps", f"{shown(self.maps)} from first_map {self.first_map} on go beyond {SEEDS - 1}")
        self._check_representation()
        self.check_design()

    def alone(self, index: int) -> Recipe:
        """Return the recipe of map `index` and no other."""
        return replace(self, first_map=index, maps=1)

    def values(self) -> dict[str, Json]:
        """Return every global parameter that is not left open, as a file has it."""
        values = {name: getattr(self, name) for name in parameters(Recipe)}
        return {name: plain(value) for name, value in values.items() if value is not None}

    def entry(self) -> dict[str, Json]:
        """Return the recipe as a file has it: parameters that differ from their defaults, the seed, the obstacles."""
        return changed(self) | {"obstacles": [obstacle.entry() for obstacle in self.obstacles]}


def with_maps(recipe: Recipe, maps: int | None) -> Recipe:
    """Return a recipe with another number of maps, if one is given."""
    refuse_other("recipe", recipe, Recipe)
    return recipe if maps is None else replace(recipe, maps=maps)


def index_of(recipe: Recipe, which: str) -> int | None:
    """Return the index of a recipe's map that is given by index or name; None if it has no such map."""
    digits = which.removeprefix(f"{recipe.name}_")
    return int(digits) if digits.isdecimal() and len(digits) < 20 and int(digits) in recipe.indices else None


def as_recipes(given: Recipe | Sequence[Recipe]) -> tuple[Recipe, ...]:
    """Return one recipe or several as a tuple; ParameterError if it is neither."""
    recipes = (given,) if isinstance(given, Recipe) else given
    if not isinstance(recipes, list | tuple) or not all(isinstance(recipe, Recipe) for recipe in recipes):
        raise ParameterError("recipes", f"{shown(given)} is not a recipe or a list of recipes")
    return tuple(recipes)
