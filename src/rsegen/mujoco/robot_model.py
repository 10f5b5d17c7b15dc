"""A robot as a body of MJCF, MuJoCo's format: its links, joints, shapes and motors, from its SDF <model>.

Robots of rsegen and of files come the same way, as text of SDF without plug-ins. The origin of the model is a body that
moves freely; links are attached to it and to each other as the joints say, without a joint if it is fixed. A drive also
needs to know of each shape: the part of the robot, whether it belongs to a belt, and a direction of its own friction
(`Shape`).

A mesh touches with its convex hull. A belt that is a single box or mesh gets round ends, as a real belt has: a box
would push its front face against an edge instead of climbing it. What breaks it: screws and gears as joints, and a link
that hangs on two others; both are refused.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import combinations
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree.ElementTree import Element, SubElement, fromstring

import numpy as np

from rsegen.errors import FileError
from rsegen.field.stepfield import Array
from rsegen.geometry.poses import pose_matrix
from rsegen.mujoco.friction import LEAST, ROBOTS, MapFriction
from rsegen.mujoco.settings import MOTOR_SOLIMP, MOTOR_SOLREF, ROLLING, TORSIONAL
from rsegen.robots.base import Robot
from rsegen.robots.drives import Drive, Servo, Tracks, Wheels
from rsegen.robots.files.meshes import collision_mesh, simplified_to
from rsegen.robots.files.mimics import mimics
from rsegen.robots.files.motors import motor
from rsegen.robots.files.sdf_elements import coefficient
from rsegen.robots.files.sdf_shapes import (
    ROUND,
    ModelFrames,
    file_and_scale,
    floats,
    geometries,
    inertia_tensor,
    radius_and_length,
)
from rsegen.robots.parameters import MOTORS
from rsegen.simulators.embedded import PlacedRobot

_ENDLESS = 1e6
"""Limits of joints and efforts from which on a file means no limit."""

_OF_HULL = 500
"""Cubes along the diagonal of a mesh of many faces; its hull has at most one point in each."""

_THIN = 0.0005
"""Half of a side, metres, that a shape has at least: MuJoCo takes no flat one."""

_SLIPPERY = 0.02
"""Least ratio of the two coefficients of a shape: contacts are solved with its square, and fly apart with 0."""

_AXLE = 0.9
"""Cosine of the angle to the axle from which on a direction of friction is taken for the axle's."""

_JOINTS = {"revolute": "hinge", "continuous": "hinge", "prismatic": "slide", "ball": "ball"}
"""Type of a joint in SDF -> in MJCF; all others but fixed ones are refused."""


class Shape(NamedTuple):
    """A collision shape of a robot, by its name in the model.

    part: LINK::COLLISION; belt: the side of the belt that it belongs to, 0 left or 1 right, -1 if none
    axis: direction in the frame of its link along which its friction is `mu_axis`, and `mu_other` across it; None if
    both are equal on this map, unless it is a belt's
    is_box: whether friction has separate limits along the axis and across it, as in Gazebo Classic; without an axis
    along the axes of the world, as there
    """

    name: str
    part: str
    belt: int = -1
    axis: Array | None = None
    mu_axis: float = 1.0
    mu_other: float = 1.0
    is_box: bool = False


class WheelMotor(NamedTuple):
    """The motor of a wheel, named as its joint.

    side: 0 left or 1 right; torque: the most that it gives, Nm, None if nothing limits it; friction: of its joint, Nm
    """

    side: int
    joint: str
    torque: float | None
    friction: float


@dataclass(frozen=True, kw_only=True, slots=True)
class RobotModel:
    """A robot's parts of MJCF, and what its drive needs of them.

    links: their names, as in its file; bodies: of the world; assets: meshes; hulls: parts that touch with their hulls
    excluded: pairs of bodies that do not touch; equalities: joints that follow others
    remarks: sentences about what is not as in its file
    """

    name: str
    kind: str
    drive: Drive
    links: list[str] = field(default_factory=list)
    bodies: list[Element] = field(default_factory=list)
    assets: list[Element] = field(default_factory=list)
    hulls: list[str] = field(default_factory=list)
    excluded: list[tuple[str, str]] = field(default_factory=list)
    equalities: list[Element] = field(default_factory=list)
    shapes: list[Shape] = field(default_factory=list)
    wheels: list[WheelMotor] = field(default_factory=list)
    servos: list[tuple[str, Servo]] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)


def robot_model(placed: PlacedRobot, friction: MapFriction, motors: str, *, alone: bool) -> RobotModel:
    """Return a robot at its start; alone: no other robot is in the world, so it touches the map only."""
    return _Builder(placed, friction, motors, alone=alone).model


