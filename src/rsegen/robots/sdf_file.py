"""A robot from an SDF or URDF file of the user, which is parsed as untrusted input.

The model is kept as text, URDF as SDF. Its drive, size and limits are read once; for a world it gets a drive plug-in of
the simulator that runs it, in place of its own or ROS's, and loses what that simulator cannot load, and its sensors.
URIs of meshes become absolute paths first, as the world is written elsewhere. What breaks it: a drive that no known
plug-in gives, meshes in packages that are not found, and joints inside an <include> (docs/robots.md).
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement, fromstring

import numpy as np

from rsegen.errors import FileError, ParameterError
from rsegen.exporters.gazebo.sdf import numbers, prefixes
from rsegen.field.limits import SIDE
from rsegen.io.input_files import elements, text_of
from rsegen.robots.base import WHEEL, refuse_outside
from rsegen.robots.body import body_of_file
from rsegen.robots.drives import Command, Drive, Wheels, pose_publisher
from rsegen.robots.links import ORIGIN, SdfPose, Vector
from rsegen.robots.sdf_drives import DEFAULT_SPEED, DEFAULT_TURN, KNOWN, ReadDrive, find_drive, named_wheels, plugin_key
from rsegen.robots.sdf_shapes import Extents, ModelFrames, extents, impossible_inertias, inertials
from rsegen.robots.urdf import converted
from rsegen.robots.uris import resolve_uris
from rsegen.robots.xacro_files import expanded, is_xacro
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

_TRACK_CONTROLLER = "gz-sim-track-controller-system"
"""The plug-in of Gazebo Sim that moves a single track, and belongs to a drive of tracks."""

_ROS = re.compile(r"(?:^|_)ros\d?(?:_|$)|^hector_gazebo_")
"""Names of plug-ins of ROS, as in libgazebo_ros_diff_drive.so or gz_ros2_control-system."""

_LIBRARIES = ("GAZEBO_PLUGIN_PATH", "GZ_SIM_SYSTEM_PLUGIN_PATH", "IGN_GAZEBO_SYSTEM_PLUGIN_PATH", "LD_LIBRARY_PATH")
"""Variables that list the folders of plug-ins."""


@dataclass(frozen=True, kw_only=True, slots=True)
class SdfRobot(Standing):
    """A robot from a file: its name, its <model> as text, its drive, and what of it was derived from the model.

    backend: the simulator that its own plug-in is of, None if ROS's or none that is known; read_drive: its drive, None
    if it
    has none that is known: then it cannot be driven; joints: those that could be wheels; size: of a box around its
    origin that holds its collision shapes; lift: how far its origin is above the lowest of them, metres; derived,
    assumed: which of size, speed and turn are from the model, and which from nowhere; remarks: sentences about
    links that were left out, or whose inertia no body has.
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
        """Return the text of an SDF file of it with its own plug-ins, ROS's too."""
        is_newer = simulator == "classic" and _minor(self.version) > _minor(_LATEST_OF_CLASSIC)
        version = _LATEST_OF_CLASSIC if is_newer else self.version
        return f'<?xml version="1.0"?>\n<sdf version="{version}">\n{_outer(self._placed(name, ORIGIN))}</sdf>\n'

    def command(self, name: str, v: float, w: float, simulator: str = "classic") -> Command:
        """Return the command for speed v forward, m/s, and turn rate w, rad/s."""
        drive = self.drive
        if self.read_drive and self.read_drive.backwards:
            v, w = -v, -w
        if simulator == "classic" and isinstance(drive, Wheels):
            most = _LARGEST_TURN * drive.spread
            w = max(-most, min(most, w))
        return drive.command(name, v, w, simulator)

    def notes(self, simulator: str) -> Iterator[str]:
        """Yield what was derived from its file, and what was left out of it for a drive, in a sentence each."""
        yield f"{self.kind}: {_derived(self)}"
        yield from (f"{self.kind}: {remark}" for remark in self.remarks)
        left_out = self._make_drivable(ElementTree.fromstring(self.text), self.kind, simulator)  # noqa: S314  # as above
        if left_out.plugins:
            yield f"{self.kind}: left out for the drive, as they are not here: {', '.join(left_out.plugins)}"
        if left_out.sensors:
            yield f"{self.kind}: left out for the drive, as sensors move nothing: {', '.join(left_out.sensors)}"

    def given(self, values: Mapping[str, Any]) -> SdfRobot:
        """Return the robot with the size, speed or turn rate that the user gives."""
        derived, assumed = (
            tuple(name for name in names if name not in values) for names in (self.derived, self.assumed)
        )
        return replace(self, derived=derived, assumed=assumed, **values)

    def _make_drivable(self, model: ElementTree.Element, name: str, simulator: str) -> LeftOut:
        if simulator == "classic" and model.find("allow_auto_disable") is None:
            ElementTree.SubElement(model, "allow_auto_disable").text = "false"  # it would sleep against a wall
        drive = self.drive if self.read_drive else None
        left_out = make_drivable(model, drive, self.read_drive.plugin if self.read_drive else "", name, simulator)
        if simulator != "classic":
            model.append(ElementTree.fromstring(pose_publisher(simulator)))  # noqa: S314  # ours
        return left_out

    def _placed(self, name: str, at: SdfPose) -> ElementTree.Element:
        model = ElementTree.fromstring(self.text)  # noqa: S314  # was found to be plain elements
        model.set("name", name)
        for pose in model.findall("pose"):
            model.remove(pose)
        pose = ElementTree.Element("pose")
        pose.text = numbers((at[0], at[1], at[2] + self.lift, *at[3:]))
        model.insert(0, pose)
        return model


