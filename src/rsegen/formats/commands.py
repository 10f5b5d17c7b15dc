"""The command `rsegen export`, and `rsegen.export` for one map."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from rsegen.cli.flags import (
    add_target_flags,
    add_target_recipe_flags,
    maps_of_flags,
)
from rsegen.cli.generate import SHOWN, going_on, run_options
from rsegen.cli.parameters import Force, OutputFolder, Resume, Scheduler, Sync, Workers
from rsegen.cli.parser import Parser
from rsegen.cli.report import Report, call, counting
from rsegen.formats.parameters import FormatList, listed, names_in_help
from rsegen.params.command import Shell, add_flags, command
from rsegen.params.numbers import counted
from rsegen.params.sorts import FilePath, Integer, Reference
from rsegen.params.streams import SEEDS

if TYPE_CHECKING:
    from rsegen.formats.base import Format
    from rsegen.formats.exports import Exported, ExportedMap
    from rsegen.recipe.recipe import Recipe
    from rsegen.scene.scene import Scene


@command
def export_maps(  # noqa: PLR0913  # each is a flag
    recipes: Recipe | Sequence[Recipe],
    folder: OutputFolder,
    formats: Annotated[
        Sequence[Format],
        FormatList("--to", help="formats; may be repeated"),
        Shell(("--to",), "'FORMAT KEY=VALUE ...'", required=True),
    ],
    *,
    force: Force = False,
    resume: Resume = False,
    workers: Workers = 1,
    scheduler: Scheduler = None,
    sync: Sync = True,
    progress: Callable[[ExportedMap], None] | None = None,
) -> tuple[ExportedMap, ...]:
    """Write maps in the formats of other programs: folder/NAME_0000, ..., with a folder for each format and the recipe.

    If a map exists, as a world or exported before, the formats are added and all else stays; `resume` keeps
    formats that are complete and have the same options. A format that joins the maps, such as `ros2` with a `package`,
    is alone, and writes them into one folder of that name: all of them or none.

    Parameters
    ----------
    recipes : Recipe or sequence of Recipe
        The maps.
    progress : callable, optional
        Called with each map that is written.

    Returns
    -------
    tuple of ExportedMap
        The maps that were written.

    Raises
    ------
    OutputError
        Before anything is written, if a folder of that name holds something else, a format exists already, or two maps
        have one name.
    TooLarge
        Before anything is written, if memory or disk space are too small.
    """
    from rsegen.formats.exports import export_joined, joining, plan_exports
    from rsegen.recipe.recipe import as_recipes
    from rsegen.writing.execute import Execution
    from rsegen.writing.plan import OnExisting, run

    recipes, on_existing = as_recipes(recipes), OnExisting.of(force=force, resume=resume)
    if together := joining(formats):
        return export_joined(recipes, Path(folder), together, on_existing, progress, sync=sync)
    execution = Execution(workers=workers, scheduler=scheduler, sync=sync)
    return run(plan_exports(recipes, Path(folder), formats, on_existing, execution), progress)


@command
def export(
    map: Recipe | Scene,  # noqa: A002  # the field's word
    path: Annotated[str | Path, FilePath("a file or folder", help="file if it has a suffix, else a folder")],
    format: Annotated[  # noqa: A002  # the command line's word
        str | None, Reference("a name in rsegen.FORMATS", help="format; default: named by the suffix of the path")
    ] = None,
    *,
    index: Annotated[int, Integer(0, SEEDS - 1, help="which map of the recipe")] = 0,
    force: Force = False,
    **options: Any,
) -> Exported:
    """Write one map in another format: `rsegen.export(recipe, "map.glb")`.

    Parameters
    ----------
    map : Recipe or Scene
        A scene, or a recipe, of which map `index` is written; in a folder the files are as in one of `export_maps`.
    **options : Any
        Options of the format, as in `rsegen.export(recipe, "folder", "mjcf", shape="hfield")`.

    Returns
    -------
    Exported
        What was written.

    Raises
    ------
    UserError
        Before anything is written, if a value is wrong or the path is taken.
    """
    from rsegen.formats.exports import export_one

    return export_one(map, Path(path), format, index=index, force=force, options=options)


def add_export(command: Parser) -> None:
    """Add the flags of `rsegen export`."""
    epilog = "rsegen export --list explains each format; rsegen generate --formats adds the same files to worlds."
    command.explain(export_maps.__doc__, epilog)
    add_target_flags(command, "all")
    command.add_argument("--list", action=_List, nargs=0, help="explain each format and its options")
    add_flags(command.group("output"), export_maps)
    command.add_paragraph("formats for --to", names_in_help)
    add_target_recipe_flags(command)


def run_export(arguments: argparse.Namespace) -> Report:
    """Export, and say what was written."""
    options = run_options(export_maps, arguments)
    recipes = [*maps_of_flags(arguments)]
    maps = sum(recipe.maps for recipe in recipes)
    with going_on(arguments, *recipes), counting(maps) as progress:
        made = call(export_maps, arguments, recipes, **options, progress=progress)
    return Report(
        lines=_export_lines(made, maps - len(made)), content=lambda: [_exported(exported) for exported in made]
    )


class _List(argparse.Action):
    """Prints and ends, like --help, whatever else is given."""

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        print("\n".join(listed()), end="")
        parser.exit()


def _exported(made: ExportedMap) -> dict[str, object]:
    files = [str(made.folder / name) for name in made.names]
    return {"name": made.folder.name, "folder": str(made.folder), "files": files}


def _export_lines(made: tuple[ExportedMap, ...], already: int) -> Iterator[str]:
    """Yield every file of one map; of many their folders."""
    if already:
        yield f"{counted(already, 'map')} complete already"
    if not made:
        return
    if len(made) == 1:
        yield from (str(made[0].folder / name) for name in made[0].names)
        return
    folders = list(dict.fromkeys(exported.folder for exported in made))
    yield f"{len(made)} maps:"
    yield from (f"  {folder}" for folder in folders[:SHOWN])
    if len(folders) > SHOWN:
        yield f"  and {len(folders) - SHOWN} more in {folders[0].parent}"
