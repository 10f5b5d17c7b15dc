"""A build sheet next to each world: `generate --sheet`."""

from __future__ import annotations

import os
from functools import partial
from pathlib import PurePosixPath
from typing import TYPE_CHECKING, Annotated, ClassVar

from rsegen.params.sorts import Flag
from rsegen.writing.sidecars import Sidecar

if TYPE_CHECKING:
    from rsegen.gazebo import Bundle
    from rsegen.recipe.recipe import Recipe
    from rsegen.scene.scene import Scene

_FILES = ("sheet.csv", "sheet.pdf")


class BuildSheet(Sidecar):
    """The build sheet of each map, as PDF and CSV."""

    name: ClassVar[str] = "sheet"
    parameter = Annotated[
        bool, Flag(help="add a build sheet, sheet.pdf and sheet.csv, to every map (see rsegen sheet)")
    ]

    def refuse(self, recipe: Recipe) -> None:
        """Raise a ParameterError if maps are too large for build sheets."""
        from rsegen.build_sheets.cut_settings import CutSettings
        from rsegen.build_sheets.document import refuse_unbuildable

        refuse_unbuildable(recipe, CutSettings.default(recipe.units))

    def files(self, scene: Scene) -> Bundle:
        """Return both files."""
        from rsegen.build_sheets.document import sheet

        # Made when they are written, and not in a dry run.
        return {PurePosixPath(name): map(partial(sheet, format=name[-3:]), [scene]) for name in _FILES}

    def are_in(self, home: str) -> bool:
        """Return whether the folder of a map has both."""
        return all(os.path.isfile(os.path.join(home, name)) for name in _FILES)

    def seconds(self, cells: int) -> float:
        """Return about how long both take: half a second each."""
        return 0.5 * len(_FILES)
