"""Find the drive of a model: by a plug-in, by what ROS controls, or by the shapes of its wheels.

A plug-in, of a simulator or of ROS, names joints (wheels) or links (tracks), and perhaps separation, radius and limits;
what it does not say is measured on the collision shapes. Left and right follow from the places of the joints, as Gazebo
Classic's plug-ins call left what is right. Without a known plug-in, wheels are those of a controller of ROS, else the
joints that take a velocity, else what looks like wheels; or the user names wheels or tracks. What breaks it:
shapes of unknown size, wheels that are steered (docs/robots.md).
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import replace
from typing import NamedTuple
from xml.etree.ElementTree import Element

import numpy as np

from rsegen.errors import ParameterError, UnknownName, shown
from rsegen.field.crossing import SPEED, TURN
from rsegen.params.sorts import Float
from rsegen.robots.base import refuse_outside
from rsegen.robots.drives import Drive, Tracks, Wheels
from rsegen.robots.files.controllers import Controller, Controls
from rsegen.robots.files.sdf_shapes import ModelFrames, positive_number
from rsegen.robots.files.wheel_joints import TURNING, is_along_y, large_wheels, rolling_joints, steered_wheels

DEFAULT_SPEED: float = 0.2
DEFAULT_TURN: float = 0.5
"""Speed, m/s, and turn rate, rad/s, of a robot whose model gives no limits: slow enough for all; notes report them."""

KNOWN = {
    "gazebo_ros_diff_drive": "wheels",
    "gazebo_ros_skid_steer_drive": "wheels",
    "gazebo_ros_kobuki": "wheels",
    "DiffDrivePlugin": "wheels",
    "SkidSteerDrivePlugin": "wheels",
    "WheelTrackedVehiclePlugin": "wheels",
    "SimpleTrackedVehiclePlugin": "tracks",
    "gz-sim-diff-drive-system": "wheels",
    "gz-sim-mecanum-drive-system": "wheels",
    "gz-sim-tracked-vehicle-system": "tracks",
}
"""Plug-ins of drives that are read, without lib and .so, and how they say what they drive."""

_SIDES = ("left", "right")
_JOINTS = ("{}_joint", "{}Joint", "{}_front", "{}FrontJoint", "front_{}_joint", "{}_front_joint", "{}_wheel_joint_name")
_REAR = ("{}_rear", "{}RearJoint", "back_{}_joint", "{}_rear_joint")
"""Tags of the joints of a side in plug-ins; those before name front joints, these rear ones."""

TRACK_CONTROLLER = "gz-sim-track-controller-system"
"""The plug-in of Gazebo Sim that moves a single track, for one that drives tracks."""

_TORQUES = ("max_wheel_torque", "wheelTorque", "wheel_torque", "torque")
"""Names of the torque of a wheel's motor, Nm, in plug-ins of Gazebo Classic and of ROS."""

_AS_FAR = 0.05
"""Share of the distance of the wheels by which a separation may differ without a word."""

_AGREES = 0.01
"""Share of a wheel's measured radius by which that of a plug-in may differ; beyond it the measured one counts."""


class ReadDrive(NamedTuple):
    """A drive as it was read from a model.

    plugin: its plug-in, by its key in KNOWN, empty for none; origin: what says which its wheels or tracks are, in
    words; separation_by, radius_by: the origins of these sizes; limits: of the speed and the turn rate, None if
    unknown, and limits_by their origin; turned: wheels whose axes point to the right: they are turned to the left for
    a drive
    """

    plugin: str
    drive: Drive
    origin: str
    separation_by: str
    radius_by: str
    limits: tuple[float | None, float | None] = (None, None)
    limits_by: str = "its plug-in"
    turned: tuple[str, ...] = ()

    @property
    def sizes_in_words(self) -> str:
        """Separation and radius with their origins, which are one in most files."""
        drive = self.drive
        skid = f", times {drive.slip:g} as they skid" if isinstance(drive, Wheels) and drive.slip != 1 else ""
        apart, radius = f"{drive.separation:.4g} m apart{skid}", f"radius {drive.radius:.4g} m by {self.radius_by}"
        return (
            f"{apart}, {radius}"
            if self.separation_by == self.radius_by
            else f"{apart} by {self.separation_by}, {radius}"
        )


