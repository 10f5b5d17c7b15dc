"""Turn MJCF, the format of MuJoCo, into SDF; its robot then is read, placed and driven as a robot of Gazebo is.

MuJoCo compiles the file (mjcf_compile.py). Bodies without a joint become part of the link of the body that holds them,
as links on fixed joints of URDF do. A body on several joints hangs on the last of them, and on each other one a link
with a thousandth of its mass. Angles count from where the file has the robot. A shape touches if it would touch the
ground of its file, or anything if there is no ground. Of several trees of bodies the one with most motors is the robot;
it moves freely and stands upright as in its file, its front that of its first body. The inertia of a wheel's rotor
(armature) becomes that of the wheel. Wheels are what looks like one, on the ground, and has a motor. Cost: linear,
after MuJoCo's. What breaks it: closed loops (<connect>), tendons but those that motors pull, flexible bodies, shapes of
height fields and of plug-ins; a gravity that is compensated counts, as the motors that hold it are held here.

An actuator gives a force f = gain u + bias_0 + bias_1 l + bias_2 l', of its control u and the length l that it moves,
which is the joint's angle times a gear. Without a spring (bias_1) it so turns a joint with the damping d and the
friction c at most at (gear gain u - c) / (d - bias_2 gear^2), and with a torque of at most m at most at (m - c) / d: a
motor runs until they take all of its torque, a velocity servo up to its control. The speed of a servo that pulls
several joints is unknown. What breaks that: muscles and actuators of other programs, which give neither; tendons that
wrap around shapes.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from functools import cached_property
from math import atan2, degrees, pi
from typing import Any, NamedTuple
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from rsegen.errors import FileError, shown, some_of
from rsegen.field.stepfield import Array
from rsegen.geometry.poses import angles, pose_matrix, rotation
from rsegen.robots.files.controllers import Controls
from rsegen.robots.files.meshes import INLINE
from rsegen.robots.files.mimics import Mimic, put_mimic
from rsegen.robots.files.mjcf_compile import Compiled, compiled, turn_of
from rsegen.robots.files.sdf_elements import (
    LATEST_OF_CLASSIC,
    Mass,
    append_inertial,
    numbers_text,
    pose_text,
    put,
    put_all,
    sum_of_masses,
)
from rsegen.robots.files.sdf_shapes import ModelFrames
from rsegen.robots.files.urdf import Converted
from rsegen.robots.files.wheel_joints import is_wheel

_BETWEEN = 1e-3
"""Share of a body's mass that a link between two of its joints has, as none may have no mass."""

_SEEN_GROUPS = 3
"""Groups of shapes that MuJoCo shows, the first ones: files have in the others what only touches."""

_TURN = np.pi
"""Half of the range, radians, that a joint gets that has a motor and no limits, and is no wheel: it is held."""


_CUBIC = 5
"""Coefficients of the polynomial by which a joint follows another one."""

_MOST_NAMES = 5
"""Names of other bodies in a sentence at most."""

_PARALLEL = 0.99
"""Cosine of the angle between two axles at least, as wheels may have camber."""

_ACROSS = 1e-3
"""Angle, radians, by which axles may be off and count as across."""


class Motor(NamedTuple):
    """The motor of a joint: the speed that it reaches without a load, rad/s, and its most torque, Nm; None: unknown."""

    rate: float | None
    torque: float | None


def of_mujoco(root: Element, where: str, wheels: Collection[str]) -> tuple[Converted, Controls]:
    """Return the robot of a file whose XML is `root` as SDF, and which of its joints have motors.

    FileError if it has none. wheels: joints that the user names
    """
    # Wheels have axes along y. Without any, the robot is read again with its axles turned there, if that yields wheels.
    source = compiled(root, where)
    reader = _Reader(source, where, wheels)
    robot, controls = reader.robot()
    turn = reader.turn_of_axles()
    if controls.rates or not turn:
        return robot, controls
    turned, turned_controls = _Reader(source, where, wheels, turn).robot()
    if not (turned_controls.rates or wheels):
        return robot, controls
    remark = f"turned by {degrees(turn):.4g} degrees about z, as its axles were along another axis than y"
    return turned, turned_controls._replace(remarks=(*turned_controls.remarks, remark))


