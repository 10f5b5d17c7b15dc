"""Makes a model of an SDF file drivable: its drive by a plug-in of the simulator, without what that cannot load."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple
from xml.etree.ElementTree import Element, SubElement, fromstring

from rsegen.exporters.gazebo.systems import prefixes
from rsegen.simulation.robots.drives import Drive
from rsegen.simulation.robots.sdf_drives import KNOWN, plugin_key

_ROS = re.compile(r"(?:^|_)ros\d?(?:_|$)|^hector_gazebo_")
_LIBRARIES = ("GAZEBO_PLUGIN_PATH", "GZ_SIM_SYSTEM_PLUGIN_PATH", "IGN_GAZEBO_SYSTEM_PLUGIN_PATH", "LD_LIBRARY_PATH")


TRACKS = "gz-sim-track-controller-system"
"""Belongs to a drive of tracks."""


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
    kept = [each for each in model.iter("plugin") if _is_own_drive(plugin_key(each.get("filename", "")), own, backend)]
    left = _leave_out(model, backend)
    for plugin in kept:
        for topic in plugin.findall("topic"):
            plugin.remove(topic)
        if plugin_key(plugin.get("filename", "")) == own:
            SubElement(plugin, "topic").text = f"/model/{name}/cmd_vel"
    if drive and not kept:
        kept = list(fromstring(f"<model>{drive.plugins(backend)}</model>"))  # noqa: S314  # ours
    model.extend(kept)
    _respell(model, backend)
    return left


def _is_own_drive(key: str, own: str, backend: str) -> bool:
    """Fortress has no mecanum drive in all of its versions; there its wheels are driven as others are."""
    missing = ("classic",) if own != "gz-sim-mecanum-drive-system" else ("classic", "fortress")
    return backend not in missing and own.startswith("gz-sim-") and key in (own, TRACKS)


def _leave_out(model: Element, backend: str) -> LeftOut:
    """Drives are not counted among what was left out: another one takes their place.

    Sensors move nothing and need a screen or time: the rays of a lidar against a mesh cost more than the robot.
    """
    names = tuple(_without(model, "sensor", lambda _: True, "name"))
    if backend != "classic":
        list(_without(model, "script", lambda _: True, "name"))  # colours of Classic's, which later versions refuse
    files = _without(model, "plugin", lambda each: not _is_loadable(each.get("filename", ""), backend), "filename")
    return LeftOut(tuple(dict.fromkeys(file for file in files if plugin_key(file) not in (*KNOWN, TRACKS))), names)


def _respell(model: Element, backend: str) -> None:
    """Name the systems of Gazebo Sim in a model as its version does: ignition-gazebo-... up to Fortress."""
    file, space = prefixes(backend)
    for plugin in model.iter("plugin"):
        key = plugin_key(plugin.get("filename", ""))
        if key.startswith("gz-sim-"):
            plugin.set("filename", file + key.removeprefix("gz-sim"))
            plugin.set("name", f"{space}::systems::{plugin.get('name', '').rpartition('::')[2]}")


def _is_loadable(file: str, backend: str) -> bool:
    key = plugin_key(file)
    if key in (*KNOWN, TRACKS):
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


def _without(model: Element, tag: str, is_out: Callable[[Element], bool], said: str) -> Iterator[str]:
    """Take elements of a tag out, wherever they are, and give an attribute of each."""
    for parent in list(model.iter()):
        for element in parent.findall(tag):
            if is_out(element):
                parent.remove(element)
                yield element.get(said, "")
