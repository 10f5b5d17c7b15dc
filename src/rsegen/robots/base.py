"""The description of a robot: links, joints, a drive, sizes and limits.

A robot is one file of this folder that makes one Robot and registers it; its SDF text, for either Gazebo, and its
commands follow from that value.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import astuple, dataclass, replace
from functools import lru_cache
from typing import ClassVar

import numpy as np

from rsegen.errors import FileError, ParameterError, UnknownName, shown
from rsegen.field.crossing import SIDE
from rsegen.field.stepfield import Array
from rsegen.gazebo.sdf import FOOTER, HEADER, numbers
from rsegen.geometry.poses import pose_matrix, turn_about
from rsegen.params.plugins import Source
from rsegen.params.registry import Contract, Registry
from rsegen.params.sorts import Float, Parameter, parameters
from rsegen.recipe.recipe import Run
from rsegen.robots.drives import BACKENDS, Drive, PublishCommand, Servo, element, pose_publisher, servo_plugins, system
from rsegen.robots.files.simulator_shapes import with_capsules
from rsegen.robots.links import GROUND_FRICTION, ORIGIN, Box, Cylinder, Joint, Lidar, Link, SdfPose, Vector, posed
from rsegen.standing.body import (
    Body,
    CollisionPart,
    Shape,
    body_of_shapes,
    sample_distance,
    sampled_ball,
    sampled_box,
    sampled_cylinder,
)
from rsegen.standing.kinds import RobotOnField


@dataclass(frozen=True, kw_only=True, slots=True)
class Robot(RobotOnField):
    """A robot; the origin of its model is on the ground below its centre, and the first link is its body.

    lift: height of the origin of its model above the ground, metres
    size, clearance: overall length, width and height, and ground clearance of the body, metres
    climbs: the highest single step that it drives up in Gazebo Classic, measured, metres; experiment reports name it
    source: the origin of its figures, and which are ours
    also: other words for it
    """

    lift: ClassVar[float] = 0.0

    kind: str
    title: str
    source: str
    size: Vector
    clearance: float
    climbs: float
    links: tuple[Link, ...]
    joints: tuple[Joint, ...]
    drive: Drive
    servos: tuple[Servo, ...] = ()
    lidar: Lidar | None = None
    also: tuple[str, ...] = ()

    @property
    def speed(self) -> float:
        """The maximum speed forward, m/s."""
        return self.drive.speed

    @property
    def turn(self) -> float:
        """The maximum turn rate, rad/s."""
        return self.drive.turn

    @property
    def plugin(self) -> Source | None:
        """The package or file that it comes from; None for rsegen's own."""
        return ROBOTS.source(self.kind) if self.kind in ROBOTS else None

    @property
    def body(self) -> Body:
        """The robot from below, with its servos at rest."""
        return _body_of(self)

    @property
    def mass(self) -> float:
        """The mass of all its links, kg."""
        return sum(link.mass for link in self.links)

    def model(self, name: str, simulator: str = "classic", at: SdfPose = ORIGIN, *, lidar: bool = False) -> str:
        """Return its <model> for a simulator, with its lidar if wanted; `at`: the pose of its origin."""
        sensors = self.lidar.sdf(simulator) if self.lidar and lidar else ""
        plugins = [self.drive.plugins(_checked_simulator(simulator)), servo_plugins(self.servos, simulator)]
        if simulator != "classic":  # which publishes poses by itself
            frames = element("odom_frame", f"{name}/odom") + element("robot_base_frame", self.links[0].name)
            topic = element("odom_topic", f"/model/{name}/ground_truth")  # the drive publishes /model/NAME/odometry
            odometry = system("OdometryPublisher", simulator, frames + topic + element("dimensions", 3))
            plugins += [odometry, pose_publisher(simulator)]
        return with_capsules(self.assembled(name, sensors, plugins, at), simulator)

    def without_plugins(self, name: str, at: SdfPose = ORIGIN) -> str:
        """Return its <model> without plug-ins, for a simulator that drives it by itself."""
        return self.assembled(name, "", (), at)

    def assembled(self, name: str, sensors: str, plugins: Iterable[str], at: SdfPose = ORIGIN) -> str:
        """Return its <model> with these <sensor>s in its first link, and these plug-ins."""
        name = parameters(Run)["name"].check("name", name)
        inside = (
            f"      <pose>{numbers(at)}</pose>\n{_AWAKE}",
            *(link.sdf("" if index else sensors) for index, link in enumerate(self.links)),
            *(joint.sdf for joint in self.joints),
            *plugins,
        )
        return f'    <model name="{name}">\n' + "".join(inside) + "    </model>\n"

    def file(self, name: str, simulator: str = "classic", *, lidar: bool = False) -> str:
        """Return the text of an SDF file of it."""
        return HEADER + self.model(name, simulator, lidar=lidar) + FOOTER

    def holding(self, angles: Mapping[str, float]) -> Robot:
        """Return the robot whose servos go to these angles, radians, as soon as the world runs."""
        for joint in angles.keys() - {servo.joint for servo in self.servos}:
            raise UnknownName.among("joint", "joint with a motor", joint, (servo.joint for servo in self.servos))
        servos = (replace(servo, rest=angles.get(servo.joint, servo.rest)) for servo in self.servos)
        return replace(self, servos=tuple(servos))

    def command(self, name: str, v: float, w: float, simulator: str = "classic") -> PublishCommand:
        """Return the command for speed v forward, m/s, and turn rate w counterclockwise, rad/s."""
        for parameter, value, most, unit in (("v", v, self.drive.speed, "m/s"), ("w", w, self.drive.turn, "rad/s")):
            if not abs(value) <= most:  # nor is NaN a speed
                limits = f"-{numbers([most])}..{numbers([most])} {unit}"
                raise ParameterError(parameter, f"{shown(value)} is outside {limits}")
        return self.drive.command(name, v, w, _checked_simulator(simulator))

    def servo_command(self, name: str, joint: str, angle: float, simulator: str = "classic") -> PublishCommand:
        """Return the command that turns a joint to an angle, radians."""
        servos = {servo.joint: servo for servo in self.servos}
        if joint not in servos:
            raise UnknownName.among("joint", "joint with a motor", joint, servos)
        return servos[joint].command(name, angle, _checked_simulator(simulator))


