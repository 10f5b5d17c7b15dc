"""The world of a ROS 2 package in real Gazebos, with the models where the package's environment hook says they are."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import rsegen
from rsegen import compose
from rsegen.exporters.formats.ros2 import Ros2
from rsegen.simulation.simulators import Installation
from tests.simulation.real.bodies import SIZE, body
from tests.simulation.real.maps import variants
from tests.simulation.real.test_sdformat import said
from tests.simulation.simulated import simulated


def package(tmp_path: Path) -> tuple[rsegen.Scene, Path]:
    scene = compose(next(recipe for recipe in variants() if recipe.mesh_type == "single"))
    for path, content in Ros2().files(scene).items():
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).write_bytes(b"".join(content))
    (found,) = tmp_path.iterdir()
    return scene, found


def test_gazebo_classic_opens_the_world_and_holds_what_is_dropped(gazebo: Installation, tmp_path: Path) -> None:
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
