"""Optional files in a map's folder, next to its world: a picture, a build sheet, files for other programs."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import PurePosixPath

from rsegen.errors import ParameterError
from rsegen.exporters.formats import Format, added, options, refuse_unready
from rsegen.exporters.gazebo import Bundle
from rsegen.exporters.scene import Scene
from rsegen.io.input_files import open_regular
from rsegen.params.sorts import Json
from rsegen.recipe.recipe import Recipe

SHEETS = ("sheet.csv", "sheet.pdf")
FORMATS_FILE = "formats.json"


@dataclass(frozen=True, kw_only=True, slots=True)
class Sidecars:
    """Which optional files maps get: a picture, a build sheet, formats of other programs with their options."""

    preview: bool = False
    sheet: bool = False
    formats: Sequence[Format] = field(default=())

    def refuse(self, recipe: Recipe) -> None:
        """Raise a UserError if they cannot be made of a recipe's maps, or need a package that is not installed."""
        refuse_unready(self.formats)
        for each in self.formats:
            if each.joins:
                problem = f"{each.joins} would hold every map, which rsegen export alone writes"
                raise ParameterError(f"formats: {each.name}", f"{problem}; export it, or leave out its name")
        if self.sheet:
            from rsegen.exporters.sheet import CutSettings, refuse_unbuildable

            refuse_unbuildable(recipe, CutSettings.default(recipe.units))

    def files(self, scene: Scene) -> Bundle:
        """Their content, by path in the map's folder."""
        found = dict(added(scene, self.formats))
        for name, make in self._makers.items():
            found[PurePosixPath(name)] = [make(scene)]
        return found

    def complete_in(self, home: str) -> bool:
        """Whether a map's folder has its world, and all of them."""
        names = [f"{os.path.basename(home)}.world", *self._makers]
        if not all(os.path.isfile(os.path.join(home, name)) for name in names):
            return False
        listed = (listed_formats(home) or {}) if self.formats else {}
        return all(listed.get(name) == wanted for name, wanted in options(self.formats).items())

    def seconds(self, cells: int) -> float:
        """About how long they take for a map with this many cells."""
        return 0.5 * len(self._makers) + (5e-3 + cells * 3e-5) * len(self.formats)

    @property
    def _makers(self) -> Mapping[str, Callable[[Scene], bytes]]:
        """The function that makes each file except those of formats, by its name."""
        found: dict[str, Callable[[Scene], bytes]] = {}
        if self.preview:
            from rsegen.exporters.pictures.preview import preview_image

            found["preview.png"] = preview_image
        if self.sheet:
            from rsegen.exporters.sheet import sheet

            found |= {name: partial(sheet, format=name[-3:]) for name in SHEETS}
        return found


def listed_formats(home: str) -> dict[str, Json] | None:
    """The formats in a map's folder with their options, from its formats.json; None if the file is damaged."""
    try:
        with open_regular(os.path.join(home, FORMATS_FILE)) as file:
            found = json.load(file)
    except FileNotFoundError:
        return {}
    except (OSError, ValueError, RecursionError):
        return None
    return found if isinstance(found, dict) else None
