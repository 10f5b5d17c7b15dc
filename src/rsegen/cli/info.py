"""rsegen info: how large a map is, what stands in it, what it costs."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from typing import TYPE_CHECKING

from rsegen.cli.flags import add_target_recipe_flags
from rsegen.cli.generate import SHOWN
from rsegen.cli.report import Report, Subparsers, add_command
from rsegen.cli.targets import add_target_flags, is_of_flags, scene_of, which_map
from rsegen.errors import ParameterError
from rsegen.params.sorts import Json, parameters

if TYPE_CHECKING:
    from rsegen.exporters.map_summary import MapSummary
    from rsegen.recipe.recipe import Recipe

_CONSTRAINTS = ("max_step", "crossable_by", "inventory")

_LONGEST = 100
"""Letters of an obstacle: a matrix may have thousands."""


def add(commands: Subparsers) -> None:
    """Add the parser of this command."""
    text = "Print the size of a map, its obstacles, the blocks of each level, and its cost in faces and bytes."
    command = add_command(commands, "info", text=text)
    add_target_flags(command)
    text = "compare every file in DIR, and in the maps in it, with the sizes and checksums that rsegen recorded"
    command.add_argument_group("output").add_argument("--verify", action="store_true", help=text)
    add_target_recipe_flags(command)


def run(arguments: argparse.Namespace) -> Report:
    """Summarise the map, or verify a folder."""
    if arguments.verify:
        return _verified(arguments)
    from rsegen.exporters.map_summary import map_summary

    scene = scene_of(arguments)
    summary = map_summary(scene)
    notes = which_map(arguments.target, arguments.map)
    return Report(lines=_lines(summary, scene.recipe), content=_content(summary, scene.recipe), notes=notes)


def _verified(arguments: argparse.Namespace) -> Report:
    """Compare a folder with its records, and say what was compared."""
    from rsegen.run.journal import verify

    if arguments.target is None or arguments.map is not None or is_of_flags(arguments):
        raise ParameterError("--verify", "needs a folder that rsegen wrote, and no recipe")
    verified = verify(arguments.target)
    unlisted = [str(path) for path in verified.unlisted]
    lines = [f"{_many(verified.files, 'file')} in {_many(verified.folders, 'folder')} as rsegen wrote them"]
    lines += [f"not written by rsegen: {path}" for path in unlisted]
    return Report(lines=lines, content={"folders": verified.folders, "files": verified.files, "unlisted": unlisted})


def _content(summary: MapSummary, recipe: Recipe) -> dict[str, object]:
    return {
        "name": summary.name,
        "seed": summary.seed,
        "size": list(summary.cells),
        "size_m": list(summary.extent),
        "unit_cm": summary.unit_cm,
        "levels": list(summary.level_counts),
        "level_counts": summary.level_counts,
        "fingerprint": summary.fingerprint,
        "obstacles": [obstacle.entry() for _, obstacle in recipe.enabled_obstacles],
        "constraints": _constraints(recipe),
        "mesh_type": summary.mesh_type,
        "models": summary.models,
        "collisions": summary.collisions,
        "faces": summary.faces,
        "bytes": summary.bytes,
        "warnings": list(summary.warnings),
        **({"plugins": summary.plugins} if summary.plugins else {}),
        **({"switched_off": list(summary.switched_off)} if summary.switched_off else {}),
    }


def _constraints(recipe: Recipe) -> dict[str, Json]:
    """Return the constraints of a recipe, as its file has them."""
    return {name: value for name, value in recipe.entry().items() if name in _CONSTRAINTS}


def _lines(summary: MapSummary, recipe: Recipe) -> Iterator[str]:
    from rsegen.exporters.map_summary import size_in_words
    from rsegen.exporters.numbers import lengths_in
    from rsegen.recipe.codec import row_text

    along_x, along_y = summary.extent
    blocks = sum(summary.level_counts.values())
    yield f"{summary.name}, seed {summary.seed}"
    yield f"size     {size_in_words(summary.grid, summary.cells)}, {along_x:g} x {along_y:g} m"
    written = lengths_in(summary.units)
    in_levels = f"in levels of {written.level(1, summary.unit_cm)} {written.unit}"
    yield f"blocks   {blocks:,} {in_levels}, fingerprint {summary.fingerprint}"
    for level, count in summary.level_counts.items():
        high = written.level(level, summary.unit_cm)
        yield f"  level {level:>3}  {high:>7} {written.unit}  {count:>9,}  {count / blocks:6.1%}"
    costs = (_many(summary.models, "model"), _many(summary.collisions, "collision"), _many(summary.faces, "face"))
    cost = f"{', '.join(costs)}, {summary.bytes:,} bytes"
    yield f"costs    mesh type {summary.mesh_type}: {cost}"
    for _, placed in recipe.enabled_obstacles[:SHOWN]:
        text = row_text(placed)
        yield f"obstacle {text if len(text) <= _LONGEST else f'{text[:_LONGEST]}...'}"
    if len(recipe.enabled_obstacles) > SHOWN:
        yield f"         and {len(recipe.enabled_obstacles) - SHOWN} more"
    for name, value in _constraints(recipe).items():
        yield f"demand   {name} {parameters(type(recipe))[name].format(value)}"
    for kind, source in summary.plugins.items():
        yield f"plug-in  {kind} of {source}"
    for obstacle in summary.switched_off:
        yield f"off      {obstacle}"
    for text in summary.warnings:
        yield f"warning: {text}"


def _many(count: int, what: str) -> str:
    return f"{count:,} {what}{'' if count == 1 else 's'}"
