"""MuJoCo judges its own format: it compiles, rays meet the heights, a ball comes to rest on a block."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rsegen import Matrix, Recipe, Scene, StepField, compose
from rsegen.errors import ParameterError
from rsegen.formats.mjcf import Mjcf
from tests.formats.maps import RECIPES, SCENES, made
from tests.real.bodies import SIDEWAYS, SIZE
from tests.real.maps import lanes, slippery

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")

SHAPES = ["boxes", "hfield", "mesh"]
SHAPE = pytest.mark.parametrize("shape", SHAPES)
SCENE = pytest.mark.parametrize("scene", SCENES.values(), ids=list(SCENES))
NEAR_FLAT = Recipe(seed=11, chunk_size=2, boundary="none", obstacles=(Matrix.of(np.array([[3, 3], [3, 3]])),))

SLIPPERY, *_, SLIPPERY_HIGH = map(compose, slippery())


def written(shape: str, scene: Scene, folder: Path, **options: int) -> Path:
    for path, content in made(Mjcf(shape=shape, **options), scene).items():
        (folder / path).write_bytes(content)
    return folder


def compiled(folder: Path, file: str = "scene.xml") -> tuple[Any, Any]:
    model = mujoco.MjModel.from_xml_path(str(folder / file))
    state = mujoco.MjData(model)
    mujoco.mj_forward(model, state)
    return model, state


def seen_from_above(model: Any, state: Any, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Height at which a ray straight down ends near each place of x times y, on what can be touched.

    A ray that goes exactly through the edge between two triangles of a height field may slip through.
    """
    x, y = x + 1e-5, y + 2e-5
    mask = np.ones(mujoco.mjNGROUP, dtype=np.uint8)
    mask[2] = 0
    found, start = np.zeros((len(x), len(y))), 10.0
    for i, j in np.ndindex(found.shape):
        way = mujoco.mj_ray(model, state, [x[i], y[j], start], [0, 0, -1], mask, 1, -1, np.zeros(1, dtype=np.int32))
        found[i, j] = start - way
    return found


def centres(field: StepField) -> list[np.ndarray]:
    return [(line[:-1] + line[1:]) / 2 for line in field.edges()]


@SHAPE
@SCENE
def test_a_ray_from_above_meets_every_cell_at_its_height(shape: str, scene: Scene, tmp_path: Path) -> None:
    model, state = compiled(written(shape, scene, tmp_path))
    found = seen_from_above(model, state, *centres(scene.field))
    np.testing.assert_allclose(found, scene.field.heights, rtol=0, atol=1e-6 if shape == "hfield" else 1e-12)


@pytest.mark.parametrize("pixels", [2, 3, 10])
def test_a_height_field_slopes_only_within_half_a_sample_of_a_cell_s_edge(pixels: int, tmp_path: Path) -> None:
    scene = SCENES["one frame of another height"]
    model, state = compiled(written("hfield", scene, tmp_path, pixels=pixels))
    assert model.hfield_nrow[0] == pixels * scene.field.shape[1]
    x, y = centres(scene.field)
    reach = scene.field.block_width * (0.5 - 0.5 / pixels) * 0.999
    for along_x in (-reach, 0, reach):
        for along_y in (-reach, 0, reach):
            found = seen_from_above(model, state, x + along_x, y + along_y)
            np.testing.assert_allclose(found, scene.field.heights, rtol=0, atol=1e-6)


@pytest.mark.parametrize("levels", [[[3, 3], [3, 3]], [[3, 1], [2, 1]]])
def test_a_height_field_without_a_cell_on_the_ground_is_at_its_heights(levels: list[list[int]], tmp_path: Path) -> None:
    scene = compose(replace(NEAR_FLAT, obstacles=(Matrix.of(np.array(levels)),)))
    model, state = compiled(written("hfield", scene, tmp_path))
    found = seen_from_above(model, state, *centres(scene.field))
    np.testing.assert_allclose(found, scene.field.heights, rtol=0, atol=1e-6)


