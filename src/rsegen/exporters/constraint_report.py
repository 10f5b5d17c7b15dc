"""The constraint report: what a recipe demands and what its map has, measured on the field itself."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from rsegen.exporters.numbers import lengths_in
from rsegen.exporters.scene import Scene
from rsegen.recipe.building import build


def constraint_report(scene: Scene) -> dict[str, Any]:
    """Return the demanded and the actual value of each constraint of a map's recipe, as JSON values."""
    from rsegen.field.metrics.roughness import differences
    from rsegen.field.metrics.traversability import crossing

    recipe = scene.recipe
    report: dict[str, Any] = {}
    if recipe.max_step is not None:
        report["max_step"] = {"asked": recipe.max_step, "is": int(differences(scene.field).max(initial=0))}
    if recipe.climber:
        robot = {name: getattr(recipe.climber, name) for name in ("climb_cm", "drop_cm", "width_cm")}
        ways = (crossing(scene.field, recipe.climber, axis) for axis in (0, 1))
        report["crossable_by"] = robot | {
            name: {"crosses": way.crosses, "length_m": way.length, "cells": way.path.tolist()}
            for name, way in zip(("west_east", "south_north"), ways, strict=True)
        }
    if recipe.inventory is not None:
        report["inventory"] = _inventory(scene, recipe.inventory)
    return report


def describe_constraints(scene: Scene) -> Iterator[str]:
    """Yield the constraint report as lines of text."""
    report = constraint_report(scene)
    if "max_step" in report:
        yield "largest step between neighbours in units: {is}, allowed: {asked}".format(**report["max_step"])
    if "crossable_by" in report:
        both = ((name, report["crossable_by"][name]) for name in ("west_east", "south_north"))
        paths = [name.replace("_", " to ") for name, way in both if way["crosses"]] or ["no side"]
        robot = "climbs {climb_cm:g} cm, descends {drop_cm:g} cm and is {width_cm:g} cm wide"
        yield f"a robot that {robot.format(**report['crossable_by'])} can cross from {' and from '.join(paths)}"
    if "inventory" in report:
        used, owned = (sum(report["inventory"][name].values()) for name in ("used", "owned"))
        yield f"uses {used:,} of the {owned:,} blocks of the inventory"


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

    counting = (isinstance(row, Random) and row.counts for row in scene.recipe.obstacles)
    if not any(counting):
        return True
    design = build(replace(scene.recipe, max_step=None, crossable_by=None), scene.index)
    return design.level_counts() == scene.field.level_counts()


def _inventory(scene: Scene, owned: tuple[int, ...]) -> dict[str, dict[int, int]]:
    """Return the numbers of blocks by level: owned, used, missing for the map as it would be without an inventory, and
    left if the map has fewer blocks than that one.
    """
    from rsegen.recipe.constraints.inventory import blocks

    design = _above_0(build(replace(scene.recipe, inventory=None), scene.index).level_counts())
    used = _above_0(scene.field.level_counts())
    there = blocks(owned, max(len(owned), *design, *used, 0) + 1)
    report = {
        "owned": dict(enumerate(owned, 1)),
        "used": used,
        "missing": {level: count - int(there[level]) for level, count in design.items() if count > there[level]},
    }
    left = {level: count - used.get(level, 0) for level, count in enumerate(owned, 1) if count > used.get(level, 0)}
    return report | ({"left": left} if left and sum(used.values()) < sum(design.values()) else {})


def _above_0(counts: dict[int, int]) -> dict[int, int]:
    return {level: count for level, count in counts.items() if level}