def numbers(values: Sequence[float] | Array) -> str:
    """Return numbers as text of MJCF, to nine digits."""
    return " ".join(f"{float(value):.9g}" for value in values)


def quaternion(turn: Array) -> str:
    """Return a rotation, (3, 3), as text of MJCF: w x y z."""
    import mujoco

    wxyz = np.zeros(4)
    mujoco.mju_mat2Quat(wxyz, np.ascontiguousarray(turn, dtype=float).ravel())
    return numbers(wxyz)


class _Builder:
    """A builder of the model of one robot; it appends all parts to `model`."""

    def __init__(self, placed: PlacedRobot, friction: MapFriction, motors: str, *, alone: bool) -> None:
        at = placed.start
        text = placed.robot.without_plugins(placed.name, (at.x, at.y, at.z, at.roll, at.pitch, at.yaw))
        element = fromstring(text)  # noqa: S314  # ours, or was found to be plain elements
        self._where = placed.robot.kind
        self._frames = ModelFrames(element, self._where)
        self._friction, self._alone, self._is_classic = friction, alone, motors == MOTORS[1]
        self._held = self._holders()
        self.model = RobotModel(name=placed.name, kind=self._where, drive=placed.robot.drive)
        self._links = dict(self._frames.links())
        self._driven = placed.robot.drive.links(self._frames.child)
        self._meshes: dict[str, str] = {}
        self._has_mecanum = False
        self._add_bodies(self._frames.local(element))
        self._add_followers()
        self._add_motors(placed.robot.servos if isinstance(placed.robot, Robot) else ())
        if self._has_mecanum:
            self.model.remarks.append(
                "its mecanum wheels are driven as ordinary ones, and skid where their rollers roll"
            )

    def _holders(self) -> Mapping[str, str]:
        """Return the joint on which each link hangs."""
        held: dict[str, str] = {}
        for name, joint in self._frames.joints.items():
            child, kind = self._frames.child(name), joint.get("type", "")
            if kind not in (*_JOINTS, "fixed"):
                raise FileError(f"{self._where}: joint {name} is of type {kind}, which cannot be driven in MuJoCo")
            if child in held:
                raise FileError(f"{self._where}: link {child} is the child of two joints, {held[child]} and {name}")
            held[child] = name
        return held

    def _add_bodies(self, place: Array) -> None:
        """Add the tree of links on a body that is the model's origin; links that hang on nothing else move freely."""
        hanging = {link for link, joint in self._held.items() if self._frames.parent(joint) in self._links}
        for root in [link for link in self._links if link not in hanging]:
            # Of a model of several bodies each is as free as the first one.
            name = f"{self.model.name}/{root}/free" if self.model.bodies else self.model.name
            base = self._free(name, place)
            self._add_link(base, root, np.eye(4))
        if looping := next((link for link in self._links if link not in self.model.links), None):
            raise FileError(f"{self._where}: the joints above link {looping} form a loop, which MuJoCo does not drive")
        # Robots touch each other by the bit `ROBOTS`, which would let the parts of one robot touch as well.
        if not self._alone:
            names = [str(body.get("name")) for root in self.model.bodies for body in root.iter("body")]
            self.model.excluded.extend(combinations(names, 2))

    def _free(self, name: str, place: Array) -> Element:
        body = Element("body", name=name, pos=numbers(place[:3, 3]), quat=quaternion(place[:3, :3]))
        SubElement(body, "freejoint", name=name)
        self.model.bodies.append(body)
        return body

    def _add_link(self, holder: Element, link: str, above: Array) -> None:
        """Add a link, and all links that hang on it, to the body that holds it; above: that body's pose, (4, 4).

        A link hangs on one other link (`_holders`), so this ends.
        """
        pose = self._frames.transform(link)
        own = np.linalg.inv(above) @ pose
        name = f"{self.model.name}/{link}"
        self.model.links.append(link)
        body = SubElement(holder, "body", name=name, pos=numbers(own[:3, 3]), quat=quaternion(own[:3, :3]))
        if (self._links[link].findtext("gravity") or "").strip() in ("0", "false"):
            body.set("gravcomp", "1")
        if joint := self._held.get(link):
            self._add_joint(body, joint, pose)
        self._add_mass(body, link)
        self._add_shapes(body, link, pose)
        for name in self._frames.joints:
            if self._frames.parent(name) == link:
                self._add_link(body, self._frames.child(name), pose)

    def _add_joint(self, body: Element, name: str, pose: Array) -> None:
        element = self._frames.joints[name]
        kind = element.get("type", "")
        # On the world a joint is left out: the robot moves freely, as every model here.
        if kind == "fixed" or self._frames.parent(name) not in self._links:
            return
        # From the frame of the model to the frame of the link, in which MJCF has anchor and axis.
        back = pose[:3, :3].T
        anchor = back @ (self._frames.joint(name)[:3, 3] - pose[:3, 3])
        values = {"name": f"{self.model.name}/{name}", "type": _JOINTS[kind], "pos": numbers(anchor)}
        if kind != "ball":
            values["axis"] = numbers(back @ self._frames.axis(name))
            low, high = (self._number(element, f"axis/limit/{end}") for end in ("lower", "upper"))
            if low is not None and high is not None and high - low < _ENDLESS:
                values |= {"limited": "true", "range": numbers((low, high))}
        for path, attribute in (
            ("damping", "damping"),
            ("friction", "frictionloss"),
            ("spring_stiffness", "stiffness"),
            ("spring_reference", "springref"),
        ):
            value = self._number(element, f"axis/dynamics/{path}")
            if value:
                values[attribute] = numbers([value if path == "spring_reference" else max(value, 0.0)])
        SubElement(body, "joint", values)

    def _add_followers(self) -> None:
        """Add constraints by which joints follow others, but for joints that motors of the drive turn."""
        for name, mimic in mimics(self._frames).items():
            if name in self.model.drive.joints:
                continue
            joints = {"joint1": f"{self.model.name}/{name}", "joint2": f"{self.model.name}/{mimic.leader}"}
            ratio = numbers((mimic.offset, mimic.multiplier, 0, 0, 0))
            stiff = {"solref": numbers(MOTOR_SOLREF), "solimp": numbers(MOTOR_SOLIMP)}
            self.model.equalities.append(Element("joint", joints | {"polycoef": ratio} | stiff))

    def _number(self, element: Element, path: str) -> float | None:
        """Return a number of a joint; None if it is missing, not a number, or too large to limit anything."""
        try:
            value = float(element.findtext(path) or "inf")
        except ValueError:
            return None
        return value if abs(value) < _ENDLESS else None

    def _add_mass(self, body: Element, link: str) -> None:
        """Add mass and moments of inertia, about the principal axes that MuJoCo wants; 1 kg and 1 kg m^2 by default."""
        inertial, mass, place = self._links[link].find("inertial"), 1.0, np.eye(4)
        if inertial is not None:
            (mass,) = floats(inertial.findtext("mass", "1"), 1, self._where)
            place = self._frames.local(inertial)
        moments, axes = np.linalg.eigh(inertia_tensor(link, self._links[link], self._frames))
        if np.linalg.det(axes) < 0:  # a mirror image, not a rotation
            axes[:, 0] *= -1
        SubElement(
            body,
            "inertial",
            pos=numbers(place[:3, 3]),
            quat=quaternion(place[:3, :3] @ axes),
            mass=numbers([mass]),
            diaginertia=numbers(np.maximum(moments, 1e-9)),
        )

    def _add_shapes(self, body: Element, link: str, pose: Array) -> None:
        own = list(geometries(self._links[link], "collision"))
        side = self._belt_side(link)
        for collision, geometry in own:
            placed = np.linalg.inv(pose) @ self._frames.shape(link, collision)
            part = f"{link}::{collision.get('name', '')}"
            mu, mu2 = (coefficient(collision, name, self._where) for name in ("mu", "mu2"))
            direction = self._direction(collision, pose @ placed)
            solids = list(self._solids(geometry[0], part))
            if side >= 0 and len(own) == 1 and len(solids) == 1 and geometry[0].tag in ("box", "mesh"):
                solids = list(self._rounded(solids[0], pose @ placed))
            for attributes, at in solids:
                shape = _Placed(attributes, placed @ at, pose)
                self._add_shape(body, shape, part, side, (mu, mu2), direction)

    def _direction(self, collision: Element, in_model: Array) -> Array:
        """Return the first direction of friction of a shape, in its frame; zeros for none.

        Gazebo Sim has an attribute for a direction in the frame of another link, which is taken for the robot's.
        """
        along = collision.find("surface/friction/ode/fdir1")
        if along is None or not (along.text or "").strip():
            return np.zeros(3)
        direction = np.array(floats(along.text, 3, self._where))
        is_of_robot = any(name.endswith("expressed_in") for name in along.attrib)
        return np.asarray(in_model[:3, :3].T @ direction) if is_of_robot else direction

    def _belt_side(self, link: str) -> int:
        drive = self.model.drive
        if not isinstance(drive, Tracks):
            return -1
        return 0 if link in drive.left else 1 if link in drive.right else -1

    def _add_shape(
        self,
        body: Element,
        shape: _Placed,
        part: str,
        side: int,
        mus: tuple[float, float],
        direction: Array,
    ) -> None:
        mu, mu2 = mus
        attributes = shape.attributes
        if "vertex" in attributes:
            attributes = {"type": "mesh", "mesh": self._asset(attributes["vertex"])}
            self.model.hulls.append(part)
        back = shape.link[:3, :3].T  # from the model's frame to the link's
        axis: Array | None = None
        mu_axis, mu_other = mu, mu2
        if side >= 0:
            drive = self.model.drive
            assert isinstance(drive, Tracks)  # noqa: S101  # `_belt_side`
            # Across a belt is along its axles, y of the model, however the belt is bent.
            axis, mu_axis, mu_other = back @ (0.0, 1.0, 0.0), drive.mu2, drive.mu
        elif direction.any():
            turned = shape.pose[:3, :3] @ direction
            axis = turned / np.linalg.norm(turned)
            if part.rpartition("::")[0] in self._driven:
                axis, mu_axis, mu_other = self._on_axle(axis, shape.link, (mu, mu2))
        # Equal coefficients need no axis, but contacts of belts are turned for their motion, and boxes for their sides.
        if (
            side < 0
            and not self._is_classic
            and min(mu_axis, self._friction.largest) == min(mu_other, self._friction.largest)
        ):
            axis = None
        strongest = max(mu_axis, mu_other)
        mu_axis, mu_other = (max(mu, _SLIPPERY * strongest, LEAST) for mu in (mu_axis, mu_other))
        for layer in self._friction.layers(strongest):
            name = f"{self.model.name}/{len(self.model.shapes)}"
            others = ROBOTS if layer.priority and not self._alone else 0
            geom = SubElement(
                body,
                "geom",
                attributes,
                name=name,
                pos=numbers(shape.pose[:3, 3]),
                quat=quaternion(shape.pose[:3, :3]),
                friction=numbers((layer.mu, TORSIONAL, ROLLING)),
                priority=str(layer.priority),
                contype=str(layer.touches | others),
                conaffinity=str(others),
            )
            if side >= 0:
                geom.set("surfacevel", "1e-15 0 0")  # MuJoCo reads speeds only of shapes that have one when it compiles
            self.model.shapes.append(Shape(name, part, side, axis, mu_axis, mu_other, self._is_classic))

    def _asset(self, vertices: str) -> str:
        """Return the name of a mesh with these vertices; shapes of one file share it, as its hull takes time.

        MuJoCo moves a mesh to its centre and turns it to its axes, and the geom with it.
        """
        if vertices not in self._meshes:
            self._meshes[vertices] = name = f"{self.model.name}/mesh{len(self._meshes)}"
            self.model.assets.append(Element("mesh", name=name, vertex=vertices, inertia="convex"))
        return self._meshes[vertices]

    def _on_axle(self, axis: Array, link: Array, mus: tuple[float, float]) -> tuple[Array, float, float]:
        """Return the axis of friction of a driven wheel, and the coefficients along it and across it.

        A direction in a wheel turns with it. A direction in the plane of a wheel is meant to be the one in which it
        rolls, so the axle is the axis. A diagonal belongs to the rollers of a mecanum wheel, which are not simulated:
        it is driven as an ordinary wheel.
        """
        mu, mu2 = mus
        axle = link[:3, :3].T @ (0.0, 1.0, 0.0)
        across = abs(float(axis @ axle))
        if across > _AXLE:
            return axis, mu, mu2
        if across < 1 - _AXLE:
            return axle, mu2, mu
        self._has_mecanum = True
        return axle, max(mu, mu2), max(mu, mu2)

    def _solids(self, kind: Element, part: str) -> Iterator[tuple[dict[str, str], Array]]:
        """Yield the shapes of MJCF of a geometry, with their poses in it; a cone is the cylinder around it."""
        where = self._where
        if kind.tag == "box":
            sides = np.maximum(np.array(floats(kind.findtext("size"), 3, where)) / 2, _THIN)
            yield {"type": "box", "size": numbers(sides)}, np.eye(4)
        elif kind.tag == "ellipsoid":
            radii = np.maximum(floats(kind.findtext("radii"), 3, where), _THIN)
            yield {"type": "ellipsoid", "size": numbers(radii)}, np.eye(4)
        elif kind.tag in ROUND:
            radius, length = radius_and_length(kind, where)
            half = 0.0 if kind.tag == "sphere" else max(length / 2, _THIN)
            name = "cylinder" if kind.tag == "cone" else kind.tag
            yield {"type": name, "size": numbers((max(radius, _THIN), half))}, np.eye(4)
        elif kind.tag == "mesh":
            path, scale = file_and_scale(kind, where)
            yield _hull(path, tuple(scale.tolist()), os.path.getmtime(path) if os.path.isfile(path) else 0.0)
        else:
            raise FileError(f"{where}: {part} is a <{kind.tag}>, which cannot be driven in MuJoCo")

    def _rounded(self, solid: tuple[dict[str, str], Array], in_model: Array) -> Iterator[tuple[dict[str, str], Array]]:
        """Yield a belt round two ends in place of a single box or mesh, in the frame of that shape.

        It is as long, wide and high as the box around the shape along the robot's axes.
        """
        attributes, at = solid
        if attributes["type"] == "box":
            half = np.array(attributes["size"].split(), dtype=float)
            corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * half
        else:
            corners = np.array(attributes["vertex"].split(), dtype=float).reshape(-1, 3)
        placed = in_model @ at
        turned = corners @ placed[:3, :3].T
        low, high = turned.min(axis=0), turned.max(axis=0)
        back, (length, width, height) = placed[:3, :3].T, high - low
        radius = min(height, length) / 2

        def in_shape(x: float) -> Array:
            middle = (low + high) / 2
            return at @ pose_matrix(back @ (middle + np.array([x, 0.0, 0.0])), back)

        across = np.array([[1.0, 0, 0], [0, 0, 1.0], [0, -1.0, 0]])  # z of a cylinder along y
        for x in (radius - length / 2, length / 2 - radius):
            yield (
                {"type": "cylinder", "size": numbers((radius, width / 2))},
                in_shape(x) @ pose_matrix((0, 0, 0), across),
            )
        if length > 2 * radius + 2 * _THIN:
            yield {"type": "box", "size": numbers((length / 2 - radius, width / 2, radius))}, in_shape(0.0)

    def _add_motors(self, servos: Sequence[Servo]) -> None:
        drive = self.model.drive
        if isinstance(drive, Wheels):
            for side, joint in (*((0, joint) for joint in drive.left), *((1, joint) for joint in drive.right)):
                element = self._frames.joints[joint]
                friction = self._number(element, "axis/dynamics/friction") or 0.0
                torque = motor(drive, joint, self._frames).torque
                name = f"{self.model.name}/{joint}"
                self.model.wheels.append(WheelMotor(side, name, torque, max(friction, 0.0)))
        self.model.servos.extend((f"{self.model.name}/{servo.joint}", servo) for servo in servos)


