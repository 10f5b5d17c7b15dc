"""Imports occupancy maps of ROS: map.yaml with its image."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar

import numpy as np

from rsegen.errors import FileError, ParameterError
from rsegen.io.importers.base import Heights, Importer, register
from rsegen.io.importers.image import brightness
from rsegen.io.recipe_file import content
from rsegen.params.sorts import Flag, Float, Integer, Json, Parameter, Text

_WALL_CM = 100.0

_KEYS: dict[str, Parameter] = {
    "image": Text(r"[^\x00-\x1f]{1,500}", "the path of an image"),
    "resolution": Float(1e-5, 1000, unit="m"),
    "negate": Integer(0, 1),
    "occupied_thresh": Float(0, 1),
    "free_thresh": Float(0, 1),
}
_USUAL = {"negate": 0, "occupied_thresh": 0.65, "free_thresh": 0.25}


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Occupancy(Importer):
    """A map of ROS (map_server, Nav2): occupied cells become walls of one unit, 100 cm if none is said."""

    name: ClassVar[str] = "occupancy map"
    suffixes: ClassVar[tuple[str, ...]] = (".yaml", ".yml")

    unknown: Annotated[bool, Flag(help="also make walls of unknown cells")] = False

    def read(self, path: Path, unit_cm: float | None) -> Heights:
        """A cell is occupied where its probability, dark being likely, is above `occupied_thresh`."""
        metadata = _metadata(path)
        bright = brightness(path.parent / metadata["image"])
        probability = bright if metadata["negate"] else 1 - bright
        walls = probability >= metadata["free_thresh"] if self.unknown else probability > metadata["occupied_thresh"]
        return Heights(
            levels=walls.astype(np.int32),
            unit_cm=unit_cm or _WALL_CM,
            recipe_values={"block_width_cm": round(metadata["resolution"] * 100, 6)},
        )


def _metadata(path: Path) -> dict[str, Json]:
    found = content(path)
    if not isinstance(found, Mapping):
        raise FileError(f"{path}: not an occupancy grid of ROS; it has keys such as image: and resolution:")
    try:
        return {key: sort.check(key, found.get(key, _USUAL.get(key))) for key, sort in _KEYS.items()}
    except ParameterError as error:
        raise error.of(str(path)) from None
