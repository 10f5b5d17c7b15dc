"""Accuracy of poses about crossings: robots drive straight over random fields in Gazebo Classic and in MuJoCo.

python -m benchmarks.crossings    prints the tables and keeps benchmarks/results/crossings.json; thirteen minutes
python -m benchmarks.crossings --simulator mujoco    drives in MuJoCo alone, and keeps the record of the other

Several robots drive side by side over each field, which has a seed of its own. Each lane is predicted from the field
and the robot's shapes alone. The rivals of this prediction know less or more: one always says yes; one is a limit of
the highest step below a robot that is chosen afterwards, such that it is right most often on these very drives.

Robots drive in both simulators, with the same starts, routes and ends: where the simulators differ about a drive, no
prediction is right in both. In MuJoCo the motors of wheels act back on the chassis; benchmarks/agreement.py has both.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from itertools import combinations, product
from math import degrees
from typing import Any, NamedTuple, TypeVar, cast

import numpy as np

import rsegen
from benchmarks.figures import RESULTS, keep, record_in, say
from benchmarks.machine import machine
from rsegen.driving.drive import DrivenRobot, driven_robot
from rsegen.driving.recording import DriveRecording, RobotRun, record_drive, record_embedded
from rsegen.driving.robot_runs import robot_runs
from rsegen.driving.routes import Straight
from rsegen.field.stepfield import StepField
from rsegen.recipe.codec import decode
from rsegen.robots.base import ROBOTS, Robot
from rsegen.scene.scene import Scene, compose
from rsegen.simulators.base import SIMULATORS
from rsegen.simulators.embedded import EMBEDDED
from rsegen.standing.lanes import End, entry_distance, step_of, straight
from rsegen.writing.target_worlds import world_of

FILE = RESULTS / "crossings.json"

OBSTACLES: Mapping[str, Mapping[str, Any]] = {
    "normal, 4 levels": {"kind": "normal_random", "levels": 4},
    "random, 4 levels": {"kind": "random", "levels": 4},
    "random, 3 levels": {"kind": "random", "levels": 3},
}
"""Fields of 10 x 30 blocks of 10 cm, so that each drive is 1 m over blocks."""


class Plan(NamedTuple):
    """Units of the fields [cm], robots side by side on each, and simulated seconds."""

    units: tuple[float, ...]
    robots: int
    seconds: float


PLANS: Mapping[str, Plan] = {
    "burger": Plan((0.3, 0.5, 0.7, 1.0), 10, 16.0),
    "jackal": Plan((1.0, 1.5, 2.0, 3.0), 5, 14.0),
    "crawler": Plan((1.0, 2.0, 3.0, 5.0), 4, 16.0),
}
"""Units from one that a robot mostly crosses to one that it mostly does not; three times the time on flat ground."""

FIRST_SEED = 8000
"""Of other fields than those on which the poses were developed."""

CLASSIC, MUJOCO = "classic", "mujoco"

TITLES: Mapping[str, str] = {**{name: kind.title for name, kind in SIMULATORS.items()}, MUJOCO: "MuJoCo"}
"""Simulators by their names on the command line and in the record."""


class Lane(NamedTuple):
    """A lane, the same in all simulators: the robot, the field, and y of the lane, metres."""

    robot: str
    field: str
    unit_cm: float
    seed: int
    line: float


@dataclass(frozen=True, kw_only=True, slots=True)
class Drive:
    """A robot on a lane: the prediction with its reason and place x [m], and the drive.

    line: y of the lane, metres; step: the highest step below the robot on its lane, metres; seconds: until it was
    beyond the map, None if it did not cross; end_x, turned: where the drive ended, metres, and how far it was turned
    from its lane there, degrees; tipped: how often it tipped over; incidents: in words
    """

    simulator: str
    robot: str
    field: str
    unit_cm: float
    seed: int
    line: float
    step: float
    foreseen: bool
    reason: str
    at: float | None
    seconds: float | None
    end_x: float
    turned: float
    tipped: int
    incidents: tuple[str, ...]

    @property
    def lane(self) -> Lane:
        """Return the robot on its lane, whatever the simulator."""
        return Lane(self.robot, self.field, self.unit_cm, self.seed, self.line)

    @property
    def crossed(self) -> bool:
        """Return whether the whole robot was beyond the map, upright and not by a way beside it."""
        return self.seconds is not None

    @property
    def is_right(self) -> bool:
        """Return whether the prediction came true."""
        return self.foreseen == self.crossed

    @property
    def outcome(self) -> str:
        """Outcome in words."""
        return "crosses" if self.crossed else "tips over" if self.tipped else "is stopped"


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit code: 0; 3 where a simulator is not installed."""
    options = _options(arguments)
    simulators = [options.simulator] if options.simulator else [CLASSIC, MUJOCO]
    versions = {name: _version(name) for name in simulators}
    for name in (name for name, here in versions.items() if not here):
        print(f"no {TITLES[name]} here", file=sys.stderr)
        return 3
    record: dict[str, Any] = record_in(FILE) if FILE.exists() else {}
    for simulator, name in product(simulators, options.robots):
        lanes = [Drive(**drive).lane for drive in record.get("drives", ()) if drive["simulator"] == CLASSIC]
        found = list(drives(simulator, name, say, lanes if simulator == MUJOCO else ()))
        record = merged(record, simulator, versions[simulator], found)
    print("\n".join(table(record)))
    if not options.only_print:
        keep(record, FILE)
    return 0


