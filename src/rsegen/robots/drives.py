"""Drives of robots: the simulators' own plug-ins, their topics and their commands.

A drive is a value that turns speed v [m/s] and turn rate w [rad/s], counterclockwise, into one message for the plug-in
of a backend, so that neither ROS nor a plug-in of our own is needed. The backends differ in names, in message types,
and in what their plug-ins make of a command; each correction for that is a field of the drive, measured in the
simulator (docs/robots.md). Servos hold other joints, such as flippers and arms, at an angle.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import cos, inf, sin
from typing import TYPE_CHECKING, Any, NamedTuple

from rsegen.gazebo.sdf import numbers

if TYPE_CHECKING:
    from rsegen.field.stepfield import Array

BACKENDS = ("classic", "sim", "fortress")
"""Gazebo Classic 11; Gazebo Sim since Garden; Gazebo Sim up to Fortress, whose names begin with ignition."""


class PublishCommand(NamedTuple):
    """A message, and the shell command that publishes it once, which in Gazebo Sim may be lost: repeat it there."""

    topic: str
    type: str
    text: str
    shell: tuple[str, ...]


def publish_command(topic: str, message: str, text: str, simulator: str) -> PublishCommand:
    """Return a message to a topic by the simulator's own tool; `message` is a type without its package."""
    names = {"classic": ("gazebo", "gz"), "sim": ("gz", "gz"), "fortress": ("ignition", "ign")}
    package, tool = names[simulator]
    kind = f"{package}.msgs.{message}"
    words = ("-p", topic, "-m", text) if simulator == "classic" else ("-t", topic, "-m", kind, "-p", text)
    return PublishCommand(topic, kind, text, (tool, "topic", *words))


def twist_text(v: float, w: float) -> str:
    """Return speeds as all drives but Classic's wheeled ones take them."""
    return f"linear {{ x: {numbers([v])} y: 0 z: 0 }} angular {{ x: 0 y: 0 z: {numbers([w])} }}"


def classic(library: str, name: str, inner: str) -> str:
    """Return a plug-in of Gazebo Classic."""
    return f'      <plugin filename="lib{library}Plugin.so" name="{name}">{inner}</plugin>\n'


class SystemName(NamedTuple):
    """The name of a system's library, without the version, and of its class."""

    library: str
    class_name: str


def prefixes(backend: str) -> SystemName:
    """Return the beginning of the names of all systems; backend: `fortress`, or `sim` for all later versions."""
    return SystemName("gz-sim", "gz::sim") if backend == "sim" else SystemName("ignition-gazebo", "ignition::gazebo")


_ONE_WORD = ("NavSat", "ForceTorque")
"""Systems whose libraries are named without a hyphen inside."""


def system_name(kind: str, backend: str) -> SystemName:
    """Return the name of a system, such as `DiffDrive`; backend: `fortress`, or `sim` for all later versions."""
    library, namespace = prefixes(backend)
    if kind in _ONE_WORD:
        return SystemName(f"{library}-{kind.lower()}-system", f"{namespace}::systems::{kind}")
    words = "".join(f"-{letter.lower()}" if letter.isupper() else letter for letter in kind)
    return SystemName(f"{library}{words}-system", f"{namespace}::systems::{kind}")


def system(kind: str, simulator: str, inner: str = "") -> str:
    """Return a system of Gazebo Sim: `DiffDrive` is gz-sim-diff-drive-system, or ignition-gazebo-... in Fortress."""
    name = system_name(kind, simulator)
    return f'      <plugin filename="{name.library}" name="{name.class_name}">{inner}</plugin>\n'


POSE_RATE = 20
"""Poses of a robot in a simulated second, in Gazebo Sim: a row of a trajectory every 0.05 s, as in Gazebo Classic."""


