"""Make a model of a file drivable: a drive of the simulator's own, joints that keep their angles, and nothing more.

Sensors, and plug-ins that the simulator has not, are taken out. Joints that have limits, and those of tracks and
flippers, become fixed at the angle that the model has them at, as nothing else holds an arm, a flipper or a leg. A
joint with a spring is a suspension and stays, as does one that turns without end, such as that of a caster. What breaks
it: an arm that hangs on endless joints, and a rocker without a spring, which becomes stiff.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Iterator
from pathlib import Path
from typing import NamedTuple
from xml.etree.ElementTree import Element, SubElement, fromstring

from rsegen.exporters.gazebo.sdf import numbers, prefixes
from rsegen.robots.drives import Drive, Tracks, Wheels
from rsegen.robots.sdf_drives import KNOWN, TRACK_CONTROLLER, ReadDrive, is_endless, plugin_key
from rsegen.robots.sdf_shapes import ModelFrames, floats

_LIBRARIES = ("GAZEBO_PLUGIN_PATH", "GZ_SIM_SYSTEM_PLUGIN_PATH", "IGN_GAZEBO_SYSTEM_PLUGIN_PATH", "LD_LIBRARY_PATH")
"""Variables that list the folders of plug-ins."""

_MOVING = ("revolute", "continuous", "prismatic")
"""Types of joints that may be held; the others of SDF are those of a screw, a ball and gears."""


class Changes(NamedTuple):
    """Elements that were taken out of a model, and joints that are held.

    plugins: their files; sensors, visuals: their names, of visuals those whose mesh is not found
    """

    plugins: tuple[str, ...]
    sensors: tuple[str, ...]
    visuals: tuple[str, ...]
    held: tuple[str, ...]


def make_drivable(model: Element, drive: Drive | None, read: ReadDrive | None, name: str, backend: str) -> Changes:
    """Give a model a drive of the simulator's own in place of all that it has; what else was changed in it.

    read: the drive as it was read; if its plug-in is the simulator's, the plug-in is kept, with its limits of
    acceleration. ROS's plug-ins are taken out where their library is not in a folder of LD_LIBRARY_PATH or of the
    simulator's plug-ins.
    """
    own = read.plugin if read else ""
    held = hold(model, drive)
    for joint in _axes(model, read.turned if read else ()):
        joint.text = numbers([-value for value in floats(joint.text, 3, name)])
    kept = [
        plugin for plugin in model.iter("plugin") if _is_own_drive(plugin_key(plugin.get("filename", "")), own, backend)
    ]
    plugins, sensors, visuals = _leave_out(model, backend)
    for plugin in kept:
        for topic in plugin.findall("topic"):
            plugin.remove(topic)
        if plugin_key(plugin.get("filename", "")) == own:
            SubElement(plugin, "topic").text = f"/model/{name}/cmd_vel"
    if drive and not kept:
        kept = list(fromstring(f"<model>{drive.plugins(backend)}</model>"))  # noqa: S314  # ours
    model.extend(kept)
    _respell(model, backend)
    return Changes(plugins, sensors, visuals, held)


def hold(model: Element, drive: Drive | None) -> tuple[str, ...]:
    """Make the joints that nothing drives fixed, and return their names; without a drive, all that move."""
    frames = ModelFrames(model, model.get("name", ""))
    wheels = (*drive.left, *drive.right) if isinstance(drive, Wheels) else ()
    tracks = (*drive.left, *drive.right) if isinstance(drive, Tracks) else ()
    held = []
    for name, joint in frames.joints.items():
        if joint.get("type") not in _MOVING or name in wheels:
            continue
        if drive is None or frames.child(name) in tracks or not (is_endless(joint) or _has_spring(joint)):
            joint.set("type", "fixed")
            for element in [*joint.findall("axis"), *joint.findall("physics")]:
                joint.remove(element)
            held.append(name)
    return tuple(held)


def has_controllers(model: Element, backend: str) -> bool:
    """Return whether a model has a plug-in that a simulator loads and that may move its joints, of ROS or its own."""
    files = (plugin.get("filename", "") for plugin in model.iter("plugin"))
    return any("control" in file.lower() and _is_loadable(file, backend) for file in files)


def _has_spring(joint: Element) -> bool:
    try:
        return float(joint.findtext("axis/dynamics/spring_stiffness") or 0) > 0
    except ValueError:
        return False


def _axes(model: Element, joints: Collection[str]) -> Iterator[Element]:
    """Yield the elements with the axes of joints."""
    if joints:
        elements = ModelFrames(model, model.get("name", "")).joints
        yield from (axis for joint in joints if (axis := elements[joint].find("axis/xyz")) is not None)


def _is_own_drive(key: str, own: str, backend: str) -> bool:
    """Return whether a plug-in is the drive that was read, and the simulator has it.

    Fortress has no mecanum drive in all of its versions; there its wheels are driven as others are.
    """
    missing = ("classic",) if own != "gz-sim-mecanum-drive-system" else ("classic", "fortress")
    return backend not in missing and own.startswith("gz-sim-") and key in (own, TRACK_CONTROLLER)


def _leave_out(model: Element, backend: str) -> tuple[tuple[str, ...], ...]:
    """Take out what a drive cannot use: the files of plug-ins but for drives, and the names of sensors and visuals.

    Sensors move nothing and need a screen or time: the rays of a lidar against a mesh cost more than the robot. Gazebo
    Sim does not load a world with a mesh that it does not find, although nobody sees it.
    """
    names = tuple(_without(model, "sensor", lambda _: True, "name"))
    visuals = tuple(_without(model, "visual", _lacks_its_mesh, "name"))
    if backend != "classic":
        list(_without(model, "script", lambda _: True, "name"))  # colours of Classic's, which later versions refuse
    files = _without(model, "plugin", lambda plugin: not _is_loadable(plugin.get("filename", ""), backend), "filename")
    plugins = tuple(dict.fromkeys(file for file in files if plugin_key(file) not in (*KNOWN, TRACK_CONTROLLER)))
    return plugins, names, visuals


def _lacks_its_mesh(visual: Element) -> bool:
    """Return whether the mesh of a visual was not found: URIs that were found are absolute paths (`resolve_uris`)."""
    uri = (visual.findtext("geometry/mesh/uri") or "/").strip()
    return not uri.removeprefix("file://").startswith("/")


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
    if key in (*KNOWN, TRACK_CONTROLLER):
        return False
    if key.startswith("gz-sim-"):
        return backend != "classic"
    # Classic's own are called so; one of a robot's manufacturer, or of ROS, is in a folder of plug-ins, or not here.
    return (backend == "classic" and key.endswith("Plugin")) or _is_installed(file)


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
