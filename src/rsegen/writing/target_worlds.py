"""The world that a target stands for: a world file, that in a map's folder, or one made of a recipe or scene.

A world on disk is opened as it is; one of a recipe is made in a temporary folder that lasts as long as the simulator.
"""

from __future__ import annotations

import errno
import os
import os.path
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

from rsegen.errors import FileError, ParameterError, shown
from rsegen.gazebo import export
from rsegen.input_files import unreadable
from rsegen.recipe.recipe import Recipe
from rsegen.recipe.recipe_file import load
from rsegen.scene.scene import Scene, compose
from rsegen.writing.resources import refuse_too_large
from rsegen.writing.store import write_folder
from rsegen.writing.targets import chosen_map, map_index

Target: TypeAlias = "Recipe | Scene | str | os.PathLike[str]"
"""A recipe, a scene, or the path or name that the command line takes: a world file, a recipe file, an example, the
folder of a map or of maps, or DIR#17 of a data set."""


@dataclass(frozen=True, kw_only=True, slots=True)
class World:
    """A world, on disk already or to be made.

    file: the world file, None if it is made of the recipe or scene; recipe: of its one map, None if unknown; made_of:
    the scene that a caller gave.
    """

    file: Path | None = None
    recipe: Recipe | None = None
    made_of: Scene | None = None

    @property
    def made_for(self) -> str:
        """The `simulator` of the recipe."""
        return self.recipe.simulator if self.recipe else "both"

    def scene(self) -> Scene:
        """Return the scene of its map; FileError if the recipe is unknown, TooLarge if it does not fit into memory."""
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
        return target.alone(map_index(target, which)), None, None
    path = path_of(target)
    file, recipe, index = chosen_map(path, None if which is None else str(which))
    return recipe.alone(index), file.parent if os.path.isdir(path) else None, None


def world_of(target: Target, which: int | str | None = None) -> World:
    """Return the world of a target; `which`: the map's index or name, by default the first."""
    path = None if isinstance(target, Scene | Recipe) else Path(path_of(target))
    if path and not path.is_dir() and path.suffix in (".world", ".sdf"):
        recipe_file = path.with_name("recipe.json")
        return World(file=_existing(path), recipe=load(recipe_file) if recipe_file.is_file() else None)
    recipe, folder, made_of = chosen(target, which)
    file = _existing(folder / f"{recipe.map_name(recipe.first_map)}.world") if folder else None
    return World(file=file, recipe=recipe, made_of=made_of)


def _existing(file: Path) -> Path:
    if not file.is_file():
        raise FileError(unreadable(file, FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT))))
    return file
