"""A robot from an SDF or URDF file of the user, which is parsed as untrusted input.

The model is kept as text, URDF as SDF. Its drive, size and limits are read once; for a world it gets a drive plug-in of
the simulator that runs it, in place of its own or ROS's, and loses what that simulator cannot load, and its sensors;
flippers, arms and legs keep their angles. URIs of meshes become absolute paths first, as the world is written
elsewhere. What breaks it: meshes in packages that are not found, and joints inside an <include> (docs/robots.md).
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any
from xml.etree import ElementTree

import numpy as np

from rsegen.errors import FileError, ParameterError
from rsegen.exporters.gazebo.sdf import numbers
from rsegen.field.limits import SIDE
from rsegen.io.input_files import elements, text_of
from rsegen.robots.base import WHEEL, refuse_outside
from rsegen.robots.body import body_of_file
from rsegen.robots.controllers import Controls, controls
from rsegen.robots.drivable_model import Changes, has_controllers, hold, make_drivable
from rsegen.robots.drives import Command, Drive, Wheels, pose_publisher
from rsegen.robots.links import ORIGIN, SdfPose, Vector
from rsegen.robots.sdf_drives import (
    DEFAULT_SPEED,
    DEFAULT_TURN,
    ReadDrive,
    find_drive,
    named_tracks,
    named_wheels,
    plugin_key,
)
from rsegen.robots.sdf_shapes import Extents, ModelFrames, impossible_inertias, inertials
from rsegen.robots.urdf import Converted, converted
from rsegen.robots.uris import resolve_uris
from rsegen.robots.xacro_files import expanded, is_xacro, with_arguments
from rsegen.standing.body import Body
from rsegen.standing.kinds import Standing
from rsegen.standing.spots import body_of_size

MAX_MIB = 4
"""The largest file that is read, MiB: a second's work for the parser; robots' files have some tens of kilobytes."""

_SUFFIXES = (".sdf", ".urdf", ".xacro")
"""Endings of files that are taken for a robot."""

_LATEST_OF_CLASSIC = "1.7"
"""The latest version of SDF that Gazebo Classic reads."""

_MOST_NAMES = 12
"""Names of joints or links in a message at most: an arm has more, and the wheels come first in most files."""

_LARGEST_TURN = 3.0
"""Largest turn rate, rad/s, of a command to Classic's drive, which takes it as an angle below pi."""


