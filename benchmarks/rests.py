"""Accuracy of predicted poses at rest: robots fall on random fields in three simulators.

python -m benchmarks.rests    prints the tables and keeps benchmarks/results/rests.json; a quarter of an hour

The simulators are a real Gazebo Classic, MuJoCo, and the physics engine of Gazebo Sim without its server, which
scripts/gazebo-engine sets up. The joints of robots do not move in the latter two.

Every robot is put down level, 5 mm above the highest block below it, at places and headings of fresh seeds, the same in
all simulators. Some slide from where they were put down, so the prediction is that for the place and heading of their
centre of mass at the end; how good it is for the place where they were put down stands in a column of its own. All
poses count, those of robots that tipped over, too. What the simulators differ by from each other is measured alike.
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, astuple, dataclass
from itertools import combinations
from math import cos, degrees, hypot, remainder, sin, tau
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from benchmarks.figures import RESULTS, say
from benchmarks.machine import machine
from benchmarks.mujoco_robots import STEP, blocks, free_robot, model, pose_of, version
from benchmarks.report import short
from rsegen.driving.world_file import world_with_robots
from rsegen.field.stepfield import Array
from rsegen.geometry.poses import rotation
from rsegen.recipe.codec import decode
from rsegen.robots.base import ROBOTS, Robot
from rsegen.scene.scene import Scene, compose
from rsegen.simulators.base import SIMULATORS, Installation
from rsegen.simulators.server import attempted, running_server
from rsegen.standing.body import Body
from rsegen.standing.ground import PaddedGround
from rsegen.standing.resting import has_stood, resting_poses
from rsegen.standing.settling import Settled, outer_radius, settle, settle_from
from rsegen.standing.stable import stable_at
from rsegen.writing.target_worlds import world_of

FILE = RESULTS / "rests.json"

UNITS: Mapping[str, float] = {"burger": 0.5, "jackal": 2.0, "crawler": 3.0}
"""Units of the fields, cm, on which each robot mostly stands; normal random of 5 levels."""

FIELDS, ON_A_FIELD, APART, FIRST_SEED = 5, 40, 1.4, 9000
"""Fields of 10 x 10 m for each robot, robots on each, metres between them, and the seed of the first field."""

ABOVE, SECONDS, STILL_FOR = 0.005, 3.0, 0.25
"""Metres of the fall, seconds until the pose is read, and seconds before in which a robot that rests stays still."""

TIPPED, SLID, STILL = 60.0, 0.02, 0.002
"""Degrees of tilt from which a robot has tipped over; metres from which it has slid; metres by which it still moves."""

CLOSE = (5.0, 1.5)
"""Millimetres and degrees of a prediction that is close enough."""

ENGINE = Path.home() / ".cache/rsegen/gazebo-engine/gazebo-engine"
"""Place at which scripts/gazebo-engine puts its program."""

TIMED, RUNS = 4096, 5
"""Poses that are timed together, and how often: the median counts."""

PEER = 2000
"""Poses a second that Oehler and von Stryk (2023) give for theirs, in C++ and on a machine of their own."""


class At(NamedTuple):
    """Place of a centre of mass, metres, and the robot's axes as columns, (3, 3)."""

    centre: Array
    axes: Array

    @property
    def yaw(self) -> float:
        """Its heading, radians."""
        return float(np.arctan2(self.axes[1, 0], self.axes[0, 0]))


@dataclass(frozen=True, kw_only=True, slots=True)
class Rest:
    """A robot in a simulator at the end, and by how much a prediction differs: height in mm, orientation in degrees.

    tilt: degrees, at the end; slid: metres along the ground, and turned: degrees about the vertical, since it was put
    down; moving: metres in the last quarter of a second; stands: whether it was predicted to stand; stable: how many
    stable poses it is said to have there, and is_one: whether the simulator's pose is close to one of them; put_height,
    put_angle: the errors of the prediction for the place where it was put down
    """

    simulator: str
    robot: str
    seed: int
    number: int
    height: float
    angle: float
    tilt: float
    slid: float
    turned: float
    moving: float
    stands: bool
    stable: int
    is_one: bool
    put_height: float
    put_angle: float

    @property
    def is_close(self) -> bool:
        """Return whether the prediction is close enough."""
        return is_close(self.height, self.angle)


