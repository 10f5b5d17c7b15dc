"""Maps and robots put into a Gazebo that runs, while a robot drives in it."""

from __future__ import annotations

import json
import os
import re
import subprocess
import threading
import time
from collections.abc import Iterator
from dataclasses import astuple, replace
from math import dist
from pathlib import Path

import numpy as np
import psutil
import pytest

import rsegen
from rsegen.cli.edge import main
from rsegen.gazebo import sdf
from rsegen.robots.lookup import robot_of_kind
from rsegen.simulators.base import Installation
from rsegen.simulators.live_world import LiveWorld
from rsegen.simulators.poses import Pose
from rsegen.simulators.server import Server, running_server
from rsegen.spawning.placement import SpawnedMap
from tests.real.bodies import SIZE, body
from tests.support.complaints import the_line
from tests.support.patience import PATIENCE
from tests.support.runs import started, until_it_has

Capture = pytest.CaptureFixture[str]
BURGER = robot_of_kind("burger")
COURSE = rsegen.Recipe(
    name="course",
    chunk_size=8,
    unit_cm=1,
    seed=5,
    obstacles=(rsegen.Random(levels=3),),
)

SINKING = 1e-4
"""Metres that ODE lets a hull sink into the block that it rests on."""

_REMOVED = "this entity does not exist. This create component request will be ignored."
"""Line that Fortress prints at every step of a model with plug-ins that was removed."""

EASY = replace(COURSE, obstacles=(rsegen.Random(levels=2),))
"""Its steps are of 1 cm, which the Burger climbs."""

TILTED = replace(COURSE, name="tilted", unit_cm=3, boundary="none", chunk_size=16)
"""Its steps of 3 cm tilt a robot that is as long as two blocks."""


@pytest.fixture
def server(gazebo: Installation, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Server]:
    """One with the ground alone, that the command finds by itself; the current folder is for maps."""
    world = tmp_path / "ground.world"
    world.write_bytes(b"".join(sdf.utf8(sdf.world(rsegen.compose(COURSE), ()))))
    rsegen.save(COURSE, tmp_path / "course.yaml")
    monkeypatch.chdir(tmp_path)
    with running_server(gazebo, world) as running:
        for name in ("GAZEBO_MASTER_URI", "GZ_PARTITION", "GZ_IP"):
            monkeypatch.setenv(name, running.environment.get(name, "http://127.0.0.1:1"))
        monkeypatch.setenv("SIMULATOR", gazebo.simulator.name)
        yield running


