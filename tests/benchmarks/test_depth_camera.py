"""The ray caster, judged by MuJoCo's rays on the same field."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

import rsegen
from benchmarks.depth_camera import DepthCamera, Flaws, cast, scanned
from rsegen import Random, Recipe


@pytest.mark.parametrize("place", [(0.5, 0.2, 2.0), (1.6, -0.4, 0.7), (-0.2, 0.0, 1.5)])
def test_rays_go_as_far_as_mujoco_rays(place: tuple[float, float, float], tmp_path: Path) -> None:
    recipe = Recipe(seed=8, obstacles=(Random(levels=5),))
    rsegen.export(recipe, tmp_path / "map", "mjcf")
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "map" / "mjcf" / "scene.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    camera = DepthCamera(place=place, columns=60, rows=45, focal=50)
    rays = camera.directions()
    ours = cast(rsegen.build(recipe, 0), camera)
    geom = np.zeros(1, dtype=np.int32)
    theirs = np.array([mujoco.mj_ray(model, data, np.array(place), ray, None, 1, -1, geom) for ray in rays])
    met = np.isfinite(ours) & (theirs >= 0)
    assert met.sum() > 500
    assert np.abs(ours - theirs)[met].max() < 1e-6


def test_flaws_have_the_requested_size() -> None:
    recipe = Recipe(seed=8, obstacles=(Random(levels=5),))
    field = rsegen.build(recipe, 0)
    camera = DepthCamera(place=(0.0, 0.01, 2.0), columns=80, rows=60, focal=70)
    whole = scanned(field, [camera], Flaws(), np.random.default_rng(1))
    flawed = scanned(field, [camera], Flaws(noise=0.01, missing=0.25), np.random.default_rng(1))
    assert len(flawed) == pytest.approx(0.75 * len(whole), rel=0.05)
    floor = flawed[np.abs(flawed[:, 2]) < 0.04, 2]
    assert floor.std() == pytest.approx(0.01, rel=0.15)
