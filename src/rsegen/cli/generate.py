"""The command `rsegen generate`, and what all commands share that write worlds."""

from __future__ import annotations

import argparse
import json
import shlex
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rsegen.cli.edge import how_to_go_on
from rsegen.cli.flags import add_input, add_recipe_flags, recipe_from
from rsegen.cli.parameters import Force, OutputFolder, Resume, Scheduler, Sync, Workers
from rsegen.cli.parser import Parser
from rsegen.cli.report import Report, call, maps_bar
from rsegen.params.command import add_flags, command, declared, given
from rsegen.params.numbers import counted
from rsegen.writing.sidecars import chosen_sidecars, sidecar_kinds, with_sidecars

if TYPE_CHECKING:
    from rsegen.recipe.recipe import Recipe
    from rsegen.writing.worlds import Generated, GeneratedMap


@command
@with_sidecars
def generate(  # noqa: PLR0913  # each is a flag
    recipe: Recipe,
    folder: OutputFolder,
    *,
    force: Force = False,
    resume: Resume = False,
    workers: Workers = 1,
    scheduler: Scheduler = None,
    sync: Sync = True,
    progress: Callable[[GeneratedMap], None] | None = None,
    beside: Mapping[str, Callable[[], bytes]] | None = None,
    **sidecars: Any,
) -> Generated:
    """Write the maps of a recipe as Gazebo worlds and models: folder/NAME_0000, folder/NAME_0001, ...

    With more than one worker a script needs `if __name__ == "__main__":`.

    Parameters
    ----------
    recipe : Recipe
        The maps.
    progress : callable, optional
        Called with each map that is done, in their order.
    beside : mapping of str to callable, optional
        What makes the content of files next to the maps, by their names; called once nothing refuses the run.

    Returns
    -------
    Generated
        The maps on disk.

    Raises
    ------
    OutputError
        Before anything is written, if a map's folder is taken or has files that rsegen did not write.
    TooLarge
        Before anything is written, if memory or disk space are too small.
    ParameterError
        Before anything is written, if maps are too large for build sheets.
    """
    from rsegen.writing.execute import Execution
    from rsegen.writing.plan import OnExisting, run_in
    from rsegen.writing.store import open_store
    from rsegen.writing.worlds import Generated, plan_worlds

    execution = Execution(workers=workers, scheduler=scheduler, sync=sync)
    plan = plan_worlds(
        recipe,
        Path(folder),
        chosen_sidecars(sidecars),
        OnExisting.of(force=force, resume=resume),
        execution,
        beside=beside or (),
    )
    # Files next to the maps may take long to make, so they are made once nothing refuses the run.
    files = {name: [make()] for name, make in (beside or {}).items()}
    with open_store(plan.folder, sync=sync) as store:
        maps = run_in(store, plan, progress)
        if files:
            store.put(files, force=plan.replaces)
    return Generated(recipe=recipe, folder=plan.folder, maps=maps, already=tuple(plan.existing))


SHOWN = 10
"""Maps that a report names one by one, and different warnings."""


def add_generate(command: Parser) -> None:
    """Add the flags of `rsegen generate`."""
    epilog = "rsegen obstacles lists the kinds of obstacles and their parameters."
    command.explain(generate.__doc__, epilog)
    add_input(command.group("input"))
    add_output_flags(command)
    add_recipe_flags(command)


def add_output_flags(command: Parser, function: Callable[..., object] = generate) -> None:
    """Add where worlds are written, and how; `function` declares the parameters of `generate` among others."""
    add_flags(command.group("output"), function, only=declared(generate))
    for kind in sidecar_kinds():
        if kind.help_text:
            command.add_paragraph(*kind.help_text)


def run_generate(arguments: argparse.Namespace) -> Report:
    """Generate, and say what was made."""
    return produce(recipe_from(arguments), arguments)


def produce(
    recipe: Recipe,
    arguments: argparse.Namespace,
    beside: Mapping[str, Callable[[], bytes]] | None = None,
    found: Mapping[str, object] | None = None,
) -> Report:
    """Write the maps of a recipe, and say what was made.

    beside: as in `generate`; found: more for programs, in JSON
    """
    options = run_options(generate, arguments)
    with going_on(arguments, recipe), maps_bar(recipe) as progress:
        made = call(generate, arguments, recipe, **options, progress=progress, beside=beside)
    return Report(lines=_lines(made), content=lambda: _content(made) | dict(found or {}))


