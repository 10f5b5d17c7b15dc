"""A robot from a file of the user, in SDF, URDF, Xacro or MJCF, which is parsed as untrusted input.

The model is kept as text, as SDF whatever it was. Its drive, size and limits are read once; for a world it gets a drive
plug-in of the simulator that runs it, in place of its own or ROS's, and loses its sensors, and the plug-ins that the
simulator lacks. Joints that nothing drives are held (holding.py). URIs of meshes become absolute paths first, as the
world is written elsewhere. Included models become a part of it (includes.py). What breaks it: meshes in packages that
are not found, and what breaks holding.py and includes.py (docs/robots.md).
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, SubElement, fromstring, tostring

import numpy as np

from rsegen.errors import FileError, ParameterError, shown, some_of
from rsegen.field.crossing import SIDE
from rsegen.gazebo.sdf import numbers
from rsegen.input_files import text_of, xml_root
from rsegen.robots.base import WHEEL, refuse_outside
from rsegen.robots.drives import BACKENDS, Drive, PublishCommand, Wheels
from rsegen.robots.files.body import body_of_model
from rsegen.robots.files.controllers import Controls, controls
from rsegen.robots.files.densities import weigh
from rsegen.robots.files.drivable import HELD, hold_and_turn, is_loadable, make_drivable, take_out
from rsegen.robots.files.gazebo_models import fit
from rsegen.robots.files.holding import hold
from rsegen.robots.files.includes import NOT_INCLUDED, Includes
from rsegen.robots.files.meshes import INLINE
from rsegen.robots.files.mimics import mimics
from rsegen.robots.files.mjcf import of_mujoco
from rsegen.robots.files.motors import light_wheels, slippery_wheels, yielding_wheels
from rsegen.robots.files.sdf_drives import (
    DEFAULT_SPEED,
    DEFAULT_TURN,
    ReadDrive,
    find_drive,
    named_belts,
    named_tracks,
    named_wheels,
    plugin_problem,
)
from rsegen.robots.files.sdf_elements import LATEST_OF_CLASSIC
from rsegen.robots.files.sdf_names import refuse_unknown, spell_types, ties_to_world
from rsegen.robots.files.sdf_shapes import (
    Extents,
    ModelFrames,
    hang_on_links,
    impossible_inertias,
    inertials,
    links_by_default,
    swollen_inertias,
    take_out_flat,
)
from rsegen.robots.files.simulator_shapes import use_shapes_of_classic, with_capsules
from rsegen.robots.files.urdf import Converted, converted
from rsegen.robots.files.uris import resolve_uris
from rsegen.robots.files.wheel_joints import TURNING, steered_wheels
from rsegen.robots.files.xacro_files import expanded, is_xacro, with_arguments
from rsegen.robots.links import ORIGIN, SdfPose, Vector
from rsegen.standing.body import Body, body_of_size
from rsegen.standing.kinds import RobotOnField

MAX_ROBOT_MIB = 4
"""The largest file that is read, MiB: a second's work for the parser; robots' files have some tens of kilobytes."""

SUFFIXES = (".sdf", ".urdf", ".xacro", ".xml", ".mjcf")
"""Endings of files that are taken for a robot, in any letters; what is in them says which they are."""

_FIRST_WITH_MIMIC = 11
"""The first version of SDF, 1.11, that has <mimic>, which Gazebo Sim then keeps to."""

NO_MIMIC = "<mimic> has no effect in Gazebo, so these joints move on their own, unless they are held"

_OF_URDF = ("joint/parent[@link]", "link/inertial/mass[@value]")
"""Elements that URDF has, and SDF has not: its own have texts."""


_LARGEST_TURN = 3.0
"""Largest turn rate, rad/s, of a command to Classic's drive, which takes it as an angle below pi."""


