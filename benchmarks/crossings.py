"""How often poses are right about a crossing: robots drive straight over random fields in a real Gazebo.

python -m benchmarks.crossings    prints the tables and keeps benchmarks/results/crossings.json; twelve minutes

Several robots drive side by side over each field, which has a seed of its own. Each lane is predicted from the field
and the robot's shapes alone. The rivals of this prediction know less or more: one always says yes; one is a limit of
the highest step below a robot that is chosen afterwards, such that it is right most often on these very drives.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from itertools import product
from math import degrees
from typing import Any, NamedTuple

import numpy as np

import rsegen
from benchmarks.figures import RESULTS
from benchmarks.machine import machine
from rsegen.exporters.scene import Scene, compose
from rsegen.field.stepfield import StepField
from rsegen.recipe.codec import decode
from rsegen.robots import ROBOTS, Robot
from rsegen.simulation.driving.robot_runs import robot_runs
from rsegen.simulation.simulators import SIMULATORS
from rsegen.standing.lanes import End, entry, step_of, straight

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
    def crossed(self) -> bool:
        """Whether the whole robot was beyond the map, upright and not by a way beside it."""
        return self.seconds is not None

    @property
    def is_right(self) -> bool:
        """Whether the prediction came true."""
        return self.foreseen == self.crossed

    @property
    def happened(self) -> str:
        """What happened, in words."""
        if self.crossed:
            return f"crosses after {self.seconds:.1f} s, turned by {abs(self.turned):.0f} degrees at the end"
        if self.tipped:
            return f"tips over, ends at x = {self.end_x:.2f} m"
        words = [f"ends at x = {self.end_x:.2f} m, turned by {abs(self.turned):.0f} degrees", *self.incidents]
        return "; ".join(words)


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit code: 0; 3 where the simulator is not installed."""
    options = _options(arguments)
    here = SIMULATORS[options.simulator].installation()
    if not here:
        print(f"no {SIMULATORS[options.simulator].title} here", file=sys.stderr)
        return 3
    found = [drive for name in options.robots for drive in drives(options.simulator, name, _say)]
    record = {"machine": machine(), "simulator": str(here), "drives": [asdict(drive) for drive in found]}
    print("\n".join(table(record)))
    if not options.only_print:
        FILE.write_text(json.dumps(record, indent=1) + "\n", "utf-8")
    return 0


def drives(simulator: str, name: str, say: Callable[[str], None] = lambda _: None) -> Iterator[Drive]:
    """Yield all drives of a robot, field by field."""
    for number, (obstacle, unit) in enumerate(product(OBSTACLES, PLANS[name].units)):
        seed = FIRST_SEED + number
        scene = _scene(obstacle, unit, seed)
        found = list(_driven(simulator, ROBOTS[name], scene, obstacle, PLANS[name]))
        right = sum(drive.is_right for drive in found)
        crossed = sum(drive.crossed for drive in found)
        say(f"{name}, {obstacle}, unit {unit:g} cm, seed {seed}: {crossed} of {len(found)} cross, {right} predicted")
        yield from found


def _scene(obstacle: str, unit: float, seed: int) -> Scene:
    given = {"chunks": [1, 3], "boundary": "none", "unit_cm": unit, "seed": seed, "obstacles": [OBSTACLES[obstacle]]}
    return compose(decode({"name": "crossings", **given}), 0)


def _driven(simulator: str, robot: Robot, scene: Scene, obstacle: str, plan: Plan) -> Iterator[Drive]:
    field, body = scene.field, robot.body
    lines = np.array([run.start.y for run in robot_runs(field, robot, "straight", count=plan.robots, seed=1)])
    lanes = straight(field, body, 0, lines)
    drive = partial(rsegen.drive, scene, robot=robot, robots=plan.robots, seed=1)
    driven = drive(simulator=simulator, duration=plan.seconds, contacts=False).robots
    for line, end, last, one in zip(lines, lanes.end, lanes.last, driven, strict=True):
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
            at=None if end == End.NONE else round(float(last * step_of(body) - entry(field, body, 0)), 3),
            seconds=metrics.crossed,
            end_x=round(float(row[1]), 3),
            turned=round(degrees(float(row[6])), 1),
            tipped=metrics.tipped,
            incidents=tuple(map(str, metrics.incidents)),
        )