@pytest.mark.parametrize("shape", ["boxes", "mesh"])
@SCENE
def test_the_boxes_are_the_volume_of_the_blocks(shape: str, scene: Scene, tmp_path: Path) -> None:
    model, _ = compiled(written(shape, scene, tmp_path), f"{scene.name}.xml")
    sizes = model.geom_size[model.geom_type == mujoco.mjtGeom.mjGEOM_BOX]
    assert 8 * sizes.prod(axis=1).sum() == pytest.approx(scene.field.heights.sum() * scene.field.block_width**2)
    touched = (model.geom_contype > 0) | (model.geom_conaffinity > 0)
    assert (model.geom_type[touched] == mujoco.mjtGeom.mjGEOM_BOX).all()


@pytest.mark.parametrize("shape", ["boxes", "mesh"])
def test_visuals_have_the_colour_of_their_level(shape: str, tmp_path: Path) -> None:
    scene = SCENES["frames round every chunk"]
    model, _ = compiled(written(shape, scene, tmp_path), f"{scene.name}.xml")
    shown = model.geom_group < 3
    colours = {
        tuple(round(float(part), 3) for part in model.mat_rgba[number, :3]) for number in model.geom_matid[shown]
    }
    levels = [level for level in scene.field.level_counts() if level]
    assert colours == {scene.colour(kind) for kind in (0, *levels)}


@SHAPE
def test_a_ball_that_is_dropped_comes_to_rest_on_a_block(shape: str, tmp_path: Path) -> None:
    scene = SCENES["one frame of another height"]
    drop = 0.1 if shape == "hfield" else 0.7  # from higher up small balls sink into MuJoCo's height fields
    i, j = np.argwhere(scene.field.levels == scene.field.levels.max())[0]
    x, y = (line[at] for line, at in zip(centres(scene.field), (i, j), strict=True))
    ball = f"""
    <mujoco>
      <include file="scene.xml"/>
      <worldbody>
        <body name="ball" pos="{x} {y} {scene.field.heights[i, j] + drop}">
          <freejoint/>
          <geom type="sphere" size="0.02" mass="0.1" condim="6" friction="1 0.01 0.01" priority="11"/>
        </body>
      </worldbody>
    </mujoco>"""
    (written(shape, scene, tmp_path) / "ball.xml").write_text(ball)
    model, state = compiled(tmp_path, "ball.xml")
    for _ in range(1500):
        mujoco.mj_step(model, state)
    at = state.body("ball")
    np.testing.assert_allclose(at.xpos, [x, y, scene.field.heights[i, j] + 0.02], rtol=0, atol=1e-3)
    assert np.abs(at.cvel).max() < 1e-3


@SHAPE
def test_the_friction_is_the_map_s(shape: str, tmp_path: Path) -> None:
    scene = compose(replace(RECIPES["frames round every chunk"], friction=0.35))
    model, _ = compiled(written(shape, scene, tmp_path))
    touched = model.geom_contype > 0
    np.testing.assert_allclose(model.geom_friction[touched, 0], 0.35)


@pytest.mark.parametrize("shape", ["boxes", "mesh"])
def test_every_box_has_the_friction_of_its_level(shape: str, tmp_path: Path) -> None:
    model, state = compiled(written(shape, SLIPPERY, tmp_path), f"{SLIPPERY.name}.xml")
    heights = seen_from_above(model, state, *centres(SLIPPERY.field))
    np.testing.assert_allclose(heights, SLIPPERY.field.heights, rtol=0, atol=1e-12)
    boxes = model.geom_type == mujoco.mjtGeom.mjGEOM_BOX
    known = {}
    for (x, y, z), friction in zip(model.geom_pos[boxes], model.geom_friction[boxes, 0], strict=True):
        i, j = (np.searchsorted(line, at) - 1 for line, at in zip(SLIPPERY.field.edges(), (x, y), strict=True))
        assert 2 * z == pytest.approx(SLIPPERY.field.heights[i, j])
        known[0 if SLIPPERY.field.frame[i, j] else int(SLIPPERY.field.levels[i, j])] = friction
    assert known == pytest.approx({0: 0.05, 1: 0.05, 2: 0.9})