@dataclass(frozen=True, kw_only=True, slots=True)
class SdfRobot(Standing):
    """A robot from a file: its name, its <model> as text, its drive, and what of it was derived from the model.

    backend: the simulator that its own plug-in is of, None if ROS's or none that is known; read_drive: its drive, None
    if it has neither wheels nor tracks that are known: then it cannot be driven, and stands; joints: those that could
    be wheels; size: of a box around its origin that holds its collision shapes; lift: how far its origin is above the
    lowest of them, metres; derived, assumed: which of size, speed and turn are from the model, and which from nowhere;
    remarks: sentences about links that were left out, or whose inertia no body has, joints that do not follow others as
    they should, and packages that are not found.
    """

    kind: str
    text: str
    version: str = "1.6"
    backend: str | None = None
    read_drive: ReadDrive | None = None
    joints: tuple[str, ...] = ()
    size: Vector = (0.5, 0.5, 0.5)
    speed: float = DEFAULT_SPEED
    turn: float = DEFAULT_TURN
    lift: float = 0
    derived: tuple[str, ...] = ()
    assumed: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()

    @property
    def body(self) -> Body:
        """The robot from below, with its joints at 0; FileError for a shape that cannot be measured."""
        return body_of_file(self)

    @property
    def body_or_box(self) -> Body:
        """The robot from below; a box of its size if its shapes are unknown, or its size is given."""
        return self.body if "size" in self.derived else body_of_size(*self.size[:2])

    @property
    def drive(self) -> Drive:
        """The drive with its maximum speed and turn rate; ParameterError if none is known."""
        if self.read_drive is None:
            raise ParameterError(self.kind, _no_drive(self))
        return replace(self.read_drive.drive, speed=self.speed, turn=self.turn)

    @property
    def topic(self) -> str | None:
        """The topic of its drive with {name} for its name, None if no drive is known."""
        return self.command("{name}", 0, 0, self.backend or "classic").topic if self.read_drive else None

    def model(self, name: str, simulator: str = "classic", at: SdfPose = ORIGIN) -> str:
        """Return its <model> with its lowest point at the height of a pose, driven by the simulator's own plug-in."""
        model = self._placed(name, at)
        self._make_drivable(model, name, simulator)
        return _outer(model)

    def file(self, name: str, simulator: str = "classic") -> str:
        """Return the text of an SDF file of it with its own plug-ins, ROS's too; what has no drive stands still."""
        is_newer = simulator == "classic" and _minor(self.version) > _minor(_LATEST_OF_CLASSIC)
        version = _LATEST_OF_CLASSIC if is_newer else self.version
        model = self._placed(name, ORIGIN)
        if self._stands(simulator):
            hold(model, None)
        return f'<?xml version="1.0"?>\n<sdf version="{version}">\n{_outer(model)}</sdf>\n'

    def command(self, name: str, v: float, w: float, simulator: str = "classic") -> Command:
        """Return the command for speed v forward, m/s, and turn rate w, rad/s."""
        drive = self.drive
        if simulator == "classic" and isinstance(drive, Wheels):
            most = _LARGEST_TURN * drive.spread
            w = max(-most, min(most, w))
        return drive.command(name, v, w, simulator)

    def notes(self, simulator: str) -> Iterator[str]:
        """Yield what was derived from its file, and what was left out of it for a drive, in a sentence each."""
        yield f"{self.kind}: {_derived(self)}"
        yield from (f"{self.kind}: {remark}" for remark in self.remarks)
        changes = self._make_drivable(self._model(), self.kind, simulator)
        if changes.held:
            yield f"{self.kind}: held as its model has them, as nothing drives them: {_some(changes.held)}"
        if changes.plugins:
            yield f"{self.kind}: left out for the drive, as they are not here: {', '.join(changes.plugins)}"
        if changes.visuals:
            yield f"{self.kind}: left out for the drive, as their meshes are not found: {', '.join(changes.visuals)}"
        if changes.sensors:
            yield f"{self.kind}: left out for the drive, as sensors move nothing: {', '.join(changes.sensors)}"

    def spawn_notes(self, simulator: str) -> Iterator[str]:
        """Yield what was left out of its file, and whether its joints are held, in a sentence each."""
        yield from (f"{self.kind}: {remark}" for remark in self.remarks)
        if self._stands(simulator) and (held := hold(self._model(), None)):
            yield f"{self.kind}: has no wheels or tracks, so its joints are held as its model has them: {_some(held)}"

    def given(self, values: Mapping[str, Any]) -> SdfRobot:
        """Return the robot with the size, speed or turn rate that the user gives."""
        derived, assumed = (
            tuple(name for name in names if name not in values) for names in (self.derived, self.assumed)
        )
        return replace(self, derived=derived, assumed=assumed, **values)

    def _stands(self, simulator: str) -> bool:
        """Return whether nothing drives it, nor moves its joints: it then stands as its model has it."""
        return self.read_drive is None and not has_controllers(self._model(), simulator)

    def _model(self) -> ElementTree.Element:
        return ElementTree.fromstring(self.text)  # noqa: S314  # was found to be plain elements

    def _make_drivable(self, model: ElementTree.Element, name: str, simulator: str) -> Changes:
        if simulator == "classic" and model.find("allow_auto_disable") is None:
            ElementTree.SubElement(model, "allow_auto_disable").text = "false"  # it would sleep against a wall
        drive = self.drive if self.read_drive else None
        changes = make_drivable(model, drive, self.read_drive, name, simulator)
        if simulator != "classic":
            model.append(ElementTree.fromstring(pose_publisher(simulator)))  # noqa: S314  # ours
        return changes

    def _placed(self, name: str, at: SdfPose) -> ElementTree.Element:
        model = self._model()
        model.set("name", name)
        for pose in model.findall("pose"):
            model.remove(pose)
        pose = ElementTree.Element("pose")
        pose.text = numbers((at[0], at[1], at[2] + self.lift, *at[3:]))
        model.insert(0, pose)
        return model


def is_robot_file(what: object) -> bool:
    """Return whether this is a path, or a text that ends as the name of a robot's file does, before any arguments."""
    return isinstance(what, os.PathLike) or (isinstance(what, str) and with_arguments(what)[0].endswith(_SUFFIXES))


