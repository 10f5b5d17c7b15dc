"""`rsegen.poses`: pose, contacts, clearance and stability of a robot at places of a field, and whether it can drive on.

A robot tips over an edge of its support polygon when its centre of mass is above that edge. With the centre of mass h
above the edge and r next to it, that is after a turn by atan(r / h), for which it is lifted by sqrt(h^2 + r^2) - h: the
angle and the energy to tip (Messuri and Klein, IEEE Journal of Robotics and Automation 1985). The polygon is the hull
of its outermost contacts. Cost: 80 to 130 microseconds a pose. What breaks it: momentum, as nothing moves here.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from rsegen.errors import ParameterError, shown
from rsegen.field.stepfield import Array, Ints, Mask, StepField
from rsegen.standing.body import Body
from rsegen.standing.ground import PaddedGround
from rsegen.standing.pushing import SLIDING, force_margin, outermost, sample_heights
from rsegen.standing.settling import Settled, outer_radius, settle

GRAVITY = 9.81

TIPPED = 1.0
"""Slope at which a robot has tipped: 45 degrees, from which no friction holds it."""

_EDGES = 64
"""Directions in which the distance to the edges of the support polygon is measured: within 0.1 % of the least."""

_ROWS = 512
"""Poses whose samples are all looked at together: some ten megabytes."""


REASONS = ("", "cannot push itself on", "slides", "tips over")
"""Reasons why a pose is bad, from good to bad, in words that follow "the robot"; empty for a good one."""


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Poses:
    """Poses of a robot at rest on a field, n of them; lengths in metres, angles in radians.

    Attributes
    ----------
    x, y, z, roll, pitch, yaw : ndarray, shape (n,)
        The robot's origin, as in Gazebo; it was put down level at x, y, so its centre of mass stays there and its
        origin moves a little.
    contacts : ndarray, shape (n, 3, 3)
        The three points that bear it, NaN if it tips over.
    loads : ndarray, shape (n, 3)
        The share of its weight on each.
    support : ndarray, shape (n, 11, 3)
        The corners of its support polygon, in no order, some of them twice.
    clearance : ndarray, shape (n,)
        From the ground to the lowest part that neither drives nor bears it; infinite if it has none.
    tip_angle : ndarray, shape (n,)
        The least turn that tips it over.
    tip_energy : ndarray, shape (n,)
        The least energy that tips it over, joules.
    stands : ndarray of bool, shape (n,)
        Whether it stands there at all.
    holds : ndarray of bool, shape (n,)
        Whether friction holds it.
    pushes : ndarray of bool, shape (n,)
        Whether it can drive forward.
    """

    x: Array
    y: Array
    z: Array
    roll: Array
    pitch: Array
    yaw: Array
    contacts: Array
    loads: Array
    support: Array
    clearance: Array
    tip_angle: Array
    tip_energy: Array
    stands: Mask
    holds: Mask
    pushes: Mask

    @property
    def tilt(self) -> Array:
        """Angle between the robot's upright and the vertical, radians, (n,)."""
        return np.asarray(np.arccos(np.clip(np.cos(self.roll) * np.cos(self.pitch), -1, 1)))

    @property
    def reason(self) -> Ints:
        """Reason why each pose is bad, (n,): the number of the worst of REASONS that holds, 0 for a good pose."""
        return np.select([~self.stands, ~self.holds, ~self.pushes], [3, 2, 1], 0)


def resting_poses(field: StepField, body: Body, x: ArrayLike, y: ArrayLike, heading: ArrayLike) -> Poses:
    """Return the robot at rest at each x, y [m] and heading [rad]; scalars and arrays go together as in numpy.

    ParameterError for a value that is not a finite number, and for a place outside the field.
    """
    at_x, at_y, yaw = places(field, body, x, y, heading)
    ground = PaddedGround.of(field, outer_radius(body))
    return of_settled(ground, body, settle(ground, body, at_x, at_y, yaw))


def places(field: StepField, body: Body, x: ArrayLike, y: ArrayLike, heading: ArrayLike) -> tuple[Array, Array, Array]:
    """Return places of a field [m] and headings [rad] as arrays of one length; errors as in `resting_poses`."""
    if body.length > max(field.extent):
        along, across = field.extent
        raise ParameterError("robot", f"is {body.length:.3g} m long, longer than the map of {along:g} x {across:g} m")
    arrays = [_numbers(name, values) for name, values in (("x", x), ("y", y), ("heading", heading))]
    try:
        at_x, at_y, yaw = (np.ravel(array) for array in np.broadcast_arrays(*arrays))
    except ValueError:
        shapes = ", ".join(str(array.shape) for array in arrays)
        raise ParameterError("", f"x, y and heading of shapes {shapes} do not go together; use one length") from None
    for name, values, extent in (("x", at_x, field.extent[0]), ("y", at_y, field.extent[1])):
        outside = values[np.abs(values) > extent / 2]
        if len(outside):
            raise ParameterError(name, f"{outside[0]:g} m is outside the field, {-extent / 2:g}..{extent / 2:g} m")
    return at_x, at_y, yaw


