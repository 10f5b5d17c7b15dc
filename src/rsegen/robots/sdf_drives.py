"""Read the drive of a model in an SDF file from its plug-in, be it one of a simulator or of ROS.

A plug-in names joints (wheels) or links (tracks), and perhaps separation, radius and limits; what it does not say is
measured on the collision shapes. Left and right follow from the places of the joints, as Gazebo Classic's plug-ins call
left what is right. Without a known plug-in the user names the wheels. What breaks it: wheels in an <include>, and
shapes of unknown size (docs/robots.md).
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import NamedTuple
from xml.etree.ElementTree import Element

import numpy as np

from rsegen.errors import FileError, ParameterError, UnknownName, shown
from rsegen.field.limits import SPEED, TURN
from rsegen.params.sorts import Float
from rsegen.robots.base import refuse_outside
from rsegen.robots.drives import Drive, Tracks, Wheels
from rsegen.robots.sdf_shapes import Extents, ModelFrames, floats

DEFAULT_SPEED, DEFAULT_TURN = 0.2, 0.5
"""Speed, m/s, and turn rate, rad/s, of a robot whose model gives no limits: slow enough for all; notes report them."""

KNOWN = {
    "gazebo_ros_diff_drive": "wheels",
    "gazebo_ros_skid_steer_drive": "wheels",
    "DiffDrivePlugin": "wheels",
    "SkidSteerDrivePlugin": "wheels",
    "WheelTrackedVehiclePlugin": "wheels",
    "SimpleTrackedVehiclePlugin": "belts",
    "gz-sim-diff-drive-system": "wheels",
    "gz-sim-mecanum-drive-system": "wheels",
    "gz-sim-tracked-vehicle-system": "tracks",
}
"""Plug-ins of drives that are read, without lib and .so, and how they say what they drive."""

_SIDES = ("left", "right")
_JOINTS = ("{}_joint", "{}Joint", "{}_front", "{}FrontJoint", "front_{}_joint", "{}_front_joint")
_REAR = ("{}_rear", "{}RearJoint", "back_{}_joint", "{}_rear_joint")
"""Tags of the joints of a side in plug-ins; those before name front joints, these rear ones."""


class ReadDrive(NamedTuple):
    """A drive as it was read from a model.

    plugin: its plug-in, by its key in KNOWN, empty if the user named the wheels; sizes: the origin of separation and
    radius; limits: of the speed and the turn rate, None if the model has none; backwards: whether the wheels' axes
    point to the right, so that they roll backwards
    """

    plugin: str
    drive: Drive
    sizes: str
    limits: tuple[float | None, float | None] = (None, None)
    backwards: bool = False


def plugin_key(file: str) -> str:
    """Return the name of a plug-in's file as in KNOWN: without lib and .so, and Fortress's as later ones."""
    name = file.strip().rpartition("/")[2].removeprefix("lib").removesuffix(".so")
    return re.sub(r"^(gz-sim|ignition-gazebo)\d*-", "gz-sim-", name)


def find_drive(model: Element, frames: ModelFrames, shapes: Extents) -> ReadDrive | None:
    """Return the drive of the first plug-in that is known and names what it drives; None if there is none.

    Classic's DiffDrive knows one pair of wheels, so a model may have several: plug-ins of one kind are one drive.
    """
    merged: dict[str, Element] = {}
    for plugin in model.iter("plugin"):
        key = plugin_key(plugin.get("filename", ""))
        if key in KNOWN:
            merged.setdefault(key, Element("plugin")).extend(list(plugin))
    readers = {"wheels": _wheels, "belts": _belts, "tracks": _tracks}
    read = ((key, readers[KNOWN[key]](plugin, frames, shapes)) for key, plugin in merged.items())
    return next((drive._replace(plugin=key) for key, drive in read if drive), None)


def named_wheels(text: str, frames: ModelFrames, shapes: Extents) -> ReadDrive:
    """Return the drive of wheels whose joints the user names: LEFT,RIGHT; several of a side joined by +."""
    sides = [side.split("+") for side in text.split(",")]
    if len(sides) != 2 or len(sides[0]) != len(sides[1]) or not all(joint for side in sides for joint in side):
        raise ParameterError("wheels", f"{shown(text)} is not LEFT,RIGHT or FRONT+REAR,FRONT+REAR, joints of wheels")
    joints = list(frames.joints)
    for joint in (joint for side in sides for joint in side):
        if joint not in joints:
            raise UnknownName.among("wheels", "joint", joint, joints)
    # 1 for an axis to the left, -1 for one to the right, 0 for an axis that is not along y, within a milliradian.
    ways = {np.sign(frames.axis(joint)[1].round(3)) for side in sides for joint in side}
    if len(ways) != 1 or 0 in ways:
        raise ParameterError("wheels", f"{text}: their axes are not all along y, to the same side")
    left, right = _by_side(sides[0], sides[1], frames, shapes)
    drive = _made(left, right, _separation(left, right, frames, shapes), _radius(left, frames, shapes), frames)
    if not drive.separation or not drive.radius:
        problem = "their places or shapes are unknown; a wheel needs a collision shape such as a cylinder or sphere"
        raise ParameterError("wheels", f"{text}: {problem}")
    return ReadDrive("", drive, "its wheels", backwards=ways == {-1.0})


def _wheels(plugin: Element, frames: ModelFrames, shapes: Extents) -> ReadDrive | None:
    """Return a drive of wheels, which plug-ins of Gazebo and of ROS name by their joints."""
    left, right = (_named(plugin, [tag.format(side) for tag in (*_JOINTS, *_REAR)]) for side in _SIDES)
    missing = [joint for joint in (*left, *right) if joint not in frames.joints]
    if not left or len(left) != len(right) or missing:
        return None
    left, right = map(list, _by_side(left, right, frames, shapes))
    separation = _number(plugin, frames, "wheel_separation", "wheelSeparation", "tracks_separation")
    diameter = _number(plugin, frames, "wheel_diameter", "wheelDiameter")
    radius = _number(plugin, frames, "wheel_radius", "default_wheel_radius") or (diameter or 0) / 2
    # Sizes that the plug-in does not give are measured on the wheels.
    given = bool(separation and radius)
    drive = _made(
        left,
        right,
        separation or _separation(left, right, frames, shapes),
        radius or _radius(left, frames, shapes),
        frames,
    )
    if not drive.separation or not drive.radius:
        return None
    limits = _limits(plugin, frames, drive, left + right)
    return ReadDrive("", drive, "its plug-in" if given else "its wheels", limits)


def _made(left: Sequence[str], right: Sequence[str], separation: float, radius: float, frames: ModelFrames) -> Wheels:
    """Return wheels; Classic's plug-in takes the distance between the joints for the separation."""
    between = frames.joint(left[0])[:3, 3] - frames.joint(right[0])[:3, 3]
    apart = float(np.linalg.norm(between))
    spread = apart / separation if apart and separation else 1
    return Wheels(
        left=tuple(left),
        right=tuple(right),
        separation=separation,
        radius=radius,
        speed=DEFAULT_SPEED,
        turn=DEFAULT_TURN,
        spread=spread,
    )


