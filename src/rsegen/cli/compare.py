"""rsegen compare: which blocks differ between what stands and a map."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from rsegen.cli.flags import PictureName, add_target_recipe_flags, map_of_flags, picture_of, which_map
from rsegen.cli.parser import Parser
from rsegen.cli.report import Report
from rsegen.commands.parameters import Force
from rsegen.errors import ParameterError
from rsegen.exporters.numbers import Lengths, lengths_in
from rsegen.io.scan_options import ScanOptions
from rsegen.params.command import Shell, add_flags, given
from rsegen.params.sorts import parameters
from rsegen.recipe.recipe import Recipe

if TYPE_CHECKING:
    from rsegen.io.scans import ComparedMap
    from rsegen.scanning.comparison import Comparison

_KNOWN = frozenset({*parameters(Recipe), "size", "fill_holes"})
"""Options of a scan that the map decides."""

_SHOWN = 20
"""Blocks that a report names."""


@dataclass(frozen=True, kw_only=True, slots=True)
class _Drawing:
    """Print, and draw, which blocks of a real field or of a map differ from those of MAP."""

    output: Annotated[PictureName, Shell(help="draw what to change: png, svg or pdf, by its ending")] = None
    force: Force = False


def add_compare(command: Parser) -> None:
    """Add the flags of `rsegen compare`."""
    epilog = "A scan may be turned and moved. Exit code 0: all blocks are right; 1: some differ, or were not seen."
    command.explain(_Drawing.__doc__, epilog)
    command.add_argument(
        "paths",
        nargs="+",
        metavar="SCAN-or-MAP",
        help="point clouds or depth images of one field, as for rsegen scan, or a map; MAP, the last, is what should "
        "stand: a recipe, an example, the folder of a map",
    )
    command.add_argument("--map", metavar="INDEX", help="which map, by its index or its name (default: the first)")
    add_flags(command.add_argument_group("output"), _Drawing)
    add_flags(command.add_argument_group("reading a scan"), ScanOptions, without=_KNOWN)
    add_target_recipe_flags(command)


def run_compare(arguments: argparse.Namespace) -> Report:
    """Compare and draw; the exit code is 1 if anything differs or was not seen."""
    from rsegen.exporters.pictures.measured import summary
    from rsegen.io.resources import refuse_too_large

    *stands, wanted = arguments.paths
    if not stands:
        raise ParameterError("MAP", f"only {wanted} is given; give a scan or a map, and then the map that should stand")
    picture = picture_of(arguments.output, force=arguments.force)
    arguments.target = wanted
    _, recipe, index = map_of_flags(arguments)
    refuse_too_large(recipe)
    compared = _compared(stands, arguments, recipe.alone(index))
    if picture:
        picture.write(compared.picture)
    comparison = compared.comparison
    lines = [summary(comparison), *_lines(comparison, lengths_in(recipe.units))]
    notes = [line for path in dict.fromkeys(arguments.paths) for line in which_map(path, arguments.map)]
    return Report(lines=lines, content=_content(comparison), notes=notes, code=0 if comparison.is_equal else 1)


def _compared(stands: list[str], arguments: argparse.Namespace, recipe: Recipe) -> ComparedMap:
    from rsegen.io.clouds import is_cloud
    from rsegen.io.resources import refuse_too_large
    from rsegen.io.scans import compare
    from rsegen.io.targets import chosen_map

    clouds = [path for path in stands if is_cloud(Path(path))]
    if clouds and len(clouds) == len(stands):
        said = given(ScanOptions, arguments, arguments.units)
        options = {name: value for name, value in said.items() if name not in _KNOWN}
        return compare(clouds, recipe, ScanOptions(**options))
    if len(stands) > 1:
        raise ParameterError("SCAN-or-MAP", "give clouds of one field and a map, or two maps")
    _, other, index = chosen_map(stands[0], arguments.map, "--map")
    refuse_too_large(other)
    return compare(other.alone(index), recipe)


def _lines(comparison: Comparison, written: Lengths) -> Iterator[str]:
    changes = list(comparison.changes())
    if changes:
        yield "x and y count the blocks of MAP from its south-west corner without frames, as on its build sheet"
    for x, y, height, wanted in changes[:_SHOWN]:
        way = "too high" if height > wanted else "too low"
        stands, right = (written.said(metres, 1) for metres in (height, wanted))
        i, j = _numbers(comparison, x, y)
        cell = f"frame, cell {x}, {y} with frames counted" if i is None else f"x {i} y {j}"
        yield f"  {cell}: {stands}, should be {right} ({way})"
    if len(changes) > _SHOWN:
        yield f"  and {len(changes) - _SHOWN} more"


def _numbers(comparison: Comparison, x: int, y: int) -> tuple[int, int] | tuple[None, None]:
    """Return the numbers of a block as recipes and build sheets count them; of a frame there are none."""
    field = comparison.wanted
    return (None, None) if field.frame[x, y] else (int(field.numbered(0)[x]), int(field.numbered(1)[y]))


def _content(comparison: Comparison) -> dict[str, object]:
    """Return the comparison for programs; lengths in metres.

    x, y: as the text has them, of blocks in MAP, none for a frame; cell: of all cells of MAP, frames counted; turns:
    quarter turns counterclockwise that lay what stands on MAP.
    """
    return {
        "cells": comparison.wrong.size,
        "wrong": int(comparison.wrong.sum()),
        "not_seen": int((~comparison.seen).sum()),
        "turns": comparison.turns,
        "differences": [
            dict(zip("xy", _numbers(comparison, x, y), strict=True))
            | {"cell": [x, y], "height_m": round(height, 4), "wanted_m": wanted}
            for x, y, height, wanted in comparison.changes()
        ],
    }
