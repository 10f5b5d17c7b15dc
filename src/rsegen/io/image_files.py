"""Opens images that may come from anybody: few formats, one error, and no message of a library's own."""

from __future__ import annotations

import logging
import os
import warnings
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

from rsegen.errors import FileError, RsegenError, said_by
from rsegen.io.input_files import open_regular

if TYPE_CHECKING:
    from PIL.Image import Image

FORMATS = ("PNG", "JPEG", "PPM", "TIFF", "BMP")
"""Those of the names that an image may have, in Pillow's words; it knows fifty more, by their first bytes."""

_STDERR = 2


@contextmanager
def opened_image(path: Path) -> Iterator[Image]:
    """An image of which only the header is read yet; any error in it, now or later, is a FileError."""
    from PIL import Image, UnidentifiedImageError

    try:
        with ExitStack() as stack:
            file = stack.enter_context(open_regular(path))
            stack.enter_context(warnings.catch_warnings())
            warnings.simplefilter("ignore")  # its size is checked by whoever opens it
            stack.enter_context(_silent_libraries())
            yield stack.enter_context(Image.open(file, formats=FORMATS))
    except RsegenError:
        raise
    except UnidentifiedImageError:
        raise FileError(f"{path}: not an image ({', '.join(FORMATS)})") from None
    except (Image.DecompressionBombError, MemoryError):
        raise FileError(f"{path}: an image too large to be read") from None
    except Exception as error:  # Pillow fails in many ways at values that cannot be
        said = getattr(error, "strerror", None) or f"not a whole image: {said_by(error)}"
        raise FileError(f"{path}: {said}") from None


@contextmanager
def _silent_libraries() -> Iterator[None]:
    """No message of Pillow or libtiff, which writes straight to file descriptor 2."""
    logger = logging.getLogger("PIL")
    if not logger.handlers:
        logger.addHandler(logging.NullHandler())
    with ExitStack() as stack:
        with suppress(OSError):  # nobody hears them if there is no stderr
            before, nowhere = os.dup(_STDERR), os.open(os.devnull, os.O_WRONLY)
            stack.callback(_restore, before)
            os.dup2(nowhere, _STDERR)
            os.close(nowhere)
        yield


def _restore(before: int) -> None:
    os.dup2(before, _STDERR)
    os.close(before)
