"""Agreement of simulators about drives: the same fields, starts, routes and ends in all of them.

python -m benchmarks.agreement                       drives in MuJoCo and in Gazebo Classic, measures steps and speeds,
                                                     prints the tables and keeps benchmarks/results/agreement.json; an
                                                     hour and a half
python -m benchmarks.agreement --simulator mujoco    in MuJoCo alone, ten minutes; or sim: in Gazebo Sim, an hour and a
                                                     half; what is recorded of the others is kept
python -m benchmarks.agreement --robot FILE --unit 0.5 --unit 1    a robot of a file, on fields of these units, alone
python -m benchmarks.agreement --quick               a field for each robot in MuJoCo alone, not kept; a minute

Lanes recorded in benchmarks/results/crossings.json were known when the settings of MuJoCo were chosen. Fresh ones, with
seeds that nobody looked at before, judge: random fields as there, fields of 10 cm for the crawler, and planned ways.
Every drive is done again with a start 0.5 mm to the side. A lane on which a simulator then ends otherwise is a coin
flip, about which it agrees with itself as little as with another one.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from functools import partial
from itertools import combinations, product
from math import ceil, nan
from statistics import median
from time import process_time
from typing import Any, NamedTuple, cast

from benchmarks import crossings
from benchmarks.figures import RESULTS, record_in
from benchmarks.machine import machine
from rsegen.driving.drive import driven_robot
from rsegen.driving.many import wilson
from rsegen.driving.recording import PERIOD, DriveRecording, RobotRun, drive_in_steps, record_embedded
from rsegen.driving.robot_runs import finish_x, robot_runs
from rsegen.driving.routes import AlongWay, Straight
from rsegen.recipe.codec import decode
from rsegen.robots.base import ROBOTS
from rsegen.robots.lookup import robot_of
from rsegen.robots.parameters import MOTORS
from rsegen.scene.scene import Scene, compose
from rsegen.simulators.base import SIMULATORS
from rsegen.simulators.embedded import EMBEDDED
from rsegen.simulators.poses import adjacent_pose
from rsegen.standing.spots import GAP

FILE = RESULTS / "agreement.json"

CLASSIC, SIM = "classic", "sim"

MUJOCO = tuple(f"mujoco {motors}" for motors in MOTORS)
"""MuJoCo with each model of motors."""

SIMULATED = (CLASSIC, SIM, *MUJOCO)
"""Robots that drive, in the order of the record."""

Ways = dict[str, list[list[float]]]
"""Points of planned ways by their worlds, metres."""

_WIDTH = 3.0
"""Metres across the fields."""

ASIDE = 0.0005
"""Metres to the side by which a start is moved, to see whether a lane is a coin flip."""


class Course(NamedTuple):
    """Drives of one sort: robots with their units [cm], number side by side and seconds; rounds over all fields.

    given: what a recipe of a field says beyond crossings.OBSTACLES
    """

    title: str
    plans: Mapping[str, crossings.Plan]
    first_seed: int
    rounds: int = 1
    route: str = Straight.name
    given: Mapping[str, Any] = {}


RECORDED, FRESH, HIGH, WAYS = "recorded lanes", "fresh lanes", "fresh lanes, 10 cm", "fresh ways"

COURSES: Mapping[str, Course] = {
    course.title: course
    for course in (
        Course(RECORDED, crossings.PLANS, crossings.FIRST_SEED),
        Course(FRESH, crossings.PLANS, 91000),
        Course(HIGH, {"crawler": crossings.Plan((10.0,), 4, 20.0)}, 91100, rounds=3, given={"max_step": 1}),
        Course(
            WAYS,
            {
                "burger": crossings.Plan((0.4, 0.6), 1, 20.0),
                "jackal": crossings.Plan((2.0, 3.0), 1, 14.0),
                "crawler": crossings.Plan((5.0, 10.0), 1, 20.0),
            },
            91200,
            rounds=3,
            route=AlongWay.name,
            given={"max_step": 1},
        ),
    )
}


@dataclass(frozen=True, kw_only=True, slots=True)
class World:
    """A field of a course with robots on it, of a kind or a file; numbers of its recipe: unit, seed."""

    course: Course
    robot: str
    field: str
    unit_cm: float
    seed: int

    @property
    def scene(self) -> Scene:
        """Return its scene: 10 x 30 blocks of 10 cm."""
        given = {"chunks": [1, 3], "boundary": "none", **self.course.given}
        obstacle = crossings.OBSTACLES[self.field]
        return compose(
            decode({"name": "agreement", "unit_cm": self.unit_cm, "seed": self.seed, "obstacles": [obstacle], **given}),
            0,
        )

    @property
    def key(self) -> tuple[str, str, str, float, int]:
        """Return what tells it from the others."""
        return self.course.title, robot_of(self.robot).kind, self.field, self.unit_cm, self.seed


@dataclass(frozen=True, kw_only=True, slots=True)
class Outcome:
    """A robot's drive in a simulator: a Gazebo, or MuJoCo with a model of motors.

    line: y of its start, metres, and aside how far that was moved; seconds: until it was beyond the map, None if it did
    not cross; end_x, end_y: where it ended, metres; tipped: how often it tipped over
    """

    course: str
    robot: str
    field: str
    unit_cm: float
    seed: int
    line: float
    simulator: str
    aside: float
    seconds: float | None
    end_x: float
    end_y: float
    tipped: int

    @property
    def lane(self) -> tuple[str, str, str, float, int, float]:
        """Return the drive, whatever the simulator."""
        return self.course, self.robot, self.field, self.unit_cm, self.seed, self.line

    @property
    def crossed(self) -> bool:
        """Return whether the whole robot was beyond the map, upright and not by a way beside it."""
        return self.seconds is not None


def worlds(course: Course, robot: str) -> Iterator[World]:
    """Yield the worlds of a robot on a course."""
    plan = course.plans[robot]
    fields = product(range(course.rounds), crossings.OBSTACLES, plan.units)
    for number, (_, field, unit) in enumerate(fields):
        yield World(course=course, robot=robot, field=field, unit_cm=unit, seed=course.first_seed + number)


def runs_of(world: World, scene: Scene, ways: Ways, aside: float) -> list[RobotRun]:
    """Return the runs of a world, with starts moved aside; none where there is no way.

    ways: the points of ways by world, which are kept, as another rsegen may plan other ones.
    """
    course, robot = world.course, robot_of(world.robot)
    if course.route == Straight.name:
        runs = robot_runs(scene.field, robot, Straight.name, count=course.plans[world.robot].robots, seed=1)
        return [replace(run, start=replace(run.start, y=run.start.y + aside)) for run in runs]
    name = " ".join(map(str, world.key))
    if name not in ways:
        (run,) = robot_runs(scene.field, robot, AlongWay.name, count=1, seed=1)
        crosses = run.way is not None and run.way.length is not None
        points = cast("AlongWay", run.route()).points if crosses else ()
        ways[name] = [[round(x, 4), round(y, 4)] for x, y in points]
    points = tuple((x, y) for x, y in ways[name])
    if not points:
        return []
    ahead = max(scene.field.block_width, robot.size[0] / 2)
    goal = finish_x(scene.field, robot) + GAP
    route = partial(AlongWay, speed=robot.driving_speed, turn=robot.turn, points=points, ahead=ahead, goal=goal)
    start = adjacent_pose(scene.field, robot.body, points[0][1] + aside)
    return [RobotRun(name=f"{robot.kind}_0", robot=robot, start=start, route=route)]


def recording_of(simulator: str, scene: Scene, runs: Sequence[RobotRun], seconds: float) -> DriveRecording:
    """Return the recording of a drive in a Gazebo, or in MuJoCo with a model of motors."""
    if simulator in MUJOCO:
        motors = simulator.rpartition(" ")[2]
        return record_embedded(EMBEDDED["mujoco"], scene, runs, seconds, contacts=False, motors=motors)
    return crossings.recorded_in(simulator, scene, runs, seconds)


def outcomes(simulator: str, world: World, ways: Ways, aside: float = 0.0) -> Iterator[Outcome]:
    """Yield the outcomes of all robots of a world."""
    scene = world.scene
    runs = runs_of(world, scene, ways, aside)
    if not runs:
        return
    recording = recording_of(simulator, scene, runs, world.course.plans[world.robot].seconds)
    title, robot, field, unit, seed = world.key
    for run in runs:
        driven = driven_robot(run, scene, recording, world.course.route)
        row = driven.trajectory.rows[-1]
        yield Outcome(
            course=title,
            robot=robot,
            field=field,
            unit_cm=unit,
            seed=seed,
            line=round(run.start.y - aside, 4),
            simulator=simulator,
            aside=aside,
            seconds=driven.metrics.crossed,
            end_x=round(float(row[1]), 3),
            end_y=round(float(row[2]), 3),
            tipped=driven.metrics.tipped,
        )


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit code: 0; 3 where a simulator is not installed."""
    options = _options(arguments)
    libraries = ["mujoco"] if options.quick else options.simulator or [CLASSIC, "mujoco"]
    simulators = [name for name in SIMULATED if _library(name) in libraries]
    versions = {name: _version(name) for name in dict.fromkeys(map(_library, simulators))}
    if missing := [name for name, version in versions.items() if not version]:
        print(f"no {missing[0]} here", file=sys.stderr)
        return 3
    old = loaded() if FILE.exists() else {}
    robots = options.robot or options.robots
    courses = [_with_files(course, options.robot, options.unit) for course in COURSES.values()]
    record = measured(old, courses[:1] if options.quick else courses, robots, simulators, quick=options.quick)
    record["simulators"] = old.get("simulators", {}) | versions
    print("\n".join(table(record, recorded_lanes())))
    if not options.quick:
        FILE.write_text(text_of(record), "utf-8")
    return 0