@lru_cache(maxsize=64)
def _hull(path: Path, scale: tuple[float, ...], changed: float) -> tuple[dict[str, str], Array]:
    """Return a mesh by the points of its convex hull, or a thin box if it is flat; changed: time of its file."""
    points, corners = simplified_to(collision_mesh(path), _OF_HULL)
    used = np.unique((points * scale)[np.unique(corners)].round(9), axis=0)
    low, high = used.min(axis=0), used.max(axis=0)
    # The least singular value is small if all points are near a plane, at any angle.
    spread = np.linalg.svd(used - used.mean(axis=0), compute_uv=False)
    if len(used) < 4 or spread[-1] < _THIN:  # no hull has a volume
        half = np.maximum((high - low) / 2, _THIN)
        return {"type": "box", "size": numbers(half)}, pose_matrix((low + high) / 2)
    return {"type": "mesh", "vertex": numbers(used.ravel())}, np.eye(4)


class _Placed(NamedTuple):
    """A shape with its pose in its link, and the pose of the link in the model, (4, 4) each."""

    attributes: dict[str, str]
    pose: Array
    link: Array


def servo_elements(model: RobotModel) -> Iterator[Element]:
    """Yield the actuators of a robot's servos."""
    for joint, servo in model.servos:
        yield Element(
            "position",
            name=joint,
            joint=joint,
            kp=numbers([servo.stiffness]),
            kv=numbers([servo.damping]),
            forcerange=numbers((-servo.effort, servo.effort)),
        )


def weights(model: Any, robots: Sequence[RobotModel]) -> list[float]:
    """Return the weight of each robot, N."""
    masses = [sum(float(model.body(body.get("name")).subtreemass[0]) for body in robot.bodies) for robot in robots]
    return [-float(model.opt.gravity[2]) * mass for mass in masses]
