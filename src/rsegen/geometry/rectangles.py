"""Merging unit squares into few rectangles.

A square is a cell (u, v) of a plane; planes are numbered and never meet. Squares in one row are joined to strips, equal
strips in successive rows to rectangles; that is done along u and along v, and each plane keeps what gave it fewer.
"""

from __future__ import annotations

from math import prod
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int64]


class Rectangles(NamedTuple):
    """The cells u0 <= u < u1, v0 <= v < v1 of a plane, one array entry a rectangle."""

    plane: Ints
    u0: Ints
    u1: Ints
    v0: Ints
    v1: Ints

    def rows(self, which: NDArray[np.intp] | NDArray[np.bool_]) -> Rectangles:
        """Some of them, by number or by mask."""
        return Rectangles(*(column[which] for column in self))

    @property
    def turned(self) -> Rectangles:
        """The same with u and v exchanged."""
        return Rectangles(self.plane, self.v0, self.v1, self.u0, self.u1)


def merge_squares(plane: Ints, u: Ints, v: Ints) -> Rectangles:
    """Rectangles that cover exactly the given squares, each once, sorted by plane."""
    along_u = merge_strips(*_strips(plane, u, v)).turned
    along_v = merge_strips(*_strips(plane, v, u))
    planes = int(plane.max(initial=-1)) + 1
    fewer = np.bincount(along_v.plane, minlength=planes) < np.bincount(along_u.plane, minlength=planes)
    kept = along_u.rows(~fewer[along_u.plane]), along_v.rows(fewer[along_v.plane])
    both = Rectangles(*(np.concatenate(columns) for columns in zip(*kept, strict=True)))
    return both.rows(np.argsort(both.plane, kind="stable"))


def merge_strips(plane: Ints, u: Ints, v0: Ints, v1: Ints) -> Rectangles:
    """Rectangles of strips v0 <= v < v1, each one cell wide: those that are equal and follow one another along u."""
    order = _order(plane, v0, v1, u)
    plane, u, v0, v1 = plane[order], u[order], v0[order], v1[order]
    starts, ends = _runs((plane, v0, v1), u)
    return Rectangles(plane[starts], u[starts], u[ends] + 1, v0[starts], v1[starts])


def _strips(plane: Ints, along: Ints, row: Ints) -> tuple[Ints, Ints, Ints, Ints]:
    """Squares of one row that follow one another: their plane and row, where they begin, and where they end."""
    order = _order(plane, row, along)
    plane, along, row = plane[order], along[order], row[order]
    starts, ends = _runs((plane, row), along)
    return plane[starts], row[starts], along[starts], along[ends] + 1


def _runs(same: tuple[Ints, ...], along: Ints) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """First and last of every run, in which all of `same` stay and `along` goes on by one."""
    broken = np.ones(len(along) + 1, dtype=bool)
    broken[1:-1] = np.diff(along) != 1
    for column in same:
        broken[1:-1] |= np.diff(column) != 0
    return np.flatnonzero(broken[:-1]), np.flatnonzero(broken[1:])


def _order(*columns: Ints) -> NDArray[np.intp]:
    """The order by the first column, then the second, and so on; no two rows are equal. One sort where that can be."""
    sizes = [int(column.max(initial=0)) + 1 for column in columns]
    if prod(sizes) >= 2**63:
        return np.lexsort(columns[::-1])
    return np.argsort(np.ravel_multi_index(columns, tuple(sizes)))
