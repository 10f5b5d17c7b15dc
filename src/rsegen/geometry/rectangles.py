"""Partition of a grid of labels into few rectangles of one label, with short seams.

labels of shape (n_u, n_v): adjacent squares of one label are one polygon, 0 is empty. A polygon must be cut at each of
its concave corners, and a cut that joins two of them, a good chord, saves a rectangle. The fewest rectangles result
from a maximum set of chords of which no two intersect (Ohtsuki 1982; Ferrari, Sankar and Sklansky 1984). It is found
greedily, by fewest intersections, then by length, and is maximum or nearly so (a maximum matching would be exact; the
number of rectangles is within 3 % of the minimum, decision 7). Corners without a chord are cut in the direction of the
shorter cut; all that `cuts_along_u` does not cut along u is cut along v, and the parts between the cuts are rectangles.
Short seams leave large rectangles whole:

       _    _              _    _                  _    _
     _| |__| |_          _|_|__|_|_              _| |__| |_
    |          |   -->  |          |   and not  | : :  : : |
    |__________|        |__________|            |_:_:__:_:_|

Cost: linear in the squares, all in numpy; only the rounds of the greedy choice are a loop, of a few passes over the
intersections and of short lists of chords. The risers of a surface are a simpler case, `merge_hanging`: strips that
hang from one height.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rsegen.field.stepfield import Ints, Mask


class _Runs(NamedTuple):
    """Straight segments inside a polygon from boundary to boundary: from corner `start` over `length` squares.

    Corners of squares are numbered row by row, (n_u + 1, n_v + 1); `step` is the difference to the next one.
    """

    start: Ints
    length: Ints
    step: int

    @property
    def end(self) -> Ints:
        return self.start + self.length * self.step

    def rows(self, which: Ints | Mask) -> _Runs:
        return _Runs(self.start[which], self.length[which], self.step)

    def corners(self, *, last: bool) -> tuple[Ints, Ints]:
        """Return every corner of each run in turn, with or without the last, and the number of its run."""
        run, along = ragged(self.length + last)
        return self.start[run] + along * self.step, run


def ragged(counts: Ints) -> tuple[Ints, Ints]:
    """Return ragged indices: for [2, 3] the groups 0 0 1 1 1 and the positions within them 0 1 0 1 2."""
    whose = np.repeat(np.arange(len(counts)), counts)
    return whose, np.arange(len(whose)) - (np.cumsum(counts) - counts).take(whose)


def cuts_along_u(labels: Ints) -> Mask:
    """Return the pairs of neighbours along v that cuts along u separate, (n_u, n_v - 1), of labels (n_u, n_v)."""
    n_u, n_v = labels.shape
    concave, along_u, along_v = _runs(labels)
    wall = np.zeros((n_u + 1) * (n_v + 1), dtype=bool)
    if not concave.any():
        return wall.reshape(n_u + 1, n_v + 1)[:-1, 1:-1]
    # Chords first; the corners at their ends are then cut, and the others get the shorter of their two cuts.
    chords_u, chords_v = (runs.rows(concave[runs.start] & concave[runs.end]) for runs in (along_u, along_v))
    kept_u, kept_v = _independent_chords(chords_u, chords_v, len(wall))
    wall[kept_u.corners(last=False)[0]] = True
    for kept in (kept_u, kept_v):
        concave[kept.start] = concave[kept.end] = False
    for cut in _shorter_cuts(concave, along_u, along_v, kept_v):
        wall[cut.corners(last=False)[0]] = True
    return wall.reshape(n_u + 1, n_v + 1)[:-1, 1:-1]


def _runs(labels: Ints) -> tuple[Mask, _Runs, _Runs]:
    """Return the concave corners, and all runs along u and along v; a run is between squares of one label.

    At a corner, `down`, `up`, `left` and `right` say whether the lattice line in that direction is inside a polygon. At
    a concave corner one of each pair is, as three of the four squares around it have one label.
    """
    around = np.zeros([cells + 2 for cells in labels.shape], dtype=labels.dtype)
    around[1:-1, 1:-1] = labels
    filled = around != 0
    inside_u = (around[:, 1:] == around[:, :-1]) & filled[:, 1:]
    inside_v = (around[1:] == around[:-1]) & filled[1:]
    down, up, left, right = inside_u[:-1], inside_u[1:], inside_v[:, :-1], inside_v[:, 1:]
    ending = ~(down & up & left & right)
    columns = around.shape[1] - 1
    # A run goes on through corners at which nothing ends, and begins and ends at all others, flat in row order.
    starts, ends = (np.flatnonzero(way & ending) for way in (right, left))
    along_v = _Runs(starts, ends - starts, 1)
    starts, ends = (np.flatnonzero((way & ending).T) for way in (up, down))
    rows = around.shape[0] - 1
    column, row = np.divmod(starts, rows)
    along_u = _Runs(row * columns + column, ends - starts, columns)
    return ((down ^ up) & (left ^ right)).ravel(), along_u, along_v


def _independent_chords(along_u: _Runs, along_v: _Runs, corners: int) -> tuple[_Runs, _Runs]:
    """Return a large set of chords of which no two intersect, found greedily."""
    if not (len(along_u.start) and len(along_v.start)):
        return along_u, along_v
    # Chords of one direction never meet each other, so the chord along v at each corner of one along u is enough.
    on = np.full(corners, -1, dtype=np.int32)
    at, chord = along_v.corners(last=True)
    on[at] = chord
    at, a = along_u.corners(last=True)
    b = on[at]
    a, b = a[b >= 0], b[b >= 0] + len(along_u.start)
    kept = independent_set(a, b, np.concatenate([along_u.length, along_v.length]))
    return along_u.rows(kept[: len(along_u.start)]), along_v.rows(kept[len(along_u.start) :])


def independent_set(a: Ints, b: Ints, lengths: Ints) -> Mask:
    """Return the mask of a large independent set of chords; chords a[k] and b[k] intersect.

    a is in order, and all its numbers are below b's. Keeping a chord that intersects only one other is always optimal;
    without such a chord, one is kept that intersects fewer others than its neighbours do, or as many and is shorter.
    """
    kept = np.ones(len(lengths), dtype=bool)
    rank = np.empty(len(lengths), dtype=np.int64)
    small = lengths.astype(np.min_scalar_type(lengths.max()))  # of 16 bits it is a radix sort
    rank[np.argsort(small, kind="stable")] = np.arange(len(lengths))
    while len(a):
        _drop_neighbours(a, b, rank, kept)
        # Local minima of (intersections, length) are no neighbours of one another, so all are kept at once.
        a, b = _of_kept(a, b, kept)
        worth = (np.bincount(a, minlength=len(rank)) + np.bincount(b, minlength=len(rank))) * len(rank) + rank
        least = worth.copy()
        np.minimum.at(least, a, worth[b])
        np.minimum.at(least, b, worth[a])
        kept[b[least[a] == worth[a]]] = kept[a[least[b] == worth[b]]] = False
        a, b = _of_kept(a, b, kept)
    return kept


def _of_kept(a: Ints, b: Ints, kept: Mask) -> tuple[Ints, Ints]:
    """Return the intersections of chords that are kept."""
    both = kept.take(a) & kept.take(b)
    return a.compress(both), b.compress(both)


def _drop_neighbours(a: Ints, b: Ints, rank: Ints, kept: Mask) -> None:
    """Drop from `kept` the only neighbour of every chord that intersects just one other, until no such chord is left.

    a: in order, and all below b, so that `neighbours` is sorted by chord. Most rounds drop few chords of many, so a
    round looks only at the neighbours of those that the last one dropped.
    """
    neighbours = np.concatenate([b, a.take(np.argsort(b))])
    count = np.bincount(a, minlength=len(rank)) + np.bincount(b, minlength=len(rank))
    begin = np.cumsum(count) - count
    met = count.copy()
    # The sum of the numbers of a chord's neighbours: of one that meets only one other, the number of that one.
    total = (np.bincount(a, b, len(rank)) + np.bincount(b, a, len(rank))).astype(np.int64)
    at = np.empty_like(met)
    ends = np.flatnonzero(met == 1)
    while len(ends):
        last = total.take(ends)
        # Of two that meet each other alone, the shorter is kept.
        gone = last[(met.take(last) > 1) | (rank.take(ends) < rank.take(last))]
        at[gone] = order = np.arange(len(gone))
        gone = gone[at.take(gone) == order]  # each once
        kept[gone] = False
        whose, place = ragged(count.take(gone))
        near = neighbours.take(begin.take(gone).take(whose) + place)
        whose, near = gone.take(whose)[kept.take(near)], near[kept.take(near)]
        np.subtract.at(met, near, 1)
        np.subtract.at(total, near, whose)
        met[gone] = 0
        ends = near[met.take(near) == 1]


def _shorter_cuts(concave: Mask, along_u: _Runs, along_v: _Runs, kept_v: _Runs) -> tuple[_Runs, _Runs]:
    """Return the cuts along u of corners whose cut along u is shorter than along v; they end at a kept chord."""
    # Each concave corner is an end of one run along u and of one along v: its two possible cuts.
    length_along_v = np.zeros(len(concave), dtype=np.int32)
    length_along_v[along_v.start] = length_along_v[along_v.end] = along_v.length
    stop = np.zeros(len(concave), dtype=bool)
    stop[kept_v.corners(last=True)[0]] = True
    forward = along_u.rows(concave[along_u.start] & (along_u.length < length_along_v[along_u.start]))
    back = along_u.rows(concave[along_u.end] & (along_u.length < length_along_v[along_u.end]))
    back = _Runs(back.end, back.length, -back.step)
    backward = _until(stop, back)
    return _until(stop, forward), _Runs(backward.end, backward.length, along_u.step)


def _until(stop: Mask, runs: _Runs) -> _Runs:
    """Return every run, shortened to the first corner at which it must stop."""
    if not len(runs.start):
        return runs
    run, along = ragged(runs.length + 1)
    reached = np.where(stop[runs.start[run] + along * runs.step], along, runs.length[run])
    return runs._replace(length=np.minimum.reduceat(reached, np.flatnonzero(along == 0)))


class Rectangles(NamedTuple):
    """Rectangles of squares u0 <= u < u1, v0 <= v < v1 of one label, one array entry per rectangle."""

    label: Ints
    u0: Ints
    u1: Ints
    v0: Ints
    v1: Ints

    def rows(self, which: Ints | Mask) -> Rectangles:
        """Return the rectangles of these indices, or of a mask."""
        return Rectangles(*(column[which] for column in self))


def merge(labels: Ints) -> Rectangles:
    """Return rectangles that cover every labelled square once; the minimum number or nearly so."""
    wall = cuts_along_u(labels)
    filled, apart = labels != 0, labels[:, 1:] != labels[:, :-1]
    begins, ends = filled.copy(), filled.copy()
    begins[:, 1:] &= apart | wall
    ends[:, :-1] &= apart | wall
    # Strips along v have a first and a last square; equal ones in successive rows are one rectangle.
    n_v, starts, flat = labels.shape[1], np.flatnonzero(begins), labels.ravel()
    lengths = np.zeros(labels.size, dtype=np.int32)
    lengths[starts] = np.flatnonzero(ends) - starts + 1
    below = starts[np.searchsorted(starts, n_v) :]
    goes_on = below[(lengths[below - n_v] == lengths[below]) & (flat[below - n_v] == flat[below])]
    first, last = begins.copy(), begins
    first.ravel()[goes_on] = False
    last.ravel()[goes_on - n_v] = False
    v0, u0 = np.divmod(np.flatnonzero(first.T), len(labels))
    u1 = np.flatnonzero(last.T) - v0 * len(labels) + 1
    at = u0 * n_v + v0
    return Rectangles(flat[at], u0, u1, v0, v0 + lengths[at])


def merge_hanging(strips: Rectangles) -> Rectangles:
    """Return the fewest rectangles for strips that hang side by side from one height, v1, down to v0.

    strips: sorted by label and u0; adjacent ones differ in v0. Between two strips that end at one height, the part of
    the others below that height is cut off, so that the rest merges:

         _______________            _______________
        |   |   |   |   |          |           |   |
        |___|   |___|   |    -->   |___________|   |
            |___|   |   |              |___|   |   |
                    |___|                      |___|
    """
    done = []
    # One level per round: strips whose row has no two equal depths cannot be merged, and leave the loop.
    while True:
        hopeful = _has_equal_depths(strips)
        done.append(strips.rows(~hopeful))
        strips = strips.rows(hopeful)
        if not len(strips.label):
            return Rectangles(*(np.concatenate(columns) for columns in zip(*done, strict=True)))
        # The lower end of the cut: the lower one of the v0 before and after each strip, at most its own v1.
        touching = _touching(strips)
        level = strips.v1.copy()
        level[1:][touching] = strips.v0[:-1][touching]
        level[:-1][touching] = np.minimum(level[:-1], strips.v0[1:])[touching]
        lowest = strips.v0 < level
        done.append(strips._replace(v1=level).rows(lowest))
        strips = _joined(strips._replace(v0=np.where(lowest, level, strips.v0)))


def _touching(strips: Rectangles) -> Mask:
    """Return whether each strip and the next are adjacent."""
    return np.asarray((strips.label[1:] == strips.label[:-1]) & (strips.u0[1:] == strips.u1[:-1]))


def _joined(strips: Rectangles) -> Rectangles:
    """Return the strips, with adjacent ones of equal v0 merged."""
    begins = np.ones(len(strips.label) + 1, dtype=bool)
    begins[1:-1] = ~_touching(strips) | (strips.v0[1:] != strips.v0[:-1])
    return strips.rows(begins[:-1])._replace(u1=strips.u1[begins[1:]])


def _has_equal_depths(strips: Rectangles) -> Mask:
    """Return which strips are in a row of at least three, two of which have the same v0."""
    row = np.zeros(len(strips.label), dtype=np.int64)
    np.cumsum(~_touching(strips), out=row[1:])
    long: Mask = np.bincount(row)[row] >= 3
    heights = int(strips.v1.max(initial=0)) + 1
    ends = np.sort(row[long] * heights + strips.v0[long])
    has_equal = np.zeros(len(row), dtype=bool)
    has_equal[ends[1:][ends[1:] == ends[:-1]] // heights] = True
    return np.asarray(has_equal[row])