def loaded() -> dict[str, Any]:
    """Return the record that is kept; drives in it are rows of values, to be short."""
    record: dict[str, Any] = record_in(FILE)
    columns = record.pop("columns")
    return record | {"drives": [dict(zip(columns, row, strict=True)) for row in record["drives"]]}


def text_of(record: Mapping[str, Any]) -> str:
    """Return a record as JSON with a row of values for each drive."""
    columns = [column.name for column in fields(Outcome)]
    parts = {**record, "columns": columns, "drives": [[drive[name] for name in columns] for drive in record["drives"]]}
    lines = []
    for name, part in parts.items():
        rows = [json.dumps(row) for row in part] if isinstance(part, list) and name != "columns" else []
        lines.append(f"{json.dumps(name)}: " + ("[\n" + ",\n".join(rows) + "\n]" if rows else json.dumps(part)))
    return "{\n" + ",\n".join(lines) + "\n}\n"


def _with_files(course: Course, files: Sequence[str], units: Sequence[float]) -> Course:
    """Return a course with plans for the robots of files too, if its seeds are fresh and its units are none of its own.

    As many robots as fit drive side by side, for three times as long as they take on flat ground.
    """
    if course.title not in (FRESH, WAYS):
        return course
    plans = dict(course.plans)
    for file in files:
        robot = robot_of(file)
        abreast = 1 if course.route == AlongWay.name else min(5, int(_WIDTH / (1.5 * max(robot.size[:2]))))
        plans[file] = crossings.Plan(tuple(units), abreast, 3 * (1 + 2 * robot.size[0]) / robot.driving_speed)
    return course._replace(plans=plans)


