"""Where plan, 3D view and legend of a preview are: side by side, or one below the other for long maps."""

from __future__ import annotations

from dataclasses import dataclass

Box = tuple[float, float, float, float]
"""Left, low, width and height; inches, or shares of the picture."""

WIDTH = 16.0
"""Inches of a picture, at the most."""

_TALLEST = 8.5
"""Inches of a plan or view."""

_LONG = 2.0
"""Maps that are so many times as long along x as along y have their view below the plan."""

_BESIDE, _BELOW, _ABOVE, _GAP, _EDGE = 0.7, 0.6, 0.8, 0.25, 0.12
"""Inches beside, below and above a plan for its numbers and title, between plan and view, and at the edge."""

_TITLE, _HEAD = 0.35, 0.35
"""Inches of the title of the picture, and of that of the view."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Layout:
    """Width and height of the picture in inches; the boxes of plan and view, and the left edge of the legend."""

    size: tuple[float, float]
    plan: Box
    view: Box
    legend: float

    def share(self, box: Box) -> Box:
        """A box as shares of the picture, as matplotlib wants it."""
        (wide, high), (left, low, width, height) = self.size, box
        return left / wide, low / high, width / wide, height / high


def layout(plan: float, view: float, legend: float) -> Layout:
    """The layout for a plan and a view of these ratios of width to height and a legend of so many inches."""
    return (_one_below_the_other if plan > _LONG else _side_by_side)(plan, view, legend)


def _side_by_side(plan: float, view: float, legend: float) -> Layout:
    """The view is higher than the plan, as it has no numbers above and below."""
    more = _BELOW + _ABOVE - _HEAD - _EDGE
    free = WIDTH - 2 * _BESIDE - _GAP - legend - _EDGE
    height = min((free - more * view) / (plan + view), _TALLEST)
    left = _BESIDE + height * plan + _BESIDE + _GAP
    right = left + (height + more) * view + _EDGE
    return Layout(
        size=(right + legend, _BELOW + height + _ABOVE + _TITLE),
        plan=(_BESIDE, _BELOW, height * plan, height),
        view=(left, _EDGE, (height + more) * view, height + more),
        legend=right,
    )


def _one_below_the_other(plan: float, view: float, legend: float) -> Layout:
    width = WIDTH - 2 * _BESIDE - legend - _EDGE
    below, above = min(width / view, _TALLEST), width / plan
    low = _EDGE + below + _HEAD + _BELOW
    return Layout(
        size=(WIDTH, low + above + _ABOVE + _TITLE),
        plan=(_BESIDE, low, width, above),
        view=(_BESIDE, _EDGE, width, below),
        legend=WIDTH - legend,
    )
