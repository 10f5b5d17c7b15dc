"""`rsegen dataset`: very many maps in few files, for machine learning."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from rsegen.commands.parameters import Force, OutputFolder, Resume, Scheduler, Sync, Workers
from rsegen.params.command import command
from rsegen.params.sorts import Choice, Integer

if TYPE_CHECKING:
    from rsegen.io.dataset.reading import Dataset
    from rsegen.recipe.recipe import Recipe
    from rsegen.run.dataset import Progress


@command
def make_dataset(  # noqa: PLR0913  # each is a flag
    recipe: Recipe | Sequence[Recipe],
    folder: OutputFolder,
    *,
    metrics: Annotated[
        str, Choice(("npy", "parquet", "none"), help="form of the table of metrics; parquet needs rsegen[dataset]")
    ] = "npy",
    shard_maps: Annotated[int, Integer(0, 10**9, unit="maps", help="maps per file; 0: about a million cells")] = 0,
    force: Force = False,
    resume: Resume = False,
    workers: Workers = 1,
    scheduler: Scheduler = None,
    sync: Sync = True,
    progress: Progress | None = None,
) -> Dataset:
    """Write the maps of one or several recipes as a data set: block levels as arrays, metrics as tables, in shards.

    Several recipes have different names, and maps of one size, unit, width of blocks and boundary. `force` replaces a
    data set in one step once the new one is complete. With more than one worker a script needs
    `if __name__ == "__main__":`. Raises a ParameterError if the recipes do not go together, an OutputError before
    anything is written if the folder holds something else, and TooLarge if there is too little space.
    """
    from rsegen.io.dataset.layout import ShardLayout
    from rsegen.recipe.tiles import recipes_of
    from rsegen.run.dataset import make_shards, plan_dataset
    from rsegen.run.execute import Execution
    from rsegen.run.plan import OnExisting

    layout = ShardLayout(recipes=recipes_of(recipe), shard_maps=shard_maps, metrics=metrics)
    execution = Execution(workers=workers, scheduler=scheduler, sync=sync)
    return make_shards(
        plan_dataset(layout, Path(folder), OnExisting.of(force=force, resume=resume), execution), progress
    )
