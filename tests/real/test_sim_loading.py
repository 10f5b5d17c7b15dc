"""A real Gazebo Sim server loads worlds with robots, and says which worlds it cannot load."""

from __future__ import annotations

import threading
from contextlib import suppress
from pathlib import Path

import psutil
import pytest

import rsegen
from rsegen.driving.world_file import ALWAYS, world_with_robots
from rsegen.errors import SimulatorFailed
from rsegen.recipe.examples import EXAMPLES
from rsegen.robots.lookup import robot_of_kind
from rsegen.simulators.base import Installation
from rsegen.simulators.server import Server, running_server
from tests.real.maps import generated
from tests.support.leftovers import MARK, left
from tests.support.patience import until

MODEL = '<model name="a"><link name="l"/></model>'
UNREADABLE = {
    "empty": "",
    "no XML": "a world",
    "cut": '<sdf version="1.6"><world name="a">',
    "no such model": '<sdf version="1.6"><world name="a"><include><uri>model://none</uri></include></world></sdf>',
    "a model twice": f'<sdf version="1.6"><world name="a">{MODEL}{MODEL}</world></sdf>',
}


@pytest.fixture
def mark(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """A variable by which all is known that the test has started."""
    monkeypatch.setenv(MARK, str(tmp_path))
    return str(tmp_path)


@pytest.fixture
def world(tmp_path: Path) -> Path:
    random = rsegen.Random(levels=3)
    return generated(rsegen.Recipe(name="course", chunk_size=3, seed=1, obstacles=(random,)), tmp_path).world


def own_log(server: Server) -> str:
    (log,) = server.home.rglob("server_console.log")
    return log.read_text()


def test_a_world_with_robots_is_loaded_every_time_with_all_systems(
    gazebo_sim: Installation, world: Path, mark: str
) -> None:
    models = [
        robot_of_kind("burger").model(f"one_{i}", gazebo_sim.backend, (-1, 0.3 * i, 0, 0, 0, 0)) for i in range(3)
    ]
    file = world.with_name("robots.world")
    file.write_text(world_with_robots(world, models, backend=gazebo_sim.backend))
    for _ in range(20):
        with running_server(gazebo_sim, file) as server:
            assert server.errors == []
            assert all(f"::systems::{kind}]" in own_log(server) for kind in (*ALWAYS, "DiffDrive"))
    assert left(mark) == []


@pytest.mark.parametrize("name", UNREADABLE)
def test_a_world_that_cannot_be_read_is_an_error_at_once(
    name: str, gazebo_sim: Installation, tmp_path: Path, mark: str
) -> None:
    world = tmp_path / "broken.world"
    world.write_text(UNREADABLE[name])
    lines: list[str] = []
    with pytest.raises(SimulatorFailed, match=rf"^{gazebo_sim} did not load the world .*broken\.world$"):
        rsegen.open(world, simulator="sim", headless=True, seconds=600, on_error=lines.append)
    assert any("Error Code" in line for line in lines)
    assert all(line.startswith(("[Err]", "Error [", "(")) for line in lines)
    with pytest.raises(SimulatorFailed, match="the world was not loaded"), running_server(gazebo_sim, world):
        pass
    assert left(mark) == []


def test_a_mesh_that_is_missing_is_an_error(gazebo_sim: Installation, world: Path) -> None:
    """Fortress runs the world without it, and Harmonic ends."""
    for mesh in world.parent.glob("meshes/*.obj"):
        mesh.unlink()
    lines: list[str] = []
    with pytest.raises(SimulatorFailed, match=r"printed an error: |did not load the world"):
        rsegen.open(world, simulator="sim", headless=True, seconds=8, on_error=lines.append)
    assert any("meshes/course_0000.obj" in line for line in lines)


def test_an_example_is_opened_and_nothing_is_left_of_it(gazebo_sim: Installation, mark: str) -> None:
    result = rsegen.open(EXAMPLES["mixed-course"], simulator="sim", headless=True, seconds=5)
    assert (result.exit_code, result.errors) == (None, ())
    assert left(mark) == []


def test_two_servers_side_by_side_load_each_its_world(gazebo_sim: Installation, world: Path, mark: str) -> None:
    with running_server(gazebo_sim, world) as one, running_server(gazebo_sim, world) as other:
        assert len({one.environment["GZ_PARTITION"], other.environment["GZ_PARTITION"]}) == 2
        one.stop()
        assert other.running.exit_code is None
        assert one.errors == other.errors == []
    assert left(mark) == []


def test_a_server_that_is_killed_ends_the_command(gazebo_sim: Installation, world: Path, mark: str) -> None:
    def kill() -> None:
        until(lambda: servers(mark))
        for each in servers(mark):
            each.kill()

    killing = threading.Thread(target=kill)
    with pytest.raises(SimulatorFailed, match=r"ended by itself, with exit code -9$"):
        rsegen.open(world, simulator="sim", headless=True, seconds=600, on_start=lambda _: killing.start())
    killing.join()
    assert left(mark) == []


def servers(mark: str) -> list[psutil.Process]:
    """The servers that a test has started, without the shells that are about to become one."""
    found = []
    for each in left(mark):
        with suppress(psutil.Error):
            if each.name() != "sh" and "".join(each.cmdline()[-1:]).endswith(".world"):
                found.append(each)
    return found
