"""From a step field to geometry: meshes and boxes of a map."""

from collections.abc import Iterator

from rsegen.field.stepfield import StepField, Window
from rsegen.geometry.boxes import Boxes, box_per_block, boxes
from rsegen.geometry.label_grid import split_window
from rsegen.geometry.mesh import NORMALS, Mesh
from rsegen.geometry.surface import surface
from rsegen.geometry.unmerged import unmerged
from rsegen.geometry.watertight import watertight

__all__ = [
    "NORMALS",
    "PIECE",
    "Boxes",
    "Mesh",
    "box_per_block",
    "boxes",
    "meshes",
    "split_window",
    "surface",
    "unmerged",
    "watertight",
]

PIECE = 512
"""Side of the pieces, in cells, that large maps are made in, so that memory does not grow with the map."""


def meshes(field: StepField, mesh: str, window: Window | None = None) -> Iterator[Mesh]:
    """A field, or a window of it, as a recipe's `mesh` says; large ones in pieces, but for a watertight mesh."""
    if mesh == "watertight":
        yield watertight(field)
        return
    piece = {"merged": surface, "blocks": unmerged}[mesh]
    for part in split_window(window or field.whole, PIECE):
        yield piece(field, part)