def is_robot_file(what: object) -> bool:
    """Return whether this is a path, or a text that ends as the name of a robot's file does."""
    return isinstance(what, os.PathLike) or (isinstance(what, str) and what.endswith(_SUFFIXES))


def from_file(path: str | os.PathLike[str], wheels: str | None = None) -> SdfRobot:
    """Return the robot of the one model in an SDF, URDF or Xacro file; FileError if the file has anything else.

    wheels: the joints of its wheels as LEFT,RIGHT, several of a side joined by +, for a model without a drive that is
    known.
    """
    return parsed(text_of(Path(path), MAX_MIB, "a robot"), str(path), wheels)


def parsed(text: str, where: str, wheels: str | None = None) -> SdfRobot:
    """Return the one model in a text; a document type and entities are refused, as bombs are made of them."""
    root = elements(text, where)
    if is_xacro(root, where):
        root = elements(expanded(text, where), where)
    root, left_out = converted(root, where) if root.tag == "robot" else (root, ())
    model = _model(root, where)
    resolve_uris(model, Path(where))
    version = _version(root)
    _modernize(model, version)
    # Places and shapes come first: what the drive's plug-in does not say is measured on them.
    frames = ModelFrames(model, where)
    shapes = extents(frames)
    inertials(frames)  # an error for a mass that no simulator takes
    drive = named_wheels(wheels, frames, shapes) if wheels else find_drive(model, frames, shapes)
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
        remarks=tuple(_remarks(left_out, impossible_inertias(frames))),
    )


def _remarks(left_out: Sequence[str], impossible: Sequence[str]) -> Iterator[str]:
    """Yield a sentence about links that have no mass, and about those whose moments of inertia no body has."""
    if left_out:
        yield f"left out, as they have no mass, or hang on such a link: {_some(left_out)}"
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
    """Return what was taken from its file, and what was assumed."""
    read_drive, phrases = robot.read_drive, []
    if read_drive:
        origin = read_drive.plugin or "the given wheels"
        what = "wheels" if isinstance(read_drive.drive, Wheels) else "tracks"
        sizes = f"{read_drive.drive.separation:.4g} m apart, radius {read_drive.drive.radius:.4g} m"
        phrases.append(f"its drive is read from {origin}, with {what} {sizes}, by {read_drive.sizes}")
    values = {
        "size": f"size {' x '.join(f'{side:.3f}' for side in robot.size)} m around its origin",
        "speed": f"speed {robot.speed:g} m/s",
        "turn": f"turn rate {robot.turn:g} rad/s",
    }
    for origin, names in (("its model", robot.derived), ("assumption", robot.assumed)):
        if names:
            phrases.append(", ".join(values[name] for name in names) + f" by {origin}")
    return "; ".join(phrases)


def _no_drive(robot: SdfRobot) -> str:
    joints = _some(robot.joints)
    wheels = f"name its wheels' joints with --wheels LEFT,RIGHT ({joints})" if joints else "it has no joint that turns"
    return f"no drive that rsegen knows ({', '.join(KNOWN)}); {wheels}"


