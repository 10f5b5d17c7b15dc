"""Changes of a robot's model for a drive: it gets a drive of the simulator's own, and loses what moves nothing."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Collection
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, fromstring

from rsegen.errors import some_of
from rsegen.gazebo.sdf import numbers
from rsegen.geometry.poses import angles, rotation
from rsegen.robots.drives import Drive, Tracks, Wheels, pose_publisher, prefixes
from rsegen.robots.files.holding import hold, turn_to_the_left
from rsegen.robots.files.motors import motor
from rsegen.robots.files.sdf_drives import (
    KNOWN,
    TRACK_CONTROLLER,
    ReadDrive,
    controlled_links,
    plugin_key,
)
from rsegen.robots.files.sdf_elements import numbers_text, put
from rsegen.robots.files.sdf_names import let_go
from rsegen.robots.files.sdf_shapes import ModelFrames, floats, positive_number

_LIBRARIES = ("GAZEBO_PLUGIN_PATH", "GZ_SIM_SYSTEM_PLUGIN_PATH", "IGN_GAZEBO_SYSTEM_PLUGIN_PATH", "LD_LIBRARY_PATH")
"""Variables that list the folders of plug-ins."""


def make_drivable(  # as `hold_and_turn`, and what a simulator needs
    model: Element, where: str, read: ReadDrive | None, steering: Collection[str], *, name: str, backend: str
) -> dict[str, str]:
    """Give a model a drive of the simulator's own in place of its drives; return what else was changed, and why.

    If the plug-in of the drive that was read is the simulator's, it is kept, with its limits of acceleration, and gets
    the sides, the separation and the radius that were read; a plug-in of tracks is kept with its controllers of belts,
    which rsegen commands itself (`Tracks.belt_commands`). ROS's plug-ins are taken out where their library is not in a
    folder of LD_LIBRARY_PATH or of the simulator's plug-ins.
    """
    drive, own = (read.drive, read.plugin) if read else (None, "")
    # First what the drive of this simulator needs of the model's joints, then what of its plug-ins is kept.
    if backend == "classic":
        if model.find("allow_auto_disable") is None:
            SubElement(model, "allow_auto_disable").text = "false"  # it would sleep against a wall
        _free_wheels(model, where, drive)
    held = hold_and_turn(model, where, read, steering, follows=False)
    # Fortress has no mecanum drive in all of its versions; there its wheels are driven as others are.
    missing = ("classic", "fortress") if own == "gz-sim-mecanum-drive-system" else ("classic",)
    keys = (own, TRACK_CONTROLLER) if own.startswith("gz-sim-") and backend not in missing else ()
    drive_plugins = [plugin for plugin in model.findall("plugin") if plugin_key(plugin.get("filename", "")) in keys]
    plugins, sensors, visuals = _leave_out(model, backend)
    for plugin in drive_plugins:
        # The maker's topics go: belts are commanded on their default ones, and the drive on the one that is set here.
        for topic in [element for tag in _TOPICS for element in plugin.findall(tag)]:
            plugin.remove(topic)
        if plugin_key(plugin.get("filename", "")) == own:
            SubElement(plugin, "topic").text = f"/model/{name}/cmd_vel"
            _put_drive(plugin, drive)
    # A plug-in of tracks moves nothing without the controller of each belt, so the drive is then made anew.
    if isinstance(drive, Tracks) and not controlled_links(drive_plugins).issuperset((*drive.left, *drive.right)):
        drive_plugins = []
    if drive and not drive_plugins:
        drive_plugins = list(fromstring(f"<model>{drive.plugins(backend)}</model>"))  # noqa: S314  # ours
    publisher = [] if backend == "classic" else [fromstring(pose_publisher(backend))]  # noqa: S314  # ours
    model.extend([*drive_plugins, *publisher])
    _align_belts(model, where)
    _respell(model, backend)
    return {
        HELD: some_of(held),
        "left out for the drive, as they are not here": ", ".join(plugins),
        "left out for the drive, as their meshes are not found": ", ".join(visuals),
        "left out for the drive, as sensors move nothing": ", ".join(sensors),
    }


def _put_drive(plugin: Element, drive: Drive | None) -> None:
    """Put what was read of wheels into their plug-in: which are left, their separation and their radius.

    Without them it takes a separation of 1 m and a radius of 0.2 m, and with others it drives or turns at another rate.
    """
    if not isinstance(drive, Wheels):
        return
    # Sides count by their places (sdf_drives.py): a plug-in that calls them the other way gets its tags swapped.
    right = {(part.text or "").strip() for part in plugin if re.search("right.*joint", part.tag)}
    if right and right <= {*drive.left}:
        mirrored = {"left": "right", "right": "left"}
        for part in plugin:
            part.tag = re.sub("left|right", lambda side: mirrored[side[0]], part.tag)
    for tag, value in (("wheel_separation", drive.separation * drive.slip), ("wheel_radius", drive.radius)):
        for part in plugin.findall(tag):
            plugin.remove(part)
        put(plugin, tag, numbers([value]))


def _align_belts(model: Element, where: str) -> None:
    """Make the belts of Gazebo Sim move along x of the model, wherever the y of their links points.

    Its TrackController moves a belt across the y of the link, as <track_orientation> turns it, so a right track that is
    mirrored by half a turn would move backwards.
    """
    plugins = [
        plugin for plugin in model.findall("plugin") if plugin_key(plugin.get("filename", "")) == TRACK_CONTROLLER
    ]
    frames = ModelFrames(model, where) if plugins else None
    for plugin in plugins:
        link = next(iter(controlled_links([plugin])), "")
        if frames is None or link not in frames.elements:
            continue
        turned = frames.transform(link)[:3, :3]
        own = rotation(*floats(plugin.findtext("track_orientation") or "0 0 0", 3, where))
        if (turned @ own)[1, 1] < _ALONG_Y:
            for part in plugin.findall("track_orientation"):
                plugin.remove(part)
            put(plugin, "track_orientation", numbers_text(angles(turned.T)))


_ALONG_Y = 0.99
"""Cosine of the angle between the y axes of a belt and of the model at least."""


_TOPICS = ("topic", "velocity_topic", "center_of_rotation_topic")
"""Elements of plug-ins with the topics on which they take commands, other than the default ones."""


def _free_wheels(model: Element, where: str, drive: Drive | None) -> None:
    """Take from driven wheels the damping and friction of their joints where their motors overcome it.

    Classic's drive has no torque, so these would brake a robot on level ground, which they do neither with motors nor
    with the plug-in of its maker.
    """
    if not isinstance(drive, Wheels):
        return
    frames = ModelFrames(model, where)
    for name in drive.joints:
        rubs = positive_number(frames.joints[name], where, "axis/dynamics/friction") or 0.0
        if motor(drive, name, frames).overcomes(rubs):
            for dynamics in frames.joints[name].findall("axis/dynamics"):
                for element in [*dynamics.findall("damping"), *dynamics.findall("friction")]:
                    dynamics.remove(element)


HELD = "held as its model has them, as nothing drives them"
"""The reason why joints are held in a drive."""


def hold_and_turn(
    model: Element, where: str, read: ReadDrive | None, steering: Collection[str], *, follows: bool
) -> tuple[str, ...]:
    """Hold the joints that nothing drives, and return their names; turn the axes of wheels to the left.

    What holds a model with a drive in the world lets go of it.
    where: begins errors; steering, follows: as of `hold`
    """
    if read:
        let_go(model)
    held = hold(model, read.drive if read else None, follows=follows, steering=steering)
    turn_to_the_left(model, where, read.turned if read else ())
    return held


def take_out(model: Element, tag: str, is_out: Callable[[Element], bool] = lambda _: True) -> list[Element]:
    """Take elements of a tag out of a model, wherever they are, and return them."""
    out = [(parent, element) for parent in model.iter() for element in parent.findall(tag) if is_out(element)]
    for parent, element in out:
        parent.remove(element)
    return [element for _, element in out]


def _leave_out(model: Element, backend: str) -> tuple[tuple[str, ...], ...]:
    """Take out what a drive cannot use: the files of plug-ins but for drives, and the names of sensors and visuals.

    Sensors move nothing and need a screen or time: the rays of a lidar against a mesh cost more than the robot. Gazebo
    Sim does not load a world with a mesh that it does not find, although nobody sees it.
    """

    def without(tag: str, attribute: str, is_out: Callable[[Element], bool] = lambda _: True) -> tuple[str, ...]:
        """Take elements of a tag out, and return an attribute of each."""
        return tuple(element.get(attribute, "") for element in take_out(model, tag, is_out))

    def lacks_its_mesh(visual: Element) -> bool:  # URIs that were found are absolute paths (`resolve_uris`)
        uri = (visual.findtext("geometry/mesh/uri") or "/").strip()
        return not uri.removeprefix("file://").startswith("/")

    sensors, visuals = without("sensor", "name"), without("visual", "name", lacks_its_mesh)
    if backend != "classic":
        without("script", "name")  # colours of Classic's, which later versions refuse
    files = without("plugin", "filename", lambda plugin: not is_loadable(plugin.get("filename", ""), backend))
    plugins = tuple(dict.fromkeys(file for file in files if plugin_key(file) not in (*KNOWN, TRACK_CONTROLLER)))
    return plugins, sensors, visuals


def _respell(model: Element, backend: str) -> None:
    """Rename the systems of Gazebo Sim in a model as its version does: ignition-gazebo-... up to Fortress."""
    file, space = prefixes(backend)
    for plugin in model.iter("plugin"):
        key = plugin_key(plugin.get("filename", ""))
        if key.startswith("gz-sim-"):
            plugin.set("filename", file + key.removeprefix("gz-sim"))
            plugin.set("name", f"{space}::systems::{plugin.get('name', '').rpartition('::')[2]}")


def is_loadable(file: str, backend: str) -> bool:
    """Return whether a simulator finds the file of a plug-in that is none of a drive."""
    key = plugin_key(file)
    if key in (*KNOWN, TRACK_CONTROLLER):
        return False
    if key.startswith("gz-sim-"):
        return backend != "classic"
    # Classic's own are called so; one of a robot's manufacturer, or of ROS, is in a folder of plug-ins, or not here.
    folders = [folder for variable in _LIBRARIES for folder in os.environ.get(variable, "").split(os.pathsep)]
    names = {file, file if file.startswith("lib") else f"lib{file}.so"}
    is_installed = any(Path(folder, name).is_file() for folder in folders if folder for name in names)
    return is_installed or (backend == "classic" and key.endswith("Plugin"))
