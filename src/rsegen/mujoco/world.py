"""A world of MuJoCo with robots that drive: motors, belts, friction along and across, contacts, a record.

    map_model -> MjModel, MjData -> step: wheels' speeds, belts' surfaces, contacts turned -> poses, contacts, record

Wheels turn by motors between them and the chassis, which reach their speed within a few steps, as far as torque and
acceleration allow. A belt has no inertia: its surface moves although its shape does not (`surfacevel` of contacts), and
its pull on the ground is all that its motor does. Friction along a belt and across it differ, and MuJoCo's contacts
know only directions of the world; so between finding contacts and solving for forces, those of a belt are turned.

Cost: 50 to 60 microseconds a step and robot, whatever the map's size, of which a third turns contacts of belts. The
same world gives the same numbers, bit by bit, in every process. What breaks it: a belt that bends round more than its
ends, and steps in which a robot sinks in (`SINKS`), which end a drive with an error.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import asin, atan2
from typing import Any, ClassVar

import mujoco
import numpy as np

from rsegen.errors import SimulatorFailed
from rsegen.field.stepfield import Array, Ints
from rsegen.mujoco.map_model import GROUND, map_model
from rsegen.mujoco.robot_model import RobotModel, Shape
from rsegen.mujoco.settings import STEP
from rsegen.mujoco.sliding import slide
from rsegen.mujoco.wheel_motors import WheelMotors
from rsegen.robots.drives import Wheels
from rsegen.robots.lookup import DrivableRobot
from rsegen.scene.scene import Scene
from rsegen.simulators.embedded import MOTORS, EmbeddedWorld, LinkPoses, PlacedRobot
from rsegen.simulators.poses import Contact, Pose
from rsegen.simulators.stepped_world import Record

SINKS = 0.01
"""Depth, metres, of a contact from which on a drive has failed: after a fall of 0.4 m a robot sinks in by 1 mm."""

STARTS_IN = 0.002
"""Depth, metres, of a contact at the start from which on a robot starts inside a block."""

_SIDE = 0.3
"""Sine of the angle between a contact's normal and an axis from which on the contact is turned: on the side of a belt
there is no along."""


class MujocoWorld(EmbeddedWorld):
    """A world with robots at their starts; SimulatorFailed if one starts inside a block, or if the physics fails.

    gains: of the turn rate of each robot (`rsegen.mujoco.turning`), by default 1
    period: seconds between two rows of the record
    seen: with colours and light, for a window
    """

    step_seconds: ClassVar[float] = STEP

    def __init__(
        self,
        scene: Scene,
        placed: Sequence[PlacedRobot],
        *,
        motors: str = MOTORS[0],
        period: float = 0.05,
        gains: Sequence[float] | None = None,
        seen: bool = False,
    ) -> None:
        made = map_model(scene, placed, seen=seen)
        try:
            self.model: Any = mujoco.MjModel.from_xml_string(made.text)
        except ValueError as error:
            raise SimulatorFailed(f"MuJoCo does not take the model: {str(error).splitlines()[0]}") from None
        self.data: Any = mujoco.MjData(self.model)
        self._drawn: Any = None
        self._scene, self._names = scene.name, [robot.name for robot in placed]
        self._robots = {robot.name: number for number, robot in enumerate(placed)}
        self._made, self._period = made.robots, round(min(period, _NEVER) / STEP)
        self._qpos = [int(self.model.joint(name).qposadr[0]) for name in self._names]
        self._gains = gains or [1.0] * len(placed)
        self._wheels = WheelMotors(self.model, made.robots, motors)
        shapes = [shape for robot in made.robots for shape in robot.shapes]
        self._shapes = _Shapes(self.model, shapes)
        self._belts = _Belts(self.model, made.robots)
        for robot in made.robots:
            for joint, servo in robot.servos:
                self.data.joint(joint).qpos = servo.rest
                self.data.actuator(joint).ctrl = servo.rest
        mujoco.mj_forward(self.model, self.data)
        self._refuse_sunk(STARTS_IN, "it starts inside a block")
        self._rows: Record = []
        self._steps, self._touched = 0, np.zeros(self._shapes.count, dtype=np.int64)
        self._keep()

    # Driving.

    def poses(self) -> Mapping[str, Pose]:
        """Return the pose of every robot's origin, by its name."""
        return {name: Pose(**dict(zip(_POSE, row, strict=True))) for name, row in self._now().items()}

    def drive(self, name: str, robot: DrivableRobot, v: float, w: float) -> None:
        """Have a robot drive at v, m/s forward, and w, rad/s counterclockwise, from now on."""
        number = self._robots[name]
        aside = w * self._gains[number] * robot.drive.separation / 2
        if isinstance(robot.drive, Wheels):
            self._wheels.command(number, (v - aside) / robot.drive.radius, (v + aside) / robot.drive.radius)
        else:
            self._belts.command(self._shapes, number, v - aside, v + aside)

    def step(self, steps: int) -> None:
        """Simulate this number of steps, as fast as possible."""
        model, data, shapes, wheels = self.model, self.data, self._shapes, self._wheels
        for _ in range(steps):
            wheels.before_step(data)
            _make_constraints(model, data, shapes)
            wheels.turn(data)
            slide(model, data)
            mujoco.mj_step2(model, data)
            wheels.after_step(data)
            self._steps += 1
            self._touched += shapes.touching(data)
            if self._steps % self._period == 0:
                self._keep()
                self._check()

    def step_with_contacts(self, steps: int) -> Sequence[Contact]:
        """Step, and give the contacts before the first step."""
        contacts = list(self._contacts())
        self.step(steps)
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
            for robot in self._made
        }

    def recorded(self) -> Record:
        """Return the poses of all robots, every period, and at the end."""
        if self._rows[-1][0] < self._seconds:
            self._keep()
        return self._rows

    def shares(self) -> Mapping[str, Mapping[str, float]]:
        """Return, for each robot, the share of all steps in which each of its parts (LINK::COLLISION) had contact."""
        found = {}
        for name in self._names:
            own = [(part, self._touched[index]) for (robot, part), index in self._shapes.parts.items() if robot == name]
            shares = {part: round(float(count) / max(self._steps, 1), 3) for part, count in own if count}
            found[name] = dict(sorted(shares.items(), key=lambda share: -share[1]))
        return found

    def notes(self) -> Iterator[str]:
        """Yield what a reader of the drive should know of its physics: that meshes touch with their hulls."""
        for robot in self._made:
            if robot.assets:
                count = len(robot.assets)
                yield f"{robot.name}: {count} of its collision shapes are meshes, which touch with their convex hulls"
            yield from (f"{robot.name}: {remark}" for remark in robot.remarks)
        yield from self._wheels.notes()

    @property
    def _seconds(self) -> float:
        return round(self._steps * STEP, 6)

    def _now(self) -> dict[str, list[float]]:
        return {
            name: _pose(self.data.qpos[at : at + 7].tolist()) for name, at in zip(self._names, self._qpos, strict=True)
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
        if name := self._shapes.names.get(geom):
            return name
        return f"{GROUND}::link::collision" if geom == 0 else f"{self._scene}::map::blocks"

    # What goes wrong.

    def _check(self) -> None:
        """Raise a SimulatorFailed if the physics has failed."""
        if not np.isfinite(self.data.qpos).all() or any(warning.number for warning in self.data.warning):
            raise SimulatorFailed(f"MuJoCo: the physics failed after {self._seconds:g} s, so this drive has no result")
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


def _pose(state: Sequence[float]) -> list[float]:
    """Return x, y, z, roll, pitch and yaw of a position and a quaternion."""
    x, y, z, a, b, c, d = state
    pitch = asin(max(-1.0, min(1.0, 2 * (a * c - d * b))))
    roll = atan2(2 * (a * b + c * d), 1 - 2 * (b * b + c * c))
    return [x, y, z, roll, pitch, atan2(2 * (a * d + b * c), 1 - 2 * (c * c + d * d))]


def _make_constraints(model: Any, data: Any, shapes: _Shapes) -> None:
    """Do the first half of a step: `mj_step1`, or its parts, bit by bit, with contacts turned in between."""
    if shapes.turned:
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_makeM(model, data)
        mujoco.mj_factorM(model, data)
        mujoco.mj_collision(model, data)
        if data.ncon:
            shapes.turn(data)
        mujoco.mj_makeConstraint(model, data)
        mujoco.mj_island(model, data)
        mujoco.mj_transmission(model, data)
        mujoco.mj_projectConstraint(model, data)
        mujoco.mj_fwdVelocity(model, data)
    else:
        mujoco.mj_step1(model, data)


_NEXT, _AFTER = [1, 2, 0, 2, 0, 1], [2, 0, 1, 1, 2, 0]
"""Rows of two vectors whose products, three less three, are their cross product."""


class _Shapes:
    """The collision shapes of all robots: which part each is, and the directions of its friction.

    parts: numbers of parts by robot and LINK::COLLISION; names: of shapes by their number in MuJoCo
    turned: whether the friction of any shape has a direction; speed: of the surface of each shape, m/s, 0 but for belts
    """

    def __init__(self, model: Any, shapes: Sequence[Shape]) -> None:
        self.parts: dict[tuple[str, str], int] = {}
        self.names: dict[int, str] = {}
        self._part = np.zeros(model.ngeom, dtype=int)
        self._axis, self._mu = np.tile([0.0, 1.0, 0.0], (model.nbody, 1, 1)), np.full((2, model.ngeom), np.inf)
        self.speed = np.zeros(model.ngeom)
        for shape in shapes:
            geom, robot = model.geom(shape.name).id, shape.name.partition("/")[0]
            self.names[geom] = f"{robot}::{shape.part}"
            self._part[geom] = self.parts.setdefault((robot, shape.part), len(self.parts) + 1)
            if shape.axis is not None:
                self._axis[model.geom_bodyid[geom]] = shape.axis
                self._mu[:, geom] = shape.mu_axis, shape.mu_other
        self.count = len(self.parts) + 1  # 0 is the map
        self.turned = any(shape.axis is not None or shape.belt >= 0 for shape in shapes)
        self._body: Ints = np.asarray(model.geom_bodyid)
        self._flags = np.zeros(self.count, dtype=np.int64)

    def touching(self, data: Any) -> Ints:
        """Return 1 for each part that has contact, else 0; the array is used again."""
        flags = self._flags
        flags.fill(0)
        flags[self._part[data.contact.geom]] = 1
        return flags

    def turn(self, data: Any) -> None:
        """Turn the planes of contacts: their first direction along the axis of the shape, with its own friction.

        Across the axis, as long as n x a, a belt's surface moves at its speed, whichever of both shapes it is. Shapes
        of robots have larger numbers than those of the map. All are turned, which changes nothing for a shape whose
        friction has no direction. Contacts on the side of a belt, along whose normal its axis is, stay as they are,
        with one friction, and without motion.
        """
        # Vectors are columns, as few contacts are turned 1,000 times a second: what counts is the number of calls.
        contact = data.contact
        geoms, columns, friction = contact.geom, contact.frame.T, contact.friction
        own = np.maximum(geoms[:, 0], geoms[:, 1])
        axes = np.add.reduce(data.xmat.reshape(-1, 3, 3) * self._axis, axis=2)
        # n x a is in the plane, at right angles to what of a is in it, and as long.
        normal = columns[_NEXT]
        product = normal * axes[self._body[own]].T[_AFTER]
        second = product[:3] - product[3:]
        length = np.sqrt(np.add.reduce(second * second))
        mu, surface = np.minimum(friction[:, 0], self._mu[:, own]), self.speed[own]
        if np.minimum.reduce(length) <= _SIDE:
            beside = length <= _SIDE
            second[:, beside], length[beside] = columns[6:, beside], 1.0
            mu[:, beside], surface[beside] = friction[beside, 0], 0.0
        second /= length
        product = normal * second[_AFTER]
        columns[3:6], columns[6:] = product[3:] - product[:3], second
        contact.surfacevel[:, 1], friction[:, :2] = surface, mu.T


class _Belts:
    """The belts of all robots."""

    def __init__(self, model: Any, robots: Sequence[RobotModel]) -> None:
        belts = [
            (number, shape.belt, model.geom(shape.name).id)
            for number, robot in enumerate(robots)
            for shape in robot.shapes
            if shape.belt >= 0
        ]
        self._owner, self._side, self._geoms = np.array(belts, dtype=int).reshape(-1, 3).T

    def command(self, shapes: _Shapes, robot: int, left: float, right: float) -> None:
        """Set the speeds of a robot's belts, m/s."""
        own = self._owner == robot
        shapes.speed[self._geoms[own]] = np.where(self._side[own] == 0, left, right)
