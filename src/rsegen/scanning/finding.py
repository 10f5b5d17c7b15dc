"""The step field in a point cloud, from points to levels.

    points -> upright (ground.py) -> unit and grid (grid.py, levels.py) -> heights of cells -> extent and frames -> Scan

Every step looks for the one thing that all blocks have in common: parallel tops, heights that are whole multiples of a
unit, edges on evenly spaced lines, one height per cell. Nothing is random (seeds are fixed), so one cloud gives one
field. The searches take at most 200,000 points; the levels are read from all of them. The time is two to four seconds
for 200,000 points, most of it for the ground plane and the refinement of the grid. It fails if few tops are seen, if
the cloud is mostly something else, or if edges of other things lie on a grid; docs/scan.md has the figures.

Numbers of these modules were halved, and raised by 60 %, on nine clouds as of benchmarks/scan (three kinds of fields;
one camera above with 10 mm of noise, two with 15 mm, one aside with 5 mm): _POINTS_PER_PIXEL, _FEWEST_POINTS,
_MOST_WIDTHS and _MOST_LEFT of grid.py with the choice of the grid as it is now, which finds all nine; those of other
modules before it. Where nothing else is said, the result stays the same. Other numbers of grid.py were not varied.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from rsegen.errors import ScanError
from rsegen.field.graphs import component_labels, neighbours
from rsegen.field.stepfield import Array, Ints, Mask, StepField
from rsegen.params.sorts import Cell
from rsegen.scanning.evidence import FEWEST_BITS, MOST_MIXED, bits_saved, cells_per_block, mixed_share, times_narrower
from rsegen.scanning.extent import (
    FLOOR_ROWS,
    FrameLayout,
    KnownFrameLayout,
    best_fit,
    extent_of,
    floor_rows,
    frames_of,
    open_sides,
    raised_apart,
    units_below,
    unseen_sides,
    whole_cloud,
    with_open_rows,
)
from rsegen.scanning.grid import CloudGrid, find_grid, flat_heights, on_tops, pixel_size, rasterized, refined
from rsegen.scanning.ground import GroundFrame, level_frame, plan_width, sample, usable
from rsegen.scanning.levels import Reading, board_below, find_unit, levelled, read_cells, units_per_level
from rsegen.scanning.lumber import sold_length
from rsegen.scanning.scan import Scan, ScanSettings, Transform

_FEWEST_TOPS = 100
"""Raised flat pixels from which the unit is read; from fewer, as in a sparse cloud, all pixels are better."""

_LEAST_AGREEING = 0.6
"""Share of the cells of a known field that must agree: two fields of five levels agree in a third of their blocks by
chance, at the best place, and in all cells of equal frames: together in half of 12 x 12 cells."""

_FEWEST_SEEN = 30
"""Cells of a known field that must be seen, or half of a smaller one: 6 of 10 agree with any map at one of the places
and turns that are tried, 18 of 30 with two of a hundred maps, if a quarter of the cells agree by chance."""

_MOST_OUTSIDE = 0.1
"""Share of the raised cells that may be outside a field of a given size: things that stand next to it."""

_NEARLY_A_UNIT = 0.06
"""Units by which a frame's height may differ from a whole number of units to be one: 6 mm of a block of 10 cm."""


def find_field(points: Array, settings: ScanSettings | None = None, known: StepField | None = None) -> Scan:
    """Return the step field in a cloud.

    points: (n, 3) [m], in any frame; those that are not finite are left out.
    known: a field that should stand there; the scan is turned and moved to it, and has its cells.
    Raises a ScanError if there is no field in the cloud, or not the known one.
    """
    settings = settings or ScanSettings()
    near, middle = usable(points)
    if known:
        return _scan_of_known_field(near, middle, settings, known)
    wanted = settings
    scan, settings = _first_scan(near, middle, wanted)
    scan, settings = _with_side_up(near, middle, scan, settings)
    is_up_assumed = scan.is_up_assumed
    # Levels show what a first reading cannot know; then the cloud is read once more with it.
    better = _corrected(settings, scan)
    scan = scan if better == settings else _found_field(_gridded(near, middle, better, None), better)
    if wanted.block_width is None and wanted.blocks is not None:
        scan = _reaching(near, middle, replace(wanted, up=settings.up), scan)
    _refuse_no_field(scan, wanted)
    return replace(scan, is_up_assumed=is_up_assumed)


