"""The merged surface: it rebuilds the field, exactly."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given

from rsegen import Random, Recipe, StepField, build
from rsegen.geometry import NORMALS, Mesh, split_window, surface
from tests.support.strategies import fields


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


def test_a_plain_is_one_rectangle_and_its_rim() -> None:
    plain = Random(levels=2, weights=(0, 1))
    assert len(surface(build(Recipe(boundary="none", obstacles=(plain,)))).faces) == 5


def test_level_ground_has_no_surface() -> None:
    assert len(surface(build(Recipe(boundary="none"))).faces) == 0


def test_a_window_is_its_share_of_the_whole() -> None:
    field = build(Recipe(seed=4, chunks=(2, 2), obstacles=(Random(levels=5),)))
    parts = [surface(field, window) for window in split_window(field.whole, 7)]
    assert len(parts) == 16
    area = sum(as_trimesh(part).area for part in parts)
    assert area == pytest.approx(as_trimesh(surface(field)).area, rel=1e-9)
    assert sum(as_trimesh(part).volume for part in parts) == pytest.approx(field.heights.sum() * 0.01, rel=1e-9)
