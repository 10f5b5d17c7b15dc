"""Meshes, boxes, pictures and files of fields and scenes by the functions of `rsegen`."""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from PIL import Image

import rsegen
from rsegen import Recipe, Scene
from rsegen.errors import UnknownName, UserError
from rsegen.geometry import boxes, surface, unmerged, watertight
from rsegen.pictures.preview import thumbnail
from rsegen.recipe.examples import EXAMPLES

RECIPE = Recipe(seed=7, chunk_size=6, boundary="divided", obstacles=[rsegen.Random(levels=5)])


@pytest.fixture
def scene() -> Scene:
    return rsegen.compose(RECIPE)


@pytest.mark.parametrize(("kind", "made"), [("merged", surface), ("watertight", watertight), ("blocks", unmerged)])
def test_the_mesh_of_a_field_is_the_exporters_mesh(scene: Scene, kind: str, made: object) -> None:
    mesh, expected = rsegen.mesh(scene.field, kind), made(scene.field)  # type: ignore[operator]
    np.testing.assert_array_equal(mesh.vertices, expected.vertices)
    np.testing.assert_array_equal(mesh.faces, expected.faces)


def test_a_field_has_its_merged_mesh_by_default(scene: Scene) -> None:
    np.testing.assert_array_equal(rsegen.mesh(scene.field).faces, surface(scene.field).faces)


def test_the_watertight_mesh_of_a_field_is_watertight_in_trimesh(scene: Scene) -> None:
    mesh = rsegen.mesh(scene.field, "watertight")
    assert trimesh.Trimesh(mesh.vertices, mesh.triangles, process=False).is_watertight


def test_an_unknown_mesh_is_named_with_the_known_ones(scene: Scene) -> None:
    with pytest.raises(UnknownName, match=r"unknown mesh 'sealed'.*blocks, merged, watertight"):
        rsegen.mesh(scene.field, "sealed")


def test_the_boxes_of_a_field_fill_its_volume(scene: Scene) -> None:
    found = rsegen.boxes(scene.field)
    assert len(found) == len(boxes(scene.field))
    volume = scene.field.heights.sum() * scene.field.block_width**2
    assert found.sizes.prod(axis=1).sum() == pytest.approx(volume)
    np.testing.assert_allclose(found.centres - found.sizes / 2, found.low, atol=1e-12)


def test_a_preview_has_the_format_that_is_asked_for(scene: Scene) -> None:
    assert rsegen.preview(scene).startswith(b"\x89PNG")
    assert rsegen.preview(scene, "svg").startswith(b"<?xml")


def test_a_field_has_a_preview_without_a_recipe(scene: Scene) -> None:
    picture = Image.open(io.BytesIO(rsegen.preview(scene.field)))
    assert picture.width == 1600
    assert "Description" not in picture.info


@pytest.mark.parametrize("cells", [1, 6, 100, 700])
def test_a_small_plan_is_drawn_of_a_field_and_of_a_scene(cells: int) -> None:
    scene = rsegen.compose(Recipe(seed=1, chunk_size=cells, boundary="none"))
    for shown in (scene, scene.field):
        picture = Image.open(io.BytesIO(thumbnail(shown)))
        assert picture.format == "PNG"
        assert 160 <= max(picture.size) <= 350


def test_a_small_plan_is_north_up_in_the_colours_of_the_levels(scene: Scene) -> None:
    picture = Image.open(io.BytesIO(thumbnail(scene)))
    side = picture.size[0] // scene.field.shape[0]
    for i, j in [(0, 0), (1, 1), (6, 6), (1, 6)]:
        material = 0 if scene.field.frame[i, j] else int(scene.field.levels[i, j])
        ground = not material and not scene.field.frame[i, j]
        expected = (0.86,) * 3 if ground else scene.plan_colour(material)
        pixel = picture.getpixel((i * side, picture.size[1] - 1 - j * side))
        assert pixel == tuple(round(255 * part) for part in expected)


def test_a_scene_is_exported_to_a_file_by_its_suffix(scene: Scene, tmp_path: Path) -> None:
    found = rsegen.export(scene, tmp_path / "x.glb")
    assert found == rsegen.Exported(path=tmp_path / "x.glb", format="glb", files=(tmp_path / "x.glb",))
    meshes: Any = trimesh.load(found.path)
    volume = scene.field.heights.sum() * scene.field.block_width**2
    assert sum(mesh.area for mesh in meshes.geometry.values()) > 0
    assert meshes.to_geometry().volume == pytest.approx(volume, rel=1e-5)
    assert {path.name for path in tmp_path.iterdir()} == {"x.glb"}


def test_a_recipe_is_exported_as_its_scene_is(scene: Scene, tmp_path: Path) -> None:
    rsegen.export(RECIPE, tmp_path / "a.stl")
    rsegen.export(scene, tmp_path / "b.dat", "stl")
    assert (tmp_path / "a.stl").read_bytes() == (tmp_path / "b.dat").read_bytes()


def test_any_map_of_a_recipe_is_exported(tmp_path: Path) -> None:
    recipe = rsegen.load(EXAMPLES["mixed-course"])
    rsegen.export(recipe, tmp_path / "other", "arrays", index=3)
    levels = np.load(tmp_path / "other" / "arrays" / "levels.npy")
    np.testing.assert_array_equal(levels, rsegen.build(recipe, 3).levels)


def test_a_path_without_suffix_is_a_folder_with_the_recipe(scene: Scene, tmp_path: Path) -> None:
    found = rsegen.export(scene, tmp_path / "map", "mjcf", shape="hfield", pixels=3)
    assert all(path.is_file() for path in found.files)
    assert tmp_path / "map" / "recipe.json" in found.files
    assert json.loads((tmp_path / "map" / "formats.json").read_text("utf-8"))["mjcf"]["pixels"] == 3


@pytest.mark.parametrize(
    ("path", "name", "options", "message"),
    [
        ("x.doc", None, {}, r"format: unknown format 'doc'.*known: arrays, glb"),
        ("x", None, {}, r"format: .*x has no suffix; choose a format \(known: arrays, glb"),
        ("x.urdf", None, {}, r"path: .*x.urdf is one file, but urdf writes \d+ of them; use a folder"),
        ("x.png", "heightmap", {}, r"heightmap writes 2 of them"),
        ("x.usd", None, {"binaries": True}, r"unknown option of usd 'binaries'; did you mean 'binary'"),
        ("x", "mjcf", {"pixels": 0}, r"pixels: 0 is outside 1..100"),
    ],
)
def test_an_impossible_export_is_refused_in_one_line_and_leaves_nothing(
    scene: Scene, tmp_path: Path, path: str, name: str | None, options: dict[str, Any], message: str
) -> None:
    with pytest.raises(UserError, match=message) as error:
        rsegen.export(scene, tmp_path / path, name, **options)
    assert "\n" not in str(error.value)
    assert not list(tmp_path.iterdir())


def test_a_file_is_replaced_by_force_alone(scene: Scene, tmp_path: Path) -> None:
    rsegen.export(scene, tmp_path / "x.stl")
    with pytest.raises(UserError, match="exists already"):
        rsegen.export(scene, tmp_path / "x.stl")
    (tmp_path / "x.stl").write_bytes(b"")
    assert rsegen.export(scene, tmp_path / "x.stl", force=True).path.stat().st_size > 100