def from_file(path: str | os.PathLike[str], wheels: str | None = None, tracks: str | None = None) -> SdfRobot:
    """Return the robot of the one model in an SDF, URDF or Xacro file; FileError if the file has anything else.

    path: a text may have arguments of Xacro after it, as in "robot.urdf.xacro laser:=true". wheels: the joints of its
    wheels as LEFT,RIGHT; tracks: the links of its tracks; several of a side joined by +, the flippers of a track after
    it. They are for a model that does not say it, or says it otherwise.
    """
    file, arguments = with_arguments(path) if isinstance(path, str) else (os.fspath(path), {})
    return parsed(text_of(Path(file), MAX_MIB, "a robot"), file, wheels, tracks, arguments)


def parsed(
    text: str,
    where: str,
    wheels: str | None = None,
    tracks: str | None = None,
    arguments: Mapping[str, str] = MappingProxyType({}),
) -> SdfRobot:
    """Return the one model in a text; a document type and entities are refused, as bombs are made of them."""
    root = elements(text, where)
    remarks: list[str] = []
    if is_xacro(root, where):
        text, missing = expanded(text, where, arguments)
        root = elements(text, where)
        remarks += [f"left out what it includes of packages that are not found: {_some(missing)}"] if missing else []
    elif arguments:
        raise FileError(f"{where}: {next(iter(arguments))}:= is for a Xacro file, and this one has no macros")
    ros = controls(root, Path(where)) if root.tag == "robot" else Controls()
    separate = re.split(r"[,+]", tracks or "")
    source = converted(root, where, separate) if root.tag == "robot" else Converted(root)
    root, model = source.sdf, _model(source.sdf, where)
    resolve_uris(model, Path(where))
    version = _version(root)
    _modernize(model, version)
    # Places and shapes come first: what the drive's plug-in does not say is measured on them.
    frames = ModelFrames(model, where)
    shapes = frames.shapes
    inertials(frames)  # an error for a mass that no simulator takes
    if wheels:
        drive: ReadDrive | None = named_wheels(wheels, frames, ros)
    else:
        drive = named_tracks(tracks, frames) if tracks else find_drive(model, frames, ros)
    if drive:
        refuse_outside(WHEEL, drive.drive.separation, f"{where}: the separation of its wheels or tracks")
        refuse_outside(WHEEL, drive.drive.radius, f"{where}: the radius of its wheels or tracks")
    size, (speed, turn) = _size(shapes, where), drive.limits if drive else (None, None)
    values = {"size": size, "speed": speed, "turn": turn}
    return SdfRobot(
        kind=re.sub(r"\W|^(?=\d)", "_", model.get("name", ""), flags=re.ASCII),
        text=_outer(model),
        version=version,
        backend=_backend(model, drive),
        read_drive=drive,
        joints=tuple(name for name, joint in frames.joints.items() if joint.get("type") in ("revolute", "continuous")),
        size=size or (0.5, 0.5, 0.5),
        speed=speed or DEFAULT_SPEED,
        turn=turn or DEFAULT_TURN,
        lift=-float(shapes.low[2]) if shapes.known else 0.0,
        derived=tuple(name for name, value in values.items() if value is not None),
        assumed=tuple(name for name, value in values.items() if value is None),
        remarks=(*remarks, *_remarks(source, impossible_inertias(frames))),
    )


def _remarks(source: Converted, impossible: Sequence[str]) -> Iterator[str]:
    """Yield a sentence about links without a mass, joints that should follow others, and impossible inertias."""
    if source.left_out:
        yield f"left out, as they have no mass, or hang on such a link: {_some(source.left_out)}"
    if source.mimics:
        yield f"<mimic> has no effect, so these joints move on their own, unless they are held: {_some(source.mimics)}"
    if impossible:
        yield f"no body has the moments of inertia of {_some(impossible)}; Gazebo Sim may refuse them"


def _some(names: Sequence[str]) -> str:
    return ", ".join(names[:_MOST_NAMES]) + (", ..." if len(names) > _MOST_NAMES else "")


