"""rsegen export: maps in the formats of other programs."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from rsegen.cli.flags import add_format_rows, add_target_recipe_flags, listed
from rsegen.cli.generate import SHOWN, going_on, run_options
from rsegen.cli.parser import Parser
from rsegen.cli.report import Report, call, counting
from rsegen.cli.targets import add_target_flags, maps_of_flags
from rsegen.commands.maps import export_maps
from rsegen.params.command import add_flags

if TYPE_CHECKING:
    from rsegen.run.exports import ExportedMap


def add_export(command: Parser) -> None:
    """Add the flags of `rsegen export`."""
    epilog = "rsegen export --list explains each format; rsegen generate --formats adds the same files to worlds."
    command.explain(export_maps.__doc__, epilog)
    add_target_flags(command, "all")
    command.add_argument("--list", action=_List, nargs=0, help="explain each format and its options")
    add_flags(command.add_argument_group("output"), export_maps)
    add_format_rows(command, "--to")
    add_target_recipe_flags(command)


def run_export(arguments: argparse.Namespace) -> Report:
    """Export, and say what was written."""
    options = run_options(export_maps, arguments)
    recipes = maps_of_flags(arguments)
    maps = sum(recipe.maps for recipe in recipes)
    with going_on(arguments, *recipes), counting(maps) as progress:
        made = call(export_maps, arguments, recipes, **options, progress=progress)
    return Report(lines=_lines(made, maps - len(made)), content=lambda: [_content(each) for each in made])


class _List(argparse.Action):
    """Prints and ends, like --help, whatever else is given."""

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        print("\n".join(listed()), end="")
        parser.exit()


def _content(made: ExportedMap) -> dict[str, object]:
    files = [str(made.folder / name) for name in made.names]
    return {"name": made.folder.name, "folder": str(made.folder), "files": files}


def _lines(made: tuple[ExportedMap, ...], already: int) -> Iterator[str]:
    """Every file of one map; of many their folders."""
    if already:
        yield f"{already} map{'s'[: already > 1]} complete already"
    if not made:
        return
    if len(made) == 1:
        yield from (str(made[0].folder / name) for name in made[0].names)
        return
    folders = list(dict.fromkeys(each.folder for each in made))
    yield f"{len(made)} maps:"
    yield from (f"  {folder}" for folder in folders[:SHOWN])
    if len(folders) > SHOWN:
        yield f"  and {len(folders) - SHOWN} more in {folders[0].parent}"
