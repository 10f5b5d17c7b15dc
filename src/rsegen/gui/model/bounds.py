"""How much space a map takes in the 3D view, with the ground around it."""

from __future__ import annotations

from rsegen.exporters.scene import Scene
from rsegen.field.stepfield import StepField

Bounds = tuple[float, float, float, float, float, float]
"""Smallest and largest x, y and z, metres."""

_BORDER = 0.06


def bounds(scene: Scene) -> Bounds:
    """Smallest and largest x, y and z of a scene [m]; z up to the highest level that the recipe can have."""
    field = scene.field
    half_x, half_y = (side / 2 for side in field.extent)
    frame = field.frame_height if field.frame.any() else 0.0
    top = max(scene.recipe.top_level * field.unit, frame, float(field.heights.max(initial=0.0)), field.unit)
    return -half_x, half_x, -half_y, half_y, 0.0, top


def border(field: StepField) -> float:
    """The width of the ground around a map [m], a share of its longer side."""
    return _BORDER * max(field.extent)
