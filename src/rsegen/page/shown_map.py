"""Maps as a page for browsers: one HTML file with 3D view, plan, metrics and recipe, which needs no internet.

The page is page.html with its style and script, which are files of this folder, and the maps as JSON; without them it
is the page that edits, of a server. Names and recipes may have any letters: in the HTML they are escaped, in the JSON
there is no `<`, and the script sets text as text. The browser runs this script and no other (Content Security Policy).

    Scene or StepField --ShownMap--> values for JSON: cells, palette, facts, metrics, recipe --page--> bytes of HTML
"""

from __future__ import annotations

import json
import re
from base64 import b64encode
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from html import escape
from importlib.resources import files
from typing import Literal, TypedDict

import numpy as np

from rsegen import __version__
from rsegen.field.stepfield import Array, Ints, Mask, StepField, coarse
from rsegen.measuring.catalogue import metrics
from rsegen.params.numbers import Lengths, decimal, lengths_in
from rsegen.pictures.plan import GROUND_GREY, ColouredField, Drawable
from rsegen.scene.colours import Colour
from rsegen.scene.scene import Scene, fingerprint


def figures(field: StepField, written: Lengths) -> Iterator[tuple[str, str, str]]:
    """Yield name, value and meaning of the metrics of a field, in the units of lengths; none without blocks."""
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
    yield "TRI", length(rugged.tri), "terrain ruggedness index, root mean square"
    yield "surface", f"{rugged.surface_ratio:.2f}", "area of tops and sides, divided by that of the plan"
    yield "smallest step, west to east", length(opens.west_east), "a robot that climbs it can cross the map"
    yield "smallest step, south to north", length(opens.south_north), "the same, from south to north"
    if measured.scale.hurst is not None:
        weak = "; uncertain, from few distances" if measured.scale.hurst_is_weak else ""
        yield (
            "Hurst exponent",
            f"{round(measured.scale.hurst, 2) + 0:.2f}",
            f"how height differences grow with distance{weak}",
        )


class Material(TypedDict):
    """A material of cells: a level of blocks, or the frames."""

    level: int | None  # null: a frame
    height: float
    label: str  # the height in `unit`
    colour: str  # "#rrggbb" on the plan and in the height look
    surface: str  # in the look of the recipe: the same, but for wood and friction
    count: int


class Drawing(TypedDict):
    """A map as it is drawn, without its metrics."""

    name: str
    description: str
    cells: tuple[int, int]  # of the field, frames included
    block_width: float
    block: str  # the same in words: "10 cm"
    unit: str  # of labels: "cm"
    palette: list[Material]
    bytes: Literal[1, 2]  # of each number of content
    content: str  # base64: of each cell the number of its material, all of the first i (x) first; little endian
    facts: list[tuple[str, str]]
    recipe: str
    file: str
    look: str
    step: float  # metres of a unit


class MapData(Drawing):
    """A map as it is drawn, with its metrics: all that a page has of it that is a file."""

    metrics: list[tuple[str, str, str]]  # name, value, meaning


class Frozen(TypedDict):
    """The maps in a page that is a file."""

    maps: list[MapData]
    version: str


_GROUND: Colour = (GROUND_GREY, GROUND_GREY, GROUND_GREY)
"""The colour and the surface of cells without a block, as in plans and previews."""

_FRAME = -1
"""The material of frame cells; of other cells it is their level."""


@dataclass(frozen=True, kw_only=True, slots=True)
class ShownMap:
    """A map on a page: what is drawn, and of a scene the text of its recipe, with the name of a file for it."""

    drawn: Drawable
    name: str
    recipe: str = ""
    file: str = ""

    @classmethod
    def of(cls, scene: Scene, recipe: str, suffix: str) -> ShownMap:
        """Return the map of a scene, with the text of its recipe for a file of some suffix."""
        return cls(drawn=scene, name=scene.name, recipe=recipe, file=f"{scene.name}{suffix}")

    @classmethod
    def of_field(cls, field: StepField, name: str = "step field") -> ShownMap:
        """Return a field that belongs to no recipe, in the default colours."""
        return cls(drawn=ColouredField(field=field), name=name)


def shown_content(shown: ShownMap) -> MapData:
    """Return everything that the page needs of a map, as JSON values: it as it is drawn, and its metrics."""
    return {**drawn(shown), "metrics": list(figures(shown.drawn.field, lengths_in(shown.drawn.units)))}


