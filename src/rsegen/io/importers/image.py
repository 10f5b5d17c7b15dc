"""Imports grey images: one pixel per cell, with vertical walls between heights."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np

from rsegen.errors import FileError
from rsegen.field.stepfield import Array, Ints
from rsegen.io.image_files import opened_image
from rsegen.io.importers.base import USUAL_UNIT_CM, Heights, Importer, refuse_too_many_cells, register
from rsegen.params.places import Cell, Size2D
from rsegen.params.sorts import Flag, Float, Integer

if TYPE_CHECKING:
    from PIL.Image import Image

_WHITE_OF_16_BITS = 65535


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Picture(Importer):
    """A grey image of 8 or 16 bits, white the highest; colours count by brightness, transparent parts as black."""

    name: ClassVar[str] = "image"
    suffixes: ClassVar[tuple[str, ...]] = (".png", ".jpg", ".jpeg", ".pgm", ".tif", ".tiff", ".bmp")

    max_height: Annotated[int, Integer(2, 32767, unit="units", help="number of levels that grey is rounded to")] = 5
    invert: Annotated[bool, Flag(help="black is the highest")] = False
    threshold: Annotated[
        float | None, Float(0, 100, unit="%", help="only two levels: the highest from this grey on, else 0")
    ] = None
    size: Annotated[
        Cell | None, Size2D(help="resample to this many cells along x and y; default: one pixel per cell")
    ] = None

    def read(self, path: Path, unit_cm: float | None) -> Heights:
        """Its size is looked at before it is decoded."""
        grey = brightness(path, self.size)
        return Heights(levels=self._levels(1 - grey if self.invert else grey), unit_cm=unit_cm or USUAL_UNIT_CM)

    def _levels(self, grey: Array) -> Ints:
        top = self.max_height - 1
        if self.threshold is not None:
            return np.where(grey * 100 >= self.threshold, top, 0)
        return np.floor(grey * top + 0.5 + 1e-9).astype(np.int32)


def brightness(path: Path, size: Cell | None = None) -> Array:
    """The brightness of an image, 0 black and 1 white, shape (n_x, n_y), resampled to a size if one is given."""
    with opened_image(path) as image:
        refuse_too_many_cells(path, *image.size)
        refuse_too_many_cells(path, *(size or image.size))
        grey, white = _grey(path, image)
        grey = grey.resize(size, _box()) if size else grey
        return (np.asarray(grey, dtype=np.float64) / white)[::-1].T


def _grey(path: Path, image: Image) -> tuple[Image, float]:
    """The image as numbers, and the value of white. Resampling needs 32-bit integers or floats."""
    if image.mode.startswith("I"):
        grey = image.convert("I")
        low, high = grey.getextrema()
        if not 0 <= low <= high <= _WHITE_OF_16_BITS:  # type: ignore[operator]  # one band has two numbers
            raise FileError(f"{path}: grey values of {low}..{high}; give an image of 8 or 16 bits")
        return grey.convert("F"), float(_WHITE_OF_16_BITS)
    if "A" in image.getbands() or "transparency" in image.info:
        from PIL import Image

        image = image.convert("RGBA")
        image = Image.alpha_composite(Image.new("RGBA", image.size, "black"), image)
    return image.convert("L").convert("F"), 255.0


def _box() -> int:
    """Resampling to the mean of the pixels in a cell."""
    from PIL import Image

    return Image.Resampling.BOX
