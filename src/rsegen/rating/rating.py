"""The result of `rsegen.rate`: for each judge its trials and curve, as a report, tables and a plot.

rating.json     curves with their intervals, and each trial with the command that drives it again
trials.csv      the same trials as a table
rating.png      shares that were crossed, with the number of trials, and the curves with their bands
recipe.json     the fields: the field of a trial is the map of its index, at its level
"""

from __future__ import annotations

import json
import shlex
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from functools import cached_property
from math import exp, inf
from typing import NamedTuple

import numpy as np

from rsegen.driving.many import csv_lines, wilson
from rsegen.field.stepfield import Array
from rsegen.params.command import Reported
from rsegen.params.numbers import decimal
from rsegen.pictures.preview import encoded, figure_of
from rsegen.rating.axes import Axis
from rsegen.rating.judges import Trial
from rsegen.rating.psychometric import Posterior, posterior
from rsegen.recipe.codec import encode, to_json
from rsegen.recipe.recipe import Recipe

HOLDS = "rating"

FILES = ("rating.json", "trials.csv", "rating.png", "recipe.json")

HALF, MOST = 0.5, 0.8
"""Shares of fields whose levels are reported. 80 % is the reliability that standard tests of robots ask for."""

_SURE = 0.975
"""Probability from which on a level is beyond the end of the axis: that of one end of a 95 % interval."""


class Estimate(NamedTuple):
    """A level at which a share of fields is crossed, with its 95 % interval, the lower end first.

    Each is infinity, or 0, if it is beyond the levels of the axis.
    """

    level: float
    low: float
    high: float


@dataclass(frozen=True, kw_only=True)
class Curve:
    """The trials of one judge, and the curve fitted to them.

    Attributes
    ----------
    by : str
        The judge, as `by` takes it.
    title : str
        The judge with its version.
    axis : Axis
        What makes fields harder.
    trials : tuple of Trial
        A row for each trial, in the order in which they were chosen.
    """

    by: str
    title: str
    axis: Axis
    trials: tuple[Trial, ...]

    @cached_property
    def posterior(self) -> Posterior:
        """Probabilities of psychometric curves, over places on the axis."""
        counted = [trial for trial in self.trials if trial.crossed is not None]
        places = [self.axis.place(trial.level) for trial in counted]
        return posterior(places, [bool(trial.crossed) for trial in counted], *self.axis.ends)

    def at_share(self, share: float) -> Estimate:
        """Return the level at which a share of fields is crossed."""
        middle, *ends = map(self.axis.level_within, self.posterior.at_share(share))
        return Estimate(middle, *sorted(ends))

    @property
    def half(self) -> Estimate:
        """The level at which half of the fields are crossed."""
        return self.at_share(HALF)

    @property
    def most(self) -> Estimate:
        """The level at which 80 % of the fields are crossed."""
        return self.at_share(MOST)

    @property
    def precision(self) -> float:
        """Half the width of the interval of `half`, as a factor less 1: 0.1 for a factor of 1.1 up and down.

        The level of half is near the middle of the interval, but seldom exactly there.
        """
        _, low, high = self.posterior.at_share(HALF)
        return exp((high - low) / 2) - 1

    @property
    def outside(self) -> str:
        """Reason why half is crossed at no level of the axis: `easy` or `hard`, as all levels are; else empty."""
        first, last = self.axis.ends
        if self.posterior.below(HALF, last) < 1 - _SURE:
            return "easy"
        return "hard" if self.posterior.below(HALF, first) > _SURE else ""

    @property
    def crossed(self) -> int:
        """Number of trials that crossed."""
        return sum(bool(trial.crossed) for trial in self.trials)

    def counts(self) -> Iterator[tuple[float, int, int]]:
        """Yield each level, rising, with the number of trials that crossed, and of trials with a result."""
        for level in sorted({trial.level for trial in self.trials}):
            crossed = [trial.crossed for trial in self.trials if trial.level == level and trial.crossed is not None]
            yield level, sum(crossed), len(crossed)

    def sentence(self, what: str, robot: str) -> str:
        """Return the result in words; what: the fields."""
        unit = {"prediction": "fields by", "function": "trials of"}.get(self.by, "drives in")
        counted = f"{len(self.trials)} {unit} {'a function' if self.by == 'function' else self.title}"
        if self.outside:
            first, last = (self.axis.shown(self.axis.level(end)) for end in self.axis.ends)
            share = "more" if self.outside == "easy" else "less"
            return f"{robot} crosses {share} than half of {what} at every level from {first} to {last}; {counted}"
        half, most = self.axis.shown(*self.half), self.axis.shown(*self.most)
        return f"{robot} crosses half of {what} at {half}, and 80 % at {most}; {counted}"


