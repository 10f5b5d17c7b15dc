"""`python -m benchmarks.lanes MODEL.sdf`: how far a robot strays on lanes of equal blocks, driving straight ahead.

Five squares of 26 x 26 cells with random levels, and through the middle of each a lane 0.6 m wide of one level, at five
headings. The robot of any SDF file, or a kind of rsegen's, is told to go ahead and nothing else.
The maps are those that rsegen writes, so what is measured is what people get; `--change` tries what else ODE could be
told.
"""

from __future__ import annotations

import argparse
import re
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import astuple, dataclass, field, replace
from itertools import product
from math import ceil, cos, radians, sin
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from rsegen import Matrix, Recipe
from rsegen.driving.recording import RobotRun, send_commands
from rsegen.driving.routes import Motion, Route
from rsegen.driving.world_file import time_step, world_with_robots
from rsegen.field.stepfield import Levels
from rsegen.robots.base import ROBOTS
from rsegen.robots.files.sdf_file import from_file
from rsegen.robots.lookup import DrivableRobot
from rsegen.scene.scene import compose
from rsegen.simulators.base import SIMULATORS, Installation
from rsegen.simulators.poses import Pose
from rsegen.simulators.process import usage
from rsegen.simulators.server import attempted, running_server
from rsegen.writing.target_worlds import write_world
from tests.real.burger import Start, way

HEADINGS = (0, 20, 45, 70, 90)
"""Degrees."""
TILE, LANE, FLOOR, LEVELS = 26, 0.6, 2, 5
"""Cells along a square, metres across its lane, the lane's level, and how many levels there are around it."""
WIDTH = 0.1
METRES, SPEED = 2.2, 0.22
"""Length of a drive, and its speed in m/s or the most that the robot does."""
PERIOD = 0.5
"""Seconds between two commands, and two looks at the robots; the first is not measured.

A start at full speed turns some robots by a milliradian or more, on the bare ground too: `--after` leaves more out.
"""
GROUNDS = ("plane", "both", "classic")
"""The bare ground, the default map, and one made with `--simulator classic`."""
_CONTACT = "<contact><ode><kd>1000</kd></ode></contact>"
_FRICTION = "<friction><ode><mu>1</mu><mu2>1</mu2></ode></friction>"


_SURFACE = re.compile(r"<surface>\s*" + re.escape(_CONTACT) + r"\s*" + re.escape(_FRICTION))
"""Beginning of the surface of a map's collision in its SDF."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Change:
    """Changes to a map: fields of its recipe; contact and friction of its collision, and the solver, in SDF of ODE."""

    recipe: Mapping[str, Any] = field(default_factory=dict)
    contact: str = ""
    friction: str = ""
    max_contacts: int = 0
    solver: str = ""

    def __call__(self, text: str) -> str:
        """The text of a world or model with the changes."""
        own = _CONTACT.replace("<kd>", self.contact + "<kd>") if "<kd>" not in self.contact else ""
        contact = own or f"<contact><ode>{self.contact}</ode></contact>"
        most = f"<max_contacts>{self.max_contacts}</max_contacts>" if self.max_contacts else ""
        friction = _FRICTION.replace("</ode>", self.friction + "</ode>")
        text = _SURFACE.sub(f"{most}<surface>{contact}{friction}", text)
        return re.sub("(<physics[^>]*>)", rf"\1{self.solver}", text, count=1)


def _solver(content: str) -> str:
    return f"<ode><solver><type>quick</type>{content}</solver></ode>"


CHANGES: Mapping[str, Change] = {
    "none": Change(),
    "watertight": Change(recipe={"mesh": "watertight"}),
    "boxes": Change(recipe={"collision": "boxes"}),
    **{f"kd-{kd}": Change(contact=f"<kd>{kd}</kd>") for kd in (1, 100, 10_000)},
    **{f"kp-1e{power}": Change(contact=f"<kp>1e{power}</kp>") for power in (5, 7)},
    "min-depth": Change(contact="<min_depth>0.001</min_depth>"),
    "max-vel": Change(contact="<max_vel>0</max_vel>"),
    "soft-cfm": Change(contact="<soft_cfm>0.001</soft_cfm>"),
    "soft-erp": Change(contact="<soft_erp>0.8</soft_erp>"),
    **{f"max-contacts-{most}": Change(max_contacts=most) for most in (2, 4)},
    **{f"slip-{slip}": Change(friction=f"<slip1>{slip}</slip1><slip2>{slip}</slip2>") for slip in (0.01, 0.1)},
    "fdir1": Change(friction="<fdir1>1 0 0</fdir1>"),
    "cone": Change(solver=_solver("<friction_model>cone_model</friction_model>")),
    "box-friction": Change(solver=_solver("<friction_model>box_model</friction_model>")),
    "iterations-200": Change(solver=_solver("<iters>200</iters>")),
    "exact-solver": Change(solver="<ode><solver><type>world</type></solver></ode>"),
}
"""Changes of Gazebo Classic's settings, by the name of `--change`."""

