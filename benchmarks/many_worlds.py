"""Drives in thousands of worlds of mujoco_warp beside the same in MuJoCo: `python -m benchmarks.many_worlds`.

Each of three robots drives straight ahead over fields of its own scale, each in a world: the way between both after
seconds, and how many lanes end alike; then how many seconds are simulated in one, by the number of worlds. Kept in
benchmarks/results/many_worlds.json; docs/mujoco.md has it. On a GPU two minutes; without one give --lanes 4 --worlds 4.
Needs `pip install mujoco-warp`.
"""

from __future__ import annotations

import argparse
import json
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
from benchmarks.figures import RESULTS
from benchmarks.machine import machine
from rsegen.driving.many import wilson
from rsegen.mujoco.settings import STEP
from rsegen.training.crossing import NAME, Crossing

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
    parser.add_argument("--worlds", type=int, nargs="+", default=[1, 64, 1024, 4096, 16384], help="of which a speed")
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
            options.output.write_text(json.dumps(record, indent=1) + "\n", "utf-8")
    print("\n".join(table(record)))
    return 0


def _crossing(robot: str) -> Crossing:
    course = COURSES[robot]
    recipe = rsegen.Recipe(
        name="lane",
        seed=91,
        unit_cm=course.unit,
        block_width_cm=course.block,
        chunk_size=10,
        boundary="none",
        obstacles=[rsegen.Random(levels=course.levels)],
    )
    return Crossing(recipe=recipe, robot=robot)


def _measured(robot: str, options: argparse.Namespace) -> dict[str, Any]:
    """The distances at each look, metres, which lanes are across in both, and the speeds by the number of worlds."""
    crossing, lanes = _crossing(robot), options.lanes
    random = np.random.default_rng(5)
    starts = random.uniform(-1, 1, (lanes, 2))
    begin = time.monotonic()
    # A process that has a GPU open must not be forked.
    with ProcessPoolExecutor(mp_context=get_context("spawn")) as pool:
        own = np.array(list(pool.map(_drive_one, repeat(robot), range(lanes), starts.tolist(), chunksize=4)))
    one = time.monotonic() - begin
    begin = time.monotonic()
    many = _drive_many(crossing, starts)
    print(f"{robot}: {one:.0f} s in MuJoCo, {time.monotonic() - begin:.0f} s in mujoco_warp", flush=True)
    finish = crossing.lane[1]
    apart = np.linalg.norm(own - many, axis=-1)
    return {
        "lanes": lanes,
        "apart": [[round(float(np.quantile(row, share)), 6) for share in (0.5, 0.9)] for row in apart.T],
        "across": [(own[:, -1, 0] >= finish).tolist(), (many[:, -1, 0] >= finish).tolist()],
        "speed": {str(worlds): _speed(crossing, worlds) for worlds in options.worlds},
    }


def _drive_one(robot: str, lane: int, start: Sequence[float]) -> list[list[float]]:
    """Where a robot is at each look, (looks, 3), metres, in MuJoCo."""
    crossing = _crossing(robot)
    world = crossing.world()
    crossing.grid.write(world.model, rsegen.build_many(crossing.recipe, [MAPS + lane])[0])
    world.restart(NAME, crossing.start(*start))
    world.drive(NAME, crossing.driven, crossing.driven.drive.speed / 2, 0.0)
    places = []
    for _ in range(round(SECONDS / LOOK)):
        world.step(round(LOOK / STEP))
        places.append(world.data.qpos[:3].tolist())
    return places


def _drive_many(crossing: Crossing, starts: Any) -> Any:
    """The same of all lanes at once in mujoco_warp, (lanes, looks, 3)."""
    import mujoco

    many = _worlds(crossing, len(starts))
    qpos = many.data.qpos.numpy()
    for row, start in zip(qpos, starts, strict=True):
        pose = crossing.start(*start)
        row[:3] = pose.x, pose.y, pose.z
        turn = np.zeros(4)
        mujoco.mju_euler2Quat(turn, (0, 0, pose.yaw), "XYZ")
        row[3:7] = turn
    many.data.qpos.assign(qpos)
    many.drive(crossing.driven.drive.speed / 2, 0.0)
    places = []
    for _ in range(round(SECONDS / LOOK)):
        many.step(round(LOOK / STEP))
        places.append(many.poses()[:, :3])
    return np.stack(places, axis=1)


def _worlds(crossing: Crossing, count: int) -> Any:
    """Worlds with a map each."""
    from rsegen.learning.mujoco_warp import BlocksOfWorlds
    from rsegen.mujoco.many_worlds import ManyWorlds

    one = crossing.world()
    many = ManyWorlds(one, count)
    blocks = BlocksOfWorlds(crossing.grid, one.model, many.model, many.data)
    blocks.write(rsegen.build_many(crossing.recipe, range(MAPS, MAPS + count)))
    return many


def _speed(crossing: Crossing, count: int) -> float:
    """Simulated seconds in a second of so many worlds together, while robots are on blocks."""
    import warp

    wp: Any = warp  # which has types in part
    many = _worlds(crossing, count)
    many.drive(crossing.driven.drive.speed / 2, 0.0)
    for _ in range(20):  # it gets to the blocks, and the graph is captured
        many.step(100)
    wp.synchronize()
    begin = time.monotonic()
    for _ in range(5):
        many.step(100)
    wp.synchronize()
    return round(count * 500 * STEP / (time.monotonic() - begin), 2)


def table(record: Mapping[str, Any]) -> Iterator[str]:
    """The figures, as lines of Markdown."""
    looks = [round(second / LOOK) - 1 for second in (1, 2, 4)]
    heads = ("robot", "lanes", "apart after 1 s: median, 9 of 10", "after 2 s", "after 4 s")
    yield f"| {' | '.join(heads)} | across in MuJoCo | in mujoco_warp | end alike |"
    yield "|---|---|---|---|---|---|---|---|"
    for robot, found in record["robots"].items():
        own, many = (np.array(across) for across in found["across"])
        alike, lanes = int((own == many).sum()), found["lanes"]
        low, high = wilson(alike, lanes)
        apart = " | ".join(_apart(found["apart"][look]) for look in looks)
        share = f"{alike / lanes:.0%} ({low:.0%}-{high:.0%})"
        yield f"| {robot} | {lanes} | {apart} | {own.sum()} | {many.sum()} | {share} |"
    yield ""
    sizes = list(next(iter(record["robots"].values()))["speed"])
    yield f"| simulated s per s, worlds | {' | '.join(f'{int(size):,}' for size in sizes)} |"
    yield f"|---|{'---|' * len(sizes)}"
    for robot, found in record["robots"].items():
        yield f"| {robot} | {' | '.join(f'{speed:,.3g}' for speed in found['speed'].values())} |"
    versions = ", ".join(f"{name} {number}" for name, number in record["versions"].items())
    yield f"\nMeasured by `python -m benchmarks.many_worlds` on: {record['machine']}; {versions}."


def _apart(pair: Sequence[float]) -> str:
    return ", ".join(f"{1000 * metres:.2g}" for metres in pair) + " mm"


if __name__ == "__main__":
    sys.exit(main())
