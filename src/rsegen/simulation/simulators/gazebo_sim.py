"""Gazebo Sim, once Ignition: `ign gazebo` up to Fortress, `gz sim` from Garden on.

Every variable is set by both of its names, old and new. A partition of its own keeps a server apart from others. It
prints in blocks of 4096 bytes, so whether it has loaded its world is read from its own log, which is flushed by line;
its exit code is 0 whatever fails.
"""

from __future__ import annotations

import os
import re
import secrets
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import ClassVar

from rsegen.simulation.simulators.base import Installation, LaunchCommand, OpenRequest, Simulator, commands_of, register
from rsegen.simulation.simulators.live_world import LiveWorld
from rsegen.simulation.simulators.patience import Patience
from rsegen.simulation.simulators.process import command_output
from rsegen.simulation.simulators.sim_world import sim_world, with_contact_sensors

COMMANDS = (("gz", "sim"), ("ign", "gazebo"))
"""Program and verb. Programs of these names without the verb are Gazebo Classic's, or libsdformat's alone."""

_SETTINGS = MappingProxyType(
    {
        "gz sim": (Path(".gz", "sim"), "GZ_SIM_SERVER_CONFIG_PATH"),
        "ign gazebo": (Path(".ignition", "gazebo"), "IGN_GAZEBO_SERVER_CONFIG_PATH"),
    }
)
"""The folder of its settings in the user's home, and the variable that names another file of default plug-ins."""

_LOADED = "Publishing dynamic pose messages on ["
"""The last message, of level 3, of its scene broadcaster in the first update after all entities are made."""

_NO_MESSAGE_IS_DROPPED = MappingProxyType({"GZ_TRANSPORT_SNDHWM": "0", "IGN_TRANSPORT_SNDHWM": "0"})
"""The length of the queue of messages to send, 0 for any. By default a server drops what is beyond 1000 messages, which
sensors of contact reach in a fraction of a second on a busy machine; then poses are missing in a record."""

_SDF_ERROR = re.compile(r"\[Server(Private)?\.cc:\d+\] Error Code \d+")
"""An error of libsdformat in the world's own file, whatever it is: the server ends, with exit code 0. (Those in models
that are spawned come from other files of its source.)"""


@register
class GazeboSim(Simulator):
    """Gazebo Sim from Fortress on."""

    name: ClassVar[str] = "sim"
    title: ClassVar[str] = "Gazebo Sim"
    generation: ClassVar[int] = 2
    how_to_install: ClassVar[tuple[str, ...]] = (
        "Ubuntu 22.04, 24.04: apt-get install gz-harmonic from packages.osrfoundation.org",
        "macOS: brew install osrf/simulation/gz-harmonic; conda: conda install -c conda-forge gz-sim8",
        "all systems: https://gazebosim.org/docs/latest/install (Debian has its libraries only)",
    )
    address_variables: ClassVar[tuple[str, ...]] = ("GZ_PARTITION", "IGN_PARTITION")
    drives_without: ClassVar[tuple[str, ...]] = ("pictures",)
    harmless_messages: ClassVar[tuple[str, ...]] = (
        # A second server's profiler finds its port taken.
        "Error launching Remotery",
    )
    load_failures: ClassVar[tuple[str, ...]] = (
        "Failed to find world [",
        "Unable to find or download file",
        "Failed to load a world",
        "Library error: Problem running",
        "Library error for [",
        "error while loading shared libraries",
    )

    def installation(self) -> Installation | None:
        """Return the newest of all that are on PATH; each prints its versions, one per line."""
        told = (
            (version, f"{program} {verb}", path)
            for program, verb in COMMANDS
            for path in commands_of(program)  # Gazebo Classic's `gz` may come first
            for version in _versions(path, verb)
        )
        newest = max(told, key=lambda each: _order(each[0]), default=None)
        if not newest:
            return None
        version, words, path = newest
        return Installation(simulator=self, version=version, commands=MappingProxyType({words: path}))

    def with_gui(self, here: Installation, opening: OpenRequest) -> LaunchCommand | None:
        """Return the command of server and window, which start to simulate at once."""
        return _launch(here, opening).with_options("-r")

    def headless(self, here: Installation, opening: OpenRequest) -> LaunchCommand:
        """Return the command of the server alone; in a home of its own with the default plug-ins of the user's."""
        launch = _launch(here, opening).with_options("-s", "-r")
        chosen = _server_config(here) if opening.home else {}
        return replace(launch, environment=MappingProxyType({**launch.environment, **chosen}))

    def paused(self, here: Installation, opening: OpenRequest, home: Path) -> LaunchCommand:
        """Return the command of a paused server, which says what it has loaded, and drops no message."""
        launch = _launch(here, replace(opening, home=home)).with_options("-s", "-v", "3")
        return replace(launch, environment=MappingProxyType({**launch.environment, **_NO_MESSAGE_IS_DROPPED}))

    def is_loaded(self, home: Path, log: str) -> bool:
        """Return whether it says so: at once in its own log in its home, perhaps 4096 bytes later in what it prints."""
        return _LOADED in log or any(_LOADED in text for text in _console_logs(home))

    def load_failed(self, log: str) -> bool:
        """Return whether its log has such a message, or an error in the world's SDF."""
        return super().load_failed(log) or any(_SDF_ERROR.search(line) for line in self.error_lines(log))

    def backend(self, here: Installation) -> str:
        """Return `fortress` up to that version, whose names begin with ignition, else `sim`."""
        return "fortress" if "ign gazebo" in here.commands else "sim"

    def with_contact_sensors(self, model: str) -> str:
        """Return the model with sensors: a server gives only contacts of collisions that a sensor names."""
        return with_contact_sensors(model)

    def connect(self, environment: Mapping[str, str], patience: Patience) -> AbstractContextManager[LiveWorld]:
        """Connect through its own transport, so it may run on another machine, and need not be installed here."""
        return sim_world(environment, patience)


