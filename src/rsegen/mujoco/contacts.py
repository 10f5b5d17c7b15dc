"""Contacts that hold: friction along and across, belts that run, sliding, and the differences of Gazebo Classic.

    contacts found -> Shapes.turn: directions, coefficients, speeds of belts -> constraints -> slide -> solution

MuJoCo's contacts know neither belts nor wheels with two coefficients: they have a normal n and one friction in all
directions. So between finding contacts and solving for forces each is turned about its normal, until one direction
is n x a, along which the shape runs, with a as its axis, such as an axle; the other is along the axis.

            a, into the page          A belt has no inertia: its surface moves at its speed along n x a although its
             ,---------------.        shape does not, and its pull on the ground is all that its motor does.
            ( x             x )
             '---------------'        With motors as Gazebo Classic's, a belt turns as its plug-in has it (`BeltTurn`),
                 n ^   --> n x a      and friction is a box, for which an ellipse stands (rsegen.mujoco.friction).

A sliding contact presses as hard as one at rest, by Coulomb's friction in place of MuJoCo's convex one (`slide`).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import inf, isinf, sqrt
from typing import Any, NamedTuple

import mujoco
import numpy as np

from rsegen.field.stepfield import Array
from rsegen.mujoco.friction import corner_ellipse
from rsegen.mujoco.robot_model import RobotModel, Shape, weights
from rsegen.robots.drives import Tracks
from rsegen.robots.links import Vector

SIDE = 0.3
"""Sine of the angle between a contact's normal and an axis from which on the contact is turned: on the side of a belt
the normal is along the axis, and n x a has no direction."""

LEAST_LEFT = 0.01
"""The share of its friction that a belt of Gazebo Classic keeps at least: MuJoCo takes none of 0."""


def _cross(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@dataclass(slots=True)
class BeltTurn:
    """The turn of a robot on belts by Gazebo Classic's SimpleTrackedVehicle, unlike the turn of a real robot.

    The plug-in has each contact pull along the circle about the centre of the turn, at right angles to its arm c:

              belt                     straight: the arm is the axle a, and the contact pulls along n x a, as any belt
           ___________                 in a turn: along n x c, with what the belt has of its speed in that direction,
          [______x____]  ^             and across it with the friction across; so nothing skids, and robots turn as told
               c/   n x c  \
               /                       n x a and n x c are as long as the sine of the angle between n and the arm, and
              o  centre                the friction of the contact is so much less: on the side of a belt it is none.

    Source: the plug-in's code, and drives in Gazebo Classic (tests/real/test_classic_friction.py).

    body: in MuJoCo's model, about which the robot turns; centre: metres from it to the left, inf in a straight drive
    """

    body: int
    centre: float = inf

    def arm(self, point: Sequence[float], places: Array, axis: Vector) -> Vector:
        """Return the arm of a contact at a point, with the places of all bodies and the direction to the left."""
        if isinf(self.centre):
            return axis
        place = places[self.body].tolist()
        x, y, z = (at - middle - self.centre * left for at, middle, left in zip(point, place, axis, strict=True))
        length = sqrt(x * x + y * y + z * z)
        return (x / length, y / length, z / length) if length else axis


def belt_direction(normal: Vector, along: Vector, arm: Vector, speed: float) -> tuple[Vector, float, float]:
    """Return the direction in which a belt of Gazebo Classic pulls, the share of its friction there, and its speed.

    along: n x a, in which it runs
    """
    x, y, z = _cross(normal, arm)
    left = max(sqrt(x * x + y * y + z * z), LEAST_LEFT)
    x, y, z = x / left, y / left, z / left
    return (x, y, z), left, speed * (along[0] * x + along[1] * y + along[2] * z)


class Directions(NamedTuple):
    """Directions of a shape's friction: its body, an axis in the body's frame, coefficients along it and across."""

    body: int
    axis: Vector = (0.0, 1.0, 0.0)
    mu_axis: float = inf
    mu_other: float = inf


class Shapes:
    """The collision shapes of all robots: which part each is, and the directions of its friction.

    parts: numbers of parts by robot and LINK::COLLISION, from 1 on; names: of shapes by their number in MuJoCo
    turned: whether any shape has a direction of friction; are_boxes: whether friction is a box, as with classic motors
    speed: of the surface of each shape, m/s, 0 but for belts

    A robot has some ten contacts, for which Python's numbers take a quarter of the time of numpy's arrays.
    """

    def __init__(
        self, model: Any, shapes: Sequence[Shape], friction: float, turns: Mapping[int, BeltTurn] | None = None
    ) -> None:
        """Take the shapes of all robots.

        friction: by which their coefficients are multiplied; turns: of robots, by the shapes of their belts, if they
        turn as in Gazebo Classic
        """
        self.parts: dict[tuple[str, str], int] = {}
        self.names: dict[int, str] = {}
        self._part = [0] * model.ngeom
        self.directions: dict[int, Directions] = {}
        self._axes: list[tuple[int, Vector]] = []  # bodies, and axes in their frames, all different
        # Of each shape: its row of `_axes`, and its coefficients.
        self._frictions: dict[int, tuple[int, float, float]] = {}
        self.speed = [0.0] * model.ngeom
        for shape in shapes:
            geom, robot = model.geom(shape.name).id, shape.name.partition("/")[0]
            self.names[geom] = f"{robot}::{shape.part}"
            self._part[geom] = self.parts.setdefault((robot, shape.part), len(self.parts) + 1)
            own = Directions(int(model.geom_bodyid[geom]))
            if shape.axis is not None:
                x, y, z = shape.axis.tolist()
                mu_axis, mu_other = friction * shape.mu_axis, friction * shape.mu_other
                own = Directions(own.body, (x, y, z), mu_axis, mu_other)
            elif shape.is_box:
                own = Directions(own.body, (0.0, 0.0, 0.0))
            self.directions[geom] = own
            if (line := (own.body, own.axis)) not in self._axes:
                self._axes.append(line)
            self._frictions[geom] = self._axes.index(line), own.mu_axis, own.mu_other
        self._roots = model.body_rootid.tolist()
        self._touched: Counter[bytes] = Counter()
        self.are_boxes = any(shape.is_box for shape in shapes)
        self.turned = self.are_boxes or any(shape.axis is not None or shape.belt >= 0 for shape in shapes)
        self._turns = turns or {}
        self._boxes: list[tuple[int, float, float]] = []  # of contacts: the shape, and the halves of its box
        self._spent: dict[int, tuple[float, float]] = {}  # what each shape has spent of its box in the step before

    def count(self, contact: Any) -> None:
        """Count a step for each part that has contact."""
        self._touched[contact.geom.tobytes()] += 1

    def shares(self, robot: str) -> dict[str, float]:
        """Return the share of the counted steps in which each part of a robot had contact, the largest first."""
        steps, counts = Counter[int](), self._touched
        for pairs, count in counts.items():
            steps.update(dict.fromkeys({self._part[geom] for geom in np.frombuffer(pairs, dtype=np.int32)}, count))
        own = [(part, steps[index]) for (owner, part), index in self.parts.items() if owner == robot and steps[index]]
        shares = {part: round(count / counts.total(), 3) for part, count in own}
        return dict(sorted(shares.items(), key=lambda share: -share[1]))

    def forget(self) -> None:
        """Forget all counted contacts and spent friction."""
        self._touched.clear()
        self._spent = {}

    def turn(self, data: Any) -> None:
        """Turn the planes of contacts: the first direction along the axis of the shape, with its own coefficients.

        In the second direction, n x a, a belt's surface moves at its speed, whichever of the two shapes it is. All
        contacts are turned, which changes nothing for a shape whose friction has no direction. Contacts on the side of
        a belt, whose normal is along its axis, stay as they are, with one friction and without motion. A box of
        friction is replaced by its ellipse for the slip now.
        """
        contact, known, speed, xmat = data.contact, self._frictions, self.speed, data.xmat
        frames, friction, pairs = contact.frame, contact.friction, contact.geom.tolist()
        axes: dict[int, Vector] = {}  # of bodies, in the frame of the world
        turned: list[float] = []  # of each contact: two directions, two coefficients, a speed
        owners, mus = map(max, pairs), friction[:, 0].tolist()  # a robot's shape has a larger number than the map's
        points = contact.pos.tolist() if self.are_boxes else []
        boxed = self._boxed(data, pairs, points) if self.are_boxes else None
        for at, (own, frame, mu) in enumerate(zip(owners, frames.tolist(), mus, strict=True)):
            line, mu_axis, mu_other = known[own]
            if line not in axes:
                body, (p, q, r) = self._axes[line]
                a, b, c, d, e, f, g, h, i = xmat[body].tolist()
                axes[line] = a * p + b * q + c * r, d * p + e * q + f * r, g * p + h * q + i * r
            nx, ny, nz, _, _, _, *second = frame
            x, y, z = axes[line]
            # n x a is in the plane, at right angles to the projection of a on it, and as long as that.
            x, y, z = ny * z - nz * y, nz * x - nx * z, nx * y - ny * x
            length = sqrt(x * x + y * y + z * z)
            # MuJoCo's mu is already the smaller one of both shapes (friction.py), and bounds the robot's own two.
            mu_axis, mu_other = mu if mu < mu_axis else mu_axis, mu if mu < mu_other else mu_other
            surface = speed[own]
            if own in self._turns:
                arm = self._turns[own].arm(points[at], data.xpos, axes[line])
                (x, y, z), length, surface = belt_direction((nx, ny, nz), (x, y, z), arm, surface)
                mu_axis, mu_other, length = mu_axis * length, mu_other * length, 1.0
            elif length <= SIDE:
                (x, y, z), length, mu_axis, mu_other, surface = second, 1.0, mu, mu, 0.0
            x, y, z = x / length, y / length, z / length
            along = nz * y - ny * z, nx * z - nz * x, ny * x - nx * y
            if boxed:
                mu_axis, mu_other = boxed(at, own, along, (x, y, z), (mu_axis, mu_other), surface)
            turned += (*along, x, y, z, mu_axis, mu_other, surface)
        rows = np.array(turned).reshape(-1, 9)
        frames[:, 3:], friction[:, :2], contact.surfacevel[:, 1] = rows[:, :6], rows[:, 6:8], rows[:, 8]

    def _boxed(
        self, data: Any, pairs: Sequence[Sequence[int]], points: Sequence[Sequence[float]]
    ) -> Callable[..., tuple[float, float]]:
        """Return a function for the ellipse of a contact, and begin the list of boxes anew.

        It takes the number of the contact and its shape, its two directions, the halves of its box, and the speed of
        the surface along the second direction.
        """
        twists, centres = data.cvel.tolist(), data.subtree_com.tolist()
        roots, known, spent = self._roots, self.directions, self._spent
        boxes = self._boxes = []

        def ellipse(
            at: int, own: int, along: Vector, across: Vector, halves: tuple[float, float], surface: float
        ) -> tuple[float, float]:
            boxes.append((own, *halves))
            body = known[own].body
            # The velocity at the contact: a twist (turn rate, velocity) is about the centre of mass of the whole robot.
            p, q, r, u, v, w = twists[body]  # a step before
            (x, y, z), (a, b, c) = points[at], centres[roots[body]]
            x, y, z = x - a, y - b, z - c
            u, v, w = u + q * z - r * y, v + r * x - p * z, w + p * y - q * x
            slip = along[0] * u + along[1] * v + along[2] * w
            slip2 = across[0] * u + across[1] * v + across[2] * w
            # The surface of a belt moves in addition to the second of both shapes, away from the first.
            slip2 = (slip2 if own == pairs[at][1] else -slip2) + surface
            return corner_ellipse(halves, (slip, slip2), spent.get(own, _NOTHING))

        return ellipse

    def keep_spent(self, data: Any, contact: Any) -> None:
        """Keep, after a step, the shares of its box that each shape has spent, the most of its contacts."""
        spent: dict[int, tuple[float, float]] = {}
        if data.ncon:
            forces = data.efc_force.tolist()
            for row, (own, half, half2) in zip(contact.efc_address.tolist(), self._boxes, strict=True):
                if row >= 0 and (normal := forces[row]) > 0:
                    share, share2 = abs(forces[row + 1]) / (half * normal), abs(forces[row + 2]) / (half2 * normal)
                    most, most2 = spent.get(own, _NOTHING)
                    spent[own] = (share if share > most else most), (share2 if share2 > most2 else most2)
        self._spent = spent


_NOTHING = (0.0, 0.0)

_WEDGED = 50.0
"""Force of a contact, in weights of the robot, at which its belts stall for a step.

