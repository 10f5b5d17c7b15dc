"""The drawing of a map of a document on pages.

Maps are kept by recipe and index, so that what follows from one map, asked for by several calls, is made of it once.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeVar

import numpy as np

from rsegen.errors import TooLarge
from rsegen.exporters.browser.page import ShownMap, base64_of, content
from rsegen.exporters.constraint_report import describe_constraints
from rsegen.exporters.map_summary import costs, warnings
from rsegen.exporters.scene import Scene, compose
from rsegen.field.stepfield import Ints, coarse_indices, coarseness
from rsegen.io.resources import format_bytes, refuse_too_large
from rsegen.page.calls import call_at_once
from rsegen.page.host import Opened
from rsegen.page.model.ends import ends_of
from rsegen.page.model.session import Entry, is_enabled
from rsegen.recipe.building import owners
from rsegen.recipe.recipe import Recipe

SHOWN_SIDE = 400
"""Larger maps than about this many cells a side are shown coarser, by the highest of several cells."""

COUNTED = 100_000
"""Files are counted for maps of up to this many cells."""

_Made = TypeVar("_Made")

_KEPT = 16
"""Maps of a document that are kept: those of the last undos, and of pages that show others."""


@call_at_once
def scene(opened: Opened, *, index: int | None = None, page: str = "") -> dict[str, Any]:
    """Return a map of a document as it is drawn; of a draft that is invalid, that of the last valid recipe."""
    with opened.lock:
        session = opened.session
        recipe, rows, revision = session.recipe, session.draft.rows, session.revision
        index = opened.index_of(page, index, or_first=True)
    return _shown(opened, recipe, rows, revision, index)


@call_at_once
def ghost(opened: Opened, *, entry: dict[str, Any], index: int | None = None, page: str = "") -> dict[str, Any]:
    """Return a map of a document as it would be with another obstacle at the end of the list, drawn as it will be."""
    with opened.lock:
        draft, revision = opened.session.with_row(entry), opened.session.revision
        index = opened.index_of(page, index, or_first=True)
    return _shown(opened, draft.recipe(), draft.rows, revision, index)


def _shown(opened: Opened, recipe: Recipe, rows: Sequence[Entry], revision: int, index: int) -> dict[str, Any]:
    """Return a map of a recipe as it is drawn, with what an editor knows of the rows of a list."""
    drawn = kept(opened, ("drawn", recipe, index), lambda: _drawn(scene_of(opened, recipe, index)))
    ends = ((row, ends_of(entry, recipe, index)) for row, entry in enumerate(rows) if is_enabled(entry))
    shown: dict[str, Any] = drawn["content"]
    return shown | {
        "revision": revision,
        "index": index,
        "owners": _owners(drawn["owners"], recipe, rows),
        "handles": [{"row": row, **at} for row, at in ends if at],
    }


def scene_of(opened: Opened, recipe: Recipe, index: int) -> Scene:
    """Return map `index` of a recipe; TooLarge if it needs more memory than is free."""

    def made() -> Scene:
        refuse_too_large(recipe, "measure")
        try:
            return compose(recipe, index)
        except MemoryError:
            raise TooLarge("this map needs more memory than is free; give fewer chunks or smaller ones") from None

    return kept(opened, ("scene", recipe, index), made)


def kept(opened: Opened, key: object, make: Callable[[], _Made]) -> _Made:
    """Return what was made for a key, or make it, and keep it with the document."""
    with opened.lock:
        if key in opened.kept:
            opened.kept.move_to_end(key)
            known: _Made = opened.kept[key]
            return known
    made = make()
    with opened.lock:
        opened.kept[key] = made
        while len(opened.kept) > _KEPT:
            opened.kept.popitem(last=False)
    return made


def _drawn(made: Scene) -> Mapping[str, Any]:
    """Return what is drawn of a map, and the rows of the recipe that made its cells."""
    factor = coarseness(made.field, SHOWN_SIDE)
    n_x, n_y = made.field.shape
    rows = np.full(made.field.shape, -1, dtype=np.int32)
    rows[np.ix_(made.field.inside(0), made.field.inside(1))] = owners(made.recipe, made.index)
    shown = content(ShownMap.of(made, "", ".yaml"), factor) | {
        "factor": factor,
        "warnings": list(warnings(made)) if made.recipe.obstacles else [],
        "cost": _cost(made) if n_x * n_y <= COUNTED else "",
        "constraints": list(describe_constraints(made)),
    }
    return {"content": shown, "owners": rows[coarse_indices(made.field, factor)]}


def _cost(made: Scene) -> str:
    models, _, faces, size = costs(made)
    return f"{models:,} model{'s'[: models != 1]}, {faces:,} faces, {format_bytes(size)}"


def _owners(cells: Ints, recipe: Recipe, rows: Sequence[Entry]) -> str:
    """Return the rows of the list that made the cells, in base64: those of the recipe by their keys.

    A draft that is invalid may have other rows than the recipe that is drawn.
    """
    places = {entry.get("key"): row for row, entry in enumerate(rows) if isinstance(entry.get("key"), str)}
    in_list = np.array([places.get(obstacle.key, -1) for obstacle in recipe.obstacles] + [-1], dtype=np.int32)
    found = in_list[cells]
    return base64_of(np.where(found > _MOST_ROWS, -1, found), "<i2")


_MOST_ROWS = 32767
"""The highest row that two bytes have; blocks of higher ones are picked as nobody's."""
