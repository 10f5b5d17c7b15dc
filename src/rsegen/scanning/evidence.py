"""Evidence that the grid found in a cloud is one of blocks: the lines between cells at which heights change.

Blocks that abut have their sides on the lines of one grid, so nearly every line has steps. A few boxes on a table have
few sides, and through few sides there always is a grid:

    blocks   | 2 | 0 | 1 | 2 |     steps at all 5 lines
    halves   |2|2|0|0|1|1|2|2|     steps at every second line: the blocks are twice as wide
    a box    | 0 | 1   1   1 |     steps at 2 of 5 lines, which any width would have that goes into it

The grid is an explanation if it tells where the steps are in fewer bits than their places by themselves (minimum
description length; Rissanen 1978): its two origins and its width are three places; then a bit or less for each line, by
the entropy of the share that has steps. Cost: linear in the cells. What breaks it: a field of few obstacles with long
sides, whose blocks nothing shows: their width then has to be given.
"""

from __future__ import annotations

from math import log2
from typing import NamedTuple

import numpy as np

from rsegen.field.stepfield import Ints, Mask
from rsegen.scanning.scan import SURE, Scan

_PLACES = 5
"""Places in a width at which sides are distinguished: a line has the sides of a tenth of a width around it."""

_OF_GRID = 3
"""Places that a grid has by itself: its origin along x and y, and its width; its heading is that of any side."""

_OF_LINE, _OF_SHORT_LINE = 2, 0.25
"""Steps that a line has at the least, or share of its pairs of cells: a single one of many may be at a cell that has
something else on top."""

_MOST_BETWEEN = 0.03
"""Share of the steps that may be at lines between those of wider blocks: at cells that were misread."""

FEWEST_BITS = 16.0
"""Bits that the grid of blocks saves, at the least: up to 14 with boxes on a table, 46 and more with fields of the
benchmark, and 13 or more with 3 x 3 random blocks."""

CERTAIN = 0.7
"""Share of the lines between cells with steps from which on blocks are taken for granted: random blocks have 0.9 and
more, 0.73 if half was seen; stairs, furniture and parts of machines up to 0.67; fields of few obstacles 0.3 to 0.55."""

_FEWEST_WIDE = 4
"""Lines along x and y with steps, at the least, of which the width of blocks is read: two are those of a box."""


class Lines(NamedTuple):
    """Lines of the grid along one axis: pairs of cells at them whose levels are sure, and steps between two; (n,)."""

    pairs: Ints
    steps: Ints

    @property
    def has_steps(self) -> Mask:
        """The lines that have steps, (n,), and not just a cell or two that have something else on top."""
        return np.asarray(self.steps >= np.clip(_OF_SHORT_LINE * self.pairs, 1, _OF_LINE))


def lines_of(scan: Scan) -> tuple[Lines, Lines]:
    """Return the n_x + 1 lines at which x changes, and the n_y + 1 at which y does, with the floor around."""
    tops, sure = np.pad(scan.tops, 1), np.pad(scan.confidence >= SURE, 1, constant_values=True)
    return _lines(tops[:, 1:-1], sure[:, 1:-1]), _lines(tops[1:-1].T, sure[1:-1].T)


def _lines(levels: Ints, known: Mask) -> Lines:
    pairs = known[1:] & known[:-1]
    return Lines(pairs=pairs.sum(axis=1), steps=(pairs & (levels[1:] != levels[:-1])).sum(axis=1))


def bits_saved(scan: Scan) -> float:
    """Return the bits by which the lines of the grid describe the places of steps more shortly than a list of them."""
    lines = lines_of(scan)
    has_steps = np.concatenate([own.has_steps for own in lines])
    seen = np.concatenate([own.pairs > 0 for own in lines])
    # A list names the place of each line with steps, along a side of half the lines; the grid asks yes or no of each.
    place = log2(_PLACES * len(has_steps) / 2)
    share = float(has_steps[seen].mean()) if seen.any() else 0.0
    entropy = -sum(part * log2(part) for part in (share, 1 - share) if part)
    return float(has_steps.sum() - _OF_GRID) * place - int(seen.sum()) * entropy


_MIXED = 0.2
"""Share of a cell's points that are off its top, from which on it has two heights: of a block's inner 60 % outliers
and noise of a quarter of a unit bring 7 % off, slopes of phones less than 15 %."""

MOST_MIXED = 0.05
"""Share of the cells that may have two heights: blocks have one. Up to 0.02 in the clouds of the benchmark and in
smoothed meshes of phones, 0.09 to 0.11 in legs of a robot whose edges are on a grid by chance."""