def _refuse_no_field(scan: Scan, wanted: ScanSettings) -> None:
    """Raise a ScanError if what was found is more likely something else than a field."""
    if wanted.block_width is None and wanted.blocks is None:
        advice = "set block_width_cm if it is made of blocks"
        if _is_one_patch(scan):
            raise ScanError(f"one raised patch of one height, in which nothing shows blocks, is no field; {advice}")
        if bits_saved(scan) < FEWEST_BITS:
            raise ScanError(f"no field: what is raised has too few sides to tell blocks from boxes; {advice}")
        if (mixed := mixed_share(scan)) > MOST_MIXED:
            raise ScanError(f"no field: {mixed:.0%} of its cells have two heights, where a block has one; {advice}")
    if wanted.unit is None and _agreement_of_tops(scan) < _CLEAR_TOPS:
        raise ScanError("tops are not at whole multiples of a unit, as those of blocks are; set unit_cm if they are")


def _with_side_up(near: Array, middle: Array, scan: Scan, settings: ScanSettings) -> tuple[Scan, ScanSettings]:
    """Return the field with the side up that the axes of the cloud say, if no floor around it tells which one is; and
    the settings with it.

    A field is a field from below too, its highest blocks level 0, and a frame is as wide as a narrow floor there.
    Raises a ScanError if the axes say that the origin, at which sensors are, is under the middle of the field.
    """
    if settings.up is not None or settings.eye is not None or scan.has_floor:
        return scan, settings
    normal = scan.rotation[2]
    by_axes = normal * np.sign(normal[int(np.abs(normal).argmax())])
    x, y, z = by_axes.tolist()
    wanted = replace(settings, up=(x, y, z))
    if by_axes @ normal < 0:
        try:
            scan, wanted = _first_scan(near, middle, wanted)
        except ScanError:
            return scan, settings
    x, y, z = scan.translation.tolist()
    half = scan.block_width * max(scan.levels.shape) / 2
    if -z > max(half, abs(x), abs(y)):
        raise ScanError("no floor around the field tells which side of it is up; set up, as z or -z")
    return replace(scan, is_up_assumed=True), wanted


_TIMES = (2, 3)
"""Times as wide, or as narrow, as they are that blocks are found, of which few have steps at their sides."""

_AS_SURE = 0.02
"""Confidence that the levels of blocks of another width may have less on average: lines of a wrong width go through
tops of two levels."""


def _first_scan(near: Array, middle: Array, settings: ScanSettings) -> tuple[Scan, ScanSettings]:
    """Return the field as it is first found, and the settings; with blocks as wide as a given size says, if their sides
    do not.
    """
    grid, scan, refused = _gridded(near, middle, settings, None), None, ScanError("")
    try:
        scan = _found_field(grid, settings)
    except ScanError as error:
        refused = error
    # A size tells how wide blocks are whose sides do not: what is raised reaches from side to side.
    if settings.blocks and settings.block_width is None and (scan is None or bits_saved(scan) < FEWEST_BITS):
        for width in _widths_of_size(grid, settings):
            known = replace(settings, block_width=width)
            try:
                other = _found_field(_gridded(near, middle, known, None), known)
            except ScanError:
                continue
            if scan is None or other.confidence.mean() >= scan.confidence.mean() - _AS_SURE:
                return other, known
    if scan is None:
        raise refused
    return scan, settings


