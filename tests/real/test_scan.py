"""Depth cameras of a real Gazebo scan a map, and the scan gives the map back."""

from __future__ import annotations

import numpy as np
import pytest

import rsegen
from benchmarks.depth_camera import Flaws, turned, with_flaws
from benchmarks.gazebo_depth import depth_clouds
from rsegen import Random, Recipe
from rsegen.scanning.finding import find_field
from rsegen.simulators.base import Installation

pytestmark = pytest.mark.long(reason="two cameras without a graphics card")

RECIPE = Recipe(seed=5, boundary="outer", obstacles=(Random(levels=5),))
PLACES = ((0.6, 0.1, 2.2), (-0.5, -0.3, 2.2))


@pytest.mark.slow
@pytest.mark.usefixtures("screen")
def test_two_depth_cameras_give_back_every_block_that_they_see(gazebo_classic: Installation) -> None:
    field = rsegen.build(RECIPE, 0)
    rng = np.random.default_rng(1)
    clouds = depth_clouds(RECIPE, PLACES, gazebo_classic)
    with_camera = [(np.array(place), cloud) for place, cloud in zip(PLACES, clouds, strict=True)]
    for noise in (0.0, 0.005):
        cloud = with_flaws(with_camera, Flaws(noise=noise, missing=0.2, outliers=0.02), rng)
        scan = find_field(turned(cloud, rng), known=field)
        assert scan.seen.mean() > 0.95
        assert (scan.levels == field.levels)[scan.seen].all()
        free = find_field(turned(cloud, rng))
        assert (free.boundary, free.block_width, free.unit) == ("outer", 0.1, 0.1)
