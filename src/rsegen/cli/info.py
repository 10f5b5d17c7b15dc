"""The command `rsegen info`: the size of a map, its obstacles and its cost, or whether its files are intact."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from rsegen.cli.flags import (
    add_target_flags,
    add_target_recipe_flags,
    is_of_flags,
    scene_of_flags,
    which_map,
)
from rsegen.cli.generate import SHOWN
from rsegen.cli.parser import Parser
from rsegen.cli.report import Report
from rsegen.errors import ParameterError
from rsegen.params.numbers import counted
from rsegen.params.sorts import parameters

if TYPE_CHECKING:
    from rsegen.scene.scene import Scene


_CONSTRAINTS = ("max_step", "crossable_by", "crossable_room", "inventory")


_LONGEST = 100
"""Letters of an obstacle: a matrix may have thousands."""


def add_info(command: Parser) -> None:
    """Add the flags of `rsegen info`."""
    text = "Print the size of a map, its obstacles, the blocks of each level, and its cost in faces and bytes."
    command.explain(text)
    add_target_flags(command)
    text = "compare every file in DIR, and in the maps in it, with the sizes and checksums that rsegen recorded"
    command.group("output").add_argument("--verify", action="store_true", help=text)
    add_target_recipe_flags(command)


def run_info(arguments: argparse.Namespace) -> Report:
    """Summarise the map, or verify a folder."""
    if arguments.verify:
        return _verified(arguments)
    scene = scene_of_flags(arguments)
    content = _summary(scene)
    return Report(lines=_lines(scene, content), content=content, notes=which_map(arguments.target, arguments.map))


def _verified(arguments: argparse.Namespace) -> Report:
    """Compare a folder with its records, and say what was compared."""
    from rsegen.writing.journal import verify

    if arguments.target is None or arguments.map is not None or is_of_flags(arguments):
        raise ParameterError("--verify", "needs a folder that rsegen wrote, and no recipe")
    verified = verify(arguments.target)
    unlisted = [str(path) for path in verified.unlisted]
    lines = [f"{counted(verified.files, 'file')} in {counted(verified.folders, 'folder')} as rsegen wrote them"]
    lines += [f"not written by rsegen: {path}" for path in unlisted]
    return Report(lines=lines, content={"folders": verified.folders, "files": verified.files, "unlisted": unlisted})


def _summary(scene: Scene) -> dict[str, Any]:
    from rsegen.gazebo.map_summary import costs, switched_off, warnings
    from rsegen.recipe.building import placed_obstacles
    from rsegen.recipe.codec import needed_plugins
    from rsegen.scene.scene import fingerprint

    field, recipe = scene.field, scene.recipe
    # Most maps have neither, so these keys are there only if they have a value.
    added = {"plugins": needed_plugins(recipe), "switched_off": switched_off(recipe)}
    return {
        "name": scene.name,
        "seed": recipe.seed,
        "size": list(field.shape),
        "size_m": list(field.extent),
        "unit_cm": recipe.unit_cm,
        "levels": list(field.level_counts()),
        "level_counts": field.level_counts(),
        "fingerprint": fingerprint(field.blocks),
        "obstacles": [obstacle.entry() for _, obstacle in recipe.enabled_obstacles],
        "placed": list(placed_obstacles(recipe, scene.index)),
        "constraints": {name: value for name, value in recipe.entry().items() if name in _CONSTRAINTS},
        "mesh_type": recipe.mesh_type,
        **costs(scene)._asdict(),
        "warnings": list(warnings(scene)),
        **{name: known for name, known in added.items() if known},
    }


def _place_in_words(place: Mapping[str, Any]) -> str:
    """Return the drawn place of an obstacle, as `drawn: first=3,2 last=7,6; covers 25 blocks within 3,2..7,6`."""
    first, last, patch = place["first"], place["last"], place["patch"]
    text = f"drawn: first={first[0]},{first[1]} last={last[0]},{last[1]}; covers {counted(patch['blocks'], 'block')}"
    if "from" not in patch:
        return text
    (x1, y1), (x2, y2) = patch["from"], patch["to"]
    return f"{text} within {x1},{y1}..{x2},{y2}"


def _lines(scene: Scene, content: Mapping[str, Any]) -> Iterator[str]:
    from rsegen.gazebo.map_summary import size_in_words
    from rsegen.params.numbers import lengths_in
    from rsegen.recipe.building import fixed_ends
    from rsegen.recipe.codec import row_text

    recipe, (along_x, along_y) = scene.recipe, scene.field.extent
    blocks = sum(content["level_counts"].values())
    yield f"{scene.name}, seed {recipe.seed}"
    yield f"size     {size_in_words(recipe.grid.shape, scene.field.shape)}, {along_x:g} x {along_y:g} m"
    written = lengths_in(recipe.units)
    in_levels = f"in levels of {written.level(1, recipe.unit_cm)} {written.unit}"
    yield f"blocks   {blocks:,} {in_levels}, fingerprint {content['fingerprint']}"
    for level, count in content["level_counts"].items():
        high = written.level(level, recipe.unit_cm)
        yield f"  level {level:>3}  {high:>7} {written.unit}  {count:>9,}  {count / blocks:6.1%}"
    cost = ", ".join(counted(content[f"{thing}s"], thing) for thing in ("model", "collision", "face"))
    yield f"costs    mesh type {recipe.mesh_type}: {cost}, {content['bytes']:,} bytes"
    for (_, obstacle), place in zip(recipe.enabled_obstacles[:SHOWN], content["placed"], strict=False):
        text = row_text(obstacle)
        yield f"obstacle {text if len(text) <= _LONGEST else f'{text[:_LONGEST]}...'}"
        if fixed_ends(recipe.grid, obstacle) is None:
            yield f"         {_place_in_words(place)}"
    if len(recipe.enabled_obstacles) > SHOWN:
        yield f"         and {len(recipe.enabled_obstacles) - SHOWN} more"
    # After what the map is: what it had to meet, what it needs, and what may be wrong with it.
    for name, value in content["constraints"].items():
        yield f"demand   {name} {parameters(type(recipe))[name].format(value)}"
    for kind, source in content.get("plugins", {}).items():
        yield f"plug-in  {kind} of {source}"
    yield from (f"off      {obstacle}" for obstacle in content.get("switched_off", ()))
    yield from (f"warning: {text}" for text in content["warnings"])