@lru_cache(maxsize=16)
def _body_of(robot: Robot) -> Body:
    """Return the body of a robot of links; ParameterError if it has no collision shapes.

    Wheels are what hangs on the joints of its drive, tracks the links that it names.
    """
    distance, poses = sample_distance(robot.size[0]), link_poses(robot)
    children = {joint.name: joint.child for joint in robot.joints}
    driven = robot.drive.links(children.__getitem__)
    links = [(link, poses[link.name]) for link in robot.links]
    centres = [pose[:3, :3] @ np.array(link.centre[:3]) + pose[:3, 3] for link, pose in links]
    return body_of_shapes(
        _shapes(links, driven, distance),
        mass=robot.mass,
        centre=np.average(centres, axis=0, weights=[link.mass for link in robot.links]),
        speed=robot.driving_speed,
        distance=distance,
        where=robot.kind,
    )


def link_poses(robot: Robot) -> dict[str, Array]:
    """Return the pose of each link in the robot's frame, (4, 4), by its name, with the servos at rest."""
    poses = {link.name: posed(link.pose) for link in robot.links}
    joints = {joint.name: joint for joint in robot.joints}
    for servo in robot.servos:
        joint = joints[servo.joint]
        # The child turns about its hinge, and takes along all links that hang on it, as an arm does.
        turn, before = turn_about(joint.axis or (0, 0, 1), servo.rest), poses[joint.child]
        origin = before[:3, 3] + before[:3, :3] @ (joint.anchor - turn @ joint.anchor)
        after = pose_matrix(origin, before[:3, :3] @ turn)
        for name in _carried_by(joint.child, robot.joints):
            poses[name] = after @ np.linalg.inv(before) @ poses[name]
        poses[joint.child] = after
    return poses


def _carried_by(link: str, joints: Iterable[Joint]) -> list[str]:
    """Return the links that hang on a link, on joints of any number between."""
    carried = [link]
    for name in carried:  # which grows meanwhile
        carried += [joint.child for joint in joints if joint.parent == name and joint.child not in carried]
    return carried[1:]


def _shapes(links: Iterable[tuple[Link, Array]], driven: set[str], distance: float) -> Iterator[Shape]:
    """Yield the collision shapes of links at their poses, (4, 4)."""
    for link, pose in links:
        for part in link.parts:
            if part.surface is None:
                continue
            mu, mu2 = (min(mu, GROUND_FRICTION) for mu in (part.surface.mu, part.surface.mu2))
            if isinstance(part.solid, Box):
                solid = sampled_box(part.solid.size, distance)
            elif isinstance(part.solid, Cylinder):
                solid = sampled_cylinder(part.solid.radius, part.solid.length, distance)
            else:
                solid = sampled_ball(part.solid.radius, distance)
            yield (
                CollisionPart(f"{link.name}::{part.name}", link.name in driven, mu, mu2),
                solid,
                pose @ posed(part.pose),
            )


_AWAKE = "      <allow_auto_disable>false</allow_auto_disable>\n"
"""Gazebo Classic would put a robot to sleep that pushes against a wall, and no command wakes its tracks."""


def _checked_simulator(simulator: str) -> str:
    if simulator not in BACKENDS:
        raise UnknownName.among("simulator", "simulator", simulator, BACKENDS)
    return simulator


