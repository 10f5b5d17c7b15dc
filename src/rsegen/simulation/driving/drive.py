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
from rsegen.simulation.driving.contacts import ContactSamples
from rsegen.simulation.driving.drive_metrics import Trajectory
from rsegen.simulation.driving.routes import Route
from rsegen.simulation.driving.world_with_robots import time_step, world_with_robots
from rsegen.simulation.robots.base import DrivableRobot
from rsegen.simulation.simulators import Installation
from rsegen.simulation.simulators.live_world import Contact, LiveWorld, Pose, Record
from rsegen.simulation.simulators.server import retried, running_server

PERIOD = 0.05
"""Seconds between two rows of a track."""


@dataclass(frozen=True, kw_only=True, slots=True)
class RobotRun:
    """A robot under a name, where it starts, and how it drives. Its route is made anew for every attempt."""

    name: str
    robot: DrivableRobot
    start: Pose
    route: Callable[[], Route]


@dataclass(frozen=True, kw_only=True, slots=True)
class DriveResult:
    """The track of every robot by its name, what touched what, the simulator's error lines, what its camera saw."""

    trajectories: Mapping[str, Trajectory]
    samples: ContactSamples
    errors: Sequence[str]
    seen: bytes = b""


def driven(
    here: Installation,
    world: Path,
    runs: Sequence[RobotRun],
    seconds: float,
    progress: Callable[[float], None] = lambda _: None,
    *,
    watched: tuple[float, float] | None = None,
) -> DriveResult:
    """Drive all of them for so many simulated seconds; a server that is lost is tried again.

    The same drivers, world and simulator give the same tracks; `progress` is told the seconds that are done. `watched`
    is the extent of what a camera looks at, metres; it needs a screen.
    """
    with tempfile.TemporaryDirectory(prefix="rsegen-") as folder:
        frames = Path(folder, "frames")
        models = [run.robot.model(run.name, here.backend, astuple(run.start)) for run in runs]
        text = world_with_robots(world, [*models, camera(watched, frames)] if watched else models, unthrottled=True)
        file = Path(folder, world.name)
        file.write_text(text, "utf-8")
        trial = _Trial(file=file, models=world.absolute().parent.parent, runs=runs, step=time_step(text))
        drive = retried(lambda: trial.run(here, seconds, progress, screen=watched is not None))
        return replace(drive, seen=last_frame(frames)) if watched else drive


@dataclass(frozen=True, kw_only=True, slots=True)
class _Trial:
    """One attempt: a world with its robots in a file, where its models are, and the seconds that a step is."""

    file: Path
    models: Path
    runs: Sequence[RobotRun]
    step: float

    def run(
        self, here: Installation, seconds: float, progress: Callable[[float], None], *, screen: bool
    ) -> DriveResult:
        """In a server of its own."""
        simulator, seen = here.simulator, Record()
        options = simulator.record_options(PERIOD)
        with running_server(here, self.file, models=self.models, options=options, screen=screen) as server:
            with server.connect() as live:
                samples = drive_in_steps(live, self.runs, seconds, self.step, progress, seen)
                end = live.clock().simulated
            errors = server.errors
            server.stop()
            states = simulator.read_record(server.home) or seen
        trajectories = {run.name: _track(run.name, states, end) for run in self.runs}
        return DriveResult(trajectories=trajectories, samples=samples, errors=errors)


def drive_in_steps(
    live: LiveWorld,
    runs: Sequence[RobotRun],
    seconds: float,
    step: float,
    progress: Callable[[float], None] = lambda _: None,
    seen: Record | None = None,
) -> ContactSamples:
    """Ask for each robot's motion, tell it, go on for a period, and so on for so many simulated seconds, or until all
    are done.

    step: the seconds of a step of the world's physics; `seen` is given where they were at each period's beginning; what
    touched what then is what comes back.
    """
    routes = {run.name: run.route() for run in runs}
    period = min(route.period for route in routes.values())
    samples: list[tuple[float, Sequence[Contact]]] = []
    for turn in range(ceil(round(seconds / step) / round(period / step))):
        poses = live.poses()
        if seen is not None:
            seen.append((turn * period, {run.name: list(astuple(poses[run.name])) for run in runs}))
        if all(route.is_done(poses[name]) for name, route in routes.items()):
            break
        send_commands(live, runs, routes, poses)
        done = min((turn + 1) * period, seconds)
        samples.append((turn * period, live.step_with_contacts(round((done - turn * period) / step))))
        progress(done)
    return samples


def send_commands(
    live: LiveWorld, runs: Sequence[RobotRun], routes: Mapping[str, Route], poses: Mapping[str, Pose]
) -> None:
    """Tell every robot what its route asks for where it is."""
    for run in runs:
        v, w = routes[run.name].motion(poses[run.name])
        live.send_command(run.robot.command(run.name, v, w, live.backend))


def _track(name: str, states: Record, end: float) -> Trajectory:
    """The rows of a robot; a record says nothing of a time in which nothing moved."""
    rows = [[second, *poses[name]] for second, poses in states if name in poses]
    if not rows:
        raise SimulatorFailed(f"the simulator kept no record of {name}")
    return Trajectory(rows=np.array([*rows, [max(end, rows[-1][0]), *rows[-1][1:]]]))
