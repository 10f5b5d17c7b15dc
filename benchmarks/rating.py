"""Check that the intervals of `rsegen rate` hold what they promise: `python -m benchmarks.rating`, half an hour.

python -m benchmarks.rating                does both, prints the tables and keeps benchmarks/results/rating.json
python -m benchmarks.rating --simulated    rates simulated robots alone, ten minutes; the record of the others is kept
python -m benchmarks.rating --add          rates those of rsegen's robots that the record has not
python -m benchmarks.rating --only-print   prints the tables of the record
python -m benchmarks.rating --file robot.urdf.xacro --name "Husky, husky/husky, noetic (dff7c81)"
                                           rates a maker's robot with two seeds, and adds it to the record

Simulated robots cross with a probability that is known, so it can be counted how often an interval holds the true
level. Some have a curve of another form than the one that is fitted. rsegen's robots are rated with two seeds, whose
intervals are compared; with other motors and friction, a maker's at another speed; and by the prediction.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from math import erfc, exp, log, sqrt
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

import rsegen
from benchmarks.figures import RESULTS, keep, record_in
from benchmarks.machine import machine
from rsegen.driving.many import wilson
from rsegen.params.streams import generator
from rsegen.rating.axes import AXES
from rsegen.rating.judges import Asked, Judge, Trial
from rsegen.rating.rate import usual_fields
from rsegen.rating.rating import HALF, MOST
from rsegen.rating.run import RatingPlan, make_curve
from rsegen.recipe.recipe import Recipe
from rsegen.simulators.parameters import ignore
from rsegen.writing.execute import Execution, cores

FILE = RESULTS / "rating.json"

RUNS = 500
"""Ratings of each simulated robot: a share of 95 % is then known to 2 %."""

UNITS = 0.3, 10.0
"""The level at which half are crossed is drawn between these, cm, evenly in its logarithm."""

PRECISION = 0.1


def _logistic(z: float) -> float:
    return 1 / (1 + exp(min(z, 500)))


def _normal(z: float) -> float:
    return 0.5 * erfc(z / 1.702 / sqrt(2))


def _gumbel(z: float) -> float:
    """A curve that falls slowly at first and steeply at its end, half at 0."""
    return exp(-log(2) * exp(min(z, 50) / 1.386))


FORMS: Mapping[str, Callable[[float], float]] = {"logistic": _logistic, "normal": _normal, "Gumbel": _gumbel}
"""Share that is crossed at a number of spreads beyond the middle; all three fall alike there."""


class Curve(NamedTuple):
    """The curve of a simulated robot."""

    form: str
    spread: float
    lapse: float

    def share(self, place: float, middle: float) -> float:
        """Return the probability that it crosses at a place."""
        return (1 - self.lapse) * FORMS[self.form]((place - middle) / self.spread)

    def place(self, share: float, middle: float) -> float:
        """Return where it crosses with a probability, by bisection."""
        low, high = middle - 20.0, middle + 20.0
        for _ in range(60):
            half = (low + high) / 2
            low, high = (half, high) if self.share(half, middle) > share else (low, half)
        return low


CURVES = (
    Curve("logistic", 0.08, 0.0),
    Curve("logistic", 0.15, 0.0),
    Curve("logistic", 0.15, 0.03),
    Curve("logistic", 0.3, 0.0),
    Curve("normal", 0.2, 0.0),
    Curve("Gumbel", 0.2, 0.0),
)


@dataclass(frozen=True, kw_only=True, slots=True)
class Simulated(Judge):
    """A simulated robot: it crosses with the probability of its curve."""

    curve: Curve
    middle: float
    seed: int

    def trial(self, recipe: Recipe, asked: Asked) -> Trial:
        """Return a trial that is drawn."""
        drawn = generator(self.seed, asked.map, "simulated robot").random()
        return Trial(
            map=asked.map, level=asked.level, crossed=bool(drawn < self.curve.share(log(asked.level), self.middle))
        )


class Robot(NamedTuple):
    """A robot that is rated; what differs from the usual."""

    kind: str
    by: str = "mujoco"
    motors: str | None = None
    friction: float = 1.0
    speed: float | None = None  # m/s, of the robot of a file; None: its usual one
    seed: int = 7

    @property
    def title(self) -> str:
        """The judge and what differs, in words."""
        words = "MuJoCo" if self.by == "mujoco" else self.by
        motors = f", motors as {self.motors}" if self.motors else ""
        friction = f", friction {self.friction:g}" if self.friction != 1 else ""
        return f"{words}{motors}{friction}{f', at {self.speed:g} m/s' if self.speed else ''}"


SEEDS = 7, 8

ROBOTS = (
    *(Robot(kind, seed=seed) for kind, seed in product(("burger", "jackal", "crawler"), SEEDS)),
    *(Robot(kind, motors="classic") for kind in ("burger", "jackal")),
    *(Robot(kind, friction=0.5) for kind in ("burger", "jackal", "crawler")),
    *(Robot(kind, by="prediction") for kind in ("burger", "jackal", "crawler")),
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit code: 0."""
    options = _options(arguments)
    record: dict[str, Any] = record_in(FILE) if FILE.exists() else {}
    if options.file:
        robots = [Robot(options.file, seed=seed, speed=options.speed) for seed in SEEDS]
        made = [{**_rated(robot), "kind": options.name} for robot in robots]
        record = record_in(FILE)  # another run may have added to it meanwhile
        others = [row for row in record["makers"] if (row["kind"], row["speed"]) != (options.name, options.speed)]
        record["makers"] = [*others, *made]
        keep(record, FILE)
    elif not options.only_print:
        if not options.add:
            record |= {"machine": machine(), "simulated": list(simulated())}
            record |= {} if options.simulated else {"robots": []}
            keep(record, FILE)
        known = [_robot(row) for row in record["robots"]]
        for robot in () if options.simulated else (robot for robot in ROBOTS if robot not in known):
            record["robots"].append(_rated(robot))
            record["robots"].sort(key=lambda row: ROBOTS.index(_robot(row)))
            keep(record, FILE)
    print("\n".join(table(record)))
    return 0


