"""Poses in which a robot rests: with least potential energy, so with its centre of mass above three of its contacts.

1. With the centre of mass over (x, y), the heading and a tilt given, each sample of the underside, at (u, v) from the
   centre of mass, demands that it is at least g = ground below the sample minus the sample's height there.
2. The least c with c + a u + b v >= g for all samples is a linear programme in three unknowns. Its solution is the
   facet of the upper convex hull of the points (u, v, g) above the origin: three contacts around the centre of mass.
   It is found by exchange, the dual simplex method (Lemke 1954): the plane through three samples around the origin,
   the sample farthest above that plane in, and one of the three out, such that the origin stays between them; the
   plane at the origin rises with each exchange.
3. The robot is turned by (a, b), all the way where its contacts stay and by a share of it where they change, and so on
   from 1 until the turn is below 1e-4: two to twelve rounds.

In a section along u, with two contacts in place of three:

    g ^                   __--*        * contact: the plane through both of them is above all other samples
      |           __--+--              + its height c above the origin, where the centre of mass is
      |     *_--      |  .             . sample below the plane; one above it would take the place of a contact
      |        .      | .
      +---------------+-----------> u
                      0

Some thousand robots are turned at once, and those that rest make room for others. Samples are in groups of neighbours
(body.py). At first one sample of each group is looked at; their three contacts are near enough to tell which groups
count. Then looks at all samples alternate with rounds of few samples. In a look at all, the robot rests if no sample is
above the plane of its contacts and that plane is level. If not, the few are the groups that are highest above that
plane or least below it; the robot is turned on them until it is still, or turned so far that other groups may count.

Cost: 20 to 50 microseconds a pose in thousands, most where a robot leans against blocks, and some 13 milliseconds a
call of a hundred, as a few take all rounds. What breaks it: robots that stand equally well in two poses, as with four
wheels and the centre of mass on a diagonal; one of the poses is taken (stable.py finds the others). And a part against
the side of a block: it goes to and fro over the edge, with shorter turns, and ends there before it is still.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, TypeVar, cast

import numpy as np

from rsegen.field.stepfield import Array, Ints, Mask
from rsegen.standing.body import Body
from rsegen.standing.ground import SINGLE, PaddedGround, Singles, row_slices

_STILL, _ROUNDS, _LOOKS = 1e-4, 12, 6
"""The turn at which a robot is still; rounds, and looks at all samples after the first, at most. Robots that lean
against the side of a block take all of them: with eight looks they cost more, and are found no better."""

_DAMPED, _DAMPED_ROUNDS = 0.7, 8
"""Share of a turn that is made as contacts change, and rounds from whose end on it shrinks by itself in each."""

_NEAR, _AROUND = 20, 0.1
"""Groups that are looked at until a robot has turned by that slope: its ends are then 3 cm nearer to the ground. With
14 groups 2 % of the poses are found less well, with 28 it takes a tenth longer."""

_LOST = 2.5
"""Slope from which no robot comes back: it tips over."""

_MOST_TURN, _STEEPEST = 0.3, 3.0
"""The largest turn in a round and the steepest slope at all: a robot that tips over is not followed to its side."""

_EXCHANGES, _ABOVE, _SHARE = 40, 2e-5, 0.3
"""Exchanges at most; metres by which a sample may be above the plane; share of robots still in exchange at which the
others are left out: to copy a row costs more than to look at it."""

_FAR, _DEEP = 1e3, -5e4
"""Three far samples, metres away, so deep that any other one is above them: the first three."""

_CHUNK = 4096
"""Robots that turn together at most; their few samples are 8 MB."""

_Rows = TypeVar("_Rows", bound=Any)


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
        """Return the robots of some rows."""
        return Settled(**{field.name: getattr(self, field.name)[rows] for field in fields(self)})


def joined(parts: Sequence[_Rows]) -> _Rows:
    """Return robots at rest, or poses, one after the other."""
    names = [field.name for field in fields(parts[0])]
    values = {name: np.concatenate([getattr(part, name) for part in parts]) for name in names}
    return cast("_Rows", type(parts[0])(**values))


def outer_radius(body: Body) -> float:
    """Return the radius of the sphere about its centre of mass that holds a whole robot, metres."""
    return float(np.linalg.norm(body.points - body.centre, axis=1).max())


def settled_on_level(ground: PaddedGround, body: Body) -> tuple[PaddedGround, Settled]:
    """Return a level ground as large as another one, and a robot at rest at its middle."""
    level, origin = replace(ground, heights=np.zeros_like(ground.heights)), np.zeros(1)
    return level, settle(level, body, origin, origin, origin)


def settle(ground: PaddedGround, body: Body, x: Array, y: Array, yaw: Array) -> Settled:
    """Return the robot at rest after it was put down level with its origin at x, y [m] and a heading [rad], (n,)."""
    return settle_from(ground, body, *centre_at(body, x, y, yaw), yaw, np.zeros((len(x), 2)))


def centre_at(body: Body, x: Array, y: Array, yaw: Array) -> tuple[Array, Array]:
    """Return where the centre of mass of a level robot is whose origin is at x, y [m], with a heading [rad], (n,)."""
    c, s = np.cos(yaw), np.sin(yaw)
    return x + c * body.centre[0] - s * body.centre[1], y + s * body.centre[0] + c * body.centre[1]


def settle_from(ground: PaddedGround, body: Body, x: Array, y: Array, yaw: Array, slope: Array) -> Settled:
    """Return the robot at rest after it was put down at a slope (n, 2) with its centre of mass at x, y, (n,)."""
    robots = _Settling(ground, body, x, y, yaw, slope)
    robots.settle()
    samples = np.append(body.groups.T, [-1, -1, -1])
    return Settled(
        x=x,
        y=y,
        z=robots.height,
        yaw=yaw,
        slope=robots.slope.T,
        axes=axes(robots.slope.T, yaw),
        contacts=samples[robots.three.T],
        turn=robots.turn,
    )


def axes(slope: Array, yaw: Array) -> Array:
    """Return the robot's axes as columns (n, 3, 3); its x axis stays in the vertical plane of its heading."""
    return np.moveaxis(_axes(slope.T, np.cos(yaw), np.sin(yaw)), 2, 0)


