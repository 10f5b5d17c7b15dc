"""Read the tags of a GeoTIFF: which pixels have data, what height a number is, and where pixels are.

A pixel has no data if it has the value for this (a tag of GDAL). A mask of pixels, which is one more image of the file
(TIFF 6.0, NewSubfileType 4), is refused. Files of whole numbers may say by which factor and sum these become heights
(GDAL_METADATA). Where pixels are decides the width of blocks and which way up the image is: rows need not go from north
to south. What breaks it: a grid that is turned by no quarter turn, which is read along its own axes.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from rsegen.errors import FileError
from rsegen.heights.coordinate_system import IN_METRES, METRES, CellSides, CoordinateSystem, of_keys, refuse_distorted
from rsegen.input_files import xml_root

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

    import numpy as np
    from numpy.typing import NDArray
    from PIL.Image import Image

    from rsegen.field.stepfield import Array

_NO_DATA, _METADATA = 42113, 42112
"""Tags of GDAL: the value of pixels that have no data, and an XML text with factors, both as texts."""

_SCALE, _CORNER, _MATRIX, _GEO_KEYS, _DOUBLES = 33550, 33922, 34264, 34735, 34736
"""Tags of a GeoTIFF: sides of a pixel; the place of one; or a matrix (4, 4) from pixels to places; and its keys."""

_KIND, _OF_MASK = 254, 4
"""The tag with the kind of an image of a TIFF, and its bit for a mask."""

_MOST_IMAGES = 32
"""Images of a file at most among which a mask is looked for: smaller copies have half of the size each."""

_BITS = 258
"""The tag with the bits of a number."""

_ORIENTATION = 0x0112
"""The tag of Exif that says which way up an image is."""


_Number = TypeVar("_Number", bound="np.generic")


class Turn(NamedTuple):
    """Turn that makes an image upright: rows and columns are swapped, then rows and columns reversed."""

    swapped: bool = False
    rows: bool = False
    columns: bool = False

    def of(self, rows: NDArray[_Number]) -> NDArray[_Number]:
        """Return an image (rows, columns) upright."""
        swapped = rows.T if self.swapped else rows
        return swapped[:: -1 if self.rows else 1, :: -1 if self.columns else 1]


_TURNS = {
    2: Turn(columns=True),
    3: Turn(rows=True, columns=True),
    4: Turn(rows=True),
    5: Turn(swapped=True),
    6: Turn(swapped=True, columns=True),
    7: Turn(swapped=True, rows=True, columns=True),
    8: Turn(swapped=True, rows=True),
}
"""Turns that make an image upright, by its orientation in Exif (CIPA DC-008)."""


def turn_of(image: Image) -> Turn:
    """Return how an image becomes upright, as viewers show it; of a GeoTIFF with north up, and east to the right."""
    import numpy as np

    matrix = _matrix(image)
    if image.format != "TIFF":  # which Pillow turns itself
        return _TURNS.get(image.getexif().get(_ORIENTATION, 1), Turn())
    if matrix is None:
        # GDAL takes y for descending whatever its sign is, as some programs write that wrongly.
        return Turn(columns=bool((np.ravel(_tags(image).get(_SCALE, ()))[:1] < 0).any()))
    # x and y per column and per row: the larger share of x says which of both runs east.
    (x_column, x_row), (y_column, y_row) = matrix[:2, :2].tolist()
    is_swapped = abs(x_row) > abs(x_column)
    east, south = (x_row, y_column) if is_swapped else (x_column, y_row)
    return Turn(is_swapped, south > 0, east < 0)


def _tags(image: Image) -> Mapping[int, Any]:
    """Return the tags of a TIFF, none of another image."""
    return getattr(image, "tag_v2", {})


def _matrix(image: Image) -> Array | None:
    """Return the matrix (4, 4) from pixels to places, None if the file has none."""
    import numpy as np

    matrix = np.ravel(_tags(image).get(_MATRIX, ()))
    return matrix.reshape(4, 4) if len(matrix) == 16 else None


def _system(image: Image) -> CoordinateSystem:
    """Return the units that the keys of a GeoTIFF say."""
    import numpy as np

    return of_keys(*(np.ravel(_tags(image).get(tag, ())).tolist() for tag in (_GEO_KEYS, _DOUBLES)))


def metres_up(path: Path, image: Image) -> float | None:
    """Return metres of the unit of heights by the metadata of GDAL or the keys of a file; None if it says none."""
    unit = next((item.text for role, item in _items(path, image) if role == "unittype"), None) or ""
    return METRES.get(unit.strip().lower(), _system(image).metres_up)


def sides(path: Path, image: Image) -> CellSides | None:
    """Return the sides of the pixels of an upright GeoTIFF, None of another image; FileError for distorted ones."""
    import numpy as np

    matrix, system = _matrix(image), _system(image)
    scale, corner = (np.ravel(_tags(image).get(tag, ())) for tag in (_SCALE, _CORNER))
    if matrix is not None:
        place, (x, y) = matrix[:2, 3], np.linalg.norm(matrix[:2, :2], axis=0)
        x, y = (y, x) if turn_of(image).swapped else (x, y)
    else:
        place, (x, y) = corner[3:5], np.abs(scale[:2]) if len(scale) >= 2 else (0, 0)
    longitude, latitude = place if len(place) == 2 else (np.nan, np.nan)
    refuse_distorted(path, system, (float(longitude), float(latitude)), IN_METRES)
    return CellSides(float(x), float(y), system.metres) if min(x, y) > 0 else None


def white_of(image: Image) -> float:
    """Return the number of white in an image of whole numbers up to 65535; a TIFF may have 12 bits for each."""
    bits: int = _tags(image).get(_BITS, (16,))[0]
    return float(2 ** min(bits, 16) - 1)


def no_data(image: Image) -> float | None:
    """Return the value of pixels without data in an image, None if it gives none."""
    text = _tags(image).get(_NO_DATA)
    try:
        return float(str(text).strip("\x00 "))
    except ValueError:
        return None


def refuse_mask(path: Path, image: Image) -> None:
    """Raise a FileError for a TIFF with a mask, as what is without data then is in another image of the file."""
    place, kind = 1, 0
    while image.format == "TIFF" and place < _MOST_IMAGES and not kind & _OF_MASK:
        try:
            image.seek(place)
        except EOFError:
            break
        except SyntaxError:  # Pillow knows no images of one bit that are masks, but has read what this one is
            pass
        kind, place = int(_tags(image).get(_KIND, 0)), place + 1
    image.seek(0)
    if kind & _OF_MASK:
        advice = "gdalwarp -ot Float32 -dstnodata -9999 FILE NEW.tif"
        raise FileError(f"{path}: has a mask of the pixels without data; write a value in their place with `{advice}`")


def as_heights(path: Path, image: Image, numbers: Array) -> Array:
    """Return the numbers of pixels as heights: by the factor and the sum that the file says, if it says any."""
    factors = {"scale": 1.0, "offset": 0.0}
    for role, item in _items(path, image):
        if role in factors:
            try:
                factors[role] = float(item.text or "")
            except ValueError:
                raise FileError(f"{path}: its {role} of heights, in GDAL_METADATA, is not a number") from None
    return numbers * factors["scale"] + factors["offset"]


def _items(path: Path, image: Image) -> Iterator[tuple[str, Element]]:
    """Yield the role and the item of each item of GDAL's metadata on the first band that has a role."""
    text = str(_tags(image).get(_METADATA, "")).strip("\x00 \n")
    for item in xml_root(text, f"{path}: GDAL_METADATA").iter("Item") if text else ():
        if item.get("role") and item.get("sample", "0") == "0":
            yield item.get("role", ""), item
