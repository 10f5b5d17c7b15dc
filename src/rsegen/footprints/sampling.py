"""Spots: even places drawn at random, such that robots on them do not overlap."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from rsegen.errors import ParameterError
from rsegen.field.stepfield import StepField
from rsegen.footprints.footprint import Footprint
from rsegen.footprints.search import GOOD, Candidates, apart, candidates
from rsegen.params.streams import randint

_HELP = "add a platform obstacle, or give a smaller robot or another map"


@dataclass(frozen=True, kw_only=True, slots=True)
class Spot:
    """A place for a start or a goal: where a robot stands level on the blocks and nothing else touches them.

    x, y, z: of the robot's origin, z that of the ground under its wheels or tracks, metres; yaw: its heading, radians
    difference: between the highest and the lowest block under the whole robot, metres
    support_difference: between those under its wheels or tracks
    unevenness: 0; only where an uneven place was allowed how much it has too much of both, metres
    """

    x: float
    y: float
    z: float
    yaw: float
    difference: float
    support_difference: float
    unevenness: float = 0.0


def even_spots(
    field: StepField,
    footprint: Footprint,
    count: int,
    rng: np.random.Generator,
    *,
    gap: float = 0.0,
    evenest: bool = False,
) -> tuple[Spot, ...]:
    """`count` spots at least `gap` metres apart, of the best rank that is left each time.

    evenest: where no even place is left, take the one with the least unevenness. ParameterError if there are too few.
    """
    found: list[Candidates] = []
    for tile in candidates(field, footprint, rng):
        found.append(tile)
        if len(chosen := _drawn(tile, footprint, count, gap, rng, 1.0)) == count:
            return _spots(tile, chosen)
    if not found:
        n_x, n_y = field.shape
        raise ParameterError("robot", f"too large for {n_x} x {n_y} cells; give a smaller robot or a larger map")
    whole = Candidates.joined(found)
    chosen = _drawn(whole, footprint, count, gap, rng, np.inf if evenest else GOOD)
    if len(chosen) < count:
        raise _too_few(whole, footprint, len(chosen), count, evenest=evenest)
    return _spots(whole, chosen)


def _drawn(
    found: Candidates, footprint: Footprint, count: int, gap: float, rng: np.random.Generator, below: float
) -> list[int]:
    """The indices of up to `count` candidates that do not overlap, each drawn among the best of those that are left."""
    chosen: list[int] = []
    free = found.rank < below
    while len(chosen) < count and free.any():
        best = np.flatnonzero(free & (found.rank <= found.rank[free].min() + 1e-9))
        index = int(best[randint(rng, 0, len(best) - 1)])
        chosen.append(index)
        pose = float(found.x[index]), float(found.y[index]), float(found.yaw[index])
        free &= apart(footprint.outline, gap, pose, found.x, found.y, found.yaw)
    return chosen


def _spots(found: Candidates, chosen: list[int]) -> tuple[Spot, ...]:
    return tuple(_spot(found, index) for index in chosen)


def _spot(found: Candidates, index: int) -> Spot:
    def rounded(values: np.ndarray) -> float:
        return round(float(values[index]), 9) + 0.0

    return Spot(
        x=rounded(found.x),
        y=rounded(found.y),
        z=rounded(found.z),
        yaw=rounded(found.yaw),
        difference=rounded(found.whole),
        support_difference=rounded(found.support),
        unevenness=0.0 if found.rank[index] < GOOD else rounded(found.uneven),
    )


def _too_few(found: Candidates, footprint: Footprint, chosen: int, count: int, *, evenest: bool) -> ParameterError:
    """The error that says how many places there are, or what is wrong with the best."""
    if chosen:
        what = "room" if evenest else "even places"
        return ParameterError("count", f"found {what} for {chosen} of {count} on this map; give fewer, or {_HELP}")
    best = int(found.uneven.argmin())
    return ParameterError("robot", f"no place is even enough: {'; '.join(_reasons(found, footprint, best))}; {_HELP}")


def _reasons(found: Candidates, footprint: Footprint, best: int) -> Iterator[str]:
    """What is wrong with the best place."""
    support, hung = found.support[best], found.hung[best]
    if support > footprint.limit:
        yield (
            f"at the best one the blocks under its wheels or tracks differ by {_cm(support)} cm, "
            f"and it stands level within {_cm(footprint.limit)} cm"
        )
    elif hung > 0:
        yield f"at the best one it would hang on a block that is {_cm(hung)} cm too high"
    else:
        yield f"at the best one the blocks under it differ by {_cm(found.whole[best])} cm; allow more than now"


def _cm(metres: float) -> str:
    return f"{100 * metres:.3g}"
