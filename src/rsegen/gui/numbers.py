"""What a map is and costs, in numbers for the window."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rsegen.exporters.map_summary import map_summary, warnings
from rsegen.exporters.scene import Scene
from rsegen.field.metrics.traversability import traversability
from rsegen.field.stepfield import StepField
from rsegen.gui.colours import GROUND, Rgb, centimetres, rgb
from rsegen.simulation.robots import ROBOTS

COUNTED = 100_000
"""The files of maps of up to so many cells are made to be counted."""


class Share(NamedTuple):
    """How many blocks have one height: its colour and its name."""

    colour: Rgb
    name: str
    blocks: int


class Costs(NamedTuple):
    """What a map costs in a few words, what to know of it before opening it, and whether a robot gets across."""

    text: str
    warnings: tuple[str, ...]
    crossing: str = ""


def in_numbers(scene: Scene) -> str:
    """Size in cells and metres, the largest step between neighbours in cm."""
    (n_x, n_y), (along_x, along_y) = scene.field.shape, scene.field.extent
    step = centimetres(largest_step(scene.field))
    return f"{n_x} x {n_y} cells, {along_x:g} x {along_y:g} m, largest step {step}"


def shares(scene: Scene) -> list[Share]:
    """The blocks of each level, from the lowest."""
    return [
        Share(rgb(scene, level) if level else GROUND, centimetres(level * scene.field.unit), count)
        for level, count in scene.field.level_counts().items()
    ]


def costs(scene: Scene, robot: str = "") -> Costs:
    """Models, faces and bytes of the files, where the map is not too large to make them; warnings always.

    Of a robot of some kind, whether it gets across. That there is nothing to see goes without saying where there are no
    obstacles yet.
    """
    said = warnings(scene) if scene.recipe.obstacles else ()
    n_x, n_y = scene.field.shape
    if n_x * n_y > COUNTED:
        return Costs("", said)
    found = map_summary(scene)
    models = f"{found.models:,} model{'s'[: found.models != 1]}"
    text = f"{models}, {found.faces:,} faces, {_size(found.bytes)}"
    return Costs(text, said, crossing(scene.field, robot) if robot else "")


def crossing(field: StepField, robot: str) -> str:
    """Whether a robot of some kind gets across, by the step that it climbs and its width, and how far it gets about."""
    found = traversability(field, ROBOTS[robot].climber)
    ways = {"west to east": found.west_east, "south to north": found.south_north}
    across = [name for name, way in ways.items() if way.crosses]
    return f"crosses {' and '.join(across)}" if across else f"does not cross; gets about on {found.cover:.0%} of it"


def largest_step(field: StepField) -> float:
    """The largest difference in height between neighbours, frames and the ground around included, metres."""
    around = np.pad(field.heights, 1)
    return round(max(float(np.abs(np.diff(around, axis=axis)).max()) for axis in (0, 1)), 9)


def _size(size: int) -> str:
    return f"{size / 1000:,.0f} kB" if size < 1e6 else f"{size / 1e6:,.1f} MB"
