"""rsegen import: a world from heights that come from elsewhere."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path

from rsegen.cli.flags import Subparsers, add_recipe_flags, flag, given, with_flags
from rsegen.cli.generate import add_output_flags, produce
from rsegen.errors import ParameterError
from rsegen.io.importers import IMPORTERS, Importer, imported, importer_for
from rsegen.params.sorts import Flag, Parameter, parameters
from rsegen.recipe.recipe import Recipe


def add(commands: Subparsers) -> None:
    """The parser of this command."""
    command = commands.add_parser(
        "import",
        help="write a world from measured heights, an image or a map of ROS",
        description="Write a world from heights that come from elsewhere, with vertical risers: a table (CSV), a numpy "
        "array (NPY), a grey image (PNG, JPEG, PGM, TIFF), an occupancy map of ROS (map.yaml).",
        epilog="The recipe is written beside the world, and can be opened in the window and generated again.",
    )
    command.add_argument("file", metavar="FILE", help=f"named {', '.join('*' + suffix for suffix in IMPORTERS)}")
    _add_reading_flags(command)
    add_output_flags(command)
    add_recipe_flags(command, over="FILE")
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Import, generate, and say what was made."""
    path = Path(arguments.file)
    recipe = given(Recipe, arguments)
    sorts = parameters(Recipe)
    settled = {name: sorts[name].check(name, recipe[name]) for name in ("unit_cm", "chunk_size") if name in recipe}
    start = imported(path, _reading(importer_for(path), arguments), **settled)
    produce(with_flags(start, arguments), arguments)


def _reading(cls: type[Importer], arguments: argparse.Namespace) -> Importer:
    """The format with the options that were given; one that it does not have is an error."""
    for name in _options():
        if name not in parameters(cls) and getattr(arguments, name) is not None:
            flags = ", ".join(flag(own) for own in parameters(cls))
            raise ParameterError(flag(name), f"is not for this file, which is read as {cls.name} (known: {flags})")
    return cls(**given(cls, arguments))


def _add_reading_flags(command: argparse.ArgumentParser) -> None:
    group = command.add_argument_group("reading")
    for name, option in _options().items():
        kinds = dict.fromkeys(cls.name for cls in IMPORTERS.values() if name in parameters(cls))
        text = f"{', '.join(kinds)}: {option.help}".replace("%", "%%")
        if isinstance(option, Flag):
            group.add_argument(flag(name), dest=name, action="store_const", const="yes", help=text)
        else:
            values = option.describe().replace("%", "%%")
            group.add_argument(flag(name), dest=name, metavar=name.upper(), help=f"{text} ({values})")


def _options() -> Mapping[str, Parameter]:
    """The options of all formats by name."""
    return {name: option for cls in IMPORTERS.values() for name, option in parameters(cls).items()}
