"""How often the metrics are right about a crossing: robots follow their planned way, in a real Gazebo.

python -m benchmarks.crossings    prints the tables and keeps benchmarks/results/crossings.json; half an hour

Every robot is sent over maps of several kinds, whose steps are shares of the highest one that it climbs, by
`--route way`. Drives are told apart by the least highest step of all ways (the percolation step).
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise, product
from typing import Any

import numpy as np

import rsegen
from benchmarks.figures import RESULTS
from benchmarks.machine import machine
from rsegen.exporters.scene import Scene, compose
from rsegen.field.metrics.traversability import percolation_step
from rsegen.recipe.codec import decode
from rsegen.robots import ROBOTS, Robot
from rsegen.robots.body import body_of, driving_speed
from rsegen.simulation.driving.routes import planned_way
from rsegen.simulation.simulators import SIMULATORS

FILE = RESULTS / "crossings.json"

KINDS: Mapping[str, Mapping[str, Any]] = {
    "random": {"obstacles": [{"kind": "random", "levels": 4}]},
    "normal": {"obstacles": [{"kind": "normal_random", "levels": 5}]},
    "barrier": {
        "obstacles": [
            {"kind": "random", "levels": 2},
            {"kind": "diagonal_barrier", "levels": 5, "softness": 40, "first": [0, 3], "last": [19, 16]},
        ]
    },
    "peak": {
        "obstacles": [
            {"kind": "random", "levels": 2},
            {"kind": "peak", "levels": 6, "softness": 60, "first": [4, 0], "last": [15, 19]},
        ]
    },
    "pallets": {"chunks": 2, "chunk_size": 10, "boundary": "divided", "obstacles": [{"kind": "random", "levels": 3}]},
}
"""Recipes of the maps, of 20 x 20 blocks."""

SHARES = (0.2, 0.35, 0.5, 0.7, 0.95)
"""Units of the maps, as shares of the highest step that a robot climbs."""

SEEDS = (2,)
"""Of other maps than those by which the robots' limits were set, which are of seed 1."""

BINS = (0.0, 0.25, 0.5, 0.75, 1.0, 1.5, np.inf)
"""Bounds of the rows of the table: the highest step on the way, as a share of what the robot climbs."""

_PATIENCE, _START = 2.0, 5.0
"""A robot has twice the time that the way takes, and five seconds more."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Trial:
    """One robot on one map: the highest step of its way in metres, what was foreseen, and how it went."""

    simulator: str
    robot: str
    kind: str
    unit_cm: float
    seed: int
    step: float
    foreseen: bool
    crossed: float | None
    distance: float
    stuck: float
    tipped: int

    @property
    def share(self) -> float:
        """The highest step of the way, as a share of the highest that the robot climbs."""
        return self.step / ROBOTS[self.robot].climbs


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit code: 0; 3 where the simulator is not installed."""
    options = _options(arguments)
    here = SIMULATORS[options.simulator].installation()
    if not here:
        print(f"no {SIMULATORS[options.simulator].title} here", file=sys.stderr)
        return 3
    found = list(trials(options.simulator, options.robots, _say))
    record = {"machine": machine(), "simulator": str(here), "trials": [asdict(each) for each in found]}
    print("\n".join(table(record)))
    if not options.only_print:
        FILE.write_text(json.dumps(record, indent=1) + "\n", "utf-8")
    return 0


def trials(simulator: str, robots: Sequence[str], say: Callable[[str], None] = lambda _: None) -> Iterator[Trial]:
    """All drives of these kinds of robots."""
    for name, kind, share, seed in product(robots, KINDS, SHARES, SEEDS):
        trial = _trial(simulator, ROBOTS[name], kind, share, seed)
        crossed = "does not cross" if trial.crossed is None else f"crosses after {trial.crossed:.1f} s"
        say(f"{name}, {kind}, unit {trial.unit_cm:g} cm, seed {seed}: step {trial.share:.2f} of its own, {crossed}")
        yield trial


