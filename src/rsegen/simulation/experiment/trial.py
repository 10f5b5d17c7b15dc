"""One trial: a world with robots that drive randomly, and what it costs the simulator."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import astuple, dataclass, replace
from math import ceil
from pathlib import Path
from statistics import fmean

from rsegen.errors import inside
from rsegen.exporters.gazebo import sdf
from rsegen.exporters.scene import Scene, compose
from rsegen.run.worlds import generate
from rsegen.simulation.driving.camera import camera_model
from rsegen.simulation.driving.drive_metrics import Trajectory
from rsegen.simulation.driving.recording import RobotRun
from rsegen.simulation.driving.robot_runs import robot_runs
from rsegen.simulation.driving.routes import Wandering
from rsegen.simulation.driving.world_with_robots import world_with_robots
from rsegen.simulation.experiment.driving_figures import driving_figures, trajectories
from rsegen.simulation.experiment.frames import CAMERA_PIXELS, SOURCES
from rsegen.simulation.experiment.plan import IN_REAL_TIME, Cell, ExperimentPlan, TableRow
from rsegen.simulation.experiment.trial_server import Setup, Span, total, trial_server
from rsegen.simulation.robots import robot
from rsegen.simulation.simulators import Installation
from rsegen.simulation.simulators.server import retried

REST, REST_AT_FULL_SPEED = 1.0, 0.2
"""Seconds between commands to robots: about a simulated second."""

TURN = 1.0
"""Seconds that one of two worlds is simulated before it is the other's turn."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Outcome:
    """The measured cost of a trial, and what the robots did meanwhile.

    load: seconds until the world was loaded; memory: MB at the end; speed: simulated seconds per second of CPU
    cpu: processors that the server used while robots drove; machine: load of all processors of the machine, 0..1;
    gpu: load of the GPU, 0..1, None where there is none; rtf_min, rtf, rtf_max: real-time factors; all of these in
    real time, else None
    fps: frames per second that the camera or the window drew, at the paces `camera` and `window`, else None
    share: speed divided by that of the empty world at the pace `beside`, else None
    simulated: seconds; driven, stuck, tipped, covered: as in DrivingFigures
    """

    load: float
    memory: float
    cpu: float | None
    speed: float
    rtf_min: float | None
    rtf: float | None
    rtf_max: float | None
    share: float | None = None
    machine: float | None = None
    gpu: float | None = None
    fps: float | None = None
    simulated: float | None = None
    driven: float | None = None
    stuck: float | None = None
    tipped: float | None = None
    covered: float | None = None


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Trial:
    """One trial: its outcome, the map, and the trajectory of every robot by its name."""

    outcome: Outcome
    scene: Scene
    trajectories: Mapping[str, Trajectory]


def run_trial(
    plan: ExperimentPlan,
    cell: Cell,
    repeat: int,
    here: Installation,
    watch: Callable[[], None] = lambda: None,
) -> Trial:
    """One trial; each repeat has its own map and start poses. A failed server is tried again.

    `watch` is called several times per second; what it raises ends the trial and its servers.
    """
    cells = [cell, replace(cell, size=0)] if cell.pace == "beside" else [cell]
    with ExitStack() as stack:
        setups = [stack.enter_context(_setup(plan, each, plan.seed + repeat, here)) for each in cells]
        return retried(lambda: _trial(setups, plan.seconds, here, watch, is_empty=not cell.size))


def refuse_crowded(plan: ExperimentPlan) -> None:
    """Raise a ParameterError, before any trial, if the smallest map of a row has no room for its robots."""
    for number, row in enumerate(plan.rows):
        smallest = min((size for size in row.sizes if size), default=0)
        with inside(f"rows[{number}]"):
            for seed in range(plan.seed, plan.seed + plan.repeats) if smallest else ():
                _runs(row, compose(row.map_of(smallest, seed)), seed)


def _runs(row: TableRow, scene: Scene, seed: int) -> Sequence[RobotRun]:
    """The runs of the robots of a row on one of its maps."""
    return robot_runs(scene.field, robot(row.robot), Wandering.name, count=row.robots, seed=seed, evenest=True)


@contextmanager
def _setup(plan: ExperimentPlan, cell: Cell, seed: int, here: Installation) -> Iterator[Setup]:
    """A temporary world file with robots, of a map or empty."""
    row = plan.rows[cell.row]
    recipe = row.map_of(cell.size, seed)
    scene = compose(recipe)
    runs = _runs(row, scene, seed)
    models = [run.robot.model(run.name, here.backend, astuple(run.start)) for run in runs]
    real = cell.pace in IN_REAL_TIME
    frames = cell.pace if cell.pace in SOURCES else None
    models += [camera_model(scene.field.extent, CAMERA_PIXELS, rate=0)] if frames == "camera" else []
    with tempfile.TemporaryDirectory(prefix="rsegen-") as folder:
        if cell.size:
            world = generate(recipe, folder).maps[0].world
        else:
            world = Path(folder, "empty.world")
            world.write_bytes(b"".join(sdf.utf8(sdf.world(scene, ()))))
        file = world.with_name("experiment.world")
        text = world_with_robots(world, models, unthrottled=not real, backend=here.backend)
        file.write_text(text, "utf-8")
        rest = REST if real else REST_AT_FULL_SPEED
        yield Setup(file=file, scene=scene, runs=runs, rest=rest, real=real, frames=frames)


def _trial(
    setups: Sequence[Setup], seconds: float, here: Installation, watch: Callable[[], None], *, is_empty: bool
) -> Trial:
    """The trial of the first setup, simulated in turns with the second, if there is one."""
    with ExitStack() as stack:
        servers = [stack.enter_context(trial_server(setup, here, watch)) for setup in setups]
        turns = [seconds] if len(servers) == 1 else [TURN] * ceil(seconds / TURN)
        spans = [[server.measure(turn) for server in servers] for turn in turns]
        ours, *others = (total(each) for each in zip(*spans, strict=True))
        first = servers[0]
        tracks = trajectories(first.record, first.setup.runs)
        figures = driving_figures(tracks, first.setup.runs, None if is_empty else first.setup.scene.field)
        outcome = Outcome(
            load=round(first.load, 3),
            memory=round(first.memory, 1),
            speed=round(ours.speed, 3),
            share=round(ours.speed / others[0].speed, 4) if others else None,
            simulated=round(ours.simulated, 3),
            **_in_real_time(ours, first.setup),
            **figures._asdict(),
        )
    return Trial(outcome=outcome, scene=first.setup.scene, trajectories=tracks)


def _in_real_time(span: Span, setup: Setup) -> dict[str, float | None]:
    """The figures that only a trial in real time has."""
    if not setup.real:
        return dict.fromkeys(("cpu", "machine", "gpu", "fps", "rtf_min", "rtf", "rtf_max"))
    return {
        "cpu": round(span.cpu / span.real, 4),
        "machine": round(min(span.busy / span.real, 1.0), 4),
        "gpu": round(fmean(span.gpu), 3) if span.gpu else None,
        "fps": round(span.frames / span.real, 2) if setup.frames else None,
        "rtf_min": round(min(span.factors), 3),
        "rtf": round(fmean(span.factors), 3),
        "rtf_max": round(max(span.factors), 3),
    }
