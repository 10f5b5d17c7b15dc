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

from rsegen.errors import FileError
from rsegen.exporters.gazebo import export
from rsegen.exporters.scene import Scene, compose
from rsegen.io.input_files import unreadable
from rsegen.io.recipe_file import load
from rsegen.io.resources import refuse_too_large
from rsegen.io.targets import chosen_map, map_index
from rsegen.recipe.recipe import Recipe
from rsegen.run.store import write_folder

Target: TypeAlias = "Recipe | Scene | str | os.PathLike[str]"
"""A recipe, a scene, or the path or name that the command line takes: a world file, a recipe file, an example, the
folder of a map or of maps, or DIR#17 of a data set."""


@dataclass(frozen=True, kw_only=True, slots=True)
class World:
    """A world, on disk already or to be made.

    file: the world file, None if it is made of the recipe or scene; recipe: of its one map, None if unknown;
    made_for: the `simulator` of the recipe; made_of: the scene that a caller gave.
    """

    file: Path | None = None
    recipe: Recipe | None = None
    made_for: str
    made_of: Scene | None = None

    def scene(self) -> Scene:
        """Return the scene of its map; FileError if the recipe is unknown, TooLarge if it does not fit into memory."""
        if self.made_of:
            return self.made_of
        if not self.recipe:
            raise FileError(f"{self.file}: no recipe.json next to it, so the heights of its blocks are unknown")
        refuse_too_large(self.recipe)
        return compose(self.recipe, self.recipe.first_map)

    @contextmanager
    def on_disk(self) -> Iterator[Path]:
        """Make the world file, if need be, and delete a file that was made when this ends."""
        if self.file:
            yield self.file
            return
        with tempfile.TemporaryDirectory(prefix="rsegen-") as folder:
            yield write_world(self.scene(), Path(folder))


def write_world(scene: Scene, folder: Path) -> Path:
    """Write a scene's world with all that it needs as `folder/NAME_000k`, and return its file."""
    write_folder(export(scene), folder / scene.name, sync=False)
    return folder / scene.name / f"{scene.name}.world"


def world_of(target: Target, which: int | str | None = None) -> World:
    """Return the world of a target; `which`: the map's index or name, by default the first."""
    if isinstance(target, Scene):
        return World(recipe=target.alone, made_for=target.recipe.simulator, made_of=target)
    if isinstance(target, Recipe):
        return World(recipe=target.alone(map_index(target, which)), made_for=target.simulator)
    path = os.fspath(target)
    if not os.path.isdir(path) and Path(path).suffix in (".world", ".sdf"):
        return _world_in(Path(path))
    file, recipe, index = chosen_map(path, None if which is None else str(which))
    if os.path.isdir(path):
        world = _existing(file.with_name(f"{recipe.map_name(index)}.world"))
        return World(file=world, recipe=recipe, made_for=recipe.simulator)
    return World(recipe=recipe.alone(index), made_for=recipe.simulator)


def _world_in(file: Path) -> World:
    """Return a world file, with the recipe next to it if there is one."""
    recipe_file = file.with_name("recipe.json")
    recipe = load(recipe_file) if recipe_file.is_file() else None
    return World(file=_existing(file), recipe=recipe, made_for=recipe.simulator if recipe else "both")


def _existing(file: Path) -> Path:
    if not file.is_file():
        raise FileError(unreadable(file, FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT))))
    return file
