"""The format `heightmap`: a 16-bit greyscale image in which every level is a whole number of grey values."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from io import BytesIO
from typing import Annotated, ClassVar

import numpy as np

from rsegen.errors import ParameterError
from rsegen.field.stepfield import Ints, StepField
from rsegen.formats.base import Format, Step, register
from rsegen.formats.encoded import as_json, metadata
from rsegen.params.numbers import decimal
from rsegen.params.sorts import Integer, Json
from rsegen.recipe.codec import encode
from rsegen.recipe.recipe import Recipe
from rsegen.scene.scene import Scene

WHITE = 65535

_STEPS = [step for step in range(WHITE, 0, -1) if WHITE % step == 0]
"""The possible grey values per level: the divisors of white, so that white is a whole number of levels."""


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Heightmap(Format):
    """A greyscale image of the heights (PNG, 16 bits), exact to the level, north up, with its metadata as JSON."""

    name: ClassVar[str] = "heightmap"
    also: ClassVar[tuple[str, ...]] = ("png", "image", "tif", "tiff", "heightfield", "hfield", "dem")
    step: ClassVar[Step] = "build"

    pixels: Annotated[int, Integer(1, 100, help="pixels along each side of a cell")] = 1

    @property
    def array_bytes(self) -> int:
        """Bytes of the 16-bit pixels, for every cell."""
        return 2 * self.pixels**2

    def files(self, scene: Scene) -> Mapping[str, Iterable[bytes]]:
        """Return the image and its metadata."""
        from PIL import Image

        field, step, (n_x, n_y) = scene.field, sample_step(scene.field), scene.field.shape
        # Rows from north to south, as images have them. The metadata say how a program, and how rsegen, reads it again.
        greys, buffer = samples(field, step), BytesIO()
        rows = greys.T[::-1].repeat(self.pixels, axis=0).repeat(self.pixels, axis=1)
        Image.fromarray(rows).save(buffer, "png")
        lengths = f"--unit-cm {decimal(field.unit * 100)} --block-width-cm {decimal(field.block_width * 100)}"
        lengths += frames_again(scene.recipe)
        again = f"rsegen import {scene.name}.png --levels {WHITE // step + 1} --size {n_x}x{n_y} {lengths} -o DIR"
        about: dict[str, Json] = {
            **metadata(scene),
            "image": f"{scene.name}.png",
            "rows": "north up: the top row is the largest y, x grows to the right",
            "metres_per_pixel": field.block_width / self.pixels,
            "pixels_per_cell": self.pixels,
            "lower_left_corner_m": [-side / 2 for side in field.extent],
            "metres_per_grey": field.unit / step,
            "greys_per_level": step,
            "white_m": WHITE // step * field.unit,
            "largest_error_m": round(float(np.abs(greys * (field.unit / step) - field.heights).max()), 9),
            "import": again,
            "recipe": encode(scene.alone),
        }
        return {f"{scene.name}.png": [buffer.getvalue()], "heightmap.json": [as_json(about)]}


def frames_again(recipe: Recipe) -> str:
    """Return the flags by which an image of a map becomes its blocks and its frames; none without frames."""
    if recipe.boundary == "none":
        return ""
    # The blocks that a frame is around: of the whole map, or of each chunk.
    inside = recipe.grid.shape if recipe.boundary == "outer" else (recipe.chunk_size, recipe.chunk_size)
    framed = f"--framed {inside[0]}x{inside[1]} --boundary {recipe.boundary} --chunk-size {recipe.chunk_size}"
    return f" {framed} --frame-height-cm {decimal(recipe.frame_height_cm)}"


def sample_step(field: StepField) -> int:
    """Return the grey values per level: the largest divisor of white with which the highest block or frame fits."""
    frames = field.frame_height if field.frame.any() else 0.0
    levels = max(int(field.levels.max()), int(np.ceil(frames / field.unit - 1e-9)), 1)  # 1.1 / 0.1 is above 11
    if levels > WHITE:
        problem = f"frames of {decimal(field.frame_height * 100)} cm are higher than {WHITE} units of "
        raise ParameterError(
            "frame_height_cm", f"{problem}{decimal(field.unit * 100)} cm, the most that a heightmap can have"
        )
    return next(step for step in _STEPS if step * levels <= WHITE)


def samples(field: StepField, step: int) -> Ints:
    """Return the grey value of every cell, uint16 (n_x, n_y): level * step for blocks, the nearest value for frames."""
    frame = int(np.floor(field.frame_height / field.unit * step + 0.5)) if field.frame.any() else 0
    return np.where(field.frame, frame, field.levels.astype(np.int64) * step).astype(np.uint16)
