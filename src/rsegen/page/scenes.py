"""Drawings of maps for pages: a map of a document, and small ones to choose from.

Maps are kept by recipe and index, so that what follows from one map, asked for by several calls, is made of it once.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from math import isnan
from typing import Annotated, NamedTuple, TypedDict, TypeVar

import numpy as np

from rsegen.errors import ParameterError, TooLarge
from rsegen.field.stepfield import Ints, StepField, coarse, coarse_indices, coarseness
from rsegen.field.steps import steps
from rsegen.field.traversability import percolation
from rsegen.gazebo.constraint_report import constraint_report, describe_constraints
from rsegen.gazebo.map_summary import costs, warnings
from rsegen.measuring.catalogue import Metric, metric_by
from rsegen.measuring.roughness import ruggedness
from rsegen.page.calls import call_at_once, call_of_host
from rsegen.page.forms import metric_title
from rsegen.page.host import Host, Opened
from rsegen.page.model.actions import Ends, ends_of
from rsegen.page.model.session import Entry, is_enabled, short_seed
from rsegen.page.shown_map import Drawing, ShownMap, base64_of, drawn, figures
from rsegen.params.numbers import lengths_in
from rsegen.params.sorts import Integer
from rsegen.recipe.building import build, owners
from rsegen.recipe.examples import EXAMPLES
from rsegen.recipe.recipe import Recipe
from rsegen.recipe.recipe_file import load
from rsegen.scene.scene import Scene, compose
from rsegen.writing.resources import format_bytes, refuse_too_large

SHOWN_SIDE = 400
"""Larger maps than about this many cells a side are shown coarser, by the highest of several cells."""

COUNTED = 100_000
"""Files are counted for maps of up to this many cells."""

_Made = TypeVar("_Made")

_KEPT = 16
"""Maps of a document that are kept: those of the last undos, and of pages that show others."""


class MapResults(TypedDict):
    """The metrics and costs of a map, which take more work than to draw it.

    A page asks for it where it shows it.
    """

    metrics: list[tuple[str, str, str]]  # name, value, meaning
    cost: str  # "1 model, 1,024 faces, 34 kB"; of a large map, empty
    constraints: list[str]  # lines of the constraint report


class WarnedMap(Drawing):
    """A map as it is drawn, with its warnings."""

    factor: int  # a cell here is the highest of factor x factor cells of a large map; 1: the cell itself
    warnings: list[str]


class Handle(Ends):
    """Place of the obstacle of a row."""

    row: int


class DocumentMap(WarnedMap):
    """A map of a document as it is drawn, with what only an editor needs."""

    revision: int
    index: int
    owners: str  # base64 of int16 for each cell, as content: the row of the obstacle that made its level; -1: none
    handles: list[Handle]


@call_at_once
def scene(opened: Opened, *, index: int | None = None, page: str = "") -> DocumentMap:
    """Return a map of a document as it is drawn; if the draft is invalid, a map of the last valid recipe."""
    with opened.lock:
        session = opened.session
        recipe, rows, revision = session.recipe, session.draft.rows, session.revision
        index = opened.index_of(page, index, or_first=True)
    return _shown(opened, recipe, rows, revision, index)


@call_at_once
def ghost(opened: Opened, *, entry: Entry, index: int | None = None, page: str = "") -> DocumentMap:
    """Return a map of a document as it would be with another obstacle at the end of the list, drawn as it will be."""
    with opened.lock:
        draft, revision = opened.session.with_row(entry), opened.session.revision
        index = opened.index_of(page, index, or_first=True)
    return _shown(opened, draft.recipe(), draft.rows, revision, index)


@call_at_once
def results(opened: Opened, *, index: int | None = None, page: str = "") -> MapResults:
    """Return what is measured of a map of a document, and what it costs; of a draft that is invalid, as `scene`."""
    with opened.lock:
        recipe = opened.session.recipe
        index = opened.index_of(page, index, or_first=True)
    return cached(opened, ("results", recipe, index), lambda: _results(scene_of_map(opened, recipe, index)))


def _results(made: Scene) -> MapResults:
    n_x, n_y = made.field.shape
    return {
        "metrics": list(figures(made.field, lengths_in(made.recipe.units))),
        "cost": _cost(made) if n_x * n_y <= COUNTED else "",
        "constraints": list(describe_constraints(made, constraint_report(made))),
    }


def _cost(made: Scene) -> str:
    models, _, faces, size = costs(made)
    return f"{models:,} model{'s'[: models != 1]}, {faces:,} faces, {format_bytes(size)}"


def _shown(opened: Opened, recipe: Recipe, rows: Sequence[Entry], revision: int, index: int) -> DocumentMap:
    """Return a map of a recipe as it is drawn, with what an editor knows of the rows of a list."""
    drawn = cached(opened, ("drawn", recipe, index), lambda: _drawn(scene_of_map(opened, recipe, index)))
    ends = ((row, ends_of(entry, recipe, index)) for row, entry in enumerate(rows) if is_enabled(entry))
    return {
        **drawn.content,
        "revision": revision,
        "index": index,
        "owners": _owners(drawn.owners, recipe, rows),
        "handles": [{"row": row, **at} for row, at in ends if at],
    }


def scene_of_map(opened: Opened, recipe: Recipe, index: int) -> Scene:
    """Return map `index` of a recipe; TooLarge if it needs more memory than is free."""

    def made() -> Scene:
        refuse_too_large(recipe, "measure")
        try:
            return compose(recipe, index)
        except MemoryError:
            raise TooLarge("this map needs more memory than is free; use fewer chunks or smaller ones") from None

    return cached(opened, ("scene", recipe, index), made)


def cached(opened: Opened, key: object, make: Callable[[], _Made]) -> _Made:
    """Return what was made for a key, or make it, and keep it with the document."""
    with opened.lock:
        if key in opened.kept:
            opened.kept.move_to_end(key)
            known: _Made = opened.kept[key]
            return known
    made = make()  # without the lock, as it may take seconds; at worst two calls make it
    with opened.lock:
        opened.kept[key] = made
        while len(opened.kept) > _KEPT:
            opened.kept.popitem(last=False)
    return made


class _Drawn(NamedTuple):
    """A map as it is drawn, and the rows of the recipe that made its cells."""

    content: WarnedMap
    owners: Ints


def _drawn(made: Scene) -> _Drawn:
    """Return what is drawn of a map, and the rows of the recipe that made its cells."""
    factor = coarseness(made.field, SHOWN_SIDE)
    rows = np.full(made.field.shape, -1, dtype=np.int32)
    rows[np.ix_(made.field.inside(0), made.field.inside(1))] = owners(made.recipe, made.index)
    shown: WarnedMap = {
        **drawn(ShownMap.of(made, "", ".yaml"), factor),
        "factor": factor,
        "warnings": list(warnings(made)) if made.recipe.obstacles else [],
    }
    return _Drawn(shown, rows[coarse_indices(made.field, factor)])


def _owners(cells: Ints, recipe: Recipe, rows: Sequence[Entry]) -> str:
    """Return for each cell the row of the list that made it, in base64; obstacles are matched by their keys.

    A draft that is invalid may have other rows than the recipe that is drawn.
    """
    places = {entry.get("key"): row for row, entry in enumerate(rows) if isinstance(entry.get("key"), str)}
    in_list = np.array([places.get(obstacle.key, -1) for obstacle in recipe.obstacles] + [-1], dtype=np.int32)
    owner = in_list[cells]
    return base64_of(np.where(owner > _MOST_ROWS, -1, owner), "<i2")


_MOST_ROWS = 32767
"""The highest row that two bytes have; blocks of higher ones are picked as nobody's."""