def test_the_next_shell_finds_what_open_began(
    gazebo: Installation, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The tutorial's last step: with no flag and no variable, and the heights of the map are known."""
    page = (Path(__file__).parents[2] / "docs" / "tutorial.md").read_text("utf-8")
    recipe = re.findall(r"^```yaml\n(# course.yaml\n.*?)^```", page, re.MULTILINE | re.DOTALL)[0]
    lines = re.findall(r"^    rsegen (\S.*?)(?:  +#.*)?$", page.partition("## 7. In Gazebo")[2], re.MULTILINE)
    assert [line.split()[0] for line in lines] == ["open", "spawn", "respawn", "remove", "drive"]
    monkeypatch.chdir(tmp_path)
    (tmp_path / "course.yaml").write_text(recipe)
    assert main(["generate", "course.yaml", "-o", "worlds"]) == 0
    for name in gazebo.simulator.address_variables:
        monkeypatch.delenv(name, raising=False)
    opening, spawning, replacing, removing, _ = (line.split() for line in lines)
    with started(*opening, "--headless", "--simulator", gazebo.simulator.name) as opened:
        try:
            until_it_has(opened, lambda: run(*spawning).returncode == 0)
            replaced = json.loads(run(*replacing, "--json").stdout)
            assert (replaced["instead_of"], replaced["name"]) == ("course_0000", "course_0001")
            assert replaced["put_on_top"] == ["burger"]
            assert run(*removing).returncode == 0
            assert "'burger'" in run(*removing).stderr
        finally:
            opened.terminate()
    assert run(*spawning).stderr.startswith("rsegen: no simulation runs")


def run(*arguments: str) -> subprocess.CompletedProcess[str]:
    """A command in a shell of its own."""
    with started(*arguments) as process:
        out, err = process.communicate(timeout=PATIENCE)
    return subprocess.CompletedProcess(arguments, process.returncode, out, err)


def done(capture: Capture, *arguments: str) -> dict[str, object]:
    """Report of a command."""
    capture.readouterr()
    assert main([*arguments, "--simulator", os.environ["SIMULATOR"], "--json"]) == 0, capture.readouterr().err
    told: dict[str, object] = json.loads(capture.readouterr().out)
    return told


def refused(capture: Capture, *arguments: str) -> str:
    capture.readouterr()
    assert main([*arguments, "--simulator", os.environ["SIMULATOR"]]) == 2
    return the_line(capture.readouterr().err)


def ground_under(live: LiveWorld, name: str, course: rsegen.Recipe = COURSE) -> float:
    """Height of a robot above the blocks under its middle."""
    poses = live.poses()
    (there,) = (each for each in poses if each.startswith("course_"))
    field = rsegen.compose(course, int(there[-4:])).field
    return poses[name].z - SpawnedMap(name=there, field=field, at=poses[there]).top(poses[name])


def comes_away(live: LiveWorld, start: Pose) -> bool:
    """Return whether the robot moves by 2 cm within 10 s of simulation time, however slow the machine is."""
    end = live.clock().simulated + 10
    while live.clock().simulated < end:
        at = live.poses()["burger"]
        if dist((start.x, start.y), (at.x, at.y)) > 0.02:
            return True
        time.sleep(0.1)
    return False


@pytest.mark.parametrize(
    "made_for", ["both", pytest.param("classic", marks=pytest.mark.long(reason="20 s of driving"))]
)
def test_a_robot_drives_on_while_its_map_is_replaced(server: Server, made_for: str, capsys: Capture) -> None:
    """It drives in a circle of 25 cm, clear of the frames."""
    rsegen.save(replace(EASY, simulator=made_for), "course.yaml", force=True)
    with server.connect() as live:
        live.unpause()
        assert done(capsys, "spawn", "course.yaml")["at"] == dict.fromkeys(("x", "y", "z", "roll", "pitch", "yaw"), 0.0)
        done(capsys, "spawn", "burger", "--at", "0,0")
        live.send_command(BURGER.command("burger", 0.1, 0.8, live.backend))
        for index in (1, 2):
            before, told = live.poses()["burger"], done(capsys, "respawn", "course.yaml")
            assert (told["name"], told["put_on_top"]) == (f"course_000{index}", ["burger"])
            assert set(live.poses()) == {"ground_plane", "burger", f"course_000{index}"}
            assert ground_under(live, "burger", EASY) > -BURGER.clearance - SINKING
            assert comes_away(live, before)
            assert ground_under(live, "burger", EASY) > -BURGER.clearance - SINKING
        assert not live.clock().paused
        done(capsys, "remove", "burger", "course_0002")
        assert set(live.poses()) == {"ground_plane"}
    assert [line for line in server.errors if _REMOVED not in line] == []


def test_a_robot_is_put_on_a_map_that_lies_elsewhere(server: Server, capsys: Capture) -> None:
    """The running model names its mesh, whose folder has its recipe."""
    done(capsys, "spawn", "course.yaml", "-o", "elsewhere")
    told = done(capsys, "spawn", "burger", "--at", "0,0")
    assert told["notes"] == []
    with server.connect() as live:
        live.step(500)
        assert ground_under(live, "burger") > -BURGER.clearance - SINKING


def test_a_robot_is_put_on_a_map_at_rest(server: Server, capsys: Capture) -> None:
    """The map, which is turned, is spawned first; the robot stays where poses settle it, also tilted."""
    rest = rsegen.poses(rsegen.build(TILTED), "crawler", -0.2, 0.1, 0.4)
    assert rest.stands[0]
    assert rest.tilt[0] > 0.05
    rsegen.save(TILTED, "tilted.yaml")
    arguments = ("tilted.yaml", "--robot", "crawler", "--pose=-0.2,0.1,0.4")
    told = done(capsys, "spawn", *arguments, "--at", "2,1,0,0.5")
    assert (told["name"], told["on"]) == ("crawler", "tilted_0000")
    assert told["notes"] == ["tilted_0000 was not in the simulation, and was spawned too"]
    x, y = float(rest.x[0]), float(rest.y[0])
    where = SpawnedMap(name="", field=rsegen.build(TILTED), at=Pose(x=2, y=1, z=0, yaw=0.5)).outside(x, y)
    with server.connect() as live:
        live.step(700)
        stands = live.poses()["crawler"]
    assert dist((stands.x, stands.y), where) < 0.01
    assert (stands.z, stands.roll, stands.pitch, stands.yaw - 0.5) == pytest.approx(
        [float(each[0]) for each in (rest.z, rest.roll, rest.pitch, rest.yaw)], abs=0.03
    )
    assert "tips over" in refused(capsys, "spawn", "tilted.yaml", "--robot", "burger", "--pose=0.3,-0.2,0.4")
    second = done(capsys, "spawn", "tilted.yaml", "--robot", "burger", "--name", "second")
    assert (second["on"], second["notes"]) == ("tilted_0000", [])
    assert "is in the simulation already" in refused(capsys, "spawn", *arguments, "--name", "third", "--at", "5,5")
    rsegen.save(replace(TILTED, seed=6), "tilted.yaml", force=True)
    assert "has other blocks" in refused(capsys, "spawn", *arguments, "--name", "third", "-o", "elsewhere")
    with server.connect() as live:
        assert set(live.poses()) == {"ground_plane", "tilted_0000", "crawler", "second"}


@pytest.mark.long(reason="a server more")
def test_a_paused_world_stays_paused(server: Server, capsys: Capture) -> None:
    with server.connect() as live:
        done(capsys, "spawn", "burger")
        assert done(capsys, "spawn", "course.yaml", "--at", "0,0,0,0.5")["put_on_top"] == ["burger"]
        done(capsys, "respawn", "course.yaml")
        assert live.clock().steps == 0
        assert live.clock().paused
        assert astuple(live.poses()["course_0001"]) == pytest.approx((0, 0, 0, 0, 0, 0.5))
        assert ground_under(live, "burger") >= 0


@pytest.mark.long(reason="a server more")
def test_a_map_of_several_frictions_is_put_in_whole(server: Server, capsys: Capture) -> None:
    icy = replace(COURSE, name="icy", frame_friction=0.5, level_friction=(0.9, 0.1))
    rsegen.save(icy, "icy.yaml")
    done(capsys, "spawn", "icy.yaml")
    field = rsegen.compose(icy).field
    x, y = ((line[:-1] + line[1:]) / 2 for line in field.edges())
    cells = [np.argwhere(where)[0] for where in (field.frame, field.levels == 1, field.levels == 2)]
    cubes = {f"cube-{i}-{j}": (float(x[i]), float(y[j]), float(field.heights[i, j])) for i, j in cells}
    with server.connect() as live:
        for name, place in cubes.items():
            live.spawn(
                f'<sdf version="1.6">{body(name, "cube", (0, 0, 0))}</sdf>',
                Pose(x=place[0], y=place[1], z=place[2] + 0.03),
            )
        live.step(800)
        poses = live.poses()
    assert {name: poses[name].z for name in cubes} == pytest.approx(
        {name: top + SIZE / 2 for name, (_, _, top) in cubes.items()}, abs=0.001
    )
    assert server.errors == []


@pytest.mark.long(reason="a server more")
def test_two_maps_do_not_overlap(server: Server, capsys: Capture) -> None:
    rsegen.generate(replace(COURSE, maps=3), "maps")
    for index in range(3):
        done(capsys, "spawn", "maps", "--map", str(index))
    with server.connect() as live:
        poses = live.poses()
    rectangles = [
        SpawnedMap(name=name, field=rsegen.compose(COURSE, int(name[-4:])).field, at=at).area
        for name, at in poses.items()
        if name.startswith("course_")
    ]
    assert len(rectangles) == 3
    assert all(one.is_clear_of(other) for one in rectangles for other in rectangles if one is not other)


@pytest.mark.long(reason="a server more; tests/simulation/spawning has these lines too")
def test_impossible_values_are_refused_in_one_line(server: Server, capsys: Capture) -> None:
    rsegen.save(replace(COURSE, name="many", mesh_type="multi"), "many.yaml")
    done(capsys, "spawn", "burger")
    assert "'burger' exists already; use another name" in refused(capsys, "spawn", "burger")
    line = refused(capsys, "remove", "burgr")
    assert "unknown model 'burgr'; did you mean 'burger'? (known: burger, ground_plane)" in line
    assert "no map such as course_0000 in the simulation" in refused(capsys, "respawn", "course.yaml")
    assert "multi makes a map of many models" in refused(capsys, "spawn", "many.yaml")
    done(capsys, "spawn", "course.yaml")
    assert "'course_0000' exists already" in refused(capsys, "respawn", "course.yaml", "--map", "0")


@pytest.mark.long(reason="a server more, and robots one after the other")
def test_a_program_that_spawns_and_removes_keeps_no_thread_and_no_socket(server: Server) -> None:
    """Each call once left 2.5 threads with their sockets; the kept connection has some for each topic that it uses."""
    me, simulator, used = psutil.Process(), server.here.simulator.name, []
    for number in range(8):
        rsegen.spawn("burger", simulator=simulator)
        rsegen.remove("burger", simulator=simulator)
        used.append((threading.active_count(), me.num_fds()))
        if number == 3:
            rsegen.spawn(COURSE, simulator=simulator)
            rsegen.remove("course_0000", simulator=simulator)
    # A map on which robots stand takes more topics, so what is counted begins after it.
    assert all(last <= first for last, first in zip(used[-1], used[4], strict=True))
    with server.connect() as live:
        assert set(live.poses()) == {"ground_plane"}
