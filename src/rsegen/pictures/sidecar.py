"""A preview next to each world: `generate --preview`."""

from __future__ import annotations

import os
from pathlib import PurePosixPath
from typing import TYPE_CHECKING, Annotated, ClassVar

from rsegen.params.sorts import Flag
from rsegen.writing.sidecars import Sidecar

if TYPE_CHECKING:
    from rsegen.gazebo import Bundle
    from rsegen.scene.scene import Scene

_FILE = "preview.png"


class Preview(Sidecar):
    """A picture of each map."""

    name: ClassVar[str] = "preview"
    parameter = Annotated[bool, Flag(help=f"add a picture, {_FILE}, to every map")]

    def files(self, scene: Scene) -> Bundle:
        """Return the picture."""
        from rsegen.pictures.preview import preview

        return {PurePosixPath(_FILE): map(preview, [scene])}  # drawn when it is written, and not in a dry run

    def are_in(self, home: str) -> bool:
        """Return whether the folder of a map has it."""
        return os.path.isfile(os.path.join(home, _FILE))
