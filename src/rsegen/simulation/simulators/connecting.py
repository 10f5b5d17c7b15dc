"""Connections to the running simulation, at the address in the user's environment variables."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

from rsegen.errors import NothingRuns, SimulatorFailed
from rsegen.simulation.simulators.base import SIMULATORS, Simulator
from rsegen.simulation.simulators.live_world import LiveWorld

TIMEOUTS = 0.3, 2.0
"""Seconds in which a server must answer; first each is asked for a moment, as most simulators do not run."""


@contextmanager
def connected(name: str | None) -> Iterator[tuple[Simulator, LiveWorld]]:
    """The running simulator, of that name if given, and its world; NothingRuns if none runs."""
    able = list(SIMULATORS.values()) if name is None else [SIMULATORS.named(name, "simulator")]
    with ExitStack() as stack:
        yield _first(stack, able)


def _first(stack: ExitStack, simulators: list[Simulator]) -> tuple[Simulator, LiveWorld]:
    reasons: list[str] = []
    for timeout in TIMEOUTS:
        reasons.clear()
        for simulator in simulators:
            world = _world_or_reason(stack, simulator, timeout)
            if isinstance(world, LiveWorld):
                return simulator, world
            reasons.append(world)
    raise NothingRuns(f"no simulation runs ({'; '.join(reasons)}); start one, as with rsegen open --shared")


def _world_or_reason(stack: ExitStack, simulator: Simulator, timeout: float) -> LiveWorld | str:
    """Return the world of a simulator, or the reason why there is none."""
    try:
        return stack.enter_context(simulator.connect(os.environ, timeout))
    except SimulatorFailed as error:
        return str(error)
