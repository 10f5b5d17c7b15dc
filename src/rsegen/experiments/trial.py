"""A trial: a world with randomly driving robots, its cost to the simulator, and figures of the robots' drives.

Costs of maps are only comparable if robots do about the same: stuck ones cost less. So how far they drove, how long
they were stuck and how much of the map they covered is measured too. At the pace `beside` the world and an empty one
are simulated in turns of a second, in two servers, so that other load on the machine affects both alike.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from math import ceil
from statistics import fmean

import numpy as np

from rsegen.driving.drive_metrics import PLANE, Course, DriveMetrics, Incident, Trajectory, drive_metrics, possible_part
from rsegen.driving.recording import RobotRun, trajectories
from rsegen.errors import inside
from rsegen.experiments.plan import Cell, ExperimentPlan
from rsegen.experiments.trial_server import SOURCES, Measurement, TrialSimulator, runs_of_row, total, trial_server
from rsegen.field.stepfield import StepField
from rsegen.robots.lookup import DrivableRobot
from rsegen.scene.scene import Scene, compose
from rsegen.simulators.process import usage
from rsegen.simulators.server import attempted

SEEN_EVERY = 1.0
"""Simulated seconds between two rows of a trajectory above which it does not show whether a robot was stuck.

MuJoCo simulates two seconds between two looks at full speed, in which a robot can drive a full circle.
"""


def driving_figures(
    tracks: Mapping[str, Trajectory], runs: Sequence[RobotRun], field: StepField | None
) -> dict[str, float | None]:
    """Return the figures of robots in an outcome, from their trajectories; field: None for an empty world."""
    seen = [run for run in runs if run.name in tracks]
    if not seen:
        return {}
    driven = [(tracks[run.name], run.robot) for run in seen]
    courses = [replace(Course.over(field), starts_on_it=_starts_on(field, run)) if field else PLANE for run in seen]
    drives = [
        (track, robot.driving_speed, robot.size, course) for (track, robot), course in zip(driven, courses, strict=True)
    ]
    every = [drive_metrics(*drive) for drive in drives]
    # Blocks count as covered only up to a row that no robot can have, as if it flew; metrics end there by themselves.
    parts = [possible_part(*drive)[0] for drive in drives]
    shares = (
        [covered_share(part, robot, field) for part, (_, robot) in zip(parts, driven, strict=True)] if field else []
    )
    return {
        "driven": round(fmean(metrics.distance for metrics in every), 3),
        "stuck": _stuck_share([track for track, _ in driven], every),
        "tipped": round(fmean(metrics.tipped for metrics in every), 3),
        "covered": round(fmean(shares), 5) if shares else None,
        "off": round(fmean(metrics.has(Incident.OFF) for metrics in every), 4),
        "impossible": round(fmean(metrics.has(Incident.IMPOSSIBLE) for metrics in every), 4),
    }


def _starts_on(field: StepField, run: RobotRun) -> bool:
    """Return whether a robot starts on a map; at full speed its first row is seconds later."""
    half_x, half_y = (side / 2 for side in field.extent)
    return abs(run.start.x) < half_x and abs(run.start.y) < half_y


def _stuck_share(tracks: Sequence[Trajectory], every: Sequence[DriveMetrics]) -> float | None:
    """Return the share of the time that robots were stuck, 0..1; None if rows are too far apart to show it."""
    gaps = np.concatenate([np.diff(track.rows[:, 0]) for track in tracks])
    if len(gaps) and np.median(gaps) > SEEN_EVERY:
        return None
    return round(fmean(metrics.stuck / metrics.seconds if metrics.seconds else 0.0 for metrics in every), 4)


def covered_share(track: Trajectory, robot: DrivableRobot, field: StepField) -> float:
    """Return the share of a field's cells over which some part of a robot's footprint has been, 0..1.

    The footprint is the rectangle of its length and width, at every row of its trajectory.
    """
    # As a grid of points, half a block apart or less, turned and moved to each row: (rows, points).
    apart = field.block_width / 2  # so that no cell between is missed
    axes = [np.linspace(-side / 2, side / 2, ceil(side / apart) + 1) for side in robot.size[:2]]
    along, across = (offsets.ravel() for offsets in np.meshgrid(*axes))
    x, y, yaw = (track.rows[:, [column]] for column in (1, 2, 6))
    places = [x + np.cos(yaw) * along - np.sin(yaw) * across, y + np.sin(yaw) * along + np.cos(yaw) * across]
    i, j = (
        np.floor((place + extent / 2) / field.block_width).astype(int).ravel()
        for place, extent in zip(places, field.extent, strict=True)
    )
    been = np.zeros(field.shape, dtype=bool)
    on_it = (i >= 0) & (j >= 0) & (i < field.shape[0]) & (j < field.shape[1])
    been[i[on_it], j[on_it]] = True
    return float(been.mean())


# A trial.


TURN = 1.0
"""Seconds that each of two worlds is simulated at a time: shorter than other load comes and goes."""


STARVED = 0.5
"""Processors below which a server at full speed, which would use one or more, was starved by other programs: the robots
have then moved for less than half of the time."""

BEHIND = 0.9
"""Real-time factor of a trial in real time below which a server would use more CPU time, if it had it.

