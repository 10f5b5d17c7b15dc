"""Check that robots cross the maps that are made crossable for them, and over how much of their way they are on blocks.

python -m benchmarks.crossable             makes 45 fresh maps, drives each robot along its way in MuJoCo, once as it is
                                           and then out of the spread of a prediction, prints the table and keeps
                                           benchmarks/results/crossable.json; five minutes
python -m benchmarks.crossable --seed 7    the same maps again; by default the seed is drawn

Maps are of `crossable_by` and random kinds of blocks alone, with units at each robot's limit and of 10 cm. Of blocks of
10 cm a robot with wheels climbs none, so its way can only be flat; that is counted, and marked.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from statistics import mean
from time import process_time
from typing import Any

import numpy as np

from benchmarks.figures import RESULTS, keep
from benchmarks.machine import machine
from rsegen.driving.drive import driven_robot
from rsegen.driving.drive_metrics import Trajectory
from rsegen.driving.planning import SURE, predictor_for
from rsegen.driving.recording import record_embedded
from rsegen.driving.robot_runs import robot_runs
from rsegen.driving.routes import AlongWay
from rsegen.field.stepfield import StepField
from rsegen.params.streams import SEEDS, fresh_seed
from rsegen.recipe.codec import decode
from rsegen.recipe.recipe import Recipe
from rsegen.robots.base import ROBOTS
from rsegen.scene.scene import compose
from rsegen.simulators.embedded import EMBEDDED
from rsegen.standing.body import Body

FILE = RESULTS / "crossable.json"

OBSTACLES: Sequence[Mapping[str, Any]] = ({"kind": "random", "levels": 5}, {"kind": "normal_random", "levels": 5})

UNITS: Mapping[str, Sequence[float]] = {
    "burger": (0.3, 0.5, 10.0),
    "jackal": (2.0, 3.0, 5.0, 10.0),
    "crawler": (5.0, 10.0),
}
"""Units, cm: about the limit of each robot, and the default."""

HIGH: Sequence[tuple[str, float]] = (("burger", 10.0), ("jackal", 5.0), ("jackal", 10.0))
"""Robots and units of blocks of which they climb none: the jackal climbs 4.5 cm in MuJoCo (benchmarks/agreement.py)."""

MAPS, SECONDS = 45, 24.0

_LOW = 0.01
"""Metres above a robot's lowest point up to which a driven sample stands on the ground."""

_FLAT = 0.5
"""Share of a way on blocks from which on it is said to be over blocks."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Drive:
    """A robot's drive along its way over a map that was made for it.

    lowered: blocks that are lower for it; seconds: until it was beyond the map, None if it did not cross; probability:
    of crossing on that way, as `rsegen predict` has it; on_blocks: share of its wheels or tracks over blocks, of all
    poses above the map; made: CPU seconds in which the map was made
    """

    robot: str
    unit_cm: float
    obstacle: str
    seed: int
    lowered: int
    seconds: float | None
    tipped: int
    probability: float
    on_blocks: float
    made: float

    @property
    def crossed(self) -> bool:
        """Return whether the whole robot was beyond the map, upright."""
        return self.seconds is not None


def recipe_of(robot: str, unit_cm: float, obstacle: Mapping[str, Any], seed: int) -> Recipe:
    """Return the recipe of a map that is made crossable."""
    given = {"chunk_size": 10, "chunks": 1, "boundary": "none", "unit_cm": unit_cm, "seed": seed}
    return decode({"name": "crossable", **given, "obstacles": [obstacle], "crossable_by": robot})


def drives(maps: int, first_seed: int) -> Iterator[Drive]:
    """Yield the drives of all robots, each over its share of the maps, in two processes."""
    kinds = [(robot, unit) for robot, units in UNITS.items() for unit in units]
    jobs = [
        (robot, unit, OBSTACLES[k % len(OBSTACLES)], (first_seed + 100 * number + k) % SEEDS)
        for number, (robot, unit) in enumerate(kinds)
        for k in range(-(-maps // len(kinds)))
    ]
    with ProcessPoolExecutor(2) as pool:
        yield from pool.map(_drive, *zip(*jobs, strict=True))


def _drive(name: str, unit_cm: float, obstacle: Mapping[str, Any], seed: int) -> Drive:
    robot, begin = ROBOTS[name], process_time()
    scene = compose(recipe_of(name, unit_cm, obstacle, seed), 0)
    made = process_time() - begin
    free = compose(replace(scene.recipe, crossable_by=None), 0)
    predictor = predictor_for(None)
    assert predictor is not None  # noqa: S101  # `main` looked
    (run,) = robot_runs(scene.field, robot, AlongWay.name, count=1, seed=1)
    recording = record_embedded(EMBEDDED["mujoco"], scene, [run], SECONDS, contacts=False)
    driven = driven_robot(run, scene, recording, AlongWay.name)
    return Drive(
        robot=name,
        unit_cm=unit_cm,
        obstacle=str(obstacle["kind"]),
        seed=seed,
        lowered=int((scene.field.levels < free.field.levels).sum()),
        seconds=driven.metrics.crossed,
        tipped=driven.metrics.tipped,
        probability=round(predictor.predict(scene, run).probability, 3),
        on_blocks=round(share_on_blocks(scene.field, robot.body, driven.trajectory), 3),
        made=round(made, 2),
    )


def share_on_blocks(field: StepField, body: Body, trajectory: Trajectory) -> float:
    """Return the share of the lowest driven samples of a robot that are over blocks, of those over the map, 0..1."""
    rows = trajectory.rows
    points = body.points[body.drives & (body.points[:, 2] < body.low[2] + _LOW)]
    c, s = np.cos(rows[:, 6, None]), np.sin(rows[:, 6, None])
    x = rows[:, 1, None] + c * points[:, 0] - s * points[:, 1]
    y = rows[:, 2, None] + s * points[:, 0] + c * points[:, 1]
    inside = (np.abs(x) < field.extent[0] / 2) & (np.abs(y) < field.extent[1] / 2)
    i, j = (
        ((along[inside] + extent / 2) / field.block_width).astype(int)
        for along, extent in zip((x, y), field.extent, strict=True)
    )
    return float((field.levels[i, j] > 0).mean()) if inside.any() else 0.0


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit code: 0; 3 where MuJoCo is not installed."""
    return recorded(arguments, __doc__, MAPS, drives, name="drives", table=table, file=FILE)


