"""The constraint report: what a recipe demands and what its map has, measured on the field itself."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from rsegen.exporters.scene import Scene
from rsegen.field.metrics.pairs import differences
from rsegen.field.metrics.traversability import crossing
from rsegen.recipe.building import build
from rsegen.recipe.constraints.inventory import blocks


def constraint_report(scene: Scene) -> dict[str, Any]:
    """For each constraint of a map's recipe the demanded and the actual value, as JSON values."""
    recipe = scene.recipe
    found: dict[str, Any] = {}
    if recipe.max_step is not None:
        found["max_step"] = {"asked": recipe.max_step, "is": int(differences(scene.field).max(initial=0))}
    if recipe.climber:
        robot = {name: getattr(recipe.climber, name) for name in ("climb_cm", "drop_cm", "width_cm")}
        ways = (crossing(scene.field, recipe.climber, axis) for axis in (0, 1))
        found["crossable_by"] = robot | {
            name: {"crosses": way.crosses, "length_m": way.length, "cells": way.path.tolist()}
            for name, way in zip(("west_east", "south_north"), ways, strict=True)
        }
    if recipe.inventory is not None:
        found["inventory"] = _inventory(scene, recipe.inventory)
    return found


def describe_constraints(scene: Scene) -> Iterator[str]:
    """The constraint report as lines of text."""
    found = constraint_report(scene)
    if "max_step" in found:
        yield "largest step between neighbours in units: {is}, allowed: {asked}".format(**found["max_step"])
    if "crossable_by" in found:
        both = ((name, found["crossable_by"][name]) for name in ("west_east", "south_north"))
        paths = [name.replace("_", " to ") for name, way in both if way["crosses"]] or ["no side"]
        robot = "climbs {climb_cm:g} cm, descends {drop_cm:g} cm and is {width_cm:g} cm wide"
        yield f"a robot that {robot.format(**found['crossable_by'])} can cross from {' and from '.join(paths)}"
    if "inventory" in found:
        yield f"uses {sum(found['inventory']['used'].values())} blocks of the inventory"


def missing(scene: Scene) -> str:
    """A line about the blocks that the inventory lacks for the map as designed; empty if it lacks none."""
    if scene.recipe.inventory is None:
        return ""
    unit_cm = scene.recipe.unit_cm
    lacks = _inventory(scene, scene.recipe.inventory)["missing"]
    parts = [f"{count} of {round(level * unit_cm, 6):g} cm" for level, count in lacks.items()]
    return f"missing blocks, replaced by others: {', '.join(parts)}" if parts else ""


def _inventory(scene: Scene, owned: tuple[int, ...]) -> dict[str, dict[int, int]]:
    """The numbers of blocks by level: owned, used, and missing for the map as it would be without an inventory."""
    design = build(replace(scene.recipe, inventory=None), scene.index).level_counts()
    used = scene.field.level_counts()
    there = blocks(owned, max(len(owned), *design, *used) + 1)
    lacks = {level: count - int(there[level]) for level, count in design.items() if count > there[level]}
    return {
        "owned": dict(enumerate(owned, 1)),
        "used": {level: count for level, count in used.items() if level},
        "missing": {level: count for level, count in lacks.items() if level},
    }