def pose_publisher(simulator: str) -> str:
    """Return the system of Gazebo Sim that publishes the pose of a model; drives are recorded from it."""
    # It publishes a model's pose only if the poses of nested models are asked for too.
    models = element("publish_nested_model_pose", "true") + element("publish_model_pose", "true")
    publishing = models + element("publish_link_pose", "false") + element("update_frequency", POSE_RATE)
    return system("PosePublisher", simulator, publishing)


def flat_name(name: str) -> str:
    """Return the name that a part of a nested model has in a drive in Gazebo Sim, where the model is flat.

    SDF refuses :: in names of parts, as it means nested models.
    """
    return name.replace("::", "__")


def element(tag: str, value: float | str) -> str:
    """Return <tag>value</tag>."""
    return f"<{tag}>{value if isinstance(value, str) else numbers([value])}</{tag}>"


def elements(tag: str, values: tuple[str, ...]) -> str:
    """Return an element of a tag for every value."""
    return "".join(element(tag, value) for value in values)


@dataclass(frozen=True, kw_only=True, slots=True)
class Drive(ABC):
    """A drive for speed v, m/s, and turn rate w, rad/s.

    left, right: what it drives on either side, hinges of wheels or links of tracks
    separation: of wheels or tracks, from middle to middle, metres   speed, turn: the maximum v and w
    """

    left: tuple[str, ...]
    right: tuple[str, ...]
    separation: float
    radius: float
    speed: float
    turn: float

    @property
    def side_names(self) -> tuple[str, str]:
        """Names of the driven parts on the left and on the right, such as `front_left+rear_left`."""
        return "+".join(self.left), "+".join(self.right)

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints that it turns; tracks turn none."""
        return ()

    def links(self, child: Callable[[str], str]) -> set[str]:
        """Return the links that it drives on; child: the link on a joint."""
        return set(map(child, self.joints)) or {*self.left, *self.right}

    def sides(self, v: Any, w: Any, gain: float = 1.0) -> tuple[Any, Any]:
        """Return the speeds of its left and its right side, m/s, for numbers or arrays; gain: of the turn rate."""
        aside = w * gain * self.separation / 2
        return v - aside, v + aside

    @abstractmethod
    def plugins(self, simulator: str, odometry: str = "") -> str:
        """Return its plug-ins as SDF; odometry: elements with the topics and frames of its odometry, in Gazebo Sim."""

    @abstractmethod
    def classic_command(self, name: str, v: float, w: float) -> PublishCommand:
        """Return the command for Gazebo Classic's plug-in."""

    def command(self, name: str, v: float, w: float, simulator: str) -> PublishCommand:
        """Return the command for speed v and turn rate w, counterclockwise."""
        if simulator == "classic":
            return self.classic_command(name, v, w)
        return publish_command(f"/model/{name}/cmd_vel", "Twist", twist_text(v, w), simulator)


@dataclass(frozen=True, kw_only=True, slots=True)
class Wheels(Drive):
    """Wheels on hinges; radius of a wheel, metres.

    left, right: hinges from front to rear, as many on either side
    slip         how much faster skidding wheels must turn against each other than rolling ones, for the same turn rate
    spread       by how much farther apart than the wheels the hinges' origins are, on the same axles: Classic's plug-in
                 takes the distance between them for the separation, and no turn rate above pi
    acceleration of the wheels' rims in Gazebo Sim, m/s^2, whose drive else changes speed at once, so that light robots
                 tip over; Classic's has the limits of its motors
    torque       the most that the motor of a wheel gives, Nm, as a plug-in has it; None if it says nothing
    """

    slip: float = 1
    spread: float = 1
    acceleration: float | None = None
    torque: float | None = None

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the hinges, the left ones first."""
        return (*self.left, *self.right)

    def plugins(self, simulator: str, odometry: str = "") -> str:
        """Return DiffDrive in both; Classic's knows one pair of wheels, and calls left what is right."""
        if simulator == "classic":
            return "".join(
                classic("DiffDrive", f"drive_{left}", element("left_joint", right) + element("right_joint", left))
                for left, right in zip(self.left, self.right, strict=True)
            )
        inner = elements("left_joint", self.left) + elements("right_joint", self.right)
        inner += element("wheel_separation", self.separation * self.slip) + element("wheel_radius", self.radius)
        inner += _limits("linear", self.speed) + _limits("angular", self.turn)
        if self.acceleration is not None:
            turning = 2 * self.acceleration / self.separation  # the wheels turn against each other
            inner += _limits("linear", self.acceleration, "acceleration") + _limits("angular", turning, "acceleration")
        return system("DiffDrive", simulator, inner + odometry)

    def classic_command(self, name: str, v: float, w: float) -> PublishCommand:
        """Return the command as a Pose: v as x, w as the yaw of an orientation, so |w| < pi."""
        half = w * self.slip / self.spread / 2  # a quaternion has the half of its angle
        turned = f"x: 0 y: 0 z: {numbers([sin(half)])} w: {numbers([cos(half)])}"
        text = f"position {{ x: {numbers([v])} y: 0 z: 0 }} orientation {{ {turned} }}"
        return publish_command(f"~/{name}/vel_cmd", "Pose", text, "classic")