def _belts(plugin: Element, frames: ModelFrames, shapes: Extents) -> ReadDrive | None:
    """Return the drive of Gazebo Classic's SimpleTrackedVehicle."""
    left, right = (_named(plugin, [f"{side}_track", f"{side}_flipper"]) for side in _SIDES)
    return _tracked(plugin, left, right, frames, shapes, body=_text(plugin.find("body")))


def _tracks(plugin: Element, frames: ModelFrames, shapes: Extents) -> ReadDrive | None:
    """Return the drive of Gazebo Sim's TrackedVehicle; its body is the first link of its model."""
    left, right = ([_text(element.find("link")) for element in plugin.findall(f"{side}_track")] for side in _SIDES)
    body = next((name for name, element in frames.elements.items() if element.tag == "link"), "")
    return _tracked(plugin, left, right, frames, shapes, body=body)


def _tracked(
    plugin: Element, left: Sequence[str], right: Sequence[str], frames: ModelFrames, shapes: Extents, *, body: str
) -> ReadDrive | None:
    if not left or not right or any(link not in frames.elements for link in (*left, *right, body)):
        return None
    middles = [_middle(link, frames, shapes) for link in (left[0], right[0])]
    if middles[0][1] < middles[1][1]:
        left, right = right, left
    track = shapes.of(left[0])
    # A track of unknown shape counts as 0.2 m high. The friction and the efficiency are SimpleTrackedVehicle's
    # defaults.
    height = _number(plugin, frames, "tracks_height") or (float(track.high[2] - track.low[2]) if track else 0.2)
    drive = Tracks(
        body=body,
        left=tuple(left),
        right=tuple(right),
        separation=_number(plugin, frames, "tracks_separation") or abs(float(middles[0][1] - middles[1][1])),
        radius=height / 2,
        speed=DEFAULT_SPEED,
        turn=DEFAULT_TURN,
        mu=_number(plugin, frames, "track_mu") or 2,
        mu2=_number(plugin, frames, "track_mu2") or 0.5,
        efficiency=_number(plugin, frames, "steering_efficiency") or 0.5,
    )
    return ReadDrive("", drive, "its plug-in", _limits(plugin, frames, drive, ()))


