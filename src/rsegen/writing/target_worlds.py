"""Find what a target stands for: recipe files, one map of them, and its world.

    path or name --recipe_files--> recipe.json of a map, of each map in a folder, an example, or a recipe file
                 --chosen_map----> one map, by its index or name, by default the first
                 --world_of------> a world file, that in a map's folder, or one made of a recipe or scene

DIR#17, a map of a data set, can be given wherever a recipe file can; a file of that very name comes first. A world on
disk is opened as it is; one of a recipe is made in a temporary folder that lasts as long as the simulator.
"""

from __future__ import annotations

import errno
import os
import os.path
import re
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple, TypeAlias

from rsegen.errors import FileError, ParameterError, UserError, shown
from rsegen.gazebo import export
from rsegen.input_files import unreadable
from rsegen.recipe.recipe import Recipe, index_of
from rsegen.recipe.recipe_file import load, or_example, recipe_in
from rsegen.scene.scene import Scene, compose
from rsegen.writing.resources import refuse_too_large
from rsegen.writing.store import write_folder

Target: TypeAlias = "Recipe | Scene | str | os.PathLike[str]"
"""A recipe, a scene, or the path or name that the command line takes: a world file, a recipe file, an example, the
folder of a map or of maps, or DIR#17 of a data set."""


class ChosenMap(NamedTuple):
    """A map of a recipe, and the file that the recipe is from."""

    file: Path
    recipe: Recipe
    map: int


def recipe_files_in(folder: Path) -> list[Path]:
    """Return the recipe files of the maps in a folder, in the order of their names."""
    return sorted(folder.glob("*/recipe.json"))


def recipe_files(target: str) -> list[Path]:
    """Return the file of a recipe, of a map's folder, or of every map in a folder; FileError if it has no map."""
    path = or_example(target)
    own = path / "recipe.json" if os.path.isdir(target) else path
    files = [own] if own == path or own.is_file() else recipe_files_in(path)
    if not files:
        raise FileError(
            f"{target}: no map in it, nor in its folders (a map's folder has a recipe.json; DIR#0 is one of a data set)"
        )
    return files


def chosen_map(target: str, which: str | None, where: str = "map") -> ChosenMap:
    """Return the given map of a target, or the first; errors about `which` name the flag or parameter `where`."""
    files = recipe_files(target)
    if which is not None and which.isdecimal():  # an index that maps of several recipes in the folder may have
        like = [file.parent.name for file in files if re.fullmatch(rf".*_0*{int(which[:20])}", file.parent.name)]
        if len(like) > 1:
            raise ParameterError(where, f"{shown(which)} may be {' or '.join(like[:3])}; use the full name")
    return one_of(((file, recipe_in(file)) for file in files), which, target, where)


def one_of(
    recipes: Iterable[tuple[Path, Recipe]], which: int | str | None, target: str, where: str = "map"
) -> ChosenMap:
    """Return the given map of some recipes, each with its file, or the first; a message calls them `target`."""
    names = []
    for file, recipe in recipes:
        index = recipe.first_map if which is None else index_of(recipe, str(which))
        if index is not None:
            return ChosenMap(file, recipe, index)
        names += [recipe.map_name(recipe.indices[0]), recipe.map_name(recipe.indices[-1])]
    known = "..".join(dict.fromkeys([names[0], names[-1]]))  # one name of a single map
    raise ParameterError(where, f"there is no map {shown(which)} in {target}; use an index or name, {known}")


