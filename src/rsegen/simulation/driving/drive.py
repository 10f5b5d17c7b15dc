"""Robots driven over a world in a simulator, and where they were meanwhile."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import astuple, dataclass, replace
from math import ceil
from pathlib import Path

import numpy as np

from rsegen.errors import SimulatorFailed
from rsegen.simulation.driving.camera import camera, last_frame
from rsegen.simulation.driving.contacts import Looks
from rsegen.simulation.driving.drive_metrics import Track
from rsegen.simulation.driving.routes import Route
from rsegen.simulation.driving.world_with_robots import arena, step_of
from rsegen.simulation.robots.base import Driven
from rsegen.simulation.simulators import Installation
from rsegen.simulation.simulators.live import Contact, LiveWorld, Pose, Record
from rsegen.simulation.simulators.server import attempted, serving

PERIOD = 0.05
"""Seconds between two rows of a track."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Driver:
    """A robot under a name, where it starts, and how it drives. Its route is made anew for every attempt."""

    name: str
    robot: Driven
    start: Pose
    route: Callable[[], Route]


@dataclass(frozen=True, kw_only=True, slots=True)
class Drive:
    """The track of every robot by its name, what touched what, the simulator's error lines, what its camera saw."""

    tracks: Mapping[str, Track]
    looks: Looks
    errors: Sequence[str]
    seen: bytes = b""


def driven(
    here: Installation,
    world: Path,
    drivers: Sequence[Driver],
    seconds: float,
    progress: Callable[[float], None] = lambda _: None,
    *,
    watched: tuple[float, float] | None = None,
) -> Drive:
    """Drive all of them for so many simulated seconds; a server that is lost is tried again.

    The same drivers, world and simulator give the same tracks; `progress` is told the seconds that are done. `watched`
    is the extent of what a camera looks at, metres; it needs a screen.
    """
    with tempfile.TemporaryDirectory(prefix="rsegen-") as folder:
        frames = Path(folder, "frames")
        models = [driver.robot.model(driver.name, here.dialect, astuple(driver.start)) for driver in drivers]
        text = arena(world, [*models, camera(watched, frames)] if watched else models, unthrottled=True)
        file = Path(folder, world.name)
        file.write_text(text, "utf-8")
        trial = _Trial(file=file, models=world.absolute().parent.parent, drivers=drivers, step=step_of(text))
        drive = attempted(lambda: trial.run(here, seconds, progress, screen=watched is not None))
        return replace(drive, seen=last_frame(frames)) if watched else drive


@dataclass(frozen=True, kw_only=True, slots=True)
class _Trial:
    """One attempt: a world with its robots in a file, where its models are, and the seconds that a step is."""

    file: Path
    models: Path
    drivers: Sequence[Driver]
    step: float

    def run(self, here: Installation, seconds: float, progress: Callable[[float], None], *, screen: bool) -> Drive:
        """In a server of its own."""
        simulator, seen = here.simulator, Record()
        options = simulator.recording(PERIOD)
        with serving(here, self.file, models=self.models, options=options, screen=screen) as server:
            with server.live() as live:
                looks = drive_in_steps(live, self.drivers, seconds, self.step, progress, seen)
                end = live.clock().simulated
            errors = server.errors
            server.stop()
            states = simulator.record(server.home) or seen
        tracks = {driver.name: _track(driver.name, states, end) for driver in self.drivers}
        return Drive(tracks=tracks, looks=looks, errors=errors)


def drive_in_steps(
    live: LiveWorld,
    drivers: Sequence[Driver],
    seconds: float,
    step: float,
    progress: Callable[[float], None] = lambda _: None,
    seen: Record | None = None,
) -> Looks:
    """Ask for each robot's motion, tell it, go on for a period, and so on for so many simulated seconds, or until all
    are done.

    step: the seconds of a step of the world's physics; `seen` is given where they were at each period's beginning; what
    touched what then is what comes back.
    """
    routes = {driver.name: driver.route() for driver in drivers}
    period = min(route.period for route in routes.values())
    looks: list[tuple[float, Sequence[Contact]]] = []
    for turn in range(ceil(round(seconds / step) / round(period / step))):
        poses = live.poses()
        if seen is not None:
            seen.append((turn * period, {driver.name: list(astuple(poses[driver.name])) for driver in drivers}))
        if all(route.is_done(poses[name]) for name, route in routes.items()):
            break
        steer(live, drivers, routes, poses)
        done = min((turn + 1) * period, seconds)
        looks.append((turn * period, live.advance_feeling(round((done - turn * period) / step))))
        progress(done)
    return looks


def steer(live: LiveWorld, drivers: Sequence[Driver], routes: Mapping[str, Route], poses: Mapping[str, Pose]) -> None:
    """Tell every robot what its route asks for where it is."""
    for driver in drivers:
        v, w = routes[driver.name].motion(poses[driver.name])
        live.tell(driver.robot.command(driver.name, v, w, live.dialect))


def _track(name: str, states: Record, end: float) -> Track:
    """The rows of a robot; a record says nothing of a time in which nothing moved."""
    rows = [[second, *poses[name]] for second, poses in states if name in poses]
    if not rows:
        raise SimulatorFailed(f"the simulator kept no record of {name}")
    return Track(rows=np.array([*rows, [max(end, rows[-1][0]), *rows[-1][1:]]]))
