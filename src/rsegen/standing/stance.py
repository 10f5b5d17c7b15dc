"""The stance of a robot: its pose on level ground, and the parts that bear it there, or hang above the ground."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rsegen.field.stepfield import Array, Mask
from rsegen.standing.body import Body
from rsegen.standing.ground import SINGLE, PaddedGround
from rsegen.standing.pushing import TOUCHING, sample_heights
from rsegen.standing.resting import Poses, of_settled
from rsegen.standing.settling import outer_radius, settled_on_level


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Stance:
    """A robot at rest on level ground.

    pose: its one pose, with its origin at 0, 0; bearing: which of its parts touch the ground, (parts,)
    heights: the lowest sample of each part above the ground, metres, (parts,); infinite for one that has none
    """

    pose: Poses
    bearing: Mask
    heights: Array


def stance_on(ground: PaddedGround, body: Body) -> Stance:
    """Return how a robot stands on level ground that is as large as a given one."""
    level, rest = settled_on_level(ground, body)
    _, above = sample_heights(level, body, rest, np.zeros(1, np.intp))
    heights = np.full(len(body.parts), np.inf)
    np.minimum.at(heights, body.part, above[0])
    return Stance(pose=of_settled(level, body, rest), bearing=heights < TOUCHING, heights=heights)


def stance(body: Body) -> Stance:
    """Return how a robot stands on level ground."""
    # One block, wide enough for a robot that also stands on its border.
    wide = PaddedGround(np.zeros(81, SINGLE), (9, 9), 2 * outer_radius(body), (4.5, 4.5), 4, 2)
    return stance_on(wide, body)
