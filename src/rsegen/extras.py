"""What a map has in its folder beside its world, where that is asked for: a picture, and formats of other programs."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import PurePosixPath

from rsegen.export import Bundle
from rsegen.formats import Format, added, bytes_a_cell, options, refuse_unready
from rsegen.params import Json
from rsegen.recipe import Recipe
from rsegen.scene import Scene


@dataclass(frozen=True, kw_only=True, slots=True)
class Extras:
    """A picture, and formats with their options."""

    preview: bool = False
    formats: Sequence[Format] = field(default=())

    def refuse(self, recipe: Recipe) -> None:
        """Raise a UserError where maps of a recipe cannot have them here."""
        refuse_unready(self.formats)

    def files(self, scene: Scene) -> Bundle:
        """The files that they are."""
        found = dict(added(scene, self.formats))
        if self.preview:
            from rsegen.drawing import picture

            found[PurePosixPath("preview.png")] = [picture(scene)]
        return found

    def stand(self, home: str) -> bool:
        """Whether a map's folder has its world, and all of them."""
        names = [f"{os.path.basename(home)}.world", *["preview.png"] * self.preview]
        if not all(os.path.isfile(os.path.join(home, name)) for name in names):
            return False
        there = _formats(home) if self.formats else {}
        return all(there.get(name) == said for name, said in options(self.formats).items())

    def seconds(self, cells: int) -> float:
        """About how long they take for a map of so many cells."""
        return 0.5 * self.preview + (5e-3 + cells * 3e-5) * len(self.formats)

    @property
    def bytes_a_cell(self) -> int:
        """Of memory."""
        return bytes_a_cell(self.formats)


def _formats(home: str) -> dict[str, Json]:
    """The formats that are there, with their options; none where the file that lists them is no such list."""
    try:
        with open(os.path.join(home, "formats.json"), "rb") as file:
            found = json.load(file)
    except (OSError, ValueError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}
