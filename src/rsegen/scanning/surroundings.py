r"""A field in a room: one of several things that stand apart, of which others are walls, furniture and people.

    from the side   |       |_|            o        cells of the plan in which a tenth of the points are above the
    wall, field,    |   _ |_| |_          /|\       ground are raised; raised cells that touch are one thing, and its
    a person        |__| |_____|__________/_\__     part of the cloud is a rectangle of floor with nothing else in it

Cells are a twelfth of the cloud's width, then ever narrower: with wide cells a field of few obstacles is one thing,
with narrow ones it is no part of what stands near it. Then every thing is looked at as a cloud of its own. At last the
ground may be a table, the widest level layer above the floor: the same again without all that is below it. Cost: linear
in the points, and some 20 searches for a field. What breaks it: things nearer to the field than two of the narrowest
cells, 6 cm in a room of 3 m.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np

from rsegen.errors import ScanError
from rsegen.field.graphs import component_labels, neighbours
from rsegen.field.stepfield import Array, Ints, Mask, StepField
from rsegen.scanning.evidence import CERTAIN, FEWEST_BITS, bits_saved, stepped_lines
from rsegen.scanning.extent import FLOOR_ROWS, NEIGHBOURS
from rsegen.scanning.finding import find_field
from rsegen.scanning.ground import SLICES, level_frame, plan_width, sample, usable
from rsegen.scanning.scan import Scan, ScanSettings

_CELLS = (12, 25, 50, 100)
"""Cells of the plan across the cloud."""

_RAISED = 0.1
"""Share of a cell's points above the ground from which it is raised: outliers are a fiftieth."""

_FEWEST = 3
"""Points above the ground in a raised cell, at the least."""

_FLOOR = 0.3
"""Width of the floor around a thing that is looked at with it, as a share of its own: three rows of 10 x 10 blocks."""

_MOST_THINGS = 3
"""Largest things that are looked at, of each width of cells."""

_MOST_OF_PLAN = 0.1
"""Share of the plan that a single thing may be to be looked at by itself: a field of 1 m on a floor of 4 m."""

_HIGHEST = 2.0
"""Height above the floor from which on there is no field, but what is over it: ceilings, lamps [m]."""

_OVERHANG = 0.1
"""Share of a block by which points of a field may be next to it, as its grid is found before its unit is exact."""

_ROWS = FLOOR_ROWS + 1.5
"""Rows of floor around a field that are kept; half a row, as a cloud that ends at a line of the grid may go on."""

_FEW_OTHERS = 0.03
"""Share of the points that may be above the floor next to a field: outliers are, and change nothing."""

_FEWEST_AROUND = 6
"""Rows around a field, at the least, in which other obstacles of it may stand; else half as many as it has."""

_MOST_OF_CELL = 0.5
"""Share of a cell's points that are at one level, from which on a block may stand there: sides have few at each."""

_ON_LEVEL = 0.35
"""Units by which a point of such a block is off its level at most: three standard deviations of a noise of a ninth."""

_MOST_BESIDE = 0.3
"""Cells around a thing that are as high as blocks, as a share of its own, up to which they are other things: a carton
next to a field of 10 x 10 blocks has 0.12."""

_LEAST_TABLE = 0.02
"""Height of a table above the floor, at the least, as a share of the width of the cloud: 6 cm in a room of 3 m."""


def is_doubtful(scan: Scan, settings: ScanSettings, known: StepField | None) -> bool:
    """Return whether something that is no field would look like what was found, and nobody says that it is one."""
    is_told = known is not None or settings.block_width is not None or settings.blocks is not None
    return not is_told and not _shows_blocks(scan)


def find_field_apart(points: Array, settings: ScanSettings, known: StepField | None) -> tuple[Scan, Array] | None:
    """Return the field that one of the things in a cloud (n, 3) is, and its points with those around it; None if none.

    A thing that is not the known field has to show blocks, and floor around them; of several, that which shows most
    blocks is it. One of which little shows them, as of few obstacles, is it if no other is, and somebody says so.
    """
    near, middle = usable(points)
    others: list[tuple[Scan, Array]] = []
    for things in _things(near, settings.up, settings.eye_from(middle)):
        fields = []
        for thing in things:
            with suppress(ScanError):
                found = find_field(thing + middle, settings, known)
                if found.has_floor and may_be_field(found, settings, known):
                    fields.append((found, thing + middle))
        if certain := [field for field in fields if known or _shows_blocks(field[0])]:
            return max(certain, key=_bits)
        others += fields
    return max(others, key=_bits, default=None)


