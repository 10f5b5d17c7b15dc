"""The commands that read clouds: scan, which writes a world of one, and compare."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from rsegen.cli.flags import (
    add_recipe_flags,
    add_target_recipe_flags,
    map_of_flags,
    which_map,
    with_flags,
)
from rsegen.cli.generate import add_output_flags, produce
from rsegen.cli.parameters import Force
from rsegen.cli.parser import Parser
from rsegen.cli.report import Report
from rsegen.errors import ParameterError
from rsegen.params.command import Shell, add_flags, given
from rsegen.params.numbers import Lengths, decimal, lengths_in
from rsegen.params.sorts import FilePath, parameters
from rsegen.pictures.flags import PictureName, picture_of
from rsegen.recipe.recipe import Recipe
from rsegen.scanning.scan_options import CLOUDS, ScanOptions
from rsegen.writing.sidecars import chosen_sidecars

if TYPE_CHECKING:
    from rsegen.field.stepfield import Mask
    from rsegen.scanning.comparison import Comparison
    from rsegen.scanning.scan import Scan
    from rsegen.scanning.scans import ComparedMap, ScannedMap


_SHOWN = 8
"""Cells that a warning names."""


_MOST_PALLETS = 30
"""Most pallets of a build sheet that is written unasked: 11 x 10 blocks have 110 square chunks of a single block."""


@dataclass(frozen=True, kw_only=True, slots=True)
class _Fit:
    """Write the world, recipe and build sheet of a real field, from a point cloud or a depth image of it."""

    fit: Annotated[
        str | None,
        FilePath("a picture", help="draw the grid, levels and residuals that were found"),
        Shell(metavar="PICTURE", default="DIR/NAME_fit.png"),
    ] = None


def add_scan(command: Parser) -> None:
    """Add the flags of `rsegen scan`."""
    epilog = "The cloud must show some floor around the field; rsegen finds the ground, the grid and all levels. "
    epilog += (
        "Several files are views or parts of one field in one common frame. PLY, PCD and mesh files need rsegen[scan]."
    )
    command.explain(_Fit.__doc__, epilog)
    command.add_argument(
        "clouds", nargs="+", metavar="CLOUD", help=f"files: {', '.join('*' + name for name in CLOUDS)}"
    )
    group = command.group("reading", "values that you do not set are estimated from the cloud")
    add_flags(group, ScanOptions, without=parameters(Recipe))
    add_output_flags(command)
    add_flags(command, _Fit)
    add_recipe_flags(command, over="CLOUD")


def run_scan(arguments: argparse.Namespace) -> Report:
    """Find the field, write the picture of the fit, the confidences and the world, and say what was found."""
    from rsegen.scanning.scan_report import confidence_csv, scan_content
    from rsegen.scanning.scans import scan

    options = ScanOptions(**given(ScanOptions, arguments, arguments.units))
    fit = picture_of(arguments.fit, force=arguments.force)
    scanned = scan(arguments.clouds, options)
    # Flags of recipes change the world around the field that was found, not the field.
    recipe = with_flags(scanned.recipe, arguments)
    scanned = replace(scanned, recipe=recipe)  # its picture has the units of the flags
    name, sure = f"{recipe.name}_fit.png", f"{recipe.name}_confidence.csv"
    no_sheet = "" if arguments.sheet else _no_sheet(recipe)
    arguments.sheet = not no_sheet
    where = fit.path if fit else f"{arguments.folder}/{name}"
    files = {"fit": str(where), "confidence": f"{arguments.folder}/{sure}"}
    beside: dict[str, Callable[[], bytes]] = {
        sure: partial(confidence_csv, scanned.scan),
        **({} if fit else {name: scanned.picture}),
    }
    lines = [*_report(scanned, options, lengths_in(recipe.units))]
    doubts = [
        line for line in lines if line.startswith(("assumed: ", "warning: "))
    ]  # programs have figures of the rest
    content = scan_content(scanned.scan, len(scanned.points), scanned.left_out)
    report = produce(recipe, arguments, beside, {"scan": content | {"notes": doubts, "files": files}})
    if fit:
        fit.write(scanned.picture)
    lines.append(f"the fit: {where}")
    lines.append(f"the confidence of each level, 0 where a block was not seen: {files['confidence']}")
    if no_sheet:
        lines.append(f"no build sheet: {no_sheet}")
    return replace(report, notes=lines)


def _no_sheet(recipe: Recipe) -> str:
    """Return why no build sheet is written unasked; nothing if one is."""
    pallets = recipe.chunks[0] * recipe.chunks[1]
    if pallets > _MOST_PALLETS:
        return f"it would have a page for each of {pallets} chunks; --sheet writes it"
    try:
        for sidecar in chosen_sidecars({"sheet": True}):
            sidecar.refuse(recipe)
    except ParameterError as error:
        return str(error)
    return ""


def _report(scanned: ScannedMap, options: ScanOptions, written: Lengths) -> Iterator[str]:
    import numpy as np

    from rsegen.scanning.scan import SURE

    scan = scanned.scan
    n_x, n_y = scan.blocks.shape
    high, unit, width = (written.with_unit(metres, 3) for metres in (scan.frame_height, scan.unit, scan.block_width))
    frames = "no frames" if scan.boundary == "none" else f"{scan.boundary} frames {high} high"
    yield (
        f"{len(scanned.points):,} points: {n_x} x {n_y} blocks {width} wide "
        f"({written.measured(scan.measured_width)} measured), unit {unit} "
        f"({written.measured(scan.measured_unit)} measured), {frames}"
    )
    if scanned.left_out:
        all_points = len(scanned.points) + scanned.left_out
        yield f"left out: {scanned.left_out:,} of {all_points:,} points, of other things than the field on its floor"
    if scanned.doubt:
        yield f"warning: {scanned.doubt}"
    yield from _other_axis(scanned, options)
    yield from _side(scan)
    # Then what was assumed and what is doubtful, each with the flag that settles it.
    if options.block_width_cm is None:
        yield from _doubt(scan)
        yield from _assumed("blocks", scan.block_width, scan.measured_width, "--block-width-cm")
        yield from _width(scan, width)
        yield from _other_width(scan, options, written)
    if options.unit_cm is None and abs(scan.unit - scan.block_width) > 1e-6:
        yield from _assumed("a unit", scan.unit, scan.measured_unit, "--unit-cm")
    yield from _rim(scan, options, written)
    yield from _board(scan, options, written)
    yield from _size(scan) if options.size is None else _place(scan)
    errors = np.abs(scan.errors[scan.seen])
    mean, most = (written.with_unit(float(error)) for error in (errors.mean(), errors.max()))
    yield f"tops are {mean} from their levels on average, {most} at most"
    if not scan.seen.all():
        level = "are filled from their neighbours" if scanned.recipe.obstacles[1:] else "get level 0"
        yield f"warning: not seen: {_cells(scanned, ~scan.seen)}; blocks among them {level}"
    unsure = scan.seen & (scan.confidence < SURE)
    if unsure.any():
        yield f"warning: less than {SURE:.0%} sure: {_cells(scanned, unsure)}"


def _size(scan: Scan) -> Iterator[str]:
    """Yield lines if the field may be smaller or larger than it was found."""
    from rsegen.scanning.evidence import rows_may_follow

    # Smaller, by things at its sides; then larger, by what is raised beyond rows, what is level, what was not seen.
    for side, (raised, cells) in scan.sparse_edges.items():
        yield (
            f"warning: {raised} of {cells} cells of the {side} side are raised: if they are no part of the field, "
            "set --size, or cut them out of the cloud"
        )
    if scan.beside:
        yield (
            f"warning: {scan.beside} cells near the field are as high as blocks: if they are a part of it, beyond rows "
            "at level 0, set --size"
        )
    if scan.whole:
        whole, (n_x, n_y) = "x".join(map(str, scan.whole)), scan.levels.shape
        yield (
            f"assumed: floor around {n_x} x {n_y} blocks, though it ends at lines of the grid as blocks would "
            f"(--size {whole} if it is blocks at level 0)"
        )
    elif why := rows_may_follow(scan):
        n_x, n_y = scan.blocks.shape
        yield (
            f"assumed: {n_x} x {n_y} blocks are the whole field; rows at level 0 next to them would look like floor, "
            f"and {why} (--size if there are some)"
        )
    for side in scan.open_sides:
        yield (
            f"warning: almost no cells next to the {side} side were seen: if the field goes on there, set --size, "
            "or a scan that shows the floor next to it"
        )


def _place(scan: Scan) -> Iterator[str]:
    """Yield a line if a field of a given size may as well be a row farther, as its sides look like floor."""
    level = [name for name, cells in scan.sides.items() if not cells.any()]
    if level and not scan.frame.any():
        yield (
            "assumed: what is raised is in the middle of the field, as rows at level 0 look like floor, here at "
            f"{' and '.join(level)} (else move the levels in the recipe)"
        )


def _other_axis(scanned: ScannedMap, options: ScanOptions) -> Iterator[str]:
    """Yield a line if more of a mesh is seen from another axis than from the one that is given as up."""
    if scanned.clearer_up is not None:
        given_as, other = f"{options.up}, which is given as up", scanned.clearer_up
        yield f"warning: the mesh shows less from {given_as}, than from {other} (--up)"


def _side(scan: Scan) -> Iterator[str]:
    """Yield a line if nothing tells which side of a field is up, or where level 0 is."""
    if scan.is_up_assumed:
        z, axis = scan.rotation[2], int(abs(scan.rotation[2]).argmax())
        up, down = ("xyz"[axis], f"-{'xyz'[axis]}") if z[axis] > 0 else (f"-{'xyz'[axis]}", "xyz"[axis])
        yield (
            f"assumed: {up} is up, and the lowest tops are at level 0, as no floor around the field tells it "
            f"(--up={down} if it is not)"
        )
    elif not scan.has_floor:
        yield (
            "assumed: the lowest tops are at level 0, as no floor around the field tells it "
            "(else all levels are too low: scan some floor too)"
        )


_DOUBTFUL = 0.5
"""Share of the cells next to frames that are as high as these from which on they may be blocks."""


_BUILT = (0.01, 1.0)
"""Widths in metres of blocks that people build with: toys and full size; others are in another unit, or no blocks."""


def _doubt(scan: Scan) -> Iterator[str]:
    """Yield a line if something that is no field of blocks would look the same."""
    from rsegen.scanning.evidence import CERTAIN, FEWEST_BITS, bits_saved, stepped_lines

    lines = stepped_lines(scan)
    if lines.confidence >= CERTAIN or bits_saved(scan) < FEWEST_BITS:  # of these `_width` says that little shows them
        return
    why, looks = f"heights change at only {lines.stepped} of {lines.seen} lines between cells", "stairs, furniture"
    if lines.alone:
        why, looks = "no two raised cells touch", "pins, keys or houses on a grid"
    yield (
        f"warning: perhaps no field of blocks: {why}, and {looks} or a part of a machine would look the same "
        "(--block-width-cm if it is a field)"
    )


def _width(scan: Scan, width: str) -> Iterator[str]:
    """Yield lines if few sides show how wide blocks are, or if nobody builds with such blocks."""
    from rsegen.scanning.evidence import FEWEST_BITS, bits_saved

    if bits_saved(scan) < FEWEST_BITS:
        yield (
            f"assumed: blocks {width} wide, though too few of their sides have a step to tell it "
            "(--block-width-cm if they are not)"
        )
    if not _BUILT[0] <= scan.measured_width <= _BUILT[1]:
        yield (
            f"warning: blocks {width} wide: if they are not, set the unit of the numbers (--values mm, cm or in); "
            "something else that is on a grid, as a part with holes or bosses, looks like blocks too"
        )


def _other_width(scan: Scan, options: ScanOptions, written: Lengths) -> Iterator[str]:
    """Yield a line if wider or narrower blocks of the given size would look the same."""
    from rsegen.scanning.evidence import cells_per_block, times_narrower

    if options.size is None:
        return
    width = written.with_unit(scan.block_width, 3)
    for times, why in (
        (cells_per_block(scan), "as what is raised then reaches from side to side, though steps are wider"),
        (1 / times_narrower(scan), "though narrower ones would reach from side to side of the size"),
    ):
        if times != 1:
            other = decimal(round(scan.block_width * times * 100, 3))
            yield f"assumed: blocks {width} wide, {why} (--block-width-cm {other} if they are not)"


def _rim(scan: Scan, options: ScanOptions, written: Lengths) -> Iterator[str]:
    """Yield a line if frames may be blocks, or a rim of blocks may be frames: both look the same."""
    import numpy as np

    from rsegen.scanning.extent import share_as_high

    if options.boundary is not None or options.size is not None or min(scan.levels.shape) < 3:
        return
    # Blocks that may be a frame; a rim of one level is none if the blocks next to it are as high.
    if not scan.frame.any():
        inside = np.zeros([side - 2 for side in scan.levels.shape], dtype=bool)
        rim = np.unique(scan.levels[np.pad(inside, 1, constant_values=True) & scan.seen])
        if len(rim) == 1 and rim[0] > 0:
            high = written.with_unit(float(rim[0]) * scan.unit, 3)
            yield (
                f"assumed: no frames, as most blocks next to the rim are {high} high too "
                "(--boundary outer or divided if the rim is a frame)"
            )
        return
    # A frame that may be blocks.
    heights = np.where(scan.seen, scan.levels * scan.unit, np.nan)
    if share_as_high(heights, scan.frame, scan.frame_height, scan.unit) >= _DOUBTFUL:
        yield (
            f"assumed: frames, though many blocks next to them are {written.with_unit(scan.frame_height, 3)} high too "
            "(--boundary none if they are blocks)"
        )


def _board(scan: Scan, options: ScanOptions, written: Lengths) -> Iterator[str]:
    """Yield a line if blocks stand on a board that was found, or may stand on one."""
    if options.base_cm is not None:
        return
    if scan.base:
        board = written.measured(scan.base)
        yield (
            f"assumed: a board of {board} {written.unit} below the blocks, as all tops are that much above whole units "
            "(--base-cm 0 if there is none)"
        )
    elif not (scan.blocks == 0).any():
        yield "assumed: no board below the blocks, though no block is at level 0 (--base-cm if there is one)"


def _assumed(what: str, taken: float, measured: float, flag: str) -> Iterator[str]:
    """Yield a line if a length was taken for that of lumber in inches, or could be."""
    from rsegen.scanning.lumber import alternatives, dressed_inches

    def named(metres: float) -> str:
        name = f"{decimal(metres * 100)} cm"
        inches = lengths_in("in").tape(round(metres * 1e9))
        return f"{name} ({inches} in of lumber)" if dressed_inches(metres) else name

    others = list(alternatives(measured, taken))
    if dressed_inches(taken) or others:
        instead = "".join(
            f"; {named(other)} is {abs(other / measured - 1):.1%} off ({flag} {decimal(other * 100)})"
            for other in others
        )
        yield f"assumed: {what} of {named(taken)}, {abs(taken / measured - 1):.1%} off the measured length{instead}"


def _cells(scanned: ScannedMap, chosen: Mask) -> str:
    """Return the number of cells, and the first of them as recipes count them."""
    from rsegen.scanning.scan_report import named_cells

    cells = list(named_cells(scanned.scan, chosen))
    names = ", ".join(f"x {x} y {y}" for x, y in cells[:_SHOWN])
    more = f" and {len(cells) - _SHOWN} more" if len(cells) > _SHOWN else ""
    return f"{int(chosen.sum())} of {chosen.size} cells" + (f" ({names}{more})" if names else "")


_OF_THE_MAP = frozenset({*parameters(Recipe), "size", "fill_holes"})
"""Options of a scan that the map decides."""


_NAMED = 20
"""Blocks that a report names."""


@dataclass(frozen=True, kw_only=True, slots=True)
class _Drawing:
    """Print and draw which blocks of a real field, or of a map, differ from those of MAP."""

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
        help="point clouds or depth images of one field, as for rsegen scan, or a map; the last one, MAP, is the map "
        "to compare with: a recipe, an example, the folder of a map",
    )
    command.add_argument("--map", metavar="INDEX", help="index or name of the map (default: the first)")
    add_flags(command.group("output"), _Drawing)
    add_flags(command.group("reading a scan"), ScanOptions, without=_OF_THE_MAP)
    add_target_recipe_flags(command)


def run_compare(arguments: argparse.Namespace) -> Report:
    """Compare and draw; the exit code is 1 if anything differs or was not seen."""
    from rsegen.scanning.pictures import cell_counts
    from rsegen.writing.resources import refuse_too_large

    *built, wanted = arguments.paths
    if not built:
        raise ParameterError(
            "MAP", f"only {wanted} was passed; pass a scan or a map, and then the map that should stand"
        )
    picture = picture_of(arguments.output, force=arguments.force)
    # The map that should stand is one of a recipe or a folder, as commands take it, though it is named last here.
    arguments.target = wanted
    _, recipe, index = map_of_flags(arguments)
    refuse_too_large(recipe)
    compared = _compared(built, arguments, recipe.alone(index))
    if picture:
        picture.write(compared.picture)
    comparison = compared.comparison
    lines = [cell_counts(comparison), *_lines(comparison, lengths_in(recipe.units))]
    notes = [line for path in dict.fromkeys(arguments.paths) for line in which_map(path, arguments.map)]
    notes += [f"warning: {compared.doubt}"] if compared.doubt else []
    content = _content(comparison) | {"notes": notes}
    return Report(lines=lines, content=content, notes=notes, code=0 if comparison.is_equal else 1)


def _compared(built: list[str], arguments: argparse.Namespace, recipe: Recipe) -> ComparedMap:
    from rsegen.scanning.clouds import is_cloud
    from rsegen.scanning.scans import compare
    from rsegen.writing.resources import refuse_too_large
    from rsegen.writing.target_worlds import chosen_map

    clouds = [path for path in built if is_cloud(Path(path))]
    if clouds and len(clouds) == len(built):
        given_options = given(ScanOptions, arguments, arguments.units)
        options = {name: value for name, value in given_options.items() if name not in _OF_THE_MAP}
        return compare(clouds, recipe, ScanOptions(**options))
    if len(built) > 1:
        raise ParameterError("SCAN-or-MAP", "pass clouds of one field and a map, or two maps")
    _, other, index = chosen_map(built[0], arguments.map, "--map")
    refuse_too_large(other)
    return compare(other.alone(index), recipe)


def _lines(comparison: Comparison, written: Lengths) -> Iterator[str]:
    changes = list(comparison.changes())
    if changes:
        yield "x and y count the blocks of MAP from its south-west corner without frames, as on its build sheet"
    for x, y, height, wanted in changes[:_NAMED]:
        way = "too high" if height > wanted else "too low"
        measured, right = (written.with_unit(metres, 1) for metres in (height, wanted))
        i, j = _numbers(comparison, x, y)
        cell = f"frame, cell {x}, {y} with frames counted" if i is None else f"x {i} y {j}"
        yield f"  {cell}: {measured}, should be {right} ({way})"
    if len(changes) > _NAMED:
        yield f"  and {len(changes) - _NAMED} more"


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
