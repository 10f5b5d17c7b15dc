"""The systems that a Gazebo Sim server loads for a world that names none, as the package's worlds do.

Up to 6.7 a server loads only what such a file names, so physics, user commands and scene broadcaster are named too.
The names are those of the installed systems: `ignition-gazebo-...` in Fortress, `gz-sim-...` from Garden on.
"""

from __future__ import annotations

from typing import NamedTuple


class _System(NamedTuple):
    """A system: its part of a library's name, its class, and its parameters."""

    library: str
    name: str
    parameters: str = ""


_SYSTEMS = (
    _System("physics", "Physics"),
    _System("user-commands", "UserCommands"),
    _System("scene-broadcaster", "SceneBroadcaster"),
    _System("sensors", "Sensors", "<render_engine>ogre2</render_engine>"),
    _System("imu", "Imu"),
    _System("contact", "Contact"),
)


def _config(library: str, namespace: str) -> str:
    plugins = "".join(
        f"""\
    <plugin entity_name="*" entity_type="world"
            filename="{library}-{system.library}-system"
            name="{namespace}::systems::{system.name}">{system.parameters}</plugin>
"""
        for system in _SYSTEMS
    )
    return f"<server_config>\n  <plugins>\n{plugins}  </plugins>\n</server_config>\n"


FORTRESS = _config("ignition-gazebo", "ignition::gazebo")
GARDEN_AND_LATER = _config("gz-sim", "gz::sim")
