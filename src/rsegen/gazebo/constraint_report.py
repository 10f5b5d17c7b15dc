"""The constraint report: what a recipe demands and what its map has, measured on the field itself."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from rsegen.field.stepfield import Array, Mask, StepField
from rsegen.params.numbers import lengths_in
from rsegen.recipe.building import build
from rsegen.scene.scene import Scene

if TYPE_CHECKING:
    from rsegen.recipe.recipe import Recipe


def constraint_report(scene: Scene) -> dict[str, Any]:
    """Return the demanded and the actual value of each constraint of a map's recipe, as JSON values."""
    from rsegen.field.steps import differences
    from rsegen.field.traversability import Crossing

    recipe = scene.recipe
    report: dict[str, Any] = {}
    if recipe.max_step is not None:
        report["max_step"] = {"asked": recipe.max_step, "is": int(differences(scene.field).max(initial=0))}
    if (crosser := recipe.crosser) is not None:
        crossable = _crossing_parameters(recipe)
        on_way = np.zeros(scene.field.shape, bool)
        for axis, name in enumerate(("west_east", "south_north")):
            way = crosser.crossing(scene.field, axis)
            crossable[name] = {"crosses": way.crosses, "length_m": way.length}
            if isinstance(way, Crossing):
                crossable[name]["cells"] = way.path.tolist()
                inside = ((way.path >= 0) & (way.path < scene.field.shape)).all(axis=1)  # it begins on the ground
                on_way[tuple(way.path[inside].T)] = True
            else:
                crossable[name]["points_m"] = np.round(way.points, 6).tolist()
                on_way |= _cells_near(scene.field, way.points, crosser.width)
        crossable["roughness"] = {
            "on_ways": _roughness(scene.field, on_way),
            "beside": _roughness(scene.field, ~on_way),
        }
        if not recipe.inventory:
            # Blocks that are lower than they would be if nothing had to get across.
            lower = scene.field.levels < _built(replace(recipe, crossable_by=None), scene.index).levels
            to_level_0 = int((lower & (scene.field.levels == 0)).sum())
            crossable["lowered"] = {"blocks": int(lower.sum()), "to_level_0": to_level_0}
        report["crossable_by"] = crossable
    if recipe.inventory is not None:
        report["inventory"] = _inventory(scene, recipe.inventory)
    return report


def _cells_near(field: StepField, points: Array, width: float) -> Mask:
    """Return the cells whose middles are within half a width [m] of a line through points (k, 2), (n_x, n_y)."""
    near, middles = np.zeros(field.shape, bool), np.stack(np.meshgrid(*field.middles(), indexing="ij"), axis=-1)
    for begin, end in pairwise(points):
        along = end - begin
        share = np.clip((middles - begin) @ along / max(float(along @ along), 1e-12), 0, 1)
        away = np.linalg.norm(middles - begin - share[..., None] * along, axis=-1)
        near |= away <= max(width, field.block_width) / 2
    return near


def _roughness(field: StepField, cells: Mask) -> dict[str, float | None]:
    """Return the mean step between neighbouring blocks in a mask, in units, and the share of them at level 0."""
    cells, levels = cells & ~field.frame, field.levels.astype(np.int64)
    steps = [
        np.abs(np.diff(levels, axis=axis))[np.take(cells, range(1, n), axis) & np.take(cells, range(n - 1), axis)]
        for axis, n in enumerate(levels.shape)
    ]
    step, own = np.concatenate(steps), levels[cells]
    return {
        "mean_step": round(float(step.mean()), 3) if len(step) else None,
        "level_0": round(float((own == 0).mean()), 3) if len(own) else None,
    }


def _crossing_parameters(recipe: Recipe) -> dict[str, Any]:
    """Return what is to get across: a robot by its kind, or limits of steps."""
    if isinstance(recipe.crossable_by, str):
        return {"robot": recipe.crossable_by}
    return dict(zip(("climb_cm", "drop_cm", "width_cm"), recipe.crossable_by or (), strict=False))


def describe_constraints(scene: Scene) -> Iterator[str]:
    """Yield the constraint report as lines of text."""
    report = constraint_report(scene)
    if "max_step" in report:
        yield "largest step between neighbours in units: {is}, allowed: {asked}".format(**report["max_step"])
    if "crossable_by" in report:
        crossable, asked = report["crossable_by"], _crossing_parameters(scene.recipe)
        # Who or what gets across, from which sides, and which blocks are lower for it.
        paths = [name.replace("_", " to ") for name in ("west_east", "south_north") if crossable[name]["crosses"]]
        # What a report of a map says is proven by poses or by a path, and not driven.
        what, lacks = (f"predicted: the {asked.get('robot')} {can} get" for can in ("can", "cannot"))
        if "robot" not in asked:
            written = lengths_in(scene.units)
            climb, drop, width = (
                written.with_unit(asked[f"{name}_cm"] / 100, 3) for name in ("climb", "drop", "width")
            )
            steps = f"path of steps of {climb} up and {drop} down, {width} wide, leads"
            what, lacks = f"a {steps}", f"no {steps}"
        yield f"{what} across from {' and from '.join(paths)}" if paths else f"{lacks} across"
        if "lowered" in crossable:
            blocks, at_0 = crossable["lowered"].values()
            of_all = f"{blocks:,} of the {np.count_nonzero(~scene.field.frame):,} blocks"
            to_0 = f"{at_0:,} of them" if 0 < at_0 < blocks else "all of them" if at_0 else "none of them"
            yield f"{of_all} were lowered for that, {to_0} to level 0" if blocks else "no blocks had to be lowered"
        way, beside = (crossable["roughness"][part] for part in ("on_ways", "beside"))
        if None not in (*way.values(), *beside.values()):
            yield (
                "on its ways neighbouring blocks differ by {mean_step:.1f} units on average, and {level_0:.0%} of the "
                "blocks are at level 0; ".format(**way)
                + "beside its ways by {mean_step:.1f} units, and {level_0:.0%} are".format(**beside)
            )
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
    asked, taken = (np.repeat(np.arange(len(numbers)), numbers) for numbers in counts)
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
    from rsegen.obstacles.random import Random

    counting = (isinstance(row, Random) and row.counts for _, row in scene.recipe.enabled_obstacles)
    if not any(counting):
        return True
    design = build(replace(scene.recipe, max_step=None, crossable_by=None), scene.index)
    return design.level_counts() == scene.field.level_counts()


def _inventory(scene: Scene, owned: tuple[int, ...]) -> dict[str, dict[int, int]]:
    """Return the numbers of blocks by level: owned, used, missing for the map as it would be without an inventory, and
    left if the map has fewer blocks than that one.
    """
    from rsegen.recipe.constraints.inventory import block_counts

    fields = _built(replace(scene.recipe, inventory=None), scene.index), scene.field
    design, used = ({level: n for level, n in field.level_counts().items() if level} for field in fields)
    there = block_counts(owned, max(len(owned), *design, *used, 0) + 1)
    report = {
        "owned": dict(enumerate(owned, 1)),
        "used": used,
        "missing": {level: count - int(there[level]) for level, count in design.items() if count > there[level]},
    }
    left = {level: count - used.get(level, 0) for level, count in enumerate(owned, 1) if count > used.get(level, 0)}
    return report | ({"left": left} if left and sum(used.values()) < sum(design.values()) else {})


_built = lru_cache(maxsize=1)(build)
"""Builds a map without one of its constraints; the report, lines and warnings of one map ask for it in turn."""
