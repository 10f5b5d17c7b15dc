"""Clouds that were taken from all around a field, or spread over its surface: most points are of sides."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

import rsegen
from rsegen import Matrix, Random, Recipe, StepField
from rsegen.errors import ScanError
from rsegen.field.stepfield import Array
from rsegen.scanning.finding import find_field
from rsegen.scanning.grid import without_sides

DENSE = 40_000
"""Points per square metre: 400 on a block of 10 cm."""


def field_of(seed: int, unit_cm: float = 10.0) -> StepField:
    recipe = Recipe(seed=seed, chunk_size=8, boundary="none", unit_cm=unit_cm, obstacles=[Random(levels=5)])
    return rsegen.build(recipe)


def all_around(field: StepField, noise: float, seed: int = 1) -> Array:
    """Points that trimesh spreads over a field and the floor around it, with noise [m], turned."""
    made, rng = rsegen.mesh(field), np.random.default_rng(seed)
    surface = trimesh.Trimesh(made.vertices, made.triangles, process=False)
    on_blocks, faces = trimesh.sample.sample_surface(surface, int(DENSE * surface.area), seed=seed)
    assert np.mean(np.abs(surface.face_normals[faces, 2]) < 0.5) > 0.5  # sides
    floor = np.column_stack([(rng.random((DENSE, 2)) - 0.5) * 2 * field.extent, np.zeros(DENSE)])
    around = np.pad(field.levels, 8)
    x, y = np.floor(floor[:, :2] / field.block_width).astype(int).T + around.shape[0] // 2
    is_free = around[x, y] == 0
    points = np.concatenate([on_blocks, floor[is_free]])
    turn = trimesh.transformations.rotation_matrix(0.3 + seed, (0.05, 0, 1))[:3, :3]
    return np.asarray((points + rng.normal(0, noise, points.shape)) @ turn.T)


@pytest.mark.parametrize(("noise", "unit_cm"), [(0.0, 10.0), (0.003, 10.0), (0.0, 5.0)])
def test_all_blocks_are_right(noise: float, unit_cm: float) -> None:
    field = field_of(3, unit_cm)
    points = all_around(field, noise)
    with pytest.raises(ScanError):
        find_field(points)  # sides hide the grid
    scan = rsegen.scan(points).scan
    assert scan.seen.all()
    assert scan.block_width == 0.1
    assert scan.measured_width == pytest.approx(0.1, rel=0.003)
    assert any(np.array_equal(np.rot90(scan.levels, turns), field.levels) for turns in range(4))


def test_the_blocks_that_differ_are_named() -> None:
    field = field_of(4)
    levels = field.levels.astype(int)
    levels[2, 5], levels[7, 0] = 4 - levels[2, 5], (levels[7, 0] + 1) % 5
    differ = np.argwhere(levels != field.levels)
    wanted = rsegen.build(Recipe(chunk_size=8, boundary="none", obstacles=[Matrix(rows=levels.T[::-1].tolist())]))
    assert np.array_equal(wanted.levels, levels)
    compared = rsegen.compare(all_around(field, 0.002), wanted).comparison
    assert compared.seen.all()
    assert np.array_equal(np.argwhere(compared.wrong), differ)


def test_another_field_is_told_apart() -> None:
    with pytest.raises(ScanError, match="another map"):
        rsegen.compare(all_around(field_of(5), 0.0), field_of(6))


def test_points_of_sides_are_left_out_and_those_of_tops_are_not() -> None:
    rng = np.random.default_rng(2)
    ground = np.column_stack([rng.random((40_000, 2)), np.zeros(40_000)])
    top = np.column_stack([0.3 + 0.4 * rng.random((20_000, 2)), np.full(20_000, 0.2)])
    side = np.column_stack([np.full(9_000, 0.3), 0.3 + 0.4 * rng.random(9_000), 0.01 + 0.18 * rng.random(9_000)])
    left = without_sides(np.concatenate([ground, top, side]))
    assert np.array_equal(left[: len(ground) + len(top)], np.concatenate([ground, top]))
    assert len(left) - len(ground) - len(top) < 0.05 * len(side)
