"""Write maps in the formats of other programs, without worlds, or add formats to maps that exist.

    Recipe or Scene --export--> a file, or a folder
    recipes --plan_exports--> RunPlan --run--> an ExportedMap of each map
    recipes, a format that joins maps (a ROS 2 package) --export_joined--> a folder with all maps, or none

Each format has its own folder in the map's folder, which is replaced as a whole. The file formats.json lists them with
their options, so a resumed run knows which formats it need not write again.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import fsum, prod
from pathlib import Path, PurePosixPath
from typing import Any

from rsegen.errors import OutputError, ParameterError, UnknownName, UserError, refuse_other
from rsegen.formats.base import FORMATS, Format, exported, recorded_options, refuse_unready
from rsegen.formats.encoded import as_json
from rsegen.formats.sidecar import FORMATS_FILE, FormatFiles, listed_formats
from rsegen.gazebo import Bundle
from rsegen.input_files import JOURNAL, Checksum, regular_content
from rsegen.params.sorts import parameters
from rsegen.recipe.codec import map_json
from rsegen.recipe.recipe import Recipe
from rsegen.recipe.recipe_file import load
from rsegen.scene.scene import Scene, compose
from rsegen.writing.dry import announce_files
from rsegen.writing.execute import Execution
from rsegen.writing.journal import Journal, compare, is_intact, read_errors, read_journal, refuse_link, refuse_loss
from rsegen.writing.plan import OnExisting, Output, RunPlan
from rsegen.writing.resources import check_needs, refuse_too_large
from rsegen.writing.sidecars import files_of
from rsegen.writing.store import (
    new_root,
    open_store,
    refuse_busy,
    refuse_taken,
    refuse_unit,
    sorted_names,
    stage_all,
    taken,
    write_file,
    write_folder,
)

_RECIPE = "recipe.json"
_RECIPES = "recipes"
"""The folder in a package with the recipe of each map."""


# A single map.


@dataclass(frozen=True, kw_only=True, slots=True)
class Exported:
    """A map that was written in another format.

    Attributes
    ----------
    path : Path
        The file or folder.
    format : str
        The format's name.
    files : tuple of Path
        Every file that was written.
    """

    path: Path
    format: str
    files: tuple[Path, ...]


def export_one(
    map: Recipe | Scene,  # noqa: A002  # the field's word
    path: Path,
    format: str | None,  # noqa: A002  # the command line's word
    *,
    index: int,
    force: bool,
    options: Mapping[str, Any],
) -> Exported:
    """Write one map in one format: as a file if the path has a suffix, else as a folder. See `rsegen.export`."""
    chosen = _format(path, format, options)
    # All that can refuse comes before the map is composed, which may take minutes.
    refuse_unready([chosen])
    refuse_other("map", map, Recipe, Scene)
    recipe = map.recipe if isinstance(map, Scene) else map
    refuse_too_large(recipe, things=[chosen])
    scene = map if isinstance(map, Scene) else compose(map, index)
    if not path.suffix:
        names = write_folder(exported(scene, [chosen]), path, force=force)
        return Exported(path=path, format=chosen.name, files=tuple(path / name for name in names))
    files = files_of(chosen, scene)
    if len(files) != 1:
        problem = f"{path} is one file, but {chosen.name} writes {len(files)} of them"
        raise ParameterError("path", f"{problem}; use a folder, without a suffix")
    (content,) = files.values()
    write_file(content, path, force=force)
    return Exported(path=path, format=chosen.name, files=(path,))


def _format(path: Path, name: str | None, options: Mapping[str, Any]) -> Format:
    """Return the format of a name, or of the suffix of a path, with its options."""
    if name is None and not path.suffix:
        raise ParameterError("format", f"{path} has no suffix; choose a format (known: {', '.join(FORMATS)})")
    cls = FORMATS.named(path.suffix.lower().removeprefix(".") if name is None else name, "format")
    for option in options:
        if option not in parameters(cls):
            raise UnknownName.among("format", f"option of {cls.name}", option, parameters(cls))
    return cls(**options)


# Many maps.


@dataclass(frozen=True, kw_only=True, slots=True)
class ExportedMap:
    """A map in other formats on disk.

    Attributes
    ----------
    folder : Path
        Its folder.
    names : tuple of str
        Names of the files that were written into it.
    """

    folder: Path
    names: tuple[str, ...]


@dataclass(frozen=True, kw_only=True, slots=True)
class MapExport:
    """A map to export in some formats; `adds`: into its folder, which exists and keeps everything else."""

    recipe: Recipe
    index: int
    formats: tuple[Format, ...]
    adds: bool = False


ExportsPlan = RunPlan[MapExport, ExportedMap]

ExportProgress = Callable[[ExportedMap], None]


def plan_exports(
    recipes: Sequence[Recipe],
    folder: Path,
    formats: Sequence[Format],
    on_existing: OnExisting,
    execution: Execution | None = None,
) -> ExportsPlan:
    """Check that all maps can be exported into a folder, and plan it; nothing is written. Raises as `export_maps`."""
    # Formats are checked for each recipe, then room for all maps, then each map's folder: cheap checks come first.
    execution, sidecar = execution or Execution(), FormatFiles.of(formats)
    for recipe in recipes:
        sidecar.refuse(recipe)
    maps, at_once = _checked_maps(recipes, folder, formats)
    planned = [planned_export(recipe, index, folder, sidecar.formats, on_existing) for recipe, index in maps]
    return RunPlan(
        folder=folder,
        product=partial(_export, folder),
        seconds=fsum(recipe.maps / len(maps) * sidecar.seconds(prod(recipe.grid.shape)) for recipe in recipes),
        to_make=[export for export in planned if export.formats],
        existing=[export for export in planned if not export.formats],
        added_to=[export.recipe.map_name(export.index) for export in planned if not export.formats],
        replaces=on_existing is OnExisting.REPLACE,
        execution=replace(execution, workers=min(execution.workers, at_once)),
    )


def _checked_maps(
    recipes: Sequence[Recipe], folder: Path, formats: Sequence[Format]
) -> tuple[Sequence[tuple[Recipe, int]], int]:
    """Return every map of some recipes, and how many of them fit into memory at once; raises as `export_maps` does."""
    refuse_busy(folder)
    at_once = check_needs(recipes, sum(recipe.maps for recipe in recipes), folder, things=formats)
    maps = [(recipe, index) for recipe in recipes for index in recipe.indices]
    seen = set()
    for name in (recipe.map_name(index) for recipe, index in maps):
        if name in seen:
            raise OutputError(f"{folder / name}: two of the maps have this name; export them into separate folders")
        seen.add(name)
    return maps, at_once


def planned_export(
    recipe: Recipe, index: int, folder: Path, formats: Sequence[Format], on_existing: OnExisting
) -> MapExport:
    """Return how a map is exported, in no format if it has them all; an OutputError if it cannot be."""
    home = folder / recipe.map_name(index)
    if not os.path.lexists(home):
        return MapExport(recipe=recipe, index=index, formats=tuple(formats))
    refuse_link(home)
    with read_errors(home):
        journal = read_journal(home)
        if not _has_map(home, recipe, index):
            _refuse_other_map(home, formats, on_existing)
            return MapExport(recipe=recipe, index=index, formats=tuple(formats))
        missing = _missing_formats(home, journal, formats, on_existing)
    return MapExport(recipe=recipe, index=index, formats=missing, adds=True)


def _export(folder: Path, item: MapExport) -> Output[ExportedMap]:
    """Return the files of a map in other formats."""
    name = item.recipe.map_name(item.index)
    home, bundle = folder / name, exported(compose(item.recipe, item.index), item.formats)
    if item.adds:  # to a map whose recipe.json stays, and whose formats.json lists the new formats too
        bundle = {path: content for path, content in bundle.items() if path != PurePosixPath(_RECIPE)}
        bundle = {**bundle, **FormatFiles(item.formats).lists(str(home))}
    names = frozenset(format_.name for format_ in item.formats)
    return Output(
        made=ExportedMap(folder=home, names=sorted_names(bundle)),
        files=bundle,
        folder=name,
        adds=item.adds,
        force=names | {FORMATS_FILE},  # the plan has refused those that must stay
        whole=names,
    )


# Formats that a map has already.


def _has_map(home: Path, recipe: Recipe, index: int) -> bool:
    """Return whether a folder holds this map, whatever version of rsegen wrote its recipe.json."""
    text = map_json(recipe, index)
    if regular_content(home / _RECIPE, len(text) + 1) == text:
        return True
    try:
        return load(home / _RECIPE) == recipe.alone(index)
    except UserError:
        return False


def _missing_formats(
    home: Path, journal: Journal | None, formats: Sequence[Format], on_existing: OnExisting
) -> tuple[Format, ...]:
    """Return the formats to write for a map that exists; an OutputError if it has one that may not be replaced."""
    listed = listed_formats(str(home))
    if listed is None:
        raise OutputError(f"{home / FORMATS_FILE}: is damaged, so no format is added; use another folder")
    refuse_link(home / FORMATS_FILE)
    missing = []
    for format_ in formats:
        if os.path.lexists(home / format_.name):
            refuse_unit(home, format_.name, journal, force=True, is_folder=True)
            if on_existing is OnExisting.REFUSE:
                raise taken(home / format_.name)
            # A resumed run keeps only what has the same options, and every file as it was written.
            same = listed.get(format_.name) == recorded_options([format_])[format_.name]
            if on_existing is OnExisting.KEEP and same and journal is not None:
                comparison = compare(home, journal, format_.name)
                if not comparison.changed and not comparison.missing:
                    continue
        missing.append(format_)
    if missing:
        is_intact(home, FORMATS_FILE, journal)  # which will list them
    return tuple(missing)


def _refuse_other_map(home: Path, formats: Sequence[Format], on_existing: OnExisting) -> None:
    """Raise an OutputError unless another map in the folder may be replaced, and nothing is lost but these formats."""
    # What another map leaves behind would be taken for a part of the new one.
    refuse_loss(home, "map")
    names = {_RECIPE, FORMATS_FILE, JOURNAL, *(format_.name for format_ in formats)}
    others = sorted({path.name for path in home.iterdir()} - names)
    if f"{home.name}.world" in others:
        raise OutputError(f"{home}: has the world of another map in it, so it is not replaced; use another folder")
    if on_existing is not OnExisting.REPLACE:
        raise OutputError(
            f"{home}: exists already and is another map, of another seed or parameter; "
            "use force=True to replace it, or another folder or name"
        )
    if others:
        raise OutputError(
            f"{home}: has {others[0]} of another map in it, which would be overwritten; "
            "name all of its formats to replace them, or use another folder"
        )


# Formats that join maps in one folder.


def joining(formats: Sequence[Format]) -> Format | None:
    """Return the format that joins maps in one folder, if any; a ParameterError if others are given with it."""
    joined = [format_ for format_ in formats if format_.joins]
    if joined and len(formats) > 1:
        others = ", ".join(format_.name for format_ in formats if format_ is not joined[0])
        problem = f"{joined[0].name} puts all maps into one folder, {joined[0].joins}, and {others} each into its own"
        raise ParameterError("formats", f"{problem}; export them one after the other")
    return joined[0] if joined else None


def export_joined(
    recipes: Sequence[Recipe],
    folder: Path,
    chosen: Format,
    on_existing: OnExisting,
    progress: ExportProgress | None,
    *,
    sync: bool,
) -> tuple[ExportedMap, ...]:
    """Write maps into one folder, which appears at the end; a returned map has the files that no earlier one wrote."""
    # All maps share files, such as launch files, which the first one writes; so they are made here, one by one.
    refuse_unready([chosen])
    maps, _ = _checked_maps(recipes, folder, [chosen])
    home = folder / chosen.joins
    if on_existing is OnExisting.KEEP and os.path.lexists(home):
        _refuse_incomplete(home, chosen, maps)
        announce_files(home, ())  # of a dry run: all of them stay
        maps = ()
    else:
        refuse_taken([home], force=on_existing is OnExisting.REPLACE, holds="package")
    made: list[ExportedMap] = []
    with open_store(home.parent, sync=sync, output=home) as store:
        root, files = new_root(store.staging), dict[str, Checksum]()
        for recipe, index in maps:
            own = files_of(chosen, compose(recipe, index))
            bundle: Bundle = {
                **{path.relative_to(chosen.joins): content for path, content in own.items()},
                PurePosixPath(_recipe_file(recipe, index)): [map_json(recipe, index)],
                PurePosixPath(FORMATS_FILE): [as_json(recorded_options([chosen]))],
            }
            new = {path: content for path, content in bundle.items() if str(path) not in files}
            files |= stage_all(root, new)
            made.append(ExportedMap(folder=home, names=sorted_names(new)))
            if progress:
                progress(made[-1])
        if maps:
            store.put_complete(root, files, home.name, "package", force=on_existing is OnExisting.REPLACE)
    return tuple(made)


def _refuse_incomplete(home: Path, chosen: Format, maps: Sequence[tuple[Recipe, int]]) -> None:
    """Raise an OutputError unless a folder holds these maps in this format, and no others."""
    refuse_link(home)
    with read_errors(home):
        journal = read_journal(home)
        expected = {_recipe_file(recipe, index): map_json(recipe, index) for recipe, index in maps}
        expected[FORMATS_FILE] = as_json(recorded_options([chosen]))
        held = journal.files if journal else {}
        same = all(Checksum.of(content) in held.get(name, ()) for name, content in expected.items())
        others = {name for name in held if name.startswith(f"{_RECIPES}/")} - expected.keys()
        if journal is None or not same or others:
            problem = "exists already and contains other maps, or not all of these"
            raise OutputError(f"{home}: {problem}; use force=True to replace it, or another package or folder")
        comparison = compare(home, journal)
    for name in (*comparison.changed, *comparison.missing):
        raise OutputError(
            f"{home / name}: was changed or lost after rsegen wrote it; use force=True, or another folder"
        )


def _recipe_file(recipe: Recipe, index: int) -> str:
    return f"{_RECIPES}/{recipe.map_name(index)}.json"