def simulated(runs: int = RUNS, curves: Sequence[Curve] = CURVES) -> Iterator[dict[str, Any]]:
    """Yield for each curve how often its intervals held the true level, and what they took."""
    with ProcessPoolExecutor(cores()) as pool:
        for curve in curves:
            begin = perf_counter()
            results = np.array(list(pool.map(partial(_simulated_run, curve), range(runs), chunksize=5)))
            print(f"{curve}: {perf_counter() - begin:.0f} s", file=sys.stderr)
            half, most, error, trials = results.T
            yield {
                **curve._asdict(),
                "runs": runs,
                "half": int(half.sum()),
                "most": int(most.sum()),
                "bias": round(float(error.mean()), 5),
                "deviation": round(float(error.std()), 5),
                "trials": [int(np.quantile(trials, share)) for share in (0.05, 0.5, 0.95)],
            }


def _simulated_run(curve: Curve, seed: int) -> tuple[float, float, float, float]:
    """Return whether the intervals of half and of 80 % hold the true levels, the error of half, and the trials."""
    axis, (low, high) = AXES["unit"], UNITS
    middle = log(low) + log(high / low) * float(generator(seed, 0, "middle of a simulated robot").random())
    plan = RatingPlan(recipe=replace(usual_fields(), seed=seed), axis=axis, trials=None, precision=PRECISION)
    judge = Simulated(name="simulated", title="simulated", cost=1e-4, curve=curve, middle=middle, seed=seed)
    made = make_curve(plan, judge, (), Execution(), ignore, ignore)
    holds = []
    for share, levels in ((HALF, made.half), (MOST, made.most)):
        holds.append(float(levels.low <= exp(curve.place(share, middle)) <= levels.high))
    return holds[0], holds[1], log(made.half.level) - curve.place(HALF, middle), float(len(made.trials))


def _rated(robot: Robot) -> dict[str, Any]:
    """Return the rating of a robot."""
    recipe = replace(usual_fields(), seed=robot.seed, friction=robot.friction)
    begin = perf_counter()
    rating = rsegen.rate(robot.kind, recipe, by=robot.by, motors=robot.motors, speed=robot.speed, workers=cores())
    print(f"{robot}: {perf_counter() - begin:.0f} s", file=sys.stderr)
    assert isinstance(rating, rsegen.Rating)  # noqa: S101  # without a reliability it is one
    (curve,) = rating.curves
    return {
        **robot._asdict(),
        "title": curve.title,
        "half": [round(level, 5) for level in curve.half],
        "most": [round(level, 5) for level in curve.most],
        "spread": [round(value, 3) for value in curve.posterior.spread()],
        "trials": len(curve.trials),
    }


