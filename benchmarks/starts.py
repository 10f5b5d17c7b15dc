"""Whether robots start level: every example, robot, seed and route in a real Gazebo, a second after the start.

python -m benchmarks.starts    prints the table and keeps benchmarks/results/starts.json; a quarter of an hour

A trial is good if the robot rests within 5 degrees of level and within 1.5 cm of the height at which it started; where
a map has no even place for a robot, that is said, and nothing is driven.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, astuple, dataclass, replace
from functools import partial
from math import acos, cos, degrees, hypot
from pathlib import Path
from typing import Any

from benchmarks.figures import RESULTS
from benchmarks.machine import machine
from rsegen.errors import ParameterError
from rsegen.exporters.scene import Scene
from rsegen.recipe.examples import EXAMPLES
from rsegen.robots import ROBOTS
from rsegen.robots.footprint import footprint_of
from rsegen.simulation.driving.recording import RobotRun
from rsegen.simulation.driving.robot_runs import ROUTES, robot_runs
from rsegen.simulation.driving.routes import Straight
from rsegen.simulation.driving.world_file import time_step, world_with_robots
from rsegen.simulation.simulators import SIMULATORS, Installation
from rsegen.simulation.simulators.live_world import Pose
from rsegen.simulation.simulators.server import retried, running_server
from rsegen.simulation.worlds import world_of

FILE = RESULTS / "starts.json"
SEEDS = (1, 2, 3, 4, 5)
SECONDS = 1.0
"""Simulated, after which a robot has come to rest."""

MOST_TILT, MOST_FALL = 5.0, 0.015
"""Degrees, and metres."""

TIMEOUT = 300.0
"""Seconds within which a world must load, on a busy machine too."""

_GAP = 0.05
"""Metres between robots that are tried in one world."""

_WITHOUT = {"sim": ("crawler",)}
"""Robots that a simulator is not asked for: tracks."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Start:
    """One robot a second after its start: its tilt in degrees and its fall in metres; None if there was no place."""

    simulator: str
    example: str
    robot: str
    route: str
    seed: int
    tilt: float | None
    fall: float | None

    @property
    def is_level(self) -> bool:
        """Whether it stands where it started."""
        return self.tilt is not None and self.tilt <= MOST_TILT and abs(self.fall or 0) <= MOST_FALL


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit code: 0; 1 if a robot does not start level; 3 where there is no Gazebo."""
    options = _options(arguments)
    installed = [here for name in SIMULATORS if (here := SIMULATORS[name].installation())]
    if not installed:
        print("no Gazebo here: run scripts/gazebo-classic", file=sys.stderr)
        return 3
    found = [each for here in installed for each in starts(here, options.examples, SEEDS, _say)]
    record = {"machine": machine(), "simulators": list(map(str, installed)), "starts": [asdict(each) for each in found]}
    print("\n".join(table(record)))
    if not options.only_print:
        FILE.write_text(json.dumps(record, indent=1) + "\n", "utf-8")
    return int(any(each.tilt is not None and not each.is_level for each in found))


def starts(
    here: Installation, examples: Sequence[str], seeds: Sequence[int], say: Callable[[str], None] = lambda _: None
) -> Iterator[Start]:
    """All trials of a simulator."""
    for example in examples:
        say(f"{here}: {example}")
        yield from _of_example(here, example, seeds)


def _of_example(here: Installation, example: str, seeds: Sequence[int]) -> Iterator[Start]:
    """Every robot on every route for every seed; a straight route starts alike for every seed.

    Robots share a world where they stand apart.
    """
    scene = world_of(example).scene()
    kinds = [kind for kind in ROBOTS if kind not in _WITHOUT.get(here.simulator.name, ())]
    trials = [(kind, route, seed) for kind in kinds for route in ROUTES for seed in seeds[: _starts_of(route)]]
    runs = {trial: run for trial in trials if (run := _run(scene, *trial))}
    rested: dict[str, Pose] = {}
    for group in _groups(runs.values()):
        rested |= retried(partial(_rested, here, scene, group))
    for trial in trials:
        kind, route, seed = trial
        tilt, fall = _moved(runs[trial], rested) if trial in runs else (None, None)
        simulator = here.simulator.name
        yield Start(simulator=simulator, example=example, robot=kind, route=route, seed=seed, tilt=tilt, fall=fall)


def _starts_of(route: str) -> int | None:
    return 1 if route == Straight.name else None


def _run(scene: Scene, kind: str, route: str, seed: int) -> RobotRun | None:
    """The run of one robot, None if there is no even place for it."""
    try:
        (run,) = robot_runs(scene.field, ROBOTS[kind], route, count=1, seed=seed)
    except ParameterError:
        return None
    return replace(run, name=f"{kind}_{route}_{seed}")


def _groups(runs: Iterable[RobotRun]) -> list[list[RobotRun]]:
    """The runs in groups of robots that stand apart."""
    groups: list[list[RobotRun]] = []
    for run in runs:
        free = [group for group in groups if all(_apart(run, other) for other in group)]
        if not free:
            free = [[]]
            groups += free
        free[0].append(run)
    return groups


def _apart(one: RobotRun, other: RobotRun) -> bool:
    distance = hypot(one.start.x - other.start.x, one.start.y - other.start.y)
    return distance > _radius(one) + _radius(other) + _GAP


def _radius(run: RobotRun) -> float:
    """That of the circle around a robot's origin in which it fits."""
    low_x, low_y, high_x, high_y = footprint_of(run.robot).outline
    return hypot(max(-low_x, high_x), max(-low_y, high_y))


