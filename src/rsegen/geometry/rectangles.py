"""Partition of a grid of labels into few rectangles of one label, with short seams.

labels of shape (n_u, n_v): adjacent squares of one label are one polygon, 0 is empty. A polygon is cut along v at every
concave corner that `chords.cuts_along_u` does not cut along u; the parts between the cuts are rectangles.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rsegen.field.stepfield import Ints
from rsegen.geometry.chords import cuts_along_u


class Rectangles(NamedTuple):
    """Rectangles of squares u0 <= u < u1, v0 <= v < v1 of one label, one array entry per rectangle."""

    label: Ints
    u0: Ints
    u1: Ints
    v0: Ints
    v1: Ints

    def rows(self, which: NDArray[np.intp] | NDArray[np.bool_]) -> Rectangles:
        """The rectangles of these indices, or of a mask."""
        return Rectangles(*(column[which] for column in self))


def merge(labels: Ints) -> Rectangles:
    """Rectangles that cover every labelled square once; the minimum number or nearly so."""
    wall = cuts_along_u(labels)
    there, apart = labels != 0, labels[:, 1:] != labels[:, :-1]
    begins, ends = there.copy(), there.copy()
    begins[:, 1:] &= apart | wall
    ends[:, :-1] &= apart | wall
    return _stacked(labels, begins, np.flatnonzero(ends))


def _stacked(labels: Ints, begins: NDArray[np.bool_], ends: NDArray[np.intp]) -> Rectangles:
    """Rectangles from strips along v, given by where they begin and end; equal strips in successive rows merge."""
    n_u, n_v = labels.shape
    starts = np.flatnonzero(begins)
    lengths = np.zeros(labels.size, dtype=np.int32)
    lengths[starts] = ends - starts + 1
    flat = labels.ravel()
    below = starts[np.searchsorted(starts, n_v) :]
    goes_on = below[(lengths[below - n_v] == lengths[below]) & (flat[below - n_v] == flat[below])]
    first, last = begins.copy(), begins
    first.ravel()[goes_on] = False
    last.ravel()[goes_on - n_v] = False
    v0, u0 = np.divmod(np.flatnonzero(first.T), n_u)
    u1 = np.flatnonzero(last.T) - v0 * n_u + 1
    at = u0 * n_v + v0
    return Rectangles(flat[at], u0, u1, v0, v0 + lengths[at])


def merge_hanging(strips: Rectangles) -> Rectangles:
    """The fewest rectangles for strips that hang side by side from one height, v1, down to v0.

    strips: sorted by label and u0; adjacent ones differ in v0. Between two strips that end at one height, the part of
    the others below that height is cut off, so that the rest merges:

         _______________            _______________
        |   |   |   |   |          |           |   |
        |___|   |___|   |    -->   |___________|   |
            |___|   |   |              |___|   |   |
                    |___|                      |___|
    """
    done = []
    while True:
        hopeful = _has_equal_depths(strips)
        done.append(strips.rows(~hopeful))
        strips = strips.rows(hopeful)
        if not len(strips.label):
            return Rectangles(*(np.concatenate(columns) for columns in zip(*done, strict=True)))
        level = np.minimum(*_neighbours(strips))
        lowest = strips.v0 < level
        done.append(strips._replace(v1=level).rows(lowest))
        strips = _joined(strips._replace(v0=np.where(lowest, level, strips.v0)))


def _touching(strips: Rectangles) -> NDArray[np.bool_]:
    """Whether each strip and the next are adjacent."""
    return np.asarray((strips.label[1:] == strips.label[:-1]) & (strips.u0[1:] == strips.u1[:-1]))


def _neighbours(strips: Rectangles) -> tuple[Ints, Ints]:
    """The v0 of the strips before and after each; v1 if there is none."""
    touching = _touching(strips)
    before, after = strips.v1.copy(), strips.v1.copy()
    before[1:][touching] = strips.v0[:-1][touching]
    after[:-1][touching] = strips.v0[1:][touching]
    return before, after


def _joined(strips: Rectangles) -> Rectangles:
    """The strips, with adjacent ones of equal v0 merged."""
    begins = np.ones(len(strips.label) + 1, dtype=bool)
    begins[1:-1] = ~_touching(strips) | (strips.v0[1:] != strips.v0[:-1])
    return strips.rows(begins[:-1])._replace(u1=strips.u1[begins[1:]])


def _has_equal_depths(strips: Rectangles) -> NDArray[np.bool_]:
    """Which strips are in a row of at least three, two of which have the same v0."""
    row = np.zeros(len(strips.label), dtype=np.int64)
    np.cumsum(~_touching(strips), out=row[1:])
    long: NDArray[np.bool_] = np.bincount(row)[row] >= 3
    heights = int(strips.v1.max(initial=0)) + 1
    ends = np.sort(row[long] * heights + strips.v0[long])
    found = np.zeros(len(row), dtype=bool)
    found[ends[1:][ends[1:] == ends[:-1]] // heights] = True
    return np.asarray(found[row])
