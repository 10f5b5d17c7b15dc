"""The metrics of a map as the page shows them: name, value with its unit, meaning."""

from __future__ import annotations

from collections.abc import Iterator

from rsegen.exporters.lengths import Lengths
from rsegen.field.metrics import metrics
from rsegen.field.stepfield import StepField


def figures(field: StepField, written: Lengths) -> Iterator[tuple[str, str, str]]:
    """The metrics of a field, lengths in the units of its recipe; none if it has no block."""
    if field.frame.all():
        return
    found = metrics(field)

    def length(metres: float | None) -> str:
        return "–" if metres is None else f"{written.short(_tenth(metres))} {written.unit}"  # noqa: RUF001  # a dash

    spread, steps, rugged, opens = found.spread, found.steps, found.ruggedness, found.opening
    yield "mean height", length(spread.mean), f"{length(spread.lowest)} to {length(spread.highest)}"
    yield "standard deviation", length(spread.deviation), "of the heights"
    yield "entropy", f"{spread.entropy:.2f} bits", "of the distribution of levels"
    yield "mean step", length(steps.mean), "between neighbouring blocks"
    yield "rms step", length(steps.rms), f"largest {length(steps.highest)}"
    yield "TRI", length(rugged.tri), "terrain ruggedness index, root mean"
    yield "surface", f"{rugged.surface_ratio:.2f}", "area of the surface, over that of the plan"
    yield "opens west to east", length(opens.west_east), "smallest step at which the map can be crossed"
    yield "opens south to north", length(opens.south_north), "the same, from the south"
    if found.scale.hurst is not None:
        weak = ", weak: of few lags" if found.scale.hurst_is_weak else ""
        yield "Hurst exponent", f"{round(found.scale.hurst, 2) + 0:.2f}", f"how differences grow with distance{weak}"


def _tenth(metres: float) -> int:
    """Nanometres, rounded to a tenth of a millimetre."""
    return round(metres * 1e4) * 100_000
