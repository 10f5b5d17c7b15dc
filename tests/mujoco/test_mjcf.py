"""Robots of MJCF drive as far as they are told, on wheels that touch the ground."""

from __future__ import annotations

from math import cos, sin
from pathlib import Path

import pytest

from rsegen.cli.edge import main
from rsegen.mujoco.turning import on_flat_ground, turn_gain, turned_within
from rsegen.robots.files.sdf_file import from_file
from rsegen.robots.parameters import MOTORS
from tests.mujoco.worlds import world_of
from tests.robots.mjcf_robots import BALL, DEFAULTS, two_wheels_mjcf


@pytest.mark.parametrize("ball", [BALL, BALL.replace("-0.15", "0.15")])
def test_it_drives_as_far_as_it_is_told_and_touches_the_ground(tmp_path: Path, ball: str) -> None:
    robot = from_file(two_wheels_mjcf(tmp_path, ball=ball))
    world = on_flat_ground(robot, turn_gain(robot))
    world.step(500)
    world.drive("robot", robot, 0.3, 0.0)
    world.step(500)  # it speeds up
    before = world.poses()["robot"]
    contacts = world.step_with_contacts(3000)
    after = world.poses()["robot"]
    assert len(contacts) >= 3
    yaw = before.yaw
    ahead = (after.x - before.x) * cos(yaw) + (after.y - before.y) * sin(yaw)
    assert ahead == pytest.approx(0.9, abs=0.002)
    shares = world.shares()["robot"]
    assert {"left_wheel", "right_wheel", "base"} == {part.partition("::")[0] for part in shares}
    world.drive("robot", robot, 0.0, 0.5)
    world.step(300)
    assert turned_within(world, 2.0) == pytest.approx(1.0, abs=0.03)


@pytest.mark.parametrize("motors", MOTORS)
def test_the_damping_of_its_wheels_does_not_push_it_back(tmp_path: Path, motors: str) -> None:
    file = two_wheels_mjcf(tmp_path)
    damped = DEFAULTS.replace('damping="0.01" armature="0.001"', 'damping="0.3"').replace("-1.5 1.5", "-5 5")
    (tmp_path / "defaults.xml").write_text(damped)
    robot = from_file(file)
    world = world_of(robot, motors=motors)
    world.step(500)
    world.drive("robot", robot, 0.3, 0.0)
    contacts = world.step_with_contacts(1000)
    assert len(contacts) >= 3
    assert world.poses()["robot"].x == pytest.approx(0.3, abs=0.05)


def test_a_drive_of_its_file_crosses_a_flat_map(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = two_wheels_mjcf(tmp_path)
    recipe = tmp_path / "flat.yaml"
    recipe.write_text("name: flat\nboundary: none\n")
    assert main(["generate", str(recipe), "-o", str(tmp_path / "worlds"), "--quiet"]) == 0
    assert main(["drive", str(tmp_path / "worlds/flat_0000"), "--robot", str(file), "--duration", "8"]) == 0
    out = capsys.readouterr().out
    assert "crossed the map" in out
