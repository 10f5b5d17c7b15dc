"""The names of Gazebo Sim's systems: `DiffDrive` is ignition-gazebo-diff-drive-system in Fortress, gz-sim-... later."""

from __future__ import annotations

from typing import NamedTuple


class SystemName(NamedTuple):
    """The name of a system's library, without the version, and of its class."""

    library: str
    class_name: str


def prefixes(backend: str) -> SystemName:
    """What the names of all systems begin with; backend: `fortress`, or `sim` for all later versions."""
    return SystemName("gz-sim", "gz::sim") if backend == "sim" else SystemName("ignition-gazebo", "ignition::gazebo")


def system_name(kind: str, backend: str) -> SystemName:
    """The name of a system, such as `DiffDrive`; backend: `fortress`, or `sim` for all later versions."""
    library, namespace = prefixes(backend)
    words = "".join(f"-{letter.lower()}" if letter.isupper() else letter for letter in kind)
    return SystemName(f"{library}{words}-system", f"{namespace}::systems::{kind}")
