"""The lanes are where the robots drive, so that what is measured is equal blocks."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import replace
from math import cos, sin

import numpy as np
import pytest

from benchmarks.lanes import CHANGES, FLOOR, LANE, METRES, Lane, recipe, starts, summary
from rsegen.gazebo import export
from rsegen.scene.scene import compose


@pytest.mark.parametrize("ground", ["both", "classic", "plane"])
def test_every_block_within_reach_of_a_drive_is_of_the_lane_s_level(ground: str) -> None:
    field = compose(recipe(1, ground), 0).field
    x, y = field.edges()
    level = FLOOR if ground != "plane" else 0
    for _, start in starts(ground):
        assert start.z == pytest.approx(level * field.unit)
        for ahead in np.linspace(0, METRES, 50):
            for aside in (-LANE / 2 + 0.1, 0, LANE / 2 - 0.1):
                at_x = start.x + ahead * cos(start.yaw) - aside * sin(start.yaw)
                at_y = start.y + ahead * sin(start.yaw) + aside * cos(start.yaw)
                assert field.levels[np.searchsorted(x, at_x) - 1, np.searchsorted(y, at_y) - 1] == level
    assert (field.levels != level).any() == (ground != "plane")


def test_the_summary_counts_robots_that_did_not_come_on() -> None:
    lanes = [Lane(heading=0, aside=-3, ahead=2.2, shake=0.5), Lane(heading=45, aside=1, ahead=1, shake=0.1)]
    assert summary(lanes) == "2.00 (3.00) mm aside, 0.30 (0.50) mm up and down, 1 of 2 stuck"
    assert "stuck" not in summary([Lane(heading=0, aside=1, ahead=1.4, shake=0.1, commanded=1.43)])


@pytest.mark.parametrize("name", CHANGES)
def test_each_change_changes_the_map_as_its_name_says(name: str) -> None:
    change = CHANGES[name]
    files = export(compose(replace(recipe(1, "classic"), **change.recipe), 0))
    text = next(b"".join(content).decode() for path, content in files.items() if path.suffix == ".world")
    changed = change(text)
    if name == "none" or change.recipe:
        assert changed.count("<kd>1000</kd>") == text.count("<kd>1000</kd>") > 0
    else:
        assert all(part in changed for part in (change.contact, change.friction, change.solver))
        assert changed != text
    ET.fromstring(changed)  # ours
