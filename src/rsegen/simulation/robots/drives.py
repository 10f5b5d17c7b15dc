"""Drives of robots: the simulators' own plug-ins, their topics and their commands."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

from rsegen.simulation.robots.commands import Command, pose_text, publish_command, twist_text
from rsegen.simulation.robots.plugins import classic, element, elements, system


@dataclass(frozen=True, kw_only=True, slots=True)
class Drive(ABC):
    """What turns v, m/s, and w, rad/s, into motion; separation of wheels or tracks from middle to middle, metres."""

    separation: float
    radius: float
    speed: float
    turn: float

    @abstractmethod
    def plugins(self, simulator: str) -> str:
        """Its plug-ins as SDF."""

    @abstractmethod
    def classic_command(self, name: str, v: float, w: float) -> Command:
        """The command for Gazebo Classic's plug-in."""

    def command(self, name: str, v: float, w: float, simulator: str) -> Command:
        """The command for speed v and turn rate w, counterclockwise."""
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
    """

    left: tuple[str, ...]
    right: tuple[str, ...]
    slip: float = 1
    spread: float = 1
    acceleration: float | None = None

    def plugins(self, simulator: str) -> str:
        """DiffDrive in both; Classic's knows one pair of wheels, and calls left what is right."""
        if simulator != "classic":
            return system("DiffDrive", simulator, self._system())
        return "".join(
            classic("DiffDrive", f"drive_{left}", element("left_joint", right) + element("right_joint", left))
            for left, right in zip(self.left, self.right, strict=True)
        )

    def classic_command(self, name: str, v: float, w: float) -> Command:
        """A Pose."""
        return publish_command(f"~/{name}/vel_cmd", "Pose", pose_text(v, w * self.slip / self.spread), "classic")

    def _system(self) -> str:
        sides = elements("left_joint", self.left) + elements("right_joint", self.right)
        sizes = element("wheel_separation", self.separation * self.slip) + element("wheel_radius", self.radius)
        limits = _limits("linear", self.speed) + _limits("angular", self.turn)
        return sides + sizes + limits + self._accelerations()

    def _accelerations(self) -> str:
        if self.acceleration is None:
            return ""
        turning = 2 * self.acceleration / self.separation
        return _limits("linear", self.acceleration, "acceleration") + _limits("angular", turning, "acceleration")


_MOVING = 0.1  # m/s, below which SimpleTrackedVehicle takes a turn for one in place


@dataclass(frozen=True, kw_only=True, slots=True)
class Tracks(Drive):
    """Belts on links; radius of a track's end, metres.

    left, right: links, the main track before its flippers
    mu, mu2: friction along and across a belt
    efficiency: how much of the tracks' difference in speed becomes a turn; the rest is skidding
    in_place: how much more Classic's plug-in must be told to turn on the spot than in an arc, for the same turn rate
    """

    body: str
    left: tuple[str, ...]
    right: tuple[str, ...]
    mu: float
    mu2: float
    efficiency: float
    in_place: float = 1

    def plugins(self, simulator: str) -> str:
        """SimpleTrackedVehicle in Classic; TrackedVehicle, and a TrackController for every belt, in Gazebo Sim.

        Classic's calls left what is right.
        """
        if simulator == "classic":
            return classic("SimpleTrackedVehicle", "drive", self._belts())
        speeds = element("min_velocity", -2 * self.speed) + element("max_velocity", 2 * self.speed)
        belts = (element("link", belt) + speeds for belt in (*self.left, *self.right))
        return system("TrackedVehicle", simulator, self._system()) + "".join(
            system("TrackController", simulator, belt) for belt in belts
        )

    def classic_command(self, name: str, v: float, w: float) -> Command:
        """A Twist."""
        gain = self.in_place if abs(v) < _MOVING else 1
        return publish_command(f"~/{name}/cmd_vel_twist", "Twist", twist_text(v, w * gain), "classic")

    def _belts(self) -> str:
        sides = (("left", self.right), ("right", self.left))
        links = "".join(element(f"{s}_track", b[0]) + elements(f"{s}_flipper", b[1:]) for s, b in sides)
        most = element("max_linear_speed", 2 * self.speed) + element("max_angular_speed", self.in_place * self.turn)
        friction = element("track_mu", self.mu) + element("track_mu2", self.mu2)
        return element("body", self.body) + links + self._steering() + most + friction

    def _system(self) -> str:
        left = "".join(element("left_track", element("link", belt)) for belt in self.left)
        right = "".join(element("right_track", element("link", belt)) for belt in self.right)
        limits = _limited("linear_velocity", self.speed) + _limited("angular_velocity", self.turn)
        return left + right + self._steering() + element("tracks_height", 2 * self.radius) + limits

    def _steering(self) -> str:
        return element("tracks_separation", self.separation) + element("steering_efficiency", self.efficiency)


def _limits(kind: str, most: float, of: str = "velocity") -> str:
    return element(f"max_{kind}_{of}", most) + element(f"min_{kind}_{of}", -most)


def _limited(tag: str, most: float) -> str:
    return element(tag, element("min_velocity", -most) + element("max_velocity", most))
