"""The files of a map, read back by others' eyes."""

from __future__ import annotations

import io
import json
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import PurePosixPath

import numpy as np
import pytest
import trimesh
from hypothesis import given

from rsegen import Random, Recipe, compose
from rsegen.gazebo import MESH_TYPES, export, obj
from rsegen.params.numbers import decimal
from rsegen.params.sorts import parameters
from rsegen.recipe.codec import decode, to_json
from rsegen.scene.scene import Scene
from tests.support.strategies import recipes


def files_of(scene: Scene) -> dict[str, bytes]:
    return {str(path): b"".join(content) for path, content in export(scene).items()}


def world_of(scene: Scene) -> ET.Element:
    world = ET.fromstring(files_of(scene)[f"{scene.name}.world"]).find("world")  # our own file
    assert world is not None
    return world


def text_of(element: ET.Element, path: str) -> str:
    found = element.findtext(path)
    assert found is not None
    return found


@pytest.mark.slow
@given(recipes())
def test_same_recipe_same_bytes(recipe: Recipe) -> None:
    assert files_of(compose(recipe)) == files_of(compose(decode(json.loads(to_json(recipe)))))


@pytest.mark.parametrize("mesh", ["merged", "watertight", "blocks"])
def test_a_mesh_has_the_same_bytes_for_any_number_of_lines_per_strip(
    monkeypatch: pytest.MonkeyPatch, mesh: str
) -> None:
    scene = compose(Recipe(seed=7, mesh=mesh, obstacles=(Random(levels=4),)))
    whole = files_of(scene)
    assert whole["meshes/rse_0000.obj"].count(b"\ng ") == 4
    for lines in (1, 7, 100):
        monkeypatch.setattr(obj, "STRIP", lines)
        assert files_of(scene) == whole


@pytest.mark.slow
@given(recipes())
def test_recipe_json_makes_this_map_again(recipe: Recipe) -> None:
    files = files_of(compose(replace(recipe, maps=9), 3))
    again = decode(json.loads(files["recipe.json"]))
    assert list(again.indices) == [3]
    assert files_of(compose(again, 3)) == files


@pytest.mark.slow
@given(recipes())
def test_levels_csv_is_the_blocks_north_up(recipe: Recipe) -> None:
    scene = compose(recipe)
    content = files_of(scene)["levels.csv"]
    rows = np.loadtxt(io.BytesIO(content), delimiter=",", comments="#", dtype=int, ndmin=2)
    np.testing.assert_array_equal(rows, scene.field.blocks.T[::-1])
    assert b"north up" in content.splitlines()[0]


@pytest.mark.slow
@given(recipes())
def test_obj_read_by_trimesh_has_the_volume_of_the_blocks(recipe: Recipe) -> None:
    scene = compose(replace(recipe, mesh_type="single"))
    files = files_of(scene)
    path = f"meshes/{scene.name}.obj"
    blocks = scene.field.heights.sum() * scene.field.block_width**2
    if not blocks:
        assert path not in files
        return
    mesh = trimesh.load_mesh(io.BytesIO(files[path]), file_type="obj")
    assert mesh.volume == pytest.approx(blocks, rel=1e-6)
    np.testing.assert_allclose(mesh.extents[:2], occupied_extent(scene), atol=1e-9)


def occupied_extent(scene: Scene) -> np.ndarray:
    cells = np.argwhere(scene.field.heights > 0)
    return np.asarray((np.ptp(cells, axis=0) + 1) * scene.field.block_width)


@given(recipes())
def test_obj_has_a_normal_at_every_corner_and_absolute_indices(recipe: Recipe) -> None:
    scene = compose(replace(recipe, mesh_type="single", boundary="outer"))
    lines = files_of(scene)[f"meshes/{scene.name}.obj"].decode().splitlines()
    vertices = sum(line.startswith("v ") for line in lines)
    normals = sum(line.startswith("vn ") for line in lines)
    for corner in (corner for line in lines if line.startswith("f ") for corner in line.split()[1:]):
        vertex, normal = corner.split("//")
        assert 1 <= int(vertex) <= vertices
        assert 1 <= int(normal) <= normals


@pytest.mark.slow
@given(recipes())
def test_materials_that_a_mesh_uses_are_in_its_library(recipe: Recipe) -> None:
    for mesh_type in ("single", "pallet"):
        scene = compose(replace(recipe, mesh_type=mesh_type))
        files = files_of(scene)
        library = files.get(f"meshes/{scene.name}.mtl", b"").decode().split()
        for path in (path for path in files if path.endswith(".obj")):
            lines = files[path].decode().splitlines()
            assert f"mtllib {scene.name}.mtl" in lines
            assert {line.split()[1] for line in lines if line.startswith("usemtl")} <= set(library)


