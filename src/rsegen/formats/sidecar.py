"""Files for other programs next to each world: `generate --formats stl,mjcf`."""

from __future__ import annotations

import json
import os
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import TYPE_CHECKING, ClassVar

from rsegen.errors import ParameterError
from rsegen.formats.parameters import HELP_TEXT, Formats
from rsegen.input_files import open_regular
from rsegen.params.sorts import Json
from rsegen.writing.sidecars import Sidecar

if TYPE_CHECKING:
    from rsegen.formats.base import Format
    from rsegen.gazebo import Bundle
    from rsegen.params.command import HelpText
    from rsegen.recipe.recipe import Recipe
    from rsegen.scene.scene import Scene
    from rsegen.writing.resources import InMemory

FORMATS_FILE = "formats.json"
"""The file in a map's folder that lists the formats in it with their options."""


@dataclass(frozen=True, slots=True)
class FormatFiles(Sidecar):
    """The files of some formats for each map, in a folder for each format, and formats.json, which lists them."""

    name: ClassVar[str] = "formats"
    parameter: ClassVar[object] = Formats
    default: ClassVar[object] = ()
    help_text: ClassVar[HelpText | None] = HELP_TEXT

    formats: tuple[Format, ...]

    @classmethod
    def of(cls, value: Sequence[Format]) -> FormatFiles:
        """Return the files of these formats."""
        return cls(tuple(value))

    @property
    def notes(self) -> Sequence[str]:
        """Files that are left out, as a library is not installed."""
        return [format_.left_out for format_ in self.formats if format_.left_out]

    @property
    def in_memory(self) -> Collection[InMemory]:
        """The formats."""
        return self.formats

    def refuse(self, recipe: Recipe) -> None:
        """Raise a UserError if a format needs a package that is not installed, or joins maps."""
        from rsegen.formats.base import refuse_unready

        refuse_unready(self.formats)
        for format_ in self.formats:
            if format_.joins:
                problem = f"{format_.joins} would contain every map; only rsegen export writes that"
                raise ParameterError(f"formats: {format_.name}", f"{problem}; export it, or leave out its name")

    def files(self, scene: Scene) -> Bundle:
        """Return the files of all formats."""
        from rsegen.formats.base import added

        return added(scene, self.formats)

    def lists(self, home: str) -> Bundle:
        """Return formats.json, which lists the formats that the folder of a map has, and these."""
        from rsegen.formats.base import recorded_options
        from rsegen.formats.encoded import as_json

        listed = {**(listed_formats(home) or {}), **recorded_options(self.formats)}
        return {PurePosixPath(FORMATS_FILE): [as_json(listed)]}

    def are_in(self, home: str) -> bool:
        """Return whether a map's folder has the formats, and lists them with the same options."""
        from rsegen.formats.base import recorded_options

        listed = listed_formats(home) or {}
        return all(
            listed.get(name) == options and os.path.isdir(os.path.join(home, name))
            for name, options in recorded_options(self.formats).items()
        )

    def seconds(self, cells: int) -> float:
        """Return about how long they take for a map with this many cells."""
        # Estimates: 5 ms and 30 us per cell for a format. Larger ones start workers for runs that are too short for
        # them; smaller ones give each worker more at once.
        return (5e-3 + cells * 3e-5) * len(self.formats)


def listed_formats(home: str) -> dict[str, Json] | None:
    """Return the formats in a map's folder with their options, from its formats.json; None if the file is damaged."""
    try:
        with open_regular(os.path.join(home, FORMATS_FILE)) as file:
            listed = json.load(file)
    except FileNotFoundError:
        return {}
    except (OSError, ValueError, RecursionError):
        return None
    return listed if isinstance(listed, dict) else None
