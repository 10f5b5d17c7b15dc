"""trimesh judges the meshes: closed, of the blocks' volume, at the blocks' heights."""

from __future__ import annotations

import io
import json
import struct
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import given

from rsegen import Scene, StepField
from rsegen.formats.base import FORMATS
from rsegen.formats.solid import solid
from tests.formats.maps import SCENES, made
from tests.support.strategies import fields

MESH = pytest.mark.parametrize("name", ["glb", "ply", "stl"])
STANDING = {name: scene for name, scene in SCENES.items() if scene.field.is_raised()}
SCENE = pytest.mark.parametrize("scene", STANDING.values(), ids=list(STANDING))


def content(name: str, scene: Scene) -> bytes:
    (found,) = made(FORMATS[name](), scene).values()
    return found


def loaded(name: str, scene: Scene) -> Any:
    """Mesh that trimesh reads, its equal corners welded, with z up."""
    found: Any = trimesh.load(io.BytesIO(content(name, scene)), file_type=name)
    if name == "glb":
        found = found.to_mesh()
        found.merge_vertices(merge_tex=True, merge_norm=True)
        found.vertices = found.vertices[:, [0, 2, 1]] * [1, -1, 1]
    return found


def seen_from_above(mesh: Any, field: StepField) -> np.ndarray:
    """The highest triangle over the middle of each cell, by its plane and its outline; 0 for the ground."""
    corners = mesh.triangles[mesh.face_normals[:, 2] > 0.5]
    x, y = ((line[:-1] + line[1:]) / 2 for line in field.edges())
    seen = np.zeros(field.shape)
    for a, b, c in corners:
        sides = [np.add.outer(-(q - p)[1] * (x - p[0]), (q - p)[0] * (y - p[1])) for p, q in ((a, b), (b, c), (c, a))]
        inside = np.all([side >= -1e-9 for side in sides], axis=0)
        seen[inside] = np.maximum(seen[inside], a[2])
    return seen


@MESH
@SCENE
def test_a_mesh_is_closed_and_has_the_volume_of_the_blocks(name: str, scene: Scene) -> None:
    found, field = loaded(name, scene), scene.field
    assert found.is_watertight
    assert found.is_winding_consistent
    assert found.volume == pytest.approx(field.heights.sum() * field.block_width**2, rel=1e-6)
    assert (np.abs(found.vertices[:, :2]).max(axis=0) <= np.array(field.extent) / 2 * (1 + 1e-6)).all()


@MESH
@SCENE
def test_a_ray_from_above_meets_every_cell_at_its_height(name: str, scene: Scene) -> None:
    expected = scene.field.heights.astype(np.float32)
    np.testing.assert_array_equal(seen_from_above(loaded(name, scene), scene.field).astype(np.float32), expected)


@pytest.mark.slow
@given(field=fields())
def test_a_solid_stays_closed_where_vertices_at_one_place_are_welded(field: StepField) -> None:
    found = solid(field)
    if not len(found.triangles):
        assert not field.heights.any()
        return
    for welded in (False, True):
        mesh = trimesh.Trimesh(found.vertices, found.triangles, process=welded)
        assert mesh.is_watertight
        assert mesh.is_winding_consistent
        assert mesh.volume == pytest.approx(field.heights.sum() * field.block_width**2, rel=1e-9)


def test_every_level_and_the_frame_are_parts_of_their_colour() -> None:
    scene = SCENES["frames round every chunk"]
    levels = [f"level_{level}" for level in scene.field.level_counts() if level]
    found: Any = trimesh.load(io.BytesIO(content("glb", scene)), file_type="glb")
    assert sorted(found.geometry) == ["frame", *levels]
    colours = {tuple(mesh.visual.material.baseColorFactor) for mesh in found.geometry.values()}
    assert len(colours) == len(levels) + 1
    coloured: Any = trimesh.load(io.BytesIO(content("ply", scene)), file_type="ply", process=False)
    expected = {scene.colour(level) for level in scene.field.level_counts() if level} | {scene.colour(0)}
    rgb = {tuple(colour) for colour in np.unique(coloured.visual.vertex_colors[:, :3], axis=0).tolist()}
    assert rgb == {tuple(round(255 * part) for part in colour) for colour in expected}


def test_a_flat_map_gives_a_valid_empty_file() -> None:
    scene = SCENES["nothing"]
    magic, version, size, length, kind = struct.unpack_from("<4sIIII", content("glb", scene))
    assert (magic, version, size, kind) == (b"glTF", 2, len(content("glb", scene)), 0x4E4F534A)
    assert json.loads(content("glb", scene)[20 : 20 + length])["asset"]["version"] == "2.0"
    assert b"element vertex 0\n" in content("ply", scene)
    assert len(content("stl", scene)) == 84