def _version(simulator: str) -> str:
    """Return the title and version of a simulator, empty where it is not installed."""
    if simulator == MUJOCO:
        return str(EMBEDDED[MUJOCO]) if EMBEDDED[MUJOCO].version() else ""
    return str(SIMULATORS[simulator].installation() or "")


def merged(record: Mapping[str, Any], simulator: str, version: str, found: Sequence[Drive]) -> dict[str, Any]:
    """Return a record in which drives replace those of the same robots in the same simulator."""
    robots = {drive.robot for drive in found}
    kept = [
        drive for drive in record.get("drives", ()) if drive["simulator"] != simulator or drive["robot"] not in robots
    ]
    order = list(product(TITLES, PLANS))
    return {
        "machine": machine(),
        "simulators": {**record.get("simulators", {}), simulator: version},
        "drives": sorted(
            [*kept, *map(asdict, found)], key=lambda drive: order.index((drive["simulator"], drive["robot"]))
        ),
    }


def drives(
    simulator: str, name: str, say: Callable[[str], None] = lambda _: None, lanes: Sequence[Lane] = ()
) -> Iterator[Drive]:
    """Yield all drives of a robot, field by field; lanes: on these of each field, if there are any, in MuJoCo."""
    for number, (obstacle, unit) in enumerate(product(OBSTACLES, PLANS[name].units)):
        seed = FIRST_SEED + number
        lines = [lane.line for lane in lanes if lane[:4] == (name, obstacle, unit, seed)]
        found = list(_driven(simulator, ROBOTS[name], _scene(obstacle, unit, seed), obstacle, lines))
        right = sum(drive.is_right for drive in found)
        crossed = sum(drive.crossed for drive in found)
        of = f"{simulator}, {name}, {obstacle}, unit {unit:g} cm, seed {seed}"
        say(f"{of}: {crossed} of {len(found)} cross, {right} predicted")
        yield from found


def _scene(obstacle: str, unit: float, seed: int) -> Scene:
    given = {"chunks": [1, 3], "boundary": "none", "unit_cm": unit, "seed": seed, "obstacles": [OBSTACLES[obstacle]]}
    return compose(decode({"name": "crossings", **given}), 0)


def _driven(simulator: str, robot: Robot, scene: Scene, obstacle: str, lines: Sequence[float]) -> Iterator[Drive]:
    field, body, plan = scene.field, robot.body, PLANS[robot.kind]
    runs = robot_runs(field, robot, Straight.name, count=plan.robots, seed=1)
    if lines:
        runs = [_on_line(run, line) for run, line in zip(runs, lines, strict=True)]
    starts = np.array([run.start.y for run in runs])
    lanes = straight(field, body, 0, starts)
    driven = _robots_driven(simulator, robot, scene, runs)
    for line, end, last, one in zip(starts, lanes.end, lanes.last, driven, strict=True):
        row, metrics = one.trajectory.rows[-1], one.metrics
        yield Drive(
            simulator=simulator,
            robot=robot.kind,
            field=obstacle,
            unit_cm=scene.recipe.unit_cm,
            seed=scene.recipe.seed,
            line=round(float(line), 4),
            step=round(highest_step(field, float(line), robot.size[1]), 6),
            foreseen=bool(end == End.NONE),
            reason=End(int(end)).words,
            at=None if end == End.NONE else round(float(last * step_of(body) - entry_distance(field, body, 0)), 3),
            seconds=metrics.crossed,
            end_x=round(float(row[1]), 3),
            turned=round(degrees(float(row[6])), 1),
            tipped=metrics.tipped,
            incidents=tuple(map(str, metrics.incidents)),
        )