@dataclass(frozen=True, kw_only=True, slots=True)
class Speed:
    """Poses a second on one core: at rest alone, and with all that follows; samples of the robot's underside."""

    robot: str
    samples: int
    at_rest: float
    in_full: float


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit code: 0; 3 where there is no Gazebo Classic, or no engine of Gazebo Sim."""
    options = _options(arguments)
    here = SIMULATORS["classic"].installation()
    if not here or not ENGINE.exists():
        missing = "gazebo-engine" if here else "gazebo-classic"
        print(f"a simulator is not here: run scripts/{missing}", file=sys.stderr)
        return 3
    found, apart = [], []
    for name in options.robots:
        rests, between = _of_robot(here, ROBOTS[name], say)
        found += rests
        apart += between
    record = {
        "machine": machine(),
        "simulators": [str(here), version(), "ignition-physics 5, DART"],
        "units": {name: UNITS[name] for name in options.robots},
        "columns": Rest.__slots__,
        "rests": [astuple(rest) for rest in (*found, *apart)],
        "speeds": [asdict(_speed(ROBOTS[name])) for name in options.robots],
    }
    print("\n".join(table(record)))
    if not options.only_print:
        FILE.write_text(json.dumps(record).replace("], [", "],\n[") + "\n", "utf-8")  # a line for each rest
    return 0


def _of_robot(here: Installation, robot: Robot, say: Callable[[str], None]) -> tuple[list[Rest], list[Rest]]:
    """Return the rests of a robot in all simulators, and those of each two compared with each other."""
    body, found, between = robot.body, [], []
    for seed in range(FIRST_SEED, FIRST_SEED + FIELDS):
        scene = _scene(seed, UNITS[robot.kind])
        ground, starts = PaddedGround.of(scene.field, outer_radius(body)), _starts(scene, body, seed)
        ends = {
            "classic": attempted(lambda scene=scene, starts=starts: _in_classic(here, scene, robot, starts))[0],  # type: ignore[misc]  # mypy has no types for defaults of lambdas
            "mujoco": [_in_mujoco(scene, robot, start) for start in starts],
            "engine": _in_engine(scene, robot, starts),
        }
        for simulator, states in ends.items():
            for number, (start, state) in enumerate(zip(starts, states, strict=True)):
                found.append(_rest(simulator, robot, seed, number, ground, start, state))
        for pair in combinations(ends, 2):
            for number, (one, other) in enumerate(zip(*(ends[name] for name in pair), strict=True)):
                two = " from ".join(pair)
                between.append(_difference(two, robot, seed, number, at_pose(body, one[1]), at_pose(body, other[1])))
        close = sum(rest.is_close for rest in found[-len(ends) * ON_A_FIELD :])
        say(f"{robot.kind}, seed {seed}: {close} of {len(ends) * ON_A_FIELD} close")
    return found, between


def _scene(seed: int, unit: float) -> Scene:
    given = {"boundary": "none", "unit_cm": unit, "seed": seed, "chunks": [10, 10]}
    return compose(decode({"name": "rests", **given, "obstacles": [{"kind": "normal_random", "levels": 5}]}), 0)


Start = tuple[float, float, float, float]
"""x, y, z of the origin, metres, and the heading, radians."""

State = tuple[Array, Array]
"""Poses x, y, z, roll, pitch, yaw of the origin, some time before the end and then."""


def _starts(scene: Scene, body: Body, seed: int) -> list[Start]:
    """Return starts in rows, with places in their squares and headings at random: level, above the highest block."""
    rng, across = np.random.default_rng(seed), int(scene.field.extent[0] / APART)
    ground = PaddedGround.of(scene.field, outer_radius(body))
    free = (APART - 2 * outer_radius(body)) / 2
    starts = []
    for k in range(ON_A_FIELD):
        x, y = ((at - (across - 1) / 2) * APART for at in divmod(k, across))
        x, y = x + max(free, 0.05) * (2 * rng.random() - 1), y + max(free, 0.05) * (2 * rng.random() - 1)
        yaw = tau * rng.random()
        c, s = cos(yaw), sin(yaw)
        below = ground.below(
            x + c * body.points[:, 0] - s * body.points[:, 1], y + s * body.points[:, 0] + c * body.points[:, 1]
        )
        starts.append((x, y, float((below - body.points[:, 2]).max()) + ABOVE, yaw))
    return starts


def _in_classic(here: Installation, scene: Scene, robot: Robot, starts: Sequence[Start]) -> list[State]:
    """Return the states of robots that rest in one world, each far from the next."""
    names = [f"{robot.kind}_{number}" for number in range(len(starts))]
    at = [(x, y, z, 0, 0, yaw) for x, y, z, yaw in starts]
    models = [robot.model(name, here.backend, pose) for name, pose in zip(names, at, strict=True)]
    with world_of(scene).on_disk() as world, tempfile.TemporaryDirectory(prefix="rsegen-") as folder:
        file = Path(folder, world.name)
        file.write_text(world_with_robots(world, models, unthrottled=True, backend=here.backend), "utf-8")
        with running_server(here, file, models=world.absolute().parent.parent) as server, server.connect() as live:
            live.step(round((SECONDS - STILL_FOR) / STEP))
            before = live.poses()
            live.step(round(STILL_FOR / STEP))
            after = live.poses()
    return [tuple(_six(poses[name]) for poses in (before, after)) for name in names]  # type: ignore[misc]  # two of them


def _six(pose: Any) -> Array:
    return np.array([pose.x, pose.y, pose.z, pose.roll, pose.pitch, pose.yaw])


def _in_engine(scene: Scene, robot: Robot, starts: Sequence[Start]) -> list[State]:
    """Return the states of robots that rest in one world of Gazebo Sim's engine, whose joints are told to stand."""
    names = [f"{robot.kind}_{number}" for number in range(len(starts))]
    models = [
        robot.model(name, "sim", (x, y, z, 0, 0, yaw)) for name, (x, y, z, yaw) in zip(names, starts, strict=True)
    ]
    joints = re.findall('<joint name="(.+?)" type="revolute"', models[0])
    told = [f"{name}::{joint}=0" for name in names for joint in joints]
    with world_of(scene).on_disk() as world:
        file = world.with_name("rests.world")
        file.write_text(world_with_robots(world, models), "utf-8")
        steps = ",".join(f"{round(seconds / STEP)}" for seconds in (SECONDS - STILL_FOR, STILL_FOR))
        command = [str(ENGINE), str(file), steps, *told]
        lines = subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()
    before, after = (
        {name: np.array(values, float) for name, *values in map(str.split, part)}
        for part in (lines[: len(names)], lines[len(names) :])
    )
    return [(before[name], after[name]) for name in names]


