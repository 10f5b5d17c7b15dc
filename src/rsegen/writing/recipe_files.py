"""Write recipe files, whole or not at all."""

from __future__ import annotations

from pathlib import Path

from rsegen.errors import refuse_other
from rsegen.params.sorts import FilePath
from rsegen.recipe.codec import to_json
from rsegen.recipe.recipe import Recipe
from rsegen.recipe.recipe_file import to_yaml
from rsegen.writing.store import write_file


def save(recipe: Recipe, path: str | Path, *, force: bool = False) -> None:
    """Write a recipe file, whole or not at all.

    Parameters
    ----------
    recipe : Recipe
        The recipe.
    path : str or Path
        The file, YAML or JSON by its suffix.
    force : bool, default False
        Replace it if it exists.

    Raises
    ------
    OutputError
        If it exists already and is not to be replaced.
    """
    refuse_other("recipe", recipe, Recipe)
    path = FilePath("a file").check("path", path)
    text = to_json(recipe, derived_keys=False) if path.suffix.lower() == ".json" else to_yaml(recipe)
    write_file([text.encode()], path, force=force)
