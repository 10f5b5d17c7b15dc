"""The constraint report: what a recipe demands and what its map has, measured on the field itself.

A map is compared with two others, each by its name: the map that the obstacles ask for; and with an inventory the map
that max_step and crossable_by make of it, in whose place the blocks in stock are put.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from rsegen.field.stepfield import Array, Mask, StepField
from rsegen.params.capabilities import commands
from rsegen.params.numbers import lengths_in, whole_degrees
from rsegen.recipe.building import build
from rsegen.scene.scene import Scene

if TYPE_CHECKING:
    from rsegen.field.crossing import CrossingModel
    from rsegen.recipe.recipe import Recipe


def constraint_report(scene: Scene) -> dict[str, Any]:
    """Return the demanded and the actual value of each constraint of a map's recipe, as JSON values."""
    from rsegen.field.steps import differences

    recipe = scene.recipe
    report: dict[str, Any] = {}
    if recipe.max_step is not None:
        report["max_step"] = {"asked": recipe.max_step, "is": int(differences(scene.field).max(initial=0))}
    if recipe.crosser is not None:
        report["crossable_by"] = _crossings(scene, recipe.crosser)
    if recipe.is_constrained:
        report["obstacles"] = _comparison(scene, _as_asked(scene))
    if recipe.inventory is not None:
        report["inventory"] = _inventory(scene, recipe.inventory)
        if limits := _limits(recipe):
            limited = _without_inventory(scene)
            missing = {"missing": _missing(recipe.inventory, limited)}
            report["limited"] = {"by": limits, **_comparison(scene, limited), **missing}
    return report


def _as_asked(scene: Scene) -> StepField:
    """Return the map that the obstacles ask for, with none of the constraints."""
    return _built(replace(scene.recipe, max_step=None, crossable_by=None, inventory=None), scene.index)


def _without_inventory(scene: Scene) -> StepField:
    """Return the map for which the blocks of an inventory are chosen: the obstacles', within the other constraints."""
    return _built(replace(scene.recipe, inventory=None), scene.index)


def _limits(recipe: Recipe) -> list[str]:
    """Return the names of the constraints that change a map before its blocks are taken from an inventory."""
    return [name for name in ("max_step", "crossable_by") if getattr(recipe, name) is not None]


def _made_of_it(limits: list[str]) -> str:
    return f"{' and '.join(limits)} make{'s'[: len(limits) == 1]} of it"


def _comparison(scene: Scene, other: StepField) -> dict[str, Any]:
    """Return the blocks of another map by level, and how far the levels of this one are from it, in units in all."""
    differs = np.abs(scene.field.levels.astype(np.int64) - other.levels)
    return {"blocks": _blocks_by_level(other), "differs_units": int(differs.sum())}


def _blocks_by_level(field: StepField) -> dict[int, int]:
    return {level: count for level, count in field.level_counts().items() if level}


def _missing(owned: Sequence[int], field: StepField) -> dict[int, int]:
    """Return how many blocks of each level a map needs beyond those that are owned."""
    stock = dict(enumerate(owned, 1))
    counts = _blocks_by_level(field)
    return {level: n - stock.get(level, 0) for level, n in counts.items() if n > stock.get(level, 0)}


def _crossings(scene: Scene, crosser: CrossingModel) -> dict[str, Any]:
    """Return the ways across a map, how rough they are, and how many blocks are lower for them."""
    from rsegen.field.traversability import Crossing

    recipe = scene.recipe
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
            crossable[name]["tilt"] = None if way.tilt is None else round(way.tilt, 4)
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
    return crossable


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
        room = {} if recipe.crossable_room == 1 else {"room": recipe.crossable_room}
        return {"robot": recipe.crossable_by, **room}
    return dict(zip(("climb_cm", "drop_cm", "width_cm"), recipe.crossable_by or (), strict=False))


def describe_constraints(scene: Scene, report: dict[str, Any]) -> Iterator[str]:
    """Yield the constraint report of a map, or what constraints.json has of it, as lines of text."""
    if "max_step" in report:
        yield "largest step between neighbours in units: {is}, allowed: {asked}".format(**report["max_step"])
    if "crossable_by" in report:
        yield from _describe_crossings(scene, report["crossable_by"])
    if "inventory" in report:
        used, owned = (sum(report["inventory"][name].values()) for name in ("used", "owned"))
        most, _ = _most_and_least(scene, scene.recipe.inventory or ())
        fewer = f"; {most:,} without the other constraints" if used < most else ""
        yield f"uses {used:,} of the {owned:,} blocks of the inventory{fewer}"
    if "obstacles" in report:
        yield f"levels differ by {_distances(scene, report)}"