def pairs(record: Mapping[str, Any]) -> tuple[list[Mapping[str, Any]], list[Mapping[str, Any]]]:
    """Return the rows of the usual robots with the first seed, and with the second."""
    usual = [row for row in record["robots"] if Robot(row["kind"], seed=row["seed"]) == _robot(row)]
    rows = [*usual, *(row for row in record.get("makers", ()) if row["speed"] is None)]
    first, second = ([row for row in rows if row["seed"] == seed] for seed in SEEDS)
    return first, second


def _robot(row: Mapping[str, Any]) -> Robot:
    """Return the robot of a row of the record."""
    return Robot(**{name: row[name] for name in Robot._fields})


def table(record: Mapping[str, Any]) -> Iterator[str]:
    """Yield the figures as lines of Markdown."""
    yield "| robot | judge | seed | half at a unit of | 80 % at | trials |"
    yield "|---|---|---|---|---|---|"
    for row in (*record.get("robots", ()), *record.get("makers", ())):
        robot = _robot(row)
        levels = " | ".join(_level(row[name]) for name in ("half", "most"))
        yield f"| {robot.kind} | {robot.title} | {robot.seed} | {levels} | {row['trials']} |"
    yield (
        "\nNormal random blocks of 4 levels, 10 x 10 of 10 cm, without a frame; 95 % intervals in brackets, of half to "
        f"{PRECISION:.0%}. By {'; '.join(dict.fromkeys(row['title'] for row in record.get('robots', ())))}."
    )
    yield (
        "\n| simulated robots: form, spread, lapse | intervals of half that hold the truth | of 80 % | bias of half "
        "| standard deviation | trials: 5 %, median, 95 % |"
    )
    yield "|---|---|---|---|---|---|"
    for row in record["simulated"]:
        held = " | ".join(_share(row[name], row["runs"]) for name in ("half", "most"))
        trials = ", ".join(map(str, row["trials"]))
        errors = f"{100 * row['bias']:+.1f} % | {100 * row['deviation']:.1f} %"
        yield f"| {row['form']}, {row['spread']:g}, {row['lapse']:.0%} | {held} | {errors} | {trials} |"
    runs = record["simulated"][0]["runs"] if record["simulated"] else 0
    yield (
        f"\n{runs} ratings of each simulated robot, half at a unit between {UNITS[0]:g} and {UNITS[1]:g} cm. In "
        "parentheses is the 95 % interval of the share. Spreads are of the logarithm of the unit."
    )
    yield f"\n`python -m benchmarks.rating` on: {record['machine']}."


def summary(record: Mapping[str, Any]) -> Iterator[str]:
    """Yield a table of makers' robots, each with the level of half by the first seed, as lines of Markdown."""
    first, _ = pairs(record)
    of_makers = sorted((row for row in first if row in record["makers"]), key=lambda row: float(row["half"][0]))
    for cells in (
        [row["kind"].partition(",")[0] for row in of_makers],
        ["---"] * len(of_makers),
        [_level(row["half"]) for row in of_makers],
    ):
        yield f"| {' | '.join(cells)} |"


def _level(levels: Sequence[float]) -> str:
    level, low, high = (f"{level:.3g}" for level in levels)
    return f"{level} cm [{low}, {high}]"


def _share(count: int, of: int) -> str:
    low, high = wilson(count, of)
    return f"{count / of:.1%} ({low:.1%} to {high:.1%})"


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.rating", description=__doc__.splitlines()[0])
    parser.add_argument("--simulated", action="store_true", help="simulated robots alone")
    parser.add_argument("--add", action="store_true", help="rate those of rsegen's robots that the record has not")
    parser.add_argument("--only-print", action="store_true", help="print the tables of the record")
    parser.add_argument("--file", help="file of a maker's robot, which is rated and added to the record")
    parser.add_argument("--speed", type=float, help="its speed in m/s, in place of its usual one")
    parser.add_argument("--name", help="what its row says: the robot, its repository, branch and commit")
    options = parser.parse_args(arguments)
    if bool(options.file) != bool(options.name):
        parser.error("--file and --name are given together")
    return options


if __name__ == "__main__":
    sys.exit(main())
