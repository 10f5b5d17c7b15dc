"""Parts of several formats rebuild the field, whatever it is."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given

from rsegen import StepField
from rsegen.formats.parts import groups
from rsegen.geometry import surface
from rsegen.geometry.box_merging import columns
from tests.formats.test_meshes import seen_from_above
from tests.support.strategies import fields


@given(field=fields())
def test_columns_are_the_heights_and_the_materials_and_do_not_overlap(field: StepField) -> None:
    (x, y), heights = field.edges(), np.zeros(field.shape)
    materials = np.zeros(field.shape, dtype=int)
    for column in columns(field):
        low, high = (np.array(column.centre) + side * np.array(column.size) / 2 for side in (-1, 1))
        assert abs(low[2]) < 1e-12
        middle_x, middle_y = (x[:-1] + x[1:]) / 2, (y[:-1] + y[1:]) / 2
        inside = np.outer((low[0] < middle_x) & (middle_x < high[0]), (low[1] < middle_y) & (middle_y < high[1]))
        assert not heights[inside].any()
        heights[inside], materials[inside] = high[2], column.material
    np.testing.assert_allclose(heights, field.heights, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(materials, field.levels)


@pytest.mark.slow
@given(field=fields())
def test_parts_of_one_colour_are_together_the_surface(field: StepField) -> None:
    from trimesh import Trimesh
    from trimesh.util import concatenate

    mesh = surface(field)
    parts = [(material, mesh.part(chosen)) for material, _, chosen in groups(mesh.materials)]
    assert [material for material, _ in parts] == sorted({material for material, _ in parts})
    for material, part in parts:
        assert set(part.materials) == {material}
        assert np.array_equal(np.unique(part.faces), np.arange(len(part.places)))
    meshes = [Trimesh(part.vertices, part.triangles, process=False) for _, part in parts]
    whole = concatenate(meshes) if meshes else Trimesh()
    np.testing.assert_allclose(seen_from_above(whole, field), field.heights, rtol=0, atol=1e-12)
    assert sum(len(part.faces) for _, part in parts) == len(surface(field).faces)
