"""What a map has beside its world, where that is asked for: a picture, a build sheet, files for other programs."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import PurePosixPath

from rsegen.exporters.formats import Format, added, bytes_a_cell, options, refuse_unready
from rsegen.exporters.gazebo import Bundle
from rsegen.exporters.pictures.preview import preview_image
from rsegen.exporters.scene import Scene
from rsegen.exporters.sheet import CutSettings, refuse_unbuildable, sheet
from rsegen.params.sorts import Json
from rsegen.recipe.recipe import Recipe

SHEETS = ("sheet.csv", "sheet.pdf")


@dataclass(frozen=True, kw_only=True, slots=True)
class Sidecars:
    """A picture, a build sheet, and formats of other programs with their options."""

    preview: bool = False
    sheet: bool = False
    formats: Sequence[Format] = field(default=())

    def refuse(self, recipe: Recipe) -> None:
        """Raise a UserError where maps of a recipe cannot have them here."""
        refuse_unready(self.formats)
        if self.sheet:
            refuse_unbuildable(recipe, CutSettings())

    def files(self, scene: Scene) -> Bundle:
        """The files that they are."""
        found = dict(added(scene, self.formats))
        for name, made in self._made.items():
            found[PurePosixPath(name)] = [made(scene)]
        return found

    def stand(self, home: str) -> bool:
        """Whether a map's folder has its world, and all of them."""
        names = [f"{os.path.basename(home)}.world", *self._made]
        if not all(os.path.isfile(os.path.join(home, name)) for name in names):
            return False
        there = _formats(home) if self.formats else {}
        return all(there.get(name) == said for name, said in options(self.formats).items())

    def seconds(self, cells: int) -> float:
        """About how long they take for a map of so many cells."""
        return 0.5 * len(self._made) + (5e-3 + cells * 3e-5) * len(self.formats)

    @property
    def bytes_a_cell(self) -> int:
        """Of memory."""
        return bytes_a_cell(self.formats)

    @property
    def _made(self) -> Mapping[str, Callable[[Scene], bytes]]:
        """What makes each file but those of formats, by its name."""
        preview = {"preview.png": preview_image} if self.preview else {}
        return preview | ({name: partial(sheet, format=name[-3:]) for name in SHEETS} if self.sheet else {})


def _formats(home: str) -> dict[str, Json]:
    """The formats that are there, with their options; none where the file that lists them is no such list."""
    try:
        with open(os.path.join(home, "formats.json"), "rb") as file:
            found = json.load(file)
    except (OSError, ValueError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}