@dataclass(frozen=True, kw_only=True, slots=True)
class SdfRobot(RobotOnField):
    """A robot from a file: its name, its <model> as text, its drive, and the origins of its size and limits.

    read_drive: its drive, None if no wheels or tracks are known: then it cannot be driven, and stands
    joints: the joints that could be wheels
    steered, steering: joints of steered wheels, if it has no drive; the joints that steer wheels, also in a drive on
        wheels that the user names
    undriven: why its plug-in is not used, if it has no drive
    size, lift: of a box around its origin that holds its collision shapes; of its origin above the lowest of them; m
    derived, assumed: which of size, speed and turn are from the model, and which are only assumed
    remarks: a sentence each about parts of the file that were left out, changed or are wrong
    """

    kind: str
    text: str
    version: str = "1.6"
    read_drive: ReadDrive | None = None
    joints: tuple[str, ...] = ()
    steered: tuple[str, ...] = ()
    steering: tuple[str, ...] = ()
    undriven: str = ""
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
        return _body_of(self)

    @property
    def body_or_box(self) -> Body:
        """The robot from below; a box of its size if its shapes are unknown, or its size is given."""
        return self.body if "size" in self.derived else body_of_size(*self.size[:2])

    @property
    def drive(self) -> Drive:
        """The drive with its maximum speed and turn rate; ParameterError if none is known."""
        # Steered wheels are known, but turn no robot by a difference of sides; unknown wheels the user may name.
        if self.read_drive is None and self.steered:
            raise ParameterError(
                self.kind,
                f"{some_of(self.steered)} are steered wheels, and rsegen drives robots that turn by a difference"
                " between their sides; to drive it straight ahead with its steering held, name its wheels with"
                " wheels='LEFT,RIGHT'; without them it only stands, with rsegen spawn",
            )
        if self.read_drive is None:
            joints = f" ({some_of(self.joints)})" if self.joints else ""
            nowhere = (
                "no plug-in or actuator that rsegen knows has them, nor ros2_control or a file of a controller, and no"
                " links look like wheels"
            )
            raise ParameterError(
                self.kind,
                f"no wheels or tracks: {self.undriven or nowhere}; name them with tracks='LEFT,RIGHT', or"
                f" wheels='LEFT,RIGHT'{joints}, which rsegen drive and rsegen predict take;"
                " without them it only stands, with rsegen spawn",
            )
        return replace(self.read_drive.drive, speed=self.speed, turn=self.turn)

    def frames(self) -> ModelFrames:
        """Return the links, joints and frames of its model."""
        return ModelFrames(self._model(), self.kind)

    @property
    def held(self) -> tuple[str, ...]:
        """The joints that are held in a drive, as nothing drives them."""
        return self._hold(self._model())

    @property
    def followers(self) -> tuple[str, ...]:
        """The joints that follow another one in a drive, in a simulator that keeps to <mimic>."""
        held = self.held
        return tuple(name for name in mimics(self.frames()) if name not in held)

    @property
    def light_wheels(self) -> str:
        """A sentence if its wheels are too light for Gazebo Classic's drive; an empty one if they are not."""
        drive = self.read_drive.drive if self.read_drive else None
        if not isinstance(drive, Wheels):
            return ""
        return light_wheels(drive, self.frames(), self.driving_speed)

    def model(self, name: str, simulator: str = "classic", at: SdfPose = ORIGIN) -> str:
        """Return its <model> with its lowest point at the height of a pose, driven by the simulator's own plug-in."""
        model = self._placed(name, at)
        self._take_out_mimics(model, simulator)
        self._make_drivable(model, name, simulator)
        self._make_fit(model, simulator, is_for_drive=True)
        return with_capsules(_outer(model), simulator)

    def without_plugins(self, name: str, at: SdfPose = ORIGIN) -> str:
        """Return its <model> with its lowest point at the height of a pose, for a simulator that drives it by itself.

        It has no plug-ins and no sensors; joints that nothing drives are held, and wheels turn about the left.
        """
        model = self._placed(name, at)
        self._hold(model)
        for tag in ("plugin", "sensor"):
            take_out(model, tag)
        return _outer(model)

    def file(self, name: str, simulator: str = "classic") -> str:
        """Return the text of an SDF file of it with its own plug-ins, ROS's too; what has no drive stands still."""
        is_newer = simulator == "classic" and _minor(self.version) > _minor(LATEST_OF_CLASSIC)
        version = LATEST_OF_CLASSIC if is_newer else self.version
        model = self._placed(name, ORIGIN)
        self._take_out_mimics(model, simulator)
        if self._is_undriven(simulator):
            hold(model, None, follows=False)
        self._make_fit(model, simulator)
        return f'<?xml version="1.0"?>\n<sdf version="{version}">\n{with_capsules(_outer(model), simulator)}</sdf>\n'

    def command(self, name: str, v: float, w: float, simulator: str = "classic") -> PublishCommand:
        """Return the command for speed v forward, m/s, and turn rate w, rad/s."""
        drive = self.drive
        # Classic's plug-in takes w / spread as an angle, which has to stay below pi.
        if simulator == "classic" and isinstance(drive, Wheels):
            most = _LARGEST_TURN * drive.spread
            w = max(-most, min(most, w))
        return drive.command(name, v, w, simulator)

    def notes(self, simulator: str) -> Iterator[str]:
        """Yield what was derived from its file, and what was left out of it for a drive, in a sentence each."""
        yield f"{self.kind}: {_derived(self)}"
        yield from (f"{self.kind}: {remark}" for remark in self.remarks)
        yield from self._unled(simulator)
        if simulator == "classic" and (light := self.light_wheels):
            yield f"{self.kind}: {light}"
        if simulator in BACKENDS:
            changes = self._make_drivable(self._model(), self.kind, simulator)
        else:
            changes = {HELD: some_of(self.held)}
        yield from (f"{self.kind}: {why}: {names}" for why, names in changes.items() if names)

    def spawn_notes(self, simulator: str) -> Iterator[str]:
        """Yield what was left out of its file, and whether its joints are held, in a sentence each."""
        yield from (f"{self.kind}: {remark}" for remark in self.remarks)
        yield from self._unled(simulator)
        if self._is_undriven(simulator) and (held := hold(self._model(), None, follows=False)):
            yield f"{self.kind}: has no wheels or tracks, so its joints are held as its model has them: {some_of(held)}"

    def given(self, values: Mapping[str, Any]) -> SdfRobot:
        """Return the robot with the size, speed or turn rate that the user gives."""
        derived, assumed = (
            tuple(name for name in names if name not in values) for names in (self.derived, self.assumed)
        )
        return replace(self, derived=derived, assumed=assumed, **values)

    @property
    def _driven(self) -> ReadDrive | None:
        """The drive as it was read, with the robot's maximum speed and turn rate."""
        return self.read_drive._replace(drive=self.drive) if self.read_drive else None

    def _hold(self, model: Element) -> tuple[str, ...]:
        """Hold the joints of its model that nothing drives, where <mimic> is kept to, and return their names."""
        return hold_and_turn(model, self.kind, self._driven, self.steering, follows=True)

    def _make_drivable(self, model: Element, name: str, backend: str) -> dict[str, str]:
        """Give its model a drive of a Gazebo; return what else was changed, and why."""
        return make_drivable(model, self.kind, self._driven, self.steering, name=name, backend=backend)

    def _is_undriven(self, simulator: str) -> bool:
        """Return whether nothing drives it, nor moves its joints: it then stands as its model has it."""
        if self.read_drive:
            return False
        # A plug-in that the simulator loads may move them, of ROS or its own.
        files = (plugin.get("filename", "") for plugin in self._model().iter("plugin"))
        return not any("control" in file.lower() and is_loadable(file, simulator) for file in files)

    def _take_out_mimics(self, model: Element, simulator: str) -> list[str]:
        """Take <mimic> out of a model unless the simulator reads it there, and return the names of its joints."""
        if simulator == "sim" and _minor(self.version) >= _FIRST_WITH_MIMIC:
            return []
        followers = list(mimics(ModelFrames(model, self.kind)))
        take_out(model, "mimic")
        return followers

    def _unled(self, simulator: str) -> Iterator[str]:
        """Yield a sentence about joints that follow no other one in a simulator, although they should."""
        if simulator in BACKENDS and (unled := self._take_out_mimics(self._model(), simulator)):
            yield f"{self.kind}: {NO_MIMIC}: {some_of(unled)}"

    def _refuse_inline_meshes(self, model: Element) -> None:
        """Take out visuals whose meshes are in the model itself; raise a FileError for such a collision shape."""
        take_out(model, "visual", lambda visual: visual.findtext("geometry/mesh/uri", "").startswith(INLINE))
        if any(uri.startswith(INLINE) for uri in (mesh.findtext("uri", "") for mesh in model.iter("mesh"))):
            raise FileError(
                f"{self.kind}: the mesh of a collision shape has no STL, OBJ or COLLADA file, and Gazebo reads no"
                " other; drive it in MuJoCo"
            )

    def _make_fit(self, model: Element, simulator: str, *, is_for_drive: bool = False) -> None:
        """Write a model as a Gazebo reads it, and drives it; FileError for what it does not read."""
        self._refuse_inline_meshes(model)
        if simulator == "classic":
            use_shapes_of_classic(model, self.kind)
        frames = ModelFrames(model, self.kind)
        driven = self.read_drive.drive.links(frames.child) if self.read_drive else ()
        fit(model, frames, simulator, sorted(driven), is_for_drive=is_for_drive)

    def _model(self) -> Element:
        return fromstring(self.text)  # noqa: S314  # was found to be plain elements

    def _placed(self, name: str, at: SdfPose) -> Element:
        model = self._model()
        model.set("name", name)
        for pose in model.findall("pose"):
            model.remove(pose)
        pose = Element("pose")
        pose.text = numbers((at[0], at[1], at[2] + self.lift, *at[3:]))
        model.insert(0, pose)
        return model


