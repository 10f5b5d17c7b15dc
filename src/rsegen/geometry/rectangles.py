"""Merging unit squares into few rectangles.

A square is a cell (u, v) of a plane; planes are numbered and never meet. Squares in one row are joined to runs, equal
runs in successive rows to rectangles; that is done along u and along v, and each plane keeps what gave it fewer.
"""

from __future__ import annotations

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


def merge_rectangles(plane: Ints, u: Ints, v: Ints) -> Rectangles:
    """Rectangles that cover exactly the given squares, each once, sorted by plane."""
    along_u = _joined(plane, u, v)
    plane_v, v0, v1, u0, u1 = _joined(plane, v, u)
    along_v = Rectangles(plane_v, u0, u1, v0, v1)
    planes = int(plane.max(initial=-1)) + 1
    fewer = np.bincount(along_v.plane, minlength=planes) < np.bincount(along_u.plane, minlength=planes)
    kept = along_u.rows(~fewer[along_u.plane]), along_v.rows(fewer[along_v.plane])
    both = Rectangles(*(np.concatenate(columns) for columns in zip(*kept, strict=True)))
    return both.rows(np.argsort(both.plane, kind="stable"))


def _joined(plane: Ints, u: Ints, v: Ints) -> Rectangles:
    """Runs along u of squares, then stacks along v of equal runs."""
    order = np.lexsort((u, v, plane))
    plane, u, v = plane[order], u[order], v[order]
    starts = _starts((plane, v), u)
    ends = _ends(starts, len(u))
    plane, u0, u1, v = plane[starts], u[starts], u[ends] + 1, v[starts]
    order = np.lexsort((v, u1, u0, plane))
    plane, u0, u1, v = plane[order], u0[order], u1[order], v[order]
    starts = _starts((plane, u0, u1), v)
    ends = _ends(starts, len(v))
    return Rectangles(plane[starts], u0[starts], u1[starts], v[starts], v[ends] + 1)


def _ends(starts: NDArray[np.intp], count: int) -> NDArray[np.intp]:
    """The last of every run, where the runs begin at `starts` and fill all of `count`."""
    return np.append(starts, count)[1:] - 1 if count else starts


def _starts(same: tuple[Ints, ...], along: Ints) -> NDArray[np.intp]:
    """Where a new run begins: one of `same` changes, or `along` does not go on by one."""
    broken = np.ones(len(along), dtype=bool)
    broken[1:] = np.diff(along) != 1
    for column in same:
        broken[1:] |= np.diff(column) != 0
    return np.flatnonzero(broken)