def _axes(slope: Array, c: Array, s: Array) -> Array:
    """Return the robot's axes as columns, (3, 3, n), for slopes (2, n) and the cosines and sines of the headings."""
    # Forward (c, s, along) and upright (-a, -b, 1), both normalized; left is upright x forward.
    a, b = slope
    along = a * c + b * s
    length, high = 1 / np.sqrt(1 + along**2), 1 / np.sqrt(1 + a**2 + b**2)
    x, y, z = c * length, s * length, along * length
    left = -(b * z + y) * high, (x + a * z) * high, (b * x - a * y) * high
    return np.array([[x, left[0], -a * high], [y, left[1], -b * high], [z, left[2], high]])


@dataclass(frozen=True, slots=True, eq=False)
class _Turning:
    """Robots that are turned on few samples each, n of them.

    rows: (n,) their numbers; columns: (n, k) the few samples, the last six of them the contacts and the far ones
    few: (n, 3, k) positions of these from the centre of mass; three: (3, n) which of the k are the contacts
    before: (2, n) slopes at the last look at all samples
    """

    rows: Ints
    columns: Ints
    few: Singles
    three: Ints
    before: Array

    def some(self, going: Ints) -> _Turning:
        """Return the robots of some rows."""
        return _Turning(
            self.rows[going], self.columns[going], self.few[going], self.three[:, going], self.before[:, going]
        )

    def joined(self, others: _Turning) -> _Turning:
        """Return these robots and others, one after the other."""
        if not len(self.rows):
            return others
        return _Turning(
            np.concatenate([self.rows, others.rows]),
            np.concatenate([self.columns, others.columns]),
            np.concatenate([self.few, others.few]),
            np.concatenate([self.three, others.three], axis=1),
            np.concatenate([self.before, others.before], axis=1),
        )


