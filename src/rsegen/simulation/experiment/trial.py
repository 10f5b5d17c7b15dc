"""A trial: a world with robots that drive randomly, what it costs the simulator, and what the robots did meanwhile.

The cost of a map is only comparable if robots do about the same: stuck ones cost less. So how far they drove, how long
they were stuck and what they have covered of the map is measured with it. At the pace `beside` the world and an empty
one are simulated in turns of a second, in two servers, so that other load on the machine affects both alike.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import astuple, dataclass, replace
from math import ceil
from pathlib import Path
from statistics import fmean
from typing import Any, NamedTuple

import numpy as np

from rsegen.errors import inside
from rsegen.exporters.gazebo import sdf
from rsegen.exporters.scene import Scene, compose
from rsegen.field.stepfield import Array, StepField
from rsegen.robots.lookup import DrivableRobot
from rsegen.simulation.driving.drive_metrics import (
    PLANE,
    Course,
    Incident,
    Trajectory,
    drive_metrics,
    possible_part,
)
from rsegen.simulation.driving.recording import RobotRun
from rsegen.simulation.driving.robot_runs import robot_runs
from rsegen.simulation.driving.routes import Wandering
from rsegen.simulation.driving.world_file import camera_model, world_with_robots
from rsegen.simulation.experiment.plan import IN_REAL_TIME, Cell, ExperimentPlan, TableRow
from rsegen.simulation.experiment.trial_server import CAMERA_PIXELS, SOURCES, Measurement, Setup, total, trial_server
from rsegen.simulation.simulators import Installation
from rsegen.simulation.simulators.live_world import Record
from rsegen.simulation.simulators.server import attempted
from rsegen.simulation.worlds import write_world


class DrivingFigures(NamedTuple):
    """The means over the robots of a trial; None if nothing of them is known.

    driven: metres; stuck: share of the time, 0..1; tipped: how often each tipped over; covered: share of the cells of
    the map over which some part of a robot has been, 0..1, None in an empty world; off, impossible: share of the robots
    that left the map, and that did what no robot can, with which their other figures end
    """

    driven: float | None = None
    stuck: float | None = None
    tipped: float | None = None
    covered: float | None = None
    off: float | None = None
    impossible: float | None = None


def trajectories(record: Record, runs: Sequence[RobotRun]) -> dict[str, Trajectory]:
    """Return the trajectories of robots that were in a record, by their names."""
    rows = {run.name: [[second, *poses[run.name]] for second, poses in record if run.name in poses] for run in runs}
    return {name: Trajectory(rows=np.array(own)) for name, own in rows.items() if own}


def driving_figures(
    tracks: Mapping[str, Trajectory], runs: Sequence[RobotRun], field: StepField | None
) -> DrivingFigures:
    """Return the figures of robots with these trajectories on a field, None for an empty world."""
    driven = [(tracks[run.name], run.robot) for run in runs if run.name in tracks]
    if not driven:
        return DrivingFigures()
    course = Course.over(field) if field else PLANE
    every = [drive_metrics(track, robot.driving_speed, robot.size, course) for track, robot in driven]
    parts = [possible_part(track, robot.driving_speed, robot.size, course)[0] for track, robot in driven]
    shares = [covered(part, robot, field) for part, (_, robot) in zip(parts, driven, strict=True)] if field else []
    return DrivingFigures(
        driven=round(fmean(metrics.distance for metrics in every), 3),
        stuck=round(fmean(metrics.stuck / metrics.seconds if metrics.seconds else 0.0 for metrics in every), 4),
        tipped=round(fmean(metrics.tipped for metrics in every), 3),
        covered=round(fmean(shares), 5) if shares else None,
        off=round(fmean(metrics.has(Incident.OFF) for metrics in every), 4),
        impossible=round(fmean(metrics.has(Incident.IMPOSSIBLE) for metrics in every), 4),
    )


def covered(track: Trajectory, robot: DrivableRobot, field: StepField) -> float:
    """Return the share of a field's cells over which some part of a robot's footprint has been, 0..1.

    The footprint is the rectangle of its length and width; it is there at points half a block apart or less, at every
    row of its trajectory.
    """
    points = _points_below(robot, field.block_width / 2)  # half a block apart, so that no cell between is missed
    x, y, yaw = (track.rows[:, [column]] for column in (1, 2, 6))
    along, across = points[:, 0], points[:, 1]
    places = [x + np.cos(yaw) * along - np.sin(yaw) * across, y + np.sin(yaw) * along + np.cos(yaw) * across]
    i, j = (
        np.floor((place + extent / 2) / field.block_width).astype(int).ravel()
        for place, extent in zip(places, field.extent, strict=True)
    )
    been = np.zeros(field.shape, dtype=bool)
    on_it = (i >= 0) & (j >= 0) & (i < field.shape[0]) & (j < field.shape[1])
    been[i[on_it], j[on_it]] = True
    return float(been.mean())


def _points_below(robot: DrivableRobot, apart: float) -> Array:
    """Return points of a robot's length and width about its origin, this far apart or less, shape (n, 2)."""
    axes = [np.linspace(-side / 2, side / 2, ceil(side / apart) + 1) for side in robot.size[:2]]
    return np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)


REST, REST_AT_FULL_SPEED = 1.0, 0.2
"""Seconds between commands to robots: about a simulated second, as small worlds run five times as fast as real time."""

TURN = 1.0
"""Seconds that one of two worlds is simulated before it is the other's turn: shorter than other load comes and goes."""