def _reaching(near: Array, middle: Array, wanted: ScanSettings, scan: Scan) -> Scan:
    """Return a field of a given size with narrower blocks, if what is raised then reaches from side to side.

    Steps that are two blocks wide look like blocks that are twice as wide, of which the given size would leave half of
    the field level. Only what rises to its middle, or falls, without a hole is taken for such steps.
    """
    times = times_narrower(scan)
    raised = scan.tops[np.ix_(*((scan.tops > 0).any(axis=1 - axis) for axis in (0, 1)))]
    if times == 1 or not (raised > 0).all() or not all(_is_stepped(rows) for rows in (raised, raised.T)):
        return scan
    known = replace(wanted, block_width=sold_length(scan.measured_width / times), boundary="none")
    try:
        other = _found_field(_gridded(near, middle, known, None), known)
    except ScanError:
        return scan
    return other if other.confidence.mean() >= scan.confidence.mean() - _AS_SURE else scan


def _is_stepped(rows: Ints) -> bool:
    """Return whether each row (n, m) only rises and then falls, or falls and then rises, as one of a pyramid does."""
    signs = [row[row != 0] for row in np.sign(np.diff(rows, axis=1))]
    return all(np.count_nonzero(np.diff(own)) <= 1 for own in signs)


def _widths_of_size(grid: _Gridded, settings: ScanSettings) -> Iterator[float]:
    """Yield widths of blocks of which what is raised reaches just from side to side of a field of a given size."""
    _, raised = extent_of(grid.reading, grid.unit)
    layouts = [*_wanted(settings), FrameLayout(boundary="none", side=None, blocks=settings.blocks or raised)]
    shapes = dict.fromkeys(own for layout in layouts for own in (layout.shape, layout.shape[::-1]))
    shares = [min(all_x / raised[0], all_y / raised[1]) for all_x, all_y in shapes]
    for times in _TIMES:
        if times in shares:
            yield sold_length(grid.width / times)
        if 1 / times in shares:
            yield sold_length(grid.width * times)


def _is_one_patch(scan: Scan) -> bool:
    """Return whether all that is raised is one patch of one level without holes, as a box or a cup on a table is."""
    tops = scan.tops  # its rim may look like a frame
    raised = tops > 0
    if len(np.unique(tops[raised])) > 1:
        return False
    # Cells that were not seen may be raised or not; with a margin all that is outside is one part.
    return _parts(np.pad(raised, 1)) == 1 and _parts(np.pad(tops == 0, 1, constant_values=True)) <= 1


_CLEAR_TOPS = 0.5
"""Agreement of raised tops on the unit at least: 1 if all are at whole multiples of it, 0 for heights at random."""


def _agreement_of_tops(scan: Scan) -> float:
    """Return the mean of cos(2 pi h / unit) of all tops that are raised; 1 without any."""
    raised = scan.seen & ~scan.frame & (np.nan_to_num(scan.heights) > scan.measured_unit / 4)
    if not raised.any():
        return 1.0
    return float(np.cos(2 * np.pi * scan.heights[raised] / scan.measured_unit).mean())


def _parts(cells: Mask) -> int:
    """Return the number of parts of some cells that are connected by sides."""
    low, high = neighbours(cells.shape)
    alike = cells.ravel()[low] & cells.ravel()[high]
    return len(np.unique(component_labels(cells.size, low[alike], high[alike])[cells.ravel()]))


def _corrected(settings: ScanSettings, scan: Scan) -> ScanSettings:
    """Return the settings with wider blocks, a board below them, or a larger unit, that only the levels show."""
    width = scan.block_width
    if settings.block_width is None and (cells := cells_per_block(scan)) > 1:
        width = sold_length(cells * scan.measured_width)
        settings = replace(settings, block_width=width)
    blocks = scan.seen & ~scan.frame
    levels = scan.levels[blocks]
    if settings.base is None and (board := board_below(scan.heights[blocks], levels, scan.measured_unit)):
        return replace(settings, base=board)
    # Frames count too: 10 cm high around blocks of 20 and 40 cm, they are one unit of 10 cm.
    frame = round(scan.frame_height / scan.unit)
    if settings.unit is None and (times := int(np.gcd(units_per_level(levels), frame))) > 1:
        return replace(settings, unit=sold_length(times * scan.measured_unit, (width, width / 2)))
    return settings