def _describe_crossings(scene: Scene, crossable: dict[str, Any]) -> Iterator[str]:
    """Yield lines on the crossing: by which robot or path, from which sides, the lowered blocks, the roughness."""
    asked = _crossing_parameters(scene.recipe)
    paths = [name.replace("_", " to ") for name in ("west_east", "south_north") if crossable[name]["crosses"]]
    # What a report of a map says is proven by poses or by a path, and not driven.
    crosses, lacks = (f"by its poses, the {asked.get('robot')} {can} get" for can in ("can", "cannot"))
    if "robot" not in asked:
        written = lengths_in(scene.units)
        climb, drop, width = (written.with_unit(asked[f"{name}_cm"] / 100, 3) for name in ("climb", "drop", "width"))
        steps = f"path of steps of {climb} up and {drop} down, {width} wide, leads"
        crosses, lacks = f"a {steps}", f"no {steps}"
    is_to_drive = "robot" in asked and paths and "predict" in commands()
    drive = "; rsegen predict drives it, and says how surely" if is_to_drive else ""
    share = scene.recipe.crossable_room if "robot" in asked else 1
    room = "" if share == 1 else f", with {share:.0%} of the usual room to spare" if share < 1 else ", on level lanes"
    yield f"{crosses} across from {' and from '.join(paths)}{room}{drive}" if paths else f"{lacks} across"
    if "lowered" in crossable:
        blocks, at_0 = crossable["lowered"].values()
        of_all = f"{blocks:,} of the {np.count_nonzero(~scene.field.frame):,} blocks"
        to_0 = f"{at_0:,} of them" if 0 < at_0 < blocks else "all of them" if at_0 else "none of them"
        yield f"{of_all} were lowered for that, {to_0} to level 0" if blocks else "no blocks had to be lowered"
    way, beside = (crossable["roughness"][part] for part in ("on_ways", "beside"))
    if None not in (*way.values(), *beside.values()):
        yield (
            "mean step between neighbouring blocks on its ways: {mean_step:.1f} units, ".format(**way)
            + "elsewhere: {mean_step:.1f}; ".format(**beside)
            + f"blocks at level 0: {way['level_0']:.0%}, elsewhere: {beside['level_0']:.0%}"
        )
    tilts = [tilt for name in ("west_east", "south_north") if (tilt := crossable[name].get("tilt")) is not None]
    if tilts:
        yield f"on its ways the {asked['robot']} tilts by up to {whole_degrees(max(tilts))}"


def _distances(scene: Scene, report: dict[str, Any]) -> str:
    """Return how far a map is from the one that the obstacles ask for and, with an inventory, from the nearest that its
    blocks allow, wherever they are.
    """
    limited = report.get("limited")
    text = f"{report['obstacles']['differs_units']:,} units in total from the map that the obstacles ask for"
    if limited:
        text += f", and by {limited['differs_units']:,} from the map that {_made_of_it(limited['by'])}"
    if scene.recipe.inventory is None:
        return text
    most, least = _most_and_least(scene, scene.recipe.inventory)
    if sum(report["inventory"]["used"].values()) < most:
        return text
    if (limited or report["obstacles"])["differs_units"] <= least:
        return f"{text}, the least that these blocks allow"
    return f"{text}; these blocks would allow {least:,}"


def _most_and_least(scene: Scene, inventory: Sequence[int]) -> tuple[int, int]:
    """Return how many blocks of an inventory a map can use, and the least distance in units from what they replace.

    The bounds are exact for blocks in the order of their levels, without any other constraint.
    """
    from rsegen.recipe.constraints.inventory import nearest_counts

    counts = nearest_counts(_without_inventory(scene), inventory)
    asked, taken = (np.repeat(np.arange(len(numbers)), numbers) for numbers in counts)
    return int(np.count_nonzero(taken)), int(np.abs(taken - asked).sum())


def block_warnings(scene: Scene) -> Iterator[str]:
    """Yield warnings about blocks: replaced by others, left in the box although the map has fewer than designed, or
    other blocks than an obstacle counts, as the largest step does not allow these.
    """
    # Without an inventory only blocks that an obstacle counts can be others than asked for.
    recipe = scene.recipe
    if recipe.inventory is None:
        if recipe.max_step is not None and not _counts_are_kept(scene):
            yield f"no order of the counted blocks keeps to max_step {recipe.max_step}: the map has others"
        return
    owned, limits = recipe.inventory, _limits(recipe)
    report = _inventory(scene, owned)
    lines = {"missing blocks, replaced by others": report["missing"]}
    if limits:
        lines = {
            "blocks missing for the map that the obstacles ask for": report["missing"],
            f"blocks missing for the map that {_made_of_it(limits)}, replaced by others": _missing(
                owned, _without_inventory(scene)
            ),
        }
    written = lengths_in(recipe.units)
    for words, counts in (lines | {"left in the box": report.get("left", {})}).items():
        if counts:
            parts = [f"{n} of {written.level(level, recipe.unit_cm)} {written.unit}" for level, n in counts.items()]
            yield f"{words}: {', '.join(parts)}"


def _counts_are_kept(scene: Scene) -> bool:
    """Return whether the map has the blocks that its random obstacles count, as it would have without constraints."""
    from rsegen.recipe.constraints.meeting import counts_blocks

    return not counts_blocks(scene.recipe) or _as_asked(scene).level_counts() == scene.field.level_counts()


def _inventory(scene: Scene, owned: Sequence[int]) -> dict[str, dict[int, int]]:
    """Return the numbers of blocks by level: owned, used, missing for the map that the obstacles ask for, and left if
    the map has fewer blocks than it would have without an inventory.
    """
    used, wished = _blocks_by_level(scene.field), _blocks_by_level(_without_inventory(scene))
    report = {"owned": dict(enumerate(owned, 1)), "used": used, "missing": _missing(owned, _as_asked(scene))}
    left = {level: count - used.get(level, 0) for level, count in enumerate(owned, 1) if count > used.get(level, 0)}
    return report | ({"left": left} if left and sum(used.values()) < sum(wished.values()) else {})


_built = lru_cache(maxsize=3)(build)
"""Builds a map without some of its constraints; the report, lines and warnings of one map ask for it in turn."""
