"""Read recipe files, by path or name, and make their text: JSON if the name ends in .json, else YAML.

Files may come from anybody: their size is bounded, and so is the work for a text of that size (`yaml_loader`).
"""

from __future__ import annotations

import json
import os.path
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from rsegen.errors import FileError, ParameterError, UserError, did_you_mean, inside
from rsegen.input_files import file_type, parser_message, refuse_duplicates, regular_content, text_of
from rsegen.params.capabilities import hooks
from rsegen.params.sorts import FilePath, Float, Json
from rsegen.recipe.codec import decode, encode
from rsegen.recipe.examples import EXAMPLES
from rsegen.recipe.map_design import asked_certainty
from rsegen.recipe.recipe import Recipe

MAX_RECIPE_MIB = {".json": 64, ".yaml": 4}
"""The largest files that are read, MiB: a minute's work for PyYAML, a second's for JSON."""


def load(path: str | Path) -> Recipe:
    """Read the recipe in a YAML or JSON file, or an example.

    Parameters
    ----------
    path : str or Path
        The file, or the name of an example.

    Returns
    -------
    Recipe
        The recipe.

    Raises
    ------
    FileError
        If the file cannot be read.
    ParameterError
        If a value in it is wrong.
    """
    recipe, _ = recipe_and_content(or_example(FilePath("a file").check("path", path)))
    return recipe


def named_recipe(text: str) -> Recipe:
    """Return the recipe that a text stands for: a file, the name of an example, the folder of a map, or DIR#17."""
    if not os.path.isdir(text):
        return recipe_in(or_example(text))
    path = Path(text) / "recipe.json"
    if not path.is_file():
        raise FileError(
            f"{text}: a folder without a recipe.json; use a recipe file, the folder of a map, or DIR#0 of a data set"
        )
    return recipe_in(path)


def or_example(path: str | Path) -> Path:
    """The path, or the example that is called so where nothing stands at the path."""
    path = Path(path)
    if path.exists():
        return path
    if str(path) not in EXAMPLES and "#" not in str(path) and (guess := did_you_mean(str(path), EXAMPLES)):
        raise FileError(f"{path}: neither a file nor the name of an example{guess}")
    return EXAMPLES.get(str(path), path)


def recipe_in(path: str | Path) -> Recipe:
    """Return the recipe in a file; without a file, what a capability knows by the text, such as a map of a data set."""
    if not os.path.lexists(path):
        for recipe_of in hooks("targets"):
            recipe: Recipe | None = recipe_of(str(path))
            if recipe:
                return recipe
    return load(path)


def recipe_and_content(path: Path) -> tuple[Recipe, object]:
    """Return the recipe in a file, and the content of the file, as `load` reads it."""
    try:
        content = recipe_content(path)
        return answered(decode, content), content
    except UserError as error:
        if description := _other_file(path):
            raise FileError(f"{path}: {description}") from None
        raise error.of(str(path)) if isinstance(error, ParameterError) else error from None


CERTAINTY = Float(0.5, 0.95, help="probability with which a robot gets across the maps of a recipe")
"""Above 0.95 no number of drives within seconds tells two probabilities apart; below 0.5 a map is not for the robot."""


def answered(make: Callable[[Any], Recipe], content: Any) -> Recipe:
    """Return the recipe that `make` makes of a content; if it asks for a certainty, with the room that this takes.

        crossable_by: crawler:0.9 --drives--> crossable_by: crawler, crossable_room: 0.4

    Lanes are lowered by poses, which have no probability; drives have one, but maps are not to depend on a simulator
    and its version. So drives decide once how much room to spare the lanes need, and a recipe has that.
    """
    asked = content.get("crossable_by") if isinstance(content, Mapping) else None
    if not isinstance(asked, str) or not (parts := asked_certainty(asked)):
        return make(content)
    robot, share = parts
    with inside("crossable_by"):
        certainty = CERTAINTY.check("", CERTAINTY.parse(share))
    if "crossable_room" in content:
        raise ParameterError("crossable_room", f"cannot be set together with {asked}, which finds it")
    recipe = make({**content, "crossable_by": robot})
    for with_certainty in hooks("certainty"):
        with_room: Recipe = with_certainty(recipe, certainty)
        return with_room
    raise ParameterError("crossable_by", f"{asked}: a certainty takes drives, and nothing that drives is installed")


_START = 4096
"""Bytes of a file by which it is known what it is."""


def _other_file(path: Path) -> str:
    """Return what a file is that is no recipe, and what reads it; an empty text if that is not known."""
    if not (start := regular_content(path, _START)):
        return ""
    sort, readers = file_type(start), [reader for reads in hooks("reads") if (reader := reads(path, start))]
    if not sort and not readers:
        return ""
    if (path.parent / "recipe.json").is_file():  # a file of a map, such as its mesh
        readers = [f"its folder, which has one: {path.parent}"]
    return f"{sort or f'a {path.suffix} file'}, and not a recipe{'; use ' if readers else ''}{' or '.join(readers)}"


def recipe_content(path: Path) -> object:
    """Return the content of a YAML or JSON file as plain values; FileError if it cannot be read."""
    most = MAX_RECIPE_MIB.get(path.suffix.lower(), MAX_RECIPE_MIB[".yaml"])
    text = text_of(path, most, f"a recipe (JSON: up to {MAX_RECIPE_MIB['.json']} MiB)")
    return _parse_json(text, path) if path.suffix.lower() == ".json" else parse_yaml(text, path)


def parse_yaml(text: str, path: Path, *, last_counts: bool = False) -> object:
    """Return the content of a YAML text; a FileError for all that rsegen's own files do not have.

    last_counts: of a key that is given twice the last value counts; it is an error without this
    """
    from rsegen.recipe.yaml_loader import Loader  # which imports PyYAML

    try:
        return Loader(text, path, last_counts=last_counts).get_single_data()
    except FileError:
        raise
    except Exception as error:  # PyYAML fails in many ways at values that are not what their tags say
        mark = getattr(error, "problem_mark", None)
        at = f":{mark.line + 1}:{mark.column + 1}" if mark else ""
        raise FileError(f"{path}{at}: not YAML: {parser_message(error)}") from None


def to_yaml(recipe: Recipe) -> str:
    """Return the recipe as the text of a YAML file, obstacles with the keys that they were given."""
    import yaml

    from rsegen.recipe.yaml_loader import Dumper

    content = encode(recipe, derived_keys=False)
    text: str = yaml.dump(
        content, Dumper=Dumper, sort_keys=False, default_flow_style=None, allow_unicode=True, width=120
    )
    return text


def _parse_json(text: str, path: Path) -> object:
    def unique(pairs: list[tuple[str, Json]]) -> dict[str, Json]:
        refuse_duplicates((key, str(path)) for key, _ in pairs)
        return dict(pairs)

    try:
        return json.loads(text, object_pairs_hook=unique)
    except json.JSONDecodeError as error:
        raise FileError(f"{path}:{error.lineno}:{error.colno}: not JSON: {error.msg}") from None
    except (RecursionError, ValueError) as error:
        raise FileError(f"{path}: not a recipe: {parser_message(error)}") from None