@dataclass(frozen=True, kw_only=True, slots=True)
class World:
    """A world, on disk already or to be made.

    file: the world file, None if it is made of the recipe or scene; recipe: of its one map, None if unknown; unread:
    why the recipe next to the file is unknown, such as a plug-in that it needs; made_of: the scene that a caller gave.
    """

    file: Path | None = None
    recipe: Recipe | None = None
    unread: UserError | None = None
    made_of: Scene | None = None

    @property
    def made_for(self) -> str:
        """The `simulator` of the recipe."""
        return self.recipe.simulator if self.recipe else "both"

    def scene(self) -> Scene:
        """Return the scene of its map; a UserError if the recipe is unknown, TooLarge if memory is too small."""
        if self.unread:
            raise self.unread
        if not self.recipe:
            raise FileError(f"{self.file}: no recipe.json next to it, so the heights of its blocks are unknown")
        return self.made_of or scene_of(self.recipe)

    @contextmanager
    def on_disk(self) -> Iterator[Path]:
        """Make the world file, if need be, and delete a file that was made when this ends."""
        if self.file:
            yield self.file
            return
        with tempfile.TemporaryDirectory(prefix="rsegen-") as folder:
            yield write_world(self.scene(), Path(folder))


def scene_of(recipe: Recipe) -> Scene:
    """Return the scene of the first map of a recipe; TooLarge if it does not fit into memory."""
    refuse_too_large(recipe)
    return compose(recipe, recipe.first_map)


def write_world(scene: Scene, folder: Path) -> Path:
    """Write a scene's world with all that it needs as `folder/NAME_000k`, and return its file."""
    write_folder(export(scene), folder / scene.name, sync=False)
    return folder / scene.name / f"{scene.name}.world"


def path_of(target: object) -> str:
    """Return the path or name that a target is; a ParameterError if it is neither."""
    if isinstance(target, str | os.PathLike):
        return os.fspath(target)
    raise ParameterError("target", f"{shown(target)} is no recipe or scene, nor the path or name of one")


def chosen(target: Target, which: int | str | None) -> tuple[Recipe, Path | None, Scene | None]:
    """Return the recipe of a target's map alone, the folder that it is in, if in any, and its scene, if one was given.

    which: the map's index or name, by default the first
    """
    if isinstance(target, Scene):
        return target.alone, None, target
    if isinstance(target, Recipe):
        return target.alone(one_of([(Path(), target)], which, "the recipe").map), None, None
    path = path_of(target)
    file, recipe, index = chosen_map(path, None if which is None else str(which))
    return recipe.alone(index), file.parent if os.path.isdir(path) else None, None


def world_of(target: Target, which: int | str | None = None) -> World:
    """Return the world of a target; `which`: the map's index or name, by default the first.

    A world on disk needs no recipe to be opened, so it may have one that cannot be read.
    """
    path = None if isinstance(target, Scene | Recipe) else Path(path_of(target))
    if path and not path.is_dir() and path.suffix in (".world", ".sdf"):
        return _world_with_recipe(_existing(path))
    try:
        recipe, folder, made_of = chosen(target, which)
    except UserError:
        if path and path.is_dir() and (file := _world_in(path, which)):
            return _world_with_recipe(file)
        raise
    file = _existing(folder / f"{recipe.map_name(recipe.first_map)}.world") if folder else None
    return World(file=file, recipe=recipe, made_of=made_of)


def _world_with_recipe(file: Path) -> World:
    """Return the world in a file, with the recipe.json next to it, if it exists, or why that cannot be read."""
    recipe_file = file.with_name("recipe.json")
    try:
        return World(file=file, recipe=load(recipe_file) if recipe_file.is_file() else None)
    except UserError as error:
        return World(file=file, unread=error)


def _world_in(folder: Path, which: int | str | None) -> Path | None:
    """Return the world file of a map's folder, or of the given map, or the first, of a folder of maps, by its name."""
    homes = [folder] if (folder / "recipe.json").is_file() else [file.parent for file in recipe_files_in(folder)]
    if which is not None:
        name = rf".*_0*{which}" if str(which).isdecimal() else re.escape(str(which))
        homes = [home for home in homes if re.fullmatch(name, home.name)]
        homes = homes if len(homes) == 1 else []
    files = [home / f"{home.resolve().name}.world" for home in homes[:1]]
    return next((file for file in files if file.is_file()), None)


def _existing(file: Path) -> Path:
    if not file.is_file():
        raise FileError(unreadable(file, FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT))))
    return file
