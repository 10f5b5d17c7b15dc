"""Pictures of a field that belongs to no recipe: a preview as large as a map's, and a small plan for notebooks."""

from __future__ import annotations

import io
from dataclasses import dataclass

import numpy as np

from rsegen.exporters.numbers import decimal
from rsegen.exporters.pictures.plan import Drawable, cell_colours
from rsegen.exporters.pictures.preview import encoded, preview_figure
from rsegen.exporters.scene import FRAME_COLOUR, Colour, level_colour
from rsegen.field.coarse import coarse, coarseness
from rsegen.field.stepfield import StepField

THUMBNAIL = 320
"""Pixels along the longer side of a small plan, at most."""


@dataclass(frozen=True, kw_only=True, slots=True)
class ColouredField:
    """A field with the default colours: frames red, levels from dark to light up to its own highest one."""

    field: StepField

    def colour(self, material: int) -> Colour:
        """The colour of a material: 0 is the frame, any other number a level."""
        return level_colour(material, int(self.field.levels.max())) if material else FRAME_COLOUR

    def surface_colour(self, material: int) -> Colour:
        """The same, in views."""
        return self.colour(material)


def field_preview(field: StepField, format: str = "png") -> bytes:  # noqa: A002  # matplotlib's word
    """The plan and the 3D view of a field as the bytes of an image file."""
    (n_x, n_y), (along_x, along_y) = field.shape, map(decimal, field.extent)
    title = f"{n_x} x {n_y} cells, {along_x} x {along_y} m"
    return encoded(preview_figure(ColouredField(field=field), title), format)


def thumbnail(drawn: Drawable) -> bytes:
    """A small plan as the bytes of a PNG file, north up; large fields show the highest of several cells."""
    from PIL import Image

    field = coarse(drawn.field, coarseness(drawn.field, THUMBNAIL))
    pixels = max(THUMBNAIL // max(field.shape), 1)
    colours = np.rint(255 * cell_colours(drawn.colour, field)).astype(np.uint8).transpose(1, 0, 2)[::-1]
    stream = io.BytesIO()
    Image.fromarray(colours.repeat(pixels, axis=0).repeat(pixels, axis=1)).save(stream, "png")
    return stream.getvalue()
