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
    support_difference: between the highest and the lowest block under its wheels or tracks, metres
    unevenness: 0, or at an uneven place, if these are allowed, the sum by which its limits are exceeded, metres
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
    """Return `count` spots at least `gap` metres apart, each drawn among the best that are left.

    evenest: if no even place is left, take the one with the least unevenness. ParameterError if there are too few.
    """
    # One tile of a large map most often has enough places of the best kind; only if none has, all tiles are compared.
    tiles: list[Candidates] = []
    for tile in candidates(field, footprint, rng):
        tiles.append(tile)
        if len(chosen := _drawn(tile, footprint, count, gap, rng, 1.0)) == count:
            return tuple(_spot(tile, index) for index in chosen)
    if not tiles:
        n_x, n_y = field.shape
        raise ParameterError("robot", f"too large for {n_x} x {n_y} cells; give a smaller robot or a larger map")
    whole = Candidates.joined(tiles)
    chosen = _drawn(whole, footprint, count, gap, rng, np.inf if evenest else GOOD)
    if len(chosen) < count:
        raise _too_few(whole, footprint, len(chosen), count, evenest=evenest)
    return tuple(_spot(whole, index) for index in chosen)


def _drawn(
    places: Candidates, footprint: Footprint, count: int, gap: float, rng: np.random.Generator, below: float
) -> list[int]:
    """Return the indices of up to `count` places that do not overlap, each drawn among the best that are left."""
    chosen: list[int] = []
    free = places.rank < below
    while len(chosen) < count and free.any():
        best = np.flatnonzero(free & (places.rank <= places.rank[free].min() + 1e-9))
        index = int(best[randint(rng, 0, len(best) - 1)])
        chosen.append(index)
        pose = float(places.x[index]), float(places.y[index]), float(places.yaw[index])
        free &= apart(footprint.outline, gap, pose, places.x, places.y, places.yaw)
    return chosen


def _spot(places: Candidates, index: int) -> Spot:
    def rounded(values: np.ndarray) -> float:
        return round(float(values[index]), 9) + 0.0

    return Spot(
        x=rounded(places.x),
        y=rounded(places.y),
        z=rounded(places.z),
        yaw=rounded(places.yaw),
        difference=rounded(places.whole),
        support_difference=rounded(places.support),
        unevenness=0.0 if places.rank[index] < GOOD else rounded(places.uneven),
    )


def _too_few(places: Candidates, footprint: Footprint, chosen: int, count: int, *, evenest: bool) -> ParameterError:
    """Return the error that says how many places there are, or what is wrong with the best."""
    if chosen:
        what = "room" if evenest else "even places"
        return ParameterError("count", f"found {what} for {chosen} of {count} on this map; give fewer, or {_HELP}")
    best = int(places.uneven.argmin())
    return ParameterError("robot", f"no place is even enough: {'; '.join(_reasons(places, footprint, best))}; {_HELP}")


def _reasons(places: Candidates, footprint: Footprint, best: int) -> Iterator[str]:
    """Yield the reasons why the best place is not even enough."""
    support, hung = places.support[best], places.hung[best]
    if support > footprint.limit:
        yield (
            f"at the best one the blocks under its wheels or tracks differ by {_cm(support)} cm, "
            f"and it stands level within {_cm(footprint.limit)} cm"
        )
    elif hung > 0:
        yield f"at the best one it would hang on a block that is {_cm(hung)} cm too high"
    else:
        yield f"at the best one the blocks under it differ by {_cm(places.whole[best])} cm; allow more than now"


def _cm(metres: float) -> str:
    return f"{100 * metres:.3g}"
