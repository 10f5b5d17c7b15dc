"""Worlds with robots in them stand alone, wherever they are written."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from rsegen import Random, Recipe, generate
from rsegen.driving.world_file import time_step, world_with_robots
from rsegen.errors import FileError
from rsegen.robots.lookup import robot_of_kind

MODEL = '<model name="one"><link name="l"/></model>'
NAMES = ("real_time_update_rate", "real_time_factor")


@pytest.fixture
def world(tmp_path: Path) -> Path:
    random = Random(levels=5)
    return generate(Recipe(seed=1, obstacles=(random,)), tmp_path).maps[0].world


def test_models_are_added_and_meshes_named_by_their_path(world: Path) -> None:
    root = ET.fromstring(world_with_robots(world, [MODEL]))
    assert [model.get("name") for model in root.iter("model")] == ["ground_plane", "rse_0000", "one"]
    uris = {uri.text for uri in root.iter("uri")}
    assert uris == {str(world.parent / "meshes" / "rse_0000.obj")}
    assert all(Path(uri or "").is_file() for uri in uris)


def test_only_an_unthrottled_world_runs_as_fast_as_can_be(world: Path) -> None:
    def rates(*, unthrottled: bool) -> list[str | None]:
        root = ET.fromstring(world_with_robots(world, unthrottled=unthrottled))
        return [root.findtext(f"world/physics/{name}") for name in NAMES]

    assert rates(unthrottled=False) == ["1000", "1"]
    assert rates(unthrottled=True) == ["100000", "0"]  # a paused Gazebo Classic without a limit would not rest
    assert time_step(world_with_robots(world)) == 0.001


@pytest.mark.parametrize(("backend", "prefix"), [("sim", "gz::sim"), ("fortress", "ignition::gazebo")])
def test_gazebo_sims_systems_are_named_as_a_plugin_of_a_robot_keeps_old_servers_from_loading_theirs(
    backend: str, prefix: str, world: Path
) -> None:
    def named(models: list[str]) -> list[str]:
        root = ET.fromstring(world_with_robots(world, models, backend=backend))
        return [plugin.get("name", "").removeprefix(f"{prefix}::systems::") for plugin in root.findall("world/plugin")]

    always = ["Physics", "UserCommands", "SceneBroadcaster"]
    assert named([]) == named([robot_of_kind("burger").model("one", backend)]) == always
    assert named([robot_of_kind("burger").model("one", backend, lidar=True)]) == [*always, "Sensors"]
    sensors = "".join(f'<sensor name="{kind}" type="{kind}"/>' for kind in ("imu", "contact", "camera", "sonar"))
    assert named([f'<model name="a"><link name="l">{sensors}</link></model>']) == [
        *always,
        "Contact",
        "Imu",
        "Sensors",
    ]


def test_systems_that_a_world_names_are_not_named_again(world: Path) -> None:
    once = world.with_name("once.world")
    once.write_text(world_with_robots(world, [MODEL], backend="fortress"))
    for backend, most in (("fortress", 3), ("sim", 3), ("classic", 3)):
        assert len(ET.fromstring(world_with_robots(once, backend=backend)).findall("world/plugin")) == most
    once.write_text(world_with_robots(world, [MODEL], backend="sim"))
    assert len(ET.fromstring(world_with_robots(once, backend="sim")).findall("world/plugin")) == 3


def test_a_world_for_classic_names_no_systems(world: Path) -> None:
    assert "<plugin" not in world_with_robots(world, [MODEL])


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("", "not XML"),
        ("<sdf><model name='a'/></sdf>", "no <world> in <sdf>"),
        ('<!DOCTYPE sdf [<!ENTITY a "b">]><sdf><world name="&a;"/></sdf>', "contains a DOCTYPE"),
    ],
)
def test_an_invalid_world_is_refused(content: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / "strange.world"
    path.write_text(content)
    with pytest.raises(FileError, match=rf"strange\.world: .*{said}"):
        world_with_robots(path)
    with pytest.raises(FileError, match="No such file"):
        world_with_robots(tmp_path / "none.world")