@lru_cache(maxsize=16)
def _body_of(robot: SdfRobot) -> Body:
    """Return the body of a robot; if its drive is unknown, all links on joints that turn count as driving."""
    frames, read = robot.frames(), robot.read_drive
    driven = read.drive.links(frames.child) if read else set(map(frames.child, robot.joints))
    return body_of_model(frames, driven, lift=robot.lift, length=robot.size[0], speed=robot.driving_speed)


def is_robot_file(what: object) -> bool:
    """Return whether this is a path, or a text that ends as the name of a robot's file does, before any arguments."""
    return isinstance(what, os.PathLike) or (
        isinstance(what, str) and with_arguments(what)[0].lower().endswith(SUFFIXES)
    )


def from_file(path: str | os.PathLike[str], wheels: str | None = None, tracks: str | None = None) -> SdfRobot:
    """Return the robot of the one model in an SDF, URDF, Xacro or MJCF file; FileError if the file has anything else.

    path: a text may have arguments of Xacro after it, as in "robot.urdf.xacro laser:=true". wheels: the joints of its
    wheels as LEFT,RIGHT; tracks: the links of its tracks; several of a side joined by +, the flippers of a track after
    it. They are for a model that does not say it, or says it otherwise.
    """
    # Whatever the format is, it becomes one <model> of SDF, whole and with names that are known.
    where, arguments = with_arguments(path) if isinstance(path, str) else (os.fspath(path), {})
    text = text_of(Path(where), MAX_ROBOT_MIB, "a robot")
    root = xml_root(text, where)
    remarks: list[str] = []
    if is_xacro(root, where):
        text, unfound = expanded(text, where, arguments)
        root = xml_root(text, where)
        if root.tag == "robot" and root.find("link") is None:
            raise FileError(f"{where}: has macros and no <link>; use the file of the robot that includes it")
        remarks += [f"left out what it includes of packages that are not found: {some_of(unfound)}"] if unfound else []
    elif arguments:
        raise FileError(f"{where}: {next(iter(arguments))}:= is for a Xacro file, and this one has no macros")
    source, ros = _as_sdf(root, where, *(re.split(r"[,+]", named or "") for named in (wheels, tracks)))
    remarks += ros.remarks
    model, version = _model_and_version(source.sdf, where)
    includes = Includes(_included_model)
    includes.put_into(model, Path(where))
    model.attrib.pop("placement_frame", None)  # rsegen places the model by its origin
    spell_types(model)
    missing = list(includes.missing)
    if model.find(".//link") is None:
        advice = f"; {some_of(missing)} that it includes is not found: {NOT_INCLUDED}" if missing else ""
        raise FileError(f"{where}: the model has no <link>{advice}")
    remarks += [f"left out what it includes and is not found: {some_of(missing)}"] if missing else []
    resolve_uris(model, Path(where))
    if flat := take_out_flat(model, where):
        remarks.append(f"left out, as these collision shapes have no size: {some_of(flat)}")
    # Then places and shapes, and on these the drive: what its plug-in does not say is measured on them.
    frames = ModelFrames(model, where)
    refuse_unknown(frames, is_whole=not missing)
    hang_on_links(frames)
    shapes = frames.shapes
    weighed = weigh(frames)
    inertials(frames)  # an error for a mass that no simulator takes
    mimics(frames)  # and for what is no number
    if wheels:
        drive: ReadDrive | None = named_wheels(wheels, frames, ros)
    else:
        drive = named_tracks(tracks, frames) if tracks else find_drive(model, frames, ros)
    if drive:
        refuse_outside(WHEEL, drive.drive.separation, f"{where}: the separation of its wheels or tracks")
        refuse_outside(WHEEL, drive.drive.radius, f"{where}: the radius of its wheels or tracks")
        remarks += filter(None, [slippery_wheels(drive.drive, frames), yielding_wheels(drive.drive, frames)])
    # Last, sentences about all that a user should know, and the figures of the robot, measured or assumed.
    problem = plugin_problem(model, frames, drive)
    remarks += [problem] if drive and problem else []
    steering = {} if drive and not wheels else steered_wheels(frames, ros)
    turned = set(map(frames.child, drive.drive.joints)) if drive else set[str]()  # a rotor adds to theirs
    size, (speed, turn) = _size(shapes, where), drive.limits if drive else (None, None)
    values = {"size": size, "speed": speed, "turn": turn}
    remarks += [
        sentence.format(some_of(names))
        for names, sentence in (
            (source.left_out, "left out, as they have no mass, or are attached to such a link: {}"),
            (ties_to_world(model) if drive else (), "held in the world in its file by {}, and moves freely in a drive"),
            (weighed, "weighed by the densities of their shapes, as Gazebo Sim does: {}"),
            (source.mimics, "joints that follow another one by more than a multiplier and an offset do not: {}"),
            (impossible_inertias(frames), "no body has the moments of inertia of {}; Gazebo Sim may refuse them"),
            (
                links_by_default(frames),
                "each link without <inertial> weighs 1 kg, with 1 kg m^2, as SDF has it: {}",
            ),
            (swollen_inertias(frames, turned), "the moments of inertia of {} are far more than fit into their shapes"),
        )
        if names
    ]
    return SdfRobot(
        kind=re.sub(r"\W|^(?=\d)", "_", model.get("name", ""), flags=re.ASCII),
        text=_outer(model),
        version=version,
        read_drive=drive,
        joints=tuple(name for name, joint in frames.joints.items() if joint.get("type") in TURNING),
        steered=() if drive else tuple(steering),
        steering=tuple(steering.values()),
        undriven="" if drive else problem,
        size=size or (0.5, 0.5, 0.5),
        speed=speed or DEFAULT_SPEED,
        turn=turn or DEFAULT_TURN,
        lift=-float(shapes.whole.low[2]) if shapes.whole else 0.0,
        derived=tuple(name for name, value in values.items() if value is not None),
        assumed=tuple(name for name, value in values.items() if value is None),
        remarks=tuple(remarks),
    )


