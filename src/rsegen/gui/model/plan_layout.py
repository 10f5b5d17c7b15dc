"""Layout of the cells on the plan, as a whole or closer by: pixels (y down), field cells and block cells (y up)."""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass, replace

import numpy as np

from rsegen.exporters.scene import Scene
from rsegen.field.stepfield import CellWindow, StepField
from rsegen.gui.model.colours import centimetres
from rsegen.params.sorts import Cell

Point = tuple[float, float]
"""x to the right and y downward, in pixels."""

Box = tuple[float, float, float, float]
"""Left, top, width and height, in pixels."""

_STEPS = (1, 2, 5)


@dataclass(frozen=True, kw_only=True, slots=True)
class PlanLayout:
    """The plan of a map in a widget.

    shape: field cells along x and y; blocks: along each axis, the field cells that hold blocks, in order.
    left, bottom: the corner of smallest x and y, pixels; side: of a cell, pixels.
    """

    shape: Cell
    blocks: tuple[tuple[int, ...], tuple[int, ...]]
    left: float
    bottom: float
    side: float

    @property
    def area(self) -> Box:
        """The whole map."""
        return self.box((0, 0), (self.shape[0] - 1, self.shape[1] - 1))

    def box(self, one: Cell, other: Cell) -> Box:
        """The rectangle of all field cells between two, both included."""
        (west, east), (south, north) = (sorted(pair) for pair in zip(one, other, strict=True))
        top = self.bottom - (north + 1) * self.side
        return self.left + west * self.side, top, (east + 1 - west) * self.side, (north + 1 - south) * self.side

    def middle(self, block: Cell) -> Point:
        """The centre of a block cell."""
        i, j = self.cell_of(block)
        return self.left + (i + 0.5) * self.side, self.bottom - (j + 0.5) * self.side

    def cell_of(self, block: Cell) -> Cell:
        """The field cell of a block cell."""
        return self.blocks[0][block[0]], self.blocks[1][block[1]]

    def cell_at(self, point: Point) -> Cell | None:
        """The field cell under a point, None outside the map."""
        i, j = self._cell(point)
        return (i, j) if 0 <= i < self.shape[0] and 0 <= j < self.shape[1] else None

    def block_of(self, cell: Cell) -> Cell | None:
        """The block cell of a field cell, None for a frame."""
        x, y = (bisect_left(along, at) for along, at in zip(self.blocks, cell, strict=True))
        inside = x < len(self.blocks[0]) and y < len(self.blocks[1]) and self.cell_of((x, y)) == cell
        return (x, y) if inside else None

    def nearest_block(self, point: Point) -> Cell:
        """The block cell under a point, or the nearest to it."""
        i, j = self._cell(point)
        return _nearest(self.blocks[0], i), _nearest(self.blocks[1], j)

    def moved(self, block: Cell, step: Cell) -> Cell:
        """The block cell some steps further, at most at the edge of the map."""
        x, y = (min(max(at + by, 0), len(along) - 1) for at, by, along in zip(block, step, self.blocks, strict=True))
        return x, y

    def _cell(self, point: Point) -> Cell:
        return int((point[0] - self.left) // self.side), int((self.bottom - point[1]) // self.side)


def fit(field: StepField, area: Box, ratio: float = 1.0) -> PlanLayout:
    """The largest plan of a field in the middle of an area; cells are whole pixels of the screen, `ratio` per pixel."""
    left, top, width, height = area
    n_x, n_y = field.shape
    side = max(min(width / n_x, height / n_y), 0.01)
    side = np.floor(side * ratio) / ratio if side * ratio >= 1 else side
    x, y = ((np.round(spare / 2 * ratio) / ratio) for spare in (width - n_x * side, height - n_y * side))
    blocks_x, blocks_y = (tuple(np.flatnonzero(field.inside(axis)).tolist()) for axis in (0, 1))
    return PlanLayout(
        shape=field.shape,
        blocks=(blocks_x, blocks_y),
        left=float(left + x),
        bottom=float(top + height - y),
        side=float(side),
    )


def ticks(cells: int, side: float, room: float) -> range:
    """The cells that a ruler numbers, so that each number has `room` pixels: every one, 2nd, 5th, 10th ..."""
    step = next(
        step * 10**power for power in range(10) for step in _STEPS if step * 10**power * side >= room or power == 9
    )
    return range(0, cells, step)


def describe_cell(scene: Scene, layout: PlanLayout, cell: Cell) -> str:
    """The content of a field cell as text: `block 3, 4: level 2, 20 cm`, or `frame: 10 cm`."""
    if scene.field.frame[cell]:
        return f"frame: {centimetres(scene.field.frame_height)}"
    x, y = layout.block_of(cell) or cell
    level = int(scene.field.levels[cell])
    return f"block {x}, {y}: level {level}, {centimetres(level * scene.field.unit)}"


def _nearest(along: tuple[int, ...], at: int) -> int:
    """The index of the number nearest to `at` in an ascending sequence; of two, the lower."""
    after = min(bisect_left(along, at), len(along) - 1)
    before = max(after - 1, 0)
    return before if at - along[before] <= along[after] - at else after


_LARGEST = 80.0
"""Pixels of a cell at the most."""


def zoomed(layout: PlanLayout, fitted: PlanLayout, area: Box, point: Point, factor: float) -> PlanLayout:
    """The layout with cells larger by a factor, that under a point kept there; never smaller than the fitted one."""
    side = min(max(layout.side * factor, fitted.side), max(fitted.side, _LARGEST))
    scale = side / layout.side
    left, bottom = point[0] - (point[0] - layout.left) * scale, point[1] + (layout.bottom - point[1]) * scale
    return fitted if side == fitted.side else kept_in(replace(layout, left=left, bottom=bottom, side=side), area)


def shifted(layout: PlanLayout, area: Box, by: Point) -> PlanLayout:
    """The layout moved by some pixels, as far as there is map to show."""
    return kept_in(replace(layout, left=layout.left + by[0], bottom=layout.bottom + by[1]), area)


def kept_in(layout: PlanLayout, area: Box) -> PlanLayout:
    """The layout moved so that the map fills the area; in its middle along an axis that fits."""
    left, top, width, height = area
    _, _, map_width, map_height = layout.area
    low = _kept(layout.left, left, width, map_width)
    return replace(layout, left=low, bottom=_kept(layout.bottom - map_height, top, height, map_height) + map_height)


def resized(layout: PlanLayout, fitted: PlanLayout, before: Box, area: Box) -> PlanLayout:
    """A layout that was zoomed in another area: cells as large as they were, the same cell in the middle."""
    (x, y), (to_x, to_y) = ((box[0] + box[2] / 2, box[1] + box[3] / 2) for box in (before, area))
    is_whole = layout.shape != fitted.shape or layout.side <= fitted.side
    moved = replace(layout, blocks=fitted.blocks, left=layout.left + to_x - x, bottom=layout.bottom + to_y - y)
    return fitted if is_whole else kept_in(moved, area)


def visible(layout: PlanLayout, area: Box) -> CellWindow:
    """The field cells of which any part is in an area."""
    left, top, width, height = area
    x, y = (
        slice(min(max(int(low // layout.side), 0), cells), min(max(int(high // layout.side) + 1, 0), cells))
        for low, high, cells in (
            (left - layout.left, left + width - layout.left, layout.shape[0]),
            (layout.bottom - top - height, layout.bottom - top, layout.shape[1]),
        )
    )
    return x, y


def _kept(low: float, start: float, room: float, length: float) -> float:
    spare = room - length
    return start + spare / 2 if spare >= 0 else min(max(low, start + spare), start)
