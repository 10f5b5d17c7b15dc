"""The world of a ROS 2 package in real Gazebos, with the models where the package's environment hook says they are."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from pathlib import Path
from xml.etree.ElementTree import fromstring

import numpy as np
import pytest

import rsegen
from rsegen import compose
from rsegen.robots.base import ROBOTS
from rsegen.ros2.ros2 import Ros2
from rsegen.simulators.base import Installation
from rsegen.simulators.process import command_output
from tests.real.bodies import SIZE, body
from tests.real.maps import variants
from tests.real.test_sdformat import said
from tests.simulators.simulated import simulated


def package(tmp_path: Path) -> tuple[rsegen.Scene, Path]:
    scene = compose(next(recipe for recipe in variants() if recipe.mesh_type == "single"))
    for path, content in Ros2().files(scene).items():
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).write_bytes(b"".join(content))
    (found,) = tmp_path.iterdir()
    return scene, found


def test_gazebo_classic_opens_the_world_and_bodies_rest_on_it(gazebo: Installation, tmp_path: Path) -> None:
    scene, folder = package(tmp_path)
    field, world = scene.field, folder / "worlds" / f"{scene.name}.world"
    i, j = np.unravel_index(int(field.heights.argmax()), field.shape)
    x, y = ((line[k] + line[k + 1]) / 2 for line, k in zip(field.edges(), (i, j), strict=True))
    dropped = body("cube", "cube", (x, y, field.heights.max() + 0.01))
    world.write_text(world.read_text().replace("  </world>", f"{dropped}  </world>"))

    run = simulated(gazebo, world, steps=500, models=folder / "models")

    assert not run.errors
    assert run.poses["cube"].z == pytest.approx(field.heights.max() + SIZE / 2, abs=0.001)


def test_libsdformat_finds_the_model_that_the_world_includes(
    check_sdf: Callable[[Path], str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene, folder = package(tmp_path)
    monkeypatch.setenv("SDF_PATH", str(folder / "models"))

    assert said(check_sdf(folder / "worlds" / f"{scene.name}.world")) == ["Valid."]


@pytest.mark.parametrize("kind", list(ROBOTS))
def test_libsdformat_finds_the_model_of_a_robot_valid(
    kind: str, check_sdf: Callable[[Path], str], tmp_path: Path
) -> None:
    _, folder = package(tmp_path)

    assert said(check_sdf(folder / "robots" / kind / "model.sdf")) == ["Valid."]


@pytest.mark.parametrize("kind", list(ROBOTS))
def test_libsdformat_reads_the_urdf_of_a_robot_with_the_mass_and_the_hinges_of_its_sdf(
    kind: str, print_sdf: Callable[[Path], str], tmp_path: Path
) -> None:
    """It merges links at fixed joints, as for a robot that is spawned from its description."""
    _, folder = package(tmp_path)

    read = re.search(r"<sdf.*</sdf>", print_sdf(folder / "robots" / kind / f"{kind}.urdf"), re.DOTALL)
    assert read
    model = fromstring(read[0])

    masses = [float(mass.text or "nan") for mass in model.iter("mass")]
    assert sum(masses) == pytest.approx(ROBOTS[kind].mass)
    hinges = {joint.get("name") for joint in model.iter("joint") if joint.get("type") == "revolute"}
    assert hinges == {joint.name for joint in ROBOTS[kind].joints if joint.axis}


SERVERS = (("gz", "sim", "GZ_SIM", "server"), ("ign", "gazebo", "IGN_GAZEBO", "fortress_server"))
SYSTEMS = {
    *("physics", "usercommands", "scenebroadcaster", "sensors", "imu", "contact"),
    *("altimeter", "forcetorque", "magnetometer", "navsat"),
}
"""Names of their classes in small letters."""


def servers() -> Sequence[tuple[str, str, str, str]]:
    return [one for one in SERVERS if re.search(r"^\d+\.\d+\.\d+$", command_output([*one[:2], "--versions"]), re.M)]


def test_gazebo_sim_loads_the_systems_of_the_server_configuration(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each system is loaded, or named as missing where Gazebo was built without it, and the world is simulated."""
    found = servers() or pytest.skip("no server of Gazebo Sim: Debian has none; install Fortress or later")
    program, command, prefix, name = found[0]
    scene, folder = package(tmp_path)
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("IGN_PARTITION", tmp_path.name)
    monkeypatch.setenv("GZ_PARTITION", tmp_path.name)
    monkeypatch.setenv(f"{prefix}_RESOURCE_PATH", str(folder / "models"))
    for _, _, variable, config in SERVERS:
        monkeypatch.setenv(f"{variable}_SERVER_CONFIG_PATH", str(folder / "config" / f"{config}.config"))
    world = folder / "worlds" / f"{scene.name}.world"

    text = command_output([program, command, "-s", "-r", "-v", "4", "--iterations", "200", world])

    plain = re.sub(r"\x1b\[[0-9;]*m", "", text)
    assert f"{folder}/config/{name}.config" in plain
    loaded = {system.lower() for system in re.findall(r"Loaded system \[\w+::\w+::systems::(\w+)\]", plain)}
    absent = re.findall(r"Failed to load system plugin \[\w+-\w+-([\w-]+)-system\] : [Cc]ould(?:n't| not) find", plain)
    assert {"physics", "usercommands", "scenebroadcaster", "contact"} <= loaded
    assert loaded | {system.replace("-", "") for system in absent} == SYSTEMS
    harmless = re.compile("Failed to load system plugin|launching Remotery")  # the profiler, where two servers run
    assert [
        line for line in plain.splitlines() if re.search(r"\[(Err|error)\]", line) and not harmless.search(line)
    ] == []
