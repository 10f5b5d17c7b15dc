"""The scene: one map of a recipe with its field, colours and friction, which every exporter starts from.

StepField --compose--> Scene

The levels of its blocks are written as CSV, north up, and named by a fingerprint.

That is a short name for levels, by which two sites know that they built the same field: 40 bits of a hash, so
of a million different fields two have the same one with a probability of a third, and of two fields hardly ever.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from hashlib import blake2b
from typing import TypeVar

from rsegen.field.stepfield import Array, CellWindow, Ints, Levels, StepField
from rsegen.params.numbers import decimal
from rsegen.params.sorts import NANOMETRE_DIGITS
from rsegen.recipe.building import build
from rsegen.recipe.recipe import Recipe
from rsegen.scene.colours import Colour, height_colour, ramp_colour, rounded_colour
from rsegen.scene.looks.looks import mean_colour

_Value = TypeVar("_Value")

FRAME_COLOUR: Colour = (0.75, 0.1, 0.08)
_LOW_TO_HIGH: tuple[Colour, ...] = (
    (0.22, 0.20, 0.42),
    (0.19, 0.39, 0.55),
    (0.16, 0.57, 0.55),
    (0.45, 0.74, 0.38),
    (0.93, 0.85, 0.30),
)
"""Colours of levels from dark to light, so that heights can be distinguished in greyscale too."""

_TIMBER: tuple[Colour, ...] = ((1.0, 1.0, 1.0), (0.93, 0.92, 0.9), (0.97, 0.95, 0.95), (0.9, 0.87, 0.84))
_BOARDS: Colour = (0.66, 0.5, 0.4)
"""Tints of wood: the blocks of every fourth level were sawn from one beam, and frames are darker."""

_SLIPPERY_TO_ROUGH: tuple[Colour, ...] = ((0.62, 0.82, 0.95), (0.36, 0.3, 0.26))
_ROUGHEST = 1.2
"""Friction coefficient from which the look `friction` has its darkest colour: rubber on dry concrete has about 1."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Scene:
    """A map with its recipe: what exporters write and previews show.

    Parameters
    ----------
    recipe : Recipe
        Its recipe.
    index : int
        Its index in the recipe.
    field : StepField
        Its blocks and frames.
    """

    recipe: Recipe
    index: int
    field: StepField

    @property
    def friction(self) -> float:
        """Friction coefficient of the ground, and of all materials without one of their own."""
        return self.recipe.friction

    @property
    def units(self) -> str:
        """Units of lengths for people, as in recipes: cm or in."""
        return self.recipe.units

    @property
    def name(self) -> str:
        """Name of the map, on disk and in the simulator."""
        return self.recipe.map_name(self.index)

    @property
    def alone(self) -> Recipe:
        """Recipe of this map alone."""
        return self.recipe.alone(self.index)

    def colour(self, material: int) -> Colour:
        """Return the colour of a material in worlds: 0 is the frame, any other number a level."""
        if (chosen := self._chosen_colour(material)) or not material:
            return chosen or FRAME_COLOUR
        # Above the top level, as of blocks of an inventory, all have its colour.
        share = min(material / max(self.recipe.top_level, 1), 1)
        return rounded_colour(ramp_colour(_LOW_TO_HIGH, share))

    def plan_colour(self, material: int) -> Colour:
        """Return the colour of a material in plans: a level's is by its height, unless the recipe chooses one."""
        if not material or self._chosen_colour(material):
            return self.colour(material)
        return height_colour(material * self.field.unit, self.recipe.highest_level * self.field.unit)

    def tint(self, material: int) -> Colour:
        """Return the colour that the textures of a material are multiplied by, if the recipe's look has textures."""
        if self.recipe.look == "friction":
            return rounded_colour(ramp_colour(_SLIPPERY_TO_ROUGH, min(self.friction_of(material) / _ROUGHEST, 1)))
        if self.recipe.look != "wood":
            return self.colour(material)
        return self._chosen_colour(material) or (_TIMBER[material % len(_TIMBER)] if material else _BOARDS)

    def surface_colour(self, material: int) -> Colour:
        """Return the colour of a material from afar, for programs and pictures without textures."""
        if not self.recipe.is_textured:
            return self.colour(material)
        tint, mean = self.tint(material), mean_colour(self.recipe.look)
        return rounded_colour(own * texture for own, texture in zip(tint, mean, strict=True))

    def view_colour(self, material: int) -> Colour:
        """Return the colour of a material in views: of wood or friction if the look shows it, else as in plans.

        So a height has one colour in views and plans; in worlds a level has its own.
        """
        return self.surface_colour(material) if self.recipe.look in ("wood", "friction") else self.plan_colour(material)

    def _chosen_colour(self, material: int) -> Colour | None:
        colour = _chosen(material, self.recipe.frame_colour, self.recipe.level_colours)
        return rounded_colour(part / 255 for part in bytes.fromhex(colour[1:])) if colour else None

    def friction_of(self, material: int) -> float:
        """Return the friction coefficient of a material: 0 is the frame, any other number a level."""
        chosen = _chosen(material, self.recipe.frame_friction, self.recipe.level_friction)
        return self.friction if chosen is None else chosen

    def by_friction(
        self, field: StepField, window: CellWindow | None = None
    ) -> Sequence[tuple[float, Sequence[int] | None]]:
        """Return the friction coefficients in a field or a window of it, lowest first, each with the materials that
        have it.

        None stands for all materials. Coefficients that are written alike count as equal.
        """
        if self.recipe.is_of_one_friction:
            return [(self.friction, None)]
        materials: dict[float, list[int]] = {}
        for material in field.materials(window):
            materials.setdefault(round(self.friction_of(material), NANOMETRE_DIGITS), []).append(material)
        return sorted(materials.items()) if len(materials) > 1 else [(next(iter(materials), self.friction), None)]


