"""rsegen dataset: very many maps in few files, for learning."""

from __future__ import annotations

import argparse
import shlex
from pathlib import Path
from typing import TYPE_CHECKING

from rsegen.cli.edge import how_to_go_on
from rsegen.cli.flags import RECIPE_HELP, add_input, add_recipe_flags, recipes_from
from rsegen.cli.generate import run_options
from rsegen.cli.parser import Parser
from rsegen.cli.report import Report, call, shards_bar
from rsegen.commands.maps import make_dataset
from rsegen.errors import ParameterError
from rsegen.params.command import add_flags
from rsegen.params.sorts import Integer

if TYPE_CHECKING:
    from rsegen.io.dataset.reading import Dataset

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
    """The data set, and what it was compared with."""
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
    maps, shards = len(dataset), len(dataset.shards)
    return (
        f"{maps:,} map{'' if maps == 1 else 's'} of {n_x} x {n_y} blocks, {said}: "
        f"{dataset.bytes:,} bytes in {shards} shard{'' if shards == 1 else 's'} in {dataset.folder}"
    )
