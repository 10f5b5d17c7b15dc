"""Import images: grey values, heights or depths, and occupancy maps of ROS as walls; one pixel per cell.

Grey values become evenly spaced levels; a cell of another size than a pixel has the mean of the area that it covers,
exactly. Where an image is transparent nothing is known. Heights of terrain are whole numbers or floating-point ones, in
a unit that no image says; a pixel without data in a GeoTIFF is a hole. A depth camera that looks straight down from a
height c sees heights c - depth; 0 is a hole. An occupancy map (map.yaml and its image, as
map_server and Nav2 write them) has a wall where the probability, high for dark pixels, is above its threshold. The size
is checked before an image is decoded, as a small file may hold a huge one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar

from rsegen.errors import FileError, ParameterError
from rsegen.heights import geotiff
from rsegen.heights.base import USUAL_UNIT_CM, Heights, Importer, refuse_too_many_cells, register
from rsegen.heights.coordinate_system import CellSides
from rsegen.heights.image_files import numbers_of, opened_image
from rsegen.heights.measured import Measured
from rsegen.params.sorts import CENTIMETRES, Cell, Choice, Flag, Float, Integer, Parameter, Size2D, Text, parameters

if TYPE_CHECKING:
    from PIL.Image import Image

    from rsegen.field.stepfield import Array, Ints


_WHITE_OF_16_BITS = 65535
"""The largest grey value of 16 bits; Pillow reads such images as 32-bit integers."""

_THEIR_UNIT = "values m, cm, mm, in or ft if they are heights"

_OF_MEASURES = tuple(name for name in parameters(Measured) if name != "size")


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Picture(Measured):
    """A grey image, white the highest, or heights, or depths; colours by brightness, transparent unknown."""

    name: ClassVar[str] = "image"
    suffixes: ClassVar[tuple[str, ...]] = (".png", ".jpg", ".jpeg", ".pgm", ".tif", ".tiff", ".bmp")

    levels: Annotated[int, Integer(2, 32767, help="number of levels for the grey values")] = 5
    invert: Annotated[bool, Flag(help="black is the highest")] = False
    threshold: Annotated[
        float | None, Float(0, 100, unit="%", help="two levels only: the highest for grey values from this on, else 0")
    ] = None
    framed: Annotated[
        Cell | None,
        Size2D(
            help="blocks inside each frame along x and y, if the image has cells of frames: these are left out, and "
            "frames stand in their place"
        ),
    ] = None
    values: Annotated[
        str,
        Choice(
            ("grey", *CENTIMETRES, "depth"),
            help="meaning of the pixels: grey, shares of the highest level; cm, mm, m, in or ft, heights in this unit; "
            "depth, distances from a level camera in mm, or m if they are floating-point numbers, 0 for none",
        ),
    ] = "grey"
    camera_cm: Annotated[
        float | None, Float(0.1, 100_000, unit="cm", help="height of the camera above the ground, for depth")
    ] = None

    def __post_init__(self) -> None:
        Measured.__post_init__(self)
        if (self.values == "depth") != (self.camera_cm is not None):
            raise ParameterError("camera_cm", "the height of the camera is needed with values: depth, and only there")
        misplaced = [name for name in _OF_MEASURES if self.values == "grey" and getattr(self, name)]
        if misplaced:
            raise ParameterError(
                misplaced[0], "is for heights and depths (values: mm, m, ...); grey values have no unit"
            )
        if self.framed and self.values != "grey":
            raise ParameterError("framed", "is for values: grey, as the format heightmap writes them")

    def read(self, path: Path, unit_cm: float | None) -> Heights:
        """Return the heights of an image, whose size is checked before it is decoded."""
        if self.values != "grey":
            heights, cells, metres_up = self._heights_cm(path)
            measured = self.measured(path, heights, unit_cm or USUAL_UNIT_CM, cells=cells)
            return replace(measured, metres_up=metres_up)
        grey = brightness(path, self.size)
        levels = self._levels(1 - grey if self.invert else grey)
        recipe_values: dict[str, object] = {}
        if self.framed:
            levels, recipe_values = _without_frames(levels, self.framed)
        return Heights(levels=levels, unit_cm=unit_cm or USUAL_UNIT_CM, recipe_values=recipe_values)

    def _heights_cm(self, path: Path) -> tuple[Array, CellSides | None, float | None]:
        """Return the heights of all pixels, (n_x, n_y), nan where a depth camera saw nothing, or for no data.

        And, if the file says them, the sides of pixels, and metres of the unit of heights.
        """
        import numpy as np

        with opened_image(path) as image:
            refuse_too_many_cells(path, *image.size)
            if not image.mode.startswith(("I", "F")):
                kinds = "a greyscale image of 16 bits or floating-point numbers"
                raise FileError(f"{path}: {image.mode} pixels; heights and depths need {kinds}")
            cells, turn, depth_cm = geotiff.sides(path, image), geotiff.turn_of(image), _DEPTH_CM[image.mode == "F"]
            metres_up = geotiff.metres_up(path, image)
            heights = turn.of(_known_heights(path, image))[::-1].T  # rows from the north -> (x, y)
        if self.camera_cm is None:
            return heights * CENTIMETRES[self.values], cells, metres_up
        return np.where(heights == 0, np.nan, self.camera_cm - heights * depth_cm), cells, None

    def _levels(self, grey: Array) -> Ints:
        """Return the levels of grey values, -1 where they are not known."""
        import numpy as np

        top = self.levels - 1
        if self.threshold is not None:
            levels = np.where(grey * 100 >= self.threshold, top, 0.0)
        else:
            levels = np.floor(grey * top + 0.5 + 1e-9)  # halves up, whatever the last bit of a share is
        return np.where(np.isnan(grey), -1, levels).astype(np.int32)


_DEPTH_CM = (0.1, 100.0)
"""Centimetres of the depths in an image of whole numbers, and in one of floating-point numbers (REP 118 of ROS)."""


def _known_heights(path: Path, image: Image) -> Array:
    """Return the heights of the pixels of an image, (rows, columns), in its unit; nan without data."""
    import numpy as np

    numbers = numbers_of(image)
    holes = np.zeros(numbers.shape, dtype=bool)
    for value in (geotiff.no_data(image), image.info.get("transparency")):
        if isinstance(value, int | float):
            holes |= np.isclose(numbers, value, rtol=1e-6, atol=0)
    heights = geotiff.as_heights(path, image, numbers)
    geotiff.refuse_mask(path, image)
    return np.where(holes, np.nan, heights)


def _without_frames(levels: Ints, blocks: Cell) -> tuple[Ints, dict[str, object]]:
    """Return levels without the cells of frames of a cell around each rectangle of blocks, and what a recipe has then.

    ParameterError if they are not made of such rectangles.
    """
    import numpy as np

    (n_x, n_y), (m_x, m_y) = levels.shape, blocks
    if n_x % (m_x + 2) or n_y % (m_y + 2):
        problem = f"{m_x}x{m_y} blocks with frames are {m_x + 2} x {m_y + 2} cells, which do not divide {n_x} x {n_y}"
        raise ParameterError("framed", problem)
    # A frame is a cell before and a cell behind the blocks.
    inside = [0 < at % (side + 2) <= side for n, side in zip(levels.shape, blocks, strict=True) for at in range(n)]
    unframed = levels[np.ix_(inside[:n_x], inside[n_x:])]
    if levels.shape == (m_x + 2, m_y + 2):
        return unframed, {"boundary": "outer"}
    if m_x != m_y:
        raise ParameterError("framed", f"{m_x}x{m_y}: chunks are squares; use the blocks of one, as in 10x10")
    return unframed, {"boundary": "divided", "chunk_size": m_x}


_OPAQUE = 255
"""The largest opacity of a pixel."""

_LEAST_KNOWN = 0.5
"""Share of a cell that has to be opaque: with less it is unknown, as it would be made up of its smaller part."""


def brightness(path: Path, size: Sequence[int] | None = None, *, alike: bool = False) -> Array:
    """Return the brightness of an image, 0 black and 1 white, shape (n_x, n_y), resampled to a size if one is given.

    nan where it is unknown: more than half of a cell is transparent. Of others the opaque part counts, the more the
    more opaque it is. alike: red, green and blue count alike, not as bright as they look
    """
    import numpy as np

    with opened_image(path) as image:
        refuse_too_many_cells(path, *image.size)
        refuse_too_many_cells(path, *(size or image.size))
        turn = geotiff.turn_of(image)
        rows, white, opaque_rows = _grey(path, image, alike=alike)
        geotiff.refuse_mask(path, image)

    def means(of_pixels: Ints) -> Array:
        values = turn.of(of_pixels)[::-1].T
        return area_means(values, size) if size else values.astype(np.float64)

    if opaque_rows is None:
        return means(rows) / white
    # The mean of what is seen of a cell: each pixel counts by its opacity.
    weighted, opacity = means(rows * opaque_rows), means(opaque_rows)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(opacity >= _LEAST_KNOWN * _OPAQUE, weighted / opacity / white, np.nan)


def area_means(values: Ints, size: Sequence[int]) -> Array:
    """Return the means of values (n_x, n_y), whole numbers from 0 on, over the areas of fewer or more cells.

    Cells may end within a value's area, of which they then have a part. Sums are whole numbers, so exact: along an axis
    with m cells they count the m-th part of a value.
    """
    import numpy as np

    sums = values.astype(np.uint64)
    for axis, cells in enumerate(size):
        n = values.shape[axis]
        along = np.moveaxis(sums, axis, 0)
        # Cell k ends behind k * n / cells values: `whole` of them, and part / cells of the next. Sums up to there times
        # `cells` are whole numbers, and their differences are the sums of the cells.
        whole, part = np.divmod(np.arange(cells + 1, dtype=np.uint64) * np.uint64(n), np.uint64(cells))
        before = np.concatenate([np.zeros_like(along[:1]), np.cumsum(along, axis=0, dtype=np.uint64)])
        last = along[np.minimum(whole, n - 1)]  # of which the part at the end of a cell is 0
        up_to = before[whole] * np.uint64(cells) + last * part[:, None]
        sums = np.moveaxis(np.diff(up_to, axis=0), 0, axis)  # right even if sums of a whole image pass 64 bits
    return np.asarray(sums / float(values.size))


def _grey(path: Path, image: Image, *, alike: bool) -> tuple[Ints, float, Ints | None]:
    """Return an image as numbers in rows, the value of white, and its opacity, 0..255; None if all of it is opaque.

    Pixels without data, as a GeoTIFF may have, are transparent.
    """
    import numpy as np

    # Three kinds: floating-point numbers, which have no white; 16 bits; and 8 bits, grey or colours.
    none = geotiff.no_data(image)
    if image.mode == "F":
        low, high = image.getextrema()
        raise FileError(f"{path}: floating-point numbers of {low:g}..{high:g} have no white; set {_THEIR_UNIT}")
    if image.mode.startswith("I"):
        grey = np.asarray(image.convert("I"), dtype=np.int64)
        if not 0 <= grey.min() <= grey.max() <= _WHITE_OF_16_BITS:
            problem = f"grey values of {grey.min()}..{grey.max()}; use an image of 8 or 16 bits, or set {_THEIR_UNIT}"
            raise FileError(f"{path}: {problem}")
        clear = [value for value in (image.info.get("transparency"), none) if isinstance(value, int | float)]
        return grey, geotiff.white_of(image), ~np.isin(grey, clear) * _OPAQUE if clear else None
    opaque, bands = None, np.atleast_3d(np.asarray(image))
    if "A" in image.getbands() or "transparency" in image.info:
        image = image.convert("RGBA")
        opaque = np.asarray(image.getchannel("A"), dtype=np.int64)
        image = image.convert("RGB")
    if none is not None:
        opaque = np.where((bands == none).all(axis=2), 0, _OPAQUE if opaque is None else opaque)
    if alike:
        return np.asarray(image.convert("RGB"), dtype=np.int64).sum(axis=2), 3 * 255.0, opaque
    return np.asarray(image.convert("L"), dtype=np.int64), 255.0, opaque


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
        if isinstance(content, Mapping) and "obstacles" in content:
            raise FileError(f"{path}: a recipe, not an occupancy grid of ROS; generate makes worlds of it")
        if not isinstance(content, Mapping) or "image" not in content:
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
        image = path.parent / metadata["image"]
        if not image.exists() and (beside := path.parent / image.name).exists():
            raise FileError(f"{path}: image: {image} does not exist; set it to {beside.name}, which is in this folder")
        bright = brightness(image, alike=True)
        probability = bright if metadata["negate"] else 1 - bright
        unknown = np.isnan(bright)  # where it is transparent
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
