"""A server of a trial, in which robots drive randomly, and what that costs: clocks, CPU time, memory, frames.

All clocks are read while the world is paused, before and after a span, so they belong to the same moment. CPU time is
that of the server's process; the machine's own load is measured too, as it tells how far a real-time factor is the
map's. Frames are drawn by a camera in the server, or by the simulator's own window, and counted by their messages.
What breaks it: a machine so busy that a span takes twenty times as long, which ends the trial.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import astuple, dataclass, field
from functools import partial
from math import ceil
from pathlib import Path
from typing import Literal

from rsegen.errors import NoSimulator, ParameterError, SimulatorFailed
from rsegen.exporters.scene import Scene
from rsegen.simulation.driving.recording import RobotRun, send_commands
from rsegen.simulation.driving.routes import Route
from rsegen.simulation.experiment.machine import busy, gpu_load
from rsegen.simulation.experiment.plan import ExperimentPlan
from rsegen.simulation.simulators import Installation
from rsegen.simulation.simulators.live_world import LiveWorld, Record
from rsegen.simulation.simulators.process import running, usage
from rsegen.simulation.simulators.server import Server, has_screen, running_server

SOURCES = ("camera", "window")
"""The paces in which frames are drawn."""

CAMERA_PIXELS = (640, 480)
"""Width and height of the camera's pictures: those of a usual robot's camera; frames per second fall with the area."""

_FIRST_FRAME = 120.0
"""Seconds within which the first frame must be drawn: a renderer without a GPU is slow to begin.

With less, trials that work would end; with more, a screen without OpenGL is reported later.
"""

SETTLED = 2.0
"""Simulated seconds before measuring begins, in which robots fall to the ground and start to drive."""

REST = 1.0
"""Seconds between two looks for the first frame."""

LOOKS = 0.05
"""Seconds between two looks at the poses of robots: two per row of a trajectory, as poses come when they like."""

PERIOD = 0.1
"""Simulated seconds between two rows of a trajectory, or more if the world is simulated faster than is looked."""

_SLOWEST = 20
"""Times of a span within which it must end: a slower world is stuck, or the machine does something else."""


def refuse_without_frames(plan: ExperimentPlan, installed: Mapping[str, Installation]) -> None:
    """Raise a UserError, before any trial, if a pace of the plan needs a screen or a window that there is not."""
    for source in (pace for pace in plan.paces if pace in SOURCES):
        for here in installed.values():
            if source not in here.simulator.frames:
                raise ParameterError("paces", f"frames of {here} cannot be counted; leave {source} out, or use classic")
            if source == "window" and "gzclient" not in here.commands:
                raise ParameterError("paces", f"the window of {here} is not installed; leave window out")
        if not has_screen():
            raise ParameterError("paces", f"{source} needs a screen, and there is none; run under xvfb-run -a")


@contextmanager
def window_of(server: Server) -> Iterator[None]:
    """The simulator's own window on the world of a server, as long as this lasts."""
    launch = server.here.simulator.window(server.here, server.launch)
    if launch is None:
        raise NoSimulator(f"{server.here}: its window is not installed")
    with (server.home / "window.log").open("w", encoding="utf-8") as log, running(launch, log):
        yield


def wait_for_frames(frames: Callable[[], int], source: str, wait: Callable[[float], object]) -> None:
    """Wait until a frame has been drawn; `wait` waits for some seconds. NoSimulator if none is."""
    for _ in range(ceil(_FIRST_FRAME / REST)):
        if frames():
            return
        wait(REST)
    raise NoSimulator(f"the {source} drew nothing in {_FIRST_FRAME:g} s: does this screen have OpenGL?")


@dataclass(frozen=True, kw_only=True, slots=True)
class Setup:
    """A world file with robots on a map, their runs, and how they are simulated.

    rest: seconds between commands; real: in real time; frames: the source that draws frames, None for none
    """

    file: Path
    scene: Scene
    runs: Sequence[RobotRun]
    rest: float
    real: bool
    frames: str | None = None


@dataclass(frozen=True, kw_only=True, slots=True)
class Measurement:
    """Seconds of simulation, wall and CPU time; real-time factors and loads of the GPU, 0..1, between commands.

    busy: seconds of CPU time of the whole machine, by its number of processors; frames: those that were drawn
    """

    simulated: float
    real: float
    cpu: float
    busy: float
    frames: int
    factors: Sequence[float]
    gpu: Sequence[float]

    @property
    def speed(self) -> float:
        """Simulated seconds per second of CPU, which the system counts in hundredths."""
        return self.simulated / max(self.cpu, 0.01)

    @property
    def cores(self) -> float:
        """Processors that the server used."""
        return self.cpu / max(self.real, 1e-9)