What is wedged between two faces is pulled in with a force that grows with itself, up to what breaks a block; a motor
stalls long before. A robot that falls from its own height has such a force for some milliseconds.
"""


class Belts:
    """The belts of all robots, which stall while they are wedged.

    belts: robot, side (0 left, 1 right) and shape of each, as numbers; limits: force at which a robot is wedged, N
    turns: of robots as in Gazebo Classic's plug-in, by the shapes of their belts
    """

    def __init__(self, model: Any, robots: Sequence[RobotModel]) -> None:
        self.belts = [
            (index, shape.belt, int(model.geom(shape.name).id))
            for index, robot in enumerate(robots)
            for shape in robot.shapes
            if shape.belt >= 0
        ]
        self._robot = {geom: index for index, _, geom in self.belts}
        self._turns = {
            index: BeltTurn(int(model.body(f"{robot.name}/{robot.drive.body}").id))
            for index, robot in enumerate(robots)
            if isinstance(robot.drive, Tracks)
        }
        self.turns = {geom: self._turns[index] for geom, index in self._robot.items()}
        self.limits = [_WEDGED * weight for weight in weights(model, robots)]
        self._least = min((self.limits[index] for index in self._robot.values()), default=inf)
        self._speeds, self._wedged = [(0.0, 0.0)] * len(robots), set[int]()

    def command(self, shapes: Shapes, robot: int, left: float, right: float, centre: float = inf) -> None:
        """Set the speeds of a robot's belts, m/s, and the centre of its turn, as in `BeltTurn`."""
        self._speeds[robot] = left, right
        if robot in self._turns:
            self._turns[robot].centre = centre
        self._run(shapes, robot)

    def stop(self, shapes: Shapes) -> None:
        """Stop all belts, and take none as wedged."""
        self._wedged = set()
        for robot in range(len(self._speeds)):
            self.command(shapes, robot, 0.0, 0.0)

    def after_step(self, data: Any, shapes: Shapes) -> None:
        """Stall the belts in the next step of robots that were wedged in this one, and run the others again."""
        wedged: set[int] = set()
        # One look at the largest force decides nearly all steps.
        if self.belts and data.nefc and np.maximum.reduce(data.efc_force) > self._least:
            forces = data.efc_force.tolist()
            for at, pair in zip(data.contact.efc_address.tolist(), data.contact.geom.tolist(), strict=True):
                owners = {self._robot[geom] for geom in pair if geom in self._robot}
                wedged |= {owner for owner in owners if at >= 0 and forces[at] > self.limits[owner]}
        if wedged != self._wedged:
            changed, self._wedged = wedged ^ self._wedged, wedged
            for robot in changed:
                self._run(shapes, robot)

    def _run(self, shapes: Shapes, robot: int) -> None:
        """Have the belts of a robot run as commanded, or stand still while it is wedged."""
        speeds = (0.0, 0.0) if robot in self._wedged else self._speeds[robot]
        for owner, side, geom in self.belts:
            if owner == robot:
                shapes.speed[geom] = speeds[side]