def drawn(shown: ShownMap, factor: int = 1) -> Drawing:
    """Return what is drawn and said of a map, without its metrics, as JSON values.

    factor: each column that is drawn is the highest of this many cells along x and y
    """
    field, written = shown.drawn.field, lengths_in(shown.drawn.units)
    (n_x, n_y), (along_x, along_y) = field.shape, map(decimal, field.extent)
    recipe = shown.drawn.recipe if isinstance(shown.drawn, Scene) else None
    facts = {"seed": str(recipe.seed)} if recipe and recipe.seed is not None else {}
    facts |= {"cells": f"{n_x} × {n_y}", "size": f"{along_x} × {along_y} m"}  # noqa: RUF001  # a page has the sign
    if not field.frame.all():
        facts["fingerprint"] = fingerprint(field.blocks)
    materials, counts = np.unique(_materials(field), return_counts=True)
    columns = coarse(field, factor)
    # The index of each cell's entry in the palette, in as few bytes as it needs.
    cells = np.searchsorted(materials, _materials(columns))
    size: Literal[1, 2] = 1 if len(materials) <= 256 else 2
    return {
        "name": shown.name,
        "description": recipe.description if recipe else "",
        "cells": columns.shape,
        "block_width": columns.block_width,
        "block": f"{written.short(_nanometres(field.block_width))} {written.unit}",
        "unit": written.unit,
        "palette": list(_palette(shown, materials, counts)),
        "bytes": size,
        "content": base64_of(cells, f"<u{size}"),
        "facts": list(facts.items()),
        "recipe": shown.recipe,
        "file": shown.file,
        "look": recipe.look if recipe else "plain",
        "step": field.unit,
    }


def _materials(field: StepField) -> Ints:
    """Return the material of each cell: its level, or `_FRAME`."""
    return np.where(field.frame, _FRAME, field.levels)


def _palette(shown: ShownMap, materials: Ints, counts: Ints) -> Iterator[Material]:
    """Yield the materials of cells, the frame first, then the lowest level: level (None for frames), height, colours,
    count.

    colour: as in plans, of its height unless the recipe gives one; surface: as in previews, of the wood or friction
    that the recipe's look shows, else the same.
    """
    # In the order of np.unique, which the cells refer to.
    field, written = shown.drawn.field, lengths_in(shown.drawn.units)
    for material, count in zip(materials.tolist(), counts.tolist(), strict=True):
        is_frame = material == _FRAME
        height = round(field.frame_height if is_frame else material * field.unit, 9)
        colour = surface = _GROUND
        if material:
            of_drawable = 0 if is_frame else material
            colour, surface = shown.drawn.plan_colour(of_drawable), shown.drawn.view_colour(of_drawable)
        yield {
            "level": None if is_frame else material,
            "height": height,
            "label": written.short(_nanometres(height)),
            "colour": hex_colour(colour),
            "surface": hex_colour(surface),
            "count": count,
        }


def hex_colour(colour: Colour) -> str:
    """Return a colour as `#rrggbb`; parts beyond 0..1 are clipped."""
    return "#" + "".join(f"{round(255 * min(max(part, 0.0), 1.0)):02x}" for part in colour)


def base64_of(values: Ints | Array | Mask, kind: str) -> str:
    """Return an array as numbers of a kind, such as <f4, in base64: all of the first index first."""
    return b64encode(values.astype(kind).tobytes()).decode()


def _nanometres(metres: float) -> int:
    return round(metres * 1e9)


def page(maps: Sequence[ShownMap]) -> bytes:
    """Return the page that shows maps, one at a time, as the bytes of an HTML file; equal maps give equal bytes."""
    title = maps[0].name if len(maps) == 1 else f"{maps[0].name} and {len(maps) - 1} more"
    frozen: Frozen = {"maps": [shown_content(shown) for shown in maps], "version": __version__}
    data = json.dumps(frozen, separators=(",", ":"))
    for sign in "<>&":  # so that no tag of HTML can begin or end in it
        data = data.replace(sign, f"\\u{ord(sign):04x}")
    return _html(title, f'<script type="application/json" id="data">{data}</script>\n').encode()


def editor_page() -> str:
    """Return the page that edits documents of a server."""
    return _html("rsegen", "")


@cache
def policy(connect: str = "'none'") -> str:
    """Return the Content Security Policy of the page: its own script and style by their hashes, and nothing else.

    connect: what its script may ask for
    """
    digests = (sha256(text.encode()).digest() for text in (_script(), source_of("page.min.css")))
    script, style = (f"'sha256-{b64encode(digest).decode()}'" for digest in digests)
    return (
        f"default-src 'none'; script-src {script}; style-src {style}; img-src data: blob:; "
        f"connect-src {connect}; base-uri 'none'; form-action 'none'"
    )


def _html(title: str, data: str) -> str:
    """Return the page with a title, and with its maps as an element if they are frozen into it."""
    parts = {
        "title": escape(title),
        "generator": f"rsegen {__version__}",
        "policy": policy("'self'" if not data else "'none'"),
        "css": source_of("page.min.css"),
        "data": data,
        "script": _script(),
    }
    return re.sub(r"\{\{(\w+)\}\}", lambda match: parts[match[1]], source_of("page.html"))


@cache
def _script() -> str:
    """Return the script of the page, with the licences of the libraries in it."""
    return f"\n/*\n{source_of('page.LICENSE')}*/\n{source_of('page.min.js')}"


@cache
def source_of(name: str) -> str:
    """Return the text of a file of this folder."""
    return files("rsegen.page.browser").joinpath(name).read_text("utf-8")