def _problem(robot: Robot) -> str:
    """Return the first thing that is wrong with a plug-in's robot; an empty text if nothing is."""
    problems = (_wrong_texts, _wrong_links, _wrong_drive, _wrong_numbers, _wrong_shapes, _wrong_model)
    return next((text for find in problems for text in find(robot)), "")


def _wrong_texts(robot: Robot) -> Iterator[str]:
    for name in ("kind", "title", "source"):
        if not isinstance(getattr(robot, name), str) or not getattr(robot, name):
            yield f"has {shown(getattr(robot, name))} as its {name}; expected a text"


def _wrong_links(robot: Robot) -> Iterator[str]:
    """Yield what keeps links from being a tree: each but the first hangs on one joint, and all hang on the first."""
    names = [*(link.name for link in robot.links), *(joint.name for joint in robot.joints)]
    if not robot.links:
        yield "has no links"
    for name, count in Counter(names).items():
        if count > 1:
            yield f"has {count} links or joints named {shown(name)}"
    first = robot.links[0].name
    carried, children = {first, *_carried_by(first, robot.joints)}, Counter(joint.child for joint in robot.joints)
    for link in robot.links:
        if link.name not in carried or children[link.name] != (link.name != first):
            yield f"does not hold its link {shown(link.name)} by one joint, and others, on its first link"


def _wrong_drive(robot: Robot) -> Iterator[str]:
    """Yield the joints of motors, and the links of tracks, that do not exist."""
    joints = {joint.name for joint in robot.joints}
    links = () if robot.drive.joints else (*robot.drive.left, *robot.drive.right)
    moved = {*robot.drive.joints, *(servo.joint for servo in robot.servos)}
    for name in sorted((moved - joints) | (set(links) - {link.name for link in robot.links})):
        yield f"drives {shown(name)}, which it does not have"
    if len(robot.drive.left) != len(robot.drive.right) or not robot.drive.left:
        sides = f"{len(robot.drive.left)} on the left and {len(robot.drive.right)} on the right"
        yield f"drives {sides}; expected as many on either side, and at least one"
    for joint in robot.joints:
        if joint.name in moved and not (joint.axis and any(joint.axis)):
            yield f"drives its joint {shown(joint.name)}, which has no axis"


def _wrong_numbers(robot: Robot) -> Iterator[str]:
    above_0 = [
        *(("size", length) for length in robot.size),
        *((f"mass of {link.name}", link.mass) for link in robot.links),
    ]
    above_0 += [(name, getattr(robot.drive, name)) for name in ("separation", "radius", "speed", "turn")]
    for what, value in above_0:
        if not 0 < value < math.inf:  # nor is NaN a size
            yield f"has {shown(value)} as its {what}; expected a number above 0"
    for what, value in (("clearance", robot.clearance), ("climbs", robot.climbs)):
        if not 0 <= value < math.inf:
            yield f"has {shown(value)} as its {what}; expected a number from 0 on"


def _wrong_shapes(robot: Robot) -> Iterator[str]:
    """Yield lengths of shapes that are not above 0, poses that are not of six numbers, and a size without three."""
    if np.shape(robot.size) != (3,):
        yield f"has {shown(robot.size)} as its size; expected three lengths"
    for link in robot.links:
        solids = (link.solid, *(part.solid for part in link.parts))
        lengths = [length for solid in solids for size in astuple(solid) for length in np.ravel(size).tolist()]
        if not all(0 < length < math.inf for length in lengths):
            yield f"has a shape of {min(lengths)} m in its link {shown(link.name)}; expected a number above 0"
        for pose in (link.pose, link.centre, *(part.pose for part in link.parts)):
            if len(pose) != 6 or not all(map(math.isfinite, pose)):
                yield f"has the pose {shown(pose)} in its link {shown(link.name)}; expected six numbers"


def _wrong_model(robot: Robot) -> Iterator[str]:
    """Yield that its model is not XML, as with a < in a name."""
    from xml.etree.ElementTree import ParseError, fromstring

    for simulator in BACKENDS:
        try:
            fromstring(robot.model("robot", simulator, lidar=robot.lidar is not None))  # noqa: S314  # of code that runs
        except ParseError as error:
            yield f"has a model that is no XML ({error}); use plain names"


ROBOTS: Registry[Robot] = Registry(
    "robot",
    package="rsegen.robots",
    group="rsegen.robots",
    contract=Contract(base=Robot, names=lambda robot: (robot.kind,), check=_problem, is_class=False),
)
"""Every robot by its kind."""


register = ROBOTS.register
"""Make a robot known by its kind, and return it."""


WHEEL = Float(0.001, SIDE.high, unit="m")
"""Radius and separation of wheels and tracks, which no flag gives."""


def refuse_outside(sort: Parameter, value: object, what: str) -> None:
    """Raise a FileError if a value of a file is not what `sort` takes; `what` begins with the file."""
    try:
        sort.check("", value)
    except ParameterError as error:
        raise FileError(f"{what}: {error.problem}; lengths in SDF are metres") from None
