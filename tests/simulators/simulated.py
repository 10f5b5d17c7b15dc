"""A world some steps from its beginning."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from rsegen.simulators.base import Installation
from rsegen.simulators.poses import Pose
from rsegen.simulators.server import attempted, running_server


@dataclass(frozen=True, kw_only=True, slots=True)
class Run:
    """State of a world at its end: where every model stood, and the error lines of the server's log."""

    poses: Mapping[str, Pose]
    errors: Sequence[str]


def simulated(here: Installation, world: Path, *, steps: int, models: Path | None = None) -> Run:
    """A world so many steps from its beginning; the same world and steps give the same poses.

    A server that is lost is tried again; SimulatorFailed where all of them are.
    """

    def once() -> Run:
        with running_server(here, world, models=models) as server:
            with server.connect() as live:
                live.step(steps)
                poses = live.poses()
            return Run(poses=poses, errors=server.errors)

    return attempted(once)[0]