STARVED = 0.5
"""Processors below which a server that would use more was starved by other programs.

At full speed it computes all the time, on one processor or a little more. With less than half of one, the robots have
moved for less than half of the seconds that they had, and its caches are cold, so that its figures are the machine's.
"""

BEHIND = 0.9
"""Real-time factor of a trial in real time below which a server would use more CPU time, if it had it.

One that keeps up has 0.97 or more in every second; one that does not, on a free machine, uses a whole processor.
"""


@dataclass(frozen=True, kw_only=True, slots=True)
class Outcome:
    """The measured cost of a trial, and what the robots did meanwhile.

    load: seconds until the world was loaded; memory: MB at the end; speed: simulated seconds per second of CPU
    cpu: processors that the server used while robots drove; machine: load of all processors of the machine, 0..1;
    starved: whether other programs left the server too little of them (STARVED); attempts: servers that it took, as
    those before the last one failed
    gpu: load of the GPU, 0..1, None where there is none; rtf_min, rtf, rtf_max: real-time factors; these in real time,
    else None
    fps: frames per second that the camera or the window drew, at the paces `camera` and `window`, else None
    share: speed divided by that of the empty world at the pace `beside`, else None
    simulated: seconds; driven, stuck, tipped, covered, off, impossible: as in DrivingFigures
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
    off: float | None = None
    impossible: float | None = None
    starved: bool | None = None
    attempts: int | None = None


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Trial:
    """A trial: its outcome, the map, and the trajectory of every robot by its name."""

    outcome: Outcome
    scene: Scene
    trajectories: Mapping[str, Trajectory]


def run_trial(
    plan: ExperimentPlan, cell: Cell, repeat: int, here: Installation, watch: Callable[[], None] = lambda: None
) -> Trial:
    """Run a trial; each repeat has its own map and start poses. A failed server is tried again.

    `watch` is called several times per second; what it raises ends the trial and its servers.
    """
    cells = [cell, replace(cell, size=0)] if cell.pace == "beside" else [cell]
    with ExitStack() as stack:
        setups = [stack.enter_context(_setup(plan, part, plan.seed + repeat, here)) for part in cells]
        trial, attempts = attempted(lambda: _trial(setups, plan.seconds, here, watch, is_empty=not cell.size))
        return replace(trial, outcome=replace(trial.outcome, attempts=attempts))


def refuse_undrivable(plan: ExperimentPlan) -> None:
    """Raise a UserError, before any trial, if a robot cannot be driven, or the smallest map of a row has no room."""
    for index, row in enumerate(plan.rows):
        smallest = min((size for size in row.sizes if size), default=0)
        with inside(f"rows[{index}]"):
            _ = row.model
            for seed in range(plan.seed, plan.seed + plan.repeats) if smallest else ():
                _runs(row, compose(row.map_of(smallest, seed)), seed)


def _runs(row: TableRow, scene: Scene, seed: int) -> Sequence[RobotRun]:
    """Return the runs of the robots of a row on one of its maps."""
    return robot_runs(scene.field, row.model, Wandering.name, count=row.robots, seed=seed, evenest=True)


@contextmanager
def _setup(plan: ExperimentPlan, cell: Cell, seed: int, here: Installation) -> Iterator[Setup]:
    """Write a temporary world file with robots, of a map or empty."""
    # Also an empty world has robots at the places of a map, so that both differ by the map alone.
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
            world = write_world(scene, Path(folder))
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
    """Run the trial of the first setup, in turns with the second, if any; round its figures for the journal."""
    with ExitStack() as stack:  # both servers run for the whole trial
        servers = [stack.enter_context(trial_server(setup, here, watch)) for setup in setups]
        turns = [seconds] if len(servers) == 1 else [TURN] * ceil(seconds / TURN)
        spans = [[server.measure(turn) for server in servers] for turn in turns]
        ours, *others = (total(parts) for parts in zip(*spans, strict=True))
        first = servers[0]
        tracks = trajectories(first.record, first.setup.runs)
        figures = driving_figures(tracks, first.setup.runs, None if is_empty else first.setup.scene.field)
        outcome = Outcome(
            load=round(first.load, 3),
            memory=round(first.memory, 1),
            speed=round(ours.speed, 3),
            share=round(ours.speed / others[0].speed, 4) if others else None,
            simulated=round(ours.simulated, 3),
            cpu=round(ours.cores, 4),
            machine=round(min(ours.busy / ours.real, 1.0), 4),
            starved=any(is_starved(span, real=first.setup.real) for span in (ours, *others)),
            **_in_real_time(ours, first.setup),
            **figures._asdict(),
        )
    return Trial(outcome=outcome, scene=first.setup.scene, trajectories=tracks)


def is_starved(span: Measurement, *, real: bool) -> bool:
    """Return whether a server had too little of the processors; in real time it wants more only if it is behind."""
    wants_more = not real or span.simulated < BEHIND * span.real
    return wants_more and span.cores < STARVED


def _in_real_time(span: Measurement, setup: Setup) -> dict[str, Any]:
    """Return the figures that only a trial in real time has."""
    if not setup.real:
        return dict.fromkeys(("gpu", "fps", "rtf_min", "rtf", "rtf_max"))
    return {
        "gpu": round(fmean(span.gpu), 3) if span.gpu else None,
        "fps": round(span.frames / span.real, 2) if setup.frames else None,
        "rtf_min": round(min(span.factors), 3),
        "rtf": round(fmean(span.factors), 3),
        "rtf_max": round(max(span.factors), 3),
    }