def _in_mujoco(scene: Scene, robot: Robot, start: Start) -> State:
    """Return the state of a robot that rests alone, on the blocks that it can reach."""
    import mujoco

    compiled = mujoco.MjModel.from_xml_string(mjcf(scene, robot, start))
    data, states = mujoco.MjData(compiled), []
    for seconds in (SECONDS - STILL_FOR, STILL_FOR):
        for _ in range(round(seconds / STEP)):
            mujoco.mj_step(compiled, data)
        states.append(pose_of(mujoco, data))
    return states[0], states[1]


def mjcf(scene: Scene, robot: Robot, start: Start) -> str:
    """Return an MJCF model: a robot whose joints do not move, above the blocks below and around it."""
    x, y, z, yaw = start
    near = (x, y, outer_radius(robot.body) + 0.3)
    return model([blocks(scene.field, near), free_robot(robot, (x, y, z, 0, 0, yaw))])


def at_pose(body: Body, pose: Array) -> At:
    """Return the centre of mass and the axes of a robot whose origin is at a pose."""
    axes = np.asarray(rotation(*pose[3:]))
    return At(pose[:3] + axes @ body.centre, axes)


def _predicted(ground: PaddedGround, body: Body, at: At) -> tuple[Settled, At]:
    """Return the robot at rest with its centre of mass above or below a place, and its heading there."""
    rest = settle_from(ground, body, at.centre[:1], at.centre[1:2], np.array([at.yaw]), np.zeros((1, 2)))
    return rest, of_rest(rest, 0)


