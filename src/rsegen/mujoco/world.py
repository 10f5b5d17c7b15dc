"""A world of MuJoCo with robots that drive: motors, belts, friction along and across, contacts, a record.

    map_model -> MjModel, MjData -> step: wheels' speeds, belts' surfaces, contacts turned -> poses, contacts, record

Wheels turn by motors between them and the chassis, which reach their speed within a few steps, as far as torque and
acceleration allow. How belts run, and how contacts hold and slide, is in `rsegen.mujoco.contacts`.

Cost: 40 to 50 microseconds a step and robot, of which a third turns contacts of belts; with 50,000 boxes of a map three
times as much. The same world gives the same numbers, bit by bit, in every process. What breaks it: a belt with more
bends than its two ends, and steps in which a robot sinks in (`SINKS`), which end a drive with an error.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import cos, sin
from typing import Any, ClassVar

import mujoco
import numpy as np

from rsegen.errors import SimulatorFailed
from rsegen.field.stepfield import Array
from rsegen.geometry.poses import pose_matrix
from rsegen.mujoco.contacts import Belts, Shapes, slide
from rsegen.mujoco.log import without_log
from rsegen.mujoco.map_model import GROUND, NamedBoxes, map_model
from rsegen.mujoco.robot_model import weights
from rsegen.mujoco.settings import STEP
from rsegen.mujoco.wheel_motors import WheelMotors
from rsegen.robots.drives import Tracks, Wheels
from rsegen.robots.lookup import DrivableRobot
from rsegen.robots.parameters import MOTORS
from rsegen.scene.scene import Scene
from rsegen.simulators.embedded import AS_DRAWN, AsBuilt, EmbeddedWorld, LinkPoses, PlacedRobot
from rsegen.simulators.poses import Contact, Pose, Record, angles_of

SINKS = 0.01
"""Depth, metres, of a contact from which on a drive has failed: after a fall of 0.4 m a robot sinks in by 1 mm."""

STARTS_IN = 0.002
"""Depth, metres, of a contact at the start from which on a robot starts inside a block."""

_PUSHED = 0.01
"""Share of a robot's weight that pushes a part back at least if that part holds the robot."""