def test_a_map_without_blocks_has_no_files_of_meshes() -> None:
    flat = Recipe(chunk_size=2, boundary="none", seed=1)
    assert not [path for path in export(compose(flat)) if path.parts[0] == "meshes"]
    assert [path for path in export(compose(replace(flat, boundary="divided"))) if path.parts[0] == "meshes"]


@pytest.mark.slow
@given(recipes())
def test_multi_has_a_static_box_for_each_cell_above_the_ground(recipe: Recipe) -> None:
    scene = compose(replace(recipe, mesh_type="multi"))
    rebuilt = np.zeros(scene.field.shape)
    edges_x, edges_y = scene.field.edges()
    for model in world_of(scene).findall("model"):
        if model.get("name") == "ground_plane":
            continue
        x, y, z, *turn = map(float, text_of(model, "pose").split())
        size = list(map(float, text_of(model, "link/collision/geometry/box/size").split()))
        i, j = np.searchsorted(edges_x, x) - 1, np.searchsorted(edges_y, y) - 1
        assert text_of(model, "static") == "true"
        assert turn == [0, 0, 0]
        assert z == pytest.approx(size[2] / 2)
        assert size[:2] == [scene.field.block_width] * 2
        assert text_of(model, "link/visual/geometry/box/size") == text_of(model, "link/collision/geometry/box/size")
        rebuilt[i, j] += size[2]
    np.testing.assert_array_equal(rebuilt, scene.field.heights)


def test_multi_names_blocks_by_cell_with_frames_left_out() -> None:
    rows = [{"kind": "random", "levels": 2, "weights": [0, 1]}]
    scene = compose(decode({"chunk_size": 2, "chunks": 2, "mesh_type": "multi", "obstacles": rows}))
    poses = {model.get("name"): text_of(model, "pose") for model in world_of(scene).findall("model")[1:]}
    assert sum(name.startswith("block_") for name in poses if name) == 16
    assert poses["block_0_0"].startswith("-0.25 -0.25 ")
    assert poses["block_2_3"].startswith("0.15 0.25 ")
    assert poses["frame_0_7"].startswith("-0.35 0.35 ")


@pytest.mark.slow
@given(recipes())
def test_pallets_hold_all_blocks_at_their_place(recipe: Recipe) -> None:
    scene = compose(replace(recipe, mesh_type="pallet"))
    files = files_of(scene)
    volume = 0.0
    for model in world_of(scene).findall("model")[1:]:
        uri = text_of(model, "link/collision/geometry/mesh/uri")
        assert uri == text_of(model, "link/visual/geometry/mesh/uri")
        volume += trimesh.load_mesh(io.BytesIO(files[uri]), file_type="obj").volume
    assert volume == pytest.approx(scene.field.heights.sum() * scene.field.block_width**2, rel=1e-6)
    assert len(world_of(scene).findall("model")) == 1 + MESH_TYPES["pallet"].counts(scene)[0]


@pytest.mark.parametrize("mesh_type", MESH_TYPES)
def test_worlds_need_nothing_from_elsewhere(mesh_type: str) -> None:
    scene = compose(decode({"mesh_type": mesh_type, "obstacles": [{"kind": "random", "levels": 5}]}))
    files = files_of(scene)
    world = world_of(scene)
    assert not world.findall("include")
    assert not list(world.iter("plugin"))
    assert {uri.text for uri in world.iter("uri")} <= set(files)
    assert world.get("name") == scene.name
    assert {"physics", "light", "model"} <= {child.tag for child in world}


@pytest.mark.parametrize("mesh_type", MESH_TYPES)
def test_every_collision_has_the_friction_of_the_recipe_and_soft_contact(mesh_type: str) -> None:
    scene = compose(decode({"mesh_type": mesh_type, "friction": 0.65, "obstacles": [{"kind": "random", "levels": 5}]}))
    for model in world_of(scene).findall("model"):
        for collision in model.iter("collision"):
            friction = [text_of(collision, f"surface/friction/ode/{name}") for name in ("mu", "mu2")]
            assert friction == ["0.65", "0.65"]
            if model.get("name") != "ground_plane":
                assert text_of(collision, "surface/contact/ode/kd") == "1000"


def test_every_mesh_type_that_a_recipe_may_name_is_made() -> None:
    assert parameters(Recipe)["mesh_type"].schema()["enum"] == list(MESH_TYPES)


@pytest.mark.slow
@given(recipes())
def test_paths_stay_inside_the_folder(recipe: Recipe) -> None:
    for path in export(compose(recipe)):
        assert isinstance(path, PurePosixPath)
        assert not path.is_absolute()
        assert ".." not in path.parts


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.1 + 0.2, "0.3"), (-0.0, "0"), (1e-12, "0"), (-1.25, "-1.25"), (100.0, "100"), (5e-7, "0.0000005")],
)
def test_numbers_are_plain_decimals(value: float, text: str) -> None:
    assert decimal(value) == text
