"""The exposed surface of a step field: tops and risers, merged, welded, outward.

Nothing faces down and nothing lies at z = 0, where the ground is. A riser belongs to the higher of its two cells:

         ____
        |top |      level 2: top at rank 2, riser from rank 1 to 2
    ____|    |____
                    level 1 on both sides
"""

from __future__ import annotations

import numpy as np

from rsegen.field.stepfield import CellWindow, Ints, StepField
from rsegen.geometry.faces import Faces
from rsegen.geometry.mesh import Mesh
from rsegen.geometry.rectangles import Rectangles, merge, merge_hanging
from rsegen.geometry.relief import Relief, relief


def surface(field: StepField, window: CellWindow | None = None) -> Mesh:
    """The mesh of a field, or of those of its cells in a window; empty where all of them are at level 0."""
    ground = relief(field, window)
    return ground.lattice.weld(Faces.joined([tops(ground), risers(ground, axis=0), risers(ground, axis=1)]))


def tops(ground: Relief) -> Faces:
    """What looks up; one plane for each height and material that touch."""
    found = merge(ground.cells)
    height, material = np.divmod(found.label, ground.kinds)
    return Faces(ground.lattice.ring(found, (0, 1), height), np.full(len(material), 4), material)


def risers(ground: Relief, axis: int) -> Faces:
    """What looks along an axis, forward or back; u runs across it, v upward."""
    labels = ground.labels if axis == 0 else ground.labels.T
    strips, sides = _strips(labels[:, 1:-1], ground)
    found = merge_hanging(strips)
    line, side = np.divmod(found.label, sides)
    owner, back = np.divmod(side, 2)
    corners = ground.lattice.ring(found, (1 - axis, 2), line)
    inward = (back == 1) == (axis == 0)
    corners[inward] = corners[inward, ::-1]
    return Faces(corners, 2 * axis + back, owner % ground.kinds)


def _strips(labels: Ints, ground: Relief) -> tuple[Rectangles, int]:
    """Risers between neighbours along the first array axis, joined where they are equal; u along the second.

    Their label is line * sides + side, where side is 2 * the label of the higher cell, plus 1 where they look back; and
    the number of sides.
    """
    ranks = len(ground.lattice.lines[2])
    rank = labels // ground.kinds
    forward, back = rank[:-1] > rank[1:], rank[:-1] < rank[1:]
    forward[0] = back[-1] = False  # the higher cell is outside the window
    side = np.where(forward, 2 * labels[:-1], np.where(back, 2 * labels[1:] + 1, 0)).astype(np.int64)
    kind = np.where(side != 0, side * ranks + np.minimum(rank[:-1], rank[1:]), 0)
    begins, ends = kind != 0, kind != 0
    apart = kind[:, 1:] != kind[:, :-1]
    begins[:, 1:] &= apart
    ends[:, :-1] &= apart
    starts, stops = np.flatnonzero(begins), np.flatnonzero(ends) + 1
    line, u0 = np.divmod(starts, kind.shape[1])
    side, low = np.divmod(kind.ravel()[starts], ranks)
    sides = 2 * ground.kinds * ranks
    top = side // 2 // ground.kinds
    return Rectangles(line * sides + side, u0, stops - line * kind.shape[1], low, top), sides
