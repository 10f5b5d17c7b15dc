"""Where a command draws its picture, refused before anything else is done."""

from __future__ import annotations

from pathlib import Path

from rsegen.exporters.pictures.preview import image_format
from rsegen.run.store import refuse_taken_file


def picture_path(name: str | None, *, force: bool) -> Path | None:
    """The path of a picture if one is wanted; a UserError if it is no picture or may not be replaced."""
    if name is None:
        return None
    path = Path(name)
    image_format(path)
    refuse_taken_file(path, force=force)
    return path