def _as_sdf(root: Element, where: str, wheels: Sequence[str], tracks: Sequence[str]) -> tuple[Converted, Controls]:
    """Return a robot of any format as SDF, and what of it has motors by its format or by ROS."""
    if root.tag == "mujoco":
        return of_mujoco(root, where, wheels)
    if root.tag == "robot":
        return converted(root, where, {*tracks, *named_belts(root)}), controls(root, Path(where))
    return Converted(root), Controls()


def _included_model(file: Path) -> Element:
    return _model_and_version(xml_root(text_of(file, MAX_ROBOT_MIB, "a model"), str(file)), str(file))[0]


def _model_and_version(root: Element, where: str) -> tuple[Element, str]:
    """Return the model of an <sdf>, and its version; FileError if it has none, or others."""
    models = root.findall("model")
    includes = root.findall("include")
    if root.tag == "sdf" and not models and len(includes) == 1:  # a file that only names a model
        models = [SubElement(root, "model", name=(includes[0].findtext("name") or Path(where).stem).strip())]
        includes[0].set("merge", "true")
        models[0].append(includes[0])
    if root.find("world") is not None:
        raise FileError(f"{where}: a world; use the SDF file of the robot alone, with one <model> in <sdf>")
    if root.tag != "sdf" or len(models) != 1:
        name = shown(root.tag)[1:-1]
        content = f"there are {len(models)} in <{name}>" if root.tag == "sdf" else f"it begins with <{name}>"
        raise FileError(f"{where}: not an SDF file with one <model> in <sdf>, nor URDF: {content}")
    if not models[0].get("name", "").strip():
        raise FileError(f"{where}: the model has no name; name it, or pass the file of the robot that includes it")
    if any(models[0].find(path) is not None for path in _OF_URDF):
        raise FileError(
            f"{where}: its links and joints are of URDF; put them into <robot name='...'>, in place of <sdf>"
        )
    version = root.get("version", "").strip()
    version = version if re.fullmatch(r"1\.\d\d?", version, flags=re.ASCII) else "1.6"  # for one that there is not
    # Before SDF 1.5 joints' axes are in the model's frame, which a world of a later version has to say.
    for axis in models[0].iter("axis") if _minor(version) < 5 else ():
        if axis.find("use_parent_model_frame") is None:
            SubElement(axis, "use_parent_model_frame").text = "true"
    return models[0], version


