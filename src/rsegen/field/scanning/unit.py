"""The height of one unit, from the heights at which a cloud has its tops."""

from __future__ import annotations

import numpy as np

from rsegen.errors import ScanError
from rsegen.field.stepfield import Array

_MOST_LEVELS = 12
_NEARLY_BEST = 0.85
_CLEAR = 0.25
"""How well heights have to agree on a unit, from 0 for heights at random to 1."""

_WRONG = 0.4


def find_unit(heights: Array, noise: float, given: float | None = None) -> float:
    """The height of a unit in a cloud [m]: the largest of which the heights above the ground are whole multiples.

    heights: of points or pixels above the ground [m]; given: what the unit should be, which is then found within a few
    per cent. A ScanError if the cloud has no such unit, or another one than the one that is given.
    """
    values, weights = _raised(heights, noise, given)
    highest = float(values[np.cumsum(weights) >= 0.98 * weights.sum()][0])
    candidates = np.geomspace(max(2 * noise, highest / _MOST_LEVELS, 0.003), highest * 1.06, 1500)
    agreement = _agreement(values, weights, candidates)
    best = float(agreement.max())
    last = int(np.flatnonzero(agreement >= _NEARLY_BEST * best)[-1])
    run = int(np.argmax(np.append(agreement[last::-1] < _NEARLY_BEST * best, True)))  # of candidates nearly as good
    first = last - run + 1
    found = float(candidates[first + int(agreement[first : last + 1].argmax())])
    if given is None:
        if best < _CLEAR:
            raise ScanError("the heights above the ground are no whole multiples of a unit; give unit_cm if they are")
        return found
    own = given * np.linspace(0.95, 1.05, 41)
    agrees = _agreement(values, weights, own)
    if best >= _CLEAR and agrees.max() < _WRONG * best:
        raise ScanError(
            f"blocks rise by {found * 100:.3g} cm in the cloud, not {given * 100:g} cm; give another unit_cm or values"
        )
    return float(own[int(agrees.argmax())]) if agrees.max() >= _CLEAR else given


def _raised(heights: Array, noise: float, given: float | None) -> tuple[Array, Array]:
    """Heights above the ground and their weights: of a histogram, so that one large plateau does not outweigh all."""
    above = heights[heights > (given / 2 if given else max(2 * noise, 0.005))]
    if len(above) < 20:
        raise ScanError("nothing is above the ground plane; is there a field in the cloud, and is it not upside down?")
    top = float(np.quantile(above, 0.995))
    counts, edges = np.histogram(above, bins=400, range=(0, top * 1.02))
    kept = counts > 0
    return ((edges[:-1] + edges[1:]) / 2)[kept], np.sqrt(counts[kept])


def _agreement(values: Array, weights: Array, units: Array) -> Array:
    """For each unit: the mean of cos(2 pi h / unit), 1 if all heights are whole multiples of it."""
    waves = np.cos(2 * np.pi * values[None] / units[:, None])
    return np.asarray(waves @ weights / weights.sum())