def of_rest(rest: Settled, number: int) -> At:
    """Return where one of the robots at rest is."""
    return At(np.array([rest.x[number], rest.y[number], rest.z[number]]), rest.axes[number])


def _rest(  # noqa: PLR0913, PLR0917  # one pose, in all respects
    simulator: str, robot: Robot, seed: int, number: int, ground: PaddedGround, start: Start, state: State
) -> Rest:
    body = robot.body
    before, end, put = (
        at_pose(body, state[0]),
        at_pose(body, state[1]),
        at_pose(body, np.array([*start[:3], 0, 0, start[3]])),
    )
    settled, rest = _predicted(ground, body, end)
    _, there = _predicted(ground, body, put)
    (height, angle), (put_height, put_angle) = errors(rest, end), errors(there, end)
    told = stable_at(ground, body, *(np.array([at]) for at in (*end.centre[:2], end.yaw))).rests
    return Rest(
        simulator=simulator,
        robot=robot.kind,
        seed=seed,
        number=number,
        height=height,
        angle=angle,
        tilt=round(degrees(float(np.arccos(np.clip(end.axes[2, 2], -1, 1)))), 2),
        slid=round(hypot(*(end.centre - put.centre)[:2]), 4),
        turned=round(degrees(remainder(end.yaw - put.yaw, tau)), 2),
        moving=round(float(np.linalg.norm(end.centre - before.centre)), 5),
        stands=bool(has_stood(settled)[0]),
        stable=len(told.x),
        is_one=any(is_close(*errors(of_rest(told, each), end)) for each in range(len(told.x))),
        put_height=put_height,
        put_angle=put_angle,
    )


def errors(one: At, other: At) -> tuple[float, float]:
    """Return the difference of heights, millimetres, and of orientations apart from the heading, degrees."""
    cosine = float(one.axes[:, 2] @ other.axes[:, 2])
    return round(1e3 * abs(float(one.centre[2] - other.centre[2])), 3), round(
        degrees(float(np.arccos(np.clip(cosine, -1, 1)))), 3
    )


def is_close(height: float, angle: float) -> bool:
    """Return whether differences of height [mm] and orientation [degrees] are small enough."""
    return height <= CLOSE[0] and angle <= CLOSE[1]


def _difference(pair: str, robot: Robot, seed: int, number: int, one: At, other: At) -> Rest:
    """Return how two simulators differ about a robot that was put down alike."""
    height, angle = errors(one, other)
    tilt = round(degrees(float(np.arccos(np.clip(min(one.axes[2, 2], other.axes[2, 2]), -1, 1)))), 2)
    return Rest(
        simulator=pair,
        robot=robot.kind,
        seed=seed,
        number=number,
        height=height,
        angle=angle,
        tilt=tilt,
        slid=round(hypot(*(one.centre - other.centre)[:2]), 4),
        turned=round(degrees(remainder(one.yaw - other.yaw, tau)), 2),
        moving=0.0,
        stands=True,
        stable=0,
        is_one=False,
        put_height=height,
        put_angle=angle,
    )


