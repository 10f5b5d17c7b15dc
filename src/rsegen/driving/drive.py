"""Robots driven over a world in a simulator, and where they were meanwhile."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import astuple, dataclass
from math import ceil
from pathlib import Path

import numpy as np

from rsegen.driving.arena import arena, step_of
from rsegen.driving.routes import Route
from rsegen.driving.trip import Track
from rsegen.errors import SimulatorFailed
from rsegen.robots import Robot
from rsegen.simulators import Installation
from rsegen.simulators.live import LiveWorld, Pose, Record
from rsegen.simulators.server import attempted, serving

PERIOD = 0.05
"""Seconds between two rows of a track."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Driver:
    """A robot under a name, where it starts, and how it drives. Its route is made anew for every attempt."""

    name: str
    robot: Robot
    start: Pose
    route: Callable[[], Route]


@dataclass(frozen=True, kw_only=True, slots=True)
class Drive:
    """The track of every robot by its name, and the error lines of the simulator."""

    tracks: Mapping[str, Track]
    errors: Sequence[str]


def driven(
    here: Installation,
    world: Path,
    drivers: Sequence[Driver],
    seconds: float,
    progress: Callable[[float], None] = lambda _: None,
) -> Drive:
    """Drive all of them for so many simulated seconds; a server that is lost is tried again.

    The same drivers, world and simulator give the same tracks; `progress` is told the seconds that are done.
    """
    models = [driver.robot.model(driver.name, here.dialect, astuple(driver.start)) for driver in drivers]
    text = arena(world, models, unthrottled=True)
    with tempfile.TemporaryDirectory(prefix="rsegen-") as folder:
        file = Path(folder, world.name)
        file.write_text(text, "utf-8")
        trial = _Trial(file=file, models=world.absolute().parent.parent, drivers=drivers, step=step_of(text))
        return attempted(lambda: trial.run(here, seconds, progress))


@dataclass(frozen=True, kw_only=True, slots=True)
class _Trial:
    """One attempt: a world with its robots in a file, where its models are, and the seconds that a step is."""

    file: Path
    models: Path
    drivers: Sequence[Driver]
    step: float

    def run(self, here: Installation, seconds: float, progress: Callable[[float], None]) -> Drive:
        """In a server of its own."""
        simulator, seen = here.simulator, Record()
        with serving(here, self.file, models=self.models, options=simulator.recording(PERIOD)) as server:
            with server.live() as live:
                drive_in_steps(live, self.drivers, seconds, self.step, progress, seen)
            errors = server.errors
            server.stop()
            states = simulator.record(server.home) or seen
        return Drive(tracks={driver.name: _track(driver.name, states) for driver in self.drivers}, errors=errors)


def drive_in_steps(
    live: LiveWorld,
    drivers: Sequence[Driver],
    seconds: float,
    step: float,
    progress: Callable[[float], None] = lambda _: None,
    seen: Record | None = None,
) -> None:
    """Ask for each robot's motion, tell it, go on for a period, and so on for so many simulated seconds.

    step: the seconds of a step of the world's physics; `seen` is given where they were at each period's beginning.
    """
    routes = {driver.name: driver.route() for driver in drivers}
    period = min(route.period for route in routes.values())
    for turn in range(ceil(seconds / period)):
        poses = live.poses()
        if seen is not None:
            seen.append((turn * period, {driver.name: list(astuple(poses[driver.name])) for driver in drivers}))
        for driver in drivers:
            v, w = routes[driver.name].motion(poses[driver.name])
            live.tell(driver.robot.command(driver.name, v, w, live.dialect))
        done = min((turn + 1) * period, seconds)
        live.advance(round((done - turn * period) / step))
        progress(done)


def _track(name: str, states: Record) -> Track:
    rows = [[second, *poses[name]] for second, poses in states if name in poses]
    if not rows:
        raise SimulatorFailed(f"the simulator kept no record of {name}")
    return Track(rows=np.array(rows))