_COUNT = Integer(1, 24, unit="maps")
"""Number of small pictures: with more, each would be too small."""

_OPENED = 40_000
"""Cells of a map up to which the smallest step across it is found: of more it takes too long for a picture."""

_SIDE = 100
"""Cells along the longer side of a small map, at most: of larger ones each is the highest of several."""


class Variant(TypedDict):
    """A map to choose from."""

    seed: Annotated[int, "number | bigint"]
    index: int
    scene: Drawing
    difficulty: list[tuple[str, str]]


@call_of_host
def variants(host: Host, *, doc: str, count: int) -> list[Variant]:
    """Return the first map of a document's recipe at fresh seeds."""
    count = _COUNT.check("count", count)
    opened = host.opened(doc)
    with opened.newest_turn("variants"):
        recipe = opened.session.recipe
        seeds = dict.fromkeys([recipe.seed])
        while len(seeds) <= count:
            seeds[short_seed()] = None
        return [_variant(replace(recipe, seed=seed), recipe.first_map) for seed in list(seeds)[1:]]


@call_of_host
def maps(host: Host, *, doc: str, first: int, count: int, by: str = "") -> list[Variant]:
    """Return `count` maps of a document's recipe from the place `first` on in their order, or as many as there are.

    by: a metric by which they are sorted, the lowest first, those without it last; of many maps some are taken, evenly
    spaced
    """
    count = _COUNT.check("count", count)
    metric = metric_by(by) if by else None
    opened = host.opened(doc)
    with opened.newest_turn("variants") as check:
        recipe = opened.session.recipe
        indices = _sorted(opened, recipe, metric, check) if metric else recipe.indices
        if not 0 <= first < len(indices):
            raise ParameterError("first", f"{first} is outside 0..{len(indices) - 1}")
        return [_variant(recipe, index, metric) for index in indices[first : first + count]]


