"""Statistics of the poses in which a robot rests all over a field."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rsegen.field.stepfield import StepField
from rsegen.standing.body import Body
from rsegen.standing.ground import PaddedGround
from rsegen.standing.lattice import HEADINGS
from rsegen.standing.resting import of_settled
from rsegen.standing.settling import Settled, outer_radius, settle
from rsegen.standing.stable import stable_at

_SAMPLE = 128
"""Poses for which all stable ones are looked for, evenly spread: that is seventeen times the work, and the error of the
share is four in a hundred at most."""


@dataclass(frozen=True, kw_only=True, slots=True)
class PoseStatistics:
    """A robot at rest at the middle of every block, in evenly spaced headings.

    stands: share of these poses in which it stands; all other numbers are of those, and None if it stands in none
    ambiguous: share of places where it may stand in more than one way, of a sample
    tilt_median, tilt_p90: the tilt that half, and nine tenths, of the poses do not exceed, radians
    clearance_median, clearance_least: from the ground to the lowest part that neither drives nor bears, metres; None
    without such a part
    """

    stands: float
    ambiguous: float | None
    tilt_median: float | None
    tilt_p90: float | None
    clearance_median: float | None
    clearance_least: float | None


def pose_statistics(field: StepField, body: Body) -> PoseStatistics:
    """Return how a robot rests all over a field, with its middle above the middles of the blocks."""
    at = np.nonzero(~field.frame)
    x, y = (np.repeat(along[own], HEADINGS) for along, own in zip(field.middles(), at, strict=True))
    ground = PaddedGround.of(field, outer_radius(body))
    rest = settle(ground, body, x, y, np.tile(np.arange(HEADINGS) * 2 * np.pi / HEADINGS, len(at[0])))
    return statistics_of(ground, body, rest)


def statistics_of(ground: PaddedGround, body: Body, rest: Settled) -> PoseStatistics:
    """Return the statistics of robots at rest."""
    every = of_settled(ground, body, rest)
    sample = rest.some(np.unique(np.linspace(0, len(rest.x) - 1, _SAMPLE).astype(int))) if len(rest.x) else rest
    counts = stable_at(ground, body, sample.x, sample.y, sample.yaw).counts
    tilts, clearances = every.tilt[every.stands], every.clearance[every.stands & np.isfinite(every.clearance)]
    median, p90 = np.quantile(tilts, [0.5, 0.9]).tolist() if len(tilts) else (None, None)
    return PoseStatistics(
        stands=float(every.stands.mean()),
        ambiguous=float((counts > 1).sum() / (counts > 0).sum()) if counts.any() else None,
        tilt_median=median,
        tilt_p90=p90,
        clearance_median=float(np.median(clearances)) if len(clearances) else None,
        clearance_least=float(clearances.min()) if len(clearances) else None,
    )
