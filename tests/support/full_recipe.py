"""A recipe that gives every parameter whose default is None."""

from __future__ import annotations

from rsegen import Recipe

FULL = Recipe(
    seed=1,
    frame_friction=0.4,
    level_friction=(0.9, 0.1),
    frame_colour="#102030",
    level_colours=("#ffffff", "#ABCDEF"),
    max_step=2,
    crossable_by=(20, 12.5, 10),
    inventory=(5, 0, 7),
)