class _Reader:
    """Reads the tree of bodies that is the robot of a compiled model.

    poses: of bodies in the frame of the robot, (4, 4); heads: the body whose link each body becomes a part of
    """

    def __init__(self, source: Compiled, where: str, wheels: Collection[str], turn: float = 0.0) -> None:
        self._source, self._model, self._where, self._wheels = source, source.model, where, wheels
        self._motors = motors(self._model)
        self._bodies = self._chosen()
        self._root = self._bodies[0]
        self._poses = self._placed(turn)
        self._heads: dict[int, int] = {}
        for body in self._bodies:
            is_head = body == self._root or self._model.body_jntnum[body]
            self._heads[body] = body if is_head else self._heads[int(self._model.body_parentid[body])]
        self._joint_names = {joint: self._joint_name(joint) for joint in range(self._model.njnt)}
        self._sdf = Element("sdf", version=LATEST_OF_CLASSIC)
        self._made = SubElement(self._sdf, "model", name=source.name)

    def robot(self) -> tuple[Converted, Controls]:
        """Return the robot, and which of its joints have motors; what is not as in its file is a remark of these."""
        # First links and joints; which joints are of wheels is found by the shapes and axes of the model made so far.
        model, remarks = self._model, list(self._left_out())
        masses = {head: self._mass(head) for head in dict.fromkeys(self._heads.values())}
        for head, mass in masses.items():
            if not mass.mass:
                raise FileError(f"{self._where}: body {shown(self._link(head))} has no mass; a simulator needs one")
            joints = self._joints_of(head)
            own = mass
            if len(joints) > 1:
                share = 1 - _BETWEEN * (len(joints) - 1)
                own = Mass(mass.mass * share, mass.centre, mass.tensor * share)
            self._add_link(head, own)
            self._add_joints(head, joints, mass)
        rates = self._wheels_with_motors()
        self._limit_held(rates)
        followers = list(self._followers())
        if missing := self._source.missing:
            remarks.append(f"left out, as these visual meshes are not found: {', '.join(missing)}")
        if model.nflex:
            remarks.append("left out its flexible bodies")
        return Converted(self._sdf, (), tuple(followers)), Controls(rates, (), tuple(remarks), "its actuators")

    # Which bodies.

    def _chosen(self) -> list[int]:
        """Return the bodies of the robot, each after its parent."""
        model = self._model
        trees: dict[int, list[int]] = {}
        for body in range(1, model.nbody):
            trees.setdefault(int(model.body_rootid[body]), []).append(body)
        if not trees:
            raise FileError(f"{self._where}: a scene of MuJoCo without a <body>, so without a robot")
        driven = {int(model.jnt_bodyid[joint]) for joint in self._motors}
        self._trees = sorted(trees.values(), key=lambda tree: (-len(driven & {*tree}), -len(tree)))
        return self._trees[0]

    def _left_out(self) -> Iterator[str]:
        """Yield sentences about what of the file is not in the robot."""
        root = self._root
        if others := [self._link(tree[0]) for tree in self._trees[1:]]:
            yield f"left out, as they are other bodies of the scene: {some_of(others, _MOST_NAMES)}"
        if not self._is_free(root):
            held = [self._joint_names[joint] for joint in self._all_joints(root)]
            by = f" on {', '.join(held)}" if held else ""
            yield f"its first body is held by the world{by} in its file, and moves freely here"
        kinds = self._equality_names()
        loops = [name for name in kinds if name not in ("joint", "")]
        if loops:
            yield f"left out the constraints between bodies: {', '.join(f'<{name}>' for name in dict.fromkeys(loops))}"

    def _equality_names(self) -> list[str]:
        """Return the element of each equality constraint, an empty text for one that is switched off."""
        import mujoco

        kinds = zip(self._model.eq_type.tolist(), self._model.eq_active0, strict=True)
        return [mujoco.mjtEq(kind).name.removeprefix("mjEQ_").lower() if on else "" for kind, on in kinds]

    def _placed(self, turn: float) -> dict[int, Array]:
        """Return the poses of bodies as in the file, about the origin of the first body, which gets `turn` as its yaw.

        So it stands upright wherever the file has it.
        """
        model = self._model
        first = pose_matrix((0, 0, 0), turn_of(model.body_quat[self._root]))
        yaw = angles(first[:3, :3])[2]
        poses = {self._root: pose_matrix((0, 0, 0), rotation(0, 0, turn - yaw) @ first[:3, :3])}
        for body in self._bodies[1:]:
            above = poses[int(model.body_parentid[body])]
            poses[body] = above @ pose_matrix(model.body_pos[body], turn_of(model.body_quat[body]))
        return poses

    def turn_of_axles(self) -> float:
        """Return the smallest turn, radians, that brings the axes of endless joints with motors across; 0 for none."""
        joints = [joint for joint in self._motors if self._is_endless(joint) and self._body(joint) in self._poses]
        axes = np.array([self._poses[self._body(joint)][:3, :3] @ self._model.jnt_axis[joint] for joint in joints])
        if len(axes) < 2 or np.abs(axes @ axes[0]).min() < _PARALLEL or np.abs(axes[:, 2]).max() > 1 - _PARALLEL:
            return 0.0
        # An axle has no sign, so the turn is taken between a quarter to the right and one to the left.
        turn = (pi / 2 - atan2(axes[0, 1], axes[0, 0]) + pi / 2) % pi - pi / 2
        return turn if abs(turn) > _ACROSS else 0.0

    def _body(self, joint: int) -> int:
        return int(self._model.jnt_bodyid[joint])

    # Names.

    def _link(self, body: int) -> str:
        name = self._model.body(body).name.replace("::", "_") or f"body_{body}"
        return f"{name}_link" if name in {self._model.joint(joint).name for joint in range(self._model.njnt)} else name

    def _joint_name(self, joint: int) -> str:
        return self._model.joint(joint).name.replace("::", "_") or f"joint_{joint}"

    # Links.

    def _mass(self, head: int) -> Mass:
        """Return the mass of all bodies of a link, in its frame; of a wheel with the inertia of its rotor."""
        model, back = self._model, np.linalg.inv(self._poses[head])
        parts = []
        for body in self._parts(head):
            turn = turn_of(model.body_iquat[body])
            tensor = turn @ np.diag(model.body_inertia[body]) @ turn.T
            parts.append((Mass(float(model.body_mass[body]), model.body_ipos[body], tensor), back @ self._poses[body]))
        mass = sum_of_masses(parts)
        for joint in self._joints_of(head):
            if self._is_endless(joint):
                axis = model.jnt_axis[joint]  # a body has half of it across at least
                rotor = float(model.dof_armature[model.jnt_dofadr[joint]]) * (np.eye(3) + np.outer(axis, axis)) / 2
                mass = mass._replace(tensor=mass.tensor + rotor)
        return mass

    def _parts(self, head: int) -> list[int]:
        return [body for body in self._bodies if self._heads[body] == head]

    def _add_link(self, head: int, mass: Mass) -> None:
        link = SubElement(self._made, "link", name=self._link(head))
        put(link, "pose", pose_text(self._poses[head]))
        append_inertial(link, mass)
        back = np.linalg.inv(self._poses[head])
        for body in self._parts(head):
            first = int(self._model.body_geomadr[body])
            for geom in range(first, first + int(self._model.body_geomnum[body])):
                self._add_shape(link, geom, back @ self._poses[body])

    def _add_shape(self, link: Element, geom: int, place: Array) -> None:
        """Add a shape of a body at a place, (4, 4), in a link: as a collision shape if it touches, and as a visual."""
        model, touches = self._model, geom in self._touching
        name = model.geom(geom).name.replace("::", "_") or f"geom_{geom}"
        geometry, at = self._geometry(geom, name, touches=touches)
        if geometry is None:
            return
        pose = place @ pose_matrix(model.geom_pos[geom], turn_of(model.geom_quat[geom])) @ at
        if touches:
            collision = SubElement(link, "collision", name=name)
            put(collision, "pose", pose_text(pose))
            collision.append(geometry)
            # Without a sliding friction a contact has one direction; the ground has a priority of 0, and three.
            is_smooth = model.geom_condim[geom] == 1 and model.geom_priority[geom] > 0
            friction = 0.0 if is_smooth else float(model.geom_friction[geom, 0])
            paths = ("surface/friction/ode/mu", "surface/friction/ode/mu2")
            put_all(collision, paths, numbers_text([friction]))
        material = int(model.geom_matid[geom])
        colour = model.geom_rgba[geom] if material < 0 else model.mat_rgba[material]
        if model.geom_group[geom] < _SEEN_GROUPS and colour[3]:
            visual = SubElement(link, "visual", name=f"{name}_seen")
            put(visual, "pose", pose_text(pose))
            visual.append(geometry)
            put_all(visual, ("material/ambient", "material/diffuse"), numbers_text(colour))

    @cached_property
    def _touching(self) -> set[int]:
        """The shapes that touch the ground of the file; if it has none, all that may touch anything."""
        model = self._model
        kinds, affinities = model.geom_contype, model.geom_conaffinity
        of_world = np.flatnonzero((model.geom_bodyid == 0) & ((kinds | affinities) != 0))
        grounds = [(int(kinds[geom]), int(affinities[geom])) for geom in of_world] or [(-1, -1)]
        # Two shapes touch if the type of either is in the affinity of the other (bit masks); a <pair> touches anyway.
        met = [(kinds & affinity) | (affinities & kind) for kind, affinity in grounds]
        touching = np.flatnonzero(np.any(met, axis=0)).tolist()
        return {*touching, *model.pair_geom1.tolist(), *model.pair_geom2.tolist()}

    def _geometry(self, geom: int, name: str, *, touches: bool) -> tuple[Element | None, Array]:
        """Return the <geometry> of a shape, and its pose in MuJoCo's shape; None for one that SDF does not have."""
        import mujoco

        kind = mujoco.mjtGeom(int(self._model.geom_type[geom])).name.removeprefix("mjGEOM_").lower()
        if kind == "mesh":
            return self._mesh(int(self._model.geom_dataid[geom]))
        geometry, size = Element("geometry"), self._model.geom_size[geom]
        if kind == "box":  # MuJoCo has halves of sides and of lengths
            put(geometry, "box/size", numbers_text(2 * size))
        elif kind == "ellipsoid":
            put(geometry, "ellipsoid/radii", numbers_text(size))
        elif kind in ("sphere", "cylinder", "capsule"):
            put(geometry, f"{kind}/radius", numbers_text(size[:1]))
            if kind != "sphere":
                put(geometry, f"{kind}/length", numbers_text(2 * size[1:2]))
        elif touches and kind != "plane":
            raise FileError(f"{self._where}: the shape {shown(name)} is of the type {kind}, which a robot cannot have")
        else:
            return None, np.eye(4)
        return geometry, np.eye(4)

    def _mesh(self, mesh: int) -> tuple[Element, Array]:
        uri, at = self._source.meshes[mesh]
        geometry = Element("geometry")
        put(geometry, "mesh/uri", uri)
        if not uri.startswith(INLINE):
            put(geometry, "mesh/scale", numbers_text(self._model.mesh_scale[mesh]))
        return geometry, at

    # Joints.

    def _all_joints(self, body: int) -> list[int]:
        first = int(self._model.body_jntadr[body])
        return list(range(first, first + int(self._model.body_jntnum[body]))) if first >= 0 else []

    def _joints_of(self, head: int) -> list[int]:
        """Return the joints on which a link hangs; none for the first, which moves freely."""
        return [] if head == self._root else self._all_joints(head)

    def _is_free(self, body: int) -> bool:
        return bool(self._kinds(self._all_joints(body)) == ["free"])

    def _kinds(self, joints: Sequence[int]) -> list[str]:
        import mujoco

        names = (mujoco.mjtJoint(int(self._model.jnt_type[joint])).name for joint in joints)
        return [name.removeprefix("mjJNT_").lower() for name in names]

    def _is_endless(self, joint: int) -> bool:
        return self._kinds([joint]) == ["hinge"] and not self._model.jnt_limited[joint]

    def _add_joints(self, head: int, joints: Sequence[int], mass: Mass) -> None:
        """Add the joints on which a link hangs, one on another, with links between them."""
        if not joints:
            return
        parent = self._link(self._heads[int(self._model.body_parentid[head])])
        for joint in joints:
            child = self._link(head)
            if joint != joints[-1]:
                child = f"{child}_on_{self._joint_names[joint]}"
                link = SubElement(self._made, "link", name=child)
                put(link, "pose", pose_text(self._poses[head]))
                append_inertial(link, Mass(mass.mass * _BETWEEN, mass.centre, mass.tensor * _BETWEEN))
            self._add_joint(joint, parent, child)
            parent = child

    def _add_joint(self, joint: int, parent: str, child: str) -> None:
        model = self._model
        (kind,) = self._kinds([joint])
        types = {"hinge": "revolute", "slide": "prismatic", "ball": "ball"}
        made = SubElement(self._made, "joint", name=self._joint_names[joint], type=types[kind])
        put(made, "pose", f"{numbers_text(model.jnt_pos[joint])} 0 0 0")
        put(made, "parent", parent)
        put(made, "child", child)
        if kind == "ball":
            return
        # Ranges and springs count from the angle 0 of MuJoCo, those of SDF from where the file has the robot, qpos0.
        at, dof = int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])
        start = float(model.qpos0[at])
        put(made, "axis/xyz", numbers_text(model.jnt_axis[joint]))
        if model.jnt_limited[joint]:
            for name, end in zip(("lower", "upper"), model.jnt_range[joint], strict=True):
                put(made, f"axis/limit/{name}", numbers_text([end - start]))
        motor = self._motors.get(joint)
        if motor and motor.torque:
            put(made, "axis/limit/effort", numbers_text([motor.torque]))
        for name, value in (
            ("damping", model.dof_damping[dof]),
            ("friction", model.dof_frictionloss[dof]),
            ("spring_stiffness", 0.0 if motor else model.jnt_stiffness[joint]),  # no suspension has a motor
            ("spring_reference", model.qpos_spring[at] - start),
        ):
            if value:
                put(made, f"axis/dynamics/{name}", numbers_text([value]))
        if made.find("axis/dynamics") is not None:
            # MuJoCo damps at the end of a step, and Gazebo Classic at its beginning, which throws light links about.
            put(made, "physics/ode/implicit_spring_damper", "true")

    def _wheels_with_motors(self) -> dict[str, float | None]:
        """Return the joints of wheels that have a motor, with the speeds that these reach, rad/s."""
        frames = ModelFrames(self._made, self._where)
        names = {self._joint_names[joint]: motor.rate for joint, motor in self._motors.items()}
        return {name: rate for name, rate in names.items() if name in frames.joints and is_wheel(name, frames)}

    def _limit_held(self, rates: Mapping[str, float | None]) -> None:
        """Give joints a range that have a motor, no limits and no wheel: what has limits is held in a drive."""
        endless = {self._joint_names[joint] for joint in self._motors if self._is_endless(joint)}
        for joint in self._made.iter("joint"):
            if joint.get("name") in endless - {*rates, *self._wheels}:
                put(joint, "axis/limit/lower", numbers_text([-_TURN]))
                put(joint, "axis/limit/upper", numbers_text([_TURN]))

    def _followers(self) -> Iterator[str]:
        """Have joints follow others (<equality><joint>); yield the names of those that follow by a curve."""
        joints = {joint.get("name"): joint for joint in self._made.iter("joint")}
        for index, name in enumerate(self._equality_names()):
            pair = (int(self._model.eq_obj1id[index]), int(self._model.eq_obj2id[index]))
            if name != "joint" or min(pair) < 0:
                continue
            follower, leader = (self._joint_names[joint] for joint in pair)
            offset, multiplier, *curve = self._model.eq_data[index, :_CUBIC].tolist()
            if follower not in joints or leader not in joints:
                continue
            if any(curve):
                yield follower
            else:
                put_mimic(joints[follower], Mimic(leader, multiplier, offset))


