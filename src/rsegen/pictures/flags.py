"""The flag for a picture that a command draws besides its report."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, NamedTuple

from rsegen.params.command import Shell
from rsegen.params.sorts import FilePath

PictureName = Annotated[str | None, FilePath("a picture"), Shell(("-o", "--output"), "PICTURE")]
"""The flag for a picture that a command draws besides its report; each says of what."""


class PictureRequest(NamedTuple):
    """A picture that a command is asked for; `picture_of` has found that its name is one, and may be written."""

    path: Path
    force: bool

    def write(self, draw: Callable[[str], bytes]) -> None:
        """Write what `draw` makes for the image format of the name."""
        from rsegen.pictures.preview import image_format
        from rsegen.writing.store import write_file

        write_file([draw(image_format(self.path))], self.path, force=self.force)


def picture_of(name: str | None, *, force: bool | None) -> PictureRequest | None:
    """Return the picture of a name if one is wanted; a UserError if it is no picture or may not be replaced."""
    from rsegen.pictures.preview import image_format
    from rsegen.writing.store import refuse_taken_file

    if name is None:
        return None
    picture = PictureRequest(Path(name), bool(force))
    image_format(picture.path)
    refuse_taken_file(picture.path, force=picture.force)
    return picture
