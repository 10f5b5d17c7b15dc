"""PyBullet judges the URDF: it loads it as something that nothing moves, and rays meet the heights."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from rsegen import Scene, compose
from rsegen.formats.base import FORMATS
from tests.formats.maps import RECIPES, SCENES, made
from tests.formats.test_meshes import seen_from_above
from tests.real.bodies import SIDEWAYS, SIZE
from tests.real.maps import lanes, slippery

SLIPPERY, *_, SLIPPERY_HIGH = map(compose, slippery())
SCENE = pytest.mark.parametrize("scene", SCENES.values(), ids=list(SCENES))


@pytest.fixture
def bullet() -> Iterator[Any]:
    found = pytest.importorskip("pybullet", reason="PyBullet has no wheel for every Python, and is not installed here")
    found.connect(found.DIRECT)
    yield found
    found.disconnect()


def written(scene: Scene, folder: Path) -> Path:
    for path, content in made(FORMATS["urdf"](), scene).items():
        (folder / path).parent.mkdir(exist_ok=True)
        (folder / path).write_bytes(content)
    return folder / f"{scene.name}.urdf"


def centres(scene: Scene) -> list[np.ndarray]:
    return [(line[:-1] + line[1:]) / 2 for line in scene.field.edges()]


@pytest.mark.long(reason="PyBullet, 0.3 GB")
@pytest.mark.parametrize("scene", [*SCENES.values(), SLIPPERY], ids=[*SCENES, "several frictions"])
def test_pybullet_s_rays_meet_every_cell_at_its_height(scene: Scene, tmp_path: Path, bullet: Any) -> None:
    body = bullet.loadURDF(str(written(scene, tmp_path)))
    assert bullet.getDynamicsInfo(body, -1)[0] == 0
    x, y = centres(scene)
    starts = [(a, b, 5) for a in x for b in y]
    ends = [(a, b, -5) for a in x for b in y]
    found = [place[2] if hit == body else 0 for hit, _, _, place, _ in bullet.rayTestBatch(starts, ends)]
    np.testing.assert_allclose(np.reshape(found, scene.field.shape), scene.field.heights, rtol=0, atol=1e-9)


@pytest.mark.long(reason="PyBullet, 0.3 GB")
@pytest.mark.parametrize("name", ["frames round every chunk", "one frame of another height"])
def test_a_ball_comes_to_rest_on_a_block_in_pybullet(name: str, tmp_path: Path, bullet: Any) -> None:
    scene = SCENES[name]
    bullet.setGravity(0, 0, -9.81)
    bullet.loadURDF(str(written(scene, tmp_path)))
    i, j = np.argwhere(scene.field.levels == scene.field.levels.max())[0]
    x, y = (line[at] for line, at in zip(centres(scene), (i, j), strict=True))
    top = scene.field.heights[i, j]
    ball = bullet.createCollisionShape(bullet.GEOM_SPHERE, radius=0.03)
    body = bullet.createMultiBody(baseMass=0.1, baseCollisionShapeIndex=ball, basePosition=[x, y, top + 0.5])
    for _ in range(720):
        bullet.stepSimulation()
    np.testing.assert_allclose(bullet.getBasePositionAndOrientation(body)[0], [x, y, top + 0.03], rtol=0, atol=1e-3)


@pytest.mark.long(reason="PyBullet, 0.3 GB")
def test_pybullet_shows_every_colour_and_keeps_the_friction(tmp_path: Path, bullet: Any) -> None:
    scene = compose(replace(RECIPES["frames round every chunk"], friction=0.35))
    body = bullet.loadURDF(str(written(scene, tmp_path)))
    kinds = [0, *(level for level in scene.field.level_counts() if level)]
    shown = [shape[7][:3] for shape in bullet.getVisualShapeData(body)]
    np.testing.assert_allclose(shown, [scene.colour(kind) for kind in kinds], atol=1e-6)
    assert bullet.getDynamicsInfo(body, -1)[1] == pytest.approx(0.35)


@pytest.mark.long(reason="PyBullet, 0.3 GB")
@pytest.mark.parametrize("scene", [SLIPPERY, SLIPPERY_HIGH], ids=["low", "high"])
def test_a_cube_that_is_pushed_in_pybullet_slides_where_it_is_slippery_alone(
    scene: Scene, tmp_path: Path, bullet: Any
) -> None:
    bullet.setGravity(SIDEWAYS, 0, -9.81)
    body = bullet.loadURDF(str(written(scene, tmp_path)))
    links = [-1, *range(bullet.getNumJoints(body))]
    assert [bullet.getDynamicsInfo(body, link)[:2] for link in links] == [(0, 0.05), (0, 0.9)]
    cube = bullet.createCollisionShape(bullet.GEOM_BOX, halfExtents=[SIZE / 2] * 3)
    cubes = {}
    for name, (x, y, top), _ in lanes(scene):
        cubes[name] = bullet.createMultiBody(0.05, cube, basePosition=[x, y, top + SIZE / 2])
        bullet.changeDynamics(cubes[name], -1, lateralFriction=1)  # Bullet multiplies the two
    for _ in range(96):
        bullet.stepSimulation()
    for name, (x, y, top), slides in lanes(scene):
        at = np.array(bullet.getBasePositionAndOrientation(cubes[name])[0])
        np.testing.assert_allclose(at[1:], [y, top + SIZE / 2], rtol=0, atol=2e-3)
        assert 0.15 < at[0] - x < 0.25 if slides else abs(at[0] - x) < 0.005, name


def test_a_map_of_several_frictions_is_as_many_links_joined_to_the_first(tmp_path: Path) -> None:
    robot = ET.parse(written(SLIPPERY, tmp_path)).getroot()
    name = SLIPPERY.name
    assert [link.get("name") for link in robot.findall("link")] == [name, f"{name}_friction_0.9"]
    (joint,) = robot.findall("joint")
    ends = [joint.find(end).get("link") for end in ("parent", "child")]  # type: ignore[union-attr]
    assert (joint.get("type"), ends) == ("fixed", [name, f"{name}_friction_0.9"])
    assert [len(link.findall("visual")) for link in robot.findall("link")] == [3, 0]


@SCENE
def test_the_boxes_are_the_volume_of_the_blocks(scene: Scene, tmp_path: Path) -> None:
    robot = ET.parse(written(scene, tmp_path)).getroot()
    assert [child.tag for child in robot] == ["link"]
    sizes = [[float(side) for side in box.get("size", "").split()] for box in robot.iter("box")]
    assert np.prod(np.reshape(sizes, (-1, 3)), axis=1).sum() == pytest.approx(
        scene.field.heights.sum() * scene.field.block_width**2
    )


@SCENE
def test_the_meshes_are_seen_at_the_heights_and_carry_the_colours(scene: Scene, tmp_path: Path) -> None:
    robot = ET.parse(written(scene, tmp_path)).getroot()
    parts = [mesh.get("filename", "") for mesh in robot.iter("mesh")]
    meshes: list[Any] = [trimesh.load_mesh(tmp_path / part, process=False) for part in parts]
    found: Any = trimesh.util.concatenate(meshes) if meshes else trimesh.Trimesh()
    np.testing.assert_allclose(seen_from_above(found, scene.field), scene.field.heights, rtol=0, atol=1e-9)
    for mesh, visual in zip(meshes, robot.iter("visual"), strict=True):
        rgba = [float(part) for part in visual.find("material/color").get("rgba").split()]  # type: ignore[union-attr]
        np.testing.assert_allclose(mesh.visual.material.diffuse, np.round(np.array(rgba) * 255), atol=1)
