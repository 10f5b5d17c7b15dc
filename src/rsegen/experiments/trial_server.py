"""A server of a trial: it loads a world, lets robots drive randomly in it, and measures the cost.

All clocks are read while the world is paused, before and after a span, so they belong to the same moment. CPU time is
measured of the server's process, and also the load of the whole machine, which shows how far a real-time factor is due
to the map. Frames are drawn by a camera in the server, or by the simulator's own window, and counted by their messages.
What breaks it: a machine so busy that a span takes twenty times as long, which ends the trial.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import astuple, dataclass, field
from functools import partial
from math import ceil
from pathlib import Path
from typing import Literal, NamedTuple, TypeAlias

from rsegen.driving.recording import RobotRun, send_commands
from rsegen.driving.robot_runs import robot_runs
from rsegen.driving.routes import Route, Wandering
from rsegen.driving.world_file import camera_model, world_with_robots
from rsegen.errors import NoSimulator, NoSpot, ParameterError, SimulatorFailed
from rsegen.experiments.plan import IN_REAL_TIME, Cell, ExperimentPlan, TableRow
from rsegen.gazebo import sdf
from rsegen.scene.scene import Scene, compose
from rsegen.simulators.base import Installation
from rsegen.simulators.embedded import EmbeddedSimulator, PlacedRobot
from rsegen.simulators.embedded_process import Task, world_in_process
from rsegen.simulators.live_world import RunningWorld
from rsegen.simulators.poses import Record
from rsegen.simulators.process import usage
from rsegen.simulators.server import running_server
from rsegen.writing.programs import has_screen, running
from rsegen.writing.target_worlds import write_world

# The load of the machine, by the server and by all other programs.


def busy() -> float:
    """Return the seconds that the machine's processors have worked so far, divided by their number."""
    import psutil

    times = psutil.cpu_times()
    idle = times.idle + getattr(times, "iowait", 0.0)
    guests = getattr(times, "guest", 0.0) + getattr(times, "guest_nice", 0.0)  # Linux counts them as time of users too
    return float(sum(times) - idle - guests) / (os.cpu_count() or 1)


def gpu_load() -> float | None:
    """Return the load of the busiest GPU just now, 0..1; None if no GPU reports it (NVIDIA's do, AMD's on Linux)."""
    percents = ""  # a line each
    if command := shutil.which("nvidia-smi"):
        query = [command, "--query-gpu=utilization.gpu", "--format=csv,noheader,nounits"]
        with suppress(OSError, subprocess.SubprocessError):
            percents = subprocess.run(query, capture_output=True, text=True, timeout=5, check=True).stdout  # noqa: S603  # no shell
    if not percents:
        with suppress(OSError):  # the files of AMD's driver
            percents = "".join(
                file.read_text() for file in Path("/sys/class/drm").glob("card*/device/gpu_busy_percent")
            )
    loads = [int(percent) for percent in re.findall(r"^\d+$", percents, re.MULTILINE)]
    return max(loads) / 100 if loads else None


# A server, in which robots drive randomly.


SOURCES = ("camera", "window")
"""The paces in which frames are drawn."""

CAMERA_PIXELS = (640, 480)
"""Width and height of the camera's pictures, as of a usual robot's camera; frames per second fall with the area."""

_FIRST_FRAME = 120.0
"""Seconds within which the first frame must be drawn: a renderer without a GPU is slow to begin.

With less, trials that work would end; with more, a screen without OpenGL is reported later.
"""

SETTLED = 2.0
"""Simulated seconds before measuring begins, in which robots fall to the ground and start to drive."""

_FRAME_LOOK = 1.0
"""Seconds between two looks for the first frame."""

LOOKS = 0.05
"""Seconds between two looks at the poses of robots: two per row of a trajectory, as poses come at no fixed times."""

PERIOD = 0.1
"""Simulated seconds between two rows of a trajectory; more if more of them pass between two looks."""

REST, REST_AT_FULL_SPEED = 1.0, 0.2
"""Wall seconds between commands: about a simulated second, as small worlds run five times as fast as real time."""

_SLOWEST = 20
"""Times of its length within which a span must end: a slower world is stuck, or the machine is busy."""


TrialSimulator: TypeAlias = Installation | EmbeddedSimulator
"""Simulator of a trial: a Gazebo, or an embedded one, in its own process."""


