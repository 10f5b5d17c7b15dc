"""A world of MuJoCo with robots that drive: motors, belts, friction along and across, contacts, a record.

    map_model -> MjModel, MjData -> step: wheels' speeds, belts' surfaces, contacts turned -> poses, contacts, record

Wheels turn by motors between them and the chassis, which reach their speed within a few steps, as far as torque and
acceleration allow. A belt has no inertia: its surface moves although its shape does not (`surfacevel` of contacts), and
its pull on the ground is all that its motor does. Friction along a belt and across it differ, and MuJoCo's contacts
know only directions of the world; so between finding contacts and solving for forces, those of a belt are turned.

A contact that slides presses as one that does not, by Coulomb's friction in place of MuJoCo's convex one (`slide`).

Cost: 40 to 50 microseconds a step and robot, of which a third turns contacts of belts; with 50,000 boxes of a map three
times as much. The same world gives the same numbers, bit by bit, in every process. What breaks it: a belt that bends
round more than its ends, and steps in which a robot sinks in (`SINKS`), which end a drive with an error.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from math import asin, atan2, cos, inf, sin, sqrt
from typing import Any, ClassVar, NamedTuple

import mujoco
import numpy as np

from rsegen.errors import SimulatorFailed
from rsegen.field.stepfield import Array
from rsegen.mujoco.friction import corner_ellipse
from rsegen.mujoco.log import without_log
from rsegen.mujoco.map_model import GROUND, NamedBoxes, map_model
from rsegen.mujoco.robot_model import RobotModel, Shape, weights
from rsegen.mujoco.settings import STEP
from rsegen.mujoco.wheel_motors import WheelMotors
from rsegen.robots.drives import Wheels
from rsegen.robots.lookup import DrivableRobot
from rsegen.robots.parameters import MOTORS
from rsegen.scene.scene import Scene
from rsegen.simulators.embedded import AS_DRAWN, AsBuilt, EmbeddedWorld, LinkPoses, PlacedRobot
from rsegen.simulators.poses import Contact, Pose, Record

SINKS = 0.01
"""Depth, metres, of a contact from which on a drive has failed: after a fall of 0.4 m a robot sinks in by 1 mm."""

STARTS_IN = 0.002
"""Depth, metres, of a contact at the start from which on a robot starts inside a block."""

_PUSHED = 0.01
"""Share of a robot's weight with which a part is pushed back at least if it holds the robot."""

SIDE = 0.3
"""Sine of the angle between a contact's normal and an axis from which on the contact is turned: on the side of a belt
there is no along."""


