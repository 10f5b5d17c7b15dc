"""rsegen generate: worlds on disk."""

from __future__ import annotations

import argparse
import json
import shlex
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from rsegen.cli.flags import Subparsers, add_recipe_flags, recipe_from
from rsegen.pipeline import Generated, GeneratedMap, generate

_SHOWN = 10


def add(commands: Subparsers) -> None:
    """The parser of this command."""
    command = commands.add_parser(
        "generate",
        help="write worlds and models",
        description="Write the maps of a recipe as Gazebo worlds and models: DIR/NAME_0000, DIR/NAME_0001, ...",
        epilog="rsegen obstacles lists the kinds of obstacles and their parameters.",
    )
    command.add_argument("recipe", nargs="?", metavar="RECIPE", help="YAML or JSON file, or the folder of a map")
    command.add_argument(
        "-o", "--output", type=_folder, required=True, metavar="DIR", help="folder to write the maps into"
    )
    command.add_argument("--force", action="store_true", help="replace maps that are there already")
    command.add_argument("--preview", action="store_true", help="add a picture, preview.png, to every map")
    command.add_argument("--json", action="store_true", help="print a summary for programs")
    add_recipe_flags(command)
    command.set_defaults(run=run)


def _folder(text: str) -> Path:
    if not text:
        raise argparse.ArgumentTypeError("nothing is given; give a folder, as in -o worlds")
    return Path(text)


def run(arguments: argparse.Namespace) -> None:
    """Generate, and say what was made."""
    recipe = recipe_from(arguments)
    with _bar(recipe.maps) as progress:
        made = generate(recipe, arguments.output, force=arguments.force, preview=arguments.preview, progress=progress)
    if arguments.json:
        print(json.dumps(summary(made), indent=2))
    else:
        print("\n".join(_report(made)))


def summary(made: Generated) -> dict[str, object]:
    """What was made, for programs."""
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
    }


def _report(made: Generated) -> Iterator[str]:
    n_x, n_y = made.maps[0].cells
    yield f"{len(made.maps)} map{'s'[: len(made.maps) > 1]} of {n_x} x {n_y} cells, seed {made.recipe.seed}:"
    for one in made.maps[:_SHOWN]:
        yield f"  {one.world}"
    if len(made.maps) > _SHOWN:
        yield f"  and {len(made.maps) - _SHOWN} more in {made.folder}"
    for text in dict.fromkeys(text for one in made.maps for text in one.warnings):
        yield f"warning: {text}"
    yield from _how_to_open(made.maps[0], made.folder)


def _how_to_open(one: GeneratedMap, folder: Path) -> Iterator[str]:
    """Lines to copy. Worlds name meshes relative to themselves; Gazebo Classic before 11.3 looks in `.` for them."""
    yield f"Gazebo Sim:     gz sim {shlex.quote(str(one.world))}"
    yield f"Gazebo Classic: cd {shlex.quote(str(one.folder))} && gazebo {shlex.quote(one.world.name)}"
    if (one.folder / "model.sdf").is_file():
        home = shlex.quote(str(folder.resolve()))
        yield f"as a model (model://{one.name}) in other worlds:"
        yield f"  export GZ_SIM_RESOURCE_PATH={home} IGN_GAZEBO_RESOURCE_PATH={home} GAZEBO_MODEL_PATH={home}"


@contextmanager
def _bar(maps: int) -> Iterator[Callable[[GeneratedMap], None] | None]:
    """A progress bar on a terminal, where there is something to wait for."""
    if maps == 1 or not (sys.stderr and sys.stderr.isatty()):
        yield None
        return
    from tqdm import tqdm

    with tqdm(total=maps, unit="map") as bar:

        def done(one: GeneratedMap) -> None:
            bar.update()

        yield done
