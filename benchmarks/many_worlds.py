"""Drives in thousands of worlds of mujoco_warp beside the same in MuJoCo: `python -m benchmarks.many_worlds`.

Each of three robots is driven over maps of its own scale as by `rsegen drives`, in both simulators: the way between
both after seconds, and how many drives end alike; then how many seconds are simulated in one, by the number of worlds.
Kept in benchmarks/results/many_worlds.json; docs/learned.md has it. On a GPU two minutes; without one give
--device cpu --lanes 16 --seconds 2 --worlds, and -o to leave that file as it is. Needs `pip install mujoco-warp`.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from importlib.metadata import version
from itertools import repeat
from multiprocessing import get_context
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import rsegen
from benchmarks.figures import RESULTS, keep
from benchmarks.machine import machine
from rsegen.driving.many import wilson
from rsegen.driving.planning import required_simulator
from rsegen.driving.recording import DriveRecording, RobotRun, record_batch, record_embedded
from rsegen.driving.robot_runs import finish_x, robot_runs
from rsegen.errors import SimulatorFailed
from rsegen.mujoco.settings import STEP
from rsegen.robots.lookup import robot_of
from rsegen.robots.parameters import MOTORS
from rsegen.scene.scene import Scene, compose

FILE = RESULTS / "many_worlds.json"
SECONDS = 10.0
LOOK = 0.5
"""Seconds between two looks at where robots are."""
MAPS = 90_000
"""The first of the maps, which nothing was chosen by."""


class Course(NamedTuple):
    """A robot and its fields: the unit and the width of blocks, cm, levels of random blocks."""

    unit: float
    block: float
    levels: int


COURSES: Mapping[str, Course] = {
    "crawler": Course(5, 10, 5),
    "jackal": Course(2, 10, 4),
    "burger": Course(0.5, 5, 3),
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit code: 0."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.many_worlds", description=__doc__.splitlines()[0])
    parser.add_argument("--robots", nargs="+", choices=COURSES, default=list(COURSES))
    parser.add_argument("--lanes", type=int, default=256, help="of each robot")
    parser.add_argument("--seconds", type=float, default=SECONDS, help="of a drive, at most")
    parser.add_argument("--worlds", type=int, nargs="*", default=[1, 64, 1024, 4096, 16384], help="of which a speed")
    parser.add_argument("--device", default="cuda:0", help="of Warp, such as cpu")
    parser.add_argument("-o", "--output", type=Path, default=FILE)
    options = parser.parse_args(arguments)
    import warp as wp

    with wp.ScopedDevice(options.device) as device:
        libraries = ("mujoco-core", "mujoco-warp", "warp-lang")
        record: dict[str, Any] = {"machine": f"{device.name}; {machine()}", "robots": {}}
        record["versions"] = {name: version(name) for name in libraries}
        for robot in options.robots:
            record["robots"][robot] = _measured(robot, options)
            keep(record, options.output)
    print("\n".join(table(record)))
    return 0


def _scenes(robot: str, count: int) -> list[Scene]:
    """Maps of the robot's scale."""
    course = COURSES[robot]
    recipe = rsegen.Recipe(
        name="lane",
        seed=91,
        unit_cm=course.unit,
        block_width_cm=course.block,
        chunk_size=10,
        boundary="none",
        first_map=MAPS,
        maps=count,
        obstacles=[rsegen.Random(levels=course.levels)],
    )
    return [compose(recipe, index) for index in recipe.indices]


def _runs(robot: str, scenes: Sequence[Scene]) -> list[RobotRun]:
    """The robot west of each map, and its way straight across it, as `rsegen drives` has it."""
    return [robot_runs(scene.field, robot_of(robot), "straight", count=1, seed=0)[0] for scene in scenes]


