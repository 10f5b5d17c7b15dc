"""The colours of the map on the screen, as integers 0..255."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rsegen.exporters.numbers import decimal
from rsegen.exporters.scene import Scene

Bytes = NDArray[np.uint8]
Rgb = tuple[int, int, int]

GROUND: Rgb = (219, 219, 219)
"""Blocks of level 0: bare ground."""

_LEGEND_ROWS = 24
_LUMINANCE = (0.3, 0.59, 0.11)


def palette(scene: Scene) -> Bytes:
    """(highest level + 1, 3): the colour of each material, 0 the frame."""
    return np.array([rgb(scene, material) for material in range(scene.recipe.highest_level + 1)], dtype=np.uint8)


def surface_palette(scene: Scene) -> Bytes:
    """(highest level + 1, 3): the colour that the surface of each material has from afar, 0 the frame."""
    found = [scene.surface_colour(material) for material in range(scene.recipe.highest_level + 1)]
    return np.asarray(np.rint(np.minimum(found, 1) * 255).astype(np.uint8))


def rgb(scene: Scene, material: int) -> Rgb:
    """The colour of one material."""
    red, green, blue = (min(round(part * 255), 255) for part in scene.colour(material))
    return red, green, blue


def cells(scene: Scene) -> Bytes:
    """(n_x, n_y, 3): the colour of each cell; level ground is light grey."""
    known = palette(scene)
    inks = np.vstack([np.array(GROUND, dtype=np.uint8), known[1:], known[:1]])
    return inks[np.where(scene.field.frame, len(inks) - 1, scene.field.levels)]


def bright(colours: Bytes) -> NDArray[np.bool_]:
    """Which colours are bright, so that dark text is legible on them."""
    return np.asarray(colours @ _LUMINANCE >= 127.5)


def legend(scene: Scene) -> list[tuple[Rgb, str]]:
    """A colour and a name for every level of the map, at most 24 of them, the highest first; frames last."""
    levels = [level for level in scene.field.level_counts() if level]
    shown = levels[:: -(-len(levels) // _LEGEND_ROWS) or 1][::-1]
    rows = [(rgb(scene, level), centimetres(level * scene.field.unit)) for level in shown]
    if scene.field.frame.any():
        rows.append((rgb(scene, 0), f"frame, {centimetres(scene.field.frame_height)}"))
    return rows


def centimetres(metres: float) -> str:
    """A height in centimetres, as text."""
    return f"{decimal(round(metres * 100, 4))} cm"
