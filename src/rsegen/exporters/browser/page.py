"""Maps as a page for browsers: one HTML file with 3D view, plan, metrics and recipe, which needs no internet.

The page is page.html with its style and scripts, which are files of this folder, and the maps as JSON. Names and
recipes may have any letters: in the HTML they are escaped, in the JSON there is no `<`, and the scripts set text as
text.

    Scene or StepField --ShownMap--> values for JSON: cells, palette, facts, metrics, recipe --page--> bytes of HTML
"""

from __future__ import annotations

import json
import re
from base64 import b64encode
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html import escape
from importlib.resources import files
from typing import Any

import numpy as np

from rsegen import __version__
from rsegen.exporters.numbers import Lengths, decimal, lengths_in
from rsegen.exporters.pictures.plan import GROUND_GREY, Drawable
from rsegen.exporters.pictures.preview import ColouredField
from rsegen.exporters.scene import Colour, Scene, fingerprint
from rsegen.field.metrics import metrics
from rsegen.field.stepfield import Array, Ints, StepField


def figures(field: StepField, written: Lengths) -> Iterator[tuple[str, str, str]]:
    """Yield name, value and meaning of the metrics of a field, lengths in the units of its recipe; none without
    blocks.
    """
    if field.frame.all():
        return
    measured = metrics(field)

    def length(metres: float | None) -> str:  # to a tenth of a millimetre, which is 100,000 nanometres
        return "–" if metres is None else f"{written.short(round(metres * 1e4) * 100_000)} {written.unit}"  # noqa: RUF001  # a dash

    spread, steps, rugged, opens = measured.spread, measured.steps, measured.ruggedness, measured.opening
    yield "mean height", length(spread.mean), f"{length(spread.lowest)} to {length(spread.highest)}"
    yield "standard deviation", length(spread.deviation), "of the heights"
    yield "entropy", f"{spread.entropy:.2f} bits", "of the distribution of levels"
    yield "mean step", length(steps.mean), "between neighbouring blocks"
    yield "rms step", length(steps.rms), f"largest {length(steps.highest)}"
    yield "TRI", length(rugged.tri), "terrain ruggedness index, root mean"
    yield "surface", f"{rugged.surface_ratio:.2f}", "area of the surface, over that of the plan"
    yield "opens west to east", length(opens.west_east), "smallest step at which the map can be crossed"
    yield "opens south to north", length(opens.south_north), "the same, from the south"
    if measured.scale.hurst is not None:
        weak = ", weak: of few lags" if measured.scale.hurst_is_weak else ""
        yield "Hurst exponent", f"{round(measured.scale.hurst, 2) + 0:.2f}", f"how differences grow with distance{weak}"


_GROUND: Colour = (GROUND_GREY, GROUND_GREY, GROUND_GREY)
"""The colour of cells without a block, as in previews."""

_FRAME = -1
"""The material of frame cells; of other cells it is their level."""


@dataclass(frozen=True, kw_only=True, slots=True)
class ShownMap:
    """A map on a page: what is drawn, and the text of its recipe with the name of a file for it; empty if it has none.

    units: of the heights, as in a recipe.
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
        """Return the map of a scene, with the text of its recipe for a file of some suffix."""
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
        """Return a field that belongs to no recipe, in the default colours."""
        return cls(drawn=ColouredField(field=field), name=name)


def content(shown: ShownMap) -> dict[str, Any]:
    """Return everything that the page needs of a map, as JSON values."""
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
    """Yield the materials of cells, the frame first, then the lowest level: level (None for frames), height, colours,
    count.

    colour: on the plan; surface: in the 3D view, as in previews.
    """
    # In the order of np.unique, which the cells refer to.
    field, written = shown.drawn.field, lengths_in(shown.units)
    for material, count in zip(materials.tolist(), counts.tolist(), strict=True):
        is_frame = material == _FRAME
        height = round(field.frame_height if is_frame else material * field.unit, 9)
        colours = (
            colour_of(0 if is_frame else material) if material else _GROUND
            for colour_of in (shown.drawn.colour, shown.drawn.surface_colour)
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
    """Return the index of each cell's entry in the palette, all of the first i first, in base64."""
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


_SCRIPTS = ("field.js", "solid.js", "plan.js", "page.js")


def page(maps: Sequence[ShownMap]) -> bytes:
    """Return the page that shows maps, one at a time, as the bytes of an HTML file; equal maps give equal bytes."""
    title = maps[0].name if len(maps) == 1 else f"{maps[0].name} and {len(maps) - 1} more"
    parts = {
        "title": escape(title),
        "generator": f"rsegen {__version__}",
        "css": _source("page.css"),
        "data": _json({"maps": [content(shown) for shown in maps]}),
        "licence": _source("three.LICENSE"),
        "three": _source("three.min.js"),
        "script": "\n".join(map(_source, _SCRIPTS)),
    }
    return re.sub(r"\{\{(\w+)\}\}", lambda match: parts[match[1]], _source("page.html")).encode()


def editor_page() -> str:
    """Return the page that edits documents of a server."""
    parts = {"css": _source("page.min.css"), "script": _source("page.min.js"), "licence": _source("page.LICENSE")}
    return re.sub(r"\{\{(\w+)\}\}", lambda match: parts[match[1]], _source("editor.html"))


def _source(name: str) -> str:
    """Return the text of a file of this folder."""
    return files("rsegen.exporters.browser").joinpath(name).read_text("utf-8")


def _json(value: object) -> str:
    """Return JSON of ASCII letters in which no tag of HTML can begin or end."""
    text = json.dumps(value, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")
