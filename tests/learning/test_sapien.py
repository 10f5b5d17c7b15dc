"""A map in SAPIEN, which ManiSkill simulates in: bodies rest on its blocks and slide as far as friction lets them."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rsegen import Matrix, Random, Recipe, compose

pytestmark = pytest.mark.long(reason="SAPIEN, which only make learners brings")

SAPIEN = Path(sys.prefix) / "sapien"
G, EDGE = 9.81, 0.06
"""Gravity, m/s^2, and side of the boxes that fall, metres."""


@pytest.fixture
def sapien(monkeypatch: pytest.MonkeyPatch) -> Any:
    if not SAPIEN.is_dir():
        pytest.skip(f"no SAPIEN in {SAPIEN}: make learners puts it there")
    monkeypatch.syspath_prepend(SAPIEN)
    return pytest.importorskip("sapien", reason="SAPIEN cannot be imported")


def world(sapien: Any) -> Any:
    """A scene with a plane at 0, simulated on the CPU."""
    scene = sapien.Scene([sapien.physx.PhysxCpuSystem()])
    scene.set_timestep(0.002)
    builder = scene.create_actor_builder()
    builder.add_plane_collision(sapien.Pose(q=[np.sqrt(0.5), 0, -np.sqrt(0.5), 0]))
    builder.build_static(name="floor")
    return scene


def add_map(scene: Any, recipe: Recipe, pos: tuple[float, float, float] = (0, 0, 0)) -> tuple[Any, int]:
    from rsegen.learning.sapien import add_map

    own = compose(recipe)
    builder = scene.create_actor_builder()
    count = add_map(builder, own, pos, visual=False)  # no GPU here
    builder.build_static(name="map")
    return own, count


def add_box(sapien: Any, scene: Any, at: list[float], friction: float) -> Any:
    builder = scene.create_actor_builder()
    material = sapien.physx.PhysxMaterial(friction, friction, 0.0)
    builder.add_box_collision(half_size=(EDGE / 2,) * 3, material=material)
    body = builder.build(name=str(at))
    body.set_pose(sapien.Pose(at))
    return body


def test_boxes_rest_on_every_block(sapien: Any) -> None:
    scene, pos = world(sapien), (1.0, -2.0, 0.3)
    own, count = add_map(
        scene, Recipe(seed=7, chunk_size=6, unit_cm=4, boundary="outer", obstacles=[Random(levels=6)]), pos
    )
    assert count > 20
    tops = {
        (x, y): pos[2] + float(height) if height else 0.0
        for x, row in zip(own.field.middles()[0] + pos[0], own.field.heights, strict=True)
        for y, height in zip(own.field.middles()[1] + pos[1], row, strict=True)
    }
    bodies = {place: add_box(sapien, scene, [*place, top + EDGE / 2 + 0.002], 0.5) for place, top in tops.items()}
    for _ in range(1000):
        scene.step()
    for (x, y), body in bodies.items():
        assert body.pose.p == pytest.approx([x, y, tops[x, y] + EDGE / 2], abs=1e-4)
    assert len(set(tops.values())) >= 6


@pytest.mark.parametrize("friction", [0.2, 0.5])
def test_a_box_slides_as_far_as_the_friction_of_blocks_lets_it(sapien: Any, friction: float) -> None:
    scene, speed = world(sapien), 1.0
    level = Matrix.of(np.full((10, 10), 2), key="level")
    own, count = add_map(scene, Recipe(seed=1, boundary="none", unit_cm=5, friction=friction, obstacles=[level]))
    assert count == 1
    top = float(own.field.heights[0, 0])
    body = add_box(sapien, scene, [-0.45, 0, top + EDGE / 2], friction)
    body.find_component_by_type(sapien.physx.PhysxRigidDynamicComponent).set_linear_velocity([speed, 0, 0])
    for _ in range(1500):
        scene.step()
    x, y, z = body.pose.p.tolist()
    assert z == pytest.approx(top + EDGE / 2, abs=1e-3)
    assert x + 0.45 == pytest.approx(speed**2 / (2 * friction * G), rel=0.05)
    assert abs(y) < 0.01