@dataclass(frozen=True, kw_only=True)
class Rating(Reported):
    """The result of `rsegen.rate`.

    Attributes
    ----------
    recipe : Recipe
        The fields, at the level that the recipe has; its maps are the fields of the trials.
    robot : str
        Its kind, or the name of the function.
    axis : Axis
        What makes fields harder.
    curves : tuple of Curve
        One for each judge.
    replay : tuple of str
        Flags of `rsegen drive`, besides the field, to drive a trial again; empty if it cannot.
    notes : tuple of str
        Warnings about the fields and curves, a sentence each.
    """

    recipe: Recipe
    robot: str
    axis: Axis
    curves: tuple[Curve, ...]
    replay: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def half(self) -> Estimate:
        """The level at which the first judge finds that half of the fields are crossed."""
        return self.curves[0].half

    @property
    def most(self) -> Estimate:
        """The level at which the first judge finds that 80 % of the fields are crossed."""
        return self.curves[0].most

    @property
    def fields_in_words(self) -> str:
        """The fields in words: `normal_random fields (10 x 10 blocks of 10 cm)`."""
        side, (n_x, n_y), recipe = self.recipe.chunk_size, self.recipe.chunks, self.recipe
        blocks = f"{n_x * side} x {n_y * side} blocks"
        width = "" if self.axis.parameter == "block_width_cm" else f" of {decimal(recipe.block_width_cm)} cm"
        unit = "" if self.axis.parameter == "unit_cm" else f", unit {decimal(recipe.unit_cm)} cm"
        return f"{recipe.name} fields ({blocks}{width}{unit})"

    def report(self) -> Iterator[str]:
        """Yield the lines that `rsegen rate` prints."""
        for curve in self.curves:
            yield f"{curve.sentence(self.fields_in_words, self.robot)}, seed {self.recipe.seed}"
            failed = [trial for trial in curve.trials if trial.crossed is None]
            if failed:
                many = (
                    "1 trial has no result" if len(failed) == 1 else f"{len(failed)} trials have no result; the first"
                )
                yield f"  {many}: {failed[0].failed}"
        yield from (f"note: {note}" for note in self.notes)

    def as_json(self) -> dict[str, object]:
        """Return the content of rating.json, which `rsegen rate --json` prints. Levels are as in a recipe."""
        return {
            "robot": self.robot,
            "axis": self.axis.name,
            "parameter": self.axis.parameter,
            "seed": self.recipe.seed,
            "recipe": encode(self.recipe),
            "curves": [self._curve_json(curve) for curve in self.curves],
            "notes": list(self.notes),
        }

    def _curve_json(self, curve: Curve) -> dict[str, object]:
        known = curve.posterior
        return {
            "by": curve.by,
            "title": curve.title,
            "outside": curve.outside,
            "half": None if curve.outside else _estimate_json(curve.half),
            "most": None if curve.outside else _estimate_json(curve.most),
            "spread": [round(value, 4) for value in known.spread()],
            "lapse": round(known.lapse(), 4),
            "trials": [{**asdict(trial), **self._again(curve, trial)} for trial in curve.trials],
        }

    def _again(self, curve: Curve, trial: Trial) -> Mapping[str, object]:
        """Return the parameters of the field of a trial, and the command that drives it again, in the folder."""
        values = self.axis.parameters_at(self.recipe, trial.level)
        flags = [word for name, value in values.items() for word in (f"--{name.replace('_', '-')}", f"{value:g}")]
        field = ["recipe.json", "--map", str(trial.map), *flags]
        if not self.replay or curve.by == "function":
            return {"parameters": values}
        robot = [*self.replay, *(["--duration", f"{trial.duration:g}"] if trial.duration else [])]
        if curve.by in ("classic", "sim"):  # whose motors are their own
            at = robot.index("--motors") if "--motors" in robot else len(robot)
            robot = [*robot[:at], *robot[at + 2 :], "--simulator", curve.by]
        return {"parameters": values, "drive": shlex.join(["rsegen", "drive", *field, *robot])}

    def csv(self) -> Iterator[bytes]:
        """Yield the lines of trials.csv."""
        names = [field.name for field in fields(Trial)]
        rows = ([curve.by, *asdict(trial).values()] for curve in self.curves for trial in curve.trials)
        return csv_lines(["by", *names], rows)

    def files(self) -> dict[str, Sequence[bytes]]:
        """Return the files of the rating by their names."""
        maps = max(len(curve.trials) for curve in self.curves)
        return {
            "rating.json": [json.dumps(self.as_json(), indent=1).encode() + b"\n"],
            "trials.csv": list(self.csv()),
            "rating.png": [plot(self)],
            "recipe.json": [to_json(replace(self.recipe, first_map=0, maps=maps)).encode()],
        }


def _estimate_json(levels: Estimate) -> dict[str, object]:
    level, low, high = (float(f"{level:.6g}") if 0 < level < inf else None for level in levels)
    return {"level": level, "interval": [low, high]}


