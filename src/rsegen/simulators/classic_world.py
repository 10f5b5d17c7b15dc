"""A world in a Gazebo Classic server that stands still: stepped, and asked what is where, through the command `gz`."""

from __future__ import annotations

import math
import re
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from rsegen.errors import SimulatorFailed
from rsegen.simulators.base import Installation
from rsegen.simulators.messages import Message, parse
from rsegen.simulators.server import PATIENCE, Server, serving

ATTEMPTS = 4
"""Gazebo 11.1's server dies or hangs one time in 10 to 25, while a `gz` command connects to it or leaves."""

Made = TypeVar("Made")


@dataclass(frozen=True, kw_only=True, slots=True)
class Pose:
    """Where a model stands, metres, and how it is turned about z, radians."""

    x: float
    y: float
    z: float
    yaw: float


@dataclass(frozen=True, kw_only=True, slots=True)
class Run:
    """What a world was like at its end: where every model stood, and the error lines of the server's log."""

    poses: Mapping[str, Pose]
    errors: Sequence[str]


def simulated(here: Installation, world: Path, *, steps: int, models: Path | None = None) -> Run:
    """A world so many steps from its beginning; the same world and steps give the same poses.

    A server that is lost is tried again; SimulatorFailed where all of them are.
    """

    def once() -> Run:
        with serving(here, world, models=models) as server:
            step(server, steps)
            return Run(poses=poses(server), errors=server.errors)

    return attempted(once)


def attempted(once: Callable[[], Made], attempts: int = ATTEMPTS) -> Made:
    """What `once` gives, tried again where it loses its server; what the last attempt raises is raised."""
    try:
        return once()
    except SimulatorFailed:
        if attempts == 1:
            raise
    return attempted(once, attempts - 1)


def step(server: Server, steps: int) -> None:
    """Simulate so many steps, as fast as the world's physics allows."""
    begin(server, steps)
    done, end = 0, time.monotonic() + PATIENCE
    while done < steps:
        before, done = done, steps_done(server)
        end = time.monotonic() + PATIENCE if done > before else end
        if time.monotonic() > end:
            raise server.lost(f"it stands still at step {done} of {steps}")


def begin(server: Server, steps: int) -> None:
    """Have it simulate so many steps, and do not wait for them."""
    server.told("gz", "world", "--multi-step", str(steps))


def resume(server: Server) -> None:
    """Let time run, as fast as the world's physics says."""
    server.told("gz", "world", "--pause", "0")


def steps_done(server: Server) -> int:
    """How many steps have been simulated since the start."""
    told = server.told("gz", "topic", "--echo", "~/world_stats", "--unformatted", "--duration", "1")
    counts = re.findall(r"iterations: (\d+)", told)
    if not counts:
        raise server.lost(f"it does not count its steps: {told!r}")
    return int(counts[-1])


def poses(server: Server) -> dict[str, Pose]:
    """Where every model stands, by its name."""
    told = server.told("gz", "topic", "--request", "entity_list")
    models = parse(told).parts.get("models")
    if not models:
        raise server.lost(f"it names no models: {told!r}")
    return {model.values["name"]: _pose(model.parts["pose"][0]) for model in models}


def _pose(message: Message) -> Pose:
    x, y, z = message.parts["position"][0].numbers("x", "y", "z")
    a, b, c, w = message.parts["orientation"][0].numbers("x", "y", "z", "w")
    return Pose(x=x, y=y, z=z, yaw=math.atan2(2 * (w * c + a * b), 1 - 2 * (b * b + c * c)))
