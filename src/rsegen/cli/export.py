"""rsegen export: maps in the formats of other programs."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from typing import Any

from rsegen.cli.bar import counting
from rsegen.cli.flags import Subparsers, add_force_flag, add_target_recipe_flags, folder
from rsegen.cli.formats import add_format_flags, formats_of, listed
from rsegen.cli.generate import add_workers_flag, going_on, workers_from
from rsegen.cli.targets import add_target_flags, map_of_flags, recipes_of
from rsegen.recipe.recipe import Recipe
from rsegen.run.exports import ExportedMap, export_maps

_SHOWN = 10


def add(commands: Subparsers) -> None:
    """The parser of this command."""
    command = commands.add_parser(
        "export",
        description="Write maps in the formats of other programs: DIR/NAME_0000, ..., each with a folder for every "
        "format and the recipe that makes the map again.",
        epilog="rsegen export --list explains each format; rsegen generate --formats adds the same files to worlds.",
    )
    add_target_flags(command, usual="all")
    command.add_argument("--list", action=_List, nargs=0, help="explain each format and its options")
    group = command.add_argument_group("output")
    text = "comma-separated formats with their options, as in stl,'mjcf shape=hfield'; may be repeated (required)"
    add_format_flags(command, group, "--to", text)
    group.add_argument(
        "-o", "--output", type=folder, required=True, metavar="DIR", help="folder to write the maps into (required)"
    )
    there = group.add_mutually_exclusive_group()
    add_force_flag(there, "existing formats")
    there.add_argument(
        "--resume",
        action="store_true",
        help="continue a stopped run: keep formats that are complete and have the same options",
    )
    group.add_argument("--json", action="store_true", help="print a summary as JSON")
    add_workers_flag(group)
    add_target_recipe_flags(command)
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Export, and say what was written."""
    formats = formats_of("--to", arguments.to)
    recipes = _recipes(arguments)
    maps = sum(recipe.maps for recipe in recipes)
    with going_on(arguments, *recipes), counting(maps) as progress:
        made = export_maps(
            recipes,
            arguments.output,
            formats,
            force=arguments.force,
            resume=arguments.resume,
            workers=workers_from(arguments),
            scheduler=arguments.scheduler,
            sync=not arguments.no_sync,
            progress=progress,
        )
    if arguments.json:
        print(json.dumps([_summary(one) for one in made], indent=2))
    else:
        print("\n".join(_report(made, maps - len(made))))


class _List(argparse.Action):
    """Like --help: prints and ends, whatever else is given."""

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        print("\n".join(listed()), end="")
        parser.exit()


def _recipes(arguments: argparse.Namespace) -> list[Recipe]:
    """The recipes of all maps of a target, or of the given one."""
    if arguments.map is None:
        return [recipe for _, recipe in recipes_of(arguments)]
    _, recipe, index = map_of_flags(arguments)
    return [recipe.alone(index)]


def _summary(one: ExportedMap) -> dict[str, object]:
    return {
        "name": one.folder.name,
        "folder": str(one.folder),
        "files": [str(one.folder / name) for name in one.names],
    }


def _report(made: tuple[ExportedMap, ...], already: int) -> Iterator[str]:
    """Every file of one map; of many their folders."""
    if already:
        yield f"{already} map{'s'[: already > 1]} complete already"
    if not made:
        return
    if len(made) == 1:
        yield from (str(made[0].folder / name) for name in made[0].names)
        return
    folders = list(dict.fromkeys(one.folder for one in made))
    yield f"{len(made)} maps:"
    yield from (f"  {folder}" for folder in folders[:_SHOWN])
    if len(folders) > _SHOWN:
        yield f"  and {len(folders) - _SHOWN} more in {folders[0].parent}"