class MujocoWorld(EmbeddedWorld):
    """A world with robots at their starts; SimulatorFailed if one starts inside a block, or if the physics fails.

    gains: of the turn rate of each robot (`rsegen.mujoco.turning`), by default 1
    period: seconds between two rows of the record
    seen: with colours and light, for a window
    built: how the map differs from its drawing
    boxes: next to its blocks, which somebody changes in `model`, and then calls `restart`
    """

    step_seconds: ClassVar[float] = STEP

    def __init__(  # noqa: PLR0913  # as `EmbeddedSimulator.world`, and what a window needs
        self,
        scene: Scene,
        placed: Sequence[PlacedRobot],
        *,
        motors: str = MOTORS[0],
        period: float = 0.05,
        gains: Sequence[float] | None = None,
        seen: bool = False,
        built: AsBuilt = AS_DRAWN,
        boxes: NamedBoxes | None = None,
    ) -> None:
        made = map_model(scene, placed, seen=seen, motors=motors, built=built, boxes=boxes)
        try:
            with without_log():
                self.model: Any = mujoco.MjModel.from_xml_string(made.text)
                self.data: Any = mujoco.MjData(self.model)
        except ValueError as error:
            raise SimulatorFailed(f"MuJoCo does not take the model: {str(error).splitlines()[0]}") from None
        self.model.geom_friction[:, 0] *= built.friction
        self._drawn: Any = None
        self._scene, self._names = scene.name, [robot.name for robot in placed]
        self._numbers = {robot.name: number for number, robot in enumerate(placed)}
        self.robots, self._period = made.robots, round(min(period, _NEVER) / STEP)
        self._qpos = [int(self.model.joint(name).qposadr[0]) for name in self._names]
        self.gains = gains or [1.0] * len(placed)
        self.wheels = WheelMotors(self.model, made.robots, motors)
        shapes = [shape for robot in made.robots for shape in robot.shapes]
        self.shapes = _Shapes(self.model, shapes, built.friction)
        self.belts = _Belts(self.model, made.robots)
        self._begin()

    def restart(self, name: str, start: Pose) -> None:
        """Put a robot at another start, still, its servos at rest: the world and its record begin anew."""
        mujoco.mj_resetData(self.model, self.data)
        at = self._qpos[self._numbers[name]]
        self.data.qpos[at : at + 7] = free_joint_state(start)
        self.wheels.stop()
        self.belts.stop(self.shapes)
        self.shapes.forget()
        self._begin()

    def _begin(self) -> None:
        """Put servos at rest, find contacts, and begin the record."""
        for robot in self.robots:
            for joint, servo in robot.servos:
                self.data.joint(joint).qpos = servo.rest
                self.data.actuator(joint).ctrl = servo.rest
        with without_log():
            mujoco.mj_forward(self.model, self.data)
        self._refuse_sunk(STARTS_IN, "no robot can start there")
        self._rows: Record = []
        self._steps = 0
        self._keep()

    # Driving.

    def poses(self) -> Mapping[str, Pose]:
        """Return the pose of every robot's origin, by its name."""
        return {name: Pose(**dict(zip(_POSE, row, strict=True))) for name, row in self._now().items()}

    def drive(self, name: str, robot: DrivableRobot, v: float, w: float) -> None:
        """Have a robot drive at v, m/s forward, and w, rad/s counterclockwise, from now on."""
        number = self._numbers[name]
        left, right = robot.drive.sides(v, w, self.gains[number])
        if isinstance(robot.drive, Wheels):
            self.wheels.command(number, left / robot.drive.radius, right / robot.drive.radius)
        else:
            self.belts.command(self.shapes, number, left, right)

    def step(self, steps: int) -> None:
        """Simulate this number of steps, as fast as possible."""
        self._step(steps, is_counted=False)

    @without_log()
    def _step(self, steps: int, *, is_counted: bool) -> None:
        model, data, shapes, wheels, belts = self.model, self.data, self.shapes, self.wheels, self.belts
        for _ in range(steps):
            wheels.before_step(data)
            _make_constraints(model, data, shapes)
            if not data.nefc:  # in the air, or MuJoCo's memory is full
                self._check()
            wheels.turn(data)
            contact = data.contact  # made anew each time that MuJoCo is asked for it
            slide(model, data, contact)
            mujoco.mj_step2(model, data)
            wheels.after_step(data)
            belts.after_step(data, shapes)
            self._steps += 1
            if is_counted:
                shapes.count(contact)
            if self._steps % self._period == 0:
                self._keep()
                self._check()

    def step_with_contacts(self, steps: int) -> Sequence[Contact]:
        """Step, and give the contacts before the first step; those of each step count for `shares`."""
        contacts = list(self._contacts())
        self._step(steps, is_counted=True)
        return contacts

    # What it tells.

    def link_poses(self) -> LinkPoses:
        """Return the poses of all links now."""
        # A step computes the poses of links at its beginning; what comes after them is not to be changed.
        data = self._drawn = self._drawn or mujoco.MjData(self.model)
        data.qpos[:] = self.data.qpos
        mujoco.mj_kinematics(self.model, data)
        return {
            robot.name: {link: _matrix(data.body(f"{robot.name}/{link}")) for link in robot.links}
            for robot in self.robots
        }

    def recorded(self) -> Record:
        """Return the poses of all robots, every period, and at the end."""
        if self._rows[-1][0] < self._seconds:
            self._keep()
        return self._rows

    def shares(self) -> Mapping[str, Mapping[str, float]]:
        """Return, for each robot, the share of steps with contacts in which each part (LINK::COLLISION) had one."""
        return {name: self.shapes.shares(name) for name in self._names}

    def held_by(self, name: str) -> str | None:
        """Return the part of a robot that is pushed back most, against its heading; None if none is."""
        yaw, contact = self._now()[name][5], self.data.contact
        back: dict[str, float] = {}
        for at, (frame, pair) in enumerate(zip(contact.frame, contact.geom.tolist(), strict=True)):
            for sign, geom in zip((-1.0, 1.0), pair, strict=True):  # the force is on the second of both
                robot, _, part = self.shapes.names.get(geom, "").partition("::")
                if robot == name:
                    force = np.zeros(6)
                    mujoco.mj_contactForce(self.model, self.data, at, force)
                    ahead = sign * (force[:3] @ frame.reshape(3, 3)[:, :2]) @ (cos(yaw), sin(yaw))
                    back[part] = back.get(part, 0.0) - float(ahead)
        weight = weights(self.model, self.robots)[self._numbers[name]]
        held = [part for part, force in back.items() if force > _PUSHED * weight]
        return max(held, key=back.__getitem__, default=None)

    def notes(self) -> Iterator[str]:
        """Yield what a reader of the drive should know of its physics: that meshes touch with their hulls."""
        for robot in self.robots:
            if count := len(robot.hulls):
                yield f"{robot.name}: {count} of its collision shapes are meshes, which touch with their convex hulls"
        # Robots of one kind have the same remarks.
        yield from dict.fromkeys(f"{robot.kind}: {remark}" for robot in self.robots for remark in robot.remarks)
        yield from self.wheels.notes()

    @property
    def _seconds(self) -> float:
        return round(self._steps * STEP, 6)

    def _now(self) -> dict[str, list[float]]:
        return {
            name: pose_numbers(self.data.qpos[at : at + 7].tolist())
            for name, at in zip(self._names, self._qpos, strict=True)
        }

    def _keep(self) -> None:
        self._rows.append((self._seconds, self._now()))

    def _contacts(self) -> Iterator[Contact]:
        """Yield the contacts now: those of a pair of parts are one, at their mean point."""
        geoms, points = self.data.contact.geom, self.data.contact.pos
        pairs: dict[tuple[str, str], list[Array]] = {}
        for (one, other), point in zip(geoms.tolist(), points, strict=True):
            pairs.setdefault((self._part(one), self._part(other)), []).append(point)
        for pair, where in pairs.items():
            x, y, z = np.mean(where, axis=0).tolist()
            yield Contact(collisions=pair, position=(x, y, z))

    def _part(self, geom: int) -> str:
        if name := self.shapes.names.get(geom):
            return name
        return f"{GROUND}::link::collision" if geom == 0 else f"{self._scene}::map::blocks"

    # What goes wrong.

    def _check(self) -> None:
        """Raise a SimulatorFailed if the physics has failed."""
        found = self.data.warning
        warnings = [mujoco.mju_warningText(kind, found[kind].lastinfo) for kind in np.flatnonzero(found.number)]
        if warnings or not np.isfinite(self.data.qpos).all():
            why = f" ({warnings[0].rstrip('. ')})" if warnings else ""
            problem = f"the physics failed after {self._seconds:g} s{why}, so this drive has no result"
            raise SimulatorFailed(f"MuJoCo: {problem}")
        self._refuse_sunk(SINKS, f"after {self._seconds:g} s it sank in, so this drive has no result")

    def _refuse_sunk(self, depth: float, why: str) -> None:
        found = self.data.contact.dist
        if len(found) and found.min() < -depth:
            number = int(found.argmin())
            parts = " and ".join(self._part(geom) for geom in self.data.contact.geom[number].tolist())
            raise SimulatorFailed(f"MuJoCo: {parts} are {-1000 * found[number]:.3g} mm inside each other: {why}")


