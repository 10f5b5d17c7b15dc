"""Check that robots start level and stay upright: every example, robot, route and distinct start in a real Gazebo.

python -m benchmarks.starts    prints the table and keeps benchmarks/results/starts.json; half an hour

Every start is tried alone: the robot rests for a second, and then drives on its route for some more. It starts level if
it rests within 5 degrees of level and within 1.5 cm of the height at which it started; the start is good if the robot
also stays upright while it is driven. Starts of several seeds that are the same pose are one start. Where a map has no
spot for a robot, that is said, and nothing is driven.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import product
from math import degrees
from typing import Any

import numpy as np

from benchmarks.figures import RESULTS, keep, say
from benchmarks.machine import machine
from rsegen.driving.drive_metrics import Course, Incident, drive_metrics
from rsegen.driving.parameters import ROUTES
from rsegen.driving.recording import RobotRun, record_drive
from rsegen.driving.robot_runs import robot_runs
from rsegen.driving.routes import STOP, Motion, Route
from rsegen.errors import ParameterError
from rsegen.recipe.examples import EXAMPLES
from rsegen.robots.base import ROBOTS
from rsegen.scene.scene import Scene
from rsegen.simulators.base import SIMULATORS, Installation
from rsegen.simulators.poses import Pose
from rsegen.writing.target_worlds import world_of

FILE = RESULTS / "starts.json"
SEEDS = (1, 2, 3, 4, 5)
REST, DRIVE = 1.0, 5.0
"""Seconds after which a robot has come to rest, and in which it then drives: some robot lengths away from its start."""

MOST_TILT, MOST_FALL = 5.0, 0.015
"""Degrees, and metres."""

_WITHOUT = {"sim": ("crawler",)}
"""Robots that a simulator is not asked for: tracks."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Start:
    """One robot at a start: its tilt in degrees and its fall in metres after the rest; None if there was no place.

    seed: the first of those that give this start; upright: whether it did not tip over while it was driven, nor did
    what no robot can; None if it was not driven
    """

    simulator: str
    example: str
    robot: str
    route: str
    seed: int
    tilt: float | None
    fall: float | None
    upright: bool | None = None

    @property
    def is_level(self) -> bool:
        """Return whether it stands where it started."""
        return self.tilt is not None and self.tilt <= MOST_TILT and abs(self.fall or 0) <= MOST_FALL

    @property
    def is_good(self) -> bool:
        """Return whether it stands where it started, and stays upright when it is driven."""
        return self.is_level and self.upright is True


