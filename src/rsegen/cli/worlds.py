"""The world that a target of the command line stands for: a file, that of a map's folder, or one made of a recipe."""

from __future__ import annotations

import os.path
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from rsegen.cli.targets import Found, found
from rsegen.errors import FileError
from rsegen.pipeline import generate
from rsegen.recipe_file import load


class World(NamedTuple):
    """A world file, and what its recipe says of simulators."""

    file: Path
    made_for: str


def is_recipe(target: str) -> bool:
    """Whether it names a recipe file, of which a world has to be made first."""
    return not os.path.isdir(target) and Path(target).suffix not in (".world", ".sdf")


@contextmanager
def world_of(target: str, which: str | None) -> Iterator[World]:
    """The world of a target; one that is made of a recipe goes when this ends."""
    if is_recipe(target):
        with tempfile.TemporaryDirectory(prefix="rsegen-") as folder:
            yield _made(found(target, which), Path(folder))
    elif os.path.isdir(target):
        map_ = found(target, which)
        yield World(_there(map_.file.with_name(f"{map_.recipe.map_name(map_.map)}.world")), map_.recipe.simulator)
    else:
        file = _there(Path(target))
        recipe = file.with_name("recipe.json")
        yield World(file, load(recipe).simulator if recipe.is_file() else "both")


def _made(map_: Found, folder: Path) -> World:
    recipe = replace(map_.recipe, first_map=map_.map, maps=1)
    return World(generate(recipe, folder).maps[0].world, recipe.simulator)


def _there(file: Path) -> Path:
    if not file.is_file():
        raise FileError(f"{file}: there is no such world")
    return file
