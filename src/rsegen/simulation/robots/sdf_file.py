"""A robot from an SDF file of the user, which is parsed as untrusted input."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from rsegen.errors import FileError, ParameterError
from rsegen.exporters.gazebo.sdf import numbers
from rsegen.io.text_files import elements, text_of
from rsegen.simulation.robots.commands import Command
from rsegen.simulation.robots.drives import Drive, Wheels
from rsegen.simulation.robots.limits import SIDE, WHEEL, refuse_outside
from rsegen.simulation.robots.links import ORIGIN, PoseTuple
from rsegen.simulation.robots.plugins import pose_publisher
from rsegen.simulation.robots.sdf_drives import (
    DEFAULT_SPEED,
    DEFAULT_TURN,
    KNOWN,
    Found,
    found_drive,
    named_wheels,
    plugin_key,
)
from rsegen.simulation.robots.sdf_frames import Frames
from rsegen.simulation.robots.sdf_plugins import LeftOut, make_drivable
from rsegen.simulation.robots.sdf_shapes import Extents, extents
from rsegen.simulation.robots.sdf_uris import resolve_uris
from rsegen.simulation.robots.solids import Vector

MAX_MIB = 4
"""The largest file that is read: a second's work for the parser."""

_SUFFIXES = (".sdf", ".urdf", ".xacro")
"""Endings of files that are taken for a robot; URDF is refused with a word on how to convert it."""

_CLASSIC = "1.7"
"""The latest version of SDF that Gazebo Classic reads."""

_MOST_NAMES = 12
"""Names of joints in a message."""

_LARGEST_TURN = 3.0
"""rad/s: the most that Classic's drive can be told, as an angle below pi."""


@dataclass(frozen=True, kw_only=True, slots=True)
class SdfRobot:
    """A robot from a file: its name, its <model> as text, its drive, and what of it was derived from the model.

    backend: the simulator that its own plug-in is of, None if ROS's or none that is known; found: its drive, None if it
    has none that is known: then it cannot be driven; joints: those that could be wheels; size: of a box around its
    origin that holds its collision shapes; lift: how far its origin is above the lowest of them, metres; derived,
    assumed: which of size, speed and turn are from the model, and which from nowhere.
    """

    kind: str
    text: str
    version: str = "1.6"
    backend: str | None = None
    found: Found | None = None
    joints: tuple[str, ...] = ()
    size: Vector = (0.5, 0.5, 0.5)
    speed: float = DEFAULT_SPEED
    turn: float = DEFAULT_TURN
    lift: float = 0
    derived: tuple[str, ...] = ()
    assumed: tuple[str, ...] = ()

    @property
    def drive(self) -> Drive:
        """Its drive with its maximum speed and turn rate; ParameterError if none is known."""
        if self.found is None:
            raise ParameterError(self.kind, _no_drive(self))
        return replace(self.found.drive, speed=self.speed, turn=self.turn)

    @property
    def topic(self) -> str | None:
        """The topic of its drive with {name} for its name, None if no drive is known."""
        return self.command("{name}", 0, 0, self.backend or "classic").topic if self.found else None

    def model(self, name: str, simulator: str = "classic", at: PoseTuple = ORIGIN) -> str:
        """Its <model> under a name, its lowest point at the height of a pose, driven by the simulator's own plug-in."""
        model = self._placed(name, at)
        self._make_drivable(model, name, simulator)
        return _outer(model)

    def file(self, name: str, simulator: str = "classic") -> str:
        """The text of an SDF file of it with its own plug-ins, ROS's too."""
        is_newer = simulator == "classic" and _minor(self.version) > _minor(_CLASSIC)
        version = _CLASSIC if is_newer else self.version
        return f'<?xml version="1.0"?>\n<sdf version="{version}">\n{_outer(self._placed(name, ORIGIN))}</sdf>\n'

    def command(self, name: str, v: float, w: float, simulator: str = "classic") -> Command:
        """The command for speed v forward, m/s, and turn rate w, rad/s."""
        drive = self.drive
        if self.found and self.found.backwards:
            v, w = -v, -w
        if simulator == "classic" and isinstance(drive, Wheels):
            most = _LARGEST_TURN * drive.spread
            w = max(-most, min(most, w))
        return drive.command(name, v, w, simulator)

    def notes(self, simulator: str) -> Iterator[str]:
        """What was derived from its file, and what was left out of it for a drive, in a sentence each."""
        yield f"{self.kind}: {_derived(self)}"
        left = self._make_drivable(ElementTree.fromstring(self.text), self.kind, simulator)  # noqa: S314  # as above
        if left.plugins:
            yield f"{self.kind}: left out for the drive, as they are not here: {', '.join(left.plugins)}"
        if left.sensors:
            yield f"{self.kind}: left out for the drive, as sensors move nothing: {', '.join(left.sensors)}"

    def given(self, values: Mapping[str, Any]) -> SdfRobot:
        """The robot with the size, speed or turn rate that the user gives."""
        derived, assumed = (
            tuple(each for each in names if each not in values) for names in (self.derived, self.assumed)
        )
        return replace(self, derived=derived, assumed=assumed, **values)

    def _make_drivable(self, model: ElementTree.Element, name: str, simulator: str) -> LeftOut:
        if simulator == "classic" and model.find("allow_auto_disable") is None:
            ElementTree.SubElement(model, "allow_auto_disable").text = "false"  # it would sleep against a wall
        drive = self.drive if self.found else None
        left = make_drivable(model, drive, self.found.plugin if self.found else "", name, simulator)
        if simulator != "classic":
            model.append(ElementTree.fromstring(pose_publisher(simulator)))  # noqa: S314  # ours
        return left

    def _placed(self, name: str, at: PoseTuple) -> ElementTree.Element:
        model = ElementTree.fromstring(self.text)  # noqa: S314  # was found to be plain elements
        model.set("name", name)
        for pose in model.findall("pose"):
            model.remove(pose)
        pose = ElementTree.Element("pose")
        pose.text = numbers((at[0], at[1], at[2] + self.lift, *at[3:]))
        model.insert(0, pose)
        return model


