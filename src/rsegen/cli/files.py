"""The commands that write files for other programs: export, sheet and dataset."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from rsegen.cli.commands import Parser
from rsegen.cli.edge import how_to_go_on
from rsegen.cli.flags import (
    RECIPE_HELP,
    add_format_rows,
    add_input,
    add_recipe_flags,
    add_target_flags,
    add_target_recipe_flags,
    listed,
    map_of_flags,
    maps_of_flags,
    recipes_from,
    which_map,
)
from rsegen.cli.report import Report, call, counted, counting, shards_bar
from rsegen.cli.worlds import SHOWN, going_on, run_options
from rsegen.commands.maps import export_maps, make_dataset
from rsegen.commands.parameters import Force
from rsegen.errors import ParameterError
from rsegen.exporters.cut_settings import CutSettings
from rsegen.params.command import Shell, add_flags, given
from rsegen.params.sorts import FilePath, Integer

if TYPE_CHECKING:
    from rsegen.io.dataset.reading import Dataset
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
    recipes = [*maps_of_flags(arguments)]
    maps = sum(recipe.maps for recipe in recipes)
    with going_on(arguments, *recipes), counting(maps) as progress:
        made = call(export_maps, arguments, recipes, **options, progress=progress)
    return Report(lines=_export_lines(made, maps - len(made)), content=lambda: [_exported(each) for each in made])


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


@dataclass(frozen=True, kw_only=True, slots=True)
class _Files:
    """Write the build sheet of a map: its pallets, what timber to buy and how to cut it, and a page for each pallet."""

    output: Annotated[
        str,
        FilePath("a file", help="build sheet: pdf or csv, by its ending"),
        Shell(("-o", "--output"), "FILE", required=True),
    ]
    csv: Annotated[
        str | None,
        FilePath("a name that ends in .csv", help="also write it as CSV, one row per cell"),
        Shell(metavar="FILE"),
    ] = None
    force: Force = False


def add_sheet(command: Parser) -> None:
    """Add the flags of `rsegen sheet`."""
    epilog = (
        "A pallet's page has the height of every block and the order of placing. rsegen import reads the CSV again."
    )
    command.explain(_Files.__doc__, epilog)
    add_target_flags(command)
    add_flags(command.add_argument_group("output"), _Files)
    add_flags(command.add_argument_group("cutting"), CutSettings)
    add_target_recipe_flags(command)


def run_sheet(arguments: argparse.Namespace) -> Report:
    """Make the sheets, and write them."""
    from rsegen.exporters.sheet import sheet_format
    from rsegen.run.single_files import write_sheets

    paths = [Path(arguments.output)]
    if arguments.csv is not None:
        paths.append(Path(arguments.csv))
        if [sheet_format(path) == "csv" for path in paths] != [False, True]:
            given_names = f"{paths[1]} beside {paths[0]}"
            raise ParameterError("--csv", f"{given_names}; give one name of .csv, and -o one of .pdf")
    settings = given(CutSettings, arguments, arguments.units)
    _, recipe, index = map_of_flags(arguments)
    saw = replace(CutSettings.default(recipe.units), **settings)
    scene = write_sheets(recipe, index, paths, saw, force=bool(arguments.force))
    content = {"files": [str(path) for path in paths], "map": scene.name, "seed": scene.recipe.seed}
    lines = [f"{path}: {scene.name}, seed {scene.recipe.seed}" for path in paths]
    return Report(lines=lines, content=content, notes=which_map(arguments.target, arguments.map))


_REBUILT = Integer(0, 10**9)


def add_dataset(command: Parser) -> None:
    """Add the flags of `rsegen dataset`."""
    epilog = "DIR#17 then names one of its maps in every command: rsegen generate DIR#17 -o worlds. docs/datasets.md "
    command.explain(make_dataset.__doc__, f"{epilog}shows how to read it in Python, and how to train on it.")
    text = f"{RECIPE_HELP}; flags apply to every recipe, so --maps N makes N maps of each"
    add_input(command.add_argument_group("input"), text, name="recipes", nargs="*")
    group = command.add_argument_group("output")
    what = group.add_mutually_exclusive_group(required=True)
    what.add_argument("-o", "--output", dest="folder", metavar="DIR", help="folder for the data set")
    what.add_argument("--verify", metavar="DIR", help="check every file of the data set in DIR instead")
    add_flags(group, make_dataset, without=["folder"])
    group.add_argument("--rebuild", metavar="N", help="with --verify: maps to build again and compare (default: 100)")
    add_recipe_flags(command)


def run_dataset(arguments: argparse.Namespace) -> Report:
    """Make or check it, and say what is there."""
    if arguments.verify is not None:
        dataset, words = _verified(arguments)
    else:
        dataset = _made(arguments)
        words = f"one of them as a world: rsegen generate {shlex.quote(f'{dataset.folder}#0')} -o worlds"
    return Report(lines=[_described(dataset), words], content=lambda: _content(dataset))


def _verified(arguments: argparse.Namespace) -> tuple[Dataset, str]:
    """Return the data set that was checked, and what it was compared with."""
    from rsegen.io.dataset.reading import Dataset

    if arguments.recipes:
        raise ParameterError("--verify", "needs no recipe: it is in the data set")
    text = arguments.rebuild
    rebuild = 100 if text is None else _REBUILT.check("--rebuild", _REBUILT.parse(text))
    dataset = Dataset(Path(arguments.verify))
    dataset.verify(rebuild)
    built = min(rebuild, len(dataset))
    return dataset, f"all checksums are right, and {built} random maps were built again and are equal"


def _made(arguments: argparse.Namespace) -> Dataset:
    recipes, options = recipes_from(arguments.recipes, arguments), run_options(make_dataset, arguments)
    resume, then = not arguments.force, "goes on" if arguments.force else "makes the others"
    maps = sum(recipe.maps for recipe in recipes)
    with how_to_go_on(*recipes, resume=resume, then=then), shards_bar(maps) as progress:
        return call(make_dataset, arguments, recipes, **options, progress=progress)


def _content(dataset: Dataset) -> dict[str, object]:
    names = ("name", "seed", "maps")
    recipes = [{name: getattr(recipe, name) for name in names} for recipe in dataset.recipes]
    return {
        "folder": str(dataset.folder),
        **({"recipes": recipes} if recipes[1:] else {"seed": dataset.recipe.seed}),
        "maps": len(dataset),
        "shape": list(dataset.levels.shape),
        "dtype": dataset.levels.dtype.name,
        "metrics": dataset.layout.metrics,
        "shards": len(dataset.shards),
        "bytes": dataset.bytes,
    }


def _described(dataset: Dataset) -> str:
    n_x, n_y = dataset.layout.grid_shape
    seeds = [f"{recipe.maps:,} of {recipe.name} (seed {recipe.seed})" for recipe in dataset.recipes]
    said = ", ".join(seeds) if len(seeds) > 1 else f"seed {dataset.recipe.seed}"
    shards = counted(len(dataset.shards), "shard")
    return (
        f"{counted(len(dataset), 'map')} of {n_x} x {n_y} blocks, {said}: "
        f"{dataset.bytes:,} bytes in {shards} in {dataset.folder}"
    )
