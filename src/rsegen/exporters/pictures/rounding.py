"""How far heights were rounded to the levels of a map, cell by cell, as a picture."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rsegen.exporters.pictures.plan import LEGIBLE
from rsegen.exporters.pictures.preview import figure_bytes
from rsegen.exporters.scene import Scene
from rsegen.field.stepfield import Array, Mask

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def rounding_plot(scene: Scene, errors_cm: Array, holes: Mask, format: str = "png") -> bytes:  # noqa: A002  # matplotlib's word
    """The picture as the bytes of an image file, north up, which carries the map's recipe.

    errors_cm, holes: (n_x, n_y), by how much each block was measured above its level [cm], and which were filled.
    """
    from matplotlib.figure import Figure

    n_x, n_y = errors_cm.shape
    figure = Figure(figsize=(8, float(np.clip(6.5 * n_y / n_x + 1, 3, 16))), dpi=100, layout="constrained")
    axes = figure.subplots()
    half = scene.recipe.unit_cm / 2
    shown = axes.imshow(
        np.ma.masked_array(errors_cm, holes).T,
        cmap="RdBu_r",
        vmin=-half,
        vmax=half,
        origin="lower",
        interpolation="none",
    )
    axes.set_facecolor("#999999")  # holes
    axes.set(xlabel="x [cells]", ylabel="y [cells]", title="measured height above that of the block [cm]")
    figure.colorbar(shown, ax=axes, label="cm")
    if max(n_x, n_y) <= LEGIBLE:
        _write(axes, errors_cm, holes, half)
    filled = f"; grey: {int(holes.sum()):,} filled" if holes.any() else ""
    figure.suptitle(f"{scene.name}: rounded to {scene.recipe.unit_cm:g} cm{filled}")
    return figure_bytes(figure, scene, format)


def _write(axes: Axes, errors_cm: Array, holes: Mask, half: float) -> None:
    for (x, y), error in np.ndenumerate(errors_cm):
        text = "hole" if holes[x, y] else f"{round(error, 1) + 0:+.1f}"
        colour = "white" if abs(error) > 0.6 * half or holes[x, y] else "black"
        axes.text(x, y, text, ha="center", va="center", fontsize=7, color=colour)
