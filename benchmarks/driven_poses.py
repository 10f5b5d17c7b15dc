"""Accuracy of predicted poses of robots that drive: put down level, and from the one before.

python -m benchmarks.driven_poses             prints the table and keeps its record; two minutes
python -m benchmarks.driven_poses --seed 7    on these fields again; by default the seed is drawn

Robots drive straight over fresh fields in MuJoCo. Wherever their centre of mass has come on by a centimetre, the
pose that they have there is compared with three: that of a robot that is put down level at the place, with the heading;
that of one which is put down as it stood at the place before, as on the ways that rsegen answers with; and the nearest
of all stable poses there, than which no rule can be better. A robot that drives is not at rest, so none is always near.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator, Mapping, Sequence
from math import cos, hypot, radians
from typing import Any, NamedTuple

import numpy as np

from benchmarks import crossings
from benchmarks.figures import RESULTS
from benchmarks.machine import machine
from benchmarks.rests import TIPPED, At, at_pose, errors, is_close, middle_and_high, of_rest
from rsegen.driving.recording import record_embedded
from rsegen.driving.robot_runs import robot_runs
from rsegen.driving.routes import Straight
from rsegen.field.stepfield import Array
from rsegen.params.streams import SEEDS, fresh_seed
from rsegen.recipe.codec import decode
from rsegen.robots.base import ROBOTS
from rsegen.scene.scene import Scene, compose
from rsegen.simulators.embedded import EMBEDDED
from rsegen.standing.body import Body
from rsegen.standing.ground import PaddedGround
from rsegen.standing.resting import has_stood
from rsegen.standing.settling import Settled, outer_radius, settle_from
from rsegen.standing.stable import stable_at

FILE = RESULTS / "driven_poses.json"

UNITS: Mapping[str, tuple[float, ...]] = {"burger": (0.4,), "jackal": (1.0, 2.0, 3.0), "crawler": (3.0, 5.0)}
"""Units of the fields of each robot, cm, over whose blocks it mostly gets; three kinds of random fields of each."""

ROBOTS_ON, SECONDS, APART = 2, 15.0, 0.01
"""Robots side by side on a field, simulated seconds, and metres from place to place."""

RULES = ("put down level", "follows", "nearest stable")


class DrivenPose(NamedTuple):
    """A pose on a drive: stable poses there; by each of RULES the errors of height [mm] and orientation [degrees]."""

    robot: str
    unit_cm: float
    seed: int
    stable: int
    level: tuple[float, float]
    follows: tuple[float, float]
    nearest: tuple[float, float]


def poses(robot: str, unit: float, kind: str, seed: int) -> Iterator[DrivenPose]:
    """Yield the poses of the robots on a field: 20 x 20 blocks of 10 cm without frames."""
    given = {"chunks": [2, 2], "boundary": "none", "unit_cm": unit, "seed": seed}
    scene = compose(decode({"name": "driven", "obstacles": [crossings.OBSTACLES[kind]], **given}), 0)
    runs = robot_runs(scene.field, ROBOTS[robot], Straight.name, count=ROBOTS_ON, seed=seed)
    recording = record_embedded(EMBEDDED["mujoco"], scene, runs, SECONDS, contacts=False)
    body = ROBOTS[robot].body
    for run in runs:
        driven = list(_places(scene, body, np.array(recording.trajectories[run.name].rows)))
        for stable, *found in _compared(PaddedGround.of(scene.field, outer_radius(body)), body, driven):
            yield DrivenPose(robot, unit, seed, stable, *found)


def _places(scene: Scene, body: Body, rows: Array) -> Iterator[At]:
    """Yield where a robot is that drives, at places so far from each other, while it is upright on the field."""
    last = np.full(2, np.inf)
    for at in (at_pose(body, row[1:7]) for row in rows):
        if at.axes[2, 2] < cos(radians(TIPPED)):
            return
        is_on = np.all(np.abs(at.centre[:2]) < np.array(scene.field.extent) / 2)
        if is_on and (np.isinf(last).any() or hypot(*(at.centre[:2] - last)) >= APART):
            last = at.centre[:2]
            yield at


def _compared(ground: PaddedGround, body: Body, driven: Sequence[At]) -> Iterator[tuple[Any, ...]]:
    """Yield for each place the number of its stable poses, and the errors by each rule."""
    if not driven:
        return
    x, y, _ = np.array([at.centre for at in driven]).T
    yaw, level = np.array([at.yaw for at in driven]), np.zeros((len(driven), 2))
    stable, put = stable_at(ground, body, x, y, yaw), settle_from(ground, body, x, y, yaw, level)
    before = level[:1]
    for number, at in enumerate(driven):
        own = slice(number, number + 1)
        follows: Settled = settle_from(ground, body, x[own], y[own], yaw[own], before)
        before = follows.slope if has_stood(follows).all() else level[:1]
        found = [errors(of_rest(stable.rests, each), at) for each in np.flatnonzero(stable.place == number).tolist()]
        by_level = errors(of_rest(put, number), at)
        nearest = min(found or [by_level], key=lambda error: (not is_close(*error), error[1]))
        yield int(stable.counts[number]), by_level, errors(of_rest(follows, 0), at), nearest


def table(record: Mapping[str, Any]) -> Iterator[str]:
    """Yield the table of a record in Markdown."""
    found = [DrivenPose(*row) for row in record["poses"]]
    titles = [f"{rule}: {what}" for rule in RULES for what in ("within", "height, mm", "orientation, degrees")]
    yield f"| robot, unit | poses | places with several | {' | '.join(titles)} |"
    yield "|---" * (3 + len(titles)) + "|"
    for robot, unit in dict.fromkeys((pose.robot, pose.unit_cm) for pose in found):
        own = [pose for pose in found if (pose.robot, pose.unit_cm) == (robot, unit)]
        several = f"{100 * sum(pose.stable > 1 for pose in own) / len(own):.0f} %"
        cells = [f"{robot}, {unit:g} cm", str(len(own)), several]
        for by_rule in zip(*((pose.level, pose.follows, pose.nearest) for pose in own), strict=True):
            cells.append(f"{100 * sum(is_close(*error) for error in by_rule) / len(own):.0f} %")
            cells += map(middle_and_high, zip(*by_rule, strict=True))
        yield f"| {' | '.join(cells)} |"


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit code: 0; 3 where MuJoCo is not installed."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.driven_poses", description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, help="seed of the first field; by default it is drawn")
    parser.add_argument("--only-print", action="store_true", help="keep no record")
    options = parser.parse_args(arguments)
    version = EMBEDDED["mujoco"].version()
    if not version:
        print("no mujoco here", file=sys.stderr)
        return 3
    seed = fresh_seed() % 10**9 if options.seed is None else options.seed
    plans = [(robot, unit, kind) for robot, units in UNITS.items() for unit in units for kind in crossings.OBSTACLES]
    found: list[DrivenPose] = []
    for number, plan in enumerate(plans):
        found += poses(*plan, (seed + number) % SEEDS)
        print(f"{' '.join(map(str, plan))}: {len(found)} poses", file=sys.stderr)
    record = {"machine": machine(), "seed": seed, "simulator": version, "poses": found}
    print("\n".join(table(record)))
    if not options.only_print:
        FILE.write_text(json.dumps(record).replace('], ["', '],\n["') + "\n", "utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
