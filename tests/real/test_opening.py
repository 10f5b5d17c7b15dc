"""`rsegen open` in each real Gazebo: the world is there, each server is alone, and nothing is left of it.

What only Gazebo Sim does is in test_sim_loading.
"""

from __future__ import annotations

import signal
import subprocess
import time
from contextlib import suppress
from pathlib import Path

import psutil
import pytest

import rsegen
from rsegen.recipe.examples import EXAMPLES
from rsegen.robots.lookup import robot_of_kind
from rsegen.simulators.base import Installation
from rsegen.simulators.gazebo_classic import STATE
from rsegen.simulators.live_world import LiveWorld
from rsegen.simulators.poses import Pose
from rsegen.simulators.server import attempted, running_server
from tests.real.maps import generated
from tests.support.leftovers import MARK, left, left_in_the_end
from tests.support.runs import ended, started

COURSE = EXAMPLES["mixed-course"]
A_SERVER_MORE = pytest.mark.long(reason="a server more")


SERVERS = ("gzserver", "gzserver-11.1.0", "ruby", "gz", "gz-sim-main", "ign")
"""Gazebo Sim's server runs in the command itself, which is a program in Ruby."""


@pytest.fixture
def mark(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """A variable by which all is known that the test has started."""
    monkeypatch.setenv(MARK, str(tmp_path))
    return str(tmp_path)


def made(tmp_path: Path, name: str) -> Path:
    random = rsegen.Random(levels=3)
    return generated(rsegen.Recipe(name=name, chunk_size=3, seed=1, obstacles=(random,)), tmp_path).world


def opening(simulator: str, *arguments: str | Path, **environment: str) -> subprocess.Popen[str]:
    """The command as a process of its own, of the rsegen that is tested."""
    source = str(Path(rsegen.__file__).parents[1])
    return started("open", *arguments, "--simulator", simulator, "--headless", PYTHONPATH=source, **environment)


def server_of(process: subprocess.Popen[str], mark: str) -> psutil.Process:
    """The server that a command has started, when it is there."""
    end = time.monotonic() + 180
    while process.poll() is None and time.monotonic() < end:
        for found in left(mark):
            with suppress(psutil.Error):
                if found.name() in SERVERS and "".join(found.cmdline()[-1:]).endswith(".world"):
                    return found
        time.sleep(0.05)
    raise AssertionError(ended(process))


def test_a_recipe_is_opened_and_gone_after_its_seconds(gazebo: Installation, tmp_path: Path, mark: str) -> None:
    home = tmp_path / "temporary"
    home.mkdir()
    process = opening(gazebo.simulator.name, COURSE, "--seconds", "5", TMPDIR=str(home))
    server = server_of(process, mark)
    assert Path(server.cmdline()[-1]).name == "mixed-course_0000.world"
    assert list(home.rglob("mixed-course_0000.world"))

    assert ended(process) == (0, "")
    assert left(mark) == []
    assert list(home.iterdir()) == []


def test_a_world_that_is_no_world_is_an_error_at_once(gazebo_classic: Installation, tmp_path: Path, mark: str) -> None:
    world = tmp_path / "broken.world"
    world.write_text('<sdf version="1.6"><world name="broken">')

    code, said = ended(opening("classic", world, "--seconds", "40"))

    assert code == 1
    *told, line = said.splitlines()
    assert any("Unable to read sdf file" in each for each in told), said
    assert line == f"rsegen: {gazebo_classic} did not load the world broken.world"
    assert left(mark) == []


@pytest.mark.long(reason="a server more")
def test_a_missing_mesh_is_reported_and_fails(gazebo_classic: Installation, tmp_path: Path, mark: str) -> None:
    world = made(tmp_path, "course")
    for mesh in world.parent.glob("meshes/*.obj"):
        mesh.unlink()

    code, said = ended(opening("classic", world, "--seconds", "4"))

    assert code == 1
    *told, line = said.splitlines()
    assert told
    assert line == f"rsegen: {gazebo_classic} printed an error: {told[0]}"


@pytest.mark.parametrize(
    ("word", "code"),
    [
        ("SIGINT", 0),
        pytest.param("SIGTERM", 0, marks=A_SERVER_MORE),
        pytest.param("SIGKILL", -9, marks=A_SERVER_MORE),
    ],
)
def test_nothing_is_left_of_a_command_that_is_stopped(
    word: str, code: int, gazebo: Installation, tmp_path: Path, mark: str
) -> None:
    process = opening(gazebo.simulator.name, made(tmp_path, "course"), TMPDIR=str(tmp_path))
    server_of(process, mark)
    time.sleep(1)
    process.send_signal(signal.Signals[word])

    assert ended(process) == (code, "")
    assert left_in_the_end(mark) == []


def test_two_servers_side_by_side_do_not_disturb_each_other(gazebo: Installation, tmp_path: Path, mark: str) -> None:
    worlds = [made(tmp_path, name) for name in ("one", "other")]

    def both() -> None:
        with (
            running_server(gazebo, worlds[0]) as one,
            running_server(gazebo, worlds[1]) as other,
            one.connect() as in_one,
            other.connect() as in_other,
        ):
            assert len({one.pid, other.pid}) == len({one.home, other.home}) == 2
            in_one.step(30)
            assert [each.clock().steps for each in (in_one, in_other)] == [30, 0]
            assert [names(each) for each in (in_one, in_other)] == [
                {"ground_plane", "one_0000"},
                {"ground_plane", "other_0000"},
            ]
            one.stop()
            assert names(in_other) == {"ground_plane", "other_0000"}
            assert one.errors == other.errors == []

    attempted(both)
    assert left(mark) == []


def test_a_server_runs_after_unpause(gazebo: Installation, tmp_path: Path, mark: str) -> None:
    def resumed() -> int:
        with (
            running_server(gazebo, made(tmp_path / str(time.monotonic_ns()), "course")) as server,
            server.connect() as live,
        ):
            live.unpause()
            time.sleep(0.5)
            return live.clock().steps

    assert attempted(resumed)[0] > 0


def names(live: LiveWorld) -> set[str]:
    return set(live.poses())


@pytest.mark.long(reason="a server more")
def test_a_record_is_kept_by_classic_until_it_is_stopped(gazebo_classic: Installation, tmp_path: Path) -> None:
    with running_server(gazebo_classic, made(tmp_path, "course")) as server, server.connect() as live:

        def kept() -> int:
            live.step(1000)
            return (server.home / STATE).stat().st_size

        live.spawn(robot_of_kind("burger").file("burger"), Pose(x=0, y=0, z=200))
        before = kept()
        assert kept() > before
        live.stop_recording()
        before = kept()  # with what was on its way
        assert kept() == before
        assert live.poses()["burger"].z > 1  # it still falls