def plugin_key(file: str) -> str:
    """Return the name of a plug-in's file as in KNOWN: without lib and .so, and Fortress's as later ones."""
    name = file.strip().rpartition("/")[2].removeprefix("lib").removesuffix(".so")
    return re.sub(r"^(gz-sim|ignition-gazebo)\d*-", "gz-sim-", name)


def find_drive(model: Element, frames: ModelFrames, ros: Controls) -> ReadDrive | None:
    """Return the drive of a model; None if it has none that is known, nor wheels."""
    if drive := _plugged(model, frames):
        return drive
    # Without a plug-in: controllers of ROS, whose joints may be left out as their links have no mass, ...
    whole = [
        controller
        for controller in ros.controllers
        if all(joint in frames.joints and is_along_y(joint, frames) for joint in (*controller.left, *controller.right))
    ]
    controlled = rolling_joints((joint for joint in ros.rates if joint in frames.joints), frames)
    fitting = _fitting(whole, large_wheels(controlled, frames), frames)
    for controller in sorted(fitting, key=lambda controller: _misfit(controller, frames)):
        if drive := _of_wheels(controller, frames, ros):
            return drive
    if steered_wheels(frames, ros):
        return None
    # ... then joints that take a velocity, then whatever looks like wheels.
    drive = _paired(controlled, frames, ros.rated_by, ros) or _by_shapes(frames)
    return drive and drive._replace(origin=f"{drive.origin}{_of_others(whole) if not fitting else ''}")


_NEAR = 0.05
"""Share of a wheel's radius by which the radius in a controller's file may differ, if there are several files."""


def _fitting(controllers: Sequence[Controller], wheels: Iterable[str], frames: ModelFrames) -> list[Controller]:
    """Return the controllers that may belong to a robot; of several files, only with its radius and all its wheels.

    A package may have files for several robots whose joints are called alike.
    wheels: those that take a velocity
    """
    if len({controller.where for controller in controllers}) < 2:
        return list(controllers)

    def fits(controller: Controller) -> bool:
        own = _radius(controller.left, frames)
        is_near = not controller.radius or not own or abs(controller.radius / own - 1) <= _NEAR
        return is_near and {*wheels} <= {*controller.left, *controller.right}

    return [controller for controller in controllers if fits(controller)]


def _of_others(controllers: Sequence[Controller]) -> str:
    """Return that files of controllers are not used, in words; an empty text for none."""
    files = list(dict.fromkeys(controller.where for controller in controllers))
    return f"; not by {', '.join(files)}, which have other wheels" if files else ""


def _misfit(controller: Controller, frames: ModelFrames) -> float:
    """Return by which shares the sizes of a controller differ from its wheels' sizes, added up; 0 if they agree.

    A robot with one of several wheels has a file for each in its package.
    """
    left, right = (_middle(frames.child(side[0]), frames)[1] for side in (controller.left, controller.right))
    sizes = (
        (controller.radius, _radius(controller.left, frames), _AGREES),
        (controller.separation, float(abs(left - right)), _AS_FAR),
    )
    shares = [(abs(stated / own - 1), near) for stated, own, near in sizes if stated and own]
    return sum(share for share, near in shares if share > near)


def _plugged(model: Element, frames: ModelFrames) -> ReadDrive | None:
    """Return the drive of the first plug-in that is known and names what it drives."""
    merged = _drive_plugins(model, frames)
    readers = {"wheels": _wheels, "tracks": _tracks}
    read = ((key, readers[KNOWN[key]](plugin, frames)) for key, plugin in merged.items() if key in KNOWN)
    drives = (drive._replace(plugin=key, origin=key) for key, drive in read if drive)
    controllers = merged.get(TRACK_CONTROLLER)
    return next(drives, None) or (None if controllers is None else _track_controllers(controllers, frames))