def run_options(function: Callable[..., object], arguments: argparse.Namespace) -> dict[str, Any]:
    """Return what the flags say of a run, by default with as many workers as there are cores; not yet checked."""
    from rsegen.writing.execute import cores

    options = {"workers": cores()} | given(function, arguments)
    notes = [note for sidecar in chosen_sidecars(options) for note in sidecar.notes]
    for note in () if arguments.quiet else notes:
        print(f"rsegen: {note}", file=sys.stderr)
    return options


def going_on(arguments: argparse.Namespace, *recipes: Recipe) -> AbstractContextManager[None]:
    """Add to the message of a run that is stopped how its maps are completed."""
    then = "makes all of them again" if arguments.force else "makes the others"
    return how_to_go_on(*recipes, resume=not arguments.force, then=then)


def _content(made: Generated) -> dict[str, object]:
    """Return the maps that were made, for programs; `already` names the maps that --resume found, if any."""
    return {
        "folder": str(made.folder),
        "seed": made.recipe.seed,
        "maps": [
            {
                "name": generated.name,
                "index": generated.index,
                "folder": str(generated.folder),
                "world": str(generated.world),
                "size": list(generated.cells),
                "size_m": list(generated.extent),
                "levels": list(generated.level_counts),
                "level_counts": generated.level_counts,
                "files": [str(path) for path in generated.files],
                "warnings": list(generated.warnings),
            }
            for generated in made.maps
        ],
    } | ({"already": [made.recipe.map_name(index) for index in made.already]} if made.already else {})


def _lines(made: Generated) -> Iterator[str]:
    if made.already:
        yield f"{counted(len(made.already), 'map')} already exist, seed {made.recipe.seed}"
    if not made.maps:
        return
    from rsegen.gazebo.map_summary import size_in_words

    size = size_in_words(made.recipe.grid.shape, made.maps[0].cells)
    yield f"{counted(len(made.maps), 'map')} of {size}, seed {made.recipe.seed}:"
    for generated in made.maps[:SHOWN]:
        yield f"  {generated.world}"
    if len(made.maps) > SHOWN:
        yield f"  and {len(made.maps) - SHOWN} more in {made.folder}"
    if made.recipe.is_constrained and (scene := made.maps[0].scene):
        from rsegen.gazebo.constraint_report import describe_constraints

        # A robot's ways take seconds to find, so they are read from the file rather than searched for again.
        yield from describe_constraints(scene, json.loads((made.maps[0].folder / "constraints.json").read_bytes()))
    elif made.recipe.is_constrained:
        yield "how each map meets its constraints: constraints.json in its folder"
    yield from warnings_of(made.maps)
    yield from _how_to_open(made.maps[0], made.folder, made.recipe.simulator)


def warnings_of(maps: Iterable[GeneratedMap]) -> Iterator[str]:
    """Yield the different warnings of maps as lines; of very many, which chance may bring, the first ones."""
    different = list(dict.fromkeys(text for generated in maps for text in generated.warnings))
    yield from (f"warning: {text}" for text in different[:SHOWN])
    if len(different) > SHOWN:
        yield f"and {len(different) - SHOWN} more warnings; rsegen info shows those of a map"


def _how_to_open(first: GeneratedMap, folder: Path, simulator: str) -> Iterator[str]:
    """Yield lines to copy. Worlds name meshes relative to them; Gazebo Classic before 11.3 looks in `.` for them."""
    if simulator == "both":
        yield f"Gazebo Sim:     gz sim {shlex.quote(str(first.world))}"
    yield f"Gazebo Classic: cd {shlex.quote(str(first.folder))} && gazebo {shlex.quote(first.world.name)}"
    if (first.folder / "model.sdf").is_file():
        home = shlex.quote(str(folder.resolve()))
        yield f"as a model (model://{first.name}) in other worlds:"
        yield f"  export GZ_SIM_RESOURCE_PATH={home} IGN_GAZEBO_RESOURCE_PATH={home} GAZEBO_MODEL_PATH={home}"