def _rested(here: Installation, scene: Scene, runs: Sequence[RobotRun]) -> dict[str, Pose]:
    """The pose of each robot a second after all were let go, by its name."""
    with tempfile.TemporaryDirectory(prefix="rsegen-") as folder, world_of(scene).on_disk() as world:
        models = [run.robot.model(run.name, here.backend, astuple(run.start)) for run in runs]
        text = world_with_robots(world, models, unthrottled=True, backend=here.backend)
        file = Path(folder, world.name)
        file.write_text(text, "utf-8")
        with (
            running_server(here, file, timeout=TIMEOUT, models=world.absolute().parent.parent) as server,
            server.connect() as live,
        ):
            live.step(round(SECONDS / time_step(text)))
            return {name: pose for name, pose in live.poses().items() if name in {run.name for run in runs}}


def _moved(run: RobotRun, rested: Mapping[str, Pose]) -> tuple[float, float]:
    """Tilt in degrees and fall in metres of a robot that has come to rest."""
    at = rested[run.name]
    return round(degrees(acos(cos(at.roll) * cos(at.pitch))), 2), round(run.start.z - at.z, 4)


def table(record: Mapping[str, Any]) -> Iterator[str]:
    """The figures as lines of Markdown: a row for each simulator, robot and route."""
    found = [Start(**each) for each in record["starts"]]
    yield "| | robot | route | level, of those driven | largest tilt | largest fall | maps without an even place |"
    yield "|---|---|---|---|---|---|---|"
    for simulator, robot, route in dict.fromkeys((each.simulator, each.robot, each.route) for each in found):
        here = [each for each in found if (each.simulator, each.robot, each.route) == (simulator, robot, route)]
        yield f"| {SIMULATORS[simulator].title} | {robot} | {route} | {' | '.join(_cells(here))} |"
    yield (
        f"\nThe ten examples and seeds {SEEDS[0]} to {SEEDS[-1]} (a straight route starts alike for each). Level: a "
        f"robot rests within {MOST_TILT:g} degrees and {100 * MOST_FALL:g} cm of its start {SECONDS:g} s after it. "
        f"Robots are let go 0.5 cm above the ground. By `python -m benchmarks.starts` in "
        f"{' and '.join(record['simulators'])}."
    )


def _cells(found: Sequence[Start]) -> Iterator[str]:
    driven = [each for each in found if each.tilt is not None]
    yield f"{sum(each.is_level for each in driven)} of {len(driven)}"
    yield f"{max((each.tilt or 0 for each in driven), default=0):.1f} degrees"
    yield f"{100 * max((abs(each.fall or 0) for each in driven), default=0):.1f} cm"
    yield ", ".join(dict.fromkeys(each.example for each in found if each.tilt is None)) or "none"


def _say(line: str) -> None:
    print(line, file=sys.stderr)


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.starts", description=__doc__.splitlines()[0])
    parser.add_argument("examples", nargs="*", metavar="EXAMPLE", default=list(EXAMPLES), help="only these")
    parser.add_argument("--only-print", action="store_true", help="keep no record")
    return parser.parse_args(arguments)


if __name__ == "__main__":
    sys.exit(main())
