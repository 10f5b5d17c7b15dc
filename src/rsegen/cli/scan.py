"""rsegen scan: the world of a field that stands somewhere, from a point cloud of it."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator

import numpy as np

from rsegen.cli.flags import Subparsers, add_parameter_flags, add_recipe_flags, add_switch, given, with_flags
from rsegen.cli.generate import add_output_flags, produce
from rsegen.cli.picture_path import picture_path
from rsegen.exporters.pictures.preview import image_format
from rsegen.field.stepfield import Mask
from rsegen.io.clouds import READERS
from rsegen.io.scans import ScannedMap, ScanOptions, scan
from rsegen.params.sorts import parameters
from rsegen.recipe.recipe import Recipe
from rsegen.run.store import write_file
from rsegen.scanning import SURE

_SHOWN = 8
_MOST_PALLETS = 30
"""Of a build sheet that is written unasked: a field of 11 x 10 blocks has 110 square chunks of a single block."""


def add(commands: Subparsers) -> None:
    """The parser of this command."""
    command = commands.add_parser(
        "scan",
        description="Write the world, recipe and build sheet of a field that stands somewhere, from a point cloud or a "
        "depth image of it with some floor around: finds the ground, the grid of blocks and the level of every block.",
        epilog="Several files are views of one field in one common frame. PLY, PCD and mesh files need rsegen[scan].",
    )
    names = ", ".join("*" + name for name in READERS)
    command.add_argument("clouds", nargs="+", metavar="CLOUD", help=f"named {names}")
    group = command.add_argument_group("reading", "what is not given is found from the cloud")
    add_parameter_flags(group, ScanOptions, without=(*parameters(Recipe), "fill_holes"))
    add_switch(group, "fill_holes", parameters(ScanOptions)["fill_holes"].help)
    add_output_flags(command)
    text = "draw the grid, levels and residuals that were found (default: DIR/NAME_fit.png)"
    command.add_argument("--fit", metavar="PICTURE", help=text)
    add_recipe_flags(command, over="CLOUD")
    command.set_defaults(run=run, sheet=None)


def run(arguments: argparse.Namespace) -> None:
    """Find the field, write the picture of the fit and the world, and say what was found."""
    options = ScanOptions(**given(ScanOptions, arguments))
    fit = picture_path(arguments.fit, force=arguments.force)
    found = scan(arguments.clouds, options)
    recipe = with_flags(found.recipe, arguments)
    name = f"{recipe.name}_fit.png"
    pallets = recipe.chunks[0] * recipe.chunks[1]
    arguments.sheet = arguments.sheet or pallets <= _MOST_PALLETS
    produce(recipe, arguments, {} if fit else {name: found.picture})
    if fit:
        write_file([found.picture(image_format(fit))], fit, force=arguments.force)
    lines = [*_report(found), f"the fit: {fit or arguments.output / name}"]
    if not arguments.sheet:
        lines.append(f"no build sheet: it would have a page for each of {pallets} chunks; --sheet writes it")
    print("\n".join(lines), file=sys.stderr if arguments.json else sys.stdout)


def _report(found: ScannedMap) -> Iterator[str]:
    scan = found.scan
    n_x, n_y = scan.blocks.shape
    frames = "no frames" if scan.boundary == "none" else f"{scan.boundary} frames {scan.frame_height * 100:.3g} cm high"
    yield (
        f"{len(found.points):,} points: {n_x} x {n_y} blocks {scan.block_width * 100:g} cm wide "
        f"({scan.measured_width * 100:.2f} measured), unit {scan.unit * 100:g} cm "
        f"({scan.measured_unit * 100:.2f} measured), {frames}"
    )
    errors = np.abs(scan.errors[scan.seen]) * 100
    yield f"tops are {errors.mean():.2f} cm from their levels in the mean, {errors.max():.2f} cm at most"
    if not scan.seen.all():
        level = "are filled from their neighbours" if found.recipe.obstacles[1:] else "get level 0"
        yield f"warning: not seen: {_cells(found, ~scan.seen)}; blocks among them {level}"
    unsure = scan.seen & (scan.confidence < SURE)
    if unsure.any():
        yield f"warning: less than {SURE:.0%} sure: {_cells(found, unsure)}"


def _cells(found: ScannedMap, chosen: Mask) -> str:
    """How many cells, and the first of them as recipes count them."""
    cells = [tuple(cell) for cell in np.argwhere(chosen & ~found.scan.frame).tolist()]
    numbers_x, numbers_y = (found.scan.field.numbered(axis) for axis in (0, 1))
    names = ", ".join(f"x {numbers_x[x]} y {numbers_y[y]}" for x, y in cells[:_SHOWN])
    more = f" and {len(cells) - _SHOWN} more" if len(cells) > _SHOWN else ""
    return f"{int(chosen.sum())} of {chosen.size} cells" + (f" ({names}{more})" if names else "")