def _numbers(name: str, values: ArrayLike) -> Array:
    try:
        array = np.asarray(values, np.float64)
    except (TypeError, ValueError):
        raise ParameterError(name, f"{shown(values)} is not a number, nor an array of them") from None
    if not np.isfinite(array).all():
        raise ParameterError(name, "has a number that is not finite")
    return array


def of_settled(ground: PaddedGround, body: Body, rest: Settled) -> Poses:
    """Return the poses of robots at rest, with their contacts, clearance and stability."""
    contacts, loads, support, clearance, angle, energy = _all_measured(ground, body, rest)
    # Settling works with the centre of mass; a pose is of the robot's origin, as simulators have it.
    origin = -np.einsum("nij,j->ni", rest.axes, body.centre)
    forward, left, up = (rest.axes[:, :, axis] for axis in range(3))
    stands = has_stood(rest)
    return Poses(
        x=rest.x + origin[:, 0],
        y=rest.y + origin[:, 1],
        z=rest.z + origin[:, 2],
        roll=np.arctan2(left[:, 2], up[:, 2]),
        pitch=-np.arcsin(np.clip(forward[:, 2], -1, 1)),
        yaw=np.arctan2(forward[:, 1], forward[:, 0]),
        contacts=contacts,
        loads=loads,
        support=support,
        clearance=clearance,
        tip_angle=np.where(stands, angle, 0.0),
        tip_energy=np.where(stands, energy, 0.0),
        stands=stands,
        holds=stands & (force_margin(ground, body, rest, is_moving=False) > SLIDING),
        pushes=stands & (force_margin(ground, body, rest) >= 0),
    )


def margins(ground: PaddedGround, body: Body, rest: Settled) -> Array:
    """Return the least turn that tips each robot over, radians, (n,); 0 for one that does not stand."""
    return np.where(has_stood(rest), _all_measured(ground, body, rest)[4], 0.0)


def has_stood(rest: Settled) -> Mask:
    """Return which robots stand: on three contacts around the centre of mass, and not tipped over, (n,)."""
    return np.asarray((rest.contacts >= 0).all(axis=1) & (np.hypot(*rest.slope.T) < TIPPED))


def _all_measured(ground: PaddedGround, body: Body, rest: Settled) -> list[Array]:
    count = len(rest.x)
    parts = [_measured(ground, body, rest, np.arange(i, min(i + _ROWS, count))) for i in range(0, count, _ROWS)]
    return [np.concatenate(arrays) for arrays in zip(*parts, strict=True)] if parts else _nothing()


def _nothing() -> list[Array]:
    shapes = ((0, 3, 3), (0, 3), (0, 11, 3), (0,), (0,), (0,))
    return [np.empty(shape) for shape in shapes]


def _measured(ground: PaddedGround, body: Body, rest: Settled, rows: Ints) -> tuple[Array, ...]:
    """Return contacts, loads, support, clearance, angle and energy to tip of some of the robots."""
    relative, above = sample_heights(ground, body, rest, rows)
    centres = np.stack([rest.x[rows], rest.y[rows], rest.z[rows]], axis=1)[:, None, :]
    bearing = rest.contacts[rows]
    index = np.arange(len(rows))[:, None]
    at = relative[index, :, bearing].astype(np.float64)
    at[bearing < 0] = np.nan
    chosen = outermost(body, relative, above, bearing)
    corners = relative[index, :, chosen].astype(np.float64)
    corners[chosen < 0] = np.nan
    # In each direction the farthest corner; the least of these distances is the one to the nearest edge of the polygon.
    turns = np.arange(_EDGES) * 2 * np.pi / _EDGES
    along = corners[..., 0, None] * np.cos(turns) + corners[..., 1, None] * np.sin(turns)
    aside = np.maximum(np.nanmax(np.where(np.isnan(along), -np.inf, along), axis=1).min(axis=1), 0.0)
    high = np.where(np.isnan(corners[..., 2]), 0.0, -corners[..., 2]).sum(axis=1)
    high = np.maximum(high / np.maximum((chosen >= 0).sum(axis=1), 1), 1e-6)
    # Driven parts, and the parts of the three contacts, should touch the ground; clearance is for all others.
    bears = (body.part == body.part[bearing][..., None]).any(axis=1)
    clearance = np.where(body.drives | bears, np.inf, above).min(axis=1)
    return (
        at + centres,
        loads_on(at),
        corners + centres,
        np.maximum(clearance, 0.0),
        np.arctan2(aside, high),
        body.mass * GRAVITY * (np.hypot(aside, high) - high),
    )


def loads_on(at: Array) -> Array:
    """Return the share of the weight on each of three contacts around the origin: barycentric coordinates, (n, 3)."""
    x, y = at[..., 0], at[..., 1]
    areas = np.stack([x[:, j] * y[:, k] - x[:, k] * y[:, j] for j, k in ((1, 2), (2, 0), (0, 1))], axis=1)
    return np.asarray(areas / areas.sum(axis=1, keepdims=True))
