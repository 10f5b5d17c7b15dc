"""What the page says of a map: cells, palette, facts, metrics and recipe, as values for JSON."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from rsegen.exporters.browser.figures import figures
from rsegen.exporters.fingerprint import fingerprint
from rsegen.exporters.lengths import lengths_in
from rsegen.exporters.numbers import decimal
from rsegen.exporters.pictures.field_picture import ColouredField
from rsegen.exporters.pictures.plan import Drawable
from rsegen.exporters.scene import Colour, Scene
from rsegen.field.stepfield import Array, Ints, StepField

_GROUND: Colour = (0.86, 0.86, 0.86)
"""The colour of cells without a block, as in previews."""

_FRAME = -1
"""The material of frame cells; of other cells it is their level."""


@dataclass(frozen=True, kw_only=True, slots=True)
class ShownMap:
    """A map on a page: what is drawn, and the text of its recipe with the name of a file for it; empty if it has none.

    units: of the heights, as in a recipe
    """

    drawn: Drawable
    name: str
    description: str = ""
    seed: int | None = None
    recipe: str = ""
    file: str = ""
    units: str = "cm"

    @classmethod
    def of(cls, scene: Scene, recipe: str, suffix: str) -> ShownMap:
        """The map of a scene, with its recipe in a text for a file of that suffix."""
        return cls(
            drawn=scene,
            name=scene.name,
            description=scene.recipe.description,
            seed=scene.recipe.seed,
            recipe=recipe,
            file=f"{scene.name}{suffix}",
            units=scene.recipe.units,
        )

    @classmethod
    def of_field(cls, field: StepField, name: str = "step field") -> ShownMap:
        """A field that belongs to no recipe, in the default colours."""
        return cls(drawn=ColouredField(field=field), name=name)


def content(shown: ShownMap) -> dict[str, Any]:
    """All that the page needs of a map."""
    field, written = shown.drawn.field, lengths_in(shown.units)
    materials, cells = np.unique(np.where(field.frame, _FRAME, field.levels), return_inverse=True)
    return {
        "name": shown.name,
        "description": shown.description,
        "cells": list(field.shape),
        "block_width": field.block_width,
        "block": f"{written.short(_nanometres(field.block_width))} {written.unit}",
        "unit": written.unit,
        "palette": list(_palette(shown, materials, np.bincount(cells.ravel()))),
        **_encoded(cells, len(materials)),
        "facts": list(_facts(shown)),
        "metrics": list(figures(field, written)),
        "recipe": shown.recipe,
        "file": shown.file,
    }


def _palette(shown: ShownMap, materials: Ints, counts: Ints) -> Iterator[dict[str, Any]]:
    """What stands in cells, lowest level first, after the frame: level (None for frames), height, colours, number.

    colour: on the plan; surface: in the 3D view, as in previews
    """
    field, written = shown.drawn.field, lengths_in(shown.units)
    for material, count in zip(materials.tolist(), counts.tolist(), strict=True):
        is_frame = material == _FRAME
        height = round(field.frame_height if is_frame else material * field.unit, 9)
        colours = (
            each(0 if is_frame else material) if material else _GROUND
            for each in (shown.drawn.colour, shown.drawn.surface_colour)
        )
        colour, surface = map(_hex, colours)
        yield {
            "level": None if is_frame else material,
            "height": height,
            "label": written.short(_nanometres(height)),
            "colour": colour,
            "surface": surface,
            "count": count,
        }


def _hex(colour: Colour) -> str:
    return "#" + "".join(f"{round(255 * part):02x}" for part in colour)


def _encoded(cells: Ints | Array, entries: int) -> dict[str, Any]:
    """The number of each cell's entry in the palette, all of the first i first, in base64."""
    size = 1 if entries <= 256 else 2
    return {"bytes": size, "content": b64encode(cells.ravel().astype(f"<u{size}").tobytes()).decode()}


def _facts(shown: ShownMap) -> Iterator[tuple[str, str]]:
    field = shown.drawn.field
    (n_x, n_y), (along_x, along_y) = field.shape, map(decimal, field.extent)
    if shown.seed is not None:
        yield "seed", str(shown.seed)
    yield "cells", f"{n_x} × {n_y}"  # noqa: RUF001  # a page has the sign
    yield "size", f"{along_x} × {along_y} m"  # noqa: RUF001
    if not field.frame.all():
        yield "fingerprint", fingerprint(field.blocks)


def _nanometres(metres: float) -> int:
    return round(metres * 1e9)