def measured(
    old: Mapping[str, Any],
    courses: Sequence[Course],
    robots: Sequence[str],
    simulators: Sequence[str],
    *,
    quick: bool = False,
) -> dict[str, Any]:
    """Return a record in which drives and steps of these robots in these simulators are new, and so are speeds."""
    kinds = [robot_of(robot).kind for robot in robots]

    def is_kept(entry: Mapping[str, Any]) -> bool:
        return entry["robot"] not in kinds or entry.get("simulator", MUJOCO[0]) not in simulators

    record: dict[str, Any] = {"machine": machine(), "ways": dict(old.get("ways", {}))}
    kept = {part: list(filter(is_kept, old.get(part, ()))) for part in ("drives", "climbs", "speeds")}
    for course, robot, simulator in product(courses, robots, simulators):
        if can_drive(course, robot, simulator):
            kept["drives"] += map(asdict, _driven(course, robot, simulator, record["ways"], quick=quick))
    own = [robot for robot in robots if robot in crossings.PLANS]
    for robot, simulator, sides in product([] if quick else own, simulators, SIDES):
        kept["climbs"] += climbs(simulator, robot, sides)
    if MUJOCO[0] in simulators:
        kept["speeds"] += [speeds(robot, blocks) for robot, blocks in product(own, (10, 40))]
    return record | {part: sorted(entries, key=_place) for part, entries in kept.items()}