def slide(model: Any, data: Any, contact: Any) -> None:
    """Correct the references of contacts, `data.contact`, between the making of constraints and their solution.

    MuJoCo's contacts are the solution of a convex problem. In it mu times the remaining slip is added along the normal,
    and a sliding body is thrown up: a box of coefficient 1 hops by 3 mm at 1 m/s, and a robot that skids rocks from
    side to side and hardly turns. That part is taken off again before contacts are solved, as large as in the step
    before; while a contact slides steadily, each step leaves mu^2 / (1 + mu^2) of the error of its normal force.

    Source: De Saxce and Feng, The bipotential method, 1998; Acary and others, A formulation of the linear discrete
    Coulomb friction problem via convex optimization, 2011. Cost: a product with the Jacobian a step. What breaks it: a
    coefficient far above 1, with which it comes slowly.
    """
    if not data.ncon:
        return
    # `left`: by what the acceleration of the step before misses the reference, in each direction of a contact.
    change = np.empty(data.nefc)
    mujoco.mj_mulJacVec(model, data, change, data.qacc)
    reference = data.efc_aref
    before, left = reference.tolist(), (change - reference).tolist()
    for at, (mu, mu2) in zip(contact.efc_address.tolist(), contact.friction[:, :2].tolist(), strict=True):
        if at >= 0:  # none for one that is near, and does not touch
            reference[at] = before[at] - abs(complex(mu * left[at + 1], mu2 * left[at + 2]))
