"""Images in files, which may come from anybody: opened by their header, and read as the numbers that the file has."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from rsegen.errors import FileError, RsegenError, library_message
from rsegen.input_files import (
    file_type,
    open_regular,
    refuse_pointer,
    regular_content,
    silent_libraries,
    unreadable,
)

if TYPE_CHECKING:
    from PIL.Image import Image

    from rsegen.field.stepfield import Array

_IMAGE_FORMATS = ("PNG", "JPEG", "PPM", "TIFF", "BMP")
"""Formats of images that are read, as Pillow names them; it would open fifty more, by their first bytes."""


@contextmanager
def opened_image(path: Path) -> Iterator[Image]:
    """An image of which only the header is read yet; any error in it, now or later, is a FileError."""
    from PIL import Image, UnidentifiedImageError

    refuse_pointer(path)
    try:
        with open_regular(path) as file, silent_libraries(), Image.open(file, formats=_IMAGE_FORMATS) as image:
            yield image  # whoever opens it checks its size
    except RsegenError:
        raise
    except UnidentifiedImageError:
        if file_type(regular_content(path, 4) or b"") == "a TIFF image":
            advice = "write one of a single band with `gdal_translate -b 1 -ot Float32 FILE NEW.tif`"
            raise FileError(f"{path}: a TIFF whose bands or numbers are not read (Pillow); {advice}") from None
        raise FileError(f"{path}: not an image ({', '.join(_IMAGE_FORMATS)})") from None
    except (Image.DecompressionBombError, MemoryError):
        raise FileError(f"{path}: an image too large to be read") from None
    except Exception as error:  # Pillow fails in many ways at values that cannot be
        if isinstance(error, OSError) and error.strerror:
            raise FileError(unreadable(path, error)) from None
        raise FileError(f"{path}: not a whole image: {library_message(error)}") from None


_WHITE = {"L": 255, "I": 65535}
"""The grey value to which Pillow stretches the largest one of a PGM, by the mode of the image."""

_BITS, _SAMPLE_FORMAT, _UNSIGNED = 258, 339, 1
"""Tags of a TIFF: bits of a number, and its kind, which is unsigned if the tag is missing."""


def numbers_of(image: Image) -> Array:
    """Decode an image of one channel, and return its numbers as its file has them, (rows, columns).

    Pillow stretches a PGM to 8 or 16 bits, unless its own white is the largest number of these, and takes 32 bits for
    signed.
    """
    import numpy as np

    tags, tiles = getattr(image, "tag_v2", {}), getattr(image, "tile", ())
    numbers = np.asarray(image.convert("I") if image.mode.startswith("I") else image, dtype=np.float64)
    if image.format == "PPM" and tiles and tiles[0][0].startswith("ppm"):
        _, largest = tiles[0][3]
        return np.asarray(np.rint(numbers * (largest / _WHITE[image.mode])))
    if image.mode == "I" and tags.get(_BITS) == (32,) and tags.get(_SAMPLE_FORMAT, (_UNSIGNED,)) == (_UNSIGNED,):
        return np.where(numbers < 0, numbers + 2.0**32, numbers)
    return numbers
