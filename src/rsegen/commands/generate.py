"""`rsegen generate`: the maps of a recipe as Gazebo worlds and models."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from rsegen.commands.parameters import Force, Formats, OutputFolder, Preview, Resume, Scheduler, Sheet, Sync, Workers
from rsegen.params.command import command

if TYPE_CHECKING:
    from rsegen.recipe.recipe import Recipe
    from rsegen.run.worlds import Generated, GeneratedMap


@command
def generate(  # noqa: PLR0913  # each is a flag
    recipe: Recipe,
    folder: OutputFolder,
    *,
    force: Force = False,
    resume: Resume = False,
    preview: Preview = False,
    sheet: Sheet = False,
    formats: Formats = (),
    workers: Workers = 1,
    scheduler: Scheduler = None,
    sync: Sync = True,
    progress: Callable[[GeneratedMap], None] | None = None,
    beside: Mapping[str, Callable[[], bytes]] | None = None,
) -> Generated:
    """Write the maps of a recipe as Gazebo worlds and models: folder/NAME_0000, folder/NAME_0001, ...

    progress: called with each map that is done, in their order. beside: what makes the content of files next to the
    maps, by their names; called once nothing refuses the run. With more than one worker a script needs
    `if __name__ == "__main__":`. Raises, before anything is written, an OutputError if a map's folder is taken or has
    files that rsegen did not write, TooLarge if memory or disk space are too small, and a ParameterError if maps are
    too large for build sheets.
    """
    from rsegen.run.execute import Execution
    from rsegen.run.plan import OnExisting
    from rsegen.run.worlds import Sidecars, make_worlds, plan_worlds

    sidecars = Sidecars(preview=preview, sheet=sheet, formats=formats)
    execution = Execution(workers=workers, scheduler=scheduler, sync=sync)
    plan = plan_worlds(
        recipe, Path(folder), sidecars, OnExisting.of(force=force, resume=resume), execution, beside=beside or ()
    )
    files = {name: make() for name, make in (beside or {}).items()}
    return make_worlds(recipe, plan, progress, files)
