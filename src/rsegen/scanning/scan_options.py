"""The options of a scan: how clouds are read, and what is known of the field in them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated

from rsegen.params.sorts import CENTIMETRES, Choice, Flag, Float, ListOf, Size2D, Text, parameters, validate
from rsegen.recipe.map_design import MapDesign

if TYPE_CHECKING:
    from rsegen.scanning.scan import ScanSettings

CLOUDS: Mapping[str, str] = MappingProxyType(
    {
        **dict.fromkeys((".xyz", ".txt", ".csv", ".asc", ".pts"), "text"),
        **dict.fromkeys((".ply", ".obj", ".stl", ".glb", ".gltf", ".dae"), "mesh"),
        ".pcd": "pcd",
        **dict.fromkeys((".las", ".laz"), "las"),
        ".e57": "e57",
        **dict.fromkeys((".mcap", ".db3", ".bag"), "bag"),
        ".npy": "array",
        **dict.fromkeys((".png", ".tif", ".tiff", ".pgm"), "image"),
    }
)
"""Readers of point clouds, by the suffixes of their files."""

_UPWARDS = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1), "-x": (-1, 0, 0), "-y": (0, -1, 0), "-z": (0, 0, -1)}
_DESIGN = parameters(MapDesign)


@dataclass(frozen=True, kw_only=True, slots=True)
class ScanOptions:
    """Options of reading clouds, and known values of the field in them; what is not given is found."""

    values: Annotated[
        str | None,
        Choice(tuple(CENTIMETRES), help="unit of the cloud's numbers; default: m, and mm for depth images of integers"),
    ] = None
    intrinsics: Annotated[
        Sequence[float] | None,
        ListOf(Float(-1e6, 1e6), 4, help="fx,fy,cx,cy of a depth image's camera, in pixels"),
    ] = None
    topic: Annotated[
        str | None,
        Text(r"[^\s]{1,255}", "the name of a topic", help="topic of a bag with clouds; default: the only one with any"),
    ] = None
    up: Annotated[
        str | None,
        Choice(
            tuple(_UPWARDS),
            help="axis of the numbers in the file that is nearly up, as --up=-y (y in glTF); default: estimated",
        ),
    ] = None
    size: Annotated[
        Sequence[int] | None,
        Size2D(
            help="blocks of the field along x and y, frames not counted; default: the rectangle of all that is raised"
        ),
    ] = None
    base_cm: Annotated[
        float | None,
        Float(0, 1000, unit="cm", help="thickness of a board below the blocks; 0: none; default: estimated"),
    ] = None
    fill_holes: Annotated[
        bool, Flag(help="fill blocks that were not seen with the median level of their neighbours, not with 0")
    ] = False
    block_width_cm: Annotated[float | None, _DESIGN["block_width_cm"]] = None
    unit_cm: Annotated[float | None, _DESIGN["unit_cm"]] = None
    boundary: Annotated[str | None, _DESIGN["boundary"]] = None
    chunk_size: Annotated[int | None, _DESIGN["chunk_size"]] = None

    def __post_init__(self) -> None:
        validate(self)

    @property
    def settings(self) -> ScanSettings:
        """The known values of the field, in metres."""
        from rsegen.scanning.scan import ScanSettings

        return ScanSettings(
            block_width=self.block_width_cm / 100 if self.block_width_cm else None,
            unit=self.unit_cm / 100 if self.unit_cm else None,
            blocks=(self.size[0], self.size[1]) if self.size else None,
            boundary=self.boundary,
            chunk_size=self.chunk_size,
            up=_UPWARDS[self.up] if self.up else None,
            eye=(0, 0, 0) if self.intrinsics else None,
            base=None if self.base_cm is None else self.base_cm / 100,
        )