def _drive_plugins(model: Element, frames: ModelFrames) -> dict[str, Element]:
    """Return the plug-ins of a model that drive it, by their keys.

    Classic's DiffDrive knows one pair of wheels, so a model may have several: plug-ins of one kind are one drive.
    """
    merged: dict[str, Element] = {}
    for plugin in _plugins(model, frames):
        key = plugin_key(plugin.get("filename", ""))
        if key in (*KNOWN, TRACK_CONTROLLER):
            merged.setdefault(key, Element("plugin")).extend(list(plugin))
    return merged


def _plugins(model: Element, frames: ModelFrames, scope: str = "") -> Iterator[Element]:
    """Yield the plug-ins of a model and its nested models; names in them become names in the whole model."""
    for plugin in model.findall("plugin"):
        copy = deepcopy(plugin)
        for element in copy.iter() if scope else ():
            inner = f"{scope}{(element.text or '').strip()}"
            if inner in frames.joints or inner in frames.elements:
                element.text = inner
        yield copy
    for nested in model.findall("model"):
        yield from _plugins(nested, frames, f"{scope}{nested.get('name', '')}::")


def named_wheels(text: str, frames: ModelFrames, ros: Controls) -> ReadDrive:
    """Return the drive of wheels whose joints the user names: LEFT,RIGHT; several of a side joined by +."""
    left, right = _sides(text, "wheels", "joint", frames.joints)
    if len(left) != len(right):
        raise ParameterError("wheels", f"{shown(text)} is not LEFT,RIGHT or FRONT+REAR,FRONT+REAR, joints of wheels")
    if not all(is_along_y(joint, frames) for joint in (*left, *right)):
        raise ParameterError("wheels", f"{text}: their axes are not all along y")
    drive = _of_wheels(Controller("their names", left, right), frames, ros)
    if drive is None:
        problem = "their places or shapes are unknown; a wheel needs a collision shape such as a cylinder or sphere"
        raise ParameterError("wheels", f"{text}: {problem}")
    return drive


def named_tracks(text: str, frames: ModelFrames) -> ReadDrive:
    """Return the drive of tracks whose links the user names: LEFT,RIGHT; a side's flippers joined to it by +."""
    left, right = _sides(text, "tracks", "link", dict(frames.links()))
    drive = _tracked(Element("plugin"), left, right, frames)
    if drive is None or not drive.drive.separation:
        raise ParameterError("tracks", f"{text}: their shapes are unknown, or in one place")
    return drive._replace(origin="their names")


def _sides(text: str, what: str, of: str, known: Mapping[str, object]) -> list[list[str]]:
    """Return the names of the two sides in LEFT,RIGHT or FRONT+REAR,FRONT+REAR; an error for one that is unknown."""
    sides = [side.split("+") for side in text.split(",")]
    if len(sides) != 2 or not all(name for side in sides for name in side):
        raise ParameterError(what, f"{shown(text)} is not LEFT,RIGHT or FRONT+REAR,FRONT+REAR, {of}s of {what}")
    for name in (name for side in sides for name in side):
        if name not in known:
            raise UnknownName.among(what, of, name, known)
    return sides


def _by_shapes(frames: ModelFrames) -> ReadDrive | None:
    """Return the drive of what looks like wheels: round, on the ground, on endless joints across, and not swivelling.

    Casters that do not swivel look the same, unless they are smaller.
    """
    if not frames.shapes.whole:
        return None
    wheels = large_wheels(rolling_joints(frames.joints, frames), frames)
    return _paired(list(wheels), frames, "the shapes of its links, as its file does not say", Controls())


def _paired(wheels: Sequence[str], frames: ModelFrames, origin: str, ros: Controls) -> ReadDrive | None:
    """Return the drive of wheels on two sides, as many on either; those in the middle are casters."""
    middles = {joint: _middle(frames.child(joint), frames) for joint in wheels}
    if not middles:
        return None
    # A wheel is on a side if it is beyond half of the way from the middle to the outermost one.
    ys = [middle[1] for middle in middles.values()]
    centre, half = (min(ys) + max(ys)) / 2, (max(ys) - min(ys)) / 2
    from_front = sorted(wheels, key=lambda joint: -middles[joint][0])
    left = [joint for joint in from_front if middles[joint][1] - centre > half / 2]
    right = [joint for joint in from_front if centre - middles[joint][1] > half / 2]
    paired = left and len(left) == len(right)
    return _of_wheels(Controller(origin, left, right), frames, ros) if paired else None