def _outer(model: ElementTree.Element) -> str:
    model.tail = "\n"
    return ElementTree.tostring(model, encoding="unicode")


class LeftOut(NamedTuple):
    """The files of the plug-ins, and the names of the sensors, that were taken out of a model."""

    plugins: tuple[str, ...]
    sensors: tuple[str, ...]


def make_drivable(model: Element, drive: Drive | None, own: str, name: str, backend: str) -> LeftOut:
    """Give a model a drive of the simulator's own in place of all that it has; what else was taken out of it.

    own: the key of the plug-in that the drive was read from; if it is the simulator's, the plug-in is kept, with its
    limits of acceleration. ROS's plug-ins are taken out where their library is not in a folder of LD_LIBRARY_PATH or
    of the simulator's plug-ins.
    """
    kept = [
        plugin for plugin in model.iter("plugin") if _is_own_drive(plugin_key(plugin.get("filename", "")), own, backend)
    ]
    left_out = _leave_out(model, backend)
    for plugin in kept:
        for topic in plugin.findall("topic"):
            plugin.remove(topic)
        if plugin_key(plugin.get("filename", "")) == own:
            SubElement(plugin, "topic").text = f"/model/{name}/cmd_vel"
    if drive and not kept:
        kept = list(fromstring(f"<model>{drive.plugins(backend)}</model>"))  # noqa: S314  # ours
    model.extend(kept)
    _respell(model, backend)
    return left_out


def _is_own_drive(key: str, own: str, backend: str) -> bool:
    """Return whether a plug-in is the drive that was read, and the simulator has it.

    Fortress has no mecanum drive in all of its versions; there its wheels are driven as others are.
    """
    missing = ("classic",) if own != "gz-sim-mecanum-drive-system" else ("classic", "fortress")
    return backend not in missing and own.startswith("gz-sim-") and key in (own, _TRACK_CONTROLLER)


def _leave_out(model: Element, backend: str) -> LeftOut:
    """Take out what a drive cannot use, and return its names; drives are not counted, as another takes their place.

    Sensors move nothing and need a screen or time: the rays of a lidar against a mesh cost more than the robot.
    """
    names = tuple(_without(model, "sensor", lambda _: True, "name"))
    if backend != "classic":
        list(_without(model, "script", lambda _: True, "name"))  # colours of Classic's, which later versions refuse
    files = _without(model, "plugin", lambda plugin: not _is_loadable(plugin.get("filename", ""), backend), "filename")
    return LeftOut(
        tuple(dict.fromkeys(file for file in files if plugin_key(file) not in (*KNOWN, _TRACK_CONTROLLER))), names
    )


def _respell(model: Element, backend: str) -> None:
    """Rename the systems of Gazebo Sim in a model as its version does: ignition-gazebo-... up to Fortress."""
    file, space = prefixes(backend)
    for plugin in model.iter("plugin"):
        key = plugin_key(plugin.get("filename", ""))
        if key.startswith("gz-sim-"):
            plugin.set("filename", file + key.removeprefix("gz-sim"))
            plugin.set("name", f"{space}::systems::{plugin.get('name', '').rpartition('::')[2]}")


def _is_loadable(file: str, backend: str) -> bool:
    key = plugin_key(file)
    if key in (*KNOWN, _TRACK_CONTROLLER):
        return False
    if key.startswith("gz-sim-"):
        return backend != "classic"
    if _ROS.search(key):
        return _is_installed(file)
    return backend == "classic" or not key.endswith("Plugin")


def _is_installed(file: str) -> bool:
    folders = [folder for variable in _LIBRARIES for folder in os.environ.get(variable, "").split(os.pathsep)]
    names = {file, file if file.startswith("lib") else f"lib{file}.so"}
    return any(Path(folder, name).is_file() for folder in folders if folder for name in names)


def _without(model: Element, tag: str, is_out: Callable[[Element], bool], attribute: str) -> Iterator[str]:
    """Take elements of a tag out, wherever they are, and give an attribute of each."""
    for parent in list(model.iter()):
        for element in parent.findall(tag):
            if is_out(element):
                parent.remove(element)
                yield element.get(attribute, "")