def mixed_share(scan: Scan) -> float:
    """Return the share of the cells that were seen whose points have two heights, 0 to 1."""
    return float((scan.strays[scan.seen] > _MIXED).mean())


class SteppedLines(NamedTuple):
    """Lines between cells at which heights change, and all that were seen; alone: whether no two raised cells touch."""

    stepped: int
    seen: int
    alone: bool

    @property
    def confidence(self) -> float:
        """The share of the lines that have steps, 0 to 1; 0 if no two raised cells touch, as blocks that abut do."""
        return 0.0 if self.alone or not self.seen else self.stepped / self.seen


def stepped_lines(scan: Scan) -> SteppedLines:
    """Return at how many lines between cells heights change, which shows that what is on them is blocks.

    A part of a machine, stairs or a table has long flat tops, and its sides are on a grid only as all its lengths are
    whole centimetres; of blocks that abut, nearly every line has two neighbours that differ. What breaks it: a field of
    few obstacles has long flat tops too, so a low confidence does not say that there is no field.
    """
    stepped = seen = touching = 0
    raised = (scan.tops > 0) & (scan.confidence >= SURE)
    for lines, cells in zip(lines_of(scan), (raised, raised.T), strict=True):
        seen += int((lines.pairs[1:-1] > 0).sum())
        stepped += int(lines.has_steps[1:-1].sum())
        touching += int((cells[1:] & cells[:-1]).sum())
    return SteppedLines(stepped, seen, not touching)


def chance_of_level_row(scan: Scan) -> float:
    """Return the probability that a row next to the field, on any of its sides, has no raised block: 0 to 1, as if all
    blocks were raised independently. A frame ends a field.
    """
    level, (n_x, n_y) = float((scan.levels <= 0).mean()), scan.levels.shape
    return 0.0 if scan.frame.any() else min(1.0, 2 * level**n_x + 2 * level**n_y)


_FALLS = 3.0
"""Standard errors by which the blocks of the rim are lower on average than those inside, of a field that falls to its
sides: of random blocks one in a thousand seems to."""


def falls_to_its_sides(scan: Scan) -> bool:
    """Return whether the blocks of the rim are lower than those inside, and none is more than half as high as the
    highest, as of a peak, which may go on at level 0.
    """
    if scan.frame.any() or min(scan.levels.shape) < 3:
        return False
    rim = np.ones(scan.levels.shape, dtype=bool)
    rim[1:-1, 1:-1] = False
    own, others = (np.maximum(scan.levels[cells], 0) for cells in (rim, ~rim))
    error = float(np.sqrt(own.var() / own.size + others.var() / others.size))
    return 2 * int(own.max()) <= int(others.max()) and float(others.mean() - own.mean()) > _FALLS * error


_MOST_LEVEL = 0.1
"""Probability of a row at level 0 from which on a field may have one: random blocks of two levels have it up to
5 x 5."""


def rows_may_follow(scan: Scan) -> str:
    """Return why rows of blocks at level 0 may be next to those that are raised; nothing if that is unlikely."""
    if falls_to_its_sides(scan):
        return "those at the sides are lower than the others"
    if np.gcd(*scan.levels.shape) == 1 and not scan.frame.any() and stepped_lines(scan).confidence < CERTAIN:
        return "they are no square, and few lines between them have steps"
    chance = chance_of_level_row(scan)
    return f"{chance:.0%} of fields with as many raised have such a row" if chance > _MOST_LEVEL else ""


def cells_per_block(scan: Scan) -> int:
    """Return how many cells of a scan a block is wide: 2 if steps are at every second line along x and along y."""
    steps = [lines.steps for lines in lines_of(scan)]
    total = sum(int(own.sum()) for own in steps)
    # Of the widths, wide ones first: the lines of the phase with most steps must have nearly all of them.
    for cells in range(min(map(len, steps)) // _FEWEST_WIDE, 1, -1):
        lines = [max((own[first::cells] for first in range(cells)), key=np.sum) for own in steps]
        between = total - sum(int(own.sum()) for own in lines)
        if between <= _MOST_BETWEEN * total and min(map(np.count_nonzero, lines)) >= _FEWEST_WIDE:
            return cells
    return 1


def times_narrower(scan: Scan) -> int:
    """Return how much narrower blocks have to be for what is raised to reach from side to side: 2, 3, or 1 if never.

    scan: with the cells of a given size, of which the raised ones are just a half or a third along x and y.
    """
    i, j = np.nonzero(scan.tops > 0)
    if scan.boundary != "none" or not len(i):
        return 1
    shares = [shape / (int(np.ptp(along)) + 1) for shape, along in zip(scan.levels.shape, (i, j), strict=True)]
    return int(shares[0]) if shares[0] == shares[1] and shares[0] in (2, 3) else 1
