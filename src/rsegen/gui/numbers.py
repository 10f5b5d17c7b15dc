"""What a map is, in a line of numbers for the window."""

from __future__ import annotations

import numpy as np

from rsegen.scene import Scene
from rsegen.stepfield import StepField


def in_numbers(scene: Scene) -> str:
    """Size in cells and metres, blocks of each level, the largest step between neighbours in cm."""
    (n_x, n_y), (along_x, along_y) = scene.field.shape, scene.field.extent
    levels = ", ".join(f"{level}: {count:,}" for level, count in list(scene.field.level_counts().items())[:8])
    step = largest_step(scene.field) * 100
    return f"{n_x} x {n_y} cells, {along_x:g} x {along_y:g} m   blocks by level  {levels}   largest step {step:g} cm"


def largest_step(field: StepField) -> float:
    """The largest difference in height between neighbours, frames and the ground around included, metres."""
    around = np.pad(field.heights, 1)
    return round(max(float(np.abs(np.diff(around, axis=axis)).max()) for axis in (0, 1)), 9)