NOTHING_HERE = 3
"""Exit code."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Ahead(Route):
    """Straight ahead, whatever comes."""

    name: ClassVar[str] = "ahead"
    period: ClassVar[float] = PERIOD

    speed: float

    def motion(self, at: Pose) -> Motion:
        """No turn."""
        return Motion(self.speed, 0.0)


@dataclass(frozen=True, kw_only=True, slots=True)
class Lane:
    """A drive along a lane: mm to the left at the end, metres ahead, mm by which the robot's height changes.

    commanded: the metres that it should have come ahead
    """

    heading: int
    aside: float
    ahead: float
    shake: float
    commanded: float = METRES
    cost: float = 0.0  # CPU s of the server per simulated second, of all robots together


def recipe(seed: int, ground: str = "both") -> Recipe:
    """The map of a seed for a simulator; with ground "plane" one without any block."""
    rng = np.random.default_rng(seed)
    levels = np.concatenate([_square(heading, rng) for heading in HEADINGS]) * (ground != "plane")
    return Recipe(
        simulator="both" if ground == "plane" else ground,
        chunk_size=TILE,
        chunks=(len(HEADINGS), 1),
        boundary="none",
        unit_cm=1,
        seed=seed,
        obstacles=(Matrix.of(levels),),
    )


def runs(robot: DrivableRobot, ground: str) -> Sequence[RobotRun]:
    """The robot on each lane, half of the way back from the middle of its square."""
    speed = min(SPEED, robot.speed)
    return [
        RobotRun(name=f"robot_{number}", robot=robot, start=pose, route=lambda: Ahead(speed=speed))
        for number, (_, pose) in enumerate(starts(ground))
    ]


def starts(ground: str) -> Iterator[tuple[int, Pose]]:
    """Heading in degrees and start pose of every lane."""
    top = FLOOR * 0.01 if ground != "plane" else 0.0
    for column, heading in enumerate(HEADINGS):
        x, turn = (column + 0.5 - len(HEADINGS) / 2) * TILE * WIDTH, radians(heading)
        yield heading, Pose(x=x - METRES / 2 * cos(turn), y=-METRES / 2 * sin(turn), z=top, yaw=turn)


@dataclass(frozen=True, kw_only=True, slots=True)
class Settings:
    """Changes of the map, how long robots stand first, and how long they drive before they are measured [s]."""

    change: Change = CHANGES["none"]
    stand: float = 0.0
    after: float = PERIOD


def drives(
    robot: DrivableRobot, seed: int, ground: str, here: Installation, settings: Settings | None = None
) -> list[Lane]:
    """The drives on the map of a seed."""
    settings = settings or Settings()
    change = settings.change
    with tempfile.TemporaryDirectory() as folder:
        file = write_world(compose(replace(recipe(seed, ground), **change.recipe), 0), Path(folder))
        model = file.with_name("model.sdf")
        model.write_text(change(model.read_text()))
        models = [run.robot.model(run.name, here.backend, astuple(run.start)) for run in runs(robot, ground)]
        world = file.with_name("lanes.world")
        world.write_text(change(world_with_robots(file, models, unthrottled=True, backend=here.backend)))
        return attempted(lambda: _run(robot, world, ground, here, settings))[0]


def _run(robot: DrivableRobot, world: Path, ground: str, here: Installation, settings: Settings) -> list[Lane]:
    driven, step = runs(robot, ground), time_step(world.read_text())
    commanded = METRES - (settings.after - PERIOD) * min(SPEED, robot.speed)
    routes = {run.name: run.route() for run in driven}
    poses: list[Mapping[str, Pose]] = [{run.name: run.start for run in driven}]
    with running_server(here, world, models=world.parent.parent) as server, server.connect() as live:
        if settings.stand:
            live.step(round(settings.stand / step))
            poses = [live.poses()]
        turns = 1 + ceil(METRES / min(SPEED, robot.speed) / PERIOD)
        before = usage(server.pid).cpu
        for _ in range(turns):
            send_commands(live, driven, routes, poses[-1])
            live.step(round(PERIOD / step))
            poses.append(live.poses())
        cost = (usage(server.pid).cpu - before) / (turns * PERIOD)
    return [
        _lane(heading, [each[run.name] for each in poses][round(settings.after / PERIOD) :], commanded, cost)
        for (heading, _), run in zip(starts(ground), driven, strict=True)
    ]


def _lane(heading: int, poses: Sequence[Pose], commanded: float, cost: float) -> Lane:
    first, heights = poses[0], [pose.z for pose in poses[1:]]
    gone = way(Start(first.x, first.y, first.z, first.yaw), poses[-1])
    shake = 1000 * (max(heights) - min(heights))
    aside = 1000 * gone.aside
    return Lane(heading=heading, aside=aside, ahead=gone.ahead, shake=shake, commanded=commanded, cost=cost)


def summary(lanes: Sequence[Lane]) -> str:
    """Mean (max) of the drift and of the shake, and how many robots did not come on."""
    aside, shake = ([abs(getattr(lane, what)) for lane in lanes] for what in ("aside", "shake"))
    stuck = sum(lane.ahead < lane.commanded - 0.2 for lane in lanes)
    said = f"{np.mean(aside):.2f} ({max(aside):.2f}) mm aside, {np.mean(shake):.2f} ({max(shake):.2f}) mm up and down"
    return f"{said}, {stuck} of {len(lanes)} stuck" if stuck else said


def _square(heading: int, rng: np.random.Generator) -> Levels:
    levels = rng.integers(0, LEVELS, (TILE, TILE))
    middle = (np.arange(TILE) - (TILE - 1) / 2) * WIDTH
    turn = radians(heading)
    aside = middle[None, :] * cos(turn) - middle[:, None] * sin(turn)
    levels[np.abs(aside) <= LANE / 2] = FLOOR
    return levels.astype(np.int16)


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit code: 0, or 3 where the simulator is not here."""
    options = _options(arguments)
    here = SIMULATORS[options.simulator].installation()
    if not here:
        print(f"no {SIMULATORS[options.simulator].title} here", file=sys.stderr)
        return NOTHING_HERE
    robot = ROBOTS[options.robot] if options.robot in ROBOTS else from_file(options.robot, options.wheels)
    for ground, change in product(options.grounds, options.change):
        settings = Settings(change=CHANGES[change], stand=options.stand, after=options.after)
        lanes = [lane for seed in options.seeds for lane in drives(robot, seed, ground, here, settings)]
        title = ground if change == "none" else f"{ground} with {change}"
        cost = np.mean([lane.cost for lane in lanes])
        print(f"{robot.kind} on {title} in {here}: {summary(lanes)}; {cost:.2f} s of CPU per second", flush=True)
        for heading in HEADINGS:
            print(f"  {heading} degrees: {summary([lane for lane in lanes if lane.heading == heading])}", flush=True)
    return 0


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.lanes", description=__doc__)
    parser.add_argument("robot", metavar="MODEL.sdf", help="SDF or URDF file of a model, or a kind of robot")
    parser.add_argument("--wheels", metavar="LEFT,RIGHT", help="joints of its wheels, as for rsegen drive")
    parser.add_argument("--simulator", choices=list(SIMULATORS), default="classic")
    parser.add_argument("--grounds", nargs="+", choices=GROUNDS, default=GROUNDS)
    parser.add_argument("--after", type=float, default=PERIOD, metavar="SECONDS", help="how much is not measured")
    parser.add_argument("--stand", type=float, default=0.0, metavar="SECONDS", help="how long robots stand first")
    parser.add_argument("--change", nargs="+", choices=list(CHANGES), default=["none"], help="what else ODE is told")
    parser.add_argument("--seeds", nargs="+", type=int, default=[1, 2, 3])
    return parser.parse_args(arguments)


if __name__ == "__main__":
    sys.exit(main())