def _scan_of_known_field(near: Array, middle: Array, settings: ScanSettings, known: StepField) -> Scan:
    """Return the known field in a cloud, also in one that looks upside down, as no floor tells which side is up."""
    try:
        return _on_floor_or_board(near, middle, settings, known)
    except ScanError:
        if settings.up is not None or settings.eye is not None:
            raise
        x, y, z = (-level_frame(near).rotation[2]).tolist()
        with suppress(ScanError):
            return _on_floor_or_board(near, middle, replace(settings, up=(x, y, z)), known)
        raise


def _on_floor_or_board(near: Array, middle: Array, settings: ScanSettings, known: StepField) -> Scan:
    """Return the known field in a cloud, on the floor, or else on a board that the cloud shows."""
    # On a board no cell agrees, as all are too high; only a reading without the known field shows the board.
    try:
        return _known_field(_gridded(near, middle, settings, known), known)
    except ScanError:
        if settings.base is not None:
            raise
        if not (board := _board(near, middle, replace(settings, block_width=known.block_width))):
            raise
        return _known_field(_gridded(near, middle, replace(settings, base=board), known), known)


def _board(near: Array, middle: Array, settings: ScanSettings) -> float:
    """Return the thickness of the board that a cloud shows [m], 0 if it shows none."""
    try:
        return _corrected(settings, _found_field(_gridded(near, middle, settings, None), settings)).base or 0.0
    except ScanError:
        return 0.0


@dataclass(frozen=True, kw_only=True, slots=True)
class _Gridded:
    """A cloud as heights of cells; unit and width as found in it [m], and as the map has them, if that is known."""

    reading: Reading
    transform: Transform
    noise: float
    unit: float
    width: float
    nominal_unit: float
    nominal_width: float
    base: float

    def scan(self, part: Reading, frames: FrameLayout, transform: Transform) -> Scan:
        """Return the result for a part of the cells."""
        # The frames have their own height, and are as sure as they agree on it.
        above = replace(part, heights=part.heights - np.where(frames.cells, frames.height, 0.0))
        return Scan(
            levels=np.where(frames.cells, 0, part.levels(self.unit)),
            heights=part.heights,
            confidence=above.confidence(self.unit),
            counts=part.counts,
            strays=part.strays,
            frame=frames.cells,
            boundary=frames.boundary,
            chunk_size=frames.side,
            block_width=self.nominal_width,
            unit=self.nominal_unit,
            measured_width=self.width,
            measured_unit=self.unit,
            frame_height=self._frame_height(frames),
            noise=self.noise,
            base=self.base,
            floor_rows=max(floor_rows(self.reading, self.unit)),
            rotation=transform.rotation,
            translation=transform.translation,
        )

    def raised(self, height: float) -> _Gridded:
        """Return this with the floor lower than it was found, by a height [m]."""
        shift = np.array([0, 0, height])
        transform = replace(self.transform, translation=self.transform.translation + shift)
        return replace(self, reading=replace(self.reading, heights=self.reading.heights + height), transform=transform)

    def lying_along(self, blocks: Cell) -> _Gridded:
        """Return this, or a quarter turn of it if a rectangle of these blocks then has more raised cells."""
        turned = replace(self, reading=self.reading.quarter_turned(1), transform=self.transform.quarter_turned(1))
        return max((self, turned), key=lambda gridded: gridded._raised_in(blocks))

    def _raised_in(self, shape: Cell) -> int:
        part = self.reading.part(*extent_of(self.reading, self.unit, shape))
        return int((part.levels(self.unit) > 0).sum())

    def _frame_height(self, frames: FrameLayout) -> float:
        """Return the height of the frames in the map's lengths [m]; a whole number of units if it is nearly one."""
        units = frames.height / self.unit
        near = abs(units - round(units)) < _NEARLY_A_UNIT
        return round(units) * self.nominal_unit if near else sold_length(frames.height)