def refuse_without_frames(plan: ExperimentPlan, installed: Mapping[str, TrialSimulator]) -> None:
    """Raise a UserError, before any trial, if a pace of the plan needs a missing screen, window or frame counter."""
    for source in (pace for pace in plan.paces if pace in SOURCES):
        for used in installed.values():
            if isinstance(used, EmbeddedSimulator) or source not in used.simulator.frames:
                raise ParameterError("paces", f"frames of {used} cannot be counted; leave {source} out, or use classic")
            if source == "window" and "gzclient" not in used.commands:
                raise ParameterError("paces", f"the window of {used} is not installed; leave window out")
        if not has_screen():
            raise ParameterError("paces", f"{source} needs a screen, and there is none; run under xvfb-run -a")


def wait_for_frames(frames: Callable[[], int], source: str, wait: Callable[[float], object]) -> None:
    """Wait until a frame has been drawn; NoSimulator if that takes too long; wait: waits for some seconds."""
    for _ in range(ceil(_FIRST_FRAME / _FRAME_LOOK)):
        if frames():
            return
        wait(_FRAME_LOOK)
    raise NoSimulator(f"the {source} drew nothing in {_FIRST_FRAME:g} s: does this screen have OpenGL?")


class Measurement(NamedTuple):
    """Seconds of simulation, wall and CPU time; real-time factors and loads of the GPU, 0..1, between commands.

    busy: seconds of CPU time of the whole machine, divided by its number of processors; frames: number of drawn ones
    """

    simulated: float
    real: float
    cpu: float
    busy: float
    frames: int
    factors: list[float]
    gpu: list[float]

    @property
    def speed(self) -> float:
        """Simulated seconds per second of CPU, which the system counts in hundredths."""
        return self.simulated / max(self.cpu, 0.01)

    @property
    def cores(self) -> float:
        """Processors that the server used."""
        return self.cpu / max(self.real, 1e-9)


def total(spans: Sequence[Measurement]) -> Measurement:
    """Return the sum of spans, with their lists joined: `+` does both."""
    return Measurement(*(sum(parts, start=type(parts[0])()) for parts in zip(*spans, strict=True)))


@dataclass(frozen=True, kw_only=True, slots=True)
class TrialServer:
    """A running server that took `load` seconds to load its world, the robots on a map in it, and their record.

    pace: of the trial; frames: returns the number of frames drawn so far
    watch: called several times per second while robots drive; may raise
    """

    live: RunningWorld
    pid: int
    load: float
    pace: str
    scene: Scene
    runs: Sequence[RobotRun]
    routes: Mapping[str, Route]
    frames: Callable[[], int]
    watch: Callable[[], None]
    record: Record = field(default_factory=list)

    @property
    def is_real(self) -> bool:
        """Return whether the world is simulated in real time."""
        return self.pace in IN_REAL_TIME

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
        """Let robots drive for this many simulated or real seconds; add their poses to `record`.

        Returns the real-time factor and the load of the GPU between each two commands.
        """
        # Between two commands the world runs freely; each interval gives a real-time factor.
        start = last = self.live.clock()
        samples, end = [], time.monotonic() + _SLOWEST * seconds
        self.live.unpause()
        while getattr(last, clock) < getattr(start, clock) + seconds:
            send_commands(self.live, self.runs, self.routes, self.live.poses())
            self._rest(record)
            now = self.live.clock()
            if time.monotonic() > end:
                raise SimulatorFailed(f"{now.simulated - start.simulated:g} s simulated in {_SLOWEST * seconds:g} s")
            factor = (now.simulated - last.simulated) / max(now.real - last.real, 1e-9)
            samples.append((factor, gpu_load() if self.is_real else None))
            last = now
        self.live.pause()
        return samples

    def _rest(self, record: Record | None) -> None:
        """Wait until the next command, and add the poses of robots to a record as they come."""
        end = time.monotonic() + (REST if self.is_real else REST_AT_FULL_SPEED)
        while (left := end - time.monotonic()) > 0:
            time.sleep(min(left, LOOKS))
            self.watch()
            if record is None:
                continue
            second, poses = self.live.last_poses()
            known = {run.name: list(astuple(poses[run.name])) for run in self.runs if run.name in poses}
            if known and (not record or second >= record[-1][0] + PERIOD):
                record.append((second, known))


def runs_of_row(row: TableRow, scene: Scene, seed: int) -> Sequence[RobotRun]:
    """Return the runs of the robots of a row on one of its maps."""
    return robot_runs(scene.field, row.model, Wandering.name, count=row.robots, seed=seed, evenest=True)


ROOMS = (1, 2, 4, 8, 16)
"""Chunks along each side of the ground of an empty world on which robots start; the first with room for all is taken.
Robots start at spots as on a map, so that both worlds differ by the map alone."""


