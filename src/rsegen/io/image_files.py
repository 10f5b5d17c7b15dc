"""Opens images that may come from anybody: few formats, one error, and no message of a library's own."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from rsegen.errors import FileError, RsegenError, said_by
from rsegen.io.input_files import open_regular
from rsegen.io.libraries import silent_libraries

if TYPE_CHECKING:
    from PIL.Image import Image

FORMATS = ("PNG", "JPEG", "PPM", "TIFF", "BMP")
"""Those of the names that an image may have, in Pillow's words; it knows fifty more, by their first bytes."""


@contextmanager
def opened_image(path: Path) -> Iterator[Image]:
    """An image of which only the header is read yet; any error in it, now or later, is a FileError."""
    from PIL import Image, UnidentifiedImageError

    try:
        with open_regular(path) as file, silent_libraries(), Image.open(file, formats=FORMATS) as image:
            yield image  # whoever opens it checks its size
    except RsegenError:
        raise
    except UnidentifiedImageError:
        raise FileError(f"{path}: not an image ({', '.join(FORMATS)})") from None
    except (Image.DecompressionBombError, MemoryError):
        raise FileError(f"{path}: an image too large to be read") from None
    except Exception as error:  # Pillow fails in many ways at values that cannot be
        said = getattr(error, "strerror", None) or f"not a whole image: {said_by(error)}"
        raise FileError(f"{path}: {said}") from None
