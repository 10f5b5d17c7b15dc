"""From a step field to geometry: meshes and boxes of a map."""

from collections.abc import Iterator

from rsegen.field.stepfield import CellWindow, StepField
from rsegen.geometry.blocks import blocks
from rsegen.geometry.boxes import Boxes, boxes, single_boxes
from rsegen.geometry.mesh import NORMALS, Mesh
from rsegen.geometry.relief import windows
from rsegen.geometry.surface import surface
from rsegen.geometry.watertight import watertight

__all__ = [
    "NORMALS",
    "PIECE",
    "Boxes",
    "Mesh",
    "blocks",
    "boxes",
    "meshes",
    "single_boxes",
    "surface",
    "watertight",
    "windows",
]

PIECE = 512
"""Side of the pieces, in cells, that large maps are made in, so that memory does not grow with the map."""


def meshes(field: StepField, mesh: str, window: CellWindow | None = None) -> Iterator[Mesh]:
    """A field, or a window of it, as a recipe's `mesh` says; large ones in pieces, but for a watertight mesh."""
    if mesh == "watertight":
        yield watertight(field)
        return
    piece = {"merged": surface, "blocks": blocks}[mesh]
    for part in windows(window or field.whole, PIECE):
        yield piece(field, part)