@dataclass(kw_only=True, slots=True)
class _Rested(Route):
    """A route that begins after a rest."""

    route: Route
    left: float = REST

    @property
    def period(self) -> float:  # type: ignore[override]  # that of the route
        """The period of the route."""
        return self.route.period

    def motion(self, at: Pose) -> Motion:
        """Stop as long as the rest lasts."""
        if self.left <= 0:
            return self.route.motion(at)
        self.left -= self.period
        return STOP


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit code: 0; 1 if a robot does not start level; 3 where there is no Gazebo."""
    options = _options(arguments)
    installed = [here for name in SIMULATORS if (here := SIMULATORS[name].installation())]
    if not installed:
        print("no Gazebo here: run scripts/gazebo-classic", file=sys.stderr)
        return 3
    found = [each for here in installed for each in starts(here, options.examples, SEEDS, say=say)]
    record = {"machine": machine(), "simulators": list(map(str, installed)), "starts": [asdict(each) for each in found]}
    print("\n".join(table(record)))
    if not options.only_print:
        keep(record, FILE)
    return int(any(each.tilt is not None and not each.is_level for each in found))


def starts(
    here: Installation,
    examples: Sequence[str],
    seeds: Sequence[int],
    routes: Sequence[str] = ROUTES,
    say: Callable[[str], None] = lambda _: None,
) -> Iterator[Start]:
    """All trials of a simulator."""
    for example in examples:
        say(f"{here}: {example}")
        yield from _of_example(here, example, seeds, routes)


def _of_example(here: Installation, example: str, seeds: Sequence[int], routes: Sequence[str]) -> Iterator[Start]:
    """Every robot on every route, at each start that any seed gives; where there is no place, one trial without it."""
    scene, simulator = world_of(example).scene(), here.simulator.name
    for kind, route in product([kind for kind in ROBOTS if kind not in _WITHOUT.get(simulator, ())], routes):
        runs = {seed: _run(scene, kind, route, seed) for seed in seeds}
        distinct = {run.start if run else None: seed for seed, run in reversed(runs.items())}
        for seed in sorted(distinct.values()):
            run = runs[seed]
            tilt, fall, upright = _driven(here, scene, run) if run else (None, None, None)
            yield Start(
                simulator=simulator,
                example=example,
                robot=kind,
                route=route,
                seed=seed,
                tilt=tilt,
                fall=fall,
                upright=upright,
            )


def _run(scene: Scene, kind: str, route: str, seed: int) -> RobotRun | None:
    """The run of one robot, None if there is no spot for it."""
    try:
        (run,) = robot_runs(scene.field, ROBOTS[kind], route, count=1, seed=seed)
    except ParameterError:
        return None
    return replace(run, name=f"{kind}_{route}_{seed}")


def _driven(here: Installation, scene: Scene, run: RobotRun) -> tuple[float, float, bool]:
    """Tilt in degrees and fall in metres of a robot after its rest, and whether it stayed upright on its route."""
    rested = replace(run, route=lambda: _Rested(route=run.route()))
    with world_of(scene).on_disk() as world:
        track = record_drive(here, world, [rested], REST + DRIVE, contacts=False).trajectories[run.name]
    at_rest = int(np.searchsorted(track.rows[:, 0], REST, side="right")) - 1
    tilt, fall = degrees(float(track.tilt[at_rest])), run.start.z - float(track.rows[at_rest, 3])
    metrics = drive_metrics(track, run.robot.driving_speed, run.robot.size, Course.over(scene.field))
    return round(tilt, 2), round(fall, 4), not metrics.tipped and not metrics.has(Incident.IMPOSSIBLE)


def table(record: Mapping[str, Any]) -> Iterator[str]:
    """The figures as lines of Markdown: a row for each simulator, robot and route."""
    found = [Start(**each) for each in record["starts"]]
    yield "| | robot | route | starts | level | and stays upright | largest tilt | largest fall | no place |"
    yield "|---|---|---|---|---|---|---|---|---|"
    for simulator, robot, route in dict.fromkeys((each.simulator, each.robot, each.route) for each in found):
        here = [each for each in found if (each.simulator, each.robot, each.route) == (simulator, robot, route)]
        yield f"| {SIMULATORS[simulator].title} | {robot} | {route} | {' | '.join(_cells(here))} |"
    yield (
        f"\nThe examples and seeds {SEEDS[0]} to {SEEDS[-1]}. Seeds may give the same start, which counts once: "
        f"on a straight route and along the way all do. Level: a robot rests within {MOST_TILT:g} degrees and "
        f"{100 * MOST_FALL:g} cm of its start {REST:g} s after it. Upright: it then drives {DRIVE:g} s on its route "
        "and does not tip over. Robots are let go 0.5 cm above the ground. By `python -m benchmarks.starts` in "
        f"{' and '.join(record['simulators'])}."
    )


def _cells(found: Sequence[Start]) -> Iterator[str]:
    tried = [each for each in found if each.tilt is not None]
    driven = [each for each in tried if each.upright is not None]
    yield str(len(tried))
    yield str(sum(each.is_level for each in tried))
    yield str(sum(each.is_good for each in driven)) if len(driven) == len(tried) else "not driven"
    yield f"{max((each.tilt or 0 for each in tried), default=0):.1f} degrees"
    yield f"{100 * max((abs(each.fall or 0) for each in tried), default=0):.1f} cm"
    yield ", ".join(dict.fromkeys(each.example for each in found if each.tilt is None)) or "none"


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.starts", description=__doc__.splitlines()[0])
    parser.add_argument("examples", nargs="*", metavar="EXAMPLE", default=list(EXAMPLES), help="only these")
    parser.add_argument("--only-print", action="store_true", help="keep no record")
    return parser.parse_args(arguments)


if __name__ == "__main__":
    sys.exit(main())