def motors(model: Any) -> dict[int, Motor]:
    """Return the motors of hinges and slides by the numbers of their joints; of several on a joint the strongest."""
    strongest: dict[int, Motor] = {}
    for actuator in range(model.nu):
        for joint, gear, is_alone in _moved(model, actuator):
            motor = _motor(model, actuator, joint, gear, is_alone=is_alone)
            best = strongest.get(joint)
            if best is None or (motor.torque or 0) > (best.torque or 0):
                strongest[joint] = motor
    return strongest


def _moved(model: Any, actuator: int) -> Iterator[tuple[int, float, bool]]:
    """Yield the hinges and slides that an actuator moves, with its gear, and whether it moves no other."""
    import mujoco

    kind, target = mujoco.mjtTrn(int(model.actuator_trntype[actuator])), int(model.actuator_trnid[actuator, 0])
    gear = float(model.actuator_gear[actuator, 0])
    if kind in (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT):
        joints = [(target, gear)]
    elif kind == mujoco.mjtTrn.mjTRN_TENDON:
        first, count = int(model.tendon_adr[target]), int(model.tendon_num[target])
        joints = [
            (int(model.wrap_objid[wrap]), gear * float(model.wrap_prm[wrap]))
            for wrap in range(first, first + count)
            if mujoco.mjtWrap(int(model.wrap_type[wrap])) == mujoco.mjtWrap.mjWRAP_JOINT
        ]
    else:
        joints = []
    turning = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)
    for joint, own in joints:
        if own and mujoco.mjtJoint(int(model.jnt_type[joint])) in turning:
            yield joint, own, len(joints) == 1


