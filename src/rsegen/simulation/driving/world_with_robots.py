"""A world file with robots added, as text that can be saved in any folder."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Iterable
from pathlib import Path

from rsegen.errors import FileError
from rsegen.io.text_files import elements, text_of
from rsegen.simulation.robots.systems import add_systems

_MOST_MIB = 512
_SCHEME = re.compile(r"[a-z][a-z0-9+.-]*:")


def world_with_robots(
    world: Path, models: Iterable[str] = (), *, unthrottled: bool = False, backend: str = "classic"
) -> str:
    """The text of a world file with models added, each the text of a <model>; meshes have absolute paths.

    unthrottled: simulated as fast as the machine can, else in real time; backend: that of the installation, whose
    systems are added where the world does not name them. FileError if the file is not a world.
    """
    root = elements(text_of(world, _MOST_MIB, "a world"), str(world))
    element = root.find("world")
    if root.tag != "sdf" or element is None:
        raise FileError(f"{world}: no <world> in <sdf>")
    for model in models:
        element.append(ET.fromstring(model))  # noqa: S314  # ours
    for uri in root.iter("uri"):
        uri.text = _absolute(uri.text or "", world.absolute().parent)
    add_systems(element, backend)
    if unthrottled:
        _unthrottle(element)
    return '<?xml version="1.0"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


def time_step(world: str) -> float:
    """The physics step of a world in seconds, from its text."""
    found = ET.fromstring(world).find("world/physics/max_step_size")  # noqa: S314  # ours
    return float(found.text or 0) if found is not None else 0.001


def _absolute(uri: str, folder: Path) -> str:
    return uri if not uri.strip() or _SCHEME.match(uri) or uri.startswith("/") else str(folder / uri)


def _unthrottle(world: ET.Element) -> None:
    """Gazebo Classic reads the update rate, Gazebo Sim the factor."""
    physics = world.find("physics")
    if physics is None:
        physics = ET.SubElement(world, "physics", {"type": "ode"})
    for name in ("real_time_update_rate", "real_time_factor"):
        element = physics.find(name)
        (ET.SubElement(physics, name) if element is None else element).text = "0"
