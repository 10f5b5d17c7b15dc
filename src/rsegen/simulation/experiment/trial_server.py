"""A server with robots in it that wander, and what that costs."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from rsegen.errors import SimulatorFailed
from rsegen.simulation.driving.drive import RobotRun, send_commands
from rsegen.simulation.driving.routes import Route
from rsegen.simulation.experiment.machine import usage
from rsegen.simulation.simulators import Installation
from rsegen.simulation.simulators.live_world import LiveWorld
from rsegen.simulation.simulators.server import running_server

TIMEOUT = 600.0
"""Seconds for the largest world to load."""

SETTLED = 2.0
"""Simulated seconds before measuring begins: robots fall to the ground, and go."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Setup:
    """A world file with robots in it; rest: seconds between what they are told, about a simulated one."""

    file: Path
    runs: Sequence[RobotRun]
    rest: float


@dataclass(frozen=True, kw_only=True, slots=True)
class Span:
    """Seconds by three clocks, and the real-time factors from each look to the next."""

    simulated: float
    real: float
    cpu: float
    factors: Sequence[float]

    @property
    def speed(self) -> float:
        """Simulated seconds for each second of CPU."""
        return self.simulated / max(self.cpu, 0.01)


def total(spans: Sequence[Span]) -> Span:
    """One of all of these."""
    return Span(
        simulated=sum(span.simulated for span in spans),
        real=sum(span.real for span in spans),
        cpu=sum(span.cpu for span in spans),
        factors=[factor for span in spans for factor in span.factors],
    )


@dataclass(frozen=True, kw_only=True, slots=True)
class TrialServer:
    """A server that took `load` seconds for a setup, and robots that know where they are going."""

    live: LiveWorld
    pid: int
    load: float
    setup: Setup
    routes: Mapping[str, Route]

    @property
    def memory(self) -> float:
        """MB of it, now."""
        return usage(self.pid).memory

    def measure(self, seconds: float) -> Span:
        """What so many real seconds came to: without a pause but before and after, so all clocks are known exactly."""
        start, before = self.live.clock(), usage(self.pid).cpu
        factors = self.run_robots("real", seconds)
        end, after = self.live.clock(), usage(self.pid).cpu
        return Span(
            simulated=end.simulated - start.simulated, real=end.real - start.real, cpu=after - before, factors=factors
        )

    def run_robots(self, hand: Literal["simulated", "real"], seconds: float) -> list[float]:
        """Have robots decide again and again for so many seconds of one hand of the clock; gives real-time factors."""
        start = last = self.live.clock()
        factors, end = [], time.monotonic() + 20 * seconds
        self.live.unpause()
        while getattr(last, hand) < getattr(start, hand) + seconds:
            send_commands(self.live, self.setup.runs, self.routes, self.live.poses())
            time.sleep(self.setup.rest)
            now = self.live.clock()
            if time.monotonic() > end:
                raise SimulatorFailed(f"{now.simulated - start.simulated:g} s simulated in {20 * seconds:g} s")
            factors.append((now.simulated - last.simulated) / max(now.real - last.real, 1e-9))
            last = now
        self.live.pause()
        return factors


@contextmanager
def trial_server(setup: Setup, here: Installation) -> Iterator[TrialServer]:
    """As long as this lasts, a server in which the robots have fallen to the ground, and gone."""
    began = time.monotonic()
    with running_server(here, setup.file, timeout=TIMEOUT) as server, server.connect() as live:
        live.stop_recording()
        load, routes = time.monotonic() - began, {run.name: run.route() for run in setup.runs}
        trial = TrialServer(live=live, pid=server.pid, load=load, setup=setup, routes=routes)
        trial.run_robots("simulated", SETTLED)
        yield trial
