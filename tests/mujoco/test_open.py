"""`rsegen open --simulator mujoco`: a map in MuJoCo's own window, or in real time without one."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import rsegen
from rsegen.cli.edge import main
from rsegen.mujoco import window
from rsegen.mujoco.map_model import map_model
from rsegen.mujoco.simulator import Mujoco
from rsegen.mujoco.world import MujocoWorld
from rsegen.robots.lookup import robot_of
from rsegen.simulators.embedded import PlacedRobot
from rsegen.simulators.poses import adjacent_pose
from tests.support.complaints import the_line
from tests.support.screen import xvfb

Capture = pytest.CaptureFixture[str]
RECIPE = rsegen.Recipe(seed=1, chunk_size=4, obstacles=(rsegen.Random(levels=4),))


def opened(*flags: str) -> int:
    return main(["open", "peak", "--simulator", "mujoco", *flags])


@pytest.fixture
def screen(monkeypatch: pytest.MonkeyPatch) -> None:
    """A screen is said to be there, and is not."""
    monkeypatch.setenv("DISPLAY", ":4711")


def test_without_a_window_a_map_runs_in_real_time_until_the_seconds_are_over(capsys: Capture) -> None:
    begun = time.monotonic()
    assert opened("--robot", "burger", "--headless", "--seconds", "1", "--json") == 0
    assert time.monotonic() - begun > 1
    told = json.loads(capsys.readouterr().out)
    assert told == {
        "simulator": str(Mujoco()),
        "world": "peak_0000",
        "address": {},
        "exit_code": None,
        "errors": [],
    }


def test_simulation_time_is_wall_time() -> None:
    scene, robot = rsegen.compose(RECIPE), robot_of("burger")
    standing = PlacedRobot(name="burger_0", robot=robot, start=adjacent_pose(scene.field, robot.body_or_box))
    world = MujocoWorld(scene, [standing])
    begun, before = time.monotonic(), world.poses()["burger_0"]
    window.simulate(world, 1.0, None)
    assert world._seconds <= time.monotonic() - begun + 0.02
    assert world._seconds > 0.3  # of a second of a busy machine
    after = world.poses()["burger_0"]
    assert before.distance(after) < 0.02  # it comes down by the 5 mm of its start, and stands
    assert before.z > after.z


def test_a_window_that_is_closed_ends_it() -> None:
    class Closed:
        looks = 3

        def is_running(self) -> bool:
            self.looks -= 1
            return self.looks > 0

        def sync(self) -> None:
            pass

        def lock(self) -> memoryview:
            return memoryview(b"")  # any context

    world = MujocoWorld(rsegen.compose(RECIPE), [])
    window.simulate(world, None, Closed())
    assert world._seconds == pytest.approx(0.02)


def test_a_model_with_looks_moves_as_one_without() -> None:
    """And it has the colours of the scene and of the robot."""
    scene, robot = rsegen.compose(RECIPE), robot_of("crawler")
    standing = PlacedRobot(name="crawler_0", robot=robot, start=adjacent_pose(scene.field, robot.body_or_box))
    plain, seen = (MujocoWorld(scene, [standing], seen=looks) for looks in (False, True))
    for world in (plain, seen):
        world.drive("crawler_0", robot, 0.3, 0.0)
        world.step(500)
    assert plain.poses()["crawler_0"].distance(seen.poses()["crawler_0"]) < 1e-6
    shown = seen.model.geom_rgba[seen.model.geom_group == 2][:, :3]
    for material in np.unique(scene.field.levels[scene.field.levels > 0]).tolist():
        assert np.abs(shown - scene.surface_colour(material)).max(axis=1).min() < 1e-3
    assert (seen.model.geom_contype[seen.model.geom_group == 2] == 0).all()
    assert not (plain.model.geom_group == 2).any()
    assert "rgba" not in map_model(scene, [standing]).text


@pytest.mark.parametrize(
    ("flags", "message"),
    [
        ((), "no screen here (neither DISPLAY nor WAYLAND_DISPLAY is set), so there can be no window"),
        (("--headless", "--shared"), "--shared: is for Gazebo; MuJoCo has no server"),
        (("--print",), "--print: is for Gazebo; MuJoCo is no command"),
        (("--robot", "crawlr"), "--robot: unknown robot 'crawlr'; did you mean 'crawler'"),
        (("--robot", "turtlebot3"), "--robot: unknown robot 'turtlebot3'; did you mean 'burger'"),
    ],
)
def test_what_cannot_be_is_said_in_a_line(
    flags: tuple[str, ...], message: str, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    assert opened(*flags) == 2
    assert the_line(capsys.readouterr().err).startswith(f"rsegen: {message}")


def test_a_robot_is_not_opened_in_gazebo(capsys: Capture) -> None:
    assert main(["open", "peak", "--robot", "crawler"]) == 2
    assert "--robot: is for MuJoCo; in Gazebo, spawn it" in the_line(capsys.readouterr().err)


@pytest.mark.skipif(sys.platform != "linux", reason="other systems always have a screen")
def test_a_window_without_its_library_or_a_screen_that_answers_is_said_in_a_line(
    screen: None, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    assert opened("--seconds", "1") == 2
    assert "MuJoCo cannot open a window on this screen" in the_line(capsys.readouterr().err)
    monkeypatch.setitem(sys.modules, "glfw", None)
    assert opened("--seconds", "1") == 2
    line = the_line(capsys.readouterr().err)
    assert line == "rsegen: MuJoCo's window needs glfw, which is not installed: " + window._RENDERING


@pytest.mark.long(reason="a window without a graphics card")
def test_mujoco_s_window_shows_the_map_in_its_colours(tmp_path: Path) -> None:
    words = [sys.executable, "-m", "rsegen", "open", "mixed-course", "--simulator", "mujoco", "--robot", "crawler"]
    with xvfb(tmp_path) as number:
        variables = {**os.environ, "DISPLAY": number, "LIBGL_ALWAYS_SOFTWARE": "1"}
        with subprocess.Popen([*words, "--seconds", "12"], env=variables) as program:
            best = 0.0
            while program.poll() is None:
                time.sleep(1)
                best = max(best, colours(tmp_path / "Xvfb_screen0"))
        assert program.returncode == 0
    assert best > 0.003


def colours(file: Path) -> float:
    """The share of the screen that is red, as frames are, or yellow, as the highest blocks; the lower of both."""
    content = file.read_bytes()
    head = np.frombuffer(content[:100], ">u4")
    begin, wide, high, line = int(head[0]) + 12 * int(head[19]), int(head[4]), int(head[5]), int(head[12])
    pixels = np.frombuffer(content, np.uint8, line * high, begin).reshape(high, -1, 4)[:, :wide, 2::-1].astype(int)
    red, green, blue = np.moveaxis(pixels, 2, 0)
    is_red, is_yellow = (red > 120) & (green < 60) & (blue < 60), (red > 150) & (green > 130) & (blue < 110)
    return float(min(is_red.mean(), is_yellow.mean()))
