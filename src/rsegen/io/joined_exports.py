"""Writes maps in a format that joins them in one folder, such as a ROS 2 package of several maps.

recipes --plan_joined_export--> JoinedExport --write_joined--> ExportedMap of each

The folder appears at the end, with all maps: a run that is stopped leaves nothing.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from rsegen.errors import OutputError, ParameterError
from rsegen.exporters.formats import Format, options
from rsegen.exporters.gazebo import Bundle
from rsegen.exporters.scene import compose
from rsegen.io.contents import compare, refuse_link
from rsegen.io.existing import OnExisting
from rsegen.io.exported_map import ExportedMap
from rsegen.io.record import WrittenFile, read_record
from rsegen.io.sidecars import FORMATS_FILE
from rsegen.io.staging import as_write_errors, remove_leftovers
from rsegen.io.writer import folder_writer, refuse_taken
from rsegen.recipe.codec import map_json
from rsegen.recipe.recipe import Recipe

Progress = Callable[[ExportedMap], None]


@dataclass(frozen=True, kw_only=True, slots=True)
class JoinedExport:
    """The maps to write into `home` together, none if it holds them all already."""

    home: Path
    format: Format
    maps: Sequence[tuple[Recipe, int]]
    replaces: bool


def joining(formats: Sequence[Format]) -> Format | None:
    """The format that joins maps in one folder, if there is one; a ParameterError if others are given with it."""
    found = [each for each in formats if each.joins]
    if found and len(formats) > 1:
        others = ", ".join(each.name for each in formats if each is not found[0])
        problem = f"{found[0].name} puts all maps into one folder, {found[0].joins}, and {others} each into its own"
        raise ParameterError("formats", f"{problem}; export them one after the other")
    return found[0] if found else None


def plan_joined_export(
    maps: Sequence[tuple[Recipe, int]], folder: Path, chosen: Format, on_existing: OnExisting
) -> JoinedExport:
    """Check that maps can be written into one folder; an OutputError if that exists and may not be replaced."""
    home = folder / chosen.joins
    if on_existing is OnExisting.KEEP and os.path.lexists(home):
        _refuse_incomplete(home, chosen, maps)
        maps = ()
    else:
        refuse_taken([home], force=on_existing is OnExisting.REPLACE)
    return JoinedExport(home=home, format=chosen, maps=maps, replaces=on_existing is OnExisting.REPLACE)


def write_joined(plan: JoinedExport, progress: Progress | None = None, *, sync: bool = True) -> tuple[ExportedMap, ...]:
    """Write the maps of a plan; `progress` is called with each. Each names the files that those before it don't."""
    if not plan.maps:
        return ()
    made: list[ExportedMap] = []

    def done(names: tuple[str, ...]) -> None:
        made.append(ExportedMap(folder=plan.home, names=names))
        if progress:
            progress(made[-1])

    remove_leftovers(plan.home.parent)
    with (
        as_write_errors(plan.home),
        folder_writer(plan.home.parent, force=plan.replaces, sync=sync) as writer,
    ):
        writer.write_together(plan.home.name, _bundles(plan), done)
    return tuple(made)


def _bundles(plan: JoinedExport) -> Iterator[Bundle]:
    """The files of each map, one map after the other, by their paths in the folder."""
    for recipe, index in plan.maps:
        files = plan.format.files(compose(recipe, index))
        yield {
            **{PurePosixPath(path).relative_to(plan.format.joins): content for path, content in files.items()},
            PurePosixPath(_recipe_file(recipe, index)): [map_json(recipe, index)],
            PurePosixPath(FORMATS_FILE): [_formats_file(plan.format)],
        }


def _refuse_incomplete(home: Path, chosen: Format, maps: Sequence[tuple[Recipe, int]]) -> None:
    """Raise an OutputError unless a folder holds these maps in this format, and no others."""
    refuse_link(home)
    record = read_record(home)
    expected = {_recipe_file(recipe, index): map_json(recipe, index) for recipe, index in maps}
    expected[FORMATS_FILE] = _formats_file(chosen)
    held = record.files if record else {}
    same = all(WrittenFile.of(content) in held.get(name, ()) for name, content in expected.items())
    others = {name for name in held if name.startswith(f"{_RECIPES}/")} - expected.keys()
    if record is None or not same or others:
        problem = "exists already and does not hold these maps and no others"
        raise OutputError(f"{home}: {problem}; give --force to replace it, or another package or folder")
    found = compare(home, record)
    if not found.is_intact:
        name = [*found.changed, *found.damaged][0]
        raise OutputError(f"{home / name}: was changed or lost after rsegen wrote it; give --force, or another folder")


_RECIPES = "recipes"


def _recipe_file(recipe: Recipe, index: int) -> str:
    return f"{_RECIPES}/{recipe.map_name(index)}.json"


def _formats_file(chosen: Format) -> bytes:
    return (json.dumps(options([chosen]), indent=2) + "\n").encode()