def _gridded(points: Array, middle: Array, settings: ScanSettings, known: StepField | None) -> _Gridded:
    """Turn a cloud upright and read the height of every cell, with as much of unit and width as is known."""
    ground = level_frame(points, settings.up, settings.eye_from(middle))
    upright = ground.apply(points)
    base = settings.base or 0.0
    if base:  # the top of the board below the blocks becomes the ground
        upright[:, 2] = np.where(upright[:, 2] > base / 2, upright[:, 2] - base, 0)
    width = known.block_width if known else settings.block_width
    nominal_unit = known.unit if known else settings.unit
    unit, grid, pixel = _unit_and_grid(upright, ground, nominal_unit, width)
    tops = on_tops(upright, unit, ground.noise, pixel)
    reading, unit = levelled(read_cells(upright, tops, grid, unit, ground.noise), unit)
    nominal_width = width or sold_length(grid.width)
    gridded = _Gridded(
        reading=reading,
        transform=Transform.of(ground, grid, reading, base).after(middle),
        noise=ground.noise,
        unit=unit,
        width=grid.width,
        # NIST's unit is the width of a post, or half of it.
        nominal_unit=nominal_unit or sold_length(unit, (nominal_width, nominal_width / 2)),
        nominal_width=nominal_width,
        base=base,
    )
    return gridded.raised(units_below(reading, unit) * unit)


def _unit_and_grid(
    upright: Array, ground: GroundFrame, unit: float | None, width: float | None
) -> tuple[float, CloudGrid, float]:
    """Find the height of a unit from flat pixels, then the grid; return both, and the side of the pixels [m]."""
    few = sample(upright)
    # A pixel is at most a third of a block, so that a top has flat pixels; of an unknown block 1/60 of the cloud.
    pixel = pixel_size(few, width / 3 if width else plan_width(few) / 60)
    raster = rasterized(few, pixel)
    tops = flat_heights(raster, max(3 * ground.noise, 0.003))  # three deviations; 3 mm without noise
    if (tops > max(3 * ground.noise, 0.005)).sum() < _FEWEST_TOPS:
        tops = raster.heights[np.isfinite(raster.heights)]
    unit = find_unit(tops, ground.noise, unit)
    grid = find_grid(upright, unit, ground.noise, pixel, width)
    return unit, refined(grid, upright, unit), pixel


def _found_field(grid: _Gridded, settings: ScanSettings) -> Scan:
    """Return the field of an unknown map: its rectangle, and its frames if it has any."""
    boundary = settings.boundary
    grid = grid.lying_along(settings.blocks) if settings.blocks else grid
    # With frames if one of the wanted layouts has them at one height; else without.
    for wanted in _wanted(settings):
        corner, shape = extent_of(grid.reading, grid.unit, wanted.shape if settings.blocks else None)
        places = [(corner, shape)] if settings.blocks else with_open_rows(grid.reading, corner, shape)
        for corner, shape in places:
            part = grid.reading.part(corner, shape)
            frames = frames_of(part, grid.unit, wanted.boundary or None, wanted.side)
            if frames and settings.blocks in (None, frames.blocks):
                scan = grid.scan(part, frames, grid.transform.moved(corner, shape))
                return scan if settings.blocks else replace(scan, open_sides=unseen_sides(grid.reading, corner, shape))
    if boundary not in (None, "none"):
        raise ScanError(f"no {boundary} frames of one height stand around the blocks; set boundary none, or size")
    corner, shape = extent_of(grid.reading, grid.unit, settings.blocks)
    if settings.blocks is None:
        corner, shape = _with_level_rim(grid, corner, shape)
    _refuse_larger(grid, corner, shape)
    none = FrameLayout(boundary="none", side=settings.chunk_size, blocks=shape)
    scan = grid.scan(grid.reading.part(corner, shape), none, grid.transform.moved(corner, shape))
    if settings.blocks:
        return scan
    _, whole = whole_cloud(grid.reading) or (corner, shape)
    return replace(
        scan,
        open_sides=open_sides(grid.reading, corner, shape),
        whole=whole if whole != shape else None,
        apart=raised_apart(grid.reading, grid.unit, corner, shape),
    )


