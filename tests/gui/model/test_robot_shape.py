"""Robots as solids that the 3D view can draw."""

from __future__ import annotations

import numpy as np
import pytest

from rsegen.gui.model.reach import place_next_to
from rsegen.gui.model.simulation import robot_names, robot_shape

BOUNDS = (-2.0, 2.0, -1.0, 1.0, 0.0, 0.4)


@pytest.mark.parametrize("name", robot_names())
def test_a_robot_has_all_parts_and_stands_on_the_ground(name: str) -> None:
    shape = robot_shape(name)
    lowest, highest = np.inf, -np.inf
    for sizes, pose, colour in shape.parts:
        half = {3: np.abs(pose[:3, :3]) @ np.array(sizes[:3]) / 2 if len(sizes) == 3 else None}.get(len(sizes))
        if half is None:
            along = np.abs(pose[:3, 2])
            half = np.full(3, sizes[0]) if len(sizes) == 1 else along * sizes[1] / 2 + sizes[0] * np.sqrt(1 - along**2)
        lowest, highest = min(lowest, pose[2, 3] - half[2]), max(highest, pose[2, 3] + half[2])
        assert np.allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3))
        assert all(0 <= part <= 1 for part in colour)
    assert lowest == pytest.approx(0, abs=0.005)
    assert highest == pytest.approx(shape.size[2], rel=0.35)


def test_a_robot_stands_next_to_the_map_and_does_not_overlap_it() -> None:
    shape = robot_shape("jackal")
    x, y = place_next_to(BOUNDS, 0.2, shape)
    assert x - shape.size[0] / 2 == pytest.approx(2.1)
    assert y + shape.size[1] / 2 == pytest.approx(-1.1)
