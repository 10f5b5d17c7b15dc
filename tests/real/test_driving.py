"""A floor of equal blocks is a floor: a robot with soft wheels goes straight on it, whatever surrounds it.

ODE takes every triangle and box by itself, so the edges between coplanar ones are bumps. Boxes steer this robot off by
centimetres: that is known, and bounded. In Gazebo Sim rsegen's own Burger drives, by its drive system; on thousands of
boxes that takes minutes of CPU there, so it drives on meshes alone.
"""

from __future__ import annotations

from dataclasses import replace
from math import cos, radians, sin
from pathlib import Path

import numpy as np
import pytest

import rsegen
from rsegen.driving.world_file import world_with_robots
from rsegen.field.stepfield import Levels
from rsegen.gazebo import export
from rsegen.robots.base import ROBOTS
from rsegen.simulators.base import Installation
from rsegen.simulators.server import running_server
from rsegen.writing.store import write_folder
from tests.real.bodies import furnished
from tests.real.burger import SPEED, Start, Way, burger, way
from tests.real.maps import SHAPES, Shape, shape_name
from tests.simulators.simulated import simulated
from tests.support.long import long_unless

TOUCHED = [shape for shape in SHAPES if "look" not in shape]
"""The shapes in which robots touch something else."""
HEADINGS = (0, 20, 45)
SECONDS = 5
WIDTH = 0.1
UNIT = 0.01
FLOOR = 2
"""Level of the lanes."""
LEVELS = 5
TILE = 16
"""Cells along each side of the square in which a lane lies."""
LANE = 0.6
"""Metres across."""


@pytest.mark.parametrize(
    "shape", long_unless(lambda shape: not shape, TOUCHED, reason="a server per shape"), ids=shape_name
)
def test_a_robot_goes_straight_along_lanes_in_a_random_field(
    shape: Shape, gazebo_classic: Installation, tmp_path: Path
) -> None:
    go_straight(shape, 1.0, gazebo_classic, tmp_path)


@pytest.mark.long(reason="a random field in make test")
def test_a_robot_goes_straight_over_a_plain_with_few_other_cells(gazebo_classic: Installation, tmp_path: Path) -> None:
    go_straight({}, 0.25, gazebo_classic, tmp_path)


def go_straight(shape: Shape, others: float, gazebo_classic: Installation, folder: Path) -> None:
    """Robots keep to their lanes within what the shape allows."""
    ways = driven(lanes(others), gazebo_classic, folder, shape)

    assert_full_way(ways)
    aside = [abs(way.aside) for way in ways.values()]
    mean, most = bounds(shape)
    assert np.mean(aside) <= mean, ways
    assert max(aside) <= most, ways


@pytest.mark.parametrize("others", [1.0, 0.25], ids=["lanes-in-a-random-field", "plain-with-few-other-cells"])
@pytest.mark.parametrize("shape", [{}, {"mesh": "watertight"}, {"mesh": "blocks"}], ids=shape_name)
def test_a_burger_goes_straight_over_equal_blocks_in_sim(
    shape: Shape, others: float, gazebo_sim: Installation, tmp_path: Path
) -> None:
    """Also over the walls between blocks, at whose edges its caster would be held if it were a ball there."""
    ways = driven_in_sim(lanes(others), gazebo_sim, tmp_path, shape)

    assert_full_way(ways)
    assert max(abs(way.aside) for way in ways.values()) <= 0.0005, ways


def test_a_burger_goes_straight_on_the_bare_ground_in_sim(gazebo_sim: Installation, tmp_path: Path) -> None:
    ways = driven_in_sim(np.zeros_like(lanes(0)), gazebo_sim, tmp_path, {})

    assert_full_way(ways)
    assert max(abs(way.aside) for way in ways.values()) <= 0.00005, ways


def test_a_crawler_that_gazebo_sim_s_default_solver_holds_at_an_edge_crosses_with_the_other(
    gazebo_sim: Installation,
) -> None:
    """Its front wheels are at the third step; friction carries it over in MuJoCo and Gazebo Classic."""
    slope = rsegen.Slope(shape="pyramid", levels=4)
    recipe = rsegen.Recipe(unit_cm=10, chunks=(1, 2), boundary="none", obstacles=[slope])
    for solver, crosses in (("dantzig", False), ("pgs", True)):
        robots = rsegen.drive(
            replace(recipe, solver=solver), robot="crawler", simulator="sim", duration=12, predict=False
        ).robots
        assert [robot.metrics.crossed is not None for robot in robots] == [crosses], (str(gazebo_sim), solver)