def _matrix(body: Any) -> Array:
    """Return the pose of a body, (4, 4)."""
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = body.xmat.reshape(3, 3), body.xpos
    return pose


_NEVER = 1e12
"""Seconds after which an infinite period is over."""

_POSE = ("x", "y", "z", "roll", "pitch", "yaw")


def free_joint_state(pose: Pose) -> Array:
    """Return the position and the quaternion, w first, (7,), of a pose, as `qpos` of a free joint has them."""
    turn = np.zeros(4)
    mujoco.mju_euler2Quat(turn, (pose.roll, pose.pitch, pose.yaw), "XYZ")
    return np.array([pose.x, pose.y, pose.z, *turn])


def pose_numbers(state: Sequence[float]) -> list[float]:
    """Return x, y, z, roll, pitch and yaw of the state of a free joint, the inverse of `free_joint_state`."""
    x, y, z, a, b, c, d = state
    pitch = asin(max(-1.0, min(1.0, 2 * (a * c - d * b))))
    roll = atan2(2 * (a * b + c * d), 1 - 2 * (b * b + c * c))
    return [x, y, z, roll, pitch, atan2(2 * (a * d + b * c), 1 - 2 * (c * c + d * d))]


def _make_constraints(model: Any, data: Any, shapes: _Shapes) -> None:
    """Do the first half of a step: the parts of `mj_step1`, bit by bit, without what it does for the map.

    With its flag for sleep, MuJoCo leaves bodies out that cannot move: their boxes are where they were. Without it the
    kinematics of 760 boxes take 13 microseconds a step, those of a robot 1.5. Nothing else sees the flag, so no robot
    falls asleep.
    """
    flags = model.opt.enableflags
    model.opt.enableflags = flags | _SLEEP
    mujoco.mj_kinematics(model, data)
    model.opt.enableflags = flags
    mujoco.mj_comPos(model, data)
    mujoco.mj_makeM(model, data)
    mujoco.mj_factorM(model, data)
    mujoco.mj_collision(model, data)
    if shapes.turned and data.ncon:
        shapes.turn(data)
    mujoco.mj_makeConstraint(model, data)
    mujoco.mj_island(model, data)
    mujoco.mj_transmission(model, data)
    mujoco.mj_projectConstraint(model, data)
    mujoco.mj_fwdVelocity(model, data)