def _place(entry: Mapping[str, Any]) -> tuple[Any, ...]:
    """Return where an entry of the record is in it, apart from others that are measured at once with it."""
    course = list(COURSES).index(entry.get("course", RECORDED))
    sides, simulator = SIDES.index(entry.get("sides", SIDES[0])), SIMULATED.index(entry.get("simulator", CLASSIC))
    return course, _order(entry["robot"]), sides, simulator, int(1e6 * entry.get("aside", 0.0))


def _order(kind: str) -> tuple[int, str]:
    """Return what sorts robots: rsegen's own first."""
    own = list(crossings.PLANS)
    return (own.index(kind), "") if kind in own else (len(own), kind)


def can_drive(course: Course, robot: str, simulator: str) -> bool:
    """Return whether a robot is to drive on a course in a simulator."""
    return robot in course.plans and (simulator in MUJOCO or course.title != RECORDED)


def _driven(course: Course, robot: str, simulator: str, ways: Ways, *, quick: bool) -> Iterator[Outcome]:
    """Yield the outcomes of a robot on a course, where a start is moved too: in a Gazebo on fresh lanes alone."""
    moved = simulator in MUJOCO or course.title == FRESH
    for world in list(worlds(course, robot))[: 1 if quick else None]:
        for aside in (0.0, ASIDE) if moved else (0.0,):
            found = list(outcomes(simulator, world, ways, aside))
            yield from found
            said = f"{sum(drive.crossed for drive in found)} of {len(found)} cross"
            print(f"{simulator}: {' '.join(map(str, world.key))}: {said}", file=sys.stderr, flush=True)


def recorded_lanes() -> Iterator[Outcome]:
    """Yield the drives of crossings.json in Gazebo Classic."""
    same = ("robot", "field", "unit_cm", "seed", "line", "simulator", "seconds", "end_x", "tipped")
    for drive in record_in(crossings.FILE)["drives"]:
        if drive["simulator"] == CLASSIC:
            # Where a drive ended to the side was not recorded.
            yield Outcome(course=RECORDED, aside=0.0, end_y=nan, **{name: drive[name] for name in same})


def _library(simulator: str) -> str:
    return simulator.partition(" ")[0]


def _version(library: str) -> str:
    """Return the title and version of a simulator, empty where it is not installed."""
    if library in SIMULATORS:
        return str(SIMULATORS[library].installation() or "")
    return str(EMBEDDED[library]) if EMBEDDED[library].version() else ""


def table(record: Mapping[str, Any], recorded: Iterable[Outcome]) -> Iterator[str]:
    """Yield the figures as lines of Markdown; recorded: the lanes of crossings.json in Gazebo Classic."""
    found = [*recorded, *(Outcome(**drive) for drive in record["drives"])]
    robots = sorted({drive.robot for drive in found}, key=_order)
    yield (
        "| drives | robot | pair of simulators | lanes | cross in each | agree, with a 95 % interval | by chance "
        "| tip alike | time | first with itself | second with itself |"
    )
    yield "|---" * 11 + "|"
    for title, robot, (one, other) in product(COURSES, robots, combinations(SIMULATED, 2)):
        own = [drive for drive in found if (drive.course, drive.robot) == (title, robot)]
        if (one, other) != MUJOCO and (row := _row(own, one, other)):
            names = ", ".join(_title(simulator) for simulator in (one, other))
            yield f"| {title} | {robot} | {names} | {row} |"
    yield f"\n## Highest steps\n\n{_STEPS_TEXT}\n"
    yield from _climbs_table(record["climbs"])
    yield f"\n## Speed of MuJoCo\n\n{_SPEEDS_TEXT}\n"
    yield from _speeds_table(record["speeds"])


_STEPS_TEXT = "A robot drives up the step straight, from flat ground, at 0.3 m/s or its top speed."

_SPEEDS_TEXT = """\
Simulated seconds per second of CPU time of one robot on a field of random blocks, with its contacts counted at every
step, on the machine of the [record](records.md). Other machines were half to a third as fast."""


