"""Drives over many maps: one robot over each, on all cores, a cluster or a GPU, and the share of maps that it crosses.

    ManyPlan --execute--> ManyDrive for each map, in order --> ManyDrives: table, share, interval

A drive is the same as `rsegen drive` over the same map, bit by bit, wherever it is simulated; in a batch simulator it
is that drive in 32 bits. A drive without a result, as its physics failed, is a row with the reason, and counts neither
as crossed nor as not.

The interval is Wilson's, which holds for shares near 0 and 1 too (E. B. Wilson, J. Am. Stat. Assoc. 22, 1927). What
breaks it: maps that are not independent, as in a recipe without random obstacles.
"""

from __future__ import annotations

import csv
import json
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, astuple, dataclass, fields
from functools import partial
from io import StringIO
from math import isnan, sqrt
from pathlib import Path, PurePosixPath

import numpy as np

from rsegen.driving.drive import driven_robot
from rsegen.driving.planning import planned_runs, predictor_for, required_simulator
from rsegen.driving.prediction import DRIVE_SECONDS
from rsegen.driving.recording import DriveRecording, RobotRun, record_batch, record_embedded
from rsegen.driving.robot_runs import robot_runs
from rsegen.driving.routes import AlongWay, Straight
from rsegen.errors import NoSpot, ParameterError, SimulatorFailed, Stopped, UserError
from rsegen.params.command import Reported
from rsegen.params.numbers import counted
from rsegen.params.streams import SEEDS
from rsegen.recipe.codec import to_json
from rsegen.recipe.recipe import Recipe
from rsegen.robots.lookup import DrivableRobot
from rsegen.robots.parameters import MOTORS
from rsegen.scene.scene import Scene, compose
from rsegen.simulators.batch import BatchSimulator
from rsegen.writing.execute import Execution, execute
from rsegen.writing.resources import refuse_too_large
from rsegen.writing.store import write_folder

_Z = 1.959963984540054
"""Standard deviations on either side of the mean that hold 95 % of a normal distribution."""


@dataclass(frozen=True, kw_only=True, slots=True)
class ManyPlan:
    """Drives to make: the maps of a recipe, a robot, its motors, route and seconds of simulation.

    file: the robot's, as the user named it, None for a kind; batch: the simulator of many worlds at once in which they
    are made, None for the simulator in the box
    """

    recipe: Recipe
    robot: DrivableRobot
    motors: str | None
    route: str
    best: str
    duration: float
    file: str | None = None
    batch: BatchSimulator | None = None

    def seed_of(self, index: int) -> int:
        """Return the seed of the start and route on a map: the recipe's seed plus the map's index."""
        return (self.recipe.seed + index) % SEEDS


@dataclass(frozen=True, kw_only=True, slots=True)
class ManyDrive:
    """A drive over a map, as in `DriveMetrics`; x and y: where the robot was at the end, metres.

    seed: of `rsegen drive`, to see it again; failed: why it has no result, empty if it has one
    """

    map: int
    seed: int
    crossed: float | None
    seconds: float
    distance: float
    stuck: float
    tipped: int
    tilt: float
    climbed: float
    x: float
    y: float
    failed: str = ""


