"""Texture coordinates: every block shows one tile, on its top and down its sides."""

from __future__ import annotations

import numpy as np
import pytest

from rsegen import StepField, compose
from rsegen.geometry import TILES, Mesh, surface, texture_coordinates, unmerged, watertight
from tests.formats.maps import RECIPES

FIELDS = {name: compose(recipe).field for name, recipe in RECIPES.items()}
KINDS = {"merged": surface, "watertight": watertight, "blocks": unmerged}


def cells(mesh: Mesh, field: StepField) -> np.ndarray:
    """The corners of all faces, (m, 3 or 4, 2), in cells from the corner of the field."""
    low = np.array([edges[0] for edges in field.edges()])
    return np.asarray((mesh.vertices[mesh.faces][..., :2] - low) / field.block_width)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", FIELDS)
def test_each_top_shows_the_tile_of_its_cell(kind: str, name: str) -> None:
    field = FIELDS[name]
    mesh = KINDS[kind](field)
    found = texture_coordinates(mesh, field)
    tops = (mesh.normals >= 4) & (mesh.materials > 0)
    shift = np.outer(mesh.materials[tops], (3, 5))[:, None]
    tiles = found.values[found.corners[tops]] - cells(mesh, field)[tops] - shift
    assert np.allclose(np.round(tiles / TILES), tiles / TILES, atol=1e-6)
    assert np.allclose(tiles, tiles[:, :1])


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", FIELDS)
def test_each_side_begins_at_the_top_of_its_block_and_has_the_column_of_its_cell(kind: str, name: str) -> None:
    field = FIELDS[name]
    mesh = KINDS[kind](field)
    found = texture_coordinates(mesh, field)
    sides = (mesh.normals < 4) & (mesh.materials > 0)
    across = np.where(mesh.normals[sides, None] < 2, *cells(mesh, field)[sides].transpose(2, 0, 1)[::-1])
    height = mesh.vertices[mesh.faces][sides][..., 2]
    u, v = found.values[found.corners[sides]].transpose(2, 0, 1)
    columns = (u - across - 3 * mesh.materials[sides, None]) / TILES
    assert np.allclose(columns, np.round(columns), atol=1e-6)
    assert np.allclose(v, (height - mesh.materials[sides, None] * field.unit) / field.block_width)


@pytest.mark.parametrize("name", FIELDS)
def test_textures_are_as_long_as_the_faces(name: str) -> None:
    """Of blocks and of frames, whose grain runs along them: nothing is stretched."""
    field = FIELDS[name]
    mesh = surface(field)
    found = texture_coordinates(mesh, field)
    corners, tiles = mesh.vertices[mesh.faces], found.values[found.corners]
    for step in (1, 2, 3):
        metres = np.linalg.norm(corners - np.roll(corners, step, axis=1), axis=2)
        assert np.allclose(np.linalg.norm(tiles - np.roll(tiles, step, axis=1), axis=2), metres / field.block_width)


def test_the_grain_of_frames_runs_along_them() -> None:
    field = FIELDS["frames round every chunk"]
    mesh = surface(field)
    found = texture_coordinates(mesh, field)
    tops = (mesh.materials == 0) & (mesh.normals == 4)
    sizes = np.ptp(mesh.vertices[mesh.faces[tops]], axis=1)[:, :2].max(axis=1) / field.block_width
    assert found.sides[tops].all()
    assert np.allclose(np.ptp(found.values[found.corners[tops]][..., 1], axis=1), sizes)
    walls = (mesh.materials == 0) & (mesh.normals < 4)
    depths = np.ptp(mesh.vertices[mesh.faces[walls]], axis=1)[:, 2] / field.block_width
    assert np.allclose(np.ptp(found.values[found.corners[walls]][..., 0], axis=1), depths)


def test_coordinates_do_not_grow_with_the_map() -> None:
    """A mesh of many blocks has few of them."""
    recipe = RECIPES["no frames, blocks of 8.5 cm"]
    field = compose(type(recipe)(seed=1, chunk_size=60, boundary="none", obstacles=recipe.obstacles)).field
    found = texture_coordinates(surface(field), field)
    assert len(found.values) < 400
    assert found.values.max() < TILES + 16
