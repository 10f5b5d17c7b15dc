"""A scan from above with the grid that was found in it, beside how far each top is from its level."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rsegen.exporters.pictures.plan import LEGIBLE, number_cells
from rsegen.exporters.pictures.preview import encoded
from rsegen.field.scanning import SURE, Scan
from rsegen.field.stepfield import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_MOST_POINTS = 60_000
_FARTHEST = 1e9
_MARGIN = 0.25
"""Metres of floor that are shown round the field."""

_UNSEEN = "#b9b9b9"


def scan_plot(scan: Scan, points: Array, format: str = "png") -> bytes:  # noqa: A002  # matplotlib's word
    """The picture as the bytes of an image file.

    points: (n, 3) of the cloud that was read [m]; some of them are drawn
    """
    from matplotlib.figure import Figure

    n_x, n_y = scan.levels.shape
    height = float(np.clip(5.6 * n_y / n_x + 1.2, 3.5, 12))
    figure = Figure(figsize=(14, height), dpi=100, layout="constrained")
    from_above, residuals = figure.subplots(1, 2)
    _draw_points(from_above, scan, points)
    _draw_errors(residuals, scan)
    figure.draw_without_rendering()  # places the axes, so that there is room for as many numbers as are asked for
    number_cells(residuals, scan.field)
    seen = int(scan.seen.sum())
    figure.suptitle(
        f"{n_x} x {n_y} cells of {scan.measured_width * 100:.2f} cm, unit {scan.measured_unit * 100:.2f} cm; "
        f"{seen} of {scan.seen.size} cells seen; a point is {scan.noise * 1000:.1f} mm off (standard deviation)"
    )
    return encoded(figure, format)


def _draw_points(axes: Axes, scan: Scan, points: Array) -> None:
    few = points[:: max(1, len(points) // _MOST_POINTS)]
    x, y, z = scan.placed(few[(np.abs(few) < _FARTHEST).all(axis=1)]).T
    half_x, half_y = (cells * scan.measured_width / 2 for cells in scan.levels.shape)
    near = (np.abs(x) < half_x + _MARGIN) & (np.abs(y) < half_y + _MARGIN)
    order = np.argsort(z[near])
    highest = max(float(np.nanmax(scan.heights, initial=0)), scan.measured_unit)
    drawn = axes.scatter(
        x[near][order],
        y[near][order],
        c=z[near][order] * 100,
        s=3,
        linewidths=0,
        cmap="viridis",
        vmin=0,
        vmax=highest * 100,
        rasterized=True,
    )
    figure = axes.figure
    figure.colorbar(drawn, ax=axes, label="height above the ground [cm]")
    for cells, half, other, line in ((0, half_x, half_y, axes.vlines), (1, half_y, half_x, axes.hlines)):
        line(np.linspace(-half, half, scan.levels.shape[cells] + 1), -other, other, colors="#d62728", linewidth=0.8)
    axes.set(xlabel="x [m]", ylabel="y [m]", title="the points from above, and the grid that was found", aspect="equal")


def _draw_errors(axes: Axes, scan: Scan) -> None:
    half = scan.measured_unit * 50
    edges_x, edges_y = scan.field.edges()
    shown = axes.imshow(
        np.ma.masked_invalid(scan.errors * 100).T,
        cmap="RdBu_r",
        vmin=-half,
        vmax=half,
        origin="lower",
        interpolation="none",
        extent=(edges_x[0], edges_x[-1], edges_y[0], edges_y[-1]),
    )
    axes.set_facecolor(_UNSEEN)
    axes.figure.colorbar(shown, ax=axes, label="measured height above that of the level [cm]", pad=0.1)
    if max(scan.levels.shape) <= LEGIBLE:
        middle_x, middle_y = (((line[:-1] + line[1:]) / 2).tolist() for line in (edges_x, edges_y))
        for (x, y), level in np.ndenumerate(scan.levels):
            text = "?" if not scan.seen[x, y] else "" if scan.frame[x, y] else f"{level}"
            weight = "bold" if scan.seen[x, y] and scan.confidence[x, y] < SURE else "normal"
            axes.text(middle_x[x], middle_y[y], text, ha="center", va="center", fontsize=9, weight=weight)
    unseen = "; ?: not seen" if not scan.seen.all() else ""
    axes.set_title(f"levels, and how far the tops are from them{unseen}")