_MOVING = 0.1
"""Speed, m/s, below which Gazebo Classic's SimpleTrackedVehicle takes a turn for one in place."""

_TURNING = 0.1
"""Turn rate, rad/s, below which it takes a turn for a straight drive."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Tracks(Drive):
    """Belts on links; radius of a track's end, metres.

    left, right: links, the main track before its flippers
    mu, mu2: friction along and across a belt
    efficiency: how much of the tracks' difference in speed becomes a turn; the rest is skidding
    in_place: how much more Classic's plug-in must be commanded on the spot than in an arc for the same turn rate
    """

    body: str
    mu: float
    mu2: float
    efficiency: float
    in_place: float = 1

    def plugins(self, simulator: str, odometry: str = "") -> str:
        """Return SimpleTrackedVehicle in Classic; TrackedVehicle, and a TrackController for every belt, in Gazebo Sim.

        Classic's calls left what is right.
        """
        steering = element("tracks_separation", self.separation) + element("steering_efficiency", self.efficiency)
        fastest = 2 * self.speed  # in a turn the outer belt is faster than the robot
        if simulator == "classic":
            sides = (("left", self.right), ("right", self.left))
            links = "".join(element(f"{s}_track", b[0]) + elements(f"{s}_flipper", b[1:]) for s, b in sides)
            most = element("max_linear_speed", fastest) + element("max_angular_speed", self.in_place * self.turn)
            friction = element("track_mu", self.mu) + element("track_mu2", self.mu2)
            inner = element("body", self.body) + links + steering + most + friction
            return classic("SimpleTrackedVehicle", "drive", inner)
        left = "".join(element("left_track", element("link", belt)) for belt in self.left)
        right = "".join(element("right_track", element("link", belt)) for belt in self.right)
        limits = element("linear_velocity", _velocities(self.speed)) + element(
            "angular_velocity", _velocities(self.turn)
        )
        inner = left + right + steering + element("tracks_height", 2 * self.radius) + limits
        return system("TrackedVehicle", simulator, inner + odometry) + "".join(
            system("TrackController", simulator, element("link", belt) + _velocities(fastest))
            for belt in (*self.left, *self.right)
        )

    def belt_commands(self, name: str, v: float, w: float, at: Array, simulator: str) -> Iterator[PublishCommand]:
        """Yield the commands for each belt in Gazebo Sim that TrackedVehicle makes of v and w.

        They are the speed of a belt, and where the centre of the turn is, from which contacts take the direction of
        their friction; without a turn it is nowhere.
        at: the pose of the robot, (4, 4), metres
        """
        # The centre of the turn is v / w to the left, along y of the robot, which may be tilted.
        place, to_left = at[:3, 3].tolist(), at[:3, 1].tolist()
        centre = [where + v / w * along if w else inf for where, along in zip(place, to_left, strict=True)]
        text = "x: {:.12g} y: {:.12g} z: {:.12g}".format(*centre)
        for belts, speed in zip((self.left, self.right), self.sides(v, w, 1 / self.efficiency), strict=True):
            for belt in belts:
                of_belt = f"/model/{name}/link/{flat_name(belt)}/track_cmd"
                yield publish_command(f"{of_belt}_center_of_rotation", "Vector3d", text, simulator)
                yield publish_command(f"{of_belt}_vel", "Double", f"data: {numbers([speed])}", simulator)

    def classic_command(self, name: str, v: float, w: float) -> PublishCommand:
        """Return the command as a Twist."""
        return publish_command(f"~/{name}/cmd_vel_twist", "Twist", twist_text(v, self._classic_rate(v, w)), "classic")

    def classic_turn(self, v: float, w: float) -> tuple[float, float, float]:
        """Return what Classic's plug-in makes of its command.

        They are the speeds of the left and the right belt, m/s, and the metres from the body to the left at which the
        plug-in has the centre of the turn, inf for none: on the far side of where the robot turns.
        """
        rate = self._classic_rate(v, w)
        left, right = self.sides(v, rate, 1 / self.efficiency)
        if abs(rate) < _TURNING:
            return left, right, inf
        return left, right, 0.0 if abs(v) < _MOVING else -v / rate

    def _classic_rate(self, v: float, w: float) -> float:
        return w * self.in_place if abs(v) < _MOVING else w


def _limits(kind: str, most: float, of: str = "velocity") -> str:
    return element(f"max_{kind}_{of}", most) + element(f"min_{kind}_{of}", -most)


def _velocities(most: float) -> str:
    return element("min_velocity", -most) + element("max_velocity", most)


@dataclass(frozen=True, kw_only=True, slots=True)
class Servo:
    """A motor with a spring and a damper: gains in Nm/rad and Nm s/rad; rest: its angle at the start, radians."""

    joint: str
    stiffness: float
    damping: float
    effort: float
    rest: float = 0

    def command(self, name: str, angle: float, simulator: str) -> PublishCommand:
        """Return the command that turns it to an angle, radians.

        Classic 11 listens on a topic of Ignition Transport, which its own `gz joint` knows.
        """
        if simulator != "classic":
            return publish_command(topic(name, self.joint), "Double", f"data: {numbers([angle])}", simulator)
        text = f'name: "{name}::{self.joint}" position {{ target {{ data: {numbers([angle])} }} }}'
        gains = ("--pos-p", numbers([self.stiffness]), "--pos-d", numbers([self.damping]))
        shell = ("gz", "joint", "-m", name, "-j", self.joint, "--pos-t", numbers([angle]), *gains)
        return PublishCommand(f"/{name}/joint_cmd", "ignition.msgs.JointCmd", text, shell)


def topic(name: str, joint: str) -> str:
    """Return the topic of Gazebo Sim's JointPositionController."""
    return f"/model/{name}/joint/{joint}/0/cmd_pos"


def servo_plugins(servos: tuple[Servo, ...], simulator: str) -> str:
    """Return a JointControl for all in Classic, a JointPositionController for each in Gazebo Sim."""
    text = ""
    for servo in servos:
        if simulator == "classic":
            gains = element("pid_gains", numbers([servo.stiffness, 0, servo.damping]))
            inner = element("joint", servo.joint) + element("target", servo.rest) + gains
            text += f'        <controller type="position">{inner}</controller>\n'
        else:
            gains = element("p_gain", servo.stiffness) + element("i_gain", 0) + element("d_gain", servo.damping)
            limits = element("cmd_max", servo.effort) + element("cmd_min", -servo.effort)
            inner = element("joint_name", servo.joint) + gains + limits + element("initial_position", servo.rest)
            text += system("JointPositionController", simulator, inner)
    return classic("JointControl", "servos", f"\n{text}      ") if servos and simulator == "classic" else text