def total(spans: Sequence[Measurement]) -> Measurement:
    """Return the sum of spans."""
    return Measurement(
        simulated=sum(span.simulated for span in spans),
        real=sum(span.real for span in spans),
        cpu=sum(span.cpu for span in spans),
        busy=sum(span.busy for span in spans),
        frames=sum(span.frames for span in spans),
        factors=[factor for span in spans for factor in span.factors],
        gpu=[load for span in spans for load in span.gpu],
    )


@dataclass(frozen=True, kw_only=True, slots=True)
class TrialServer:
    """A running server that took `load` seconds to load its setup, the routes of its robots, and their record.

    watch: called several times per second while robots drive; may raise
    """

    live: LiveWorld
    pid: int
    load: float
    setup: Setup
    routes: Mapping[str, Route]
    frames: Callable[[], int]
    watch: Callable[[], None]
    record: Record = field(default_factory=list)

    @property
    def memory(self) -> float:
        """Memory of the server in MB."""
        return usage(self.pid).memory

    def measure(self, seconds: float) -> Measurement:
        """Measure `seconds` of wall time, paused only before and after, so that all clocks are exact."""
        start, cpu, machine, frames = self.live.clock(), usage(self.pid).cpu, busy(), self.frames()
        samples = self.run_robots("real", seconds, self.record)
        end = self.live.clock()
        return Measurement(
            simulated=end.simulated - start.simulated,
            real=end.real - start.real,
            cpu=usage(self.pid).cpu - cpu,
            busy=busy() - machine,
            frames=self.frames() - frames,
            factors=[factor for factor, _ in samples],
            gpu=[load for _, load in samples if load is not None],
        )

    def run_robots(
        self, clock: Literal["simulated", "real"], seconds: float, record: Record | None = None
    ) -> list[tuple[float, float | None]]:
        """Let robots drive for this many simulated or real seconds.

        Gives the real-time factor and the load of the GPU between commands; poses are added to `record`.
        """
        # Between two commands the world runs freely; each interval gives a real-time factor.
        start = last = self.live.clock()
        samples, end = [], time.monotonic() + _SLOWEST * seconds
        self.live.unpause()
        while getattr(last, clock) < getattr(start, clock) + seconds:
            send_commands(self.live, self.setup.runs, self.routes, self.live.poses())
            self._rest(record)
            now = self.live.clock()
            if time.monotonic() > end:
                raise SimulatorFailed(f"{now.simulated - start.simulated:g} s simulated in {_SLOWEST * seconds:g} s")
            factor = (now.simulated - last.simulated) / max(now.real - last.real, 1e-9)
            samples.append((factor, gpu_load() if self.setup.real else None))
            last = now
        self.live.pause()
        return samples

    def _rest(self, record: Record | None) -> None:
        """Wait until the next command, and add the poses of robots to a record as they come."""
        end = time.monotonic() + self.setup.rest
        while (left := end - time.monotonic()) > 0:
            time.sleep(min(left, LOOKS))
            self.watch()
            if record is not None:
                self._look(record)

    def _look(self, record: Record) -> None:
        """Add the last poses of robots to a record, unless it has some that are hardly older."""
        second, poses = self.live.last_poses()
        here = {run.name: list(astuple(poses[run.name])) for run in self.setup.runs if run.name in poses}
        if here and (not record or second >= record[-1][0] + PERIOD):
            record.append((second, here))


@contextmanager
def trial_server(setup: Setup, here: Installation, watch: Callable[[], None]) -> Iterator[TrialServer]:
    """Start a server of a trial, in which the robots have fallen to the ground and started to drive."""
    # Loading ends with the connection: what comes later, window, first frame and settling, is not its time.
    began = time.monotonic()
    with ExitStack() as stack:
        screen = setup.frames == "camera"
        running = running_server(here, setup.file, screen=screen, watch=watch)
        server = stack.enter_context(running)
        live = stack.enter_context(server.connect())
        live.stop_recording()
        load, routes = time.monotonic() - began, {run.name: run.route() for run in setup.runs}
        frames = live.frame_counter(setup.frames) if setup.frames else lambda: 0
        trial = TrialServer(
            live=live, pid=server.pid, load=load, setup=setup, routes=routes, frames=frames, watch=watch
        )
        if setup.frames == "window":
            stack.enter_context(window_of(server))
            wait_for_frames(frames, setup.frames, time.sleep)  # a window draws a paused world too
        live.last_poses()
        trial.run_robots("simulated", SETTLED)
        if setup.frames == "camera":
            wait_for_frames(frames, setup.frames, partial(trial.run_robots, "real"))
        yield trial