@dataclass(frozen=True, kw_only=True, slots=True)
class ManyDrives(Reported):
    """The result of `rsegen.drive_many`.

    Attributes
    ----------
    recipe : Recipe
        The maps.
    robot : str
        Its kind.
    simulator : str
        Title and version.
    route : str
        How the robot was sent.
    drives : tuple of ManyDrive
        A row for each map, in the order of the maps.
    file : str or None
        The file of the robot, with its arguments, as it was named; None for a kind.
    motors : str or None
        How motors acted in MuJoCo.
    speed : float or None
        The commanded speed, m/s.
    duration : float or None
        The longest simulation time of a drive, seconds.
    """

    recipe: Recipe
    robot: str
    simulator: str
    route: str
    drives: tuple[ManyDrive, ...]
    file: str | None = None
    motors: str | None = None
    speed: float | None = None
    duration: float | None = None

    @property
    def crossed(self) -> int:
        """Number of maps that were crossed."""
        return sum(drive.crossed is not None for drive in self.drives)

    @property
    def counted(self) -> int:
        """Number of drives that have a result."""
        return sum(not drive.failed for drive in self.drives)

    @property
    def interval(self) -> tuple[float, float]:
        """The share of maps that are crossed, low and high, with a confidence of 95 %."""
        return wilson(self.crossed, self.counted)

    def as_json(self) -> dict[str, object]:
        """Return the content of drives.json, which `rsegen drives --json` prints."""
        return {
            "map": self.recipe.name,
            "robot": self.robot,
            "file": self.file,
            "simulator": self.simulator,
            "motors": self.motors,
            "route": self.route,
            "speed": self.speed,
            "duration": self.duration,
            "seed": self.recipe.seed,
            "crossed": self.crossed,
            "drives": self.counted,
            "interval": [round(end, 6) for end in self.interval],
            "rows": [
                {name: None if _is_nan(value) else value for name, value in asdict(drive).items()}
                for drive in self.drives
            ],
        }

    def report(self) -> Iterator[str]:
        """Yield the lines that `rsegen drives` prints."""
        low, high = self.interval
        share = f"{self.crossed / self.counted:.0%} [{low:.0%}, {high:.0%}]" if self.counted else "no result"
        motors = "" if self.motors in (None, MOTORS[0]) else f", motors as {self.motors}"
        yield f"{self.recipe.name} in {self.simulator}{motors}, {self.route}:"
        yield f"  {self.robot} crossed {self.crossed} of {self.counted} maps: {share} (95 % interval)"
        times = [drive.crossed for drive in self.drives if drive.crossed is not None]
        if times:
            yield f"  median time of crossing {np.median(times):.3g} s"
        if tipped := sum(drive.tipped > 0 for drive in self.drives):
            yield f"  tipped over on {counted(tipped, 'map')}"
        failed = [drive for drive in self.drives if drive.failed]
        yield from (f"  map {drive.map} has no result: {drive.failed}" for drive in failed[:_FAILED])
        if more := len(failed[_FAILED:]):
            yield f"  and {more} more {'map has' if more == 1 else 'maps have'} no result"

    def csv(self) -> Iterator[bytes]:
        """Yield the lines of drives.csv."""
        return csv_lines([field.name for field in fields(ManyDrive)], map(astuple, self.drives))

    def write(self, folder: str | Path, *, force: bool = False) -> None:
        """Write drives.csv, drives.json and the recipe into a folder; `force` replaces earlier ones."""
        files = {
            "drives.csv": self.csv(),
            "drives.json": [json.dumps(self.as_json(), indent=2).encode() + b"\n"],
            "recipe.json": [to_json(self.recipe).encode()],
        }
        write_folder(
            {PurePosixPath(name): list(content) for name, content in files.items()}, Path(folder), "drives", force=force
        )


def _is_nan(value: object) -> bool:
    return isinstance(value, float) and isnan(value)


def csv_lines(head: Sequence[str], rows: Iterable[Iterable[object]]) -> Iterator[bytes]:
    """Yield the lines of a CSV file: 1 and 0 for True and False, an empty cell for None and for NaN."""
    text = StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(head)
    table.writerows(map(_cell, row) for row in rows)
    yield from text.getvalue().encode().splitlines(keepends=True)


def _cell(value: object) -> str:
    if value is None or _is_nan(value):
        return ""
    return str(int(value)) if isinstance(value, bool) else f"{value:g}" if isinstance(value, float) else str(value)


_FAILED = 5
"""Drives without a result that are named in a report."""


def wilson(count: int, of: int) -> tuple[float, float]:
    """Return the ends of the 95 % interval of the share that `count` of `of` trials show; (0, 1) without a trial."""
    if not of:
        return 0.0, 1.0
    share, z2 = count / of, _Z * _Z / of
    middle, half = share + z2 / 2, _Z * sqrt(share * (1 - share) / of + z2 / (4 * of))
    return max((middle - half) / (1 + z2), 0.0), min((middle + half) / (1 + z2), 1.0)


