"""The flags of commands that look at maps: where the maps are or a recipe of them, and the maps that they stand for."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Collection, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

from rsegen.cli.flags import add_input, has_recipe_flags, with_flags
from rsegen.cli.parser import Parser
from rsegen.errors import ParameterError
from rsegen.params.command import Shell
from rsegen.params.sorts import FilePath
from rsegen.recipe.recipe import Recipe

if TYPE_CHECKING:
    from rsegen.exporters.scene import Scene
    from rsegen.io.targets import ChosenMap

_WHERE = "a recipe (YAML, JSON), the name of an example, the folder of a map, a folder of maps, or DIR#17 of a data set"


def add_target_flags(command: Parser, default: str = "the first") -> None:
    """Add where to look, and which map; `add_target_recipe_flags` adds what makes a map of flags alone."""
    group = command.add_argument_group("input")
    add_input(group, f"{_WHERE}; or none, but --obstacle", name="target", metavar="RECIPE-or-DIR")
    group.add_argument("--map", metavar="INDEX", help=f"which map, by its index or its name (default: {default})")


def is_of_flags(arguments: argparse.Namespace) -> bool:
    """Return whether a map is to be made of flags, alone or over a target's; ParameterError if nothing is given."""
    if arguments.target is None and not arguments.obstacle:
        raise ParameterError("RECIPE", "nothing is given; give a recipe, a folder or --obstacle 'random levels=5'")
    return has_recipe_flags(arguments)


def recipes_of(arguments: argparse.Namespace) -> Iterator[tuple[Path, Recipe]]:
    """Yield each recipe of the target with the flags over it, and its file; without a target that of the flags."""
    from rsegen.io.targets import recipe_files, recipe_in

    flags, target = is_of_flags(arguments), arguments.target
    if target is None:
        yield Path(), with_flags(Recipe(), arguments)
        return
    for file in recipe_files(target):
        recipe = recipe_in(file)
        yield file, with_flags(recipe, arguments) if flags else recipe


def map_of_flags(arguments: argparse.Namespace) -> ChosenMap:
    """Return one map of them: the one that --map names, or the first."""
    from rsegen.io.targets import one_of

    return one_of(recipes_of(arguments), arguments.map, arguments.target or "the recipe of the flags", "--map")


def maps_of_flags(arguments: argparse.Namespace) -> Iterator[Recipe]:
    """Yield the recipes of all their maps, or of the one that --map names."""
    if arguments.map is None:
        yield from (recipe for _, recipe in recipes_of(arguments))
        return
    _, recipe, index = map_of_flags(arguments)
    yield recipe.alone(index)


def target_of(arguments: argparse.Namespace, without: Collection[str] = ()) -> Recipe | str:
    """Return the target as given, or the recipe of one map if flags make one; some flags are the command's own."""
    own = argparse.Namespace(**{name: value for name, value in vars(arguments).items() if name not in without})
    if not is_of_flags(own):
        return str(arguments.target)
    _, recipe, index = map_of_flags(own)
    return recipe.alone(index)


def scene_of(arguments: argparse.Namespace) -> Scene:
    """Return the scene of that map."""
    from rsegen.exporters.scene import compose
    from rsegen.io.resources import refuse_too_large

    _, recipe, index = map_of_flags(arguments)
    refuse_too_large(recipe)
    return compose(recipe, index)


def which_map(target: str | None, which: str | None) -> Iterator[str]:
    """Yield a line on the map that a command took, if it is the first of a folder and nobody chose it."""
    from rsegen.io.targets import recipe_files

    files = recipe_files(target) if target is not None and which is None else []
    if len(files) > 1:
        yield f"note: {files[0].parent.name} is the first of {len(files)} maps in {target}; --map takes another"


PictureName = Annotated[str | None, FilePath("a picture"), Shell(("-o", "--output"), "PICTURE")]
"""The flag for a picture that a command draws besides its report; each says of what."""


class Picture(NamedTuple):
    """A picture that a command is asked for; `picture_of` has found that its name is one, and may be written."""

    path: Path
    force: bool

    def write(self, draw: Callable[[str], bytes]) -> None:
        """Write what `draw` makes for the image format of the name."""
        from rsegen.exporters.pictures.preview import image_format
        from rsegen.run.store import write_file

        write_file([draw(image_format(self.path))], self.path, force=self.force)


def picture_of(name: str | None, *, force: bool | None) -> Picture | None:
    """Return the picture of a name if one is wanted; a UserError if it is no picture or may not be replaced."""
    from rsegen.exporters.pictures.preview import image_format
    from rsegen.run.store import refuse_taken_file

    if name is None:
        return None
    picture = Picture(Path(name), bool(force))
    image_format(picture.path)
    refuse_taken_file(picture.path, force=picture.force)
    return picture
