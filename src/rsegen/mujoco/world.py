"""A world of MuJoCo with robots that drive: motors, belts, friction along and across, contacts, a record.

    map_model -> MjModel, MjData -> step: wheels' speeds, belts' surfaces, contacts turned -> poses, contacts, record

Wheels turn by motors between them and the chassis, which reach their speed within a few steps, as far as torque and
acceleration allow. A belt has no inertia: its surface moves although its shape does not (`surfacevel`), and its pull on
the ground is all that its motor does. Friction along a belt and across it differ, and MuJoCo's contacts know only
directions of the world; so between finding contacts and solving for forces, those of a belt are turned along it.

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
from rsegen.mujoco.robot_model import Shape
from rsegen.mujoco.settings import STEP
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
        made = map_model(scene, placed, motors, seen=seen)
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
        self._wheels = _WheelMotors(self.model, self.data, made.robots, motors)
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
            self._belts.command(self.model, number, v - aside, v + aside)

    def step(self, steps: int) -> None:
        """Simulate this number of steps, as fast as possible."""
        model, data, shapes = self.model, self.data, self._shapes
        for _ in range(steps):
            self._wheels.before_step(data)
            _step(model, data, shapes)
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


_RAMP = 10.0
"""Change of speed, m/s^2, of a drive of which none is known: as much as friction lets a robot make use of. A motor that
jumped to its speed would throw the robot up by its reaction."""

_STIFF = 100.0
"""Gain of the motors of wheels, in units of the inertia that they turn by a step: with 1, a jackal that turns on the
spot at 0.1 rad/s loses a quarter of it to the load of its skidding wheels."""


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


def _step(model: Any, data: Any, shapes: _Shapes) -> None:
    """Simulate a step: the parts of `mj_step`, bit by bit, with contacts turned and let slide in between."""
    mujoco.mj_kinematics(model, data)
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
    if data.ncon:
        shapes.let_slide(data)
    mujoco.mj_step2(model, data)


_NEXT, _AFTER = [1, 2, 0, 2, 0, 1], [2, 0, 1, 1, 2, 0]
"""Rows of two vectors whose products, three less three, are their cross product."""


class _Shapes:
    """The collision shapes of all robots: which part each is, and the directions of its friction.

    parts: numbers of parts by robot and LINK::COLLISION; names: of shapes by their number in MuJoCo
    turned: whether the friction of any shape has a direction
    """

    def __init__(self, model: Any, shapes: Sequence[Shape]) -> None:
        self.parts: dict[tuple[str, str], int] = {}
        self.names: dict[int, str] = {}
        self._part = np.zeros(model.ngeom, dtype=int)
        self._axis, self._mu = np.tile([0.0, 1.0, 0.0], (model.ngeom, 1)), np.full((2, model.ngeom), np.inf)
        for shape in shapes:
            geom, robot = model.geom(shape.name).id, shape.name.partition("/")[0]
            self.names[geom] = f"{robot}::{shape.part}"
            self._part[geom] = self.parts.setdefault((robot, shape.part), len(self.parts) + 1)
            if shape.axis is not None:
                self._axis[geom] = shape.axis
                self._mu[:, geom] = shape.mu_axis, shape.mu_other
        self.count = len(self.parts) + 1  # 0 is the map
        self.turned = any(shape.axis is not None for shape in shapes)
        self._body: Ints = np.asarray(model.geom_bodyid)
        self._flags = np.zeros(self.count, dtype=np.int64)

    def touching(self, data: Any) -> Ints:
        """Return 1 for each part that has contact, else 0; the array is used again."""
        flags = self._flags
        flags.fill(0)
        flags[self._part[data.contact.geom]] = 1
        return flags

    def let_slide(self, data: Any) -> None:
        """Keep contacts that slide from being pushed apart, which MuJoCo's convex model of friction does.

        The model asks that the residual acceleration of a contact is in the cone dual to that of its force: where it
        slides with a residual r along its plane, the bodies part with mu r, so that wheels and belts that slip hop by
        some tenths of a millimetre, and are in the air for most of the time. Coulomb's law asks that for the residual
        plus mu r along the normal (de Saxce and Feng, 1998). So the reference of the normal is lowered by mu times that
        of the plane: the whole residual of a contact that slides evenly, and nothing for one that holds. What breaks
        it: stiff contacts (`settings.SOLIMP`), which then may hold by pressing harder than they should.
        """
        at, mu, reference = data.contact.efc_address, data.contact.friction, data.efc_aref
        if at.min() < 0:
            at, mu = at[at >= 0], mu[at >= 0]
        reference[at] -= np.hypot(mu[:, 0] * reference[at + 1], mu[:, 1] * reference[at + 2])

    def turn(self, data: Any) -> None:
        """Turn the planes of contacts: their first direction along the axis of the shape, with its own friction.

        Shapes of robots have larger numbers than those of the map. All are turned, which changes nothing for a shape
        whose friction has no direction. Contacts on the side of a belt, along whose normal its axis is, stay as they
        are, with one friction.
        """
        # Vectors are columns, as few contacts are turned 1,000 times a second: what counts is the number of calls.
        contact = data.contact
        geoms, frames, surface, friction = contact.geom, contact.frame, contact.surfacevel, contact.friction
        own = np.maximum(geoms[:, 0], geoms[:, 1])
        columns = frames.T
        turn, axis = data.xmat[self._body[own]].T, self._axis[own].T
        axis = turn[0::3] * axis[0] + turn[1::3] * axis[1] + turn[2::3] * axis[2]
        # n x a is in the plane, at right angles to what of a is in it, and as long.
        normal = columns[_NEXT]
        product = normal * axis[_AFTER]
        second = product[:3] - product[3:]
        length = np.sqrt((second * second).sum(axis=0))
        mu = np.minimum(friction[:, 0], self._mu[:, own])
        beside = length <= _SIDE
        if beside.any():
            second[:, beside], length[beside], mu[:, beside] = columns[6:, beside], 1.0, friction[beside, 0]
        second /= length
        product = normal * second[_AFTER]
        first = product[3:] - product[:3]
        # The velocity of a belt's surface is kept along the two directions.
        moving = columns[3:6] * surface[:, 0] + columns[6:] * surface[:, 1]
        surface[:, 0], surface[:, 1] = (moving * first).sum(axis=0), (moving * second).sum(axis=0)
        columns[3:6], columns[6:], friction[:, :2] = first, second, mu.T


class _WheelMotors:
    """The motors of all wheels: speeds that are wanted, and by how much they may change in a step."""

    def __init__(self, model: Any, data: Any, robots: Sequence[Any], motors: str) -> None:
        owners = [
            (number, side, joint, robot.drive) for number, robot in enumerate(robots) for side, joint, _ in robot.wheels
        ]
        self._owner = np.array([(number, side) for number, side, _, _ in owners], dtype=int).reshape(-1, 2)
        self._dofs = np.array([model.joint(joint).dofadr[0] for _, _, joint, _ in owners], dtype=int)
        self._most = np.array([(drive.acceleration or _RAMP) * STEP / drive.radius for _, _, _, drive in owners])
        self._reacts = motors == "reaction"
        self._wanted, self._now = np.zeros(len(owners)), np.zeros(len(owners))
        self._has_changed = False
        if self._reacts and owners:
            self._motors = np.array([model.actuator(joint).id for _, _, joint, _ in owners], dtype=int)
            # A hundredth of a difference in speed is left after a step, as the torque is implicit in it, and a load
            # slows a wheel by less than a hundredth of what it would in that step without a motor.
            gains = _STIFF * model.dof_M0[self._dofs] / STEP
            model.actuator_gainprm[self._motors, 0], model.actuator_biasprm[self._motors, 2] = gains, -gains

    def command(self, robot: int, left: float, right: float) -> None:
        """Set the speeds of a robot's wheels, rad/s."""
        own = self._owner[:, 0] == robot
        self._wanted[own] = np.where(self._owner[own, 1] == 0, left, right)
        self._has_changed = True

    def before_step(self, data: Any) -> None:
        """Bring speeds nearer to those that are wanted."""
        if self._has_changed:
            self._now += np.clip(self._wanted - self._now, -self._most, self._most)
            self._has_changed = not np.array_equal(self._now, self._wanted)
            if self._reacts:
                data.ctrl[self._motors] = self._now
        if not self._reacts and len(self._dofs):
            data.qvel[self._dofs] = self._now


class _Belts:
    """The belts of all robots."""

    def __init__(self, model: Any, robots: Sequence[Any]) -> None:
        belts = [
            (number, shape, model.geom(shape.name).id)
            for number, robot in enumerate(robots)
            for shape in robot.shapes
            if shape.surface is not None
        ]
        self._owner = np.array([(number, shape.belt) for number, shape, _ in belts], dtype=int).reshape(-1, 2)
        self._geoms = np.array([geom for _, _, geom in belts], dtype=int)
        surfaces = []
        for _, shape, geom in belts:  # in the frame of the shape as it was compiled
            turn = np.zeros(9)
            mujoco.mju_quat2Mat(turn, model.geom_quat[geom])
            back = turn.reshape(3, 3).T
            surfaces.append(np.concatenate([back @ shape.surface[:3], back @ shape.surface[3:]]))
        self._surfaces = np.array(surfaces).reshape(-1, 6)

    def command(self, model: Any, robot: int, left: float, right: float) -> None:
        """Set the speeds of a robot's belts, m/s."""
        own = self._owner[:, 0] == robot
        speeds = np.where(self._owner[own, 1] == 0, left, right)
        model.geom_surfacevel[self._geoms[own]] = self._surfaces[own] * speeds[:, None]