def is_robot_file(what: object) -> bool:
    """Whether this is a path, or a text that ends as the name of a robot's file does."""
    return isinstance(what, os.PathLike) or (isinstance(what, str) and what.endswith(_SUFFIXES))


def from_file(path: str | os.PathLike[str], wheels: str | None = None) -> SdfRobot:
    """The robot of the one model in an SDF file; FileError if the file has anything else.

    wheels: the joints of its wheels as LEFT,RIGHT, several of a side joined by +, for a model without a drive that is
    known.
    """
    return parsed(text_of(Path(path), MAX_MIB, "a robot"), str(path), wheels)


def parsed(text: str, where: str, wheels: str | None = None) -> SdfRobot:
    """The one model in a text of SDF; a document type and entities are refused, as bombs are made of them."""
    root = elements(text, where)
    model = _model(root, where)
    resolve_uris(model, Path(where))
    version = _version(root)
    _modernize(model, version)
    frames = Frames(model, where)
    shapes = extents(frames)
    found = named_wheels(wheels, frames, shapes) if wheels else found_drive(model, frames, shapes)
    if found:
        refuse_outside(WHEEL, found.drive.separation, f"{where}: the separation of its wheels or tracks")
        refuse_outside(WHEEL, found.drive.radius, f"{where}: the radius of its wheels or tracks")
    size, (speed, turn) = _size(shapes, where), found.limits if found else (None, None)
    values = {"size": size, "speed": speed, "turn": turn}
    return SdfRobot(
        kind=re.sub(r"\W|^(?=\d)", "_", model.get("name", ""), flags=re.ASCII),
        text=_outer(model),
        version=version,
        backend=_backend(model, found),
        found=found,
        joints=tuple(name for name, each in frames.joints.items() if each.get("type") in ("revolute", "continuous")),
        size=size or (0.5, 0.5, 0.5),
        speed=speed or DEFAULT_SPEED,
        turn=turn or DEFAULT_TURN,
        lift=-float(shapes.low[2]) if shapes.known else 0.0,
        derived=tuple(name for name, value in values.items() if value is not None),
        assumed=tuple(name for name, value in values.items() if value is None),
    )


