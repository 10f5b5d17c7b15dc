"""Meshes and boxes of a step field."""

from rsegen.geometry.box_merging import Boxes, box_per_block, boxes
from rsegen.geometry.exposed_faces import surface, unmerged
from rsegen.geometry.mesh import NORMALS, Mesh, split_window
from rsegen.geometry.mesh_kinds import PIECE, meshes
from rsegen.geometry.texture import TILES, TextureCoordinates, texture_coordinates
from rsegen.geometry.watertight_mesh import watertight

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
