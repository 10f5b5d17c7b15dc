"""Import images: grey values, heights or depths, and occupancy maps of ROS as walls; one pixel per cell.

Grey values become max_height evenly spaced levels. Heights of terrain are whole numbers or floating-point ones, in a
unit that no image says; a pixel of the value that a GeoTIFF gives as no data is a hole. A depth camera that looks
straight down from a height c sees heights c - depth; 0 is a hole. An occupancy map (map.yaml and its image, as
map_server and Nav2 write them) has a wall where the probability, high for dark pixels, is above its threshold; its
transparent pixels are unknown. The size is checked before an image is decoded, as a small file may hold a huge one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar

from rsegen.errors import FileError, ParameterError
from rsegen.heights.base import CENTIMETRES, USUAL_UNIT_CM, Heights, Importer, refuse_too_many_cells, register
from rsegen.heights.measured import Measured
from rsegen.input_files import opened_image
from rsegen.params.sorts import Cell, Choice, Flag, Float, Integer, Parameter, Text, parameters

if TYPE_CHECKING:
    from PIL.Image import Image

    from rsegen.field.stepfield import Array, Ints


_WHITE_OF_16_BITS = 65535
"""The largest grey value of 16 bits; Pillow reads such images as 32-bit integers."""

_THEIR_UNIT = "values m, cm, mm or in if they are heights"

_OF_MEASURES = tuple(name for name in parameters(Measured) if name != "size")


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Picture(Measured):
    """A grey image, white the highest, or heights, or depths in mm; colours by brightness, transparent parts black."""

    name: ClassVar[str] = "image"
    suffixes: ClassVar[tuple[str, ...]] = (".png", ".jpg", ".jpeg", ".pgm", ".tif", ".tiff", ".bmp")

    levels: Annotated[int, Integer(2, 32767, unit="units", help="number of levels for the grey values")] = 5
    invert: Annotated[bool, Flag(help="black is the highest")] = False
    threshold: Annotated[
        float | None, Float(0, 100, unit="%", help="two levels only: the highest for grey values from this on, else 0")
    ] = None
    values: Annotated[
        str,
        Choice(
            ("grey", *CENTIMETRES, "depth"),
            help="meaning of the pixels: grey, shares of the highest level; cm, mm, m or in, heights in this unit; "
            "depth, distances in mm from a level camera, 0 for none",
        ),
    ] = "grey"
    camera_cm: Annotated[
        float | None, Float(0.1, 100_000, unit="cm", help="height of the camera above the ground, for depth")
    ] = None

    def __post_init__(self) -> None:
        Measured.__post_init__(self)
        if (self.values == "depth") != (self.camera_cm is not None):
            raise ParameterError("camera_cm", "the height of the camera is needed with values: depth, and only there")
        given = [name for name in _OF_MEASURES if self.values == "grey" and getattr(self, name)]
        if given:
            raise ParameterError(given[0], "is for heights and depths (values: mm, m, ...); grey values have no unit")

    def read(self, path: Path, unit_cm: float | None) -> Heights:
        """Return the heights of an image, whose size is checked before it is decoded."""
        if self.values != "grey":
            return self.measured(path, self._heights_cm(path), unit_cm or USUAL_UNIT_CM)
        grey = brightness(path, self.size)
        return Heights(levels=self._levels(1 - grey if self.invert else grey), unit_cm=unit_cm or USUAL_UNIT_CM)

    def _heights_cm(self, path: Path) -> Array:
        """Return the heights of all pixels, shape (n_x, n_y); nan where a depth camera saw nothing, or for no data."""
        import numpy as np

        with opened_image(path) as image:
            refuse_too_many_cells(path, *image.size)
            if not image.mode.startswith(("I", "F")):
                kinds = "a greyscale image of 16 bits or floating-point numbers"
                raise FileError(f"{path}: {image.mode} pixels; heights and depths need {kinds}")
            numbers = np.asarray(image.convert("F" if image.mode == "F" else "I"), dtype=np.float64)[::-1].T
            none = _no_data(image)
        if none is not None:
            numbers = np.where(np.isclose(numbers, none, rtol=1e-6, atol=0), np.nan, numbers)
        if self.camera_cm is None:
            return numbers * CENTIMETRES[self.values]
        return np.where(numbers == 0, np.nan, self.camera_cm - numbers / 10)

    def _levels(self, grey: Array) -> Ints:
        import numpy as np

        top = self.levels - 1
        if self.threshold is not None:
            return np.where(grey * 100 >= self.threshold, top, 0)
        return np.floor(grey * top + 0.5 + 1e-9).astype(np.int32)  # halves up, whatever the last bit of a share is


def brightness(path: Path, size: Cell | None = None) -> Array:
    """Return the brightness of an image, 0 black and 1 white, shape (n_x, n_y), resampled to a size if one is given."""
    import numpy as np
    from PIL.Image import Resampling

    with opened_image(path) as image:
        refuse_too_many_cells(path, *image.size)
        refuse_too_many_cells(path, *(size or image.size))
        grey, white = _grey(path, image)
        grey = grey.resize(size, Resampling.BOX) if size else grey  # to the mean of the pixels in a cell
        return (np.asarray(grey, dtype=np.float64) / white)[::-1].T


_NO_DATA = 42113
"""The tag of a GeoTIFF with the value of pixels that have none, as a text (GDAL_NODATA)."""


def _no_data(image: Image) -> float | None:
    """Return the value of pixels without data in an image, None if it gives none."""
    text = getattr(image, "tag_v2", {}).get(_NO_DATA)
    try:
        return float(str(text).strip("\x00 "))
    except ValueError:
        return None


def _grey(path: Path, image: Image) -> tuple[Image, float]:
    """Return the image as numbers, and the value of white. Resampling needs 32-bit integers or floats."""
    if image.mode == "F":
        low, high = image.getextrema()
        raise FileError(f"{path}: floating-point numbers of {low:g}..{high:g} have no white; give {_THEIR_UNIT}")
    if image.mode.startswith("I"):
        grey = image.convert("I")
        low, high = grey.getextrema()
        if not 0 <= low <= high <= _WHITE_OF_16_BITS:  # type: ignore[operator]  # one band has two numbers
            raise FileError(f"{path}: grey values of {low}..{high}; give an image of 8 or 16 bits, or {_THEIR_UNIT}")
        return grey.convert("F"), float(_WHITE_OF_16_BITS)
    if "A" in image.getbands() or "transparency" in image.info:
        from PIL import Image

        image = image.convert("RGBA")
        image = Image.alpha_composite(Image.new("RGBA", image.size, "black"), image)
    return image.convert("L").convert("F"), 255.0


_WALL_CM = 100.0
"""Height of a wall if no unit is given: higher than any robot here climbs."""

# The keys of map.yaml, and Nav2's own defaults of those that may be missing.
_KEYS: dict[str, Parameter] = {
    "image": Text(r"[^\x00-\x1f]{1,500}", "the path of an image"),
    "resolution": Float(1e-5, 1000, unit="m"),
    "mode": Choice(("trinary", "scale", "raw")),
    "negate": Integer(0, 1),
    "occupied_thresh": Float(0, 1),
    "free_thresh": Float(0, 1),
}
_USUAL = {"mode": "trinary", "negate": 0, "occupied_thresh": 0.65, "free_thresh": 0.25}

_OPAQUE = 0.5
"""Share from which on a pixel is seen: below it, it is transparent, and its cell unknown."""


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class OccupancyImage(Importer):
    """A map of ROS (map_server, Nav2): occupied cells become walls of one unit, 100 cm if none is said."""

    name: ClassVar[str] = "occupancy map"
    suffixes: ClassVar[tuple[str, ...]] = (".yaml", ".yml")

    unknown: Annotated[bool, Flag(help="also make walls of unknown cells")] = False

    def read(self, path: Path, unit_cm: float | None) -> Heights:
        """Return walls for cells whose probability, high for dark pixels, is above `occupied_thresh`."""
        import numpy as np

        from rsegen.recipe import recipe_file

        content = recipe_file.recipe_content(path)
        if not isinstance(content, Mapping):
            raise FileError(f"{path}: not an occupancy grid of ROS; it has keys such as image: and resolution:")
        values = {key: content.get(key, _USUAL.get(key)) for key in _KEYS}
        if isinstance(values["negate"], bool):  # as YAML writes it
            values["negate"] = int(values["negate"])
        try:
            metadata = {key: sort.check(key, values[key]) for key, sort in _KEYS.items()}
        except ParameterError as error:
            raise error.of(str(path)) from None
        # As map_server of ROS reads it. Dark is occupied, unless `negate`; between the thresholds is unknown, or with
        # the mode `scale` less probable. With `raw` the pixels are per cent, and unknown above 100.
        bright, opaque = _shades(path.parent / metadata["image"])
        probability = bright if metadata["negate"] else 1 - bright
        unknown = opaque < _OPAQUE
        if metadata["mode"] == "raw":
            probability = np.rint(bright * 255) / 100
            unknown |= probability > 1
        elif metadata["mode"] == "trinary":
            unknown |= (probability >= metadata["free_thresh"]) & (probability <= metadata["occupied_thresh"])
        walls = np.where(unknown, self.unknown, probability > metadata["occupied_thresh"])
        return Heights(
            levels=walls.astype(np.int32),
            unit_cm=unit_cm or _WALL_CM,
            recipe_values={"block_width_cm": round(metadata["resolution"] * 100, 6)},
        )


def _shades(path: Path) -> tuple[Array, Array]:
    """Return how bright the colours of an image are, and how opaque its pixels, 0 to 1, shape (n_x, n_y)."""
    import numpy as np

    with opened_image(path) as image:
        refuse_too_many_cells(path, *image.size)
        opaque, colours = np.ones(image.size), image.copy()
        if "A" in image.getbands() or "transparency" in image.info:
            opaque = np.asarray(image.convert("RGBA").getchannel("A"), dtype=np.float64)[::-1].T / 255
            colours = image.convert("RGBA").convert("RGB")
        grey, white = _grey(path, colours)
        return (np.asarray(grey, dtype=np.float64) / white)[::-1].T, opaque