_SLEEP = int(mujoco.mjtEnableBit.mjENBL_SLEEP)


class _Directions(NamedTuple):
    """Directions of a shape's friction: its body, an axis in the body's frame, coefficients along it and across."""

    body: int
    axis: tuple[float, float, float] = (0.0, 1.0, 0.0)
    mu_axis: float = inf
    mu_other: float = inf


class _Shapes:
    """The collision shapes of all robots: which part each is, and the directions of its friction.

    parts: numbers of parts by robot and LINK::COLLISION, from 1 on; names: of shapes by their number in MuJoCo
    turned: whether the friction of any shape has a direction; are_boxes: whether it is a box, that
    of all shapes of a world or of none; speed: of the surface of each shape, m/s, 0 but for belts

    A robot has some ten contacts. For so few, Python's numbers take a quarter of the time of numpy's arrays.
    """

    def __init__(self, model: Any, shapes: Sequence[Shape], friction: float) -> None:
        """Take the shapes of all robots; friction: by which their coefficients are multiplied."""
        self.parts: dict[tuple[str, str], int] = {}
        self.names: dict[int, str] = {}
        self._part = [0] * model.ngeom
        self.directions: dict[int, _Directions] = {}
        self._axes: list[tuple[int, tuple[float, float, float]]] = []  # bodies, and axes in their frames, all different
        # Of each shape: its row of `_axes`, and its coefficients.
        self._frictions: dict[int, tuple[int, float, float]] = {}
        self.speed = [0.0] * model.ngeom
        for shape in shapes:
            geom, robot = model.geom(shape.name).id, shape.name.partition("/")[0]
            self.names[geom] = f"{robot}::{shape.part}"
            self._part[geom] = self.parts.setdefault((robot, shape.part), len(self.parts) + 1)
            own = _Directions(int(model.geom_bodyid[geom]))
            if shape.axis is not None:
                x, y, z = shape.axis.tolist()
                mu_axis, mu_other = friction * shape.mu_axis, friction * shape.mu_other
                own = _Directions(own.body, (x, y, z), mu_axis, mu_other)
            elif shape.is_box:
                own = _Directions(own.body, (0.0, 0.0, 0.0))
            self.directions[geom] = own
            if (line := (own.body, own.axis)) not in self._axes:
                self._axes.append(line)
            self._frictions[geom] = self._axes.index(line), own.mu_axis, own.mu_other
        self._roots = model.body_rootid.tolist()
        self._touched: Counter[bytes] = Counter()
        self.are_boxes = any(shape.is_box for shape in shapes)
        self.turned = self.are_boxes or any(shape.axis is not None or shape.belt >= 0 for shape in shapes)

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
        """Count anew."""
        self._touched.clear()

    def turn(self, data: Any) -> None:
        """Turn the planes of contacts: their first direction along the axis of the shape, with its own friction.

        Across the axis, as long as n x a, a belt's surface moves at its speed, whichever of both shapes it is. Shapes
        of robots have larger numbers than those of the map. All are turned, which changes nothing for a shape whose
        friction has no direction. Contacts on the side of a belt, along whose normal its axis is, stay as they are,
        with one friction, and without motion. A box of friction is the ellipse that stands for it at the slip now.
        """
        contact, known, speed, xmat = data.contact, self._frictions, self.speed, data.xmat
        frames, friction = contact.frame, contact.friction
        axes: dict[int, tuple[float, float, float]] = {}  # of bodies, in the frame of the world
        found: list[float] = []  # of each contact: two directions, two coefficients, a speed
        owners, mus = map(max, contact.geom.tolist()), friction[:, 0].tolist()
        velocity = self._velocity(data) if self.are_boxes else None
        for at, (own, frame, mu) in enumerate(zip(owners, frames.tolist(), mus, strict=True)):
            number, mu_axis, mu_other = known[own]
            if number not in axes:
                body, (p, q, r) = self._axes[number]
                a, b, c, d, e, f, g, h, i = xmat[body].tolist()
                axes[number] = a * p + b * q + c * r, d * p + e * q + f * r, g * p + h * q + i * r
            nx, ny, nz, _, _, _, *other = frame
            x, y, z = axes[number]
            # n x a is in the plane, at right angles to what of a is in it, and as long.
            x, y, z = ny * z - nz * y, nz * x - nx * z, nx * y - ny * x
            length = sqrt(x * x + y * y + z * z)
            surface = speed[own]
            if length <= SIDE:
                (x, y, z), length, mu_axis, mu_other, surface = other, 1.0, mu, mu, 0.0
            x, y, z = x / length, y / length, z / length
            along = nz * y - ny * z, nx * z - nz * x, ny * x - nx * y
            mu_axis, mu_other = mu if mu < mu_axis else mu_axis, mu if mu < mu_other else mu_other
            if velocity:
                u, v, w = velocity(at, self._axes[number][0])
                slip = along[0] * u + along[1] * v + along[2] * w
                mu_axis, mu_other = corner_ellipse(mu_axis, mu_other, slip, x * u + y * v + z * w + surface)
            found += (*along, x, y, z, mu_axis, mu_other, surface)
        rows = np.array(found).reshape(-1, 9)
        frames[:, 3:], friction[:, :2], contact.surfacevel[:, 1] = rows[:, :6], rows[:, 6:8], rows[:, 8]

    def _velocity(self, data: Any) -> Callable[[int, int], tuple[float, float, float]]:
        """Return a function for the velocity, m/s, at a contact by its number, of a body, as it was a step before."""
        twists, centres, points = data.cvel.tolist(), data.subtree_com.tolist(), data.contact.pos.tolist()

        def at_contact(contact: int, body: int) -> tuple[float, float, float]:
            p, q, r, u, v, w = twists[body]  # about the centre of mass of the whole robot
            (x, y, z), (a, b, c) = points[contact], centres[self._roots[body]]
            x, y, z = x - a, y - b, z - c
            return u + q * z - r * y, v + r * x - p * z, w + p * y - q * x

        return at_contact