def _model(root: ElementTree.Element, where: str) -> ElementTree.Element:
    found = root.findall("model")
    if root.tag == "robot":
        raise FileError(f"{where}: URDF, not SDF; convert it: xacro FILE.xacro > r.urdf, gz sdf -p r.urdf > r.sdf")
    if root.tag != "sdf" or len(found) != 1 or root.find("world") is not None:
        raise FileError(f"{where}: not an SDF file with one <model> in <sdf>")
    if not found[0].get("name", "").strip():
        raise FileError(f"{where}: the model has no name")
    if found[0].find("link") is None and found[0].find("include") is None and found[0].find("model") is None:
        raise FileError(f"{where}: the model has no <link>")
    return found[0]


def _version(root: ElementTree.Element) -> str:
    """The version of SDF, 1.6 if it is none that there is."""
    found = root.get("version", "").strip()
    return found if re.fullmatch(r"1\.\d\d?", found, flags=re.ASCII) else "1.6"


def _minor(version: str) -> int:
    return int(version.partition(".")[2])


def _modernize(model: ElementTree.Element, version: str) -> None:
    """Say of the joints' axes what was the rule before SDF 1.5, for a world of a later version."""
    if _minor(version) < 5:
        for axis in model.iter("axis"):
            if axis.find("use_parent_model_frame") is None:
                ElementTree.SubElement(axis, "use_parent_model_frame").text = "true"


def _size(shapes: Extents, where: str) -> Vector | None:
    """The size of a box around the origin that holds all collision shapes; None if it is not known of all."""
    if not shapes.known:
        return None
    low, high = shapes.low, shapes.high
    sides = (*(2 * np.maximum(np.abs(low), np.abs(high))[:2]), high[2] - low[2])
    x, y, z = (float(np.maximum(side, SIDE.low)) for side in sides)
    for side in (x, y, z):
        refuse_outside(SIDE, side, f"{where}: the box around its collision shapes, {x:.4g} x {y:.4g} x {z:.4g} m")
    return None if shapes.unknown else (x, y, z)


def _backend(model: ElementTree.Element, found: Found | None) -> str | None:
    """The simulator that the plug-in of a drive is of."""
    if not found or not found.plugin or _is_ros(found):
        return None
    if found.plugin.endswith("Plugin"):
        return "classic"
    files = (plugin.get("filename", "") for plugin in model.iter("plugin"))
    return "fortress" if any("ignition" in file for file in files if plugin_key(file) == found.plugin) else "sim"


def _is_ros(found: Found) -> bool:
    return "_ros_" in found.plugin


def _derived(robot: SdfRobot) -> str:
    """What was taken from its file, and what was assumed."""
    found, said = robot.found, []
    if found:
        origin = found.plugin or "the given wheels"
        what = "wheels" if isinstance(found.drive, Wheels) else "tracks"
        sizes = f"{found.drive.separation:.4g} m apart, radius {found.drive.radius:.4g} m"
        said.append(f"its drive is read from {origin}, with {what} {sizes}, by {found.sizes}")
    values = {
        "size": f"size {' x '.join(f'{side:.3f}' for side in robot.size)} m around its origin",
        "speed": f"speed {robot.speed:g} m/s",
        "turn": f"turn rate {robot.turn:g} rad/s",
    }
    for origin, names in (("its model", robot.derived), ("assumption", robot.assumed)):
        if names:
            said.append(", ".join(values[name] for name in names) + f" by {origin}")
    return "; ".join(said)


def _no_drive(robot: SdfRobot) -> str:
    joints = ", ".join(robot.joints[:_MOST_NAMES]) + (", ..." if len(robot.joints) > _MOST_NAMES else "")
    wheels = f"name its wheels' joints with --wheels LEFT,RIGHT ({joints})" if joints else "it has no joint that turns"
    return f"no drive that rsegen knows ({', '.join(KNOWN)}); {wheels}"


def _outer(model: ElementTree.Element) -> str:
    model.tail = "\n"
    return ElementTree.tostring(model, encoding="unicode")