def _measured(robot: str, options: argparse.Namespace) -> dict[str, Any]:
    """The distances at each look, metres, which lanes are across in both, and the speeds by the number of worlds."""
    lanes, seconds = options.lanes, options.seconds
    scenes = _scenes(robot, lanes)
    begin = time.monotonic()
    # A process that has a GPU open must not be forked.
    with ProcessPoolExecutor(mp_context=get_context("spawn")) as pool:
        own = list(pool.map(_drive_one, repeat(robot), scenes, repeat(seconds), chunksize=4))
    one = time.monotonic() - begin
    begin, runs = time.monotonic(), _runs(robot, scenes)
    worlds = _worlds(robot, scenes)
    many = record_batch("MuJoCo Warp", worlds, runs, seconds)
    print(f"{robot}: {one:.0f} s in MuJoCo, {time.monotonic() - begin:.0f} s in mujoco_warp", flush=True)
    places = np.array([[_looks(made, seconds) for made in side] for side in (own, many)])
    finish = finish_x(scenes[0].field, robot_of(robot))
    apart = np.linalg.norm(places[0] - places[1], axis=-1)
    return {
        "lanes": lanes,
        "apart": [[round(float(np.quantile(row, share)), 6) for share in (0.5, 0.9)] for row in apart.T],
        "across": [[bool(across) for across in side[:, -1, 0] >= finish] for side in places],
        "speed": {str(count): _speed(robot, count) for count in options.worlds},
    }


def _drive_one(robot: str, scene: Scene, seconds: float) -> DriveRecording:
    """The drive over a map in MuJoCo."""
    return record_embedded(required_simulator("this needs"), scene, _runs(robot, [scene]), seconds, contacts=False)


def _looks(made: DriveRecording | SimulatorFailed, seconds: float) -> Any:
    """Place of the robot at each look, (looks, 3), metres; after its end the last one."""
    if isinstance(made, SimulatorFailed):
        raise made
    (trajectory,) = made.trajectories.values()
    times = np.arange(1, round(seconds / LOOK) + 1) * LOOK
    rows = trajectory.rows[np.searchsorted(trajectory.rows[:, 0], times + 1e-6, side="right") - 1]
    return rows[:, 1:4]


def _worlds(robot: str, scenes: Sequence[Scene]) -> Any:
    """Worlds with a map each."""
    from rsegen.mujoco.many_maps import ManyMaps

    return ManyMaps(scenes, _runs(robot, scenes), MOTORS[0])


def _speed(robot: str, count: int) -> float:
    """Simulated seconds in a second of so many worlds together, while robots are on blocks."""
    import warp

    wp: Any = warp  # which has types in part
    worlds = _worlds(robot, _scenes(robot, count))
    worlds.drive(np.full(count, robot_of(robot).driving_speed), np.zeros(count))
    for _ in range(15):  # it gets to the blocks, and the graph is captured
        worlds.step(100)
    wp.synchronize()
    begin = time.monotonic()
    for _ in range(5):
        worlds.step(100)
    wp.synchronize()
    return round(count * 500 * STEP / (time.monotonic() - begin), 2)


def table(record: Mapping[str, Any]) -> Iterator[str]:
    """The figures, as lines of Markdown."""
    least = min(len(found["apart"]) for found in record["robots"].values())
    seconds = [second for second in (1, 2, 4) if second / LOOK <= least]
    looks = [round(second / LOOK) - 1 for second in seconds]
    heads = ("robot", "lanes", "apart after 1 s: median, 9 of 10", *(f"after {second} s" for second in seconds[1:]))
    yield f"| {' | '.join(heads)} | across in MuJoCo | in mujoco_warp | end alike |"
    yield f"|{'---|' * (len(heads) + 3)}"
    for robot, found in record["robots"].items():
        own, many = (np.array(across) for across in found["across"])
        alike, lanes = int((own == many).sum()), found["lanes"]
        low, high = wilson(alike, lanes)
        apart = " | ".join(_apart(found["apart"][look]) for look in looks)
        share = f"{alike / lanes:.0%} ({low:.0%}-{high:.0%})"
        yield f"| {robot} | {lanes} | {apart} | {own.sum()} | {many.sum()} | {share} |"
    sizes = list(next(iter(record["robots"].values()))["speed"])
    if sizes:
        yield from _speeds(record, sizes)
    versions = ", ".join(f"{name} {number}" for name, number in record["versions"].items())
    yield f"\nMeasured by `python -m benchmarks.many_worlds` on: {record['machine']}; {versions}."


def _speeds(record: Mapping[str, Any], sizes: Sequence[str]) -> Iterator[str]:
    yield ""
    yield f"| simulated s per s, worlds | {' | '.join(f'{int(size):,}' for size in sizes)} |"
    yield f"|---|{'---|' * len(sizes)}"
    for robot, found in record["robots"].items():
        yield f"| {robot} | {' | '.join(f'{speed:,.3g}' for speed in found['speed'].values())} |"


def _apart(pair: Sequence[float]) -> str:
    return ", ".join(f"{1000 * metres:.2g}" for metres in pair) + " mm"


if __name__ == "__main__":
    sys.exit(main())