A server that keeps up has 0.97 or more in every second; one that does not uses a whole processor on a free machine.
"""


@dataclass(frozen=True, kw_only=True, slots=True)
class Outcome:
    """The measured cost of a trial, and figures of its robots, None if not measured.

    load: seconds until the world was loaded; memory: MiB at the end; speed: simulated seconds per second of CPU
    cpu: processors that the server used while robots drove; machine: load of all processors of the machine, 0..1
    starved: whether other programs left the server too little of them (STARVED)
    attempts: number of servers that were started; all before the last one failed
    gpu: load of the GPU, 0..1; rtf_min, rtf, rtf_max: real-time factors; these at paces in real time
    fps: frames per second of the camera or the window, at the paces `camera` and `window`
    share: speed divided by the empty world's, at the pace `beside`
    simulated: seconds of simulation

    Means over the robots:
    driven: metres; stuck: share of the time, 0..1; tipped: how often a robot tipped over
    covered: share of the cells of the map over which some part of a robot has been, 0..1, not in an empty world
    off: share of the robots that left the map, and drove on
    impossible: share whose figures end at a row that no robot can have
    """

    load: float
    memory: float
    cpu: float | None = None
    speed: float
    rtf_min: float | None = None
    rtf: float | None = None
    rtf_max: float | None = None
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


Results = Mapping[Cell, list[Outcome]]
"""The outcomes of every cell, in the order of its repeats."""


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Trial:
    """A trial: its outcome, the map, and the trajectory of every robot by its name."""

    outcome: Outcome
    scene: Scene
    trajectories: Mapping[str, Trajectory]


def run_trial(
    plan: ExperimentPlan, cell: Cell, repeat: int, here: TrialSimulator, watch: Callable[[], None] = lambda: None
) -> Trial:
    """Run a trial; each repeat has its own map and start poses. A failed server is tried again.

    `watch` is called several times per second; an exception in it ends the trial and its servers.
    """
    trial, attempts = attempted(lambda: _trial(plan, cell, plan.seed + repeat, here, watch))
    return replace(trial, outcome=replace(trial.outcome, attempts=attempts))


def refuse_undrivable(plan: ExperimentPlan) -> None:
    """Raise a UserError, before any trial, if a robot cannot be driven, or the smallest map of a row has no room."""
    for index, row in enumerate(plan.rows):
        smallest = min((size for size in row.sizes if size), default=0)
        with inside(f"rows[{index}]"):
            _ = row.model
            for seed in range(plan.seed, plan.seed + plan.repeats) if smallest else ():
                runs_of_row(row, compose(row.map_of(smallest, seed)), seed)


def _trial(plan: ExperimentPlan, cell: Cell, seed: int, here: TrialSimulator, watch: Callable[[], None]) -> Trial:
    """Run the trial of a cell, perhaps in turns with an empty world; round its figures for the journal."""
    cells = [cell, replace(cell, size=0)] if cell.pace == "beside" else [cell]
    with ExitStack() as stack:  # both servers run for the whole trial
        servers = [stack.enter_context(trial_server(plan, part, seed, here, watch)) for part in cells]
        turns = [plan.seconds] if len(servers) == 1 else [TURN] * ceil(plan.seconds / TURN)
        spans = [[server.measure(turn) for server in servers] for turn in turns]
        ours, *others = (total(parts) for parts in zip(*spans, strict=True))
        first = servers[0]
        tracks = trajectories(first.record, first.runs)
        figures = driving_figures(tracks, first.runs, first.scene.field if cell.size else None)
        if first.is_real:
            rtf_min, rtf, rtf_max = min(ours.factors), fmean(ours.factors), max(ours.factors)
            figures |= {"rtf_min": round(rtf_min, 3), "rtf": round(rtf, 3), "rtf_max": round(rtf_max, 3)}
            figures["gpu"] = round(fmean(ours.gpu), 3) if ours.gpu else None
            figures["fps"] = round(ours.frames / ours.real, 2) if cell.pace in SOURCES else None
        outcome = Outcome(
            load=round(first.load, 3),
            memory=round(usage(first.pid).memory, 1),
            speed=round(ours.speed, 3),
            share=round(ours.speed / others[0].speed, 4) if others else None,
            simulated=round(ours.simulated, 3),
            cpu=round(ours.cores, 4),
            machine=round(min(ours.busy / ours.real, 1.0), 4),
            starved=any(is_starved(span, real=first.is_real) for span in (ours, *others)),
            **figures,  # type: ignore[arg-type]  # mypy takes them for `starved` and `attempts` too
        )
    return Trial(outcome=outcome, scene=first.scene, trajectories=tracks)


def is_starved(span: Measurement, *, real: bool) -> bool:
    """Return whether a server had too little CPU time; in real time it needs more only if it is behind."""
    wants_more = not real or span.simulated < BEHIND * span.real
    return wants_more and span.cores < STARVED