def placed(row: TableRow, size: int, seed: int) -> tuple[Scene, Sequence[RobotRun]]:
    """Return a map of a row, or for 0 blocks the ground of an empty world, and the runs of the robots on it."""
    for room in () if size else ROOMS[:-1]:
        with suppress(NoSpot):
            return _placed(row, size, seed, room)
    return _placed(row, size, seed, ROOMS[-1])


def _placed(row: TableRow, size: int, seed: int, room: int) -> tuple[Scene, Sequence[RobotRun]]:
    scene = compose(row.map_of(size, seed, room))
    return scene, runs_of_row(row, scene, seed)


@contextmanager
def trial_server(
    plan: ExperimentPlan, cell: Cell, seed: int, here: TrialSimulator, watch: Callable[[], None]
) -> Iterator[TrialServer]:
    """Start a server of a trial, in which the robots have fallen to the ground and started to drive."""
    row = plan.rows[cell.row]
    try:
        scene, runs = placed(row, cell.size, seed)
    except NoSpot as error:  # of a map larger than the smallest one of its row, which has been tried
        raise error.of(cell.name) from None
    routes = {run.name: run.route() for run in runs}
    made = partial(TrialServer, pace=cell.pace, scene=scene, runs=runs, routes=routes, watch=watch)
    if isinstance(here, EmbeddedSimulator):
        started = _process(cell, scene, runs, here, made)
    else:
        started = _server(cell, scene, runs, here, made, watch)
    with started as trial:
        yield trial


@contextmanager
def _process(
    cell: Cell, scene: Scene, runs: Sequence[RobotRun], here: EmbeddedSimulator, made: Callable[..., TrialServer]
) -> Iterator[TrialServer]:
    """Start the process of a trial in an embedded simulator; its whole start counts as loading.

    made: makes the trial's server from the parts that are known once it runs
    """
    placed = [PlacedRobot(name=run.name, robot=run.robot, start=run.start) for run in runs]
    is_real, began = cell.pace in IN_REAL_TIME, time.monotonic()
    with world_in_process(Task(simulator=here.name, recipe=scene.recipe, robots=placed, is_real=is_real)) as live:
        trial = made(live=live, pid=live.pid, load=time.monotonic() - began, frames=lambda: 0)
        trial.run_robots("simulated", SETTLED)
        yield trial


@contextmanager
def _server(
    cell: Cell,
    scene: Scene,
    runs: Sequence[RobotRun],
    here: Installation,
    made: Callable[..., TrialServer],
    watch: Callable[[], None],
) -> Iterator[TrialServer]:
    """Start the server of a trial in a Gazebo; made: as in `_process`."""
    source = cell.pace if cell.pace in SOURCES else None
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="rsegen-")))
        file = _write_trial(cell, scene, runs, here, folder)
        # Loading ends with the connection: window, first frame and settling come later, and do not count.
        began = time.monotonic()
        server = stack.enter_context(running_server(here, file, screen=source == "camera", watch=watch))
        live = stack.enter_context(server.connect())
        live.stop_recording()
        loaded = time.monotonic()
        frames = live.frame_counter(source) if source else lambda: 0
        trial = made(live=live, pid=server.pid, load=loaded - began, frames=frames)
        if source == "window":
            window = here.simulator.window(here, server.launch)
            if window is None:
                raise NoSimulator(f"{here}: its window is not installed")
            log = stack.enter_context((server.home / "window.log").open("w", encoding="utf-8"))
            stack.enter_context(running(window, log))
            wait_for_frames(trial.frames, source, time.sleep)  # a window draws a paused world too
        live.last_poses()
        trial.run_robots("simulated", SETTLED)
        if source == "camera":
            wait_for_frames(trial.frames, source, partial(trial.run_robots, "real"))
        yield trial


def _write_trial(cell: Cell, scene: Scene, runs: Sequence[RobotRun], here: Installation, folder: Path) -> Path:
    """Write the world file of a trial: robots, perhaps a camera, and a map unless the cell is empty."""
    models = [run.robot.model(run.name, here.backend, astuple(run.start)) for run in runs]
    models += [camera_model(scene.field.extent, CAMERA_PIXELS, rate=0)] if cell.pace == "camera" else []
    if cell.size:
        world = write_world(scene, folder)
    else:
        world = folder / "empty.world"
        world.write_bytes(b"".join(sdf.utf8(sdf.world(scene, ()))))
    unthrottled, file = cell.pace not in IN_REAL_TIME, world.with_name("experiment.world")
    file.write_text(world_with_robots(world, models, unthrottled=unthrottled, backend=here.backend), "utf-8")
    return file