_MOST_MADE = 12
"""Maps that were written, of which pictures are drawn."""


@call_of_host
def made_maps(host: Host, *, paths: list[str]) -> list[Variant]:
    """Return the maps of recipes in the folder of the page, the first of each: of what a command has just written."""
    recipes = [load(host.places.inside(path)) for path in paths[:_MOST_MADE]]
    return [_variant(recipe, recipe.first_map) for recipe in recipes]


@call_of_host
def example_maps(_: Host) -> dict[str, Drawing]:
    """Return the first map of each example as a small picture is drawn of it, by its name."""
    recipes = {name: load(path) for name, path in EXAMPLES.items()}
    return {name: _small(compose(recipe, recipe.first_map)) for name, recipe in recipes.items()}


_MOST_SORTED = 200
"""Maps that are measured to be sorted: some milliseconds each."""


def _sorted(opened: Opened, recipe: Recipe, metric: Metric, check: Callable[[], None]) -> Sequence[int]:
    """Return indices of maps by a metric of them, kept for the next pictures of the same order."""

    def measured(index: int) -> tuple[bool, float]:
        check()
        value = metric(build(recipe, index))
        return isnan(value), value

    def made() -> Sequence[int]:
        n_x, n_y = recipe.grid.shape
        if n_x * n_y > _OPENED:
            raise TooLarge(f"maps of more than {_OPENED:,} blocks take too long to sort")
        all_maps = recipe.indices
        taken = [all_maps[at * len(all_maps) // _MOST_SORTED] for at in range(_MOST_SORTED)]
        return sorted(dict.fromkeys(taken), key=measured)

    return cached(opened, ("sorted", recipe, metric.name), made)


def _variant(recipe: Recipe, index: int, metric: Metric | None = None) -> Variant:
    """Return a map with its seed, index and difficulty, and a metric if it is asked for."""
    refuse_too_large(recipe)
    scene = compose(recipe, index)
    return {
        "seed": recipe.seed,
        "index": index,
        "scene": _small(scene),
        "difficulty": list(_difficulty(scene.field, recipe.units, metric)),
    }


def _small(scene: Scene) -> Drawing:
    """Return a map as a small picture is drawn of it; a large one coarser."""
    small = replace(scene, field=coarse(scene.field, coarseness(scene.field, _SIDE)))
    return {**drawn(ShownMap.of(small, "", ".yaml")), "step": scene.field.unit, "look": scene.recipe.look}


def _difficulty(field: StepField, units: str, metric: Metric | None) -> Iterator[tuple[str, str]]:
    """Yield a metric that is asked for, and what says how hard a field is to cross, quickly found."""
    if field.frame.all():
        return
    written = lengths_in(units)

    def length(metres: float | None) -> str:  # to a millimetre
        return "-" if metres is None else f"{written.short(round(metres * 1e3) * 1_000_000)} {written.unit}"

    if metric:
        value = metric(field)
        figure = "-" if isnan(value) else length(value) if metric.unit == "m" else f"{value:.3g} {metric.unit}".strip()
        yield metric_title(metric.name), figure
    if field.levels.size <= _OPENED:
        opens = percolation(field, 0.0)
        yield "smallest step across", length(max(opens.west_east, opens.south_north))
    yield "mean step", length(steps(field).mean)
    yield "TRI", length(ruggedness(field).tri)
