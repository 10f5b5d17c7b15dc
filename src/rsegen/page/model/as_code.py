"""A recipe as a command line and as a Python program that generate the same maps."""

from __future__ import annotations

import shlex

from rsegen.field.obstacles import Obstacle
from rsegen.page.model.session import Entry, draft_of
from rsegen.params.sorts import Json, parameters
from rsegen.recipe.codec import row_text
from rsegen.recipe.recipe import Recipe


def command_line(recipe: Recipe, folder: str) -> str:
    """Return the command that generates the maps of a recipe."""
    words = ["rsegen", "generate", "-o", folder]
    for name, value in _stated(recipe).items():
        words += [f"--{name.replace('_', '-')}", parameters(Recipe)[name].format(value)]
    for obstacle in recipe.obstacles:
        words += ["--obstacle", row_text(obstacle)]
    return shlex.join(words)


def python_code(recipe: Recipe, folder: str) -> str:
    """Return the program that generates the maps of a recipe."""
    others = {type(obstacle) for obstacle in recipe.obstacles if not _is_ours(type(obstacle))}
    imports = sorted(f"from {cls.__module__} import {cls.__name__}" for cls in others)
    lines = ["import rsegen", *imports, "", "recipe = rsegen.Recipe("]
    lines += [f"    {name}={_tuple(value)!r}," for name, value in _stated(recipe).items()]
    lines += ["    obstacles=[", *(f"        {_call(obstacle)}," for obstacle in recipe.obstacles), "    ],", ")"]
    return "\n".join([*lines, f"rsegen.generate(recipe, {folder!r})", ""])


def _stated(recipe: Recipe) -> Entry:
    """Return the seed, and the global parameters that differ from their defaults."""
    values, default = draft_of(recipe).values, draft_of(Recipe(seed=0)).values
    return {name: value for name, value in values.items() if value != default.get(name) or name == "seed"}


def _is_ours(cls: type) -> bool:
    return cls.__module__.partition(".")[0] == "rsegen"


def _call(obstacle: Obstacle) -> str:
    """Return an obstacle as the expression that makes it."""
    cls = type(obstacle)
    name = f"rsegen.{cls.__name__}" if _is_ours(cls) else cls.__name__
    values = {key: _tuple(value) for key, value in obstacle.entry().items() if key != "kind"}
    return f"{name}({', '.join(f'{key}={value!r}' for key, value in values.items())})"


def _tuple(value: Json) -> Json:
    return tuple(value) if isinstance(value, list) else value
