"""Merging equal squares of a grid into few rectangles with short seams.

labels of shape (n_u, n_v): squares of one label that touch are one plane, 0 is nothing. A plane is cut along v at every
concave corner that `chords.cuts_along_u` does not cut along u; what is left between the cuts are rectangles.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rsegen.field.stepfield import Ints
from rsegen.geometry.chords import cuts_along_u


class Rectangles(NamedTuple):
    """The squares u0 <= u < u1, v0 <= v < v1 that have one label, one array entry a rectangle."""

    label: Ints
    u0: Ints
    u1: Ints
    v0: Ints
    v1: Ints

    def rows(self, which: NDArray[np.intp] | NDArray[np.bool_]) -> Rectangles:
        """Some of them, by number or by mask."""
        return Rectangles(*(column[which] for column in self))


def merge(labels: Ints) -> Rectangles:
    """Rectangles that cover every labelled square once; nearly the fewest that there can be."""
    wall = cuts_along_u(labels)
    there, apart = labels != 0, labels[:, 1:] != labels[:, :-1]
    begins, ends = there.copy(), there.copy()
    begins[:, 1:] &= apart | wall
    ends[:, :-1] &= apart | wall
    return _stacked(labels, begins, np.flatnonzero(ends))


def _stacked(labels: Ints, begins: NDArray[np.bool_], ends: NDArray[np.intp]) -> Rectangles:
    """Strips along v, from where one begins to where it ends; equal ones in successive rows are one rectangle."""
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
    """The fewest rectangles of strips that hang side by side from one height, v1, down to v0.

    strips: sorted by label and u0; no two that touch are equal in v0. Between two that end at one height what hangs
    lower is cut off, so that they become one:

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
    """Between each strip and the next: do they hang side by side?"""
    return np.asarray((strips.label[1:] == strips.label[:-1]) & (strips.u0[1:] == strips.u1[:-1]))


def _neighbours(strips: Rectangles) -> tuple[Ints, Ints]:
    """How far down the strips beside each hang, before it and after it; v1 where there is none."""
    touching = _touching(strips)
    before, after = strips.v1.copy(), strips.v1.copy()
    before[1:][touching] = strips.v0[:-1][touching]
    after[:-1][touching] = strips.v0[1:][touching]
    return before, after


def _joined(strips: Rectangles) -> Rectangles:
    """Strips that touch and hang equally far down, as one."""
    begins = np.ones(len(strips.label) + 1, dtype=bool)
    begins[1:-1] = ~_touching(strips) | (strips.v0[1:] != strips.v0[:-1])
    return strips.rows(begins[:-1])._replace(u1=strips.u1[begins[1:]])


def _has_equal_depths(strips: Rectangles) -> NDArray[np.bool_]:
    """Which strips are in a row of at least three, two of which hang equally far down."""
    row = np.zeros(len(strips.label), dtype=np.int64)
    np.cumsum(~_touching(strips), out=row[1:])
    long: NDArray[np.bool_] = np.bincount(row)[row] >= 3
    heights = int(strips.v1.max(initial=0)) + 1
    ends = np.sort(row[long] * heights + strips.v0[long])
    found = np.zeros(len(row), dtype=bool)
    found[ends[1:][ends[1:] == ends[:-1]] // heights] = True
    return np.asarray(found[row])
