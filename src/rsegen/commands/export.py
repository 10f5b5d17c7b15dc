"""`rsegen export`: maps in the formats of other programs, without worlds."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from rsegen.commands.parameters import Force, FormatList, OutputFolder, Resume, Scheduler, Sync, Workers
from rsegen.params.command import Shell, command
from rsegen.params.sorts import FilePath, Integer, Reference
from rsegen.params.streams import SEEDS

if TYPE_CHECKING:
    from rsegen.exporters.formats import Format
    from rsegen.exporters.scene import Scene
    from rsegen.recipe.recipe import Recipe
    from rsegen.run.exports import Exported, ExportedMap, Progress


@command
def export_maps(  # noqa: PLR0913  # each is a flag
    recipes: Sequence[Recipe],
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
    progress: Progress | None = None,
) -> tuple[ExportedMap, ...]:
    """Write maps in the formats of other programs: folder/NAME_0000, ..., with a folder for each format and the recipe.

    If a map is there already, as a world or exported before, the formats are added and all else stays; `resume` keeps
    formats that are complete and have the same options. Gives the maps that were written. Raises an OutputError before
    anything is written if a folder of that name holds something else, a format exists already, or two maps have one
    name; TooLarge if memory or disk space are too small. A format that joins the maps, such as `ros2` with a `package`,
    is alone, and writes them into one folder of that name: all of them or none. The rest is as in `generate`.
    """
    from rsegen.run.execute import Execution
    from rsegen.run.exports import export_joined, joining, plan_exports
    from rsegen.run.plan import OnExisting, run

    on_existing = OnExisting.of(force=force, resume=resume)
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

    map: a scene, or a recipe, of which map `index` is written; in a folder the files are as in one of `export_maps`.
    options: those of the format, as in `rsegen.export(recipe, "folder", "mjcf", shape="hfield")`. A UserError says what
    is wrong before anything is written.
    """
    from rsegen.run.exports import export_one

    return export_one(map, Path(path), format, index=index, force=force, options=options)
