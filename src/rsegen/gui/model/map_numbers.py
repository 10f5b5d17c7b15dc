"""Size, level counts and costs of a map, as the window shows them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rsegen.exporters.map_summary import map_summary, warnings
from rsegen.exporters.scene import Scene
from rsegen.field.stepfield import StepField
from rsegen.gui.model.colours import GROUND, Rgb, centimetres, rgb
from rsegen.gui.model.reach import Reach
from rsegen.gui.model.simulation import reach

COUNTED = 100_000
"""Files are counted for maps of up to this many cells."""


class Share(NamedTuple):
    """How many blocks have one level, with the colour and name of the level."""

    colour: Rgb
    name: str
    blocks: int


class Costs(NamedTuple):
    """What a map costs in a few words, warnings about it, and what a robot can do on it."""

    text: str
    warnings: tuple[str, ...]
    reach: Reach | None = None


def size_text(scene: Scene) -> str:
    """The size of a map in cells and metres, and its largest step in cm."""
    (n_x, n_y), (along_x, along_y) = scene.field.shape, scene.field.extent
    step = centimetres(largest_step(scene.field))
    return f"{n_x} x {n_y} cells, {along_x:g} x {along_y:g} m, largest step {step}"


def shares(scene: Scene) -> list[Share]:
    """The block count of each level, from the lowest."""
    return [
        Share(rgb(scene, level) if level else GROUND, centimetres(level * scene.field.unit), count)
        for level, count in scene.field.level_counts().items()
    ]


def costs(scene: Scene, robot: str = "") -> Costs:
    """Warnings about a map, and unless it is too large: its models, faces and bytes, and what a robot can do on it.

    A map without obstacles gets no warning that it is empty.
    """
    found_warnings = warnings(scene) if scene.recipe.obstacles else ()
    n_x, n_y = scene.field.shape
    if n_x * n_y > COUNTED:
        return Costs("", found_warnings)
    found = map_summary(scene)
    models = f"{found.models:,} model{'s'[: found.models != 1]}"
    text = f"{models}, {found.faces:,} faces, {_size(found.bytes)}"
    return Costs(text, found_warnings, reach(scene.field, robot, scene.recipe.seed) if robot else None)


def largest_step(field: StepField) -> float:
    """The largest height difference between neighbouring cells [m], with frames and the ground around the map."""
    around = np.pad(field.heights, 1)
    return round(max(float(np.abs(np.diff(around, axis=axis)).max()) for axis in (0, 1)), 9)


def _size(size: int) -> str:
    return f"{size / 1000:,.0f} kB" if size < 1e6 else f"{size / 1e6:,.1f} MB"
