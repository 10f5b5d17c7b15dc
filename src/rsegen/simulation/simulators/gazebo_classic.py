"""Gazebo Classic 11: gzserver, gzclient, and gazebo that starts both.

Two servers need two ports of GAZEBO_MASTER_URI, and the internet's database of models is switched off, or they wait for
it. A paused server begins its record when its world is complete, which tells that it has loaded; the record later tells
where models were, to three digits, which is all that Gazebo writes.
"""

from __future__ import annotations

import re
import socket
from collections.abc import Mapping
from contextlib import AbstractContextManager
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import ClassVar

from rsegen.errors import ParameterError, shown
from rsegen.simulation.simulators.base import Installation, LaunchCommand, OpenRequest, Simulator, commands_of, register
from rsegen.simulation.simulators.classic_world import classic_world
from rsegen.simulation.simulators.live_world import LiveWorld, Record
from rsegen.simulation.simulators.patience import Patience
from rsegen.simulation.simulators.process import command_output

_STATE = re.compile(r"<sim_time>(\d+) (\d+)</sim_time>(.*?)</state>", re.DOTALL)
_MODEL = re.compile(r"<model name='([^']+)'>\s*<pose>([^<]+)</pose>")


SET_UP = Path(".cache", "rsegen", "gazebo-classic")
"""The folder in the user's home in which scripts/gazebo-classic sets it up."""

MASTER = "http://localhost:11345"
"""The default address of Gazebo Classic's server."""

STATE = Path("record", "state.log")
"""The record of a server, below its home."""


@register
class GazeboClassic(Simulator):
    """Gazebo Classic 11, the last of its line."""

    name: ClassVar[str] = "classic"
    title: ClassVar[str] = "Gazebo Classic"
    generation: ClassVar[int] = 1
    how_to_install: ClassVar[tuple[str, ...]] = (
        "Ubuntu 22.04, Debian 11: apt-get install gazebo gazebo-plugin-base",
        "Debian 12 and later, headless: scripts/gazebo-classic in a clone of rsegen (1.3 GB, as root)",
    )
    address_variables: ClassVar[tuple[str, ...]] = ("GAZEBO_MASTER_URI",)
    harmless_messages: ClassVar[tuple[str, ...]] = (
        "Can't open display",
        "Unable to open audio device",
        # What a server says whom a `gz` command has just left.
        "Header is empty",
        "Data was empty, try again",
        # What a server that keeps a record says of every model that is put in while time runs.
        "Unable to call parseURDF on robot model",
        "parse as old deprecated model file failed",
    )
    frames: ClassVar[tuple[str, ...]] = ("camera", "window")
    load_failures: ClassVar[tuple[str, ...]] = ("Falling back on worlds/empty.world", "Unable to start server[bind")

    def installation(self) -> Installation | None:
        """Return the installation on PATH, else the one that scripts/gazebo-classic has set up."""
        home = Path.home() / SET_UP
        elsewhere = [home / "bin"] if (home / "complete").exists() else []
        server = next(iter(commands_of("gzserver", *elsewhere)), None)
        version = re.search(r"version (11\.\S+)", command_output([server, "--version"])) if server else None
        if not server or not version:
            return None
        names = ("gzserver", "gz", "gazebo", "gzclient")
        commands = {name: server.with_name(name) for name in names if server.with_name(name).exists()}
        return Installation(simulator=self, version=version[1], commands=MappingProxyType(commands))

    def with_gui(self, here: Installation, opening: OpenRequest) -> LaunchCommand | None:
        """Return the command `gazebo`, which starts server and window."""
        if "gazebo" not in here.commands or "gzclient" not in here.commands:
            return None
        return _launch(here.commands["gazebo"], opening, {})

    def headless(self, here: Installation, opening: OpenRequest) -> LaunchCommand:
        """Return the command `gzserver`, without a screen if it needs none."""
        blind = {} if opening.screen else {"DISPLAY": ""}
        return _launch(here.commands["gzserver"], opening, blind | opening.home_variables)

    def paused(self, here: Installation, opening: OpenRequest, home: Path) -> LaunchCommand:
        """Return the command `gzserver`, paused, with a record in its home."""
        options = ("--pause", "--record", "--record_path", str(home / STATE.parent))
        return self.headless(here, replace(opening, home=home)).with_options(*options)

    def window(self, here: Installation, server: LaunchCommand) -> LaunchCommand | None:
        """Return the command `gzclient`, with the variables of the server, but on the screen."""
        if "gzclient" not in here.commands:
            return None
        variables = {name: value for name, value in server.environment.items() if name != "DISPLAY"}
        return replace(server, command=(str(here.commands["gzclient"]),), environment=MappingProxyType(variables))

    def is_loaded(self, home: Path, log: str) -> bool:
        """Return whether the record exists: a paused server begins it when its world is complete."""
        return (home / STATE).exists()

    def backend(self, here: Installation) -> str:
        """Return the only one."""
        return "classic"

    def connect(self, environment: Mapping[str, str], patience: Patience) -> AbstractContextManager[LiveWorld]:
        """Connect through its own transport, so it may run on another machine, and need not be installed here."""
        return classic_world(_address(environment.get("GAZEBO_MASTER_URI") or MASTER), patience)

    def record_options(self, period: float) -> tuple[str, ...]:
        """Return the options of a record as text."""
        return "--record_encoding", "txt", "--record_period", f"{period:g}"

    def read_record(self, home: Path) -> Record | None:
        """Return the record, which is complete when the server has ended."""
        return [
            (
                int(seconds) + int(nanos) / 1e9,
                {name: [float(value) for value in pose.split()] for name, pose in _MODEL.findall(models)},
            )
            for seconds, nanos, models in _STATE.findall((home / STATE).read_text())
        ]


def _address(master: str) -> tuple[str, int]:
    """Host and port of a GAZEBO_MASTER_URI."""
    parts = re.fullmatch(r"(?:http://)?([^/:]+):(\d{1,5})/?", master)
    if not parts:
        raise ParameterError("GAZEBO_MASTER_URI", f"{shown(master)} is not a host and a port, as in {MASTER}")
    return parts[1], int(parts[2])


def _launch(command: Path, opening: OpenRequest, more: Mapping[str, str]) -> LaunchCommand:
    """Return a command in the world's folder: Gazebo 11.1 looks for meshes there."""
    return LaunchCommand(
        command=(str(command), "--verbose", opening.world.name),
        environment=MappingProxyType(_environment(opening) | dict(more)),
        folder=opening.folder,
    )


def _environment(opening: OpenRequest) -> dict[str, str]:
    """Return variables: no model database in the internet, and an address of its own unless it is to be shared."""
    own = {"GAZEBO_IP": "127.0.0.1", "GAZEBO_MASTER_URI": f"http://127.0.0.1:{_free_port()}"}
    models = {"GAZEBO_MODEL_DATABASE_URI": "", "GAZEBO_MODEL_PATH": opening.model_path("GAZEBO_MODEL_PATH")}
    return models if opening.shared else models | own


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port