def make_drives(plan: ManyPlan, execution: Execution, progress: Callable[[int], None]) -> ManyDrives:
    """Return the drives over all maps of a plan; `progress` is called with how many more are done.

    UserError if no drive has a result; Stopped, with how many are done, after Ctrl-C.
    """
    refuse_too_large(plan.recipe)
    simulator = plan.batch or required_simulator("many drives need")
    first = plan.recipe.first_map
    indices = range(first, first + plan.recipe.maps)
    if plan.batch:
        batches = _batches(plan, plan.batch, indices, execution)
    else:
        batches = execute(partial(_drives, plan), indices, DRIVE_SECONDS, execution)
    drives: list[ManyDrive] = []
    try:
        for batch in batches:
            drives += batch
            progress(len(batch))
    except KeyboardInterrupt:
        done = f"{len(drives)} of {len(indices)} drives were done, and are not kept"
        raise Stopped(done, changed=False) from None
    # A failed drive is a row; if all are, the reason is the result.
    if all(drive.failed for drive in drives):
        problem = f"map {drives[0].map}: {drives[0].failed}"
        raise UserError(problem if len(drives) == 1 else f"none of {len(drives)} drives has a result; {problem}")
    return ManyDrives(
        recipe=plan.recipe,
        robot=plan.robot.kind,
        simulator=str(simulator),
        route=plan.route,
        drives=tuple(drives),
        file=plan.file,
        motors=plan.motors or MOTORS[0],
        speed=plan.robot.driving_speed,
        duration=plan.duration,
    )


def _drives(plan: ManyPlan, indices: Sequence[int]) -> list[ManyDrive]:
    return [drive_over(plan, index) for index in indices]


def drive_over(plan: ManyPlan, index: int) -> ManyDrive:
    """Return the drive over one map; it has no result without a spot to start at, or if the physics fails."""
    scene, seed = compose(plan.recipe, index), plan.seed_of(index)
    try:
        simulator = required_simulator("many drives need")
        predictor = predictor_for(None, plan.motors) if plan.route == AlongWay.name else None
        (run,), _ = planned_runs(predictor, scene, plan.robot, plan.route, count=1, seed=seed, best=plan.best)
        recording = record_embedded(simulator, scene, [run], plan.duration, contacts=False, motors=plan.motors)
    except (NoSpot, SimulatorFailed) as error:
        return _failed(plan, scene, error)
    return _driven(plan, scene, run, recording)


def _batches(
    plan: ManyPlan, simulator: BatchSimulator, indices: Sequence[int], execution: Execution
) -> Iterator[list[ManyDrive]]:
    """Yield the drives of each batch; ParameterError for what a batch simulator cannot do."""
    if plan.route != Straight.name:
        raise ParameterError("route", f"'{plan.route}' needs simulator='mujoco'; {simulator.name} drives straight")
    if execution.workers > 1 or execution.scheduler:
        where = "scheduler" if execution.scheduler else "workers"
        raise ParameterError(where, f"is for simulator='mujoco'; {simulator.name} makes all drives in one process")
    simulator.refuse_missing()
    size = simulator.size(plan.recipe)
    for begin in range(0, len(indices), size):
        scenes = [compose(plan.recipe, index) for index in indices[begin : begin + size]]
        runs = [robot_runs(scene.field, plan.robot, plan.route, count=1, seed=0)[0] for scene in scenes]
        worlds = simulator.worlds(scenes, runs, motors=plan.motors or MOTORS[0])
        recordings = record_batch(simulator.title, worlds, runs, plan.duration)
        yield [
            _failed(plan, scene, made) if isinstance(made, SimulatorFailed) else _driven(plan, scene, run, made)
            for scene, run, made in zip(scenes, runs, recordings, strict=True)
        ]


def _failed(plan: ManyPlan, scene: Scene, error: UserError | SimulatorFailed) -> ManyDrive:
    """Return the row of a drive without a result."""
    values = dict.fromkeys(("seconds", "distance", "stuck", "tilt", "climbed", "x", "y"), float("nan"))
    seed = plan.seed_of(scene.index)
    return ManyDrive(map=scene.index, seed=seed, crossed=None, tipped=0, failed=str(error), **values)


def _driven(plan: ManyPlan, scene: Scene, run: RobotRun, recording: DriveRecording) -> ManyDrive:
    """Return the row of a drive."""
    robot = driven_robot(run, scene, recording, plan.route)
    metrics, (x, y) = robot.metrics, robot.trajectory.rows[-1, 1:3].tolist()
    return ManyDrive(
        map=scene.index,
        seed=plan.seed_of(scene.index),
        crossed=metrics.crossed,
        seconds=metrics.seconds,
        distance=metrics.distance,
        stuck=metrics.stuck,
        tipped=metrics.tipped,
        tilt=metrics.tilt,
        climbed=metrics.climbed,
        x=round(x, 4),
        y=round(y, 4),
    )