def _speed(robot: Robot) -> Speed:
    """Time poses of a robot: CPU time of all threads, so that it is that of one core."""
    scene, body = _scene(FIRST_SEED, UNITS[robot.kind]), robot.body
    rng, half = np.random.default_rng(1), scene.field.extent[0] / 2
    x, y, yaw = (rng.uniform(-most, most, TIMED) for most in (half, half, np.pi))
    ground = PaddedGround.of(scene.field, outer_radius(body))

    def rate(work: Callable[[], object]) -> float:
        seconds = []
        for _ in range(RUNS):
            begin = time.process_time()
            work()
            seconds.append(time.process_time() - begin)
        return TIMED / float(np.median(seconds))

    return Speed(
        robot=robot.kind,
        samples=len(body.points),
        at_rest=round(rate(lambda: settle(ground, body, x, y, yaw))),
        in_full=round(rate(lambda: resting_poses(scene.field, body, x, y, yaw))),
    )


_TITLES = {"classic": "Gazebo Classic", "mujoco": "MuJoCo", "engine": "Gazebo Sim's engine"}


def table(record: Mapping[str, Any]) -> Iterator[str]:
    """The figures as lines of Markdown."""
    found = [Rest(**dict(zip(record["columns"], row, strict=True))) for row in record["rests"]]
    yield (
        "| compared with | robot, unit | poses | height, mm | orientation, degrees | within 5 mm and 1.5 degrees "
        "| within, of one of its stable poses | places with several | within, for where it was put down | tipped over "
        "| predicted to tip | slid 2 cm | not at rest |"
    )
    yield "|---" * 13 + "|"
    for simulator, name in dict.fromkeys((rest.simulator, rest.robot) for rest in found):
        own = [rest for rest in found if (rest.simulator, rest.robot) == (simulator, name)]
        close = sum(rest.is_close for rest in own)
        put = sum(is_close(rest.put_height, rest.put_angle) for rest in own)
        cells = [
            " from ".join(_TITLES[one] for one in simulator.split(" from ")),
            f"{name}, {record['units'][name]:g} cm",
            f"{len(own)}",
            middle_and_high([rest.height for rest in own]),
            middle_and_high([rest.angle for rest in own]),
            f"{100 * close / len(own):.0f} %",
            f"{100 * sum(rest.is_one or rest.is_close for rest in own) / len(own):.0f} %"
            if simulator in _TITLES
            else "",
            f"{100 * sum(rest.stable > 1 for rest in own) / len(own):.0f} %" if simulator in _TITLES else "",
            f"{100 * put / len(own):.0f} %" if simulator in _TITLES else "",
            f"{sum(rest.tilt > TIPPED for rest in own)}",
            f"{sum(not rest.stands for rest in own)}" if simulator in _TITLES else "",
            f"{sum(rest.slid > SLID for rest in own)}",
            f"{sum(rest.moving > STILL for rest in own)}" if simulator in _TITLES else "",
        ]
        yield f"| {' | '.join(cells)} |"
    yield ""
    yield (
        "| robot | samples | poses at rest per second and core | times the 2,000 of [Oehler and von Stryk](#sources) "
        "| with stability and forces |"
    )
    yield "|---|---|---|---|---|"
    for speed in (Speed(**speed) for speed in record["speeds"]):
        rates = f"{speed.at_rest:,.0f} | {short(speed.at_rest / PEER)} | {speed.in_full:,.0f}"
        yield f"| {speed.robot} | {speed.samples:,} | {rates} |"


def middle_and_high(values: Sequence[float]) -> str:
    """Return the median and the 90th percentile."""
    middle, high = np.percentile(values, [50, 90])
    return f"{middle:.2f}, {high:.2f}"


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.rests", description=__doc__.splitlines()[0])
    parser.add_argument("robots", nargs="*", metavar="ROBOT", default=list(UNITS), help="only these kinds")
    parser.add_argument("--only-print", action="store_true", help="keep no record")
    return parser.parse_args(arguments)


if __name__ == "__main__":
    sys.exit(main())