def bounds(shape: Shape) -> tuple[float, float]:
    """Distances from its course that a robot may have after 1.1 m, on average and at worst, metres."""
    if shape.get("simulator") == "classic":
        return 0.00025, 0.00025
    return (0.005, 0.010) if shape.get("collision", "mesh") == "mesh" else (0.020, 0.040)


def assert_full_way(ways: dict[int, Way]) -> None:
    """At least 1 m, at the speed that was asked for."""
    for each in ways.values():
        assert each.ahead >= 1, ways
        assert each.ahead == pytest.approx(SPEED * SECONDS, rel=0.1), ways


def lanes(others: float) -> Levels:
    """Squares side by side along x, in each of them a lane of FLOOR through its middle at one of the headings.

    `others`: the share of the other cells whose level is drawn at random, FLOOR too; the rest are FLOOR as well.
    """
    rng = np.random.default_rng(1)
    shape = (len(HEADINGS), TILE, TILE)
    levels = np.where(rng.random(shape) < others, rng.integers(0, LEVELS, shape), FLOOR)
    middle = (np.arange(TILE) - (TILE - 1) / 2) * WIDTH
    for square, heading in zip(levels, map(radians, HEADINGS), strict=True):
        aside = middle[None, :] * cos(heading) - middle[:, None] * sin(heading)
        square[np.abs(aside) <= LANE / 2] = FLOOR
    return levels.reshape(-1, TILE).astype(np.int16)


def driven(levels: Levels, gazebo_classic: Installation, folder: Path, shape: Shape) -> dict[int, Way]:
    """The way of a robot along each lane, by its heading in degrees."""
    ground = float(levels[levels.shape[0] // 2, TILE // 2]) * UNIT
    starts = {heading: start(square, ground) for square, heading in enumerate(HEADINGS)}
    world = furnished(
        written(levels, folder, shape), [burger(f"robot_{heading}", at) for heading, at in starts.items()]
    )
    run = simulated(gazebo_classic, world, steps=SECONDS * 1000)
    assert not run.errors
    return {heading: way(at, run.poses[f"robot_{heading}"]) for heading, at in starts.items()}


def driven_in_sim(levels: Levels, gazebo_sim: Installation, folder: Path, shape: Shape) -> dict[int, Way]:
    """The same of rsegen's Burger in Gazebo Sim."""
    ground = float(levels[levels.shape[0] // 2, TILE // 2]) * UNIT
    starts = {heading: start(square, ground) for square, heading in enumerate(HEADINGS)}
    robot, backend = ROBOTS["burger"], gazebo_sim.backend
    models = [
        robot.model(f"robot_{heading}", backend, (at.x, at.y, at.ground, 0, 0, at.heading))
        for heading, at in starts.items()
    ]
    plain = written(levels, folder, shape)
    world = plain.with_name("robots.world")
    world.write_text(world_with_robots(plain, models, unthrottled=True, backend=backend))
    with running_server(gazebo_sim, world) as server, server.connect() as live:
        for heading in starts:
            live.send_command(robot.command(f"robot_{heading}", SPEED, 0, live.backend))
        live.step(SECONDS * 1000)
        poses = live.poses()
        assert not server.errors
    return {heading: way(at, poses[f"robot_{heading}"]) for heading, at in starts.items()}


def start(square: int, ground: float) -> Start:
    """Half of the way back from the middle of a square."""
    heading, back = radians(HEADINGS[square]), SPEED * SECONDS / 2
    x = (square + 0.5 - len(HEADINGS) / 2) * TILE * WIDTH
    return Start(x - back * cos(heading), -back * sin(heading), ground, heading)


def written(levels: Levels, folder: Path, shape: Shape) -> Path:
    """The world of a field as one model."""
    no_frame = np.zeros(levels.shape, dtype=bool)
    field = rsegen.StepField(levels=levels, frame=no_frame, block_width=WIDTH, unit=UNIT, frame_height=WIDTH)
    colours = rsegen.Random(levels=LEVELS)
    recipe = replace(rsegen.Recipe(name="lanes", seed=0, obstacles=(colours,)), **shape)
    scene = rsegen.Scene(recipe=recipe, index=0, field=field)
    write_folder(export(scene), folder / "lanes")
    return folder / "lanes" / f"{scene.name}.world"