def _of_wheels(controller: Controller, frames: ModelFrames, ros: Controls) -> ReadDrive | None:
    """Return the drive of wheels on joints along y; a missing size is measured; None if that is impossible.

    ros: has the limits of joints, rad/s, for a speed that is not said; else those of the joints themselves
    """
    # Left is known by the places of the joints: Classic calls left what is right.
    first, second = (_middle(frames.child(side[0]), frames)[1] for side in (controller.left, controller.right))
    left, right = (controller.right, controller.left) if first < second else (controller.left, controller.right)
    apart, measured = float(abs(first - second)), _radius(left, frames)
    separation = controller.separation or apart
    radius = controller.radius or measured
    if not separation or not radius:
        return None
    separation_by = controller.where if controller.separation else _MEASURED
    radius_by = controller.where if controller.radius else _MEASURED
    if measured and abs(radius - measured) > _AGREES * measured:
        # With a controller's figure the robot would drive at another speed than commanded.
        radius_by = f"{_MEASURED}, not {radius:.4g} m by {controller.where}"
        radius = measured
    if abs(separation - apart) > _AS_FAR * apart:  # skidding wheels turn as if they were farther apart
        separation_by += f", although its wheels are {apart:.4g} m apart"
    # Classic's plug-in takes the distance between the joints for the separation.
    joints_apart = float(np.linalg.norm(frames.joint(left[0])[:3, 3] - frames.joint(right[0])[:3, 3]))
    drive = Wheels(
        left=tuple(left),
        right=tuple(right),
        separation=separation,
        radius=radius,
        speed=DEFAULT_SPEED,
        turn=DEFAULT_TURN,
        slip=controller.slip,
        spread=joints_apart / separation if joints_apart else 1,
    )
    limits, limits_by = _limits_of_wheels(controller, drive, frames, ros)
    turned = tuple(joint for joint in (*left, *right) if frames.axis(joint)[1] < 0)
    return ReadDrive("", drive, controller.where, separation_by, radius_by, limits, limits_by, turned)


_MEASURED = "its wheels"
"""The origin of a size that is measured on the collision shapes of wheels."""


def _limits_of_wheels(
    controller: Controller, drive: Wheels, frames: ModelFrames, ros: Controls
) -> tuple[tuple[float | None, float | None], str]:
    """Return the maximum speed and turn rate of wheels, None if unknown, and their origin in words."""
    speed, turn = _limit(SPEED, controller.speed, frames), _limit(TURN, controller.turn, frames)
    # A speed that the controller lacks is the least limit of a wheel times its radius: by ROS, or of the joint itself.
    origins = own_source = [controller.where] if speed or turn else []
    own = [positive_number(frames.joints[joint], frames.where, "axis/limit/velocity") for joint in drive.joints]
    for source, limits in ((ros.rated_by, map(ros.rates.get, drive.joints)), ("its joints", own)):
        if not speed:
            speed = _limit(SPEED, min(filter(None, limits), default=0) * drive.radius, frames)
            origins = [source, *own_source]
    return (speed, turn), " and ".join(origins)


def _wheels(plugin: Element, frames: ModelFrames) -> ReadDrive | None:
    """Return a drive of wheels, which plug-ins of Gazebo and of ROS name by their joints."""
    left, right = _joints(plugin)
    if not left or len(left) != len(right) or not all(_rolls(joint, frames) for joint in (*left, *right)):
        return None
    separation = positive_number(plugin, frames.where, "wheel_separation", "wheelSeparation", "tracks_separation")
    diameter = positive_number(plugin, frames.where, "wheel_diameter", "wheelDiameter")
    radius = positive_number(plugin, frames.where, "wheel_radius", "default_wheel_radius") or (diameter or 0) / 2
    speed, turn = _limits(plugin, frames)
    turn = turn or positive_number(plugin, frames.where, "max_velocity")  # Gazebo Sim limits m/s and rad/s by it
    read = _of_wheels(Controller("its plug-in", left, right, separation, radius, speed, turn), frames, Controls())
    if read is None or not isinstance(read.drive, Wheels):
        return None
    return read._replace(drive=replace(read.drive, torque=positive_number(plugin, frames.where, *_TORQUES)))