def _minor(version: str) -> int:
    return int(version.partition(".")[2])


def _size(shapes: Extents, where: str) -> Vector | None:
    """Return the size of a box around the origin that holds all collision shapes; None if one is unknown."""
    if not shapes.whole:
        return None
    low, high = shapes.whole
    sides = (*(2 * np.maximum(np.abs(low), np.abs(high))[:2]), high[2] - low[2])
    x, y, z = (float(np.maximum(side, SIDE.low)) for side in sides)
    for side in (x, y, z):
        refuse_outside(SIDE, side, f"{where}: the box around its collision shapes, {x:.4g} x {y:.4g} x {z:.4g} m")
    return None if shapes.unknown else (x, y, z)


def _derived(robot: SdfRobot) -> str:
    """Return what was taken from its file or from those around it, and what was assumed."""
    read, phrases = robot.read_drive, []
    limits_by = read.limits_by if read else "its model"
    if read:
        parts = "wheels" if isinstance(read.drive, Wheels) else "tracks"
        sides = ",".join(read.drive.side_names)
        phrases.append(f"its {parts} are {sides} by {read.origin}, {read.sizes_in_words}")
    values = {
        "size": f"size {' x '.join(f'{side:.3f}' for side in robot.size)} m around its origin",
        "speed": f"speed {robot.speed:.4g} m/s",
        "turn": f"turn rate {robot.turn:.4g} rad/s",
    }
    # Values of one origin share a phrase; those that the user gave are in none.
    origins = {"size": "its model", "speed": limits_by, "turn": limits_by}
    origins |= dict.fromkeys(robot.assumed, "assumption")
    for origin in dict.fromkeys(origins.values()):
        names = [name for name in (*robot.derived, *robot.assumed) if origins[name] == origin]
        phrases += [", ".join(values[name] for name in names) + f" by {origin}"] if names else []
    return "; ".join(phrases)


def _outer(model: Element) -> str:
    model.tail = "\n"
    return tostring(model, encoding="unicode")