def highest_step(field: StepField, line: float, width: float) -> float:
    """Return the highest step along x, up or down, of the blocks below a lane of a width; metres, ground included."""
    edges = field.edges()[1]
    below = (edges[1:] > line - width / 2) & (edges[:-1] < line + width / 2)
    heights = np.pad(field.heights[:, below], ((1, 1), (0, 0)))
    return float(np.abs(np.diff(heights, axis=0)).max(initial=0.0))


def table(record: Mapping[str, Any]) -> Iterator[str]:
    """The figures as lines of Markdown."""
    found = [Drive(**drive) for drive in record["drives"]]
    robots = list(dict.fromkeys(drive.robot for drive in found))
    yield "| robot | drives | crossed | right | always yes | best limit, chosen afterwards | precision | recall |"
    yield "|---|---|---|---|---|---|---|---|"
    for name in robots:
        yield _row(name, [drive for drive in found if drive.robot == name])
    if len(robots) > 1:
        yield _row("all", found)
    yield ""
    yield "| robot, unit | drives | crossed | of these predicted | not crossed | of these predicted |"
    yield "|---|---|---|---|---|---|"
    for name, unit in dict.fromkeys((drive.robot, drive.unit_cm) for drive in found):
        own = [drive for drive in found if (drive.robot, drive.unit_cm) == (name, unit)]
        crossed, ended = ([drive for drive in own if drive.crossed == claim] for claim in (True, False))
        counts = (len(own), len(crossed), _right(crossed), len(ended), _right(ended))
        yield f"| {name}, {unit:g} cm | " + " | ".join(map(str, counts)) + " |"
    yield ""
    yield from _wrong(found)


def _row(name: str, found: Sequence[Drive]) -> str:
    foreseen, crossed = ([drive for drive in found if claim(drive)] for claim in (_is_foreseen, _is_crossed))
    hits = sum(drive.crossed for drive in foreseen)
    parts = [best_limit([drive for drive in found if drive.robot == robot]) for robot in {one.robot for one in found}]
    limit = f" ({100 * parts[0][0]:.2g} cm)" if len(parts) == 1 else ""
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


def _is_foreseen(drive: Drive) -> bool:
    return drive.foreseen


def _is_crossed(drive: Drive) -> bool:
    return drive.crossed


def _right(found: Sequence[Drive]) -> int:
    return sum(drive.is_right for drive in found)


def _share(part: int, whole: int) -> str:
    return f"{100 * part / whole:.0f} %" if whole else "none"


def _wrong(found: Sequence[Drive]) -> Iterator[str]:
    """Yield a table of all wrong predictions."""
    yield "| robot, unit, seed, lane | predicted | what happened |"
    yield "|---|---|---|"
    for drive in (drive for drive in found if not drive.is_right):
        lane = f"{drive.robot}, {drive.unit_cm:g} cm, {drive.seed}, y = {drive.line:.2f} m"
        predicted = "crosses" if drive.at is None else f"{drive.reason} at x = {drive.at:.2f} m"
        yield f"| {lane} | {predicted} | {drive.happened} |"


def best_limit(found: Sequence[Drive]) -> tuple[float, int]:
    """Return the limit of `step` that is right about most of these drives, metres, and about how many."""
    steps, crossed = (np.array([getattr(drive, name) for drive in found]) for name in ("step", "crossed"))
    right = {float(limit): int(((steps <= limit) == crossed).sum()) for limit in (-1.0, *np.unique(steps))}
    most = max(right.values())
    return min(limit for limit, count in right.items() if count == most), most


def _say(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.crossings", description=__doc__.splitlines()[0])
    parser.add_argument("robots", nargs="*", metavar="ROBOT", default=list(PLANS), help="only these kinds")
    parser.add_argument("--simulator", default="classic", choices=tuple(SIMULATORS), help="default: classic")
    parser.add_argument("--only-print", action="store_true", help="keep no record")
    return parser.parse_args(arguments)


if __name__ == "__main__":
    sys.exit(main())