def _rolls(joint: str, frames: ModelFrames) -> bool:
    """Return whether the model has a joint of this name, and its axis is across the model."""
    return _type(joint, frames) in TURNING and is_along_y(joint, frames)


def _type(joint: str, frames: ModelFrames) -> str:
    """Return the type of a joint; an empty text for none, as for a fixed one of URDF, whose links become one."""
    return frames.joints[joint].get("type", "") if joint in frames.joints else ""


def _joints(plugin: Element) -> tuple[list[str], list[str]]:
    """Return the joints of wheels that a plug-in names, the left and the right ones."""
    left, right = (_named(plugin, [tag.format(side) for tag in (*_JOINTS, *_REAR)]) for side in _SIDES)
    return left, right


def plugin_problem(model: Element, frames: ModelFrames, read: ReadDrive | None) -> str:
    """Return a sentence if a plug-in of a drive is not used, or drives another way than its maker's; else an empty one.

    It names what the model has not, as it was changed or left out, or what does not turn about an axis across it.
    """
    if read and read.plugin:  # its plug-in is used, but perhaps turned
        return _TURNED.format(", ".join(read.turned)) if read.turned else ""
    plugins = _drive_plugins(model, frames)
    joints = _of_all(side for plugin in plugins.values() for side in _joints(plugin))
    links = _of_all(side for plugin in plugins.values() for side in _belts(plugin))
    for names, problem in (
        ([joint for joint in joints if _type(joint, frames) not in TURNING], _STIFF),
        ([joint for joint in joints if not _rolls(joint, frames)], _ACROSS),
        ([link for link in links if link not in frames.elements], "its plug-in names links that it has not: {}"),
    ):
        if names:
            return problem.format(", ".join(names))
    return ""


_TURNED = (
    "the axes of {} point to the right, so its plug-in turns these wheels backwards; here all wheels drive it forward,"
    " along x"
)
_STIFF = "its plug-in names joints that it has not, or that do not turn: {}"
_ACROSS = "the wheels of its plug-in do not turn about axes along y, as those of robots whose front is along x: {}"


def _of_all(sides: Iterable[Sequence[str]]) -> list[str]:
    return list(dict.fromkeys(name for side in sides for name in side))


def _belts(plugin: Element) -> tuple[list[str], list[str]]:
    """Return the links of tracks that a plug-in names, the left and the right ones, main tracks first."""
    tags = ("{}_track", "{}_track/link", "{}_flipper")
    left, right = (list(filter(None, _named(plugin, [tag.format(side) for tag in tags]))) for side in _SIDES)
    return left, right


def _tracks(plugin: Element, frames: ModelFrames) -> ReadDrive | None:
    """Return the drive of Classic's SimpleTrackedVehicle, which names links, or of Sim's TrackedVehicle: <link>s."""
    return _tracked(plugin, *_belts(plugin), frames)


def _track_controllers(plugin: Element, frames: ModelFrames) -> ReadDrive | None:
    """Return the drive of tracks that have a TrackController each; the longest of a side is the main one."""
    # Each plug-in moves one belt and names no side, so the side of a link follows from its place.
    links = [link for link in _named(plugin, ["link"]) if link in frames.elements]
    ys = [float(_middle(link, frames)[1]) for link in links]
    centre = (min(ys, default=0) + max(ys, default=0)) / 2
    longest = sorted(zip(links, ys, strict=True), key=lambda link: -_size(link[0], frames)[0])
    left, right = ([link for link, y in longest if sign * (y - centre) > 0] for sign in (1, -1))
    drive = _tracked(plugin, left, right, frames)
    return drive and drive._replace(origin=TRACK_CONTROLLER)


def controlled_links(plugins: Iterable[Element]) -> set[str]:
    """Return the links of the tracks that have a TrackController among some plug-ins."""
    own = (plugin for plugin in plugins if plugin_key(plugin.get("filename", "")) == TRACK_CONTROLLER)
    return {link for plugin in own for link in _named(plugin, ["link"])}


