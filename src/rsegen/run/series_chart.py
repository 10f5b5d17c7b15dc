"""The chart of a series: the metric by which it rises, of every map, and plans of some of them."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from rsegen.exporters.pictures.plan import draw_cells
from rsegen.exporters.scene import Scene, compose
from rsegen.field.metrics.catalogue import RMS
from rsegen.field.stepfield import Array
from rsegen.recipe.codec import to_json
from rsegen.run.series_rows import SeriesPlan, SeriesRow

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


PLANS = 8
"""Plans that are drawn at most, evenly spaced: as many as are still large enough to be seen next to each other."""

_SWATCHES = 12
"""Heights in the legend at most, which has one line."""

_INK, _LINE, _PALE = "#2b2b33", "#d6336c", "#a9a9b5"


def chart(plan: SeriesPlan, rows: Sequence[SeriesRow]) -> bytes:
    """Return a PNG, which carries the recipe at difficulty 1."""
    from matplotlib.figure import Figure

    shown = _shown(len(rows))
    scenes = [_scene(plan, rows[number]) for number in shown]
    figure = Figure(figsize=(13, 7.4), dpi=100, layout="constrained")
    grid = figure.add_gridspec(2, len(shown), height_ratios=(2.6, 1))
    _draw_rise(figure.add_subplot(grid[0, :]), plan, rows, shown)
    for column, scene in enumerate(scenes):
        _draw_plan(figure.add_subplot(grid[1, column]), plan, scene, rows[shown[column]])
    _legend(figure, scenes)
    fields = "one field" if plan.same_field else f"{len(rows)} fields"
    figure.suptitle(f"{plan.recipe.name}: {fields}, difficulty {plan.from_:g} to {plan.to:g}, seed {plan.recipe.seed}")
    stream = io.BytesIO()
    figure.savefig(stream, format="png", metadata={"Description": to_json(plan.recipe)})
    return stream.getvalue()


def _shown(maps: int) -> list[int]:
    """Return the numbers of the maps that are drawn: the first, the last, and some between them."""
    return [int(number) for number in np.unique(np.rint(np.linspace(0, maps - 1, PLANS)))]


def _scene(plan: SeriesPlan, row: SeriesRow) -> Scene:
    recipe = replace(plan.whole(row.number), difficulty=row.recipe_difficulty)
    return compose(recipe, recipe.first_map)


def _draw_rise(axes: Axes, plan: SeriesPlan, rows: Sequence[SeriesRow], shown: Sequence[int]) -> None:
    from matplotlib.ticker import MaxNLocator

    # Asked for as a line, reached as points on it, what a field cannot reach as a gap between both.
    numbers = np.array([row.number for row in rows])
    asked, reached, full = (_column(plan, rows, name) for name in ("asked", "measured", "full"))
    axes.plot(numbers, asked, color=_LINE, linewidth=2, label=f"asked for: {_line_text(plan, full)}")
    if not plan.same_field:
        axes.plot(numbers, full, "_", color=_PALE, markersize=9, label="the field as it is: it gets no harder")
    axes.vlines(numbers, asked, reached, color=_INK, linewidth=1)
    size = float(np.clip(260 / len(rows), 2, 7))  # points of hundreds of maps do not overlap
    axes.plot(numbers, reached, "o", color=_INK, markersize=size, label="reached", zorder=3)
    marked = np.isin(numbers, shown)
    axes.plot(numbers[marked], reached[marked], "o", color="white", markersize=size * 0.45, zorder=4)
    unit = f" [{_unit(plan)}]" if _unit(plan) else ""
    name = "rms step between neighbouring blocks" if plan.by == RMS else plan.metric.name
    axes.set(xlabel="map (light in the middle: its plan is below)", ylabel=f"{name}{unit}")
    if plan.by == RMS:
        axes.set_ylim(bottom=0)
    axes.margins(x=0.02)
    axes.grid(visible=True, alpha=0.25)
    axes.spines[["top", "right"]].set_visible(False)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.legend(frameon=False, loc="lower right")


def _line_text(plan: SeriesPlan, full: Array) -> str:
    """Return the legend of the straight line."""
    if plan.by != RMS:
        return f"from level to as designed{'' if plan.same_field else ', in the mean of the fields'}"
    of = "the rms step of the field as it is" if plan.same_field else "the mean rms step of the fields as they are"
    return f"difficulty x {np.nan_to_num(full).mean():.3g} cm, {of}"


def _unit(plan: SeriesPlan) -> str:
    """Lengths are shown in centimetres."""
    return "cm" if plan.metric.unit == "m" else plan.metric.unit


def _column(plan: SeriesPlan, rows: Sequence[SeriesRow], name: str) -> Array:
    """Return a column of the table, as it is shown; NaN for values that do not exist."""
    cells = (getattr(row, name) for row in rows)
    values = np.array([np.nan if value is None else value for value in cells], dtype=float)
    return values * 100 if _unit(plan) == "cm" else values


def _draw_plan(axes: Axes, plan: SeriesPlan, scene: Scene, row: SeriesRow) -> None:
    draw_cells(axes, scene)
    (value,) = _column(plan, [row], "measured")
    reached = "" if row.measured is None else f"\n{value:.3g} {_unit(plan)}"
    axes.set_title(f"{row.number}: difficulty {row.difficulty:.3g}{reached}", fontsize=9, color=_INK)
    axes.set(xticks=[], yticks=[])
    for spine in axes.spines.values():
        spine.set(color=_INK, linewidth=0.5)


def _legend(figure: Figure, scenes: Sequence[Scene]) -> None:
    """Draw a swatch for every height in the plans, or for some of them evenly spaced."""
    from matplotlib.patches import Patch

    levels = sorted({level for scene in scenes for level in scene.field.level_counts() if level})
    few, unit = levels[:: -(-len(levels) // _SWATCHES) or 1], scenes[0].field.unit * 100
    swatches = [Patch(facecolor=scenes[0].colour(level), label=f"{level * unit:g} cm") for level in few]
    if swatches:
        figure.legend(handles=swatches, loc="outside lower center", ncols=len(swatches), frameon=False)