def _on_line(run: RobotRun, line: float) -> RobotRun:
    """Return a straight run on another line."""
    route = cast("Straight", run.route())
    return replace(run, start=replace(run.start, y=line), route=partial(replace, route, line=line))


def _robots_driven(simulator: str, robot: Robot, scene: Scene, runs: Sequence[RobotRun]) -> Sequence[DrivenRobot]:
    seconds = PLANS[robot.kind].seconds
    if simulator == MUJOCO:
        recording = record_embedded(EMBEDDED[MUJOCO], scene, runs, seconds, contacts=False)
        return [driven_robot(run, scene, recording, Straight.name) for run in runs]
    drive = partial(rsegen.drive, scene, robot=robot, robots=len(runs), seed=1)
    return drive(simulator=simulator, duration=seconds, contacts=False).robots


def recorded_in(simulator: str, scene: Scene, runs: Sequence[RobotRun], seconds: float) -> DriveRecording:
    """Return the recording of a drive in a Gazebo, and print what its server complained about.

    A server that lacks the plug-in of a robot's flippers drives it all the same, and the record is worth nothing.
    """
    here = SIMULATORS[simulator].installation()
    assert here is not None  # noqa: S101  # the caller looked
    with world_of(scene, None).on_disk() as file:
        recording = record_drive(here, file, runs, seconds, contacts=False)
    for line in recording.errors:
        print(f"{here}: {line}", file=sys.stderr)
    return recording


def highest_step(field: StepField, line: float, width: float) -> float:
    """Return the highest step along x, up or down, of the blocks below a lane of a width; metres, ground included."""
    edges = field.edges()[1]
    below = (edges[1:] > line - width / 2) & (edges[:-1] < line + width / 2)
    heights = np.pad(field.heights[:, below], ((1, 1), (0, 0)))
    return float(np.abs(np.diff(heights, axis=0)).max(initial=0.0))


def table(record: Mapping[str, Any]) -> Iterator[str]:
    """The figures as lines of Markdown."""
    found = [Drive(**drive) for drive in record["drives"]]
    simulators = list(dict.fromkeys(drive.simulator for drive in found))
    yield (
        "| simulator | robot | drives | crossed | right | always yes | best limit, chosen afterwards | precision "
        "| recall |"
    )
    yield "|---" * 9 + "|"
    for simulator in simulators:
        own = [drive for drive in found if drive.simulator == simulator]
        yield from (f"| {TITLES[simulator]} {row}" for row in _by_robot(own, _row))
    yield "\nThe same lanes in two simulators:\n"
    for one, other in combinations(simulators, 2):
        yield from _agreement(one, other, found)
    yield "\nBy the unit of the blocks:\n"
    yield "| simulator | robot, unit | drives | crossed | of these predicted | not crossed | of these predicted |"
    yield "|---|---|---|---|---|---|---|"
    for kind in dict.fromkeys((drive.simulator, drive.robot, drive.unit_cm) for drive in found):
        own = [drive for drive in found if (drive.simulator, drive.robot, drive.unit_cm) == kind]
        crossed, ended = ([drive for drive in own if drive.crossed == claim] for claim in (True, False))
        counts = (len(own), len(crossed), _right(crossed), len(ended), _right(ended))
        simulator, name, unit = kind
        yield f"| {TITLES[simulator]} | {name}, {unit:g} cm | " + " | ".join(map(str, counts)) + " |"
    yield "\nWrong predictions by their reason:\n"
    yield from _wrong(found)


def _by_robot(found: Sequence[Item], row: Callable[[str, Sequence[Item]], str]) -> Iterator[str]:
    """Yield a row for each robot, and one for all."""
    robots = list(dict.fromkeys(one.robot for one in found))
    for name in robots:
        yield row(name, [one for one in found if one.robot == name])
    if len(robots) > 1:
        yield row("all", found)


@dataclass(frozen=True, kw_only=True, slots=True)
class Pair:
    """A robot on one lane in two simulators, predicted alike."""

    one: Drive
    other: Drive

    @property
    def robot(self) -> str:
        """The kind of the robot."""
        return self.one.robot

    @property
    def agrees(self) -> bool:
        """Return whether it crosses in both simulators or in neither."""
        return self.one.crossed == self.other.crossed


Item = TypeVar("Item", Drive, Pair)


