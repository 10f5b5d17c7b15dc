"""rsegen import: a world from heights that come from elsewhere."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Collection, Mapping
from pathlib import Path

from rsegen.cli.flags import Subparsers, add_recipe_flags, add_switch, describe_flag, flag, given, with_flags
from rsegen.cli.generate import add_output_flags, produce
from rsegen.cli.picture_path import picture_path
from rsegen.errors import ParameterError
from rsegen.exporters.pictures.measured import rounding_plot
from rsegen.exporters.pictures.preview import image_format
from rsegen.exporters.scene import compose
from rsegen.io.importers import IMPORTERS, Importer, heights_in, importer_for, recipe_of
from rsegen.params.sorts import Flag, Parameter, parameters
from rsegen.recipe.recipe import Recipe
from rsegen.run.store import write_file


def add(commands: Subparsers) -> None:
    """The parser of this command."""
    command = commands.add_parser(
        "import",
        description="Write a world from a file of heights, each cell a block with vertical sides: a table (CSV), a "
        "numpy array (NPY), a greyscale image (PNG, JPEG, PGM, TIFF), or an occupancy grid of ROS (map.yaml).",
        epilog="The folder of the world has its recipe, which can be opened in the window and generated again.",
    )
    command.add_argument("file", metavar="FILE", help=f"named {', '.join('*' + suffix for suffix in IMPORTERS)}")
    _add_reading_flags(command)
    add_output_flags(command)
    command.add_argument("--errors", metavar="PICTURE", help="draw by how much each height was rounded")
    add_recipe_flags(command, over="FILE")
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Import, generate, and say what was made and how far heights were rounded."""
    path = Path(arguments.file)
    picture = picture_path(arguments.errors, force=arguments.force)
    recipe = given(Recipe, arguments)
    sorts = parameters(Recipe)
    settled = {name: sorts[name].check(name, recipe[name]) for name in ("unit_cm", "chunk_size") if name in recipe}
    heights = heights_in(path, _reading(importer_for(path), arguments), settled.get("unit_cm"))
    found = with_flags(recipe_of(path, heights, settled.get("chunk_size")), arguments)
    if picture and heights.rounding is None:
        raise ParameterError("--errors", f"{path} has levels, which are not rounded")
    produce(found, arguments)
    if picture and heights.errors_cm is not None and heights.holes is not None:
        drawn = rounding_plot(compose(found), heights.errors_cm, heights.holes, image_format(picture))
        write_file([drawn], picture, force=arguments.force)
    if said := str(heights.rounding or ""):
        print(said, file=sys.stderr if arguments.json else sys.stdout)


def _reading(cls: type[Importer], arguments: argparse.Namespace) -> Importer:
    """The format with the options that were given; one that it does not have is an error."""
    for name in _options():
        if name not in parameters(cls) and getattr(arguments, name) is not None:
            flags = ", ".join(flag(own) for own in parameters(cls))
            raise ParameterError(flag(name), f"is not for this file, which is read as {cls.name} (known: {flags})")
    said = given(cls, arguments)
    if (
        arguments.units == "in"
        and "values" not in said
        and "in" in getattr(parameters(cls).get("values"), "values", ())
    ):
        said["values"] = "in"
    return cls(**said)


def _add_reading_flags(command: argparse.ArgumentParser) -> None:
    group = command.add_argument_group("reading")
    for name, option in _options().items():
        text = "; ".join(f"{', '.join(kinds)}: {said}" for said, kinds in _meanings(name).items())
        if isinstance(option, Flag):
            add_switch(group, name, text)
        else:
            group.add_argument(flag(name), dest=name, metavar=name.upper(), help=text)


def _meanings(name: str) -> Mapping[str, Collection[str]]:
    """What the help says of an option, and the formats of which it says so."""
    found: dict[str, dict[str, None]] = {}
    for cls in IMPORTERS.values():
        if option := parameters(cls).get(name):
            values, text = describe_flag(name, option)
            said = text if isinstance(option, Flag) or not values.startswith("{") else f"{values}: {text}"
            found.setdefault(said, {})[cls.name] = None
    return found


def _options() -> Mapping[str, Parameter]:
    """The options of all formats by name."""
    return {name: option for cls in IMPORTERS.values() for name, option in parameters(cls).items()}