def _with_level_rim(grid: _Gridded, corner: Cell, shape: Cell) -> tuple[Cell, Cell]:
    """Return a rectangle with the rows at level 0 next to it on some sides, if the cloud ends with them there, and with
    the rectangle on the others: it is cut at the sides of the field then, and has no floor.
    """
    rows = floor_rows(grid.reading, grid.unit)
    is_cut = min(rows) == 0 < max(rows) < FLOOR_ROWS
    return (is_cut and whole_cloud(grid.reading)) or (corner, shape)


def _wanted(settings: ScanSettings) -> Iterator[FrameLayout]:
    """Yield the frames to look for; without a boundary if any will do."""
    blocks, side = settings.blocks or (1, 1), settings.chunk_size
    if settings.blocks is None:
        if settings.boundary != "none":
            yield FrameLayout(boundary=settings.boundary or "", side=side, blocks=blocks)
        return
    if settings.boundary in (None, "outer"):
        yield FrameLayout(boundary="outer", side=side, blocks=blocks)
    if settings.boundary in (None, "divided"):
        common = int(np.gcd(*blocks))
        sides = [side] if side else [divisor for divisor in range(2, common + 1) if common % divisor == 0]
        for chunk_side in sides:
            yield FrameLayout(boundary="divided", side=chunk_side, blocks=blocks)


def _refuse_larger(grid: _Gridded, corner: Cell, shape: Cell) -> None:
    """Raise a ScanError if many raised cells are outside a rectangle of a given size."""
    (low_x, low_y), (n_x, n_y) = extent_of(grid.reading, grid.unit)
    raised = grid.reading.part((low_x, low_y), (n_x, n_y)).levels(grid.unit) > 0
    inside = raised[
        max(corner[0] - low_x, 0) : max(corner[0] + shape[0] - low_x, 0),
        max(corner[1] - low_y, 0) : max(corner[1] + shape[1] - low_y, 0),
    ]
    if raised.sum() - inside.sum() > _MOST_OUTSIDE * raised.sum():
        raise ScanError(
            f"{n_x} x {n_y} cells are raised, not {shape[0]} x {shape[1]}; set another size, or cut the cloud"
        )


def _known_field(grid: _Gridded, known: StepField) -> Scan:
    """Return the known field in a cloud, turned as it stands there; a ScanError if it does not stand there."""
    stretch = grid.unit / known.unit  # the blocks as high as they are in the cloud
    fit = best_fit(grid.reading, known.heights * stretch, grid.unit / 2)
    lowest = float(known.heights.min()) * stretch
    if lowest and max(floor_rows(grid.reading, grid.unit)) < FLOOR_ROWS:  # the known field tells where its floor is
        raised = grid.raised(lowest)
        other = best_fit(raised.reading, known.heights * stretch, grid.unit / 2)
        grid, fit = (raised, other) if other.agree > fit.agree else (grid, fit)
    if fit.seen < (fewest := min(_FEWEST_SEEN, known.levels.size / 2)):
        raise ScanError(
            f"{fit.seen} cells of the map were seen, too few to tell it from others; at least {fewest:.0f} are needed"
        )
    if fit.agree < _LEAST_AGREEING * fit.seen:
        raise ScanError(
            f"the scan shows another map: at the best place {fit.agree} of the {fit.seen} cells that were seen agree"
        )
    part = grid.reading.quarter_turned(fit.turns).part(fit.corner, known.shape)
    transform = grid.transform.quarter_turned(fit.turns).moved(fit.corner, known.shape)
    frames = KnownFrameLayout(
        boundary="known", side=None, blocks=known.shape, height=known.frame_height * stretch, field=known
    )
    return grid.scan(part, frames, transform)
