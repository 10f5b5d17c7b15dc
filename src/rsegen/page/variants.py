"""Small maps for a page to choose from: of a recipe at other seeds, and the maps that a recipe has itself."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from math import isnan
from typing import Any

from rsegen.errors import ParameterError, TooLarge
from rsegen.exporters.browser.page import ShownMap, drawn
from rsegen.exporters.numbers import lengths_in
from rsegen.exporters.scene import compose
from rsegen.field.metrics.catalogue import Metric, metric_by
from rsegen.field.metrics.roughness import ruggedness, steps
from rsegen.field.metrics.traversability import percolation
from rsegen.field.stepfield import StepField, coarse, coarseness
from rsegen.io.resources import refuse_too_large
from rsegen.page.calls import call_of_host
from rsegen.page.forms import metric_title
from rsegen.page.host import Host, Opened
from rsegen.page.model.session import short_seed
from rsegen.page.scenes import kept
from rsegen.params.sorts import Integer
from rsegen.recipe.building import build
from rsegen.recipe.recipe import Recipe

_COUNT = Integer(1, 24, unit="maps")
"""More would be too small to be told apart."""

_OPENED = 40_000
"""Cells of a map up to which the smallest step across it is found: of more it takes too long for a picture."""

_SIDE = 100
"""Cells along the longer side of a small map, at most: of larger ones each is the highest of several."""


@call_of_host
def variants(host: Host, *, doc: str, count: int) -> list[dict[str, Any]]:
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
def maps(host: Host, *, doc: str, first: int, count: int, by: str = "") -> list[dict[str, Any]]:
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
            raise TooLarge(f"maps of more than {_OPENED:,} blocks take too long to be sorted")
        all_maps = recipe.indices
        taken = [all_maps[at * len(all_maps) // _MOST_SORTED] for at in range(_MOST_SORTED)]
        return sorted(dict.fromkeys(taken), key=measured)

    return kept(opened, ("sorted", recipe, metric.name), made)


def _variant(recipe: Recipe, index: int, metric: Metric | None = None) -> dict[str, Any]:
    """Return a map with its seed, index and difficulty, and a metric if it is asked for; large maps coarser."""
    refuse_too_large(recipe)
    scene = compose(recipe, index)
    small = replace(scene, field=coarse(scene.field, coarseness(scene.field, _SIDE)))
    shown = drawn(ShownMap.of(small, "", ".yaml"))
    return {
        "seed": recipe.seed,
        "index": index,
        # The metrics of a map that is drawn coarser are not its own.
        "scene": shown | {"index": index, "step": scene.field.unit, "look": recipe.look, "metrics": []},
        "difficulty": list(_difficulty(scene.field, recipe.units, metric)),
    }


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