def named_belts(robot: Element) -> set[str]:
    """Return the links of tracks and flippers that the plug-ins of a robot in URDF name."""
    plugins = list(robot.iter("plugin"))
    tracked = (plugin for plugin in plugins if KNOWN.get(plugin_key(plugin.get("filename", ""))) == "tracks")
    return {*controlled_links(plugins), *(link for plugin in tracked for side in _belts(plugin) for link in side)}


def _size(link: str, frames: ModelFrames) -> list[float]:
    """Return length, width and height of a link's shapes; zeros if one is unknown."""
    shape = frames.shapes.of(link)
    return [0.0] * 3 if shape is None else (shape.high - shape.low).tolist()


def _tracked(plugin: Element, left: Sequence[str], right: Sequence[str], frames: ModelFrames) -> ReadDrive | None:
    """Return the drive of tracks whose links are known; the body is the first link, unless the plug-in names a link.

    In URDF the link that a plug-in names may have become a part of its base_footprint.
    """
    if not left or not right or not {*left, *right} <= frames.elements.keys():
        return None
    body = _text(plugin.find("body"))
    if body not in frames.elements:
        body = next((name for name, _ in frames.links()), "")
    # Left is known by the places of the links, as for wheels; the main track of a side comes first.
    middles = [_middle(link, frames) for link in (left[0], right[0])]
    if middles[0][1] < middles[1][1]:
        left, right = right, left
    # A track of unknown shape counts as 0.2 m high. The friction and the efficiency are SimpleTrackedVehicle's
    # defaults.
    measured = _size(left[0], frames)[2] if frames.shapes.of(left[0]) else 0.2
    separation = positive_number(plugin, frames.where, "tracks_separation")
    height = positive_number(plugin, frames.where, "tracks_height")
    drive = Tracks(
        body=body,
        left=tuple(left),
        right=tuple(right),
        separation=separation or abs(float(middles[0][1] - middles[1][1])),
        radius=(height or measured) / 2,
        speed=DEFAULT_SPEED,
        turn=DEFAULT_TURN,
        mu=positive_number(plugin, frames.where, "track_mu") or 2,
        mu2=positive_number(plugin, frames.where, "track_mu2") or 0.5,
        efficiency=positive_number(plugin, frames.where, "steering_efficiency") or 0.5,
    )
    speed, turn = _limits(plugin, frames)
    limits = _limit(SPEED, speed, frames), _limit(TURN, turn, frames)
    separation_by, radius_by = ("its plug-in" if stated else "its shapes" for stated in (separation, height))
    return ReadDrive("", drive, "", separation_by, radius_by, limits)


def _radius(joints: Sequence[str], frames: ModelFrames) -> float:
    """Return half of the height of the first wheel; 0 if its shape is unknown."""
    return _size(frames.child(joints[0]), frames)[2] / 2


def _middle(link: str, frames: ModelFrames) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Return the middle of a link's shapes, else its origin."""
    shape = frames.shapes.of(link)
    return np.asarray(frames.transform(link)[:3, 3] if shape is None else (shape.low + shape.high) / 2)


def _limits(plugin: Element, frames: ModelFrames) -> tuple[float | None, float | None]:
    """Return the maximum speed and turn rate that a plug-in says."""
    speed = positive_number(plugin, frames.where, "max_linear_velocity", "max_velocity", "max_linear_speed")
    speed = speed or positive_number(plugin, frames.where, "linear_velocity/max_velocity")
    turn = positive_number(
        plugin, frames.where, "max_angular_velocity", "max_angular_speed", "angular_velocity/max_velocity"
    )
    return speed, turn


def _limit(sort: Float, value: float | None, frames: ModelFrames) -> float | None:
    """Return a limit of a model; None for none, as numbers are that no robot reaches: SDF's own is 1e16."""
    if not value or value > sort.high:
        return None
    refuse_outside(sort, value, f"{frames.where}: the limit of a velocity")
    return value


def _named(plugin: Element, tags: Iterable[str]) -> list[str]:
    """Return the texts of elements with these tags, in the order of the tags, each once: files repeat a plug-in."""
    return list(dict.fromkeys(_text(element) for tag in tags for element in plugin.findall(tag)))


def _text(element: Element | None) -> str:
    return "" if element is None else (element.text or "").strip()
