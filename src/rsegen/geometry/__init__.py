"""Meshes and boxes of a step field."""

from rsegen.geometry.boxes import Boxes, box_per_block, boxes
from rsegen.geometry.label_grid import split_window
from rsegen.geometry.mesh import NORMALS, Mesh
from rsegen.geometry.meshes import PIECE, meshes
from rsegen.geometry.surface import surface, unmerged
from rsegen.geometry.texture import TILES, TextureCoordinates, texture_coordinates
from rsegen.geometry.watertight import watertight

__all__ = [
    "NORMALS",
    "PIECE",
    "TILES",
    "Boxes",
    "Mesh",
    "TextureCoordinates",
    "box_per_block",
    "boxes",
    "meshes",
    "split_window",
    "surface",
    "texture_coordinates",
    "unmerged",
    "watertight",
]