def pairs(one: str, other: str, found: Sequence[Drive]) -> list[Pair]:
    """Return the lanes that were driven in both of two simulators; ValueError if they were not predicted alike."""
    others = {drive.lane: drive for drive in found if drive.simulator == other}
    both = [
        Pair(one=drive, other=others[drive.lane]) for drive in found if drive.simulator == one and drive.lane in others
    ]
    for pair in both:
        if pair.one.foreseen != pair.other.foreseen:
            raise ValueError(f"{pair.one.lane}: predicted otherwise in {other} than in {one}; drive in both anew")
    return both


def _agreement(one: str, other: str, found: Sequence[Drive]) -> Iterator[str]:
    """Yield a table of how often two simulators agree about the same drives: a prediction is right at most as often."""
    titles = TITLES[one], TITLES[other]
    yield (
        f"| robot | drives in both | cross in both | only in {titles[0]} | only in {titles[1]} | in neither "
        f"| simulators agree | right in {titles[0]} | right in {titles[1]} | right where they agree |"
    )
    yield "|---" * 10 + "|"
    yield from _by_robot(pairs(one, other, found), _agreement_row)


def _agreement_row(name: str, both: Sequence[Pair]) -> str:
    count = Counter((pair.one.crossed, pair.other.crossed) for pair in both)
    agreed = [pair for pair in both if pair.agrees]
    cells = (
        f"{len(both)}",
        *(f"{count[crossed]}" for crossed in ((True, True), (True, False), (False, True), (False, False))),
        _share(len(agreed), len(both)),
        _share(sum(pair.one.is_right for pair in both), len(both)),
        _share(sum(pair.other.is_right for pair in both), len(both)),
        _share(sum(pair.one.is_right for pair in agreed), len(agreed)),
    )
    return f"| {name} | " + " | ".join(cells) + " |"


def _row(name: str, found: Sequence[Drive]) -> str:
    foreseen, crossed = ([drive for drive in found if claim(drive)] for claim in (_is_foreseen, _is_crossed))
    hits = sum(drive.crossed for drive in foreseen)
    parts = [best_limit([drive for drive in found if drive.robot == robot]) for robot in {one.robot for one in found}]
    limit = f" ({_limit(parts[0][0])})" if len(parts) == 1 else ""
    cells = (
        f"{len(found)}",
        f"{len(crossed)}",
        _share(_right(found), len(found)),
        _share(len(crossed), len(found)),
        _share(sum(right for _, right in parts), len(found)) + limit,
        _share(hits, len(foreseen)),
        _share(hits, len(crossed)),
    )
    return f"| {name} | " + " | ".join(cells) + " |"


def _limit(metres: float) -> str:
    return f"{100 * metres:.2g} cm" if metres >= 0 else "always no"


def _is_foreseen(drive: Drive) -> bool:
    return drive.foreseen


def _is_crossed(drive: Drive) -> bool:
    return drive.crossed


def _right(found: Sequence[Drive]) -> int:
    return sum(drive.is_right for drive in found)


def _share(part: int, whole: int) -> str:
    return f"{100 * part / whole:.0f} %" if whole else "none"


def _wrong(found: Sequence[Drive]) -> Iterator[str]:
    """Yield a table that counts the wrong predictions by their reason."""
    yield "| simulator | robot | predicted | what happened | lanes |"
    yield "|---|---|---|---|---|"
    wrong = (drive for drive in found if not drive.is_right)
    kinds = (
        (drive.simulator, drive.robot, "crosses" if drive.at is None else drive.reason, drive.outcome)
        for drive in wrong
    )
    for (simulator, *told), lanes in sorted(Counter(kinds).items()):
        yield f"| {TITLES[simulator]} | {' | '.join(told)} | {lanes} |"


def best_limit(found: Sequence[Drive]) -> tuple[float, int]:
    """Return the limit of `step` that is right about most of these drives, metres, and about how many."""
    steps, crossed = (np.array([getattr(drive, name) for drive in found]) for name in ("step", "crossed"))
    right = {float(limit): int(((steps <= limit) == crossed).sum()) for limit in (-1.0, *np.unique(steps))}
    most = max(right.values())
    return min(limit for limit, count in right.items() if count == most), most


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.crossings", description=__doc__.splitlines()[0])
    parser.add_argument("robots", nargs="*", metavar="ROBOT", default=list(PLANS), help="only these kinds")
    parser.add_argument("--simulator", choices=tuple(TITLES), help="only this one; default: classic and mujoco")
    parser.add_argument("--only-print", action="store_true", help="keep no record")
    return parser.parse_args(arguments)


if __name__ == "__main__":
    sys.exit(main())
