"""The push of a robot at rest: forces at its contacts that balance its weight and leave some.

At a driven contact the force is within the friction pyramid, mu along the belt or tyre and mu2 across; at any other
contact friction is against the motion. The largest margin s of forward force, in shares of the weight, is a linear
programme:

    maximize s, such that   sum of f_k (d_k, x_k x d_k) = (s, 0, 1, 0, 0, 0),   f_k >= 0

with the edges d_k of the pyramids at the contacts x_k, seen from the centre of mass (forces and moments, Newton and
Euler). All robots are solved at once, by the simplex algorithm on their tables (Dantzig 1947; ties are broken by a
small perturbation of the right side). Where three driven contacts that each stand within their friction cone bear the
robot, it is not solved: upright forces balance it, and some are left. Cost: 30 microseconds a programme.
"""

from __future__ import annotations

import numpy as np

from rsegen.field.stepfield import Array, Ints, Mask
from rsegen.standing.body import Body
from rsegen.standing.ground import SINGLE, PaddedGround, Singles
from rsegen.standing.settling import Settled

TOUCHING = 0.0008
"""Metres between a sample and the ground up to which it counts as in contact: what contacts of simulators give way.
With 1.5 mm, wheels push that hang 0.7 mm above the ground and carry nothing (Gazebo Classic's contacts)."""

_EVEN = 1e-4
"""Metres within which the samples of a flat part are all in contact: rounding of single precision, and a turn left."""

_DIRECTIONS = 8
"""Directions in which the outermost contacts are taken, besides the three that bear the robot."""

_ITERATIONS, _ZERO, _PIVOT, _ARTIFICIAL = 60, 1e-9, 1e-7, 1e3
"""Exchanges of the simplex algorithm at most; the cost and the pivot that count as zero; the cost of missing force."""

_OF_CONE, _LEVEL = 0.97, 0.9995
"""Share of the friction up to which a contact is within its cone: with 0.9 one of 5,400 poses is judged otherwise, with
1 none. And the least cosine of level ground, 2 degrees, on which a part without friction stays."""

SLIDING = -9.0
"""Surplus where no forces balance the weight: the robot slides, turns or tips by itself."""


def sample_heights(ground: PaddedGround, body: Body, settled: Settled, rows: Ints) -> tuple[Singles, Singles]:
    """Return the positions of all samples from the centres of mass, (n, 3, m), and their heights above ground."""
    relative = settled.axes[rows].astype(SINGLE) @ (body.points - body.centre).T.astype(SINGLE)
    middle = ground.middles(settled.x[rows], settled.y[rows])
    under = ground.under(relative * SINGLE(1 / ground.width), middle)
    return relative, relative[:, 2] + settled.z[rows, None].astype(SINGLE) - under


def outermost(body: Body, relative: Singles, above: Singles, contacts: Ints) -> Ints:
    """Return the samples in contact that bear the robot or are outermost in a direction, (n, 3 + 8); -1 for none.

    Of each part only the lowest samples count: a round part is near the ground next to them, but not in contact.
    """
    rows, columns = np.nonzero(above < TOUCHING)
    heights, of_part = above[rows, columns], rows * len(body.parts) + body.part[columns]
    low = heights < _of_runs(np.minimum, heights, of_part) + SINGLE(_EVEN)
    rows, columns = rows[low], columns[low]
    turns = np.arange(_DIRECTIONS) * 2 * np.pi / _DIRECTIONS
    along = np.outer(relative[rows, 0, columns], np.cos(turns)) + np.outer(relative[rows, 1, columns], np.sin(turns))
    far = np.full((len(contacts), _DIRECTIONS), -1)
    # Of equally far samples the first one stays, as it is written last.
    at, turn = np.nonzero((along == _of_runs(np.maximum, along, rows))[::-1])
    far[rows[::-1][at], turn] = columns[::-1][at]
    return np.concatenate([contacts, far], axis=1)


def _of_runs(best: np.ufunc, values: Singles, of: Ints) -> Singles:
    """Return the best value of each run of equal numbers in `of`, at each of its places; values along axis 0."""
    begins = np.flatnonzero(np.diff(of, prepend=-1))
    if not len(begins):
        return values
    return np.repeat(best.reduceat(values, begins, axis=0), np.diff(begins, append=len(of)), axis=0)


def stands_easily(body: Body, settled: Settled) -> Mask:
    """Return which robots stand on three contacts of which each is driven and within its friction cone."""
    # Driven contacts within the cone; a part without friction, as a caster, on level ground.
    up = -np.einsum("nj,ncj->nc", settled.axes[:, 2], body.normals[settled.contacts])
    mu = np.array([part.mu for part in body.parts])[body.part[settled.contacts]]
    drives = body.drives[settled.contacts]
    grips = drives & (up > 1 / np.hypot(1, _OF_CONE * mu))
    glides = ~drives & (mu == 0) & (up > _LEVEL)
    return np.asarray((settled.contacts >= 0).all(axis=1) & (grips | glides).all(axis=1) & grips.any(axis=1))