def _shows_blocks(scan: Scan) -> bool:
    return stepped_lines(scan).confidence >= CERTAIN


def may_be_field(scan: Scan, settings: ScanSettings, known: StepField | None) -> bool:
    """Return whether a thing may be the field: who says how wide its blocks are does not say that a carton is it."""
    return known is not None or (bits_saved(scan) >= FEWEST_BITS and not is_doubtful(scan, settings, known))


def _bits(field: tuple[Scan, Array]) -> float:
    return bits_saved(field[0])


def with_beside(scan: Scan, points: Array, settings: ScanSettings, known: StepField | None) -> Scan:
    """Return a field with the number of cells beside it, of a cloud (n, 3), if nobody says how large it is."""
    is_sized = known is not None or settings.blocks is not None
    return scan if is_sized else replace(scan, beside=_raised_beside(scan, points))


def may_be_part(scan: Scan) -> bool:
    """Return whether one of the things in a cloud may be a part of the field only, as much is as high beside it."""
    return scan.beside > _MOST_BESIDE * int(np.count_nonzero(scan.levels > 0))


def without_others(scan: Scan, points: Array, settings: ScanSettings, known: StepField | None) -> tuple[Scan, Array]:
    """Return a field as its own points and those of some rows of floor show it, if other things stand next to it.

    Their tops are at any height, and so change the unit a little.
    """
    placed = scan.placed(points)
    beside = (np.abs(placed[:, :2]) / scan.measured_width - np.array(scan.levels.shape) / 2).max(axis=1)
    is_low = placed[:, 2] < scan.measured_unit / 2
    # All that is above the field, whatever its height, and of the rest only floor.
    own = (beside < _OVERHANG) | (is_low & (beside < _ROWS))
    if (~is_low & (beside > _OVERHANG)).mean() > _FEW_OTHERS:
        with suppress(ScanError):
            alone = find_field(points[own], settings, known)
            if alone.levels.size == scan.levels.size and alone.has_floor:
                kept = {name: getattr(scan, name) for name in ("open_sides", "apart", "whole", "beside")}
                return replace(alone, **kept), points[own]
    return scan, points


