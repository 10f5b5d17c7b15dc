"""The systems that a Gazebo Sim server loads for a world that names none, as the package's worlds do.

Up to 6.7 a server loads only what such a file names, so physics, user commands and scene broadcaster are named too.
The names are those of the installed systems: `ignition-gazebo-...` in Fortress, `gz-sim-...` from Garden on.
"""

from __future__ import annotations

from collections.abc import Iterator
from types import MappingProxyType

from rsegen.exporters.gazebo.systems import system_name

_SYSTEMS = MappingProxyType(
    {
        "Physics": "",
        "UserCommands": "",
        "SceneBroadcaster": "",
        "Sensors": "<render_engine>ogre2</render_engine>",
        "Imu": "",
        "Contact": "",
    }
)
"""The parameters of each system."""


def _config(backend: str) -> str:
    return f"<server_config>\n  <plugins>\n{''.join(_plugins(backend))}  </plugins>\n</server_config>\n"


def _plugins(backend: str) -> Iterator[str]:
    for kind, parameters in _SYSTEMS.items():
        name = system_name(kind, backend)
        yield f"""\
    <plugin entity_name="*" entity_type="world"
            filename="{name.library}"
            name="{name.class_name}">{parameters}</plugin>
"""


FORTRESS = _config("fortress")
GARDEN_AND_LATER = _config("sim")
