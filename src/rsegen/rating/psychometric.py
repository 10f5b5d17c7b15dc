"""The share of crossings over the difficulty of fields: a psychometric curve, its posterior, and the next trials.

    p(u) = (1 - lapse) / (1 + exp((u - middle) / spread))     u: logarithm of the level, so that a unit of 2 is as far
                                                              from 1 as 4 from 2

    1 |--.                middle   half are crossed there, but for lapses
      |   '.              spread   how gently the curve falls
      |     '.            lapse    share of easy fields that are not crossed either
    0 |_______'--___ u

The posterior of the three is held on a grid: first a coarse one over all middles, then a fine one over those that the
trials leave (Watson and Pelli, QUEST, Perception & Psychophysics 33, 1983, with all parameters unknown as in Watson,
QUEST+, J. Vision 17(3), 2017). The next trial is put where its outcome is expected to tell most about the middle,
which is the Psi method (Kontsevich and Tyler, Vision Research 39, 1999) with spread and lapse as nuisances (Prins,
J. Vision 13(7), 2013): with the spread as its own aim it took a fifth to two fifths more trials. Several trials
are chosen together: after each, an outcome is drawn from what is known so far, and the next is chosen as if it had
come. So they do not depend on who makes them, or how many at a time.

Priors: middles even over the axis and a factor of 3 beyond it; spreads log-normal around 0.2; lapses up to 8 %, small
ones more likely. Cost: some 10 ms for a batch of eight trials. What breaks it: outcomes that depend on each other, as
on one field; a mixture of kinds of fields, whose curve has steps; more lapses than 8 %; spreads below the least of the
grid, for which the level of 80 % comes out too low.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import log
from typing import TYPE_CHECKING

import numpy as np

from rsegen.field.stepfield import Array, Mask

if TYPE_CHECKING:
    from numpy.random import Generator

SPREADS = np.geomspace(0.03, 1.5, 14)
"""Spreads of curves: from a fall within a tenth of the level, as of a robot that always does the same, to decades."""

LAPSES = np.array([0.0, 0.01, 0.02, 0.04, 0.08])
"""Shares of easy fields that are not crossed: few, as a robot on nearly level ground arrives."""

_LAPSE_WEIGHTS = np.array([0.35, 0.25, 0.2, 0.13, 0.07])

_SPREAD_WEIGHTS = np.exp(-((np.log(SPREADS / 0.2) / 0.9) ** 2) / 2)
"""Prior of the spreads, log-normal. With an even prior, a few trials that happen to be in order make a curve look like
a step and a rating end early: only 85 % of the intervals that ended such a rating held the truth."""

_BEYOND = log(3)
"""Largest distance of a middle from the levels of an axis: farther away, these levels show no difference."""

_COARSE, _FINE = 0.04, 81
"""Distance between middles of the coarse grid, and number of middles of the fine one."""

_LEFT_OUT = 1e-6
"""Share of the posterior that the fine grid may leave out at either end."""

_CANDIDATES = 48
"""Levels that are compared for the next trial, at most: neighbours differ by less than a spread."""

_FAR = 4.0
"""Spreads from the middle beyond which an outcome is as good as known: 1 / (1 + exp(4)) is 2 %."""

LEVEL = 0.025
"""95 % interval: this share of the posterior is below it, and as much above it."""


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Posterior:
    """Probabilities of curves on a grid: `weights` (middles, spreads, lapses), which add up to 1."""

    middles: Array
    weights: Array

    def shares(self, u: Array) -> Array:
        """Return the share that is crossed at some u by each curve of the grid, (n, middles, spreads, lapses)."""
        return _shares(u, self.middles)

    def expected(self, u: Array) -> Array:
        """Return the expected share that is crossed at some u, (n,)."""
        return np.asarray(np.tensordot(self.shares(u), self.weights, 3))

    def band(self, u: Array) -> tuple[Array, Array]:
        """Return the ends of the 95 % interval of the share that is crossed at each u, (n,) each."""
        ends = [_quantiles(shares, self.weights, (LEVEL, 1 - LEVEL)) for shares in self.shares(u)]
        low, high = np.transpose(ends)
        return low, high

    def at_share(self, share: float) -> tuple[float, float, float]:
        """Return u at which a share of fields is crossed: median, and the ends of the 95 % interval."""
        z = np.log((1 - LAPSES) / share - 1)
        u = self.middles[:, None, None] + SPREADS[:, None] * z
        middle, low, high = _quantiles(u, self.weights, (0.5, LEVEL, 1 - LEVEL)).tolist()
        return middle, low, high

    def below(self, share: float, u: float) -> float:
        """Return the probability that a share of fields is crossed at a u below this one at most."""
        z = np.log((1 - LAPSES) / share - 1)
        return float(self.weights[self.middles[:, None, None] + SPREADS[:, None] * z < u].sum())

    def spread(self) -> tuple[float, float, float]:
        """Return the spread: median, and the ends of the 95 % interval."""
        marginal = self.weights.sum((0, 2))
        middle, low, high = np.exp(_quantiles(np.log(SPREADS), marginal, (0.5, LEVEL, 1 - LEVEL))).tolist()
        return middle, low, high

    def lapse(self) -> float:
        """Return the expected lapse."""
        return float(self.weights.sum((0, 1)) @ LAPSES)


def posterior(u: Sequence[float] | Array, crossed: Sequence[bool] | Mask, low: float, high: float) -> Posterior:
    """Return the posterior after trials at some u; low, high: the ends of the axis."""
    # Trials at one place count together, as there are far fewer places than trials. First the coarse grid, then the
    # fine one over the middles that have all but `_LEFT_OUT` of the posterior at either end.
    places, which = np.unique(np.asarray(u, float), return_inverse=True)
    crossings = np.bincount(which, np.asarray(crossed, float)).astype(float)
    misses = np.bincount(which).astype(float) - crossings
    middles = np.arange(low - _BEYOND, high + _BEYOND + _COARSE, _COARSE)
    mass = _weights(places, crossings, misses, middles).sum((1, 2))
    until = np.cumsum(mass)
    first, last = np.searchsorted(until, [_LEFT_OUT, 1 - _LEFT_OUT])
    ends = middles[max(first - 1, 0)], middles[min(last + 1, len(middles) - 1)]
    fine = np.linspace(*ends, _FINE)
    return Posterior(middles=fine, weights=_weights(places, crossings, misses, fine))


def _weights(u: Array, crossings: Array, misses: Array, middles: Array) -> Array:
    shares = _shares(u, middles)
    logarithms = np.tensordot(crossings, np.log(shares), 1) + np.tensordot(misses, np.log1p(-shares), 1)
    weights = np.exp(logarithms - logarithms.max()) * _SPREAD_WEIGHTS[:, None] * _LAPSE_WEIGHTS
    return np.asarray(weights / weights.sum())


_LEAST = 1e-9
"""Least share that is crossed, and that is not: no single trial may rule a curve out."""


def _shares(u: Array, middles: Array) -> Array:
    z = (u[:, None, None] - middles[:, None]) / SPREADS
    falling = 1 / (1 + np.exp(np.clip(z, -40, 40)))
    return np.asarray(np.clip((1 - LAPSES) * falling[..., None], _LEAST, 1 - _LEAST))


def _quantiles(values: Array, weights: Array, shares: Sequence[float]) -> Array:
    """Return the values below which these shares of the weights are, interpolated between the points of the grid."""
    order = np.argsort(values, axis=None)
    weight = weights.ravel()[order]
    return np.interp(shares, np.cumsum(weight) - weight / 2, values.ravel()[order])


def next_places(known: Posterior, candidates: Array, count: int, rng: Generator) -> list[float]:
    """Return the u of the next `count` trials, chosen among some candidates in rising order, (n,)."""
    # Something can be learned only where the outcome is open.
    reach = _FAR * np.exp(known.weights.sum((0, 2)) @ np.log(SPREADS))
    near = candidates[(candidates > known.middles[0] - reach) & (candidates < known.middles[-1] + reach)]
    near = near if len(near) else candidates
    near = near[:: -(-len(near) // _CANDIDATES)]
    shares, weights, chosen = known.shares(near), known.weights, []
    for _ in range(count):
        best = int(np.argmax(np.round(_information(shares, weights), 9)))  # rounded: the same one on every machine
        # As if that trial had ended, by chance as likely as now known: else all of a batch would be at one place.
        likely = shares[best] if rng.random() < float((shares[best] * weights).sum()) else 1 - shares[best]
        weights = weights * likely
        weights = weights / weights.sum()
        chosen.append(float(near[best]))
    return chosen


def _information(shares: Array, weights: Array) -> Array:
    """Return the expected information of an outcome about the middle at each candidate, nats.

    That is the entropy of the outcome, less the entropy that is left if the middle is known.
    """
    by_middle = weights.sum((1, 2))
    crossed = (shares * weights).sum((2, 3)) / np.maximum(by_middle, 1e-300)
    return np.asarray(_entropy((crossed * by_middle).sum(1)) - (_entropy(crossed) * by_middle).sum(1))


def _entropy(share: Array) -> Array:
    share = np.clip(share, _LEAST, 1 - _LEAST)
    return np.asarray(-share * np.log(share) - (1 - share) * np.log1p(-share))