def _raised_beside(scan: Scan, points: Array) -> int:
    """Return the number of cells around a field without frames that are as high as blocks: obstacles beyond rows at
    level 0, or other things that stand there. Walls and people have no such tops.

    points: (n, 3), of the whole cloud [m].
    """
    if scan.frame.any():
        return 0
    # A histogram of levels for each cell around the field: most points of a top are at one level.
    rows = max(_FEWEST_AROUND, max(scan.levels.shape) // 2)
    shape = np.array(scan.levels.shape) + 2 * rows
    placed = scan.placed(points)
    cells = np.floor(placed[:, :2] / scan.measured_width + shape / 2)
    is_around = ((cells >= 0) & (cells < shape)).all(axis=1)
    key, heights = cells[is_around].astype(np.int64) @ (shape[1], 1), placed[is_around, 2] / scan.measured_unit
    levels, most = np.rint(heights).astype(np.int64), int(scan.tops.max()) + 1
    on_level = (levels > 0) & (levels <= most) & (np.abs(heights - levels) < _ON_LEVEL)
    count = np.bincount(key[on_level] * most + levels[on_level] - 1, minlength=shape.prod() * most)
    seen = np.bincount(key, minlength=shape.prod())
    beside = (count.reshape(-1, most).max(axis=1) >= np.maximum(_FEWEST, _MOST_OF_CELL * seen)).reshape(shape)
    beside[rows - NEIGHBOURS : NEIGHBOURS - rows, rows - NEIGHBOURS : NEIGHBOURS - rows] = False
    return int(np.count_nonzero(beside))


def _things(points: Array, up: Sequence[float] | None, eye: Array | None) -> Iterator[list[Array]]:
    """Yield things that may be fields, some at a time: all below a ceiling, each on the floor, all on a table together,
    and each on it.
    """
    ground = level_frame(points, up, eye)
    upright = ground.apply(points)
    below = upright[:, 2] < _HIGHEST
    points, upright = points[below], upright[below]
    if 1 - below.mean() > _FEW_OTHERS:
        yield [points]
    yield from _things_apart(points, upright, ground.noise)
    with suppress(ScanError):
        on_table = points[upright[:, 2] > _table(sample(upright))]
        yield [on_table]
        table = level_frame(on_table, up, eye)
        yield from _things_apart(on_table, table.apply(on_table), table.noise)


def _table(upright: Array) -> float:
    """Return the height from which points are on a table, or are of its top: the widest layer above the floor [m]."""
    width = _width(upright)
    # Each slice of heights by the cells of the plan that it has points in, not by its points: near things have more.
    slices = np.floor(upright[:, 2] / (width / SLICES)).astype(np.int64)
    plan = np.floor(upright[:, :2] / (width / _CELLS[1])).astype(np.int64)
    taken = np.unique(np.column_stack([slices, plan])[slices > _LEAST_TABLE * SLICES], axis=0)
    if not len(taken):
        raise ScanError("nothing is as high as a table")
    return float((np.bincount(taken[:, 0]).argmax() - 1) * width / SLICES)  # points of its top may be a slice lower


def _width(upright: Array) -> float:
    """Return the width of an upright cloud without outliers [m]; at least a fifth of that with all, as for a pole."""
    return max(plan_width(upright), float(np.ptp(upright[:, :2], axis=0).max()) / 5)


def _things_apart(points: Array, upright: Array, noise: float) -> Iterator[list[Array]]:
    """Yield for each width of cells the largest things in a cloud, if there are several, or a single one that is small
    in it: points, with those around.

    upright: the same points above their ground; noise: of the ground [m].
    """
    is_above, width = upright[:, 2] > 3 * noise, _width(upright)
    for cells in _CELLS:
        place = np.floor((upright[:, :2] - upright[:, :2].min(axis=0)) / (width / cells)).astype(np.int64)
        raised = _raised(place, is_above)
        labels = _labels(raised)
        sizes = np.bincount(labels[raised], minlength=labels.max() + 1)
        # One large thing alone was looked at already, as the whole cloud.
        if np.count_nonzero(sizes) > 1 or 0 < sizes.max(initial=0) < _MOST_OF_PLAN * labels.size:
            largest = [label for label in np.argsort(-sizes, kind="stable")[:_MOST_THINGS].tolist() if sizes[label]]
            yield [points[_around(labels, label)[place[:, 0], place[:, 1]]] for label in largest]


def _raised(place: Ints, is_above: Mask) -> Mask:
    """Return the cells of the plan in which many points are above the ground, (n_x, n_y); place: (n, 2), of each."""
    n_x, n_y = (int(most) + 1 for most in place.max(axis=0))
    key = place @ (n_y, 1)
    points = np.bincount(key, minlength=n_x * n_y)
    above = np.bincount(key[is_above], minlength=n_x * n_y)
    typical = float(np.median(points[key]))  # cells with far fewer have outliers
    many: Mask = above >= np.maximum(_FEWEST, _RAISED * np.maximum(points, typical))
    return many.reshape(n_x, n_y)


def _labels(raised: Mask) -> Ints:
    """Return one label for all cells of a thing and those next to it, (n_x, n_y), and -1 for all other cells."""
    windows: Any = np.lib.stride_tricks.sliding_window_view(np.pad(raised, 1), (3, 3))
    near = windows.any(axis=(2, 3))
    low, high = neighbours(raised.shape)
    joined = near.ravel()[low] & near.ravel()[high]
    return np.where(near, component_labels(raised.size, low[joined], high[joined]).reshape(raised.shape), -1)


def _around(labels: Ints, label: int) -> Mask:
    """Return the cells of a thing, and those of a rectangle around it that are of no other thing."""
    own = labels == label
    i, j = np.nonzero(own)
    margin = int(_FLOOR * max(np.ptp(i), np.ptp(j)) + 1)
    inside = np.zeros(labels.shape, dtype=bool)
    inside[max(i.min() - margin, 0) : i.max() + margin + 1, max(j.min() - margin, 0) : j.max() + margin + 1] = True
    return np.asarray(own | (inside & (labels < 0)))
