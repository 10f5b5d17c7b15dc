"""Robots driven over a world in a simulator server, and the record of their poses and contacts."""

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
from rsegen.simulation.driving.way import PlannedWay
from rsegen.simulation.driving.world_with_robots import time_step, world_with_robots
from rsegen.simulation.robots.base import DrivableRobot
from rsegen.simulation.simulators import Installation
from rsegen.simulation.simulators.live_world import Contact, LiveWorld, Pose, Record
from rsegen.simulation.simulators.server import retried, running_server

PERIOD = 0.05
"""Seconds between two rows of a trajectory."""

_SAME = 1e-4
"""Seconds between two times that are one."""


@dataclass(frozen=True, kw_only=True, slots=True)
class RobotRun:
    """A robot with its name in the world, its start pose, and a function that makes its route for each attempt.

    unevenness: by how much the ground at its start is too uneven for it, metres; 0 where it starts level; way: the one
    that its route follows
    """

    name: str
    robot: DrivableRobot
    start: Pose
    route: Callable[[], Route]
    unevenness: float = 0.0
    way: PlannedWay | None = None


@dataclass(frozen=True, kw_only=True, slots=True)
class DriveRecording:
    """The trajectory of every robot by its name, the contact samples, the simulator's error lines, a JPEG if asked.

    There are no samples if contacts were not wanted, or if the simulator does not report any.
    """

    trajectories: Mapping[str, Trajectory]
    samples: ContactSamples
    errors: Sequence[str]
    image: bytes = b""


def record_drive(  # noqa: PLR0913  # each is a parameter of rsegen.drive
    here: Installation,
    world: Path,
    runs: Sequence[RobotRun],
    seconds: float,
    progress: Callable[[float], None] = lambda _: None,
    *,
    contacts: bool = True,
    camera_extent: tuple[float, float] | None = None,
) -> DriveRecording:
    """The recording of robots that drive for `seconds` of simulation time; if the server fails, it is tried again.

    The same runs, world and simulator give the same trajectories. `progress` is called with the simulated seconds that
    are done; contacts: sample them, as in `drive_in_steps`; camera_extent: size in metres of the map that a camera
    looks at, which needs a screen.
    """
    with tempfile.TemporaryDirectory(prefix="rsegen-") as folder:
        frames = Path(folder, "frames")
        models = [run.robot.model(run.name, here.backend, astuple(run.start)) for run in runs]
        models = [here.simulator.with_contact_sensors(model) for model in models] if contacts else models
        extra = [camera(camera_extent, frames)] if camera_extent else []
        text = world_with_robots(world, [*models, *extra], unthrottled=True, backend=here.backend)
        file = Path(folder, world.name)
        file.write_text(text, "utf-8")
        folder_of_models = world.absolute().parent.parent
        attempt = _Attempt(file=file, models=folder_of_models, runs=runs, step=time_step(text), contacts=contacts)
        recording = retried(lambda: attempt.recording(here, seconds, progress, screen=camera_extent is not None))
        return replace(recording, image=last_frame(frames)) if camera_extent else recording


@dataclass(frozen=True, kw_only=True, slots=True)
class _Attempt:
    """One attempt: the world file with robots, the folder of its models, the runs, the physics step in seconds, and
    whether contacts are sampled.
    """

    file: Path
    models: Path
    runs: Sequence[RobotRun]
    step: float
    contacts: bool

    def recording(
        self, here: Installation, seconds: float, progress: Callable[[float], None], *, screen: bool
    ) -> DriveRecording:
        """The recording made in a server of its own."""
        simulator, poses = here.simulator, Record()
        options = simulator.record_options(PERIOD)
        with running_server(here, self.file, models=self.models, options=options, screen=screen) as server:
            with server.connect() as live:
                live.record([run.name for run in self.runs])
                contacts = self.contacts and live.watch_contacts()
                samples = drive_in_steps(live, self.runs, seconds, self.step, progress, poses, contacts=contacts)
                end, recorded = live.clock().simulated, live.recorded()
            errors = server.errors
            server.stop()
            record = _from_the_start(simulator.read_record(server.home) or recorded or poses, poses)
        trajectories = {run.name: _trajectory(run.name, record, end) for run in self.runs}
        return DriveRecording(trajectories=trajectories, samples=samples, errors=errors)


def drive_in_steps(  # noqa: PLR0913  # what a drive is made of
    live: LiveWorld,
    runs: Sequence[RobotRun],
    seconds: float,
    step: float,
    progress: Callable[[float], None] = lambda _: None,
    record: Record | None = None,
    *,
    contacts: bool = True,
) -> ContactSamples:
    """The contact samples of a drive: each period, routes decide on motions, robots get commands, the world steps.

    It ends after `seconds` of simulation time, or when all routes are done. step: seconds of a physics step of the
    world; the poses at the beginning of each period are appended to `record`. Without `contacts` there are no samples.
    """
    routes = {run.name: run.route() for run in runs}
    period = min(route.period for route in routes.values())
    samples: list[tuple[float, Sequence[Contact]]] = []
    for turn in range(ceil(round(seconds / step) / round(period / step))):
        poses = live.poses()
        if record is not None:
            record.append((turn * period, {run.name: list(astuple(poses[run.name])) for run in runs}))
        if all(route.is_done(poses[name]) for name, route in routes.items()):
            break
        send_commands(live, runs, routes, poses)
        done = min((turn + 1) * period, seconds)
        steps = round((done - turn * period) / step)
        if contacts:
            samples.append((turn * period, live.step_with_contacts(steps)))
        else:
            live.step(steps)
        progress(done)
    return samples


def send_commands(
    live: LiveWorld, runs: Sequence[RobotRun], routes: Mapping[str, Route], poses: Mapping[str, Pose]
) -> None:
    """Send every robot the command for the motion that its route wants at its pose."""
    for run in runs:
        v, w = routes[run.name].motion(poses[run.name])
        live.send_command(run.robot.command(run.name, v, w, live.backend))


def _trajectory(name: str, record: Record, end: float) -> Trajectory:
    """The trajectory of a robot; a record has no states for times at which nothing moved, so `end` may be added."""
    rows = [[second, *poses[name]] for second, poses in record if name in poses]
    if not rows:
        raise SimulatorFailed(f"the simulator kept no record of {name}")
    last = [[end, *rows[-1][1:]]] if end > rows[-1][0] + _SAME else []
    return Trajectory(rows=np.array([*rows, *last]))


def _from_the_start(record: Record, poses: Record) -> Record:
    """A record with the first of these poses, which a server that records after its first steps does not have."""
    return [*poses[:1], *record] if poses and record[0][0] > poses[0][0] + _SAME else record