def _motor(model: Any, actuator: int, joint: int, gear: float, *, is_alone: bool) -> Motor:
    """Return the motor that an actuator is for a joint, by the force f and the speeds in the module's docstring."""
    import mujoco

    # Of an uneven range, such as -1..2, the larger end counts.
    gear = abs(gear)
    most = float(abs(model.actuator_ctrlrange[actuator]).max()) if model.actuator_ctrllimited[actuator] else None
    kind, bias = (int(kinds[actuator]) for kinds in (model.actuator_gaintype, model.actuator_biastype))
    biases = (mujoco.mjtBias.mjBIAS_NONE, mujoco.mjtBias.mjBIAS_AFFINE)
    is_linear = mujoco.mjtGain(kind) == mujoco.mjtGain.mjGAIN_FIXED and mujoco.mjtBias(bias) in biases
    gain = float(model.actuator_gainprm[actuator, 0])
    _, spring, slope = (float(value) for value in model.actuator_biasprm[actuator, :3])  # bias_0, bias_1, bias_2
    torques = []
    if model.actuator_forcelimited[actuator]:
        torques.append(gear * float(abs(model.actuator_forcerange[actuator]).max()))
    if model.jnt_actfrclimited[joint]:
        torques.append(float(abs(model.jnt_actfrcrange[joint]).max()))
    rate = None
    if most is not None and is_linear:
        if mujoco.mjtDyn(int(model.actuator_dyntype[actuator])) == mujoco.mjtDyn.mjDYN_INTEGRATOR:
            rate = most / gear  # the control is the speed at which the servo's angle goes on
        elif not spring:
            dof = int(model.jnt_dofadr[joint])
            rubs, damping = float(model.dof_frictionloss[dof]), float(model.dof_damping[dof])
            # The two bounds of the module's docstring, by the control and by the torque: the lesser counts.
            torques.append(gear * abs(gain) * most)
            slowed = ((torques[-1], damping - slope * gear**2), (min(torques), damping))
            rates = [(torque - rubs) / slowing for torque, slowing in slowed if slowing > 0]
            rate = min(rates) if rates and min(rates) > 0 else None
    return Motor(rate if is_alone or not slope else None, min(torques, default=None))
