"""The physics engine of Gazebo Sim has maps as they are: its libraries without the server, in a program of our own."""

from __future__ import annotations

import subprocess
from collections.abc import Iterable, Iterator, Mapping
from math import pi
from pathlib import Path
from typing import Protocol

import numpy as np
import pytest

import rsegen
from rsegen.driving.world_file import world_with_robots
from rsegen.field.stepfield import Ints
from rsegen.robots.base import ROBOTS, Robot
from rsegen.robots.drives import Wheels
from rsegen.simulators.poses import Pose
from tests.real.bodies import body, furnished, tilt
from tests.real.falling import FALL, falling, judge
from tests.real.maps import example_of_each_shape, few, generated, lanes, map_name, slippery, variants
from tests.support.missing import missing

pytestmark = pytest.mark.long(reason="a package of 1.7 GB, scripts/gazebo-engine")

AXES = ("x", "y", "z", "roll", "pitch", "yaw")


class Engine(Protocol):
    """Places of the models that can move, a number of steps after a world's beginning, if joints are told speeds."""

    def __call__(self, world: Path, steps: int, *told: str) -> Mapping[str, Pose]: ...


@pytest.fixture(scope="session")
def engine() -> Engine:
    program = Path.home() / ".cache/rsegen/gazebo-engine/gazebo-engine"
    if not program.exists():
        missing("no physics engine of Gazebo Sim: run scripts/gazebo-engine")

    def simulated(world: Path, steps: int, *told: str) -> Mapping[str, Pose]:
        said = subprocess.run(
            [program, world, str(steps), *told], capture_output=True, text=True, check=True, timeout=300
        )
        return dict(map(placed, said.stdout.splitlines()))

    return simulated


def placed(line: str) -> tuple[str, Pose]:
    name, *numbers = line.split()
    return name, Pose(**dict(zip(AXES, map(float, numbers), strict=True)))


def loaded(recipes: Iterable[rsegen.Recipe]) -> list[rsegen.Recipe]:
    """The recipes whose worlds are for Gazebo Sim too."""
    return [recipe for recipe in recipes if recipe.simulator == "both"]


@pytest.mark.parametrize("recipe", loaded([*example_of_each_shape(), *few(variants())]), ids=map_name)
def test_bodies_rest_on_the_top_of_their_cell(recipe: rsegen.Recipe, engine: Engine, tmp_path: Path) -> None:
    made = generated(recipe, tmp_path)
    judge(made.scene.field, engine(falling(made), FALL))


@pytest.mark.parametrize("recipe", loaded(few(slippery())), ids=map_name)
def test_boxes_have_their_friction_and_meshes_that_of_the_engine(
    recipe: rsegen.Recipe, engine: Engine, tmp_path: Path
) -> None:
    made = generated(recipe, tmp_path)
    cubes = {name: (place, slides) for name, place, slides in lanes(made.scene)}
    world = furnished(made.world, [body(name, "cube", place) for name, (place, _) in cubes.items()])
    tilt(world)

    poses = engine(world, 400)

    has_boxes = recipe.collision != "mesh" or recipe.mesh_type == "multi"
    for name, ((x, _, _), slides) in cubes.items():
        went = poses[name].x - x
        assert 0.15 < went < 0.25 if slides and has_boxes else abs(went) < 0.002, name


@pytest.mark.parametrize("kind", ROBOTS)
@pytest.mark.parametrize("level", [0, 1])
def test_robots_stand_on_their_wheels_and_belts(kind: str, level: int, engine: Engine, tmp_path: Path) -> None:
    world = course(np.full((12, 12), level), ROBOTS[kind], (0, 0, level / 10), 10, tmp_path)
    at = engine(world, 1500)["robot"]
    assert at.z == pytest.approx(level / 10, abs=0.005)
    assert (at.x, at.y, at.roll, at.pitch) == pytest.approx((0, 0, 0, 0), abs=0.02)


@pytest.mark.parametrize("kind", ["burger", "jackal"])
def test_robots_on_wheels_cross_floors_of_blocks_as_commanded(kind: str, engine: Engine, tmp_path: Path) -> None:
    robot, levels = ROBOTS[kind], np.random.default_rng(1).integers(1, 3, size=(20, 20))
    levels[:, 7:13] = 2
    v, w = robot.drive.speed / 2, robot.drive.turn / 4
    world = course(levels, robot, (-0.6, 0, 0.2), 10, tmp_path)

    early, late = (engine(world, steps, *told(robot, v, 0))["robot"] for steps in (500, 1000))
    assert late.x - early.x == pytest.approx(v / 2, rel=0.01)
    assert (late.y, late.z, late.yaw) == pytest.approx((0, 0.2, 0), abs=0.005)

    early, late = (engine(world, steps, *told(robot, 0, w))["robot"] for steps in (500, 1000))
    assert (late.yaw - early.yaw) % (2 * pi) == pytest.approx(w / 2, rel=0.1)


@pytest.mark.parametrize(
    ("kind", "unit_cm", "collision", "climbs"),
    [
        ("jackal", 4, "mesh", True),
        ("jackal", 11, "mesh", False),
        ("burger", 0.5, "boxes", True),
        ("burger", 0.5, "mesh", True),
        ("burger", 0.7, "mesh", False),
    ],
)
def test_robots_on_wheels_climb_the_steps_of_the_manual(
    kind: str, unit_cm: float, collision: str, climbs: bool, engine: Engine, tmp_path: Path
) -> None:
    levels = np.repeat([0, 1], 10)[:, None].repeat(20, axis=1)
    v = min(ROBOTS[kind].drive.speed, 0.3)
    world = course(levels, ROBOTS[kind], (-0.5, 0, 0), unit_cm, tmp_path, collision)
    at = engine(world, round(1000 / v), *told(ROBOTS[kind], v, 0))["robot"]
    assert (at.x > 0.3) == climbs
    assert at.z == pytest.approx(unit_cm / 100 if climbs else 0, abs=0.005 if climbs else 0.03)


def course(  # what a world is made of
    levels: Ints,
    robot: Robot,
    place: tuple[float, float, float],
    unit_cm: float,
    folder: Path,
    collision: str = "mesh",
) -> Path:
    """A world of blocks 10 cm wide with a robot a little above a place."""
    matrix = rsegen.Matrix.of(levels)
    recipe = rsegen.Recipe(
        chunk_size=len(levels), boundary="none", unit_cm=unit_cm, collision=collision, seed=1, obstacles=(matrix,)
    )
    world = generated(recipe, folder).world
    x, y, z = place
    world.write_text(world_with_robots(world, [robot.model("robot", "sim", (x, y, z + 0.005, 0, 0, 0))]))
    return world


def told(robot: Robot, v: float, w: float) -> Iterator[str]:
    """The speeds of its wheels, of a robot that is to go at v, m/s, and to turn at w, rad/s."""
    assert isinstance(robot.drive, Wheels)
    apart = w * robot.drive.slip * robot.drive.separation / 2
    for joints, speed in ((robot.drive.left, v - apart), (robot.drive.right, v + apart)):
        yield from (f"robot::{joint}={speed / robot.drive.radius}" for joint in joints)