_WEDGED = 50.0
"""Force of a contact, in weights of the robot, at which its belts stall for a step.

What is wedged between two faces is pulled in with a force that grows with itself, up to what breaks a block; a motor
stalls long before. A robot that falls from its own height has such a force for some milliseconds.
"""


class _Belts:
    """The belts of all robots, which stall where they are wedged."""

    def __init__(self, model: Any, robots: Sequence[RobotModel]) -> None:
        self.belts = [
            (number, shape.belt, int(model.geom(shape.name).id))
            for number, robot in enumerate(robots)
            for shape in robot.shapes
            if shape.belt >= 0
        ]
        self._robot = {geom: number for number, _, geom in self.belts}
        self.limits = [_WEDGED * weight for weight in weights(model, robots)]
        self._least = min((self.limits[number] for number in self._robot.values()), default=inf)
        self._speeds, self._wedged = [(0.0, 0.0)] * len(robots), set[int]()

    def command(self, shapes: _Shapes, robot: int, left: float, right: float) -> None:
        """Set the speeds of a robot's belts, m/s."""
        self._speeds[robot] = left, right
        self._run(shapes, robot)

    def stop(self, shapes: _Shapes) -> None:
        """Let all belts stand, none of which is wedged."""
        self._wedged = set()
        for robot in range(len(self._speeds)):
            self.command(shapes, robot, 0.0, 0.0)

    def after_step(self, data: Any, shapes: _Shapes) -> None:
        """Let the belts of robots stall, in the next step, that are wedged in this one."""
        wedged: set[int] = set()
        if self.belts and data.nefc and np.maximum.reduce(data.efc_force) > self._least:
            forces = data.efc_force.tolist()
            for at, pair in zip(data.contact.efc_address.tolist(), data.contact.geom.tolist(), strict=True):
                owners = {self._robot[geom] for geom in pair if geom in self._robot}
                wedged |= {number for number in owners if at >= 0 and forces[at] > self.limits[number]}
        if wedged != self._wedged:
            changed, self._wedged = wedged ^ self._wedged, wedged
            for robot in changed:
                self._run(shapes, robot)

    def _run(self, shapes: _Shapes, robot: int) -> None:
        """Have the belts of a robot run as commanded, or stand still while it is wedged."""
        speeds = (0.0, 0.0) if robot in self._wedged else self._speeds[robot]
        for owner, side, geom in self.belts:
            if owner == robot:
                shapes.speed[geom] = speeds[side]


