"""Worlds with robots in them stand alone, wherever they are written."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from rsegen import Placement, Random, Recipe, generate
from rsegen.errors import FileError
from rsegen.simulation.driving.world_with_robots import time_step, world_with_robots

MODEL = '<model name="one"><link name="l"/></model>'
NAMES = ("real_time_update_rate", "real_time_factor")


@pytest.fixture
def world(tmp_path: Path) -> Path:
    random = Placement(obstacle=Random(max_height=5))
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
    assert rates(unthrottled=True) == ["0", "0"]
    assert time_step(world_with_robots(world)) == 0.001


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("", "not XML"),
        ("<sdf><model name='a'/></sdf>", "no <world> in <sdf>"),
        ('<!DOCTYPE sdf [<!ENTITY a "b">]><sdf><world name="&a;"/></sdf>', "has a document type"),
    ],
)
def test_what_is_no_world_is_refused(content: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / "strange.world"
    path.write_text(content)
    with pytest.raises(FileError, match=rf"strange\.world: .*{said}"):
        world_with_robots(path)
    with pytest.raises(FileError, match="No such file"):
        world_with_robots(tmp_path / "none.world")