def _by_side(
    first_side: Sequence[str], second_side: Sequence[str], frames: ModelFrames, shapes: Extents
) -> tuple[Sequence[str], Sequence[str]]:
    """Return the joints of the left and the right side, by their places: Classic calls left what is right."""
    first, second = (_middle(_child(side[0], frames), frames, shapes)[1] for side in (first_side, second_side))
    return (second_side, first_side) if first < second else (first_side, second_side)


def _separation(left: Sequence[str], right: Sequence[str], frames: ModelFrames, shapes: Extents) -> float:
    first, second = (_middle(_child(side[0], frames), frames, shapes)[1] for side in (left, right))
    return float(abs(first - second))


def _radius(joints: Sequence[str], frames: ModelFrames, shapes: Extents) -> float:
    """Half of the height of the first wheel; 0 if its shape is unknown."""
    wheel = shapes.of(_child(joints[0], frames))
    return float(wheel.high[2] - wheel.low[2]) / 2 if wheel else 0.0


def _middle(link: str, frames: ModelFrames, shapes: Extents) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Return the middle of a link's shapes, else its origin."""
    shape = shapes.of(link)
    return np.asarray(frames.transform(link)[:3, 3] if shape is None else (shape.low + shape.high) / 2)


def _child(joint: str, frames: ModelFrames) -> str:
    """Return the link that a joint turns."""
    scope = joint.rpartition("::")[0]
    child = _text(frames.joints[joint].find("child"))
    return f"{scope}::{child}" if scope else child


def _limits(
    plugin: Element, frames: ModelFrames, drive: Drive, joints: Iterable[str]
) -> tuple[float | None, float | None]:
    """Return the greatest speed and turn rate by the plug-in, else the greatest speed by its wheels' joints."""
    speed = _number(plugin, frames, "max_linear_velocity", "max_velocity", "max_linear_speed")
    speed = speed or _number(plugin, frames, "linear_velocity/max_velocity")
    turn = _number(plugin, frames, "max_angular_velocity", "max_angular_speed", "angular_velocity/max_velocity")
    rates = [_number(frames.joints[joint], frames, "axis/limit/velocity") for joint in joints]
    least = min((rate for rate in rates if rate), default=0) * drive.radius
    speed = _limit(SPEED, speed, frames) or _limit(SPEED, least, frames)
    return speed, _limit(TURN, turn, frames)


def _limit(sort: Float, value: float | None, frames: ModelFrames) -> float | None:
    """Return a limit of a model; None for none, as numbers are that no robot reaches: SDF's own is 1e16."""
    if not value or value > sort.high:
        return None
    refuse_outside(sort, value, f"{frames.where}: the limit of a velocity")
    return value


def _number(element: Element, frames: ModelFrames, *paths: str) -> float | None:
    """Return the first number that stands in one of these elements; None if there is none, or it is not positive."""
    text = next((text for path in paths if (text := element.findtext(path))), None)
    try:
        value = floats(text, 1, frames.where)[0]
    except FileError:
        return None
    return value if value > 0 else None


def _named(plugin: Element, tags: Iterable[str]) -> list[str]:
    """Return the texts of elements with these tags, in the order of the tags."""
    return [_text(element) for tag in tags for element in plugin.findall(tag)]


def _text(element: Element | None) -> str:
    return "" if element is None else (element.text or "").strip()
