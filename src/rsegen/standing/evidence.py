"""Evidence of drives about the places of a lattice: where a robot got on, and where it was held.

    o---o---o---x   o---o---o        a drive got on over three moves and was held at x: the next way keeps those three
    |passed |held   |unknown|        rather than ground that nobody has tried, and leads around x

Of each move, and each lane onto the map or off it, follows how surely the robot is held there, as the mean of a beta
distribution of little weight s, since most places hold a robot always or never:

    1 - q = (s exp(-h w) + passed) / (s + passed + held)

h w is the hazard of w metres, weighted by the risk that poses show. A robot gets over a way with the product of all
1 - q, so the surest way is the one with the least sum of -log(1 - q), here counted in metres, by 1/h: w where nobody
has been, a third of it after one drive that got on, some 4 m where one was held, and no limit where a place is closed.

Cost: one array operation a search. What breaks it: a place that holds only robots that come from one side.
"""

from __future__ import annotations

import numpy as np

from rsegen.field.stepfield import Array, Ints

MOVE, IN, OUT = range(3)
"""Parts of a way: a move on from a place, the lane onto the map that leads there, and the lane from there off it."""

_HAZARD = 0.3
"""Hazard h of ground that nobody has tried, per weighted metre. Of 120 drives along the first ways over 40 maps of
mixed-course, 13 such metres each, ten crossed, which is 0.2; of drives along the ways that were found at last with 0.1,
0.4 and 1 on twelve other maps, 52, 57 and 35 in a hundred did."""

_WEIGHT = 0.5
"""Number of drives s that the prior from poses counts as: as many as the prior of a prediction, Beta(1/4, 1/4)."""


class Evidence:
    """Numbers of drives that got over the moves of a lattice, and of those that were held there.

    passed, held: (3, n_x, n_y, 8), for moves on from places and for lanes onto the map and off it
    """

    def __init__(self, shape: tuple[int, ...]) -> None:
        self.passed, self.held = np.zeros((2, 3, *shape))

    def counts(self, part: int, places: Ints | slice) -> tuple[Array, Array]:
        """Return how many drives passed, and how many were held, on a part of ways at some places."""
        return self.passed[part].ravel()[places], self.held[part].ravel()[places]

    def metres(self, part: int, places: Ints | slice, weighted: Array) -> Array:
        """Return the metres as which moves or lanes count; weighted: their metres weighted by risk, by the places."""
        passed, held = self.counts(part, places)
        got_on = _WEIGHT * np.exp(-_HAZARD * weighted) + passed
        return np.asarray((np.log(_WEIGHT + passed + held) - np.log(got_on)) / _HAZARD)

    def least_share(self, longest: float) -> float:
        """Return the least share of its weighted metres as which any move counts; longest: of all moves, metres.

        The metres as which a move counts are a concave function of its own, so the longest has the least share.
        """
        got_on = self.passed[MOVE].max()
        at_least = np.log(_WEIGHT + got_on) - np.log(_WEIGHT * np.exp(-_HAZARD * longest) + got_on)
        return float(at_least / _HAZARD / longest)
