"""A server of a trial, in which robots drive randomly, and what that costs."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from rsegen.errors import SimulatorFailed
from rsegen.simulation.driving.recording import RobotRun, send_commands
from rsegen.simulation.driving.routes import Route
from rsegen.simulation.experiment.machine import usage
from rsegen.simulation.simulators import Installation
from rsegen.simulation.simulators.live_world import LiveWorld
from rsegen.simulation.simulators.server import running_server

TIMEOUT = 600.0
"""Seconds within which the largest world must load."""

SETTLED = 2.0
"""Simulated seconds before measuring begins, in which robots fall to the ground and start to drive."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Setup:
    """A world file with robots, their runs, and the seconds between commands, about a simulated second."""

    file: Path
    runs: Sequence[RobotRun]
    rest: float


@dataclass(frozen=True, kw_only=True, slots=True)
class Span:
    """Seconds of simulation, wall and CPU time, and the real-time factors between samples."""

    simulated: float
    real: float
    cpu: float
    factors: Sequence[float]

    @property
    def speed(self) -> float:
        """Simulated seconds per second of CPU."""
        return self.simulated / max(self.cpu, 0.01)


def total(spans: Sequence[Span]) -> Span:
    """The sum of spans."""
    return Span(
        simulated=sum(span.simulated for span in spans),
        real=sum(span.real for span in spans),
        cpu=sum(span.cpu for span in spans),
        factors=[factor for span in spans for factor in span.factors],
    )


@dataclass(frozen=True, kw_only=True, slots=True)
class TrialServer:
    """A running server that took `load` seconds to load its setup, and the routes of its robots."""

    live: LiveWorld
    pid: int
    load: float
    setup: Setup
    routes: Mapping[str, Route]

    @property
    def memory(self) -> float:
        """Memory of the server in MB."""
        return usage(self.pid).memory

    def measure(self, seconds: float) -> Span:
        """The span of this many wall seconds, paused only before and after, so that all clocks are exact."""
        start, before = self.live.clock(), usage(self.pid).cpu
        factors = self.run_robots("real", seconds)
        end, after = self.live.clock(), usage(self.pid).cpu
        return Span(
            simulated=end.simulated - start.simulated, real=end.real - start.real, cpu=after - before, factors=factors
        )

    def run_robots(self, clock: Literal["simulated", "real"], seconds: float) -> list[float]:
        """Let robots drive for this many simulated or real seconds; gives the real-time factors between commands."""
        start = last = self.live.clock()
        factors, end = [], time.monotonic() + 20 * seconds
        self.live.unpause()
        while getattr(last, clock) < getattr(start, clock) + seconds:
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
    """A server of a trial in which the robots have fallen to the ground and started to drive."""
    began = time.monotonic()
    with running_server(here, setup.file, timeout=TIMEOUT) as server, server.connect() as live:
        live.stop_recording()
        load, routes = time.monotonic() - began, {run.name: run.route() for run in setup.runs}
        trial = TrialServer(live=live, pid=server.pid, load=load, setup=setup, routes=routes)
        trial.run_robots("simulated", SETTLED)
        yield trial