@pytest.mark.parametrize("shape", ["boxes", "mesh"])
@pytest.mark.parametrize("scene", [SLIPPERY, SLIPPERY_HIGH], ids=["low", "high"])
def test_a_slippery_cube_that_is_pushed_slides_where_the_map_is_slippery_too(
    shape: str, scene: Scene, tmp_path: Path
) -> None:
    """MuJoCo takes the larger coefficient of the two."""
    cubes = "".join(
        f"""
        <body name="{name}" pos="{x} {y} {top + SIZE / 2}">
          <freejoint/>
          <geom type="box" size="{SIZE / 2} {SIZE / 2} {SIZE / 2}" mass="0.05" friction="0.01 0.005 0.0001"/>
        </body>"""
        for name, (x, y, top), _ in lanes(scene)
    )
    (written(shape, scene, tmp_path) / "cubes.xml").write_text(f"""
    <mujoco>
      <include file="scene.xml"/>
      <option gravity="{SIDEWAYS} 0 -9.81"/>
      <worldbody>{cubes}</worldbody>
    </mujoco>""")
    model, state = compiled(tmp_path, "cubes.xml")
    while state.time < 0.4:
        mujoco.mj_step(model, state)
    for name, (x, y, top), slides in lanes(scene):
        at = state.body(name).xpos
        np.testing.assert_allclose(at[1:], [y, top + SIZE / 2], rtol=0, atol=2e-3)
        assert 0.15 < at[0] - x < 0.25 if slides else abs(at[0] - x) < 0.01, name


def test_a_height_field_of_several_frictions_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match=r"^shape: 'hfield' has one friction coefficient"):
        written("hfield", SLIPPERY, tmp_path)
    alike = compose(replace(SLIPPERY.recipe, frame_friction=0.9, level_friction=(0.9, 0.9)))
    model, _ = compiled(written("hfield", alike, tmp_path))
    np.testing.assert_allclose(model.geom_friction[:, 0], 0.9)


@SHAPE
def test_the_map_alone_is_one_body_which_a_scene_takes_in_twice(shape: str, tmp_path: Path) -> None:
    """Attached under two prefixes, as a robot's own scene would have it."""
    scene = SCENES["frames round every chunk"]
    folder = written(shape, scene, tmp_path)
    alone, _ = compiled(folder, f"{scene.name}.xml")
    assert alone.nbody == 2
    assert alone.body(1).name == scene.name
    assert alone.nlight == alone.ncam == alone.nv == 0
    attach = f'<attach model="{scene.name}" body="{scene.name}" prefix='
    (folder / "two.xml").write_text(f"""
    <mujoco>
      <asset><model name="{scene.name}" file="{scene.name}.xml"/></asset>
      <worldbody>
        <frame pos="-2 0 0">{attach}"left_"/></frame>
        <frame pos="2 0 0">{attach}"right_"/></frame>
      </worldbody>
    </mujoco>""")
    model, state = compiled(folder, "two.xml")
    assert model.ngeom == 2 * alone.ngeom
    x, y = centres(scene.field)
    for side in (-2, 2):
        found = seen_from_above(model, state, x + side, y)
        np.testing.assert_allclose(np.where(scene.field.heights, found, 0), scene.field.heights, rtol=0, atol=1e-6)


def test_maps_of_one_recipe_go_into_one_scene(tmp_path: Path) -> None:
    scenes = [compose(replace(RECIPES["frames round every chunk"], maps=2), index) for index in (0, 1)]
    for scene in scenes:
        written("boxes", scene, tmp_path)
    includes = "".join(f'<include file="{scene.name}.xml"/>' for scene in scenes)
    (tmp_path / "both.xml").write_text(f"<mujoco>{includes}</mujoco>")
    model, _ = compiled(tmp_path, "both.xml")
    assert [model.body(number).name for number in range(1, model.nbody)] == [scene.name for scene in scenes]
