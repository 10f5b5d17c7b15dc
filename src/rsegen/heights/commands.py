"""The command `rsegen import`."""

from __future__ import annotations

import argparse
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from rsegen.cli.flags import (
    add_recipe_flags,
    recipe_flags,
    with_flags,
)
from rsegen.cli.generate import add_output_flags, produce
from rsegen.cli.parser import Parser
from rsegen.cli.report import Report
from rsegen.errors import ParameterError
from rsegen.params.command import Declared, Shell, add_flag, add_flags, declared, given
from rsegen.params.numbers import counted, decimal, lengths_in
from rsegen.params.sorts import CENTIMETRES, FilePath, Flag, parameters
from rsegen.pictures.flags import picture_of
from rsegen.recipe.recipe import Recipe

if TYPE_CHECKING:
    from rsegen.heights.base import Heights, Importer


@dataclass(frozen=True, kw_only=True, slots=True)
class _Errors:
    """Write a world from a file of heights, each cell a block with vertical sides."""

    errors: Annotated[
        str | None,
        FilePath("a picture", help="draw the rounding error of each height"),
        Shell(metavar="PICTURE"),
    ] = None


def add_import(command: Parser) -> None:
    """Add the flags of `rsegen import`."""
    from rsegen.heights.base import IMPORTERS

    epilog = "A table (CSV), a numpy array (NPY), a greyscale image (PNG, JPEG, PGM, TIFF), an occupancy grid of ROS "
    epilog += "(map.yaml), or a bag of ROS with grid maps (needs rsegen[bag]). "
    epilog += "The folder of the world has its recipe, which can be opened on the page and generated again."
    command.explain(_Errors.__doc__, epilog)
    command.add_argument("file", metavar="FILE", help=f"a file: {', '.join('*' + suffix for suffix in IMPORTERS)}")
    _add_reading_flags(command)
    add_output_flags(command)
    add_flags(command, _Errors)
    add_recipe_flags(command, over="FILE")


def run_import(arguments: argparse.Namespace) -> Report:
    """Import a file, generate the map, and report what was made and how far heights were rounded."""
    from rsegen.heights.base import heights_in, importer_for, recipe_of_heights
    from rsegen.heights.pictures import rounding_plot
    from rsegen.scene.scene import compose

    path, picture = Path(arguments.file), picture_of(arguments.errors, force=arguments.force)
    # Two parameters of the recipe decide how heights are read: the unit, of which levels are made, and the chunk size.
    given_values, sorts = recipe_flags(arguments), parameters(Recipe)
    settled = {
        name: sorts[name].check(name, given_values[name]) for name in ("unit_cm", "chunk_size") if name in given_values
    }
    reading = _reading(importer_for(path), arguments)
    heights = heights_in(path, reading, settled.get("unit_cm"))
    recipe = with_flags(recipe_of_heights(path, heights, settled.get("chunk_size")), arguments)
    if picture and heights.rounding is None:
        raise ParameterError("--errors", f"{path} has levels, which are not rounded")
    report = produce(recipe, arguments)
    if picture and heights.errors_cm is not None and heights.holes is not None:
        picture.write(partial(rounding_plot, compose(recipe), heights.errors_cm, heights.holes))
    notes = [text] if (text := str(heights.rounding or "")) else []
    if heights.unknown:
        notes.append(
            f"{counted(heights.unknown, 'cell')} transparent or without data, so unknown: no block stands there"
        )
    notes += _other_unit(heights, getattr(reading, "values", ""))
    return replace(report, notes=[*notes, *_width(heights, recipe, is_given="block_width_cm" in given_values)])


_SAME_UNIT = 1e-4
"""Share by which two units differ that count as one, such as both kinds of feet."""


def _other_unit(heights: Heights, values: str) -> Iterator[str]:
    """Yield a line if the file says that its heights are in another unit than in the one that the user says."""
    of_file, read = heights.metres_up, CENTIMETRES.get(values, 0) / 100
    if of_file and read and abs(read / of_file - 1) > _SAME_UNIT:
        near = (name for name, length in CENTIMETRES.items() if abs(length / 100 / of_file - 1) <= _SAME_UNIT)
        unit = next(near, f"{decimal(round(of_file, 6))} m")
        yield f"warning: heights are read in {values}, and by the file their unit is {unit} (--values)"


def _width(heights: Heights, recipe: Recipe, *, is_given: bool) -> Iterator[str]:
    """Yield a line on the width of blocks, if the file says how wide its cells are and the user does not."""
    if heights.sides is None or is_given:
        return
    width = lengths_in(recipe.units).with_unit(recipe.block_width_cm / 100, 3)
    if "block_width_cm" in heights.recipe_values:
        yield f"blocks are {width} wide, as the file says (--block-width-cm if they are not)"
        return
    metres = heights.sides.metres
    of_blocks = " x ".join(decimal(round(side * (metres or 1), 6)) for side in heights.sides[:2])
    unit = "in a unit that it does not say" if metres is None else "m"
    yield f"warning: blocks are {width} wide, and in the file they are {of_blocks} {unit} (--block-width-cm)"


def _reading(cls: type[Importer], arguments: argparse.Namespace) -> Importer:
    """Return the importer with the options that were given; one that it does not have is an error."""
    for name, option in _options().items():
        if name not in parameters(cls) and getattr(arguments, name) is not None:
            flags = ", ".join(known.flags[-1] for known in declared(cls).values()) or "none"
            raise ParameterError(
                option.flags[-1], f"is not for this file, which is read as {cls.name} (known: {flags})"
            )
    given_values = given(cls, arguments, arguments.units)
    values: Any = parameters(cls).get("values")
    if arguments.units == "in" and "values" not in given_values and "in" in getattr(values, "values", ()):
        given_values["values"] = "in"
    return cls(**given_values)


def _add_reading_flags(command: Parser) -> None:
    group = command.group("reading")
    for name, option in _options().items():
        text = "; ".join(f"{', '.join(kinds)}: {meaning}" for meaning, kinds in _meanings(name).items())
        is_switch = isinstance(option.sort, Flag)
        options = {"action": "store_const", "const": True} if is_switch else {"metavar": name.upper()}
        action = add_flag(group, option._replace(default=None), text, **options)
        action.completer = None  # its words depend on the file


def _meanings(name: str) -> Mapping[str, Collection[str]]:
    """Return the help texts of an option, each with the formats that have it."""
    from rsegen.heights.base import IMPORTERS

    formats: dict[str, dict[str, None]] = {}
    for cls in IMPORTERS.values():
        if option := declared(cls).get(name):
            listed = option.metavar.startswith("{") and not isinstance(option.sort, Flag)
            text = option._replace(default=None).help
            formats.setdefault(f"{option.metavar}: {text}" if listed else text, {})[cls.name] = None
    return formats


def _options() -> Mapping[str, Declared]:
    """Return the options of all formats by name."""
    from rsegen.heights.base import IMPORTERS

    return {name: option for cls in IMPORTERS.values() for name, option in declared(cls).items()}
