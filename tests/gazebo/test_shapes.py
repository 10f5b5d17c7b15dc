"""Visuals and collisions of a map, in every combination that a recipe may ask for."""

from __future__ import annotations

import io
import xml.etree.ElementTree as ET
from itertools import product
from pathlib import Path

import numpy as np
import pytest
import trimesh

import rsegen
from rsegen import Recipe, compose
from rsegen.errors import ParameterError
from rsegen.gazebo import export
from rsegen.params.sorts import parameters
from rsegen.recipe.codec import decode
from rsegen.scene.scene import Scene

MESHES = parameters(Recipe)["mesh"].schema()["enum"]
COLLISIONS = parameters(Recipe)["collision"].schema()["enum"]
ROWS = [{"kind": "random", "levels": 4}]


def scene_of(**entries: object) -> Scene:
    return compose(decode({"chunk_size": 6, "chunks": [2, 1], "seed": 1, "obstacles": ROWS, **entries}))


def files_of(scene: Scene) -> dict[str, bytes]:
    return {str(path): b"".join(content) for path, content in export(scene).items()}


def links(files: dict[str, bytes], name: str) -> list[tuple[ET.Element, ET.Element]]:
    """Every model but the ground, and its link."""
    models = ET.fromstring(files[name]).findall(".//model")  # our own file
    found = [(model, model.find("link")) for model in models if model.get("name") != "ground_plane"]
    return [(model, link) for model, link in found if link is not None]


def mesh_volume(files: dict[str, bytes], uris: set[str | None]) -> float:
    return sum(trimesh.load_mesh(io.BytesIO(files[uri or ""]), file_type="obj").volume for uri in uris)


def box_volume(link: ET.Element) -> float:
    return sum(float(np.prod(np.array((size.text or "").split(), dtype=float))) for size in link.iter("size"))


@pytest.mark.parametrize(("mesh_type", "mesh", "collision"), [*product(["single", "pallet"], MESHES, COLLISIONS)])
def test_visuals_and_collisions_have_the_volume_of_the_blocks(mesh_type: str, mesh: str, collision: str) -> None:
    scene = scene_of(mesh_type=mesh_type, mesh=mesh, collision=collision)
    files = files_of(scene)
    blocks = scene.field.heights.sum() * 0.01
    found = links(files, f"{scene.name}.world")
    seen = {uri.text for _, link in found for uri in link.findall("visual//uri")}
    assert mesh_volume(files, seen) == pytest.approx(blocks, rel=1e-6)
    touched = {uri.text for _, link in found for uri in link.findall("collision//uri")}
    assert touched == (seen if collision == "mesh" else set())
    if collision != "mesh":
        assert sum(box_volume(link) for _, link in found) == pytest.approx(blocks, rel=1e-6)
    assert {path for path in files if path.endswith(".obj")} == seen


@pytest.mark.parametrize("collision", COLLISIONS)
def test_shapes_of_a_link_have_names_of_their_own(collision: str) -> None:
    scene = scene_of(collision=collision, tile=5)
    for name in (f"{scene.name}.world", "model.sdf"):
        for _, link in links(files_of(scene), name):
            names = [child.get("name") for child in link]
            assert len(names) == len(set(names)) > 1


def test_the_model_package_finds_its_meshes_by_its_name() -> None:
    scene = scene_of(tile=5)
    ((_, link),) = links(files_of(scene), "model.sdf")
    assert {(uri.text or "").rsplit("/", 1)[0] for uri in link.iter("uri")} == {f"model://{scene.name}/meshes"}


def test_tiles_have_every_face_of_the_map_once() -> None:
    whole, cut = scene_of(), scene_of(tile=5)
    files = files_of(cut)
    meshes = [trimesh.load_mesh(io.BytesIO(files[path]), file_type="obj") for path in files if path.endswith(".obj")]
    name = f"meshes/{whole.name}.obj"
    one = trimesh.load_mesh(io.BytesIO(files_of(whole)[name]), file_type="obj")
    assert len(meshes) == 4 * 2
    assert sum(mesh.area for mesh in meshes) == pytest.approx(one.area, rel=1e-6)
    assert all(max(mesh.extents[:2]) <= 0.5 + 1e-9 for mesh in meshes)


def test_a_tile_without_blocks_has_no_file() -> None:
    rows = [{"kind": "random", "levels": 2, "weights": [0, 1], "first": [0, 0], "last": [2, 2]}]
    scene = compose(decode({"boundary": "none", "tile": 5, "obstacles": rows}))
    assert [path for path in files_of(scene) if path.endswith(".obj")] == [f"meshes/{scene.name}_0_0.obj"]


@pytest.mark.parametrize(
    ("entries", "said"),
    [
        ({"mesh_type": "multi", "mesh": "watertight"}, "mesh: 'watertight' is for mesh_type single and pallet"),
        ({"mesh_type": "multi", "collision": "boxes"}, "collision: 'boxes' is for mesh_type single and pallet"),
        ({"mesh_type": "pallet", "tile": 5}, "tile: 5 is for mesh_type single"),
        ({"mesh_type": "pallet", "simulator": "classic"}, "simulator: 'classic' is for mesh_type single"),
        ({"mesh": "watertight", "tile": 5}, "tile: 5 would cut a watertight mesh open"),
    ],
)
def test_shapes_that_cannot_be_are_refused(entries: dict[str, object], said: str) -> None:
    with pytest.raises(ParameterError, match=f"^{said}"):
        scene_of(**entries)


@pytest.mark.parametrize("collision", COLLISIONS)
def test_for_gazebo_classic_a_map_is_a_body_that_nothing_moves(collision: str) -> None:
    scene = scene_of(simulator="classic", collision=collision)
    ((model, link),) = links(files_of(scene), f"{scene.name}.world")
    assert model.find("static") is None
    assert (link.findtext("kinematic"), link.findtext("gravity")) == ("true", "false")
    (joint,) = model.findall("joint")
    assert (joint.get("type"), joint.findtext("parent"), joint.findtext("child")) == (
        "fixed",
        "world",
        link.get("name"),
    )
    both = scene_of(collision=collision)
    ((_, usual),) = links(files_of(both), f"{both.name}.world")
    for one, other in zip(link.findall("collision"), usual.findall("collision"), strict=True):
        lifted = np.array((one.findtext("pose") or "").split(), dtype=float)
        before = np.array((other.findtext("pose") or "0 0 0 0 0 0").split(), dtype=float)
        np.testing.assert_allclose(lifted - before, [0, 0, 1e-5, 0, 0, 0], atol=1e-12)


def test_many_collisions_are_warned_of(tmp_path: Path) -> None:
    recipe = decode({"chunks": 4, "collision": "blocks", "obstacles": ROWS})
    (one,) = rsegen.generate(recipe, tmp_path).maps
    assert any("collisions: Gazebo Classic needs" in text for text in one.warnings)
