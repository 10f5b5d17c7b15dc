"""A field as Genesis's height field: spheres rest on the middles of its blocks."""

from __future__ import annotations

import pytest

import rsegen
from tests.support.late_import import LateImport

gs = LateImport("genesis", reason="Genesis is not installed: with PyTorch it is a download of gigabytes")
adapter = LateImport("rsegen.learning.genesis", reason="Genesis is not installed")

pytestmark = pytest.mark.long(reason="Genesis, which compiles its kernels for minutes")


def test_spheres_rest_on_blocks() -> None:
    gs.init(backend=gs.cpu, logging_level="warning")
    field = rsegen.build(
        rsegen.Recipe(seed=7, chunk_size=6, unit_cm=4, boundary="none", obstacles=[rsegen.Random(levels=4)])
    )
    scene, pos, radius = (
        gs.Scene(show_viewer=False, sim_options=gs.options.SimOptions(dt=0.005)),
        (1.0, -2.0, 0.3),
        0.02,
    )
    scene.add_entity(adapter.terrain_morph(field, pos), material=gs.materials.Rigid(friction=0.8))
    places = {
        (float(x) + pos[0], float(y) + pos[1]): float(field.heights[i, j]) + pos[2]
        for i, x in enumerate(field.middles()[0])
        for j, y in enumerate(field.middles()[1])
        if (i + 2 * j) % 5 == 0
    }
    assert len(set(places.values())) == 4
    spheres = {
        (x, y): scene.add_entity(gs.morphs.Sphere(radius=radius, pos=(x, y, top + radius + 0.01)))
        for (x, y), top in places.items()
    }
    scene.build()
    for _ in range(300):
        scene.step()
    for (x, y), top in places.items():
        assert spheres[x, y].get_pos().tolist() == pytest.approx([x, y, top + radius], abs=2e-4)
