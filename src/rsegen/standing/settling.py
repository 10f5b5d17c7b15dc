"""Poses in which a robot rests: its potential energy is least, so its centre of mass is above three of its contacts.

1. With the centre of mass over (x, y), the heading and a tilt given, each sample of the underside, at (u, v) from the
   centre of mass, demands that it is at least g = ground below the sample minus the sample's height there.
2. The least c with c + a u + b v >= g for all samples is a linear programme in three unknowns. Its solution is the
   facet of the upper convex hull of the points (u, v, g) above the origin: three contacts around the centre of mass.
   It is found by exchange: the plane through three samples around the origin, the sample farthest above that plane in,
   and one of the three out, such that the origin stays between them; the plane at the origin rises with each exchange.
3. The robot is turned by (a, b), all the way where its contacts stay and by a share of it where they change, and so on
   from 1 until the turn is below 1e-4: two to ten rounds.

All poses of a chunk are done at once. After two rounds only the samples near the ground are looked at; a last round
with all of them shows whether that was right, and goes on with all where it was not. Cost: 50 to 130 microseconds a
pose. What breaks it: robots that stand equally well in two ways, as one with four wheels and its centre of mass on the
diagonal; it takes one of them. And a part against the side of a block: it never comes to rest at the very edge.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from rsegen.field.stepfield import Array, Ints, Mask, StepField
from rsegen.standing.body import Body

_ROUNDS, _FULL, _STILL, _DAMPED = 10, 2, 1e-4, 0.7
"""Rounds at most, rounds with all samples, the turn at which it ends, and the share that is made as contacts change."""

_LOST = 2.5
"""Slope from which no robot comes back: it tips over."""

_NEAR, _LAST = 96, 6
"""Samples that are looked at after the first rounds, and rounds with all of them again at the end, at most."""

_MOST_TURN, _STEEPEST = 0.3, 3.0
"""The largest turn in a round and the steepest slope at all: a robot that tips over is not followed to its side."""

_EXCHANGES, _ABOVE = 40, 2e-5
"""Exchanges at most; metres by which a sample may be above the plane."""

_FAR, _DEEP = 1e3, -5e4
"""Three far samples, metres away, so deep that any other one is above them: the first three."""

_CHUNK = 1_000_000
"""Samples of all poses of a chunk: the calls of numpy then cost little beside their work."""

_BLOCK = 80_000
"""Samples of poses that are looked at together: their arrays of 0.3 MB stay in the cache of a core, and from 87,000 on
BLAS would use a second core, and win nothing."""

SINGLE = np.float32
Singles = NDArray[np.float32]
_Rows = TypeVar("_Rows", bound=Any)


@dataclass(frozen=True, slots=True, eq=False)
class PaddedGround:
    """The ground of a field, flat as an array with a border of level ground.

    heights: metres, (rows * columns,); width: of a block, metres; half: cells from the corner to the origin
    """

    heights: Singles
    shape: tuple[int, int]
    width: float
    half: tuple[float, float]
    border: int

    @classmethod
    def of(cls, field: StepField, reach: float) -> PaddedGround:
        """Return the ground of a field, for robots that reach so many metres from their centre of mass."""
        border = int(np.ceil(reach / field.block_width)) + 2
        heights = np.pad(field.heights, border).astype(SINGLE)
        n_x, n_y = field.shape
        return cls(heights.ravel(), heights.shape, field.block_width, (n_x / 2 + border, n_y / 2 + border), border)

    def below(self, x: Array, y: Array) -> Array:
        """Return the heights of the ground at places in metres, of any shape; outside the field it is 0."""
        i = np.clip(x / self.width + self.half[0], 0, self.shape[0] - 1).astype(np.intp)
        j = np.clip(y / self.width + self.half[1], 0, self.shape[1] - 1).astype(np.intp)
        return np.asarray(self.heights[i * self.shape[1] + j], np.float64)


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Settled:
    """Robots at rest, n of them.

    x, y, z: of the centre of mass, metres; slope: (n, 2), of the robot's plane along x and y
    axes: (n, 3, 3), whose columns are the robot's x, y and z in the world; contacts: (n, 3) samples, -1 for none
    turn: by which the last round would still have turned it, radians
    """

    x: Array
    y: Array
    z: Array
    yaw: Array
    slope: Array
    axes: Array
    contacts: Ints
    turn: Array

    @property
    def tilt(self) -> Array:
        """Return the angle between each robot's upright and the vertical, radians, (n,)."""
        return np.asarray(np.arctan(np.hypot(*self.slope.T)))

    def some(self, rows: slice | Ints) -> Settled:
        """Return some of them."""
        return Settled(**{field.name: getattr(self, field.name)[rows] for field in fields(self)})


