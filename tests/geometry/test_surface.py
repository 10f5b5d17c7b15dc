"""The merged surface: it rebuilds the field, exactly."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from rsegen import Placement, Random, Recipe, StepField, build
from rsegen.geometry import NORMALS, Mesh, surface
from rsegen.geometry.rectangles import merge_squares
from strategies import fields


def as_trimesh(mesh: Mesh) -> trimesh.Trimesh:
    return trimesh.Trimesh(mesh.vertices, mesh.triangles, process=False)


def boxes_of_faces(mesh: Mesh, field: StepField, normal: int) -> np.ndarray:
    """Corners of the faces that look one way: (m, 2, 3), low and high, x and y in cells and z in metres."""
    corners = mesh.vertices[mesh.faces[mesh.normals == normal]]
    cells = [field.block_width, field.block_width, 1]
    offset = [field.shape[0] / 2, field.shape[1] / 2, 0]
    return np.stack([corners.min(axis=1), corners.max(axis=1)], axis=1) / cells + offset


@given(fields())
def test_tops_cover_every_cell_above_the_ground_once_at_its_height(field: StepField) -> None:
    painted = np.zeros(field.shape)
    times = np.zeros(field.shape, dtype=int)
    for low, high in boxes_of_faces(surface(field), field, normal=4):
        (i, j), (k, m) = np.rint(low[:2]).astype(int), np.rint(high[:2]).astype(int)
        painted[i:k, j:m] = low[2]
        times[i:k, j:m] += 1
    np.testing.assert_array_equal(painted, field.heights)
    np.testing.assert_array_equal(times, field.heights > 0)


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("sign", [1, -1])
@given(field=fields())
def test_risers_fill_every_step_exactly(axis: int, sign: int, field: StepField) -> None:
    around = np.pad(field.heights, 1)
    steps = -sign * np.diff(around, axis=axis)
    steps = steps[:, 1:-1] if axis == 0 else steps[1:-1, :]
    area = np.zeros(steps.shape)
    for low, high in boxes_of_faces(surface(field), field, normal=2 * axis + (sign < 0)):
        (i, j), (k, m) = np.rint(low[:2]).astype(int), np.rint(high[:2]).astype(int)
        line = (slice(i, i + 1), slice(j, m)) if axis == 0 else (slice(i, k), slice(j, j + 1))
        area[line] += high[2] - low[2]
    np.testing.assert_allclose(area, np.maximum(steps, 0), atol=1e-12)


@given(fields())
def test_volume_is_that_of_the_blocks(field: StepField) -> None:
    mesh = surface(field)
    blocks = field.heights.sum() * field.block_width**2
    volume = as_trimesh(mesh).volume if len(mesh.faces) else 0.0
    assert volume == pytest.approx(blocks, rel=1e-9, abs=1e-12)


@given(fields())
def test_corners_turn_counterclockwise_seen_from_outside(field: StepField) -> None:
    mesh = surface(field)
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in (0, 1, 2))
    turned = np.cross(b - a, c - b)
    lengths = np.linalg.norm(turned, axis=1)
    assert (lengths > 0).all()
    np.testing.assert_allclose(turned / lengths[:, None], NORMALS[mesh.normals], atol=1e-9)


@given(fields())
def test_vertices_are_welded_and_all_used(field: StepField) -> None:
    mesh = surface(field)
    assert len(np.unique(mesh.vertices, axis=0)) == len(mesh.vertices)
    np.testing.assert_array_equal(np.unique(mesh.faces), np.arange(len(mesh.vertices)))


@given(fields())
def test_faces_have_the_material_of_their_block(field: StepField) -> None:
    mesh = surface(field)
    for low, high in boxes_of_faces(mesh, field, normal=4):
        (i, j), (k, m) = np.rint(low[:2]).astype(int), np.rint(high[:2]).astype(int)
        assert len(np.unique(np.where(field.frame, 0, field.levels)[i:k, j:m])) == 1
    assert (np.diff(mesh.materials) >= 0).all()
    assert set(mesh.materials.tolist()) == {
        0 if frame else level
        for level, frame, height in zip(
            field.levels.ravel().tolist(), field.frame.ravel().tolist(), field.heights.ravel(), strict=True
        )
        if height
    }


def test_a_ray_from_above_meets_every_cell_at_its_height() -> None:
    field = build(Recipe(seed=4, chunks=(2, 2), obstacles=(Placement(obstacle=Random(max_height=5)),)))
    triangles = surface(field).vertices[surface(field).triangles]
    middle_x, middle_y = ((line[:-1] + line[1:]) / 2 for line in field.edges())
    for (i, j), height in np.ndenumerate(field.heights):
        assert highest_at(triangles, float(middle_x[i]) + 0.003, float(middle_y[j]) + 0.001) == height


def highest_at(triangles: np.ndarray, x: float, y: float) -> float:
    """Where a vertical line meets horizontal triangles; 0 for the ground."""
    flat = triangles[np.ptp(triangles[:, :, 2], axis=1) == 0]
    sides = [
        (b[:, 0] - a[:, 0]) * (y - a[:, 1]) - (b[:, 1] - a[:, 1]) * (x - a[:, 0])
        for a, b in pairwise([*np.moveaxis(flat, 1, 0), flat[:, 0]])
    ]
    hit = np.all(np.stack(sides) > 0, axis=0)
    return float(flat[hit, 0, 2].max(initial=0.0))


def test_a_plain_is_one_rectangle_and_its_rim() -> None:
    plain = Placement(obstacle=Random(max_height=2, weights=(0, 1)))
    assert len(surface(build(Recipe(boundary="none", obstacles=(plain,)))).faces) == 5


def test_level_ground_has_no_surface() -> None:
    assert len(surface(build(Recipe(boundary="none"))).faces) == 0


@given(st.lists(st.tuples(st.integers(0, 1), st.integers(0, 6), st.integers(0, 6)), unique=True))
def test_rectangles_cover_exactly_the_squares(squares: list[tuple[int, int, int]]) -> None:
    plane, u, v = np.array(squares, dtype=np.int64).reshape(-1, 3).T
    covered = [
        (p, i, j)
        for p, u0, u1, v0, v1 in zip(*(column.tolist() for column in merge_squares(plane, u, v)), strict=True)
        for i in range(u0, u1)
        for j in range(v0, v1)
    ]
    assert sorted(covered) == sorted(squares)


def test_each_plane_is_cut_the_better_way() -> None:
    comb = [(0, 0, v) for v in range(5)] + [(0, 1, v) for v in (0, 2, 4)]
    turned = [(1, v, u) for _, u, v in comb]
    plane, u, v = np.array(comb + turned, dtype=np.int64).T
    assert np.bincount(merge_squares(plane, u, v).plane).tolist() == [4, 4]