class MujocoWorld(EmbeddedWorld):
    """A world with robots at their starts; SimulatorFailed if one starts inside a block, or if the physics fails.

    gains: of the turn rate of each robot (`rsegen.mujoco.turning`), by default 1
    period: seconds between two rows of the record
    seen: with colours and light, for a window
    built: how the map differs from its drawing
    boxes: besides its blocks; a caller that changes them in `model` calls `restart` then
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
        # Friction as built: here for all contacts, and in `Shapes` for the coefficients along and across.
        self.model.geom_friction[:, 0] *= built.friction
        self._drawn: Any = None
        self._scene, self._names = scene.name, [robot.name for robot in placed]
        self._numbers = {robot.name: index for index, robot in enumerate(placed)}
        self.robots, self._period = made.robots, round(min(period, _NEVER) / STEP)
        self._qpos = [int(self.model.joint(name).qposadr[0]) for name in self._names]
        self.gains = gains or [1.0] * len(placed)
        self.wheels = WheelMotors(self.model, made.robots, motors)
        shapes = [shape for robot in made.robots for shape in robot.shapes]
        self.belts = Belts(self.model, made.robots)
        turns = self.belts.turns if motors == MOTORS[1] else None
        self.shapes = Shapes(self.model, shapes, built.friction, turns)
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
        return {name: Pose.of(row) for name, row in self._now().items()}

    def drive(self, name: str, robot: DrivableRobot, v: float, w: float) -> None:
        """Have a robot drive at v, m/s forward, and w, rad/s counterclockwise, from now on."""
        index = self._numbers[name]
        drive = robot.drive
        if self.shapes.are_boxes and isinstance(drive, Tracks):
            self.belts.command(self.shapes, index, *drive.classic_turn(v, w))
            return
        left, right = drive.sides(v, w, self.gains[index])
        if isinstance(drive, Wheels):
            self.wheels.command(index, left / drive.radius, right / drive.radius)
        else:
            self.belts.command(self.shapes, index, left, right)

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
            if shapes.are_boxes:
                shapes.keep_spent(data, contact)
            self._steps += 1
            if is_counted:
                shapes.count(contact)
            if self._steps % self._period == 0:
                self._keep()
                self._check()

    def step_with_contacts(self, steps: int) -> Sequence[Contact]:
        """Simulate this number of steps, and return the contacts before the first; all steps count for `shares`."""
        contacts = list(self._contacts())
        self._step(steps, is_counted=True)
        return contacts

    # Results.

    def link_poses(self) -> LinkPoses:
        """Return the poses of all links now."""
        # A step computes the poses of links at its beginning, so they are late; `data` itself must not change here.
        data = self._drawn = self._drawn or mujoco.MjData(self.model)
        data.qpos[:] = self.data.qpos
        mujoco.mj_kinematics(self.model, data)
        return {
            robot.name: {
                link: pose_matrix(body.xpos, body.xmat.reshape(3, 3))
                for link in robot.links
                for body in [data.body(f"{robot.name}/{link}")]
            }
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
        """Return the part of a robot that is pushed back most, against its heading; None if no part is."""
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
        """Yield notes on the physics of a drive: meshes that touch with their hulls, remarks, and weak motors."""
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
        """Yield the contacts now, one for each pair of parts that touch, at the mean point."""
        geoms, points = self.data.contact.geom, self.data.contact.pos
        pairs: dict[tuple[str, str], list[Array]] = {}
        for (first, second), point in zip(geoms.tolist(), points, strict=True):
            pairs.setdefault((self._part(first), self._part(second)), []).append(point)
        for pair, where in pairs.items():
            x, y, z = np.mean(where, axis=0).tolist()
            yield Contact(collisions=pair, position=(x, y, z))

    def _part(self, geom: int) -> str:
        if name := self.shapes.names.get(geom):
            return name
        return f"{GROUND}::link::collision" if geom == 0 else f"{self._scene}::map::blocks"

    # Failures.

    def _check(self) -> None:
        """Raise a SimulatorFailed if the physics has failed."""
        counted = self.data.warning
        warnings = [mujoco.mju_warningText(kind, counted[kind].lastinfo) for kind in np.flatnonzero(counted.number)]
        if warnings or not np.isfinite(self.data.qpos).all():
            why = f" ({warnings[0].rstrip('. ')})" if warnings else ""
            problem = f"the physics failed after {self._seconds:g} s{why}, so this drive has no result"
            raise SimulatorFailed(f"MuJoCo: {problem}")
        self._refuse_sunk(SINKS, f"after {self._seconds:g} s it sank in, so this drive has no result")

    def _refuse_sunk(self, depth: float, why: str) -> None:
        distances = self.data.contact.dist
        if len(distances) and distances.min() < -depth:
            deepest = int(distances.argmin())
            parts = " and ".join(self._part(geom) for geom in self.data.contact.geom[deepest].tolist())
            raise SimulatorFailed(f"MuJoCo: {parts} are {-1000 * distances[deepest]:.3g} mm inside each other: {why}")


_NEVER = 1e12
"""Seconds after which an infinite period is over."""


def free_joint_state(pose: Pose) -> Array:
    """Return the position and the quaternion, w first, (7,), of a pose, as `qpos` of a free joint has them."""
    turn = np.zeros(4)
    mujoco.mju_euler2Quat(turn, (pose.roll, pose.pitch, pose.yaw), "XYZ")
    return np.array([pose.x, pose.y, pose.z, *turn])


def pose_numbers(state: Sequence[float]) -> list[float]:
    """Return x, y, z, roll, pitch and yaw of the state of a free joint, the inverse of `free_joint_state`."""
    x, y, z, *turn = state
    return [x, y, z, *angles_of(*turn)]


def _make_constraints(model: Any, data: Any, shapes: Shapes) -> None:
    """Do the first half of a step: the same as `mj_step1`, bit by bit, but without the kinematics of the map.

    With its flag for sleep, MuJoCo leaves out bodies that cannot move: their boxes are where they were. Without it the
    kinematics of 760 boxes take 13 microseconds a step, and of a robot 1.5. Nothing else sees the flag, so no robot
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
    # Between these two calls of `mj_step1`: contacts are known, and no constraint is made of them yet.
    if shapes.turned and data.ncon:
        shapes.turn(data)
    mujoco.mj_makeConstraint(model, data)
    mujoco.mj_island(model, data)
    mujoco.mj_transmission(model, data)
    mujoco.mj_projectConstraint(model, data)
    mujoco.mj_fwdVelocity(model, data)


_SLEEP = int(mujoco.mjtEnableBit.mjENBL_SLEEP)