def force_margin(ground: PaddedGround, body: Body, settled: Settled, *, is_moving: bool = True) -> Array:
    """Return the forward force that each robot has left, in shares of its weight, (n,); SLIDING if nothing balances.

    Where a robot stands easily, its margin is only known not to be negative, and is 0. If it does not move, friction
    also holds the parts that are not driven.
    """
    result = np.zeros(len(settled.x))
    hard = np.flatnonzero(~stands_easily(body, settled))
    for begin in range(0, len(hard), 512):
        rows = hard[begin : begin + 512]
        result[rows] = _force_margins(ground, body, settled, rows, is_moving=is_moving)
    return result


def _force_margins(ground: PaddedGround, body: Body, settled: Settled, rows: Ints, *, is_moving: bool) -> Array:
    relative, above = sample_heights(ground, body, settled, rows)
    chosen = outermost(body, relative, above, settled.contacts[rows])
    turned = settled.axes[rows]
    at = relative[np.arange(len(rows))[:, None], :, chosen].astype(np.float64)
    force = -np.einsum("nij,ncj->nci", turned, body.normals[chosen])
    # In the frame of the heading, so that forward is the first axis.
    c, s = np.cos(settled.yaw[rows]), np.sin(settled.yaw[rows])
    heading = np.stack([np.stack([c, s, 0 * c], 1), np.stack([-s, c, 0 * c], 1), np.tile([0.0, 0, 1], (len(c), 1))], 1)
    at, force = at @ np.swapaxes(heading, 1, 2), force @ np.swapaxes(heading, 1, 2)
    # Forward within the plane of the contact; upward on a wall straight ahead, as a tyre or belt drives up it.
    along = np.array([1.0, 0, 0]) - force * force[..., :1]
    length = np.linalg.norm(along, axis=2, keepdims=True)
    along = np.where(length > 1e-6, along / np.maximum(length, 1e-6), np.array([0, 0, 1.0]))
    across = np.cross(force, along)
    parts = body.part[chosen]
    mu, mu2 = (np.array([getattr(part, name) for part in body.parts])[parts][..., None] for name in ("mu", "mu2"))
    drives = body.drives[chosen][..., None] | (not is_moving)
    edges = [
        np.where(drives, force + i * mu * along + j * mu2 * across, force - mu * along)
        for i in (-1, 1)
        for j in (-1, 1)
    ]
    directions = np.concatenate(edges, axis=1)
    # Moments in half lengths of the robot, to be of the size of forces: one tolerance is for both.
    moments = np.cross(np.tile(at, (1, 4, 1)), directions) / max(body.length / 2, 1e-3)
    columns = np.swapaxes(np.concatenate([directions, moments], axis=2), 1, 2)
    columns[np.tile(chosen < 0, (1, 4))[:, None, :].repeat(6, axis=1)] = 0.0
    return _largest_margin(columns)


def _largest_margin(columns: Array) -> Array:
    """Return the largest s for wrenches (n, 6, k); SLIDING where no forces balance the weight."""
    count, rows, wrenches = columns.shape
    # A table: wrenches, s forward and s backward, artificial forces, right side; the last row is the cost.
    # The right side is a little perturbed: with ties the algorithm could go round in a circle.
    right = np.array([0, 0, 1.0, 0, 0, 0]) + 1e-7 * np.arange(1, rows + 1)
    table = np.zeros((count, rows + 1, wrenches + 2 + rows + 1))
    table[:, :rows, :wrenches] = columns
    table[:, 0, wrenches], table[:, 0, wrenches + 1] = -1, 1
    table[:, :rows, wrenches + 2 : -1] = np.eye(rows)
    table[:, :rows, -1] = right
    table[:, rows, wrenches], table[:, rows, wrenches + 1] = -1, 1
    table[:, rows] -= _ARTIFICIAL * np.where(np.arange(table.shape[2]) < wrenches + 2, table[:, :rows].sum(axis=1), 0)
    table[:, rows, -1] = -_ARTIFICIAL * right.sum()
    live = np.arange(count)
    result = np.full(count, SLIDING)
    # Each robot exchanges the column with the least cost for the row with the least ratio; those that are done leave.
    for _ in range(_ITERATIONS):
        entering = table[:, rows, : wrenches + 2].argmin(axis=1)
        index = np.arange(len(live))
        optimal = table[index, rows, entering] > -_ZERO * _ARTIFICIAL
        if optimal.any():
            result[live[optimal]] = np.maximum(table[optimal, rows, -1], SLIDING)  # missing forces cost a thousand
            table, live = table[~optimal], live[~optimal]
            if not len(live):
                break
            entering, index = entering[~optimal], np.arange(len(live))
        column = table[index, :, entering]
        is_open = column[:, :rows] > _PIVOT
        bounded = is_open.any(axis=1)  # forces in cones cannot push without end: else rounding has spoilt the table
        if not bounded.all():
            table, live, column, is_open = table[bounded], live[bounded], column[bounded], is_open[bounded]
            if not len(live):
                break
            index = np.arange(len(live))
        ratios = np.where(is_open, table[:, :rows, -1] / np.where(is_open, column[:, :rows], 1), np.inf)
        leaving = ratios.argmin(axis=1)
        pivot = table[index, leaving] / column[index, leaving][:, None]
        column[index, leaving] = 0
        table[index, leaving] = pivot
        mask = np.ones((len(live), rows + 1), bool)
        mask[index, leaving] = False
        table -= np.where(mask, column, 0)[:, :, None] * pivot[:, None, :]
    return result
