"""Every mesh rebuilds the field, exactly; each keeps its own promises."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest
import trimesh
from hypothesis import example, given, settings

from rsegen import Random, Recipe, StepField, build
from rsegen.geometry import Mesh, meshes, surface, unmerged, watertight
from rsegen.params.sorts import parameters
from tests.geometry.grids import GRIDS
from tests.support.strategies import fields

MESHES = parameters(Recipe)["mesh"].schema()["enum"]


def field_of(levels: list[list[int]] | np.ndarray) -> StepField:
    grid = np.array(levels, dtype=np.int16)
    return StepField(levels=grid, frame=grid < 0, block_width=0.1, unit=0.1, frame_height=0.1)


def as_trimesh(mesh: Mesh) -> trimesh.Trimesh:
    return trimesh.Trimesh(mesh.vertices, mesh.triangles, process=False)


def heights_seen_from_above(pieces: Iterable[Mesh], field: StepField) -> np.ndarray:
    """The highest face that a vertical line through the middle of each cell meets; 0 for the ground."""
    middle_x, middle_y = ((line[:-1] + line[1:]) / 2 for line in field.edges())
    seen = np.zeros(field.shape)
    for mesh in pieces:
        for a, b, c in mesh.vertices[mesh.triangles]:
            if a[2] == b[2] == c[2]:
                inside = np.all([left_of(p, q, middle_x, middle_y) for p, q in ((a, b), (b, c), (c, a))], axis=0)
                seen[inside] = np.maximum(seen[inside], a[2])
    return seen


def left_of(p: np.ndarray, q: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Which of the points on a grid are on the left of the line from p to q, or on it."""
    found: np.ndarray = np.add.outer(-(q[1] - p[1]) * (x - p[0]), (q[0] - p[0]) * (y - p[1])) >= -1e-12
    return found


@pytest.mark.parametrize("mesh", MESHES)
@given(field=fields())
def test_a_ray_from_above_meets_every_cell_at_its_height(mesh: str, field: StepField) -> None:
    np.testing.assert_array_equal(heights_seen_from_above(meshes(field, mesh), field), field.heights)


@pytest.mark.parametrize("mesh", MESHES)
def test_so_it_does_on_a_map_with_frames(mesh: str) -> None:
    field = build(Recipe(seed=4, chunks=(2, 2), obstacles=(Random(levels=5),)))
    np.testing.assert_array_equal(heights_seen_from_above(meshes(field, mesh), field), field.heights)


@pytest.mark.parametrize("mesh", MESHES)
@given(field=fields())
def test_volume_is_that_of_the_blocks(mesh: str, field: StepField) -> None:
    volume = sum(as_trimesh(piece).volume for piece in meshes(field, mesh) if len(piece.faces))
    assert volume == pytest.approx(field.heights.sum() * field.block_width**2, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("mesh", MESHES)
def test_level_ground_has_no_faces(mesh: str) -> None:
    assert sum(len(piece.faces) for piece in meshes(field_of([[0, 0], [0, 0]]), mesh)) == 0


def test_pieces_of_a_large_map_are_the_map() -> None:
    field = field_of(GRIDS["obstacles"](600, np.random.default_rng(1)))
    pieces = list(meshes(field, "merged"))
    assert len(pieces) == 4
    assert sum(len(piece.faces) for piece in meshes(field, "blocks")) == 6 * 600 * 600
    assert sum(as_trimesh(piece).volume for piece in pieces) == pytest.approx(field.heights.sum() * 0.01, rel=1e-9)


@pytest.mark.slow
@given(field=fields())
@example(field_of([[1, 0], [0, 1]]))
@example(field_of([[4, 1], [2, 3]]))
@example(field_of([[3, 0, 3], [0, 3, 0], [3, 0, 3]]))
@settings(max_examples=300)
def test_a_watertight_mesh_is_the_surface_of_a_solid(field: StepField) -> None:
    mesh = watertight(field)
    if not len(mesh.faces):
        assert not field.heights.any()
        return
    found = as_trimesh(mesh)
    assert found.is_watertight
    assert found.is_winding_consistent
    assert found.volume == pytest.approx(field.heights.sum() * field.block_width**2, rel=1e-9)
    assert found.area_faces.min() > 0
    assert len(np.unique(mesh.faces)) == len(mesh.places)


@given(field=fields())
def test_a_watertight_mesh_has_exactly_the_volume_of_the_levels(field: StepField) -> None:
    """In whole numbers: x and y in cells, z in nanometres; six times the volume is a sum of determinants."""
    mesh = watertight(field)
    z = np.rint(mesh.lines[2] * 1e9).astype(np.int64)
    corners = np.stack([mesh.places[:, 0], mesh.places[:, 1], z[mesh.places[:, 2]]], axis=1)[mesh.triangles]
    a, b, c = (corners[:, turn].astype(object) for turn in range(3))
    six_times = (a * np.cross(b, c)).sum() if len(corners) else 0
    assert six_times == 6 * int(np.rint(field.heights * 1e9).astype(np.int64).sum())


@given(field=fields())
def test_a_watertight_mesh_has_each_face_in_the_material_of_its_block(field: StepField) -> None:
    areas = []
    for mesh in (watertight(field), unmerged(field)):
        triangles = as_trimesh(mesh)
        repeats = len(mesh.triangles) // max(len(mesh.faces), 1)
        tops, materials = np.repeat(mesh.normals == 4, repeats), np.repeat(mesh.materials, repeats)
        areas.append({int(m): float(triangles.area_faces[tops & (materials == m)].sum()) for m in set(materials[tops])})
    assert areas[0] == pytest.approx(areas[1])


@pytest.mark.parametrize("kind", GRIDS)
def test_watertight_meshes_are_closed_on_every_kind_of_grid(kind: str) -> None:
    field = field_of(GRIDS[kind](40, np.random.default_rng(2)))
    found = as_trimesh(watertight(field))
    assert found.is_watertight
    assert found.is_winding_consistent
    assert found.volume == pytest.approx(field.heights.sum() * 0.01, rel=1e-9)


def test_a_watertight_mesh_has_at_most_30_percent_more_triangles() -> None:
    field = field_of(GRIDS["uniform"](80, np.random.default_rng(2)))
    assert len(watertight(field).triangles) <= 1.3 * len(surface(field).triangles)


def test_blocks_that_touch_along_an_edge_share_no_vertex_there() -> None:
    mesh = watertight(field_of([[2, 0], [0, 1]]))
    on_the_edge = (mesh.vertices[:, :2] == 0).all(axis=1)
    assert sorted(mesh.vertices[on_the_edge, 2]) == [0, 0, 0.1, 0.2]


@given(fields())
def test_blocks_have_8_vertices_and_6_faces_each(field: StepField) -> None:
    mesh, count = unmerged(field), int((field.heights > 0).sum())
    assert (len(mesh.places), len(mesh.faces)) == (8 * count, 6 * count)
    if count:
        assert as_trimesh(mesh).is_watertight
        assert (np.diff(mesh.materials) >= 0).all()
