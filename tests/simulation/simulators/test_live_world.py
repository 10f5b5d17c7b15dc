"""What every live world keeps to: Gazebo Classic in a real server, Gazebo Sim with a program that plays its own."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from dataclasses import astuple
from pathlib import Path

import pytest

import rsegen
from rsegen.cli import main
from rsegen.errors import SimulatorFailed
from rsegen.exporters.gazebo import sdf
from rsegen.simulation.robots import robot
from rsegen.simulation.simulators import SIMULATORS
from rsegen.simulation.simulators.live_world import LiveWorld, Pose
from rsegen.simulation.simulators.server import running_server
from tests.simulation.real.conftest import missing
from tests.simulation.simulators.standins import PROGRAMS, play, put
from tests.support.complaints import the_line

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the stand-ins are programs by their first line")
BURGER = robot("burger")
THERE, ELSEWHERE = Pose(x=1, y=-2, z=0.5, yaw=1.0), Pose(x=-1.5, y=0.25, z=1.0, yaw=-0.5)


@pytest.fixture(params=["sim", "classic"])
def live(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[LiveWorld]:
    """A world with the ground alone, which stands still."""
    if request.param == "sim":
        programs = request.getfixturevalue("programs")
        play(programs)
        with SIMULATORS["sim"].connect({"GZ_PARTITION": "lab"}) as world:
            yield world
        return
    here = SIMULATORS["classic"].installation() or missing("no Gazebo Classic 11: run scripts/gazebo-classic")
    file = tmp_path / "ground.world"
    file.write_bytes(b"".join(sdf.utf8(sdf.world(rsegen.compose(rsegen.Recipe(seed=1)), ()))))
    with running_server(here, file) as server, server.connect() as world:
        yield world


def model(name: str) -> str:
    return BURGER.file(name)


def test_a_model_is_put_moved_and_taken(live: LiveWorld) -> None:
    live.spawn(model("one"), THERE)
    live.spawn(model("other"), Pose(x=0, y=0, z=0))
    assert set(live.poses()) == {"ground_plane", "one", "other"}
    assert live.movable() == {"one", "other"}
    assert astuple(live.poses()["one"]) == pytest.approx(astuple(THERE))
    live.move("one", ELSEWHERE)
    assert astuple(live.poses()["one"]) == pytest.approx(astuple(ELSEWHERE))
    assert astuple(live.poses()["other"]) == pytest.approx((0,) * 6)
    live.delete("one")
    assert set(live.poses()) == {"ground_plane", "other"}
    with pytest.raises(SimulatorFailed, match="no model one to move"):
        live.move("one", THERE)


def test_time_goes_by_steps_or_by_itself(live: LiveWorld) -> None:
    assert (live.clock().steps, live.clock().paused) == (0, True)
    live.step(1250)
    assert (live.clock().steps, live.clock().simulated, live.clock().paused) == (1250, 1.25, True)
    live.unpause()
    assert not live.clock().paused
    live.pause()
    assert live.clock().paused


def test_a_model_of_the_worlds_own_name_is_taken_and_put_again(live: LiveWorld) -> None:
    world = "rse_0000" if live.backend == "classic" else "lab"
    live.spawn(model("other"), ELSEWHERE)
    live.spawn(model(world), THERE)
    live.delete(world)
    assert set(live.poses()) == {"ground_plane", "other"}
    live.spawn(model(world), Pose(x=2, y=0, z=0))
    assert live.poses()[world].x == pytest.approx(2)
    assert set(live.poses()) == {"ground_plane", "other", world}


# Gazebo Sim.


def test_sim_tells_robots_by_their_topic(programs: Path) -> None:
    play(programs)
    with SIMULATORS["sim"].connect({}) as live:
        assert live.backend == "sim"
        live.send_command(BURGER.command("burger", 0.1, -0.5, live.backend))
    ((topic, type_name, message),) = json.loads((programs / "gz.json").read_text())["told"]
    assert (topic, type_name) == (BURGER.command("burger", 0, 0, "sim").topic, "gz.msgs.Twist")
    assert (message["linear"]["x"], message["angular"]["z"]) == (0.1, -0.5)


def test_a_robot_and_a_map_are_spawned_respawned_and_removed_in_sim(
    programs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    play(programs)
    monkeypatch.chdir(tmp_path)
    Path("course.yaml").write_text("name: course\nseed: 1\nchunk_size: 4\n")
    for words in (["spawn", "course.yaml"], ["spawn", "burger", "--at", "0,0"], ["respawn", "course.yaml"]):
        assert main([*words, "--simulator", "sim"]) == 0
    out = capsys.readouterr().out
    assert "course_0000 is in Gazebo Sim at 0 0 0" in out
    assert "course_0001 replaces course_0000, at 0 0 0; put on top of it: burger" in out
    assert set(json.loads((programs / "gz.json").read_text())["models"]) == {"ground_plane", "burger", "course_0001"}
    assert main(["remove", "burger", "course_0001"]) == 0
    assert set(json.loads((programs / "gz.json").read_text())["models"]) == {"ground_plane"}


def test_where_no_world_is_it_says_so(programs: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    put(programs, PROGRAMS["sim"])
    with (
        pytest.raises(SimulatorFailed, match="no world is running in GZ_PARTITION=lab"),
        SIMULATORS["sim"].connect({"GZ_PARTITION": "lab"}),
    ):
        pass


@pytest.mark.parametrize("words", [["spawn", "burger"], ["remove", "burger"]])
def test_where_nothing_runs_it_is_said_in_one_line(
    words: list[str], programs: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("GAZEBO_MASTER_URI", "http://127.0.0.1:1")
    assert main(words) == 2
    line = the_line(capsys.readouterr().err)
    assert "no simulation runs (Gazebo Sim: none is installed here; Gazebo Classic: nobody answers at 127." in line


def test_an_address_that_is_none_is_said(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setenv("GAZEBO_MASTER_URI", "localhost")
    assert main(["remove", "burger", "--simulator", "classic"]) == 2
    assert "GAZEBO_MASTER_URI: 'localhost' is not a host and a port" in the_line(capsys.readouterr().err)
