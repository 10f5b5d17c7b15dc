"""The plan closer by: the same cells in larger squares, of which the area of the plan shows a part."""

from __future__ import annotations

from dataclasses import replace

from rsegen.field.stepfield import CellWindow
from rsegen.gui.model.plan_layout import Box, PlanLayout, Point

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