def summary(record: Mapping[str, Any]) -> Iterator[str]:
    """Yield how often pairs of simulators agree on fresh lanes, robot by robot, as lines of Markdown."""
    found = [Outcome(**drive) for drive in record["drives"]]
    shown = (CLASSIC, SIM), *product((CLASSIC, SIM), MUJOCO[:1]), (CLASSIC, MUJOCO[1])
    yield "| robot | " + " | ".join(" and ".join(map(_title, pair)) for pair in shown) + " |"
    yield "|---" * (1 + len(shown)) + "|"
    for robot in sorted({drive.robot for drive in found}, key=_order):
        own = [drive for drive in found if (drive.course, drive.robot) == (FRESH, robot)]
        rows = (_row(own, *pair).split(" | ") for pair in shown)
        yield f"| {robot} | " + " | ".join(f"{row[2]}; by chance {row[3]}" for row in rows) + " |"


def _row(found: Sequence[Outcome], first: str, second: str) -> str:
    """Return the cells of a robot on a course in two simulators; empty if it was not driven in both."""
    if not (both := pairs(found, first, second)):
        return ""
    crossed = [sum(drive.crossed for drive in side) for side in zip(*both, strict=True)]
    tipped = [sum(drive.tipped > 0 for drive in side) for side in zip(*both, strict=True)]
    agreed = sum(one.crossed == other.crossed for one, other in both)
    alike = sum((one.tipped > 0) == (other.tipped > 0) for one, other in both)
    shares = [count / len(both) for count in crossed]
    chance = shares[0] * shares[1] + (1 - shares[0]) * (1 - shares[1])
    later = [other.seconds - one.seconds for one, other in both if one.seconds and other.seconds]
    low, high = wilson(agreed, len(both))
    cells = (
        f"{len(both)}",
        f"{crossed[0]}, {crossed[1]}",
        f"{agreed} of {len(both)}: {100 * agreed / len(both):.0f} % ({100 * low:.0f} to {100 * high:.0f})",
        f"{100 * chance:.0f} %",
        f"{alike} of {len(both)} ({tipped[0]}, {tipped[1]} tip)",
        f"{median(later):+.2f} s" if later else "",
        _with_itself(found, first),
        _with_itself(found, second),
    )
    return " | ".join(cells)


def pairs(found: Sequence[Outcome], one: str, other: str) -> list[tuple[Outcome, Outcome]]:
    """Return the lanes that were driven in both of two simulators, with starts that were not moved."""
    others = {drive.lane: drive for drive in found if drive.simulator == other and not drive.aside}
    return [
        (drive, others[drive.lane])
        for drive in found
        if drive.simulator == one and not drive.aside and drive.lane in others
    ]


def _with_itself(found: Sequence[Outcome], simulator: str) -> str:
    """Return how often a simulator agrees with itself where the start is moved aside; empty if it was not tried."""
    moved = {drive.lane: drive for drive in found if drive.simulator == simulator and drive.aside}
    both = [
        (drive, moved[drive.lane])
        for drive in found
        if drive.simulator == simulator and not drive.aside and drive.lane in moved
    ]
    return f"{sum(one.crossed == other.crossed for one, other in both)} of {len(both)}" if both else ""


