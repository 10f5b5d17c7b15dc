"""rsegen dataset: very many maps in few files, for learning."""

from __future__ import annotations

import argparse
import json
import shlex
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from rsegen.cli.bar import watched
from rsegen.cli.flags import (
    RECIPE_HELP,
    Subparsers,
    add_force_flag,
    add_parameter_flags,
    add_recipe_flags,
    folder,
    given,
    recipes_from,
)
from rsegen.cli.generate import add_workers_flag, workers_from
from rsegen.cli.stop import how_to_go_on
from rsegen.errors import ParameterError
from rsegen.io.dataset.layout import ShardLayout
from rsegen.io.dataset.reading import Dataset
from rsegen.params.sorts import Integer
from rsegen.recipe.recipe import Recipe
from rsegen.run.dataset import Progress, make_dataset

_REBUILT = Integer(0, 10**9)


def add(commands: Subparsers) -> None:
    """The parser of this command."""
    command = commands.add_parser(
        "dataset",
        description="Write the maps of one or several recipes as a data set: block levels as arrays, metrics as "
        "tables, in shards. DIR#17 then names one of its maps in every command: rsegen generate DIR#17 -o worlds.",
        epilog="docs/datasets.md shows how to read it in Python, and how to train on it.",
    )
    text = f"{RECIPE_HELP}; flags apply to every recipe, so --maps N makes N maps of each"
    command.add_argument_group("input").add_argument("recipes", nargs="*", metavar="RECIPE", help=text)
    group = command.add_argument_group("output")
    what = group.add_mutually_exclusive_group(required=True)
    what.add_argument("-o", "--output", type=folder, metavar="DIR", help="folder for the data set")
    what.add_argument("--verify", type=folder, metavar="DIR", help="check every file of the data set in DIR instead")
    add_parameter_flags(group, ShardLayout)
    there = group.add_mutually_exclusive_group()
    add_force_flag(there, "an existing data set", ", once the new one is complete")
    there.add_argument(
        "--resume",
        action="store_true",
        help="continue a stopped run: keep the shards that are complete, and make the others; needs the same "
        "recipe and seed",
    )
    add_workers_flag(group)
    group.add_argument("--rebuild", metavar="N", help="with --verify: maps to build again and compare (default: 100)")
    group.add_argument("--json", action="store_true", help="print a summary as JSON")
    add_recipe_flags(command)
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Make or check it, and say what is there."""
    if arguments.verify:
        dataset, words = _verified(arguments)
    else:
        dataset = _made(recipes_from(arguments.recipes, arguments), arguments)
        words = f"one of them as a world: rsegen generate {shlex.quote(f'{dataset.folder}#0')} -o worlds"
    print(json.dumps(_summary(dataset), indent=2) if arguments.json else f"{_described(dataset)}\n{words}")


def _verified(arguments: argparse.Namespace) -> tuple[Dataset, str]:
    """The data set, and what it was compared with."""
    if arguments.recipes:
        raise ParameterError("--verify", "needs no recipe: it is in the data set")
    text = arguments.rebuild
    rebuild = 100 if text is None else _REBUILT.check("--rebuild", _REBUILT.parse(text))
    dataset = Dataset(arguments.verify)
    dataset.verify(rebuild)
    built = min(rebuild, len(dataset))
    return dataset, f"all checksums are right, and {built} random maps were built again and are equal"


def _made(recipes: Sequence[Recipe], arguments: argparse.Namespace) -> Dataset:
    said = given(ShardLayout, arguments)
    resume, then = not arguments.force, "goes on" if arguments.force else "makes the others"
    with how_to_go_on(*recipes, resume=resume, then=then), _bar(sum(recipe.maps for recipe in recipes)) as progress:
        return make_dataset(
            recipes,
            arguments.output,
            force=arguments.force,
            resume=arguments.resume,
            workers=workers_from(arguments),
            scheduler=arguments.scheduler,
            sync=not arguments.no_sync,
            progress=progress,
            **said,
        )


@contextmanager
def _bar(maps: int) -> Iterator[Progress | None]:
    """A progress bar on a terminal; maps that are there already are of no weight in the time that is left."""
    if not watched():
        yield None
        return
    from tqdm import tqdm

    with tqdm(total=maps, unit="map", unit_scale=True) as bar:

        def done(maps: int, *, already: bool) -> None:
            bar.initial += maps * already
            bar.update(maps)

        yield done


def _summary(dataset: Dataset) -> dict[str, object]:
    return {
        "folder": str(dataset.folder),
        **_seeds(dataset),
        "maps": len(dataset),
        "shape": list(dataset.levels.shape),
        "dtype": dataset.levels.dtype.name,
        "metrics": dataset.layout.metrics,
        "shards": len(dataset.shards),
        "bytes": dataset.bytes,
    }


def _seeds(dataset: Dataset) -> dict[str, object]:
    if len(dataset.recipes) == 1:
        return {"seed": dataset.recipe.seed}
    names = ("name", "seed", "maps")
    return {"recipes": [{name: getattr(recipe, name) for name in names} for recipe in dataset.recipes]}


def _described(dataset: Dataset) -> str:
    n_x, n_y = dataset.layout.grid_shape
    seeds = [f"{recipe.maps:,} of {recipe.name} (seed {recipe.seed})" for recipe in dataset.recipes]
    said = ", ".join(seeds) if len(seeds) > 1 else f"seed {dataset.recipe.seed}"
    return (
        f"{len(dataset):,} maps of {n_x} x {n_y} blocks, {said}: "
        f"{dataset.bytes:,} bytes in {len(dataset.shards)} shards in {dataset.folder}"
    )
