"""The parts of a surface with one material and one texture each, for glb and usd."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from rsegen.exporters.formats.solid import Solid
from rsegen.exporters.gazebo.obj import PARTS
from rsegen.field.stepfield import Array, Ints, Mask


class TexturedPart(NamedTuple):
    """The triangles of a material with one texture, `top` or `side`: vertices (n, 3) in metres, coordinates (n, 2)."""

    material: int
    part: str
    vertices: Array
    coordinates: Array
    triangles: Ints


def textured_groups(found: Solid) -> Iterator[tuple[int, str, Mask]]:
    """Each material with each texture that it has, and its triangles as a mask."""
    for material in np.unique(found.materials).tolist():
        for part, sides in zip(PARTS, (~found.sides, found.sides), strict=True):
            chosen = (found.materials == material) & sides
            if chosen.any():
                yield material, part, chosen


def textured_parts(found: Solid) -> Iterator[TexturedPart]:
    """The triangles of each material and texture; a vertex is there once per pair of texture coordinates."""
    for material, part, chosen in textured_groups(found):
        places = found.vertices[found.triangles[chosen]]
        corners = np.concatenate([places, found.coordinates[chosen]], axis=2).reshape(-1, 5)
        known, numbers = np.unique(corners, axis=0, return_inverse=True)
        yield TexturedPart(material, part, known[:, :3], known[:, 3:], numbers.reshape(-1, 3))