def _climbs_table(climbs: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """Yield a table of the highest step that robots climb in each simulator, and the lowest one that holds them."""
    yield "| robot | step before | simulator | climbs all steps up to | is held by the first one at | steps tried |"
    yield "|---|---|---|---|---|---|"
    by_kind: dict[tuple[str, ...], dict[float, bool]] = {}
    for one in climbs:
        kind = one["robot"], one["sides"], one["simulator"]
        by_kind.setdefault(kind, {})[one["height"]] = one["climbed"]
    for (robot, sides, simulator), own in by_kind.items():
        held = min((height for height, climbed in own.items() if not climbed), default=None)
        below = max((height for height in own if held is None or height < held), default=0.0)
        first = "none" if held is None else f"{100 * held:.3g} cm"
        span = f"{100 * min(own):.3g} to {100 * max(own):.3g} cm"
        yield f"| {robot} | {sides} | {_title(simulator)} | {100 * below:.3g} cm | {first} | {span} |"


def _speeds_table(speeds: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """Yield a table of simulated seconds per second of CPU."""
    sizes = sorted({one["blocks"] for one in speeds})
    yield "| robot, alone | " + " | ".join(f"{size} x {size} blocks" for size in sizes) + " |"
    yield "|---" * (1 + len(sizes)) + "|"
    for robot in dict.fromkeys(one["robot"] for one in speeds):
        own = {one["blocks"]: one["speed"] for one in speeds if one["robot"] == robot}
        yield f"| {robot} | " + " | ".join(f"{own[size]:.0f}" for size in sizes) + " |"


def _title(simulator: str) -> str:
    """Return a simulator by its name in the table."""
    return f"MuJoCo, motors `{simulator.rpartition(' ')[2]}`" if simulator in MUJOCO else simulator.title()


class Steps(NamedTuple):
    """Single steps that a robot is driven against, side by side: unit [cm], levels, and blocks of 10 cm per lane."""

    unit_cm: float
    levels: range
    blocks: int


STEPS: Mapping[str, Steps] = {
    "burger": Steps(0.1, range(1, 25), 3),
    "jackal": Steps(0.5, range(4, 24), 6),
    "crawler": Steps(2.5, range(4, 17), 9),
}

SIDES = "both sides", "one side"
"""Sides of a robot that meet a step."""

_EASY = 0.3
"""Speed, m/s, at which a robot is driven against a step, at most: what climbs by its momentum has an easier field."""


def climbs(simulator: str, name: str, sides: str = SIDES[0]) -> Iterator[dict[str, Any]]:
    """Yield, for each height, whether a robot that is driven straight against a step of it is upon it in the end."""
    robot, steps = ROBOTS[name], STEPS[name]
    met = steps.blocks if sides == SIDES[0] else steps.blocks // 2
    lanes = [[level if row < met else 0] * 30 for level in steps.levels for row in range(steps.blocks)]
    chunks = [3, ceil(len(lanes) / 10)]
    given = {"chunks": chunks, "boundary": "none", "unit_cm": steps.unit_cm, "seed": 1}
    scene = compose(decode({"name": "steps", **given, "obstacles": [{"kind": "matrix", "rows": lanes[::-1]}]}), 0)
    edge, v = -scene.field.extent[0] / 2, min(robot.speed, _EASY)
    on_top = edge - float(robot.body.low[0])
    goal = on_top + 0.1
    runs = []
    for number in range(len(steps.levels)):
        y = (number + 0.5) * steps.blocks * 0.1 - scene.field.extent[1] / 2
        route = partial(Straight, speed=v, turn=robot.turn, line=y, goal=goal)
        start = adjacent_pose(scene.field, robot.body, y)
        runs.append(RobotRun(name=f"{name}_{number}", robot=robot, start=start, route=route))
    seconds = 2.0 + 2 * (goal - runs[0].start.x) / v
    recording = recording_of(simulator, scene, runs, seconds)
    for level, run in zip(steps.levels, runs, strict=True):
        driven = driven_robot(run, scene, recording, Straight.name)
        height, row = level * steps.unit_cm / 100, driven.trajectory.rows[-1]
        climbed = bool(row[1] > on_top) and not driven.metrics.tipped
        yield {"robot": name, "sides": sides, "simulator": simulator, "height": round(height, 6), "climbed": climbed}


def speeds(name: str, blocks: int, seconds: float = 10.0) -> dict[str, Any]:
    """Return the simulated seconds per second of CPU of a robot on random blocks, contacts counted at every step."""
    unit = crossings.PLANS[name].units[1]
    given = {"chunk_size": blocks, "boundary": "none", "unit_cm": unit, "seed": 1}
    scene = compose(decode({"name": "speeds", **given, "obstacles": [crossings.OBSTACLES["random, 4 levels"]]}), 0)
    runs = robot_runs(scene.field, ROBOTS[name], Straight.name, count=1, seed=1)
    world = EMBEDDED["mujoco"].world(scene, runs, period=PERIOD)
    before = process_time()
    drive_in_steps(world, runs, seconds, world.step_seconds)
    spent = process_time() - before
    return {"robot": name, "blocks": blocks, "speed": round(world.recorded()[-1][0] / spent, 2)}


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.agreement", description=__doc__.splitlines()[0])
    parser.add_argument("robots", nargs="*", metavar="ROBOT", default=list(crossings.PLANS), help="only these kinds")
    parser.add_argument("--robot", action="append", metavar="FILE", default=[], help="the robot of a file alone")
    parser.add_argument("--unit", action="append", type=float, default=[], help="a unit for robots of files, cm")
    libraries = list(dict.fromkeys(map(_library, SIMULATED)))
    parser.add_argument("--simulator", action="append", choices=libraries, help="drive in these alone")
    parser.add_argument("--quick", action="store_true", help="a field for each robot in MuJoCo alone, not kept")
    return parser.parse_args(arguments)


if __name__ == "__main__":
    sys.exit(main())
