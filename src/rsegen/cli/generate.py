"""rsegen generate: worlds on disk."""

from __future__ import annotations

import argparse
import json
import shlex
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path

from rsegen.cli.bar import watched
from rsegen.cli.flags import RECIPE_HELP, Subparsers, add_force_flag, add_recipe_flags, folder, recipe_from
from rsegen.cli.formats import add_format_flags, formats_of
from rsegen.cli.parser import Parser
from rsegen.cli.stop import how_to_go_on
from rsegen.recipe.recipe import Recipe
from rsegen.run.execute import WORKERS, Execution, cores
from rsegen.run.plan import OnExisting
from rsegen.run.worlds import Generated, GeneratedMap, Sidecars, make_worlds, plan_worlds

_SHOWN = 10


def add(commands: Subparsers) -> None:
    """The parser of this command."""
    command = commands.add_parser(
        "generate",
        description="Write the maps of a recipe as Gazebo worlds and models: DIR/NAME_0000, DIR/NAME_0001, ...",
        epilog="rsegen obstacles lists the kinds of obstacles and their parameters.",
    )
    command.add_argument_group("input").add_argument("recipe", nargs="?", metavar="RECIPE", help=RECIPE_HELP)
    add_output_flags(command)
    add_recipe_flags(command)
    command.set_defaults(run=run)


def add_output_flags(command: Parser) -> None:
    """Where to write, and how."""
    group = command.add_argument_group("output")
    group.add_argument(
        "-o", "--output", type=folder, required=True, metavar="DIR", help="folder to write the maps into (required)"
    )
    there = group.add_mutually_exclusive_group()
    add_force_flag(there, "existing maps")
    there.add_argument(
        "--resume",
        action="store_true",
        help="continue a stopped run: keep complete maps (with --preview, --sheet or --formats: if they have these "
        "files), and make the others; needs the same recipe and seed",
    )
    group.add_argument("--preview", action="store_true", help="add a picture, preview.png, to every map")
    group.add_argument(
        "--sheet",
        action="store_true",
        help="add a build sheet, sheet.pdf and sheet.csv, to every map (see rsegen sheet)",
    )
    add_format_flags(command, group, "--formats", "add files for other programs to every map: stl,'mjcf shape=hfield'")
    group.add_argument("--json", action="store_true", help="print a summary as JSON")
    add_workers_flag(group)


def add_workers_flag(group: argparse._ArgumentGroup) -> None:
    """How many processes work at the same time, and whether they wait for the disk."""
    group.add_argument(
        "--no-sync",
        action="store_true",
        help="do not wait until files are on disk: a little faster for many small maps; after a power failure some "
        "may be empty, and --resume makes them again",
    )
    text = f"{WORKERS.help} ({WORKERS.describe()}; default: the number of cores)"
    group.add_argument("--workers", metavar="N", help=text)
    group.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="make it on a Dask cluster whose workers see the same folder: tcp://HOST:PORT, or local for a cluster of "
        "--workers processes on this machine; needs rsegen[cluster]",
    )


def run(arguments: argparse.Namespace) -> None:
    """Generate, and say what was made."""
    produce(recipe_from(arguments), arguments)


def produce(
    recipe: Recipe, arguments: argparse.Namespace, beside: Mapping[str, Callable[[], bytes]] | None = None
) -> None:
    """Write the maps of a recipe, and say what was made.

    beside: what makes the content of files next to the maps, by their names; called once nothing refuses the run
    """
    beside = beside or {}
    formats = formats_of("--formats", arguments.formats)
    sidecars = Sidecars(preview=arguments.preview, sheet=arguments.sheet, formats=formats)
    on_existing = OnExisting.of(force=arguments.force, resume=arguments.resume)
    plan = plan_worlds(recipe, arguments.output, sidecars, on_existing, execution_from(arguments), beside=beside)
    files = {name: make() for name, make in beside.items()}
    with going_on(arguments, recipe), _bar(recipe) as progress:
        made = make_worlds(recipe, plan, progress, files)
    if arguments.json:
        print(json.dumps(_as_json(made), indent=2))
    else:
        print("\n".join(_report(made)))