_COLOURS = ("#1f5fbf", "#d9730d", "#2a8c4a", "#8a3ffc")

_POINTS = 161
"""Points of a curve in a plot."""

_PER_POINT = 0.09
"""Width of the levels that are one point of a plot, as a logarithm: narrow, and still with some trials."""


def plot(rating: Rating) -> bytes:
    """Draw a PNG: shares that were crossed with their Wilson intervals and numbers of trials; curves and 95 % bands."""
    figure = figure_of(8.5, 5.6, 4, 8)
    axes, axis = figure.subplots(), rating.axis
    places = np.linspace(*shown_places(rating.curves), _POINTS)
    levels = [axis.level(place) for place in places]
    # For each judge the band and curve, the tried levels, and the intervals of half and 80 % as thick bars.
    for colour, curve in zip(_COLOURS, rating.curves, strict=False):
        known = curve.posterior
        low, high = known.band(places)
        axes.fill_between(levels, low, high, color=colour, alpha=0.18, linewidth=0)
        axes.plot(levels, known.expected(places), color=colour, linewidth=2, label=_label(curve))
        for level, crossed, count in points_of(curve):
            share, (below, above) = crossed / count, wilson(crossed, count)
            axes.plot([level, level], [below, above], color=colour, linewidth=0.8, alpha=0.5)
            axes.plot([level], [share], "o", color=colour, markersize=3 + 1.1 * count**0.5, alpha=0.75)
            if len(rating.curves) == 1:
                axes.annotate(f"{count}", (level, share), (5, 5), textcoords="offset points", fontsize=7)
        if not curve.outside:
            for share in (HALF, MOST):
                ends = [axis.level(place) for place in np.clip(known.at_share(share)[1:], *axis.ends)]
                axes.plot(ends, [share, share], color=colour, linewidth=5, alpha=0.6, solid_capstyle="butt")
    for share in (HALF, MOST):
        axes.axhline(share, color="0.6", linewidth=0.8, linestyle=":", zorder=0)
    axes.set_xscale("log")
    axes.set(xlim=(levels[0], levels[-1]), ylim=(-0.04, 1.06), ylabel="share of fields that are crossed")
    axes.set_xlabel(axis_label(axis))
    axes.set_title(f"{rating.robot} on {rating.fields_in_words}, seed {rating.recipe.seed}", fontsize=11)
    ticks = ticks_between(*sorted((levels[0], levels[-1])))
    axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.set_xticks([], minor=True)
    axes.legend(loc="lower left", fontsize=8)
    return encoded(figure, "png", to_json(rating.recipe))


def _label(curve: Curve) -> str:
    counted = f"{curve.title}: {curve.crossed} of {len(curve.trials)} crossed"
    return counted if curve.outside else f"{counted}\nhalf at {curve.axis.shown(*curve.half)}"


def axis_label(axis: Axis) -> str:
    """Return the label of an axis in a plot."""
    unit = {"unit": "unit [cm]", "block_width": "width of a block [cm]", "slope": "slope [degrees]"}
    return f"{unit.get(axis.name, axis.name)}, harder to the right"


def shown_places(curves: Sequence[Curve]) -> tuple[float, float]:
    """Return the ends of a plot: from where nearly all fields are crossed to where hardly any is, on every curve."""
    # With all levels tried more than once, and all intervals that are drawn, but nothing beyond the axis.
    axis = curves[0].axis
    ends = [curve.posterior.at_share(share)[0] for curve in curves for share in (0.9, 0.03)]
    ends += [axis.place(level) for curve in curves for level, _, count in points_of(curve) if count > 1]
    inside = [curve.posterior for curve in curves if not curve.outside]
    ends += [place for known in inside for share in (HALF, MOST) for place in known.at_share(share)[1:]]
    first, last = axis.ends
    return max(min(ends) - 0.1, first), min(max(ends) + 0.1, last)


def points_of(curve: Curve) -> Iterator[tuple[float, int, int]]:
    """Yield the mean level of neighbouring trials, the number that crossed, and the number with a result."""
    bins: dict[int, list[tuple[float, int, int]]] = {}
    for level, crossed, count in curve.counts():
        if count:
            bins.setdefault(round(curve.axis.place(level) / _PER_POINT), []).append((level, crossed, count))
    for near in bins.values():
        levels, crossings, counts = map(np.array, zip(*near, strict=True))
        yield exp(float(np.log(levels) @ counts / counts.sum())), int(crossings.sum()), int(counts.sum())


def ticks_between(low: float, high: float) -> Array:
    """Return round levels between two ends, fewer of them on a wide axis."""
    steps = (1, 2, 5) if high / low > 12 else (1, 1.5, 2, 3, 4, 5, 6, 8) if high / low > 2 else np.arange(1, 10, 0.25)
    values = np.array([step * 10.0**power for power in range(-4, 4) for step in steps])
    return values[(values >= low) & (values <= high)]