class _Settling:
    """Robots as they settle, n of them.

    points: (3, m), samples from the centre of mass, of whole groups, of which column k is one of group k % groups, and
    three far ones
    middle: (2, n), of the centres of mass in cells of the padded ground; heading: (2, n), its cosine and sine
    three: (3, n), columns of the contacts, counterclockwise; slope: (2, n); height, turn: (n,), as in Settled
    rounds, looks: (n,), those that each robot has had
    """

    def __init__(self, ground: PaddedGround, body: Body, x: Array, y: Array, yaw: Array, slope: Array) -> None:
        count, self.groups = len(x), len(body.groups)
        points = np.concatenate([body.points[body.groups.T.ravel()] - body.centre, _AFAR])
        self.ground, self.points = ground, np.ascontiguousarray(points.T, SINGLE)
        self.middle = ground.middles(x, y)
        self.heading, self.slope = np.array([np.cos(yaw), np.sin(yaw)]), slope.T.copy()
        self.three = np.tile(np.arange(body.groups.size, body.groups.size + 3)[:, None], count)
        self.height, self.turn = np.zeros(count), np.full(count, np.inf)
        self.rounds, self.looks = np.zeros((2, count), int)

    def settle(self) -> None:
        """Turn the robots until they are still."""
        # Each robot is put down, then waits for a look at all samples or is turned on few; `looks` and `rounds` end it.
        begun, count, waiting = 0, len(self.turn), np.empty(0, np.intp)
        turning = self.look_at_all_samples(waiting)
        while begun < count or len(waiting) or len(turning.rows):
            # Those that end make room for others, so that no call of numpy is for few, but for the last ones.
            if len(turning.rows) <= max(min(_CHUNK // 2, count - begun), len(waiting)):
                new = np.arange(begun, min(begun + _CHUNK - len(turning.rows), count))
                begun += len(new)
                self.begin(new)
                turning = turning.joined(self.look_at_all_samples(np.concatenate([waiting, new])))
                waiting = waiting[:0]
            goes_on = self.turn_once(turning)
            if not goes_on.all():
                waiting = np.concatenate([waiting, turning.rows[~goes_on]])
                turning = turning.some(np.flatnonzero(goes_on))
        # Those that end before they are still are as high as all of their samples demand.
        self.find_contacts(np.flatnonzero(np.isinf(self.turn)))

    def begin(self, rows: Ints) -> None:
        """Find the contacts of some robots as they are put down, among one sample of each group."""
        if not len(rows):
            return
        coarse = np.append(np.arange(self.groups), self.points.shape[1] + np.arange(-3, 0))
        three = np.tile(np.arange(self.groups, self.groups + 3)[:, None], len(rows))
        few, turned = _of_each(self.points[:, coarse], len(rows)), self.axes(rows)
        _plane(self.under(few, rows, turned), few, turned, three)
        self.three[:, rows] = coarse[three]

    def turn_once(self, turning: _Turning) -> Mask:
        """Turn robots by the planes of their few samples; return which of them go on with these."""
        rows, three = turning.rows, turning.three
        turned, before = self.axes(rows), three.copy()
        a, b, c = _plane(self.under(turning.few, rows, turned), turning.few, turned, three)
        self.three[:, rows] = own = turning.columns[np.arange(len(rows)), three]
        # On the same contacts the turn is Newton's step; where they changed, a whole one may go too far.
        same = (three[:, None] == before).any(axis=1).all(axis=0) | (self.rounds[rows] == 0)
        self.rounds[rows] += 1
        share = np.where(same, 1.0, _DAMPED ** np.maximum(self.rounds[rows] - _DAMPED_ROUNDS + 1, 1))
        steep = np.hypot(a, b)
        share = np.minimum(share, _MOST_TURN / np.maximum(steep, 1e-12))
        # With a far one among the three the few samples do not surround the origin; the next look takes others.
        share[(own >= self.points.shape[1] - 3).any(axis=0)] = 0.0
        self.height[rows], self.turn[rows] = c, steep
        self.slope[:, rows] = slope = np.clip(self.slope[:, rows] + share * (a, b), -_STEEPEST, _STEEPEST)
        moves = (share * steep >= _STILL) & (np.hypot(*slope) <= _LOST)
        near = np.hypot(*(slope - turning.before)) < _AROUND
        return np.asarray(moves & near & (self.rounds[rows] < _ROUNDS))

    def look_at_all_samples(self, rows: Ints) -> _Turning:
        """Return the robots that neither rest nor tip over, with the samples of each on which they turn next."""
        samples, count = self.points.shape[1] - 3, min(_NEAR, self.groups)
        # As a robot is turned its contacts move. Where they no longer surround its centre, their plane is of no use,
        # and it goes on with the samples that are highest as it stands.
        turned, three = self.axes(rows), self.three[:, rows]
        at = np.einsum("ijn,jkn->ikn", turned[:2], self.points[:, three])
        lost = ~_surrounds(at)
        self.looks[rows] += 1
        contacts, index = np.moveaxis(self.points[:, three], 2, 0), np.arange(len(rows))
        under = self.ground.under(self.scaled(turned) @ contacts, self.middle[:, rows])
        under[(three >= samples).T] = _DEEP
        plane = _through(_placed(under, contacts, turned, index, np.tile(np.arange(3)[:, None], len(rows))))
        plane[:, lost] = 0.0
        of_groups = self.highest_of_groups(rows, turned, plane)
        turn = np.where((of_groups.max(axis=1) - plane[2] <= _ABOVE) & ~lost, np.hypot(*plane[:2]), np.inf)
        self.height[rows], self.turn[rows] = plane[2], turn
        tips = (three >= samples).any(axis=0) | (np.hypot(*self.slope[:, rows]) > _LOST)
        is_open = (self.rounds[rows] < _ROUNDS) & (self.looks[rows] <= _LOOKS)
        goes_on = np.flatnonzero((turn >= _STILL) & ~tips & is_open)
        # The few: all members of the groups nearest to the plane, then the contacts, then the three far samples.
        nearest = np.argpartition(of_groups[goes_on], -count, axis=1)[:, -count:]
        members = samples // self.groups
        columns = np.empty((len(goes_on), members * count + 6), np.intp)
        np.add(
            nearest[:, None],
            self.groups * np.arange(members)[:, None],
            out=columns[:, :-6].reshape(-1, members, count),
        )
        columns[:, -6:-3], columns[:, -3:] = three[:, goes_on].T, np.arange(samples, samples + 3)
        return self.turning(rows[goes_on], columns)

    def highest_of_groups(self, rows: Ints, turned: Array, plane: Array) -> Singles:
        """Return how high the highest sample of each group is above a plane moved to the origin, (n, groups)."""
        samples, groups = np.ascontiguousarray(self.points[:, :-3]), np.empty((len(rows), self.groups), SINGLE)
        scaled, normals, middle = self.scaled(turned), _normals(turned, plane), self.middle[:, rows]
        every = _of_each(samples, len(rows))
        for part in row_slices(len(rows), samples.shape[1]):
            over = self.ground.under(_times(scaled[part], every[part]), middle[:, part])
            over -= normals[part] @ samples
            over.reshape(len(over), -1, self.groups).max(axis=1, out=groups[part])
        return groups

    def turning(self, rows: Ints, columns: Ints) -> _Turning:
        """Return some robots that are turned on some of their samples, columns (n, k) as in _Turning."""
        few = np.moveaxis(self.points.take(columns, axis=1, mode="clip"), 0, 1)
        three = np.tile(columns.shape[1] + np.arange(-6, -3)[:, None], len(rows))
        return _Turning(rows, columns, few, three, self.slope[:, rows])

    def find_contacts(self, rows: Ints) -> None:
        """Find the contacts of robots among all samples, from those that they have."""
        if not len(rows):
            return
        three, turned, every = self.three[:, rows], self.axes(rows), _of_each(self.points, len(rows))
        a, b, c = _plane(self.under(every, rows, turned), every, turned, three)
        self.three[:, rows], self.height[rows], self.turn[rows] = three, c, np.hypot(a, b)

    def axes(self, rows: Ints) -> Array:
        """Return the axes of some robots, (3, 3, n)."""
        return _axes(self.slope[:, rows], *self.heading[:, rows])

    def under(self, few: Singles, rows: Ints, turned: Array) -> Singles:
        """Return the heights of the ground under samples (n, 3, m) of some robots, (n, m)."""
        scaled, under, middle = self.scaled(turned), np.empty((len(rows), few.shape[2]), SINGLE), self.middle[:, rows]
        for part in row_slices(*under.shape):
            under[part] = self.ground.under(_times(scaled[part], few[part]), middle[:, part])
        under[:, -3:] = _DEEP
        return under

    def scaled(self, turned: Array) -> Singles:
        """Return the first two rows of axes, (n, 2, 3), which give places in cells."""
        return np.ascontiguousarray(np.moveaxis(turned[:2] / self.ground.width, 2, 0), SINGLE)


def _of_each(array: _Rows, count: int) -> _Rows:
    """Return the same array for each of some robots, (count, ...), without a copy."""
    return cast("_Rows", np.broadcast_to(array, (count, *array.shape)))


def _times(axes: Singles, few: Singles) -> Singles:
    """Return products of k axes of each robot and its samples, (n, k, 3) and (n, 3, m): (n, k, m)."""
    # All robots have the same samples (`_of_each`): one large product in place of many small ones.
    if few.strides[0] == 0 and len(few):
        return np.asarray((axes.reshape(-1, 3) @ few[0]).reshape(*axes.shape[:2], few.shape[2]))
    return np.asarray(axes @ few)


def _some(array: _Rows, rows: Ints) -> _Rows:
    """Return some rows of an array, without a copy if they are all the same."""
    return cast("_Rows", array[: len(rows)] if array.strides[0] == 0 else array[rows])


_AFAR = _FAR * np.array([[1, 0, 0], [-1 / 2, 3**0.5 / 2, 0], [-1 / 2, -(3**0.5) / 2, 0]])


def _placed(under: Singles, few: Singles, turned: Array, rows: Ints, columns: Ints) -> Array:
    """Return u, v and g of one sample of each robot, (3, n), or of k, (3, k, n); columns: which, (n,) or (k, n)."""
    placed: Array = np.einsum("ijn,...nj->i...n", turned, few[rows, :, columns])
    np.subtract(under[rows, columns], placed[2], out=placed[2])
    return placed


def _plane(under: Singles, few: Singles, turned: Array, three: Ints) -> Array:
    """Return a, b, c of the plane through three samples around the origin with no sample above it, (3, n).

    three: (3, n), the samples to begin with; overwritten with those of the plane
    """
    count, far = under.shape[0], under.shape[1] - 3
    rows = np.arange(count)
    corners = _placed(under, few, turned, rows, three)
    # The contacts of the round before have moved as the robot was turned; those no longer around the origin start anew.
    left = np.flatnonzero(~_surrounds(corners))
    if len(left):
        three[:, left] = np.arange(far, far + 3)[:, None]
        corners[:, :, left] = _placed(under, few, turned[:, :, left], left, three[:, left])
    plane, own = np.empty((3, count)), three
    for _ in range(_EXCHANGES):
        through = _through(corners)
        highest, above = _highest(under, few, turned, through)
        # One of the three themselves is above their plane by rounding alone, a far one by millimetres: it never enters.
        rises = (above - through[2] > _ABOVE) & (own != highest).all(axis=0)
        rising = np.flatnonzero(rises)
        highest = highest[rising]
        # Once most robots are done, their planes are kept, and only the others go on.
        if len(rising) <= _SHARE * len(rows):
            plane[:, rows], three[:, rows] = through, own
            rows, under, few, turned = rows[rising], under[rising], _some(few, rising), turned[:, :, rising]
            corners, own, rising = corners[:, :, rising], own[:, rising], np.arange(len(rising))
            if not len(rows):
                break
        new = _placed(under, few, turned[:, :, rising], rising, highest)
        # The origin is between the new sample and two of the three: exactly one pair, but for rounding.
        leaving = (_least_share(new, corners[:, :, rising]).argmax(axis=0) + 2) % 3
        corners[:, leaving, rising] = new
        own[leaving, rising] = highest
    else:
        plane[:, rows], three[:, rows] = _through(corners), own
    return plane


def _over(under: Singles, few: Singles, turned: Array, plane: Array) -> Singles:
    """Return how high samples are above a plane moved to the origin, (n, m): in the plane itself they are at its c."""
    over = _times(_normals(turned, plane)[:, None], few)[:, 0]
    return np.asarray(np.subtract(under, over, out=over))


def _normals(turned: Array, plane: Array) -> Singles:
    """Return the vectors, in the robots' axes, whose products with samples are heights above planes, (n, 3)."""
    return np.asarray((turned[2] + plane[0] * turned[0] + plane[1] * turned[1]).T, SINGLE)


def _highest(under: Singles, few: Singles, turned: Array, plane: Array) -> tuple[Ints, Singles]:
    """Return the sample that is highest above the plane in each row, and its height above it."""
    highest, above = np.empty(len(under), np.intp), np.empty(len(under), SINGLE)
    for part in row_slices(*under.shape):
        over = _over(under[part], few[part], turned[:, :, part], plane[:, part])
        over.argmax(axis=1, out=highest[part])
        above[part] = over[np.arange(len(over)), highest[part]]
    return highest, above


_NEXT = np.array([1, 2, 0])


def _areas(corners: Array) -> Array:
    """Return twice the areas between the origin and each side of triangles, (3, n), positive for one around it."""
    (u, v), following = corners[:2], corners[:2, _NEXT]
    return np.asarray(u * following[1] - v * following[0])


def _surrounds(corners: Array) -> Mask:
    """Return which triangles hold the origin, (n,): it is on the inner side of all of their sides."""
    return np.asarray((_areas(corners) >= 0).all(axis=0))


def _through(corners: Array) -> Array:
    """Return a, b, c of the plane g = a u + b v + c through three points each, (3, 3, n): (3, n)."""
    (u1, u2), (v1, v2), (g1, g2) = corners[:, 1:] - corners[:, :1]
    area = u1 * v2 - u2 * v1
    area[np.abs(area) < 1e-12] = 1e-12
    a, b = (g1 * v2 - g2 * v1) / area, (u1 * g2 - u2 * g1) / area
    u, v, g = corners[:, 0]
    return np.array([a, b, g - a * u - b * v])


def _least_share(new: Array, corners: Array) -> Array:
    """Return the least barycentric coordinate of the origin in the triangles of a new point and each side, (3, n)."""
    # Negative where the origin is outside of a triangle; a triangle without area is out of the question.
    of_new = _areas(corners)
    before = new[0] * corners[1] - new[1] * corners[0]
    after = -before[_NEXT]
    area = of_new + before + after
    flat = area < 1e-12
    area[flat] = 1.0
    least = np.minimum(np.minimum(of_new, before), after) / area
    least[flat] = -np.inf
    return np.asarray(least)