def _model(root: ElementTree.Element, where: str) -> ElementTree.Element:
    models = root.findall("model")
    if root.tag != "sdf" or len(models) != 1 or root.find("world") is not None:
        raise FileError(f"{where}: not an SDF file with one <model> in <sdf>, nor URDF")
    if not models[0].get("name", "").strip():
        raise FileError(f"{where}: the model has no name")
    if models[0].find("link") is None and models[0].find("include") is None and models[0].find("model") is None:
        raise FileError(f"{where}: the model has no <link>")
    return models[0]


def _version(root: ElementTree.Element) -> str:
    """Return the version of SDF, 1.6 if it is none that there is."""
    version = root.get("version", "").strip()
    return version if re.fullmatch(r"1\.\d\d?", version, flags=re.ASCII) else "1.6"


def _minor(version: str) -> int:
    return int(version.partition(".")[2])


def _modernize(model: ElementTree.Element, version: str) -> None:
    """Write down the rule for joints' axes before SDF 1.5, for a world of a later version: the model's frame."""
    if _minor(version) < 5:
        for axis in model.iter("axis"):
            if axis.find("use_parent_model_frame") is None:
                ElementTree.SubElement(axis, "use_parent_model_frame").text = "true"


def _size(shapes: Extents, where: str) -> Vector | None:
    """Return the size of a box around the origin that holds all collision shapes; None if one is unknown."""
    if not shapes.known:
        return None
    low, high = shapes.low, shapes.high
    sides = (*(2 * np.maximum(np.abs(low), np.abs(high))[:2]), high[2] - low[2])
    x, y, z = (float(np.maximum(side, SIDE.low)) for side in sides)
    for side in (x, y, z):
        refuse_outside(SIDE, side, f"{where}: the box around its collision shapes, {x:.4g} x {y:.4g} x {z:.4g} m")
    return None if shapes.unknown else (x, y, z)


def _backend(model: ElementTree.Element, drive: ReadDrive | None) -> str | None:
    """Return the backend that the plug-in of a drive is of; None for ROS's, and for wheels that the user named."""
    if not drive or not drive.plugin or "_ros_" in drive.plugin:
        return None
    if drive.plugin.endswith("Plugin"):
        return "classic"
    files = (plugin.get("filename", "") for plugin in model.iter("plugin"))
    return "fortress" if any("ignition" in file for file in files if plugin_key(file) == drive.plugin) else "sim"


def _derived(robot: SdfRobot) -> str:
    """Return what was taken from its file or from those around it, and what was assumed."""
    read, phrases = robot.read_drive, []
    limits_by = "its model"
    if read:
        limits_by = read.limits_by
        drive = read.drive
        what = "wheels" if isinstance(drive, Wheels) else "tracks"
        sides = ",".join("+".join(side) for side in (drive.left, drive.right))
        skid = f", times {drive.slip:g} as they skid" if isinstance(drive, Wheels) and drive.slip != 1 else ""
        sizes = f"{drive.separation:.4g} m apart{skid}, radius {drive.radius:.4g} m"
        phrases.append(f"its {what} are {sides} by {read.origin}, {sizes} by {read.sizes}")
    values = {
        "size": f"size {' x '.join(f'{side:.3f}' for side in robot.size)} m around its origin",
        "speed": f"speed {robot.speed:.4g} m/s",
        "turn": f"turn rate {robot.turn:.4g} rad/s",
    }
    origins = {"size": "its model", "speed": limits_by, "turn": limits_by}
    origins |= dict.fromkeys(robot.assumed, "assumption")
    for origin in dict.fromkeys(origins.values()):
        names = [name for name in (*robot.derived, *robot.assumed) if origins[name] == origin]
        phrases += [", ".join(values[name] for name in names) + f" by {origin}"] if names else []
    return "; ".join(phrases)


def _no_drive(robot: SdfRobot) -> str:
    joints = f" ({_some(robot.joints)})" if robot.joints else ""
    return (
        "no wheels or tracks: no plug-in that rsegen knows has them, nor ros2_control or a file of a controller, and no"
        f" links look like wheels; name them with tracks='LEFT,RIGHT', or wheels='LEFT,RIGHT'{joints}; without them it"
        " only stands, with rsegen spawn"
    )


def _outer(model: ElementTree.Element) -> str:
    model.tail = "\n"
    return ElementTree.tostring(model, encoding="unicode")
