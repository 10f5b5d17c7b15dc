"""Check that robots cross maps as surely as is asked, and how rough these are: `crossable_by: crawler:0.9`.

python -m benchmarks.asked             asks for fresh maps with several certainties, drives each robot along its ways in
                                       MuJoCo, both ways across, out of the spread of a prediction with errors that no
                                       prediction has used, prints the table and keeps benchmarks/results/asked.json;
                                       half an hour on two cores
python -m benchmarks.asked --seed 7    the same maps again; by default the seed is drawn

Maps and units are those of benchmarks/crossable, without blocks that a robot does not climb. A certainty is right if as
many drives cross as it says, or more, as the least room that is enough may be more than enough.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from statistics import mean
from time import process_time
from typing import Any

from benchmarks.crossable import HIGH, OBSTACLES, UNITS, recipe_of, recorded
from benchmarks.figures import RESULTS
from rsegen.driving.certainty import with_certainty
from rsegen.driving.planning import northward, predict_way, predictor_for
from rsegen.driving.prediction import spread_drive
from rsegen.driving.robot_runs import runs_along
from rsegen.errors import ParameterError
from rsegen.gazebo.constraint_report import constraint_report
from rsegen.params.streams import SEEDS
from rsegen.robots.base import ROBOTS
from rsegen.scene.scene import compose
from rsegen.simulators.embedded import EMBEDDED
from rsegen.standing.lattice import BEST

FILE = RESULTS / "asked.json"

MARKS = ("<!-- asked: made by docs.generate from benchmarks/results -->", "<!-- end of asked -->")
"""Between these lines of its page the table stands."""

ASKED = (0.5, 0.7, 0.9)
KINDS = [(robot, unit) for robot, units in UNITS.items() for unit in units if (robot, unit) not in HIGH]

MAPS, JUDGES, FIRST_JUDGE = 54, 3, 1000
"""Maps in all, and drives along each way that judge, with numbers from here on."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Made:
    """A map that was asked for, and the drives on it.

    room: to spare, None if no room was enough; told: the lower probability of its two ways; crossed: of `drives` along
    both; step, beside: mean step between neighbouring blocks on its ways, and beside them, units; seconds: of CPU
    """

    robot: str
    unit_cm: float
    seed: int
    asked: float
    room: float | None
    told: float = 0.0
    crossed: int = 0
    drives: int = 0
    lowered: int = 0
    step: float = 0.0
    beside: float = 0.0
    seconds: float = 0.0


def made(robot: str, unit_cm: float, seed: int, asked: float) -> Made:
    """Return a map that is asked for, driven."""
    begin = process_time()
    place: dict[str, Any] = {"robot": robot, "unit_cm": unit_cm, "seed": seed, "asked": asked}
    free = recipe_of(robot, unit_cm, OBSTACLES[seed % len(OBSTACLES)], seed)
    try:
        recipe = with_certainty(free, asked)
    except ParameterError:
        return Made(**place, room=None, seconds=round(process_time() - begin, 1))
    seconds = round(process_time() - begin, 1)
    scene, predictor = compose(recipe, 0), predictor_for(None)
    assert predictor is not None  # noqa: S101  # `main` looked
    crossed, told = 0, 1.0
    for side in (scene, northward(scene)):
        found = predict_way(predictor, side, ROBOTS[robot], BEST[0])
        assert found.way is not None  # noqa: S101  # as it was planned
        told = min(told, found.probability)
        (run,) = runs_along(side.field, ROBOTS[robot], found.way)
        drives = (
            spread_drive(EMBEDDED["mujoco"], side, run, FIRST_JUDGE + number, predictor.motors, is_whole=True)
            for number in range(JUDGES)
        )
        crossed += sum(drive.seconds is not None for drive in drives)
    report = constraint_report(scene)["crossable_by"]
    return Made(
        **place,
        room=recipe.crossable_room,
        told=round(told, 3),
        crossed=crossed,
        drives=2 * JUDGES,
        lowered=report["lowered"]["blocks"],
        step=report["roughness"]["on_ways"]["mean_step"],
        beside=report["roughness"]["beside"]["mean_step"] or 0.0,
        seconds=seconds,
    )


def maps_made(maps: int, seed: int) -> Iterator[Made]:
    """Yield the maps of all kinds and certainties, each kind with its share of a number, in two processes."""
    jobs = [
        (robot, unit, (seed + 100 * number + k) % SEEDS, asked)
        for number, (robot, unit) in enumerate(KINDS)
        for k in range(-(-maps // len(KINDS) // len(ASKED)))
        for asked in ASKED
    ]
    with ProcessPoolExecutor(2) as pool:
        yield from pool.map(made, *zip(*jobs, strict=True))


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit code: 0; 3 where MuJoCo is not installed."""
    return recorded(arguments, __doc__, MAPS, maps_made, name="maps", table=table, file=FILE)


def table(record: Mapping[str, Any]) -> Iterator[str]:
    """Yield the figures as lines of Markdown."""
    found = [Made(**one) for one in record["maps"]]
    yield (
        "| asked | maps | of which no room was enough | predicted, mean of the worse way | drives that crossed "
        "| mean step on the ways, and off them, units | blocks lowered | room to spare | CPU seconds |"
    )
    yield "|---" * 9 + "|"
    for asked in dict.fromkeys(one.asked for one in found):
        yield _row(f"{asked:g}", [one for one in found if one.asked == asked])


def _row(name: str, found: Sequence[Made]) -> str:
    there = [one for one in found if one.room is not None]
    cells = (
        len(found),
        len(found) - len(there),
        f"{mean(one.told for one in there):.2f}",
        f"{sum(one.crossed for one in there)} of {sum(one.drives for one in there)}",
        f"{mean(one.step for one in there):.2f}, {mean(one.beside for one in there):.2f}",
        f"{mean(one.lowered for one in there):.1f}",
        f"{mean(one.room for one in there if one.room is not None):.2f}",
        f"{mean(one.seconds for one in found):.0f}",
    )
    return f"| {name} | " + " | ".join(map(str, cells)) + " |"


if __name__ == "__main__":
    raise SystemExit(main())