def compose(recipe: Recipe, index: int = 0) -> Scene:
    """Build a map, and return it with the colours and friction of its recipe.

    Parameters
    ----------
    recipe : Recipe
        The recipe.
    index : int, default 0
        Index of the map, 0 or more.

    Returns
    -------
    Scene
        The map.
    """
    return Scene(recipe=recipe, index=index, field=build(recipe, index))


def _chosen(material: int, frame: _Value | None, levels: Sequence[_Value] | None) -> _Value | None:
    """Return the value that a recipe has for a material, if any: for the frame, or for levels 1, 2, ..."""
    if not material:
        return frame
    return levels[material - 1] if levels and material <= len(levels) else None


def csv(field: StepField) -> Iterator[bytes]:
    """Yield the lines of the CSV file: levels in units, without frames, north up."""
    return north_up(field.blocks, f"block levels in units of {decimal(field.unit * 100)} cm")


def north_up(values: Ints | Array, head: str, repeat: int = 1) -> Iterator[bytes]:
    """Yield values (n_x, n_y) as lines of CSV, each value `repeat` times along x and y; `#` starts a comment."""
    yield f"# {head}; north up: the top row is the largest y, x grows to the right\n".encode()
    for row in values.T[::-1]:
        yield (",".join(map(decimal, row.repeat(repeat).tolist())) + "\n").encode() * repeat


_LETTERS = "0123456789ABCDEFGHJKMNPQRSTVWXYZ"
"""Digits of base 32 after Crockford: none of them is read as another one."""


def fingerprint(levels: Levels) -> str:
    """Return eight letters and digits, as in 7K3F-9QXA, of levels (n_x, n_y) without frames, whatever their unit is.

    They are 40 bits of the BLAKE2b hash of "n_x n_y " and the levels as 16-bit numbers, the lowest byte first, along y
    and x.
    """
    n_x, n_y = levels.shape
    digest = blake2b(f"{n_x} {n_y} ".encode() + levels.astype("<i2").tobytes(), digest_size=5).digest()
    bits = int.from_bytes(digest, "big")
    text = "".join(_LETTERS[bits >> shift & 31] for shift in range(35, -1, -5))
    return f"{text[:4]}-{text[4:]}"