def joined(parts: Sequence[_Rows]) -> _Rows:
    """Return robots at rest, or poses, one after the other."""
    names = [each.name for each in fields(parts[0])]
    values = {name: np.concatenate([getattr(part, name) for part in parts]) for name in names}
    return cast("_Rows", type(parts[0])(**values))


def reach_of(body: Body) -> float:
    """Return how far a robot reaches from its centre of mass, metres."""
    return float(np.linalg.norm(body.points - body.centre, axis=1).max())


def settle(ground: PaddedGround, body: Body, x: Array, y: Array, yaw: Array) -> Settled:
    """Return the robot at rest after it was put down level with its origin at x, y [m] and a heading [rad], (n,)."""
    c, s = np.cos(yaw), np.sin(yaw)
    at_x, at_y = x + c * body.centre[0] - s * body.centre[1], y + s * body.centre[0] + c * body.centre[1]
    count, per_chunk = len(x), max(_CHUNK // (len(body.points) + 3), 8)
    slope, z, turn = np.zeros((count, 2)), np.zeros(count), np.zeros(count)
    contacts = np.zeros((count, 3), np.int64)
    for begin in range(0, count, per_chunk):
        part = slice(begin, min(begin + per_chunk, count))
        slope[part], z[part], contacts[part], turn[part] = _settled(ground, body, at_x[part], at_y[part], yaw[part])
    contacts[contacts >= len(body.points)] = -1
    return Settled(x=at_x, y=at_y, z=z, yaw=yaw, slope=slope, axes=axes(slope, yaw), contacts=contacts, turn=turn)


def axes(slope: Array, yaw: Array) -> Array:
    """Return the robot's axes as columns (n, 3, 3); its x axis stays in the vertical plane of its heading."""
    c, s = np.cos(yaw), np.sin(yaw)
    along = slope[:, 0] * c + slope[:, 1] * s
    forward = np.stack([c, s, along], axis=1) / np.sqrt(1 + along**2)[:, None]
    up = np.stack([-slope[:, 0], -slope[:, 1], np.ones_like(c)], axis=1)
    up /= np.linalg.norm(up, axis=1)[:, None]
    return np.stack([forward, np.cross(up, forward), up], axis=2)


def _settled(ground: PaddedGround, body: Body, x: Array, y: Array, yaw: Array) -> tuple[Array, Array, Ints, Array]:
    """Return slope, height of the centre of mass, contacts and the last turn of each robot of a chunk."""
    count, samples = len(x), len(body.points)
    offsets = (body.points - body.centre).T.astype(SINGLE)
    slope, height, turn = np.zeros((count, 2)), np.zeros(count), np.full(count, np.inf)
    contacts = np.tile(np.arange(samples, samples + 3), (count, 1))
    live, near, few, of_few = np.arange(count), None, offsets, np.empty(0, np.int64)
    number, rounds = 0, _ROUNDS
    while number < rounds and len(live):
        start = contacts[live] if near is None else _positions(near, contacts[live], samples)
        u, v, g = _demands(ground, few, x[live], y[live], axes(slope[live], yaw[live]))
        three, a, b, c = _plane(u, v, g, start)
        own = three if near is None else np.take_along_axis(near, three, axis=1)
        # On the same contacts the turn is Newton's step; where they changed, a whole one may go too far.
        same = (np.sort(own, axis=1) == np.sort(contacts[live], axis=1)).all(axis=1)
        contacts[live], height[live] = own, c
        turn[live] = steep = np.hypot(a, b)
        still = (steep < _STILL) | (np.hypot(*slope[live].T) > _LOST)
        share = np.minimum(1.0 if number == 0 else np.where(same, 1.0, _DAMPED), _MOST_TURN / np.maximum(steep, 1e-12))
        slope[live] = np.clip(
            slope[live] + np.where(still, 1.0, share)[:, None] * np.stack([a, b], 1), -_STEEPEST, _STEEPEST
        )
        number += 1
        if number == _FULL and samples > 2 * _NEAR:
            # Those in contact and the three far ones are always among them.
            far = np.tile(np.arange(samples, samples + 3), (len(live), 1))
            near = np.concatenate([_nearest(u, v, g, a, b, c), contacts[live], far], axis=1)[~still]
            few = np.ascontiguousarray(np.moveaxis(offsets[:, near[:, :-3]], 0, 1))
            of_few = live[~still]
        elif near is not None:
            near, few = near[~still], few[~still]
        live = live[~still]
        if near is not None and (number == rounds or not len(live)):
            live, near, few, rounds = of_few, None, offsets, number + _LAST
    return slope, height, contacts, turn


def _nearest(u: Singles, v: Singles, g: Singles, a: Array, b: Array, c: Array) -> Ints:
    """Return the samples nearest to the plane of each row, (n, 96), but for the three far ones."""
    chosen = np.empty((len(u), _NEAR), np.int64)
    for part in _blocks(*u.shape):
        slack = a[part, None] * u[part]
        slack += b[part, None] * v[part]
        slack += c[part, None]
        slack -= g[part]
        chosen[part] = np.argpartition(slack[:, :-3], _NEAR, axis=1)[:, :_NEAR]
    return chosen


def _blocks(rows: int, samples: int) -> Iterator[slice]:
    """Yield slices of some rows each, whose samples stay in the cache of a core."""
    step = max(_BLOCK // samples, 1)
    yield from (slice(begin, begin + step) for begin in range(0, rows, step))


def _positions(near: Ints, contacts: Ints, samples: int) -> Ints:
    """Return where each contact is in its row of `near`, (n, 3)."""
    return np.asarray((near[:, :, None] == contacts[:, None, :]).argmax(axis=1))


def _demands(
    ground: PaddedGround, offsets: Singles, x: Array, y: Array, turned: Array
) -> tuple[Singles, Singles, Singles]:
    """Return u, v and g of samples, (n, m + 3), three far ones last; offsets: (3, m) of all or (n, 3, m) of some."""
    count, width = len(x), offsets.shape[-1] + 3
    u, v, g = (np.empty((count, width), SINGLE) for _ in range(3))
    inner, far = slice(0, width - 3), slice(width - 3, width)
    single, (rows, columns) = turned.astype(SINGLE), ground.shape
    i, j = (x / ground.width + ground.half[0])[:, None], (y / ground.width + ground.half[1])[:, None]
    for part in _blocks(*u.shape):
        if offsets.ndim == 2:
            for array, row in zip((u, v, g), range(3), strict=True):
                np.matmul(single[part, row], offsets, out=array[part, inner])
        else:
            moved = np.matmul(single[part], offsets[part])
            for array, row in zip((u, v, g), range(3), strict=True):
                array[part, inner] = moved[:, row]
        cells = _along(u[part, inner], i[part].astype(SINGLE), ground.width, rows) * np.int32(columns)
        cells += _along(v[part, inner], j[part].astype(SINGLE), ground.width, columns)
        below = ground.heights.take(cells.astype(np.intp), mode="clip")
        np.subtract(below, g[part, inner], out=g[part, inner])
    u[:, far] = np.array([_FAR, -_FAR / 2, -_FAR / 2], SINGLE)
    v[:, far] = np.array([0, 0.866 * _FAR, -0.866 * _FAR], SINGLE)
    g[:, far] = _DEEP
    return u, v, g


def _along(offset: Singles, middle: Singles, width: float, cells: int) -> NDArray[np.int32]:
    """Return the cells along an axis in which samples are, offset from a middle; the nearest ones outside."""
    place = offset * SINGLE(1 / width)
    place += middle
    return np.clip(place, 0, cells - 1, out=place).astype(np.int32)


def _plane(u: Singles, v: Singles, g: Singles, three: Ints) -> tuple[Ints, Array, Array, Array]:
    """Return three samples around the origin and a, b, c of the plane through them, which no sample is above."""
    count = len(u)
    three, a, b, c = three.copy(), np.zeros(count), np.zeros(count), np.zeros(count)
    # The contacts of the round before have moved as the robot was turned; where the origin left them, from afar again.
    rows = np.arange(count)[:, None]
    three[~_surrounds(u[rows, three], v[rows, three])] = np.arange(u.shape[1] - 3, u.shape[1])
    live = np.arange(count)
    for _ in range(_EXCHANGES):
        own = three[live]
        at_u, at_v, at_g = (array[live[:, None], own].astype(np.float64) for array in (u, v, g))
        a[live], b[live], c[live] = _through(at_u, at_v, at_g)
        highest, above = _highest(u, v, g, a, b, live)
        # One of the three is above their plane by rounding alone: far ones by millimetres.
        rises = (above - c[live] > _ABOVE) & (own != highest[:, None]).all(axis=1)
        live, own, at_u, at_v, highest = live[rises], own[rises], at_u[rises], at_v[rises], highest[rises]
        if not len(live):
            break
        # The origin is between the new sample and two of the three: exactly one pair, but for rounding.
        new_u, new_v = (array[live, highest].astype(np.float64)[:, None] for array in (u, v))
        kept = _PAIRS[_least_share(new_u, new_v, at_u, at_v).argmax(axis=1)]
        three[live, 0] = highest
        three[live, 1:] = np.take_along_axis(own, kept, axis=1)
    return three, a, b, c


def _highest(u: Singles, v: Singles, g: Singles, a: Array, b: Array, rows: Ints) -> tuple[Ints, Singles]:
    """Return the sample that is highest above the plane a u + b v in each of some rows, and its height above it."""
    highest, above = np.empty(len(rows), np.intp), np.empty(len(rows), SINGLE)
    for part in _blocks(len(rows), u.shape[1]):
        at = rows[part]
        over = u.take(at, axis=0)
        over *= -a[at, None].astype(SINGLE)
        term = v.take(at, axis=0)
        term *= b[at, None].astype(SINGLE)
        over -= term
        over += g.take(at, axis=0)
        over.argmax(axis=1, out=highest[part])
        above[part] = over[np.arange(len(at)), highest[part]]
    return highest, above


def _through(u: Array, v: Array, g: Array) -> tuple[Array, Array, Array]:
    """Return a, b, c of the plane g = a u + b v + c through three points each, (n, 3)."""
    (u1, u2), (v1, v2), (g1, g2) = ((array[:, 1] - array[:, 0], array[:, 2] - array[:, 0]) for array in (u, v, g))
    area = u1 * v2 - u2 * v1
    area = np.where(np.abs(area) < 1e-12, 1e-12, area)
    a, b = (g1 * v2 - g2 * v1) / area, (u1 * g2 - u2 * g1) / area
    return a, b, g[:, 0] - a * u[:, 0] - b * v[:, 0]


def _surrounds(u: Singles, v: Singles) -> Mask:
    """Return which triangles (n, 3) hold the origin, (n,): it is on the same side of all of their sides."""
    sides = np.stack([u[:, j] * v[:, k] - u[:, k] * v[:, j] for j, k in _PAIRS], axis=1)
    return np.asarray((sides >= 0).all(axis=1) | (sides <= 0).all(axis=1))


_PAIRS = np.array([(0, 1), (1, 2), (2, 0)])


def _least_share(new_u: Array, new_v: Array, u: Array, v: Array) -> Array:
    """Return the least barycentric coordinate of the origin in the triangles of a new point and each pair, (n, 3)."""
    u1, v1 = u - new_u, v - new_v
    u2, v2 = u1[:, [1, 2, 0]], v1[:, [1, 2, 0]]
    area = u1 * v2 - u2 * v1
    flat = np.abs(area) < 1e-12
    area[flat] = 1.0
    first, second = (u2 * new_v - new_u * v2) / area, (new_u * v1 - u1 * new_v) / area
    least = np.minimum(np.minimum(first, second), 1 - first - second)
    least[flat] = -np.inf
    return np.asarray(least)