def _launch(here: Installation, opening: OpenRequest) -> LaunchCommand:
    ((words, program),) = here.commands.items()
    return LaunchCommand(
        command=(str(program), words.split()[1], str(opening.folder / opening.world.name)),
        environment=MappingProxyType(_environment(opening)),
        folder=opening.folder,
    )


_TRANSPORT = {
    f"{prefix}_{name}": value
    for prefix in ("GZ", "IGN")
    for name, value in {"TRANSPORT_IMPLEMENTATION": "zeromq", "TRANSPORT_TOPIC_STATISTICS": "0", "RELAY": ""}.items()
}
"""What our client speaks, whatever the user's variables say: ZeroMQ, and messages without statistics."""


def _environment(opening: OpenRequest) -> dict[str, str]:
    """Return variables by both of their names; a partition on this machine alone, unless it is to be shared."""
    partition = f"rsegen-{secrets.token_hex(4)}"
    address = {"GZ_PARTITION": partition, "IGN_PARTITION": partition, "GZ_IP": "127.0.0.1", "IGN_IP": "127.0.0.1"}
    own = address | _TRANSPORT
    names = ("GZ_SIM_RESOURCE_PATH", "IGN_GAZEBO_RESOURCE_PATH")
    return {name: opening.model_path(name) for name in names} | ({} if opening.shared else own) | opening.home_variables


def _server_config(here: Installation) -> dict[str, str]:
    """Return the variable that names the user's own file of default plug-ins, if the file exists and it is not set."""
    ((words, _),) = here.commands.items()
    folder, variable = _SETTINGS[words]
    file = Path.home() / folder / here.version.partition(".")[0] / "server.config"
    return {} if variable in os.environ or not file.is_file() else {variable: str(file)}


def _console_logs(home: Path) -> Iterator[str]:
    """Yield the logs that servers have written in a home, in a folder for each start; they are flushed line by line."""
    for folder, _ in _SETTINGS.values():
        for file in (home / folder).glob("log/*/server_console.log"):
            yield file.read_text(errors="replace")


def _versions(program: Path, verb: str) -> Iterator[str]:
    told = command_output([program, verb, "--versions"])
    return (line.strip() for line in told.splitlines() if re.fullmatch(r"\s*\d+\.\d+\.\d+\S*\s*", line))


def _order(version: str) -> list[int]:
    return [int(part) for part in re.findall(r"\d+", version)[:3]]
