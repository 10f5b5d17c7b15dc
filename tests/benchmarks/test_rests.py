"""Robots in MuJoCo are those of rsegen, and poses that came out otherwise are counted."""

from __future__ import annotations

from dataclasses import asdict, astuple, replace

import numpy as np
import pytest

from benchmarks import rests
from benchmarks.rests import Rest, Speed, table
from rsegen.robots.base import ROBOTS

REST = Rest(
    simulator="mujoco",
    robot="burger",
    seed=1,
    number=0,
    height=0.5,
    angle=0.2,
    tilt=3.0,
    slid=0.001,
    turned=0.0,
    moving=0.0,
    stands=True,
    stable=1,
    is_one=True,
    put_height=0.5,
    put_angle=2.0,
)


@pytest.mark.parametrize("kind", list(rests.UNITS))
def test_a_robot_in_mujoco_has_its_mass_and_centre(kind: str) -> None:
    mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    scene, robot = rests._scene(1, rests.UNITS[kind]), ROBOTS[kind]
    model = mujoco.MjModel.from_xml_string(rests.mjcf(scene, robot, (0.0, 0.0, 1.0, 0.0)))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert model.body_subtreemass[0] == pytest.approx(robot.body.mass)
    assert data.subtree_com[1] - np.array([0, 0, 1]) == pytest.approx(robot.body.centre, abs=1e-6)


@pytest.mark.parametrize("kind", list(rests.UNITS))
def test_robots_start_above_the_blocks_and_apart(kind: str) -> None:
    scene, body = rests._scene(1, rests.UNITS[kind]), ROBOTS[kind].body
    starts = rests._starts(scene, body, 1)
    assert len(starts) == rests.ON_A_FIELD
    assert min(z for _, _, z, _ in starts) >= rests.ABOVE - 1e-3
    places = np.array([(x, y) for x, y, _, _ in starts])
    assert np.abs(places).max() < scene.field.extent[0] / 2 - body.length / 2
    apart = np.linalg.norm(places[:, None] - places, axis=2)[~np.eye(len(places), dtype=bool)]
    assert apart.min() > body.length


def test_the_table_counts_what_came_out_otherwise() -> None:
    found = [
        REST,
        replace(REST, angle=6.0, put_angle=0.1),
        replace(REST, angle=90.0, tilt=88.0, stable=2, is_one=False, slid=0.2, moving=0.1),
    ]
    speed = Speed(robot="burger", samples=500, at_rest=4000, in_full=2000)
    record = {"columns": Rest.__slots__, "rests": [astuple(each) for each in found], "units": {"burger": 0.5}}
    lines = list(table({**record, "speeds": [asdict(speed)]}))
    assert lines[2] == (
        "| MuJoCo | burger, 0.5 cm | 3 | 0.50, 0.50 | 6.00, 73.20 | 33 % | 67 % | 33 % | 33 % | 1 | 0 | 1 | 1 |"
    )
    assert lines[-1] == "| burger | 500 | 4,000 | 2 | 2,000 |"
