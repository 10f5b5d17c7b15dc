"""Gazebo Sim, once Ignition: `ign gazebo` up to Fortress, `gz sim` from Garden on."""

from __future__ import annotations

import re
import secrets
from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import ClassVar

from rsegen.errors import SimulatorFailed
from rsegen.simulation.simulators.base import Installation, LaunchCommand, OpenRequest, Simulator, on_path, register
from rsegen.simulation.simulators.live_world import LiveWorld
from rsegen.simulation.simulators.process import command_output
from rsegen.simulation.simulators.sim_world import sim_world

COMMANDS = (("gz", "sim"), ("ign", "gazebo"))
"""Program and verb. Programs of these names without the verb are Gazebo Classic's, or libsdformat's alone."""


@register
class GazeboSim(Simulator):
    """Fortress and all later ones."""

    name: ClassVar[str] = "sim"
    title: ClassVar[str] = "Gazebo Sim"
    generation: ClassVar[int] = 2
    how_to_install: ClassVar[tuple[str, ...]] = (
        "Ubuntu: apt-get install gz-harmonic from packages.osrfoundation.org",
        "all systems: https://gazebosim.org/docs/latest/install",
    )
    address_variables: ClassVar[tuple[str, ...]] = ("GZ_PARTITION", "IGN_PARTITION")
    load_failures: ClassVar[tuple[str, ...]] = (
        "Failed to find world [",
        "Unable to find or download file",
        "Failed to load a world",
    )

    def installation(self) -> Installation | None:
        """The newest of all that are on PATH; it tells its versions one a line."""
        told = ((number, words) for words in COMMANDS for number in _versions(words))
        newest = max(told, key=lambda each: _order(each[0]), default=None)
        if not newest:
            return None
        version, (program, verb) = newest
        where = on_path(program) or Path(program)
        return Installation(simulator=self, version=version, commands=MappingProxyType({f"{program} {verb}": where}))

    def with_gui(self, here: Installation, opening: OpenRequest) -> LaunchCommand | None:
        """Server and window, which start to simulate at once."""
        return _launch(here, opening).with_options("-r")

    def headless(self, here: Installation, opening: OpenRequest) -> LaunchCommand:
        """The server alone."""
        return _launch(here, opening).with_options("-s", "-r")

    def paused(self, here: Installation, opening: OpenRequest, home: Path) -> LaunchCommand:
        """The server alone, which is not told to run, and tells what it has loaded."""
        return _launch(here, replace(opening, home=home)).with_options("-s", "-v", "3")

    def is_loaded(self, home: Path, log: str) -> bool:
        """It says so of each world, in a message of level 3."""
        return re.search(r"World \[[^]]*\] initialized with", log) is not None

    def backend(self, here: Installation) -> str:
        """Up to Fortress, names begin with ignition."""
        return "fortress" if "ign gazebo" in here.commands else "sim"

    def connect(self, environment: Mapping[str, str]) -> AbstractContextManager[LiveWorld]:
        """Through its commands, which have to be installed."""
        here = self.installation()
        if not here:
            raise SimulatorFailed(f"{self.title}: none is installed here")
        ((_, program),) = here.commands.items()
        return sim_world(program, self.backend(here), environment)


def _launch(here: Installation, opening: OpenRequest) -> LaunchCommand:
    ((words, program),) = here.commands.items()
    return LaunchCommand(
        command=(str(program), words.split()[1], str(opening.folder / opening.world.name)),
        environment=MappingProxyType(_environment(opening)),
        folder=opening.folder,
    )


def _environment(opening: OpenRequest) -> dict[str, str]:
    """Every variable by both of its names; a partition of its own on this machine alone, unless it is to be shared."""
    partition = f"rsegen-{secrets.token_hex(4)}"
    own = {"GZ_PARTITION": partition, "IGN_PARTITION": partition, "GZ_IP": "127.0.0.1", "IGN_IP": "127.0.0.1"}
    names = ("GZ_SIM_RESOURCE_PATH", "IGN_GAZEBO_RESOURCE_PATH")
    return {name: opening.model_path(name) for name in names} | ({} if opening.shared else own) | opening.home_variables


def _versions(words: Sequence[str]) -> Iterator[str]:
    program, verb = words
    where = on_path(program)
    told = command_output([where, verb, "--versions"]) if where else ""
    return (line.strip() for line in told.splitlines() if re.fullmatch(r"\s*\d+\.\d+\.\d+\S*\s*", line))


def _order(version: str) -> list[int]:
    return [int(number) for number in re.findall(r"\d+", version)[:3]]