def recorded(  # noqa: PLR0913  # what differs between two benchmarks of maps in MuJoCo
    arguments: Sequence[str] | None,
    doc: str | None,
    maps: int,
    make: Callable[[int, int], Iterator[Any]],
    *,
    name: str,
    table: Callable[[Mapping[str, Any]], Iterator[str]],
    file: Path,
) -> int:
    """Print the table of what is made of a number of maps from a seed on, and keep it in a file; the exit code.

    name: under which the record has what was made
    """
    parser = argparse.ArgumentParser(description=doc)
    parser.add_argument("--maps", type=int, default=maps, help="maps in all")
    parser.add_argument("--seed", type=int, help="seed of the first map; by default it is drawn")
    parser.add_argument("--only-print", action="store_true", help="keep no record")
    options = parser.parse_args(arguments)
    if not EMBEDDED["mujoco"].version():
        print("no MuJoCo here", file=sys.stderr)
        return 3
    seed = fresh_seed() % 10**9 if options.seed is None else options.seed
    found = []
    for one in make(options.maps, seed):
        found.append(one)
        print(f"{one}", file=sys.stderr, flush=True)
    head = {"machine": machine(), "seed": seed, "simulator": str(EMBEDDED["mujoco"])}
    record = {**head, name: [asdict(one) for one in found]}
    print("\n".join(table(record)))
    if not options.only_print:
        keep(record, file)
    return 0


def table(record: Mapping[str, Any]) -> Iterator[str]:
    """Yield the figures as lines of Markdown."""
    found = [Drive(**drive) for drive in record["drives"]]
    yield (
        "| robot, unit | maps | crossed | predicted with at least 0.9 | crossed, on blocks over half of the way "
        "| share of the way on blocks | blocks lowered | CPU seconds to make a map |"
    )
    yield "|---" * 8 + "|"
    kinds = list(dict.fromkeys((drive.robot, drive.unit_cm) for drive in found))
    for robot, unit in kinds:
        yield _row(f"{robot}, {unit:g} cm", [drive for drive in found if (drive.robot, drive.unit_cm) == (robot, unit)])
    low = [drive for drive in found if (drive.robot, drive.unit_cm) not in HIGH]
    yield _row("all but wheels on blocks that they do not climb", low)
    yield _row("all", found)


def _row(name: str, found: Sequence[Drive]) -> str:
    cells = (
        len(found),
        sum(drive.crossed for drive in found),
        sum(drive.probability >= SURE for drive in found),
        sum(drive.crossed and drive.on_blocks >= _FLAT for drive in found),
        f"{mean(drive.on_blocks for drive in found):.0%}",
        f"{mean(drive.lowered for drive in found):.1f}",
        f"{mean(drive.made for drive in found):.1f}",
    )
    return f"| {name} | " + " | ".join(map(str, cells)) + " |"


if __name__ == "__main__":
    raise SystemExit(main())