def slide(model: Any, data: Any, contact: Any) -> None:
    """Correct the references of contacts, `data.contact`, between the making of constraints and their solution.

    MuJoCo's contacts are the solution of a convex problem. In it what friction does not stop of a slip adds mu times
    itself to the direction of the normal, and what slides is thrown up: a box of coefficient 1 hops by 3 mm at 1 m/s,
    and a robot that skids rocks from side to side and hardly turns. That share is taken off again before contacts are
    solved, as it was in the step before; while a contact slides steadily its normal force comes within a factor
    mu^2 / (1 + mu^2) a step.

    Source: De Saxce and Feng, The bipotential method, 1998; Acary and others, A formulation of the linear discrete
    Coulomb friction problem via convex optimization, 2011. Cost: a product with the Jacobian a step. What breaks it: a
    coefficient far above 1, with which it comes slowly.
    """
    if not data.ncon:
        return
    # A robot has some ten contacts. For so few, Python's numbers take a quarter of the time of numpy's arrays.
    change = np.empty(data.nefc)
    mujoco.mj_mulJacVec(model, data, change, data.qacc)
    reference = data.efc_aref
    before, left = reference.tolist(), (change - reference).tolist()
    for at, (mu, mu2) in zip(contact.efc_address.tolist(), contact.friction[:, :2].tolist(), strict=True):
        if at >= 0:  # none for one that is near, and does not touch
            reference[at] = before[at] - abs(complex(mu * left[at + 1], mu2 * left[at + 2]))
