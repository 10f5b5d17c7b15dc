"""The format `occupancy`: an occupancy grid of ROS, in which cells that are too high for a robot are occupied."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import ceil
from typing import Annotated, ClassVar

import numpy as np

from rsegen.errors import ParameterError
from rsegen.field.stepfield import StepField
from rsegen.formats.base import Format, Step, register
from rsegen.params.numbers import decimal
from rsegen.params.sorts import NANOMETRE_DIGITS, Float, Integer
from rsegen.scene.scene import Scene

_OCCUPIED, _FREE = 0, 254
"""Grey values of occupied and free cells, as map_server writes them."""

_MOST_PIXELS = 100_000_000
"""Pixels of an image with a margin, at the most: 100 MB."""


Climb = Annotated[
    float | None, Float(0, 100_000, unit="cm", help="cells higher than this are occupied; default: one unit")
]


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Occupancy(Format):
    """An occupancy grid for ROS map_server and Nav2 (map.yaml, map.pgm): cells too high to climb are occupied."""

    name: ClassVar[str] = "occupancy"
    also: ClassVar[tuple[str, ...]] = ("pgm", "costmap", "nav2", "map_server")
    step: ClassVar[Step] = "build"

    climb_cm: Climb = None
    margin_cm: Annotated[
        float, Float(0, 100_000, unit="cm", help="free ground around the map, rounded up to whole cells")
    ] = 0.0
    pixels: Annotated[int, Integer(1, 100, help="pixels along each side of a cell")] = 1

    @property
    def array_bytes(self) -> int:
        """Bytes of the pixels, for every cell."""
        return self.pixels**2

    def files(self, scene: Scene) -> Mapping[str, Iterable[bytes]]:
        """Return the image, north up, and its YAML metadata; the centre of the map is the origin of the world."""
        # The thresholds are those that map_saver writes; with mode `trinary` black is occupied and 254 is free.
        field, margin = scene.field, self.margin(scene.field)
        climb = field.unit if self.climb_cm is None else self.climb_cm / 100
        occupied = np.pad(
            field.heights > round(climb, NANOMETRE_DIGITS), margin
        )  # as heights are: 3 * 0.1 is not above 0.3
        grey = np.where(occupied, _OCCUPIED, _FREE).astype(np.uint8).T[::-1]
        rows = grey.repeat(self.pixels, axis=0).repeat(self.pixels, axis=1)
        x, y = (decimal(-side / 2 - margin * field.block_width) for side in field.extent)
        lines = [
            f"# {scene.name}: cells higher than {decimal(climb)} m above the ground are occupied; made by rsegen",
            "image: map.pgm",
            "mode: trinary",
            f"resolution: {decimal(field.block_width / self.pixels)}",
            f"origin: [{x}, {y}, 0]",
            "negate: 0",
            "occupied_thresh: 0.65",
            "free_thresh: 0.196",
        ]
        head = f"P5\n{rows.shape[1]} {rows.shape[0]}\n255\n"
        return {"map.yaml": ["\n".join([*lines, ""]).encode()], "map.pgm": [head.encode(), rows.tobytes()]}

    def margin(self, field: StepField) -> int:
        """Return the cells of free ground on each side; a ParameterError if the image would be too large."""
        margin = ceil(round(self.margin_cm / 100 / field.block_width, NANOMETRE_DIGITS))
        width, height = ((n + 2 * margin) * self.pixels for n in field.shape)
        if margin and width * height > _MOST_PIXELS:
            problem = f"{decimal(self.margin_cm)} cm around the map make an image of {width} x {height} pixels"
            raise ParameterError("margin_cm", f"{problem}; use less, so that it has up to {_MOST_PIXELS:,}")
        return margin
