"""Pictures of measured fields, north up: how a scan was read, what is built wrong, how far heights were rounded."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from rsegen.field.stepfield import Array
from rsegen.params.numbers import Lengths, lengths_in
from rsegen.pictures.plan import LEGIBLE, ColouredField, draw_heights, number_cells, show_cells
from rsegen.pictures.preview import encoded, figure_of
from rsegen.scanning.comparison import Comparison
from rsegen.scanning.scan import SURE, Scan

if TYPE_CHECKING:
    from matplotlib.axes import Axes


_MOST_POINTS = 60_000
"""Points that are drawn: of 3 pixels, so that they cover half of the plot; more take longer and hide the grid."""

_FARTHEST = 1e9
"""Metres beyond which points are left out, as matplotlib fails on them."""

_MARGIN = 0.25
"""Metres of floor that are shown round the field."""

_UNSEEN = "#b9b9b9"


def scan_plot(scan: Scan, points: Array, format: str = "png", units: str = "cm") -> bytes:  # noqa: A002  # matplotlib's word
    """Return the points from above with the grid, and the errors of all tops, as the bytes of an image file.

    points: (n, 3) of the cloud that was read [m]; some of them are drawn; units: of lengths, as in recipes.
    """
    # Two plots of 7 inches with their bars leave 5.6 for the map; 1.2 for titles.
    n_x, n_y = scan.levels.shape
    figure = figure_of(14, 5.6 * n_y / n_x + 1.2, 3.5, 12)
    from_above, residuals = figure.subplots(1, 2)
    written = lengths_in(units)
    _draw_points(from_above, scan, points, written)
    _draw_errors(residuals, scan, written)
    figure.draw_without_rendering()  # places the axes, so that there is room for as many numbers as are asked for
    number_cells(residuals, scan.field)
    seen = int(scan.seen.sum())
    width, unit = (written.with_unit(metres) for metres in (scan.measured_width, scan.measured_unit))
    figure.suptitle(
        f"{n_x} x {n_y} cells of {width}, unit {unit}; "
        f"{seen} of {scan.seen.size} cells seen; a point is {scan.noise * 1000:.1f} mm off (standard deviation)"
    )
    return encoded(figure, format)


def _draw_points(axes: Axes, scan: Scan, points: Array, written: Lengths) -> None:
    # In the frame of the map, the highest last, so that tops hide what is below them.
    few = points[:: max(1, len(points) // _MOST_POINTS)]
    x, y, z = scan.placed(few[(np.abs(few) < _FARTHEST).all(axis=1)]).T
    half_x, half_y = (cells * scan.measured_width / 2 for cells in scan.levels.shape)
    near = (np.abs(x) < half_x + _MARGIN) & (np.abs(y) < half_y + _MARGIN)
    order = np.argsort(z[near])
    highest = max(float(np.nanmax(scan.heights, initial=0)), scan.measured_unit)
    drawn = axes.scatter(
        x[near][order],
        y[near][order],
        c=z[near][order] * written.per_metre,
        s=3,
        linewidths=0,
        cmap="viridis",
        vmin=0,
        vmax=highest * written.per_metre,
        rasterized=True,
    )
    axes.figure.colorbar(drawn, ax=axes, label=f"height above the ground [{written.unit}]", shrink=0.8)
    for cells, half, other, line in ((0, half_x, half_y, axes.vlines), (1, half_y, half_x, axes.hlines)):
        line(np.linspace(-half, half, scan.levels.shape[cells] + 1), -other, other, colors="#d62728", linewidth=0.8)
    axes.set(xlabel="x [m]", ylabel="y [m]", title="the points from above, and the grid that was found", aspect="equal")


def _draw_errors(axes: Axes, scan: Scan, written: Lengths) -> None:
    # Colours end at half a unit: beyond it the level would be another one.
    half = scan.measured_unit * written.per_metre / 2
    errors = np.ma.masked_invalid(scan.errors * written.per_metre)
    shown = show_cells(axes, scan.field, errors, cmap="RdBu_r", vmin=-half, vmax=half, interpolation="none")
    axes.set_facecolor(_UNSEEN)
    label = f"measured height above that of the level [{written.unit}]"
    axes.figure.colorbar(shown, ax=axes, label=label, pad=0.1, shrink=0.8)
    if max(scan.levels.shape) <= LEGIBLE:
        middle_x, middle_y = (line.tolist() for line in scan.field.middles())
        for (x, y), level in np.ndenumerate(scan.levels):
            text = "?" if not scan.seen[x, y] else "" if scan.frame[x, y] else f"{level}"
            weight = "bold" if scan.seen[x, y] and scan.confidence[x, y] < SURE else "normal"
            axes.text(middle_x[x], middle_y[y], text, ha="center", va="center", fontsize=9, weight=weight)
    unseen = "; ?: not seen" if not scan.seen.all() else ""
    axes.set_title(f"levels, and how far the tops are from them{unseen}")


_TOO_HIGH, _TOO_LOW = (0.84, 0.19, 0.15), (0.13, 0.40, 0.67)
_RIGHT, _UNSEEN_CELL = (0.93, 0.95, 0.92), (0.73, 0.73, 0.73)
"""Red and blue of about equal lightness (ends of ColorBrewer's RdBu), which colour-blind people tell apart; greys."""


def comparison_plot(comparison: Comparison, format: str = "png", units: str = "cm") -> bytes:  # noqa: A002  # matplotlib's word
    """Return the picture as the bytes of an image file, north up: what to change, next to the field as it should be.

    units: of lengths, as in recipes
    """
    n_x, n_y = comparison.wanted.shape
    figure = figure_of(14, 6.2 * n_y / n_x + 1.4, 3.5, 14)
    changes, wanted = figure.subplots(1, 2)
    _draw_changes(changes, comparison, lengths_in(units))
    title = draw_heights(wanted, ColouredField(field=comparison.wanted, units=units))
    wanted.set_title(f"as it should be: {title}")
    figure.suptitle(cell_counts(comparison))
    figure.draw_without_rendering()  # places the axes, so that there is room for as many numbers as are asked for
    for axes in (changes, wanted):
        number_cells(axes, comparison.wanted)
    return encoded(figure, format)


def cell_counts(comparison: Comparison) -> str:
    """Return a line: the numbers of cells that are right, too high, too low and not seen."""
    cells = comparison.wrong.size
    high, low = int((comparison.differences > 0).sum()), int((comparison.differences < 0).sum())
    unseen = int((~comparison.seen).sum())
    counts = {"too high": high, "too low": low, "not seen": unseen}
    others = ", ".join(f"{count} {name}" for name, count in counts.items() if count)
    turned = f", turned by {comparison.turns * 90} degrees" * bool(comparison.turns)
    return f"{cells - high - low - unseen} of {cells} cells are right{turned}" + (f"; {others}" if others else "")


def _draw_changes(axes: Axes, comparison: Comparison, written: Lengths) -> None:
    off = comparison.differences
    colours = np.select(
        [~comparison.seen[..., None], off[..., None] > 0, off[..., None] < 0],
        [_UNSEEN_CELL, _TOO_HIGH, _TOO_LOW],
        _RIGHT,
    )
    show_cells(axes, comparison.wanted, colours)
    if max(off.shape) <= LEGIBLE:
        edges_x, edges_y = comparison.wanted.edges()
        axes.set_xticks(edges_x, minor=True)
        axes.set_yticks(edges_y, minor=True)
        axes.grid(which="minor", color="white", linewidth=1.5)
        axes.tick_params(which="minor", length=0)
        # Heights that are right, and of the others both: that which stands, and that which should.
        middle_x, middle_y = (line.tolist() for line in comparison.wanted.middles())
        style: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": min(10.0, 110 / max(off.shape))}
        for x, y in np.argwhere(~comparison.wrong & ~comparison.wanted.frame):
            right = written.measured(float(comparison.wanted.heights[x, y]), 3)
            axes.text(middle_x[x], middle_y[y], right if comparison.seen[x, y] else "?", color="#8a8f88", **style)
        for x, y, height, wanted in comparison.changes():
            text = f"{written.measured(height, 1)}\n\u2192 {written.measured(wanted, 1)}"
            axes.text(middle_x[x], middle_y[y], text, color="white", weight="bold", **style)
    axes.set_title(f"what to change [{written.unit}]; red: too high, blue: too low, grey: not seen")
