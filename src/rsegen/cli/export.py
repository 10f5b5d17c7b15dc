"""rsegen export: maps in the formats of other programs."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from typing import Any

from rsegen.cli.bar import counting
from rsegen.cli.flags import Subparsers, folder
from rsegen.cli.formats import add_option_flags, formats_of, listed
from rsegen.cli.generate import add_workers_flag, workers_from
from rsegen.cli.targets import add_target_flags
from rsegen.exporters.formats import FORMATS
from rsegen.io.dataset.map_reference import recipe_in
from rsegen.io.exports import ExportedMap, export_maps
from rsegen.io.targets import found, recipe_files
from rsegen.recipe.recipe import Recipe

_SHOWN = 10


def add(commands: Subparsers) -> None:
    """The parser of this command."""
    command = commands.add_parser(
        "export",
        help="write maps for other programs: meshes, arrays, images, occupancy maps",
        description="Write maps in the formats of other programs: DIR/NAME_0000, ..., each with a folder for every "
        "format and the recipe that makes the map again.",
        epilog="rsegen export --list explains each format; rsegen generate --formats adds the same files to worlds.",
    )
    command.add_argument("--list", action=_List, nargs=0, help="say what each format is, and its options")
    add_target_flags(command, usual="all")
    known = ", ".join(FORMATS)
    command.add_argument("--to", required=True, metavar="FORMAT,...", help=f"comma-separated formats: {known}")
    command.add_argument(
        "-o", "--output", type=folder, required=True, metavar="DIR", help="folder to write the maps into"
    )
    command.add_argument("--force", action="store_true", help="replace what was exported there before")
    command.add_argument("--json", action="store_true", help="print a summary for programs")
    add_workers_flag(command)
    add_option_flags(command)
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Export, and say what was written."""
    formats = formats_of("--to", arguments.to, arguments)
    recipes = _recipes(arguments.target, arguments.map)
    with counting(sum(recipe.maps for recipe in recipes)) as progress:
        made = export_maps(
            recipes,
            arguments.output,
            formats,
            force=arguments.force,
            workers=workers_from(arguments),
            progress=progress,
        )
    if arguments.json:
        print(json.dumps([_summary(one) for one in made], indent=2))
    else:
        print("\n".join(_report(made)))


class _List(argparse.Action):
    """Like --help: prints and ends, whatever else is given."""

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        print("\n".join(listed()), end="")
        parser.exit()


def _recipes(target: str, which: str | None) -> list[Recipe]:
    """The recipes of all maps of a target, or of the given one."""
    if which is None:
        return [recipe_in(file) for file in recipe_files(target)]
    _, recipe, index = found(target, which)
    return [recipe.alone(index)]


def _summary(one: ExportedMap) -> dict[str, object]:
    return {
        "name": one.folder.name,
        "folder": str(one.folder),
        "files": [str(one.folder / name) for name in one.names],
    }


def _report(made: tuple[ExportedMap, ...]) -> Iterator[str]:
    """Every file of one map; of many their folders."""
    if len(made) == 1:
        yield from (str(made[0].folder / name) for name in made[0].names)
        return
    yield f"{len(made)} maps:"
    yield from (f"  {one.folder}" for one in made[:_SHOWN])
    if len(made) > _SHOWN:
        yield f"  and {len(made) - _SHOWN} more in {made[0].folder.parent}"
