"""Accuracy of predictions: what was predicted and what happened, on fields that nobody has seen before.

python -m benchmarks.certainty               predicts and drives in MuJoCo, with both models of motors, on lanes and on
                                             planned ways of fresh fields; keeps benchmarks/results/certainty.json and
                                             its picture; a quarter of an hour on two cores
python -m benchmarks.certainty --judge classic --judge sim      in Gazebos too, with the motors that they have; as
                                             long again for each
python -m benchmarks.certainty --seed 7      the same fields again; by default the seed is drawn
python -m benchmarks.certainty --quick       the record is not kept
python -m benchmarks.certainty --robot FILE --unit 0.5 --unit 1    a robot of a file too, such as a maker's

A drive that judges is another one out of the spread, with errors of its start, position, friction and heights that no
prediction has used, and is not ended where a prediction takes the robot for held. In Gazebo it has those of its start
and position. A told probability is right if as many drives cross as it says (Brier 1950; Murphy and Winkler 1977); it
is of use if it is seldom near one half.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from benchmarks import crossings
from benchmarks.figures import RESULTS, record_in
from benchmarks.machine import machine
from rsegen.driving.drive import driven_robot
from rsegen.driving.many import wilson
from rsegen.driving.planning import predict_way, predictor_for
from rsegen.driving.prediction import Prediction, Predictor, spread_drive
from rsegen.driving.recording import RobotRun
from rsegen.driving.robot_runs import robot_runs, runs_along
from rsegen.driving.routes import AlongWay, Straight
from rsegen.driving.spread import spread_run
from rsegen.errors import SimulatorFailed
from rsegen.params.streams import SEEDS, fresh_seed
from rsegen.recipe.codec import decode
from rsegen.robots.lookup import robot_of
from rsegen.robots.parameters import MOTORS
from rsegen.scene.scene import Scene, compose
from rsegen.simulators.base import SIMULATORS
from rsegen.simulators.embedded import EMBEDDED
from rsegen.writing.execute import Execution, cores, execute

FILE, PICTURE = RESULTS / "certainty.json", Path(__file__).parents[1] / "docs" / "pictures" / "certainty.png"

PLANS: Mapping[str, tuple[float, ...]] = {
    "burger": (0.2, 0.4, 0.6, 1.0),
    "jackal": (1.0, 2.0, 3.0, 5.0),
    "crawler": (3.0, 5.0, 10.0),
}
"""The robots with their units, cm: from all fields crossed to none, and of 10 cm."""

ROUNDS, LANES, JUDGES, FIRST_JUDGE = 3, 2, 3, 1000
"""Fields of each robot and unit; lanes on each; drives that judge a prediction, and the number of the first."""

_ACROSS, _INNER = {"first": [5, 0], "last": [5, 19]}, {"first": [2, 0], "last": [7, 19]}
"""Blocks of a field of 10 x 20, a row that every lane crosses, and all but two rows at the start and the end."""

KINDS: Mapping[str, tuple[Mapping[str, Any], Mapping[str, Any]]] = {
    **{name: (obstacle, {}) for name, obstacle in crossings.OBSTACLES.items()},
    "random, slippery": ({"kind": "random", "levels": 3}, {"friction": 0.4}),
    "random, each level": ({"kind": "random", "levels": 3}, {"level_friction": [1, 0.5, 0.2]}),
    "random, framed": ({"kind": "random", "levels": 3}, {"boundary": "divided", "frame_friction": 0.5}),
    "random, 20 cm blocks": ({"kind": "random", "levels": 3}, {"block_width_cm": 20, "chunk_size": 5}),
    "horizontal_barrier": ({"kind": "horizontal_barrier", "softness": 20, **_ACROSS}, {}),
    "diagonal_barrier": ({"kind": "diagonal_barrier", "softness": 20}, {}),
    "peak": ({"kind": "peak", "softness": 60, "first": "random", "last": "random"}, {}),
    "platform": ({"kind": "platform", "softness": 30, **_INNER}, {}),
    "stairs": ({"kind": "stairs", "step_width": 2}, {}),
    "slope": ({"kind": "slope", "shape": "pyramid"}, {}),
    "waves": ({"kind": "waves", "shape": "both", "waves": 2}, {}),
    "noise": ({"kind": "noise"}, {}),
    "pallet": ({"kind": "pallet"}, {}),
    "discrete_obstacles": ({"kind": "discrete_obstacles", "count": 8}, {}),
    "rails": ({"kind": "rails", "levels": 3, "uneven": 1}, {}),
    "stones": ({"kind": "stones", "levels": 3, "stone_width": 3}, {"ground_level": 2}),
    "pit": ({"kind": "pit", "levels": 3, "gap_width": 2, **_INNER}, {"ground_level": 2}),
}
"""The kinds of fields: an obstacle, of 3 to 5 levels if it does not say how many, and what else their recipes say."""

_SECONDS, _GAZEBO_SECONDS = 20.0, 20.0
"""CPU seconds of a field, about; simulated seconds of a drive in Gazebo."""

_TITLES = {judge: crossings.TITLES[judge] for judge in (crossings.MUJOCO, *SIMULATORS)}

COLUMNS = ("robot", "field", "unit_cm", "seed", "route", "motors", "line", "told", "drives", "judge", "crossed", "of")
"""Columns of a row of the record: a prediction, and how many of the drives in a simulator that judged it crossed."""


class Field(NamedTuple):
    """A fresh field for a robot."""

    robot: str
    field: str
    unit_cm: float
    seed: int

    @property
    def scene(self) -> Scene:
        """Return its scene: 1 x 2 m, without frames, or with frames of one unit; steps of one unit at 10 cm."""
        obstacle, given = KINDS[self.field]
        recipe = {
            "name": "certainty",
            "unit_cm": self.unit_cm,
            "seed": self.seed,
            "obstacles": [{"levels": 3 + self.seed % 3, **obstacle}],
            "chunks": [1, 2],
            "boundary": "none",
            "frame_height_cm": self.unit_cm,
            **({"max_step": 1} if self.unit_cm >= 10 else {}),
            **given,
        }
        return compose(decode(recipe), 0)


def fields(plans: Mapping[str, Sequence[float]], seed: int, rounds: int) -> list[Field]:
    """Return the fields of all robots, each with a seed of its own; the kinds are dealt to them."""
    named = [(robot, unit) for robot, units in plans.items() for unit in units for _ in range(rounds)]
    rng, kinds = np.random.default_rng(seed), list(KINDS)
    dealt = [int(kind) for _ in range(0, len(named), len(kinds)) for kind in rng.permutation(len(kinds))]
    return [
        Field(robot, kinds[kind], unit, (seed + number) % SEEDS)
        for number, ((robot, unit), kind) in enumerate(zip(named, dealt, strict=False))
    ]


def judged(judges: Sequence[str], batch: Sequence[Field]) -> list[list[Any]]:
    """Return the rows of some fields, judged in MuJoCo and in Gazebos by their names."""
    return [row for field in batch for row in _rows(field, judges)]


def _rows(field: Field, judges: Sequence[str]) -> Iterator[list[Any]]:
    scene, robot = field.scene, robot_of(field.robot)
    for motors in MOTORS:
        predictor = _predictor(motors)
        runs = robot_runs(scene.field, robot, Straight.name, count=LANES, seed=1)
        predicted = [(run, predictor.predict(scene, run)) for run in runs]
        found = predict_way(predictor, scene, robot, "safe")
        if found.way is not None and found.way.crosses:
            predicted += [(run, found) for run in runs_along(scene.field, robot, found.way)]
        gazebos = [name for name in judges if _predictor(None, name).motors == motors]
        for run, told in predicted:
            yield _row(field, run, told, "mujoco", _in_mujoco(scene, run, motors))
            # A drive in Gazebo costs ten times as much; of the lanes it judges the first.
            for name in gazebos if run.name == runs[0].name or run.way is not None else ():
                yield _row(field, run, told, name, _in_gazebo(name, scene, run))


def _predictor(motors: str | None, judge: str | None = None) -> Predictor:
    """Return what predicts with a kind of motors, or with those of a Gazebo."""
    predictor = predictor_for(judge, motors)
    assert predictor is not None  # noqa: S101  # `main` looked
    return predictor


def _row(field: Field, run: RobotRun, told: Prediction, judge: str, crossed: Sequence[bool]) -> list[Any]:
    route, line = (AlongWay if run.way else Straight).name, round(run.start.y, 4)
    name = run.robot.kind, field.field, field.unit_cm, field.seed
    return [*name, route, told.motors, line, round(told.probability, 4), told.drives, judge, sum(crossed), len(crossed)]


def _in_mujoco(scene: Scene, run: RobotRun, motors: str) -> list[bool]:
    """Return whether fresh drives out of the spread cross; without those whose physics fails."""
    crossed = []
    for number in range(FIRST_JUDGE, FIRST_JUDGE + JUDGES):
        try:
            drive = spread_drive(EMBEDDED["mujoco"], scene, run, number, motors, is_whole=True)
            crossed.append(drive.seconds is not None)
        except SimulatorFailed:
            continue
    return crossed


def _in_gazebo(name: str, scene: Scene, run: RobotRun) -> list[bool]:
    """Return whether a drive in a Gazebo crosses, with errors of its start and position; nothing if it fails."""
    erring, _ = spread_run(scene, run, FIRST_JUDGE)
    try:
        recording = crossings.recorded_in(name, scene, [erring], _GAZEBO_SECONDS)
    except SimulatorFailed as error:
        print(f"no result in {_TITLES[name]}: {error}", file=sys.stderr)
        return []
    return [driven_robot(erring, scene, recording, Straight.name).metrics.crossed is not None]


# What it amounts to.

BINS = ((0.0, 0.1), (0.1, 0.3), (0.3, 0.7), (0.7, 0.9), (0.9, 1.0))
"""Probabilities that are counted together."""


class _Bin(NamedTuple):
    """Predictions of about one probability: their number, mean, and how many of the drives that judged them crossed."""

    predictions: int
    mean: float
    crossed: int
    drives: int

    @classmethod
    def of(cls, rows: Sequence[Mapping[str, Any]], low: float, high: float) -> _Bin | None:
        """Return the bin of the predictions from low to high; None if there are none."""
        told = [row for row in rows if low <= row["told"] < high or row["told"] == high == 1]
        if not told:
            return None
        crossed, drives = (sum(row[name] for row in told) for name in ("crossed", "of"))
        return cls(len(told), sum(row["told"] * row["of"] for row in told) / drives, crossed, drives)

    @property
    def interval(self) -> tuple[float, float]:
        """The share that crosses, low and high, with a confidence of 95 %."""
        return wilson(self.crossed, self.drives)


SHARP = 0.9
"""Probability from which on a prediction is sure, and below 1 minus which too."""

GOOD = 0.95
"""Share of drives as told below which a group of sure predictions is named in the summary."""


def table(record: Mapping[str, Any]) -> Iterator[str]:
    """Yield the tables of a record in Markdown."""
    for title, own in _by_judge(record).items():
        yield f"## {title}\n"
        yield f"{len(own)} predictions, {sum(row['of'] for row in own)} drives, Brier score {brier(own):.3f}"
        yield ""
        yield "| predicted | predictions | drives | crossed | 95 % interval |"
        yield "|---|---|---|---|---|"
        for low, high in BINS:
            if told := _Bin.of(own, low, high):
                counts = f"{told.predictions} | {told.drives} | {told.crossed / told.drives:.2f}"
                ends = "{:.2f} to {:.2f}".format(*told.interval)
                yield f"| {low:g} to {high:g}, mean {told.mean:.2f} | {counts} | {ends} |"
            else:
                yield f"| {low:g} to {high:g} | 0 | 0 | | |"
        yield ""
        yield "| of | predictions | sure | of sure ones right | 95 % interval | at least 0.9: crossed |"
        yield "|---|---|---|---|---|---|"
        for names in GROUPS:
            yield from _by(own, names)
        yield ""
    yield from _together(record)


def _by_judge(record: Mapping[str, Any]) -> dict[str, list[dict[str, Any]]]:
    """Return the predictions of a record that were judged, by the title of the simulator that judged them."""
    rows = [dict(zip(COLUMNS, row, strict=True)) for row in record["rows"]]
    judged_by = {title: [row for row in rows if row["judge"] == name and row["of"]] for name, title in _TITLES.items()}
    return {title: own for title, own in judged_by.items() if own}


GROUPS = ((), ("robot",), ("robot", "unit_cm"), ("route",), ("route", "motors"), ("field",))
"""Columns by which predictions are counted together."""


class _Counts(NamedTuple):
    """Counts of predictions: how many are sure, how many drives of those were as told, and which crossed as told."""

    predictions: int
    sure: int
    right: int
    of_sure: int
    crossed: int
    of_yes: int

    @classmethod
    def of(cls, rows: Sequence[Mapping[str, Any]]) -> _Counts:
        """Count the predictions of some rows."""
        sure = [row for row in rows if not 1 - SHARP < row["told"] < SHARP]
        yes = [row for row in sure if row["told"] >= SHARP]
        right = sum(row["crossed"] if row["told"] >= SHARP else row["of"] - row["crossed"] for row in sure)
        of_sure, of_yes = (sum(row["of"] for row in part) for part in (sure, yes))
        return cls(len(rows), len(sure), right, of_sure, sum(row["crossed"] for row in yes), of_yes)

    @property
    def share_sure(self) -> str:
        """The share of predictions that are sure."""
        return f"{self.sure / self.predictions:.0%}"

    @property
    def share_right(self) -> str:
        """The drives of sure predictions that were as told, of all."""
        return f"{self.right} of {self.of_sure} ({self.right / self.of_sure:.0%})" if self.of_sure else ""

    @property
    def is_weak(self) -> bool:
        """Return whether less than `GOOD` of the drives of sure predictions were as told."""
        return self.right < GOOD * self.of_sure


def _grouped(rows: Sequence[Mapping[str, Any]], names: Sequence[str]) -> dict[tuple[Any, ...], _Counts]:
    """Return the counts of each group of predictions that are alike in some columns."""
    groups: dict[tuple[Any, ...], list[Mapping[str, Any]]] = {}
    for row in rows:
        groups.setdefault(tuple(row[name] for name in names), []).append(row)
    return {key: _Counts.of(group) for key, group in groups.items()}


def _named(key: Sequence[Any]) -> str:
    """Return the name of a group: its values, with the unit of lengths."""
    return ", ".join(f"{value:g} cm" if isinstance(value, float) else str(value) for value in key) or "all"


def _by(rows: Sequence[Mapping[str, Any]], names: Sequence[str]) -> Iterator[str]:
    """Yield a row for each group of predictions that are alike in some columns."""
    for key, counts in _grouped(rows, names).items():
        ends = "{:.2f} to {:.2f}".format(*wilson(counts.right, counts.of_sure)) if counts.of_sure else ""
        told = f"{counts.crossed} of {counts.of_yes}" if counts.of_yes else ""
        yield f"| {_named(key)} | {counts.predictions} | {counts.share_sure} | {counts.share_right} | {ends} | {told} |"


RECORDS = 4
"""Records that are counted together: one alone has some twenty drives of a robot in a Gazebo."""

_TOGETHER = (), ("robot",), ("robot", "unit_cm")
"""Columns by which the predictions of several records are counted together."""


def _sums(record: Mapping[str, Any]) -> dict[str, Any]:
    """Return what is kept of a record once there is another one: its seed, and counts by simulator, robot and unit."""
    groups = [
        [title, *key, counts]
        for title, rows in _by_judge(record).items()
        for key, counts in _grouped(rows, _TOGETHER[-1]).items()
    ]
    return {"seed": record["seed"], "groups": groups}


def _counted_together(record: Mapping[str, Any]) -> dict[tuple[Any, ...], dict[str, _Counts]]:
    """Return the counts of a record and of the records before it, by group and by the simulator that judged."""
    sums: dict[tuple[Any, ...], dict[str, _Counts]] = {}
    for names, one in product(_TOGETHER, [_sums(record), *record["earlier"]]):
        for title, *key, counts in one["groups"]:
            own = sums.setdefault(tuple(key[: len(names)]), {})
            own[title] = _Counts(*map(sum, zip(own.get(title, (0,) * len(counts)), counts, strict=True)))
    return sums


def summary(record: Mapping[str, Any]) -> Iterator[str]:
    """Yield how often sure predictions are right, by simulator, and the groups in which they are less often right."""
    judged_by = _by_judge(record)
    yield "| judged by | predictions | sure | right | on lanes | on ways | >= 0.9: crossed | <= 0.1: crossed |"
    yield "|---|---|---|---|---|---|---|---|"
    for title, rows in judged_by.items():
        counts, by_route = _Counts.of(rows), _grouped(rows, ("route",))
        routes = (by_route[route,].share_right if (route,) in by_route else "" for route in ("straight", "way"))
        of_no = counts.of_sure - counts.of_yes
        crossed_no = of_no - (counts.right - counts.crossed)
        told_no = f"{crossed_no} of {of_no}"
        cells = (counts.predictions, counts.share_sure, counts.share_right, *routes)
        told_yes = f"{counts.crossed} of {counts.of_yes}"
        yield f"| {title} | {' | '.join(map(str, cells))} | {told_yes} | {told_no} |"
    yield ""
    yield f"Groups of which less than {GOOD:.0%} were right, in the newest record or in the last ones together:"
    yield ""
    yield f"| of | judged by | newest record | last {1 + len(record['earlier'])} records |"
    yield "|---|---|---|---|"
    together = _counted_together(record)
    for names in _TOGETHER[1:]:
        newest = {title: _grouped(rows, names) for title, rows in judged_by.items()}
        for key, by_title in together.items():
            # Of a robot at one unit a Gazebo has too few drives to say anything.
            for title in by_title if len(names) == 1 else ("MuJoCo",):
                pair = newest[title].get(key), by_title[title]
                if len(key) == len(names) and any(counts and counts.is_weak for counts in pair):
                    shares = (counts.share_right if counts else "" for counts in pair)
                    yield f"| {_named(key)} | {title} | {' | '.join(shares)} |"


def _together(record: Mapping[str, Any]) -> Iterator[str]:
    """Yield a table of a record and those before it, counted together."""
    sums = _counted_together(record)
    titles = list(sums[()])
    yield "## Records together"
    yield ""
    records = [record, *record["earlier"]]
    seeds = ", ".join(str(one["seed"]) for one in records)
    yield f"The last {len(records)} records counted together, of seeds {seeds}:"
    yield ""
    yield f"| of | {' | '.join(f'{title}: sure | of sure ones right' for title in titles)} |"
    yield f"|---|{'---|---|' * len(titles)}"
    for key, by_title in sums.items():
        counted = map(by_title.get, titles)  # a robot of a file may not have been judged in each of them
        cells = (f"{counts.share_sure} | {counts.share_right}" if counts else " | " for counts in counted)
        yield f"| {_named(key)} | {' | '.join(cells)} |"
    yield ""


def brier(rows: Sequence[Mapping[str, Any]]) -> float:
    """Return the mean squared difference of what was told and what happened (0 or 1), drive by drive."""
    squares = (
        row["crossed"] * (1 - row["told"]) ** 2 + (row["of"] - row["crossed"]) * row["told"] ** 2 for row in rows
    )
    return float(sum(squares) / sum(row["of"] for row in rows))


def draw(record: Mapping[str, Any]) -> None:
    """Draw the reliability diagram: how often robots crossed beside what was told, with intervals and counts."""
    from matplotlib.figure import Figure

    judged_by = _by_judge(record)
    figure = Figure(figsize=(5.2 * len(judged_by), 4.6), dpi=100, layout="constrained")
    for axes, (title, own) in zip(np.atleast_1d(figure.subplots(1, len(judged_by))), judged_by.items(), strict=True):
        axes.plot([0, 1], [0, 1], color="grey", linewidth=1, label="as told")
        for low, high in BINS:
            if told := _Bin.of(own, low, high):
                at = told.mean, told.crossed / told.drives
                axes.plot([told.mean] * 2, told.interval, color="#1f5fa8", linewidth=2)
                axes.plot(*at, "o", color="#1f5fa8", markersize=8)
                counts = f"{told.crossed} of {told.drives}"
                axes.annotate(counts, at, (7, -4), textcoords="offset points", fontsize=9)
        axes.set(
            xlim=(-0.02, 1.18),
            ylim=(-0.03, 1.03),
            xlabel="probability that was told",
            ylabel="share that crossed",
            title=f"{title}: {len(own)} predictions, Brier {brier(own):.3f}",
        )
    figure.savefig(PICTURE, metadata={"Software": None})


def loaded() -> dict[str, Any]:
    """Return the record that is kept."""
    record: dict[str, Any] = record_in(FILE)
    return record


def _keep(record: Mapping[str, Any]) -> None:
    """Write a record, with a line for each earlier one and for each prediction."""
    parts = []
    for name, value in record.items():
        lines = ",\n  ".join(json.dumps(one) for one in value) if isinstance(value, list) else ""
        parts.append(f' "{name}": ' + (f"[\n  {lines}\n ]" if lines else json.dumps(value)))
    FILE.write_text("{\n" + ",\n".join(parts) + "\n}\n", "utf-8")


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit code: 0; 3 where a simulator is not installed."""
    options = _options(arguments)
    versions = {"mujoco": EMBEDDED["mujoco"].version()}
    for name in options.judge:
        here = SIMULATORS[name].installation()
        versions[name] = here.version if here else None
    if missing := [name for name, version in versions.items() if not version]:
        print(f"no {missing[0]} here", file=sys.stderr)
        return 3
    seed = fresh_seed() % 10**9 if options.seed is None else options.seed
    plans = {name: PLANS[name] for name in options.robots} | {file: tuple(options.unit) for file in options.robot}
    every = fields(plans, seed, options.rounds)
    rows: list[list[Any]] = []
    for batch in execute(partial(judged, options.judge), every, _SECONDS, Execution(workers=options.workers)):
        rows += batch
        print(f"{len(rows)} predictions of {len(every)} fields judged", file=sys.stderr)
    last = loaded()
    record = {
        "machine": machine(),
        "seed": seed,
        "simulators": versions,
        "earlier": [_sums(last), *last["earlier"]][: RECORDS - 1],
        "columns": COLUMNS,
        "rows": rows,
    }
    print("\n".join(table(record)))
    if not options.quick:
        _keep(record)
        draw(record)
    return 0


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.certainty", description=__doc__.splitlines()[0])
    parser.add_argument("robots", nargs="*", metavar="ROBOT", default=list(PLANS), help="only these kinds")
    parser.add_argument("--robot", action="append", metavar="FILE", default=[], help="the robot of a file too")
    parser.add_argument("--unit", action="append", type=float, default=[], help="a unit for robots of files, cm")
    parser.add_argument("--judge", action="append", choices=list(SIMULATORS), default=[], help="drive in a Gazebo too")
    parser.add_argument("--seed", type=int, help="seed of the first field; by default it is drawn")
    parser.add_argument("--workers", type=int, default=cores(), help="processes")
    parser.add_argument("--rounds", type=int, default=ROUNDS, help="fields of each robot and unit")
    parser.add_argument("--quick", action="store_true", help="the record is not kept")
    return parser.parse_args(arguments)


if __name__ == "__main__":
    sys.exit(main())
