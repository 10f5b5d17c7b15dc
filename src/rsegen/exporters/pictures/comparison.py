"""What is built wrong, as a plan for the person with the mallet."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rsegen.exporters.numbers import decimal
from rsegen.exporters.pictures.field_picture import ColouredField
from rsegen.exporters.pictures.plan import LEGIBLE, draw_heights, number_cells
from rsegen.exporters.pictures.preview import encoded
from rsegen.field.comparison import Comparison

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_TOO_HIGH, _TOO_LOW, _RIGHT, _UNSEEN = (0.84, 0.19, 0.15), (0.13, 0.40, 0.67), (0.93, 0.95, 0.92), (0.73, 0.73, 0.73)


def comparison_plot(comparison: Comparison, format: str = "png") -> bytes:  # noqa: A002  # matplotlib's word
    """The picture as the bytes of an image file, north up: what to change, beside the field as it should be."""
    from matplotlib.figure import Figure

    n_x, n_y = comparison.wanted.shape
    figure = Figure(figsize=(14, float(np.clip(6.2 * n_y / n_x + 1.4, 3.5, 14))), dpi=100, layout="constrained")
    changes, wanted = figure.subplots(1, 2)
    _draw_changes(changes, comparison)
    said = draw_heights(wanted, ColouredField(field=comparison.wanted))
    wanted.set_title(f"as it should be: {said}")
    figure.suptitle(summary(comparison))
    figure.draw_without_rendering()  # places the axes, so that there is room for as many numbers as are asked for
    for axes in (changes, wanted):
        number_cells(axes, comparison.wanted)
    return encoded(figure, format)


def summary(comparison: Comparison) -> str:
    """One line: how many cells are right, too high, too low and not seen."""
    cells = comparison.wrong.size
    high, low = int((comparison.differences > 0).sum()), int((comparison.differences < 0).sum())
    unseen = int((~comparison.seen).sum())
    counts = {"too high": high, "too low": low, "not seen": unseen}
    others = ", ".join(f"{count} {name}" for name, count in counts.items() if count)
    turned = f", turned by {comparison.turns * 90} degrees" * bool(comparison.turns)
    return f"{cells - high - low - unseen} of {cells} cells are right{turned}" + (f"; {others}" if others else "")


def _draw_changes(axes: Axes, comparison: Comparison) -> None:
    off = comparison.differences
    colours = np.select(
        [~comparison.seen[..., None], off[..., None] > 0, off[..., None] < 0], [_UNSEEN, _TOO_HIGH, _TOO_LOW], _RIGHT
    )
    edges_x, edges_y = comparison.wanted.edges()
    extent = (edges_x[0], edges_x[-1], edges_y[0], edges_y[-1])
    axes.imshow(colours.transpose(1, 0, 2), origin="lower", extent=extent, interpolation="nearest")
    if max(off.shape) <= LEGIBLE:
        axes.set_xticks(edges_x, minor=True)
        axes.set_yticks(edges_y, minor=True)
        axes.grid(which="minor", color="white", linewidth=1.5)
        axes.tick_params(which="minor", length=0)
        _write(axes, comparison)
    axes.set_title("what to change [cm]; red: too high, blue: too low, grey: not seen")


def _write(axes: Axes, comparison: Comparison) -> None:
    middle_x, middle_y = (((line[:-1] + line[1:]) / 2).tolist() for line in comparison.wanted.edges())
    size = min(10.0, 110 / max(comparison.wanted.shape))
    for x, y in np.argwhere(~comparison.wrong & ~comparison.wanted.frame):
        wanted_cm = decimal(round(float(comparison.wanted.heights[x, y]) * 100, 4))
        text = wanted_cm if comparison.seen[x, y] else "?"
        axes.text(middle_x[x], middle_y[y], text, ha="center", va="center", fontsize=size, color="#8a8f88")
    for x, y, height, wanted in comparison.changes():
        text = f"{decimal(round(height * 100, 1))}\n\u2192 {decimal(round(wanted * 100, 1))}"
        axes.text(middle_x[x], middle_y[y], text, ha="center", va="center", fontsize=size, color="white", weight="bold")