def _trial(simulator: str, robot: Robot, kind: str, share: float, seed: int) -> Trial:
    scene = _scene(kind, 100 * share * robot.climbs, seed)
    way = planned_way(scene.field, body_of(robot))
    length = float(np.hypot(*np.diff(way.points, axis=0).T).sum())
    seconds = _PATIENCE * length / driving_speed(robot) + _START
    (driven,) = rsegen.drive(
        scene, robot=robot, simulator=simulator, route="way", duration=seconds, seed=seed, contacts=False
    ).robots
    return Trial(
        simulator=simulator,
        robot=robot.kind,
        kind=kind,
        unit_cm=scene.recipe.unit_cm,
        seed=seed,
        step=round(percolation_step(scene.field, robot.size[1], 0), 6),
        foreseen=bool(way.crosses),
        crossed=driven.metrics.crossed,
        distance=round(driven.metrics.distance, 3),
        stuck=driven.metrics.stuck,
        tipped=driven.metrics.tipped,
    )


def _scene(kind: str, unit_cm: float, seed: int) -> Scene:
    given = {"chunk_size": 20, **KINDS[kind], "unit_cm": round(unit_cm, 3), "frame_height_cm": round(unit_cm, 3)}
    return compose(decode({"name": kind, "boundary": "none", "seed": seed, **given}), 0)


def table(record: Mapping[str, Any]) -> Iterator[str]:
    """The figures as lines of Markdown."""
    found = [Trial(**each) for each in record["trials"]]
    robots = list(dict.fromkeys(each.robot for each in found))
    limits = {name: (100 * ROBOTS[name].climbs, ROBOTS[name].limits.climb_cm) for name in robots}
    heads = [f"{name} (climbs {climbs:g} cm, limit {limit:g} cm)" for name, (climbs, limit) in limits.items()]
    yield "| highest step of the path / `climbs` | " + " | ".join(heads) + " |"
    yield "|---|" + "---|" * len(robots)
    for low, high in pairwise(BINS):
        within = [each for each in found if low < each.share <= high or each.share == low == 0]
        cells = (_cell([each for each in within if each.robot == name]) for name in robots)
        yield f"| {_bounds(low, high)} | " + " | ".join(cells) + " |"
    yield ""
    yield from _right(found, robots)


def _bounds(low: float, high: float) -> str:
    return f"above {low:g}" if high == np.inf else f"{low:g} to {high:g}"


def _cell(found: Sequence[Trial]) -> str:
    return f"{sum(each.crossed is not None for each in found)} of {len(found)}" if found else ""


def _right(found: Sequence[Trial], robots: Sequence[str]) -> Iterator[str]:
    """How often the forecast came true, and at which limit it would have done so most often."""
    yield "| robot | predicted to cross, and did | predicted not to cross, and did not | best limit on these maps |"
    yield "|---|---|---|---|"
    for name in robots:
        mine = [each for each in found if each.robot == name]
        cells = [
            f"{sum((each.crossed is not None) == said for each in group)} of {len(group)}"
            for said in (True, False)
            for group in [[each for each in mine if each.foreseen == said]]
        ]
        limit, right = best_limit(mine)
        yield f"| {name} | {cells[0]} | {cells[1]} | {100 * limit:.2g} cm: {right} of {len(mine)} |"


def best_limit(found: Sequence[Trial]) -> tuple[float, int]:
    """The step up to which most drives crossed and beyond which most did not, metres, and how many those are."""
    steps = np.array([each.step for each in found])
    crossed = np.array([each.crossed is not None for each in found])
    right = {float(limit): int(((steps <= limit) == crossed).sum()) for limit in np.unique(steps)}
    most = max(right.values())
    return min(limit for limit, count in right.items() if count == most), most


def _say(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.crossings", description=__doc__.splitlines()[0])
    parser.add_argument("robots", nargs="*", metavar="ROBOT", default=list(ROBOTS), help="only these kinds")
    parser.add_argument("--simulator", default="classic", choices=tuple(SIMULATORS), help="default: classic")
    parser.add_argument("--only-print", action="store_true", help="keep no record")
    return parser.parse_args(arguments)


if __name__ == "__main__":
    sys.exit(main())