def going_on(arguments: argparse.Namespace, *recipes: Recipe) -> AbstractContextManager[None]:
    """Add to the message of a run that is stopped how its maps are completed."""
    then = "makes all of them again" if arguments.force else "makes the others"
    return how_to_go_on(*recipes, resume=not arguments.force, then=then)


def execution_from(arguments: argparse.Namespace) -> Execution:
    """Return where the flags ask for the run to be made."""
    return Execution(workers=workers_from(arguments), scheduler=arguments.scheduler, sync=not arguments.no_sync)


def workers_from(arguments: argparse.Namespace) -> int:
    """How many were asked for, or the number of cores."""
    given = arguments.workers
    return cores() if given is None else WORKERS.check("--workers", WORKERS.parse(given))


def _as_json(made: Generated) -> dict[str, object]:
    """What was made, for programs; `already` names the maps that --resume found, where there are any."""
    return {
        "folder": str(made.folder),
        "seed": made.recipe.seed,
        "maps": [
            {
                "name": one.name,
                "index": one.index,
                "folder": str(one.folder),
                "world": str(one.world),
                "size": list(one.cells),
                "size_m": list(one.extent),
                "levels": list(one.level_counts),
                "level_counts": one.level_counts,
                "files": [str(path) for path in one.files],
                "warnings": list(one.warnings),
            }
            for one in made.maps
        ],
    } | ({"already": [made.recipe.map_name(index) for index in made.already]} if made.already else {})


def _report(made: Generated) -> Iterator[str]:
    if made.already:
        yield f"{_count(len(made.already))} there already, seed {made.recipe.seed}"
    if not made.maps:
        return
    n_x, n_y = made.maps[0].cells
    yield f"{_count(len(made.maps))} of {n_x} x {n_y} cells, seed {made.recipe.seed}:"
    for one in made.maps[:_SHOWN]:
        yield f"  {one.world}"
    if len(made.maps) > _SHOWN:
        yield f"  and {len(made.maps) - _SHOWN} more in {made.folder}"
    if made.recipe.is_constrained and len(made.maps) == 1:
        from rsegen.exporters.constraint_report import describe_constraints
        from rsegen.exporters.scene import compose

        yield from describe_constraints(compose(made.recipe, made.maps[0].index))
    for text in dict.fromkeys(text for one in made.maps for text in one.warnings):
        yield f"warning: {text}"
    yield from _how_to_open(made.maps[0], made.folder, made.recipe.simulator)


def _count(maps: int) -> str:
    return f"{maps} map{'s'[: maps > 1]}"


def _how_to_open(one: GeneratedMap, folder: Path, simulator: str) -> Iterator[str]:
    """Lines to copy. Worlds name meshes relative to themselves; Gazebo Classic before 11.3 looks in `.` for them."""
    if simulator == "both":
        yield f"Gazebo Sim:     gz sim {shlex.quote(str(one.world))}"
    yield f"Gazebo Classic: cd {shlex.quote(str(one.folder))} && gazebo {shlex.quote(one.world.name)}"
    if (one.folder / "model.sdf").is_file():
        home = shlex.quote(str(folder.resolve()))
        yield f"as a model (model://{one.name}) in other worlds:"
        yield f"  export GZ_SIM_RESOURCE_PATH={home} IGN_GAZEBO_RESOURCE_PATH={home} GAZEBO_MODEL_PATH={home}"


@contextmanager
def _bar(recipe: Recipe) -> Iterator[Callable[[GeneratedMap], None] | None]:
    """A progress bar on a terminal, where there is something to wait for; maps that are there already count as done."""
    if recipe.maps == 1 or not watched():
        yield None
        return
    from tqdm import tqdm

    with tqdm(total=recipe.maps, unit="map", miniters=1) as bar:

        def done(one: GeneratedMap) -> None:
            place = one.index - recipe.first_map + 1
            if not bar.n:
                bar.initial = bar.n = place - 1  # of no weight in the time that is left
            bar.update(place - bar.n)

        yield done
        bar.update(recipe.maps - bar.n)
