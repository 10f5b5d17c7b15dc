"""The constraint report: what a recipe demands and what its map has, measured on the field itself."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from rsegen.exporters.numbers import lengths_in
from rsegen.exporters.scene import Scene
from rsegen.recipe.building import build

if TYPE_CHECKING:
    from rsegen.recipe.recipe import Recipe


def constraint_report(scene: Scene) -> dict[str, Any]:
    """Return the demanded and the actual value of each constraint of a map's recipe, as JSON values."""
    from rsegen.field.metrics.roughness import differences

    recipe = scene.recipe
    report: dict[str, Any] = {}
    if recipe.max_step is not None:
        report["max_step"] = {"asked": recipe.max_step, "is": int(differences(scene.field).max(initial=0))}
    if (crosser := recipe.crosser) is not None:
        ways = zip(("west_east", "south_north"), (crosser.crossing(scene.field, axis) for axis in (0, 1)), strict=True)
        lowered = {} if recipe.inventory else {"lowered": _lowered(scene)}
        report["crossable_by"] = _asked(recipe) | {name: _way(way) for name, way in ways} | lowered
    if recipe.inventory is not None:
        report["inventory"] = _inventory(scene, recipe.inventory)
    return report


def _asked(recipe: Recipe) -> dict[str, Any]:
    """Return what is to get across: a robot by its kind, or limits of steps."""
    if isinstance(recipe.crossable_by, str):
        return {"robot": recipe.crossable_by}
    return dict(zip(("climb_cm", "drop_cm", "width_cm"), recipe.crossable_by or (), strict=False))


def _lowered(scene: Scene) -> dict[str, int]:
    """Return how many blocks are lower than they would be if nothing had to get across, and how many of these are 0."""
    free = _built(replace(scene.recipe, crossable_by=None), scene.index)
    lower = scene.field.levels < free.levels
    return {"blocks": int(lower.sum()), "to_level_0": int((lower & (scene.field.levels == 0)).sum())}


def _told_lowered(scene: Scene, blocks: int, to_level_0: int) -> str:
    if not blocks:
        return "no block is lower for that than it would be"
    lower = f"{blocks:,} of the {np.count_nonzero(~scene.field.frame):,} blocks are lower for that than they would be"
    if to_level_0 < blocks:
        return f"{lower}, {to_level_0:,} of these at level 0"
    return f"{lower}, all of these at level 0, so its ways are flat; a max_step keeps them rough"


def _way(way: Any) -> dict[str, Any]:
    """Return a way as JSON values: by cells, or by the points of a robot's, metres."""
    from rsegen.field.metrics import Crossing

    ends: dict[str, Any] = {"crosses": way.crosses, "length_m": way.length}
    if isinstance(way, Crossing):
        return ends | {"cells": way.path.tolist()}
    return ends | {"points_m": np.round(way.points, 6).tolist()}


def describe_constraints(scene: Scene) -> Iterator[str]:
    """Yield the constraint report as lines of text."""
    report = constraint_report(scene)
    if "max_step" in report:
        yield "largest step between neighbours in units: {is}, allowed: {asked}".format(**report["max_step"])
    if "crossable_by" in report:
        both = ((name, report["crossable_by"][name]) for name in ("west_east", "south_north"))
        paths = [name.replace("_", " to ") for name, way in both if way["crosses"]] or ["no side"]
        asked, written = _asked(scene.recipe), lengths_in(scene.units)
        what = f"{asked.get('robot')} drives"
        if "robot" not in asked:
            climb, drop, width = (written.said(asked[f"{name}_cm"] / 100, 3) for name in ("climb", "drop", "width"))
            what = f"a path of steps of {climb} up and {drop} down, {width} wide, leads"
        yield f"{what} across from {' and from '.join(paths)}"
        if "lowered" in report["crossable_by"]:
            yield _told_lowered(scene, **report["crossable_by"]["lowered"])
    if "inventory" in report:
        used, owned = (sum(report["inventory"][name].values()) for name in ("used", "owned"))
        nearness = _nearness(scene, scene.recipe.inventory or ())
        yield f"uses {used:,} of the {owned:,} blocks of the inventory; {nearness}"


def _nearness(scene: Scene, inventory: tuple[int, ...]) -> str:
    """Return how far a map is from the design, and from the nearest to it that these blocks allow, wherever they are.

    The bound is that of the blocks in the order of their levels, without any other constraint; it is exact then.
    """
    from rsegen.recipe.constraints.inventory import nearest_counts

    field, design = scene.field, _built(replace(scene.recipe, inventory=None), scene.index)
    cells, counts = ~field.frame, nearest_counts(design, inventory)
    asked, taken = (np.repeat(np.arange(len(each)), each) for each in counts)
    most, used = np.count_nonzero(taken), np.count_nonzero(field.levels[cells])
    if used < most:
        return f"{most:,} without the other constraints"
    least = int(np.abs(taken - asked).sum())
    differs = int(np.abs(field.levels[cells].astype(np.int64) - design.levels[cells]).sum())
    if differs <= least:
        return f"levels differ from the design by {differs:,} units in all, the least that these blocks allow"
    return f"levels differ from the design by {differs:,} units in all; these blocks would allow {least:,}"


def block_warnings(scene: Scene) -> Iterator[str]:
    """Yield warnings about blocks: replaced by others, left in the box although the map has fewer than designed, or
    other blocks than an obstacle counts, as the largest step does not allow these.
    """
    recipe = scene.recipe
    if recipe.inventory is None:
        if recipe.max_step is not None and not _counts_are_kept(scene):
            yield f"no order of the counted blocks keeps to max_step {recipe.max_step}: the map has others"
        return
    report = _inventory(scene, recipe.inventory)
    for name, words in (("missing", "missing blocks, replaced by others"), ("left", "left in the box")):
        if report.get(name):
            written = lengths_in(recipe.units)
            parts = [
                f"{count} of {written.level(level, recipe.unit_cm)} {written.unit}"
                for level, count in report[name].items()
            ]
            yield f"{words}: {', '.join(parts)}"


def _counts_are_kept(scene: Scene) -> bool:
    """Return whether the map has the blocks that its random obstacles count, as it would have without constraints."""
    from rsegen.field.obstacles.random import Random

    counting = (isinstance(row, Random) and row.counts for _, row in scene.recipe.enabled_obstacles)
    if not any(counting):
        return True
    design = build(replace(scene.recipe, max_step=None, crossable_by=None), scene.index)
    return design.level_counts() == scene.field.level_counts()


def _inventory(scene: Scene, owned: tuple[int, ...]) -> dict[str, dict[int, int]]:
    """Return the numbers of blocks by level: owned, used, missing for the map as it would be without an inventory, and
    left if the map has fewer blocks than that one.
    """
    from rsegen.recipe.constraints.inventory import blocks

    design = _above_0(_built(replace(scene.recipe, inventory=None), scene.index).level_counts())
    used = _above_0(scene.field.level_counts())
    there = blocks(owned, max(len(owned), *design, *used, 0) + 1)
    report = {
        "owned": dict(enumerate(owned, 1)),
        "used": used,
        "missing": {level: count - int(there[level]) for level, count in design.items() if count > there[level]},
    }
    left = {level: count - used.get(level, 0) for level, count in enumerate(owned, 1) if count > used.get(level, 0)}
    return report | ({"left": left} if left and sum(used.values()) < sum(design.values()) else {})


_built = lru_cache(maxsize=1)(build)
"""Builds a map without one of its constraints; the report, lines and warnings of one map ask for it in turn."""


def _above_0(counts: dict[int, int]) -> dict[int, int]:
    return {level: count for level, count in counts.items() if level}
