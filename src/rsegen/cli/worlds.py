"""The world that a target of the command line stands for: a file, that of a map's folder, or one made of a recipe."""

from __future__ import annotations

import os.path
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from rsegen.errors import FileError
from rsegen.io.recipe_file import load
from rsegen.io.targets import found
from rsegen.io.worlds import generate
from rsegen.recipe.recipe import Recipe


@dataclass(frozen=True, kw_only=True, slots=True)
class World:
    """A world file if there is one, the recipe of its one map if that is known, and what it says of simulators."""

    file: Path | None = None
    recipe: Recipe | None = None
    made_for: str

    @contextmanager
    def on_disk(self) -> Iterator[Path]:
        """Its file; one that is made of a recipe goes when this ends."""
        if self.file:
            yield self.file
        elif self.recipe:
            with tempfile.TemporaryDirectory(prefix="rsegen-") as folder:
                yield generate(self.recipe, folder).maps[0].world


def world_of(target: str, which: str | None) -> World:
    """The world of a target."""
    if not os.path.isdir(target) and Path(target).suffix in (".world", ".sdf"):
        beside = Path(target).with_name("recipe.json")
        recipe = load(beside) if beside.is_file() else None
        return World(file=_there(Path(target)), recipe=recipe, made_for=recipe.simulator if recipe else "both")
    file, recipe, index = found(target, which)
    if os.path.isdir(target):
        world = _there(file.with_name(f"{recipe.map_name(index)}.world"))
        return World(file=world, recipe=recipe, made_for=recipe.simulator)
    return World(recipe=recipe.alone(index), made_for=recipe.simulator)


def _there(file: Path) -> Path:
    if not file.is_file():
        raise FileError(f"{file}: there is no such world")
    return file
