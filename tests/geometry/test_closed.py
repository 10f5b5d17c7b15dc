"""The closed mesh of squares: a closed surface of the volume of the blocks, whatever touches what."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given

import rsegen
from rsegen import StepField
from rsegen.geometry import NORMALS
from tests.support.strategies import fields

trimesh = pytest.importorskip("trimesh", reason="trimesh is not installed")


@given(fields())
def test_it_is_closed_and_has_the_volume_of_the_blocks(field: StepField) -> None:
    mesh = rsegen.mesh(field, "closed")
    found = trimesh.Trimesh(mesh.vertices, mesh.triangles, process=False)
    if not field.stands():
        assert len(mesh.faces) == 0
        return
    assert found.is_watertight
    assert found.is_winding_consistent
    assert found.volume == pytest.approx(field.heights.sum() * field.block_width**2)
    _, uses = np.unique(np.sort(found.edges, axis=1), axis=0, return_counts=True)
    assert set(uses) == {2}
    assert np.array_equal(np.unique(mesh.faces), np.arange(len(mesh.vertices)))


@given(fields())
def test_it_is_the_surface_of_the_watertight_mesh(field: StepField) -> None:
    mesh, fewer = rsegen.mesh(field, "closed"), rsegen.mesh(field, "watertight")
    areas = [
        [
            trimesh.Trimesh(one.vertices, one.triangles[_repeated(one.normals == normal, one)], process=False).area
            for normal in range(6)
        ]
        for one in (mesh, fewer)
    ]
    assert areas[0] == pytest.approx(areas[1])
    squares = mesh.vertices[mesh.faces]
    across = np.cross(squares[:, 1] - squares[:, 0], squares[:, 2] - squares[:, 1])
    assert np.array_equal(np.sign(np.round(across, 12)), NORMALS[mesh.normals])


def _repeated(which: np.ndarray, mesh: object) -> np.ndarray:
    """The mask of the triangles of these faces."""
    return np.repeat(which, len(mesh.triangles) // max(len(mesh.faces), 1))  # type: ignore[attr-defined]


@given(fields())
def test_every_side_has_the_material_of_its_block(field: StepField) -> None:
    mesh, blocks = rsegen.mesh(field, "closed"), rsegen.mesh(field, "blocks")
    for material in np.unique(blocks.materials):
        tops = (mesh.normals == 4) & (mesh.materials == material)
        assert tops.sum() == ((blocks.normals == 4) & (blocks.materials == material)).sum()
    assert set(mesh.materials) == set(blocks.materials)
