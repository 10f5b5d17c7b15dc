"""A picture of the rounding errors of measured heights."""

from __future__ import annotations

import numpy as np

from rsegen.field.stepfield import Array, Mask
from rsegen.params.numbers import lengths_in
from rsegen.pictures.plan import LEGIBLE
from rsegen.pictures.preview import figure_bytes, figure_of
from rsegen.scene.scene import Scene


def rounding_plot(scene: Scene, errors_cm: Array, holes: Mask, format: str = "png") -> bytes:  # noqa: A002  # matplotlib's word
    """Return the picture as the bytes of an image file, north up, which carries the map's recipe.

    errors_cm: (n_x, n_y), measured height of each block above its level [cm]; holes: (n_x, n_y), true if filled.
    """
    from matplotlib.ticker import MaxNLocator

    # The colours end at half a unit, the largest possible rounding.
    n_x, n_y = errors_cm.shape
    figure = figure_of(8, 6.5 * n_y / n_x + 1, 3, 16)
    axes = figure.subplots()
    written = lengths_in(scene.units)
    errors = errors_cm / 100 * written.per_metre
    half = scene.recipe.unit_cm / 200 * written.per_metre
    shown = axes.imshow(
        np.ma.masked_array(errors, holes).T, cmap="RdBu_r", vmin=-half, vmax=half, origin="lower", interpolation="none"
    )
    axes.set_facecolor("#999999")  # holes
    axes.set(xlabel="x [cells]", ylabel="y [cells]", title=f"measured height above that of the block [{written.unit}]")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(integer=True))
    figure.colorbar(shown, ax=axes, label=written.unit, shrink=0.8)
    if max(n_x, n_y) <= LEGIBLE:
        for (x, y), error in np.ndenumerate(errors):
            text = "hole" if holes[x, y] else f"{round(error, 1) + 0:+.1f}"
            colour = "white" if abs(error) > 0.6 * half or holes[x, y] else "black"
            axes.text(x, y, text, ha="center", va="center", fontsize=7, color=colour)
    filled = f"; grey: {int(holes.sum()):,} filled" if holes.any() else ""
    figure.suptitle(f"{scene.name}: rounded to {written.with_unit(scene.recipe.unit_cm / 100, 3)}{filled}")
    return figure_bytes(figure, scene, format)
