"""Texture coordinates of a mesh: one tile of an image per block, on tops and on sides.

A top takes the tile of its cell. A side takes the column of its cell, and its rows from the top of the block downward:

     ___ ___ ___           v = 0 at the top of the block
    | 0 | 1 | 2 |   side
    |   |   |   |          v = -1 one block width below it

The image repeats after TILES tiles, so coordinates are whole numbers of tiles on tops, and distinct values are few:
they are welded as integers (mesh.py) and written once. Levels are shifted against one another, so that equal tiles are
not neighbours. Cost: linear in the corners of the faces.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rsegen.field.stepfield import Array, Ints, Mask, StepField
from rsegen.geometry.mesh import Mesh, welded

TILES = 8
"""Tiles along each side of an image, after which it repeats: 64 blocks, among which the eye finds no pattern at once.
The images grow with the square (decision 21)."""

SHIFT = (3, 5)
"""Tiles by which each level is shifted along u and v, so that neighbours of different height have different tiles. Both
are coprime to TILES, so only every eighth level has the tiles of another one."""


class TextureCoordinates(NamedTuple):
    """The texture coordinates of the corners of faces.

    values: (n, 2) u to the right and v upward, in tiles; corners: (m, 3 or 4) rows of `values`, one per face corner;
    sides: (m,) true for faces that show long grain: the sides of blocks, and frames.
    """

    values: Array
    corners: Ints
    sides: Mask


def texture_coordinates(mesh: Mesh, field: StepField) -> TextureCoordinates:
    """Return the texture coordinates of a mesh of `field` or of a part of it."""
    vertical, frame = mesh.normals < 4, mesh.materials == 0
    # The edges of cells at the corners of faces, counted from the sides of the field; and from them column and row.
    x, y = (
        np.rint((line - own[0]) / field.block_width).astype(np.int64)[mesh.places[mesh.faces, axis]]
        for axis, (line, own) in enumerate(zip(mesh.lines, field.edges(), strict=False))
    )
    is_along_x = frame & (np.ptp(x, axis=1) > np.ptp(y, axis=1))
    swapped = ((mesh.normals < 2) | (~vertical & is_along_x))[:, None]
    shift_u, shift_v = (shift * mesh.materials[:, None] % TILES for shift in SHIFT)
    across, along = _reduced(np.where(swapped, y, x) + shift_u), _reduced(np.where(swapped, x, y) + shift_v)
    # The depths of corners below the top of their block, negated: distinct ones, and which of them each corner has.
    materials = np.arange(int(mesh.materials.max(initial=0)) + 1)
    tops = np.where(materials > 0, materials * field.unit, field.frame_height)
    table = np.minimum(np.round((mesh.lines[2] - tops[:, None]) / field.block_width, 9) + 0.0, 0)
    depths, index = np.unique(table, return_inverse=True)
    depth = index.reshape(table.shape)[mesh.materials[:, None], mesh.places[mesh.faces, 2]]
    # A pair (u, v) is one integer: the column, and an index into all values of v, rows of tops before depths of sides.
    rows = int(along.max(initial=0)) + 1
    values_of_v = np.concatenate([np.arange(rows), depths])
    v = np.where(vertical[:, None], rows + depth, along)
    turned = (vertical & frame)[:, None]  # the grain of a frame is horizontal
    columns = int(across.max(initial=0)) + 1
    known, corners = welded((turned * columns + across) * len(values_of_v) + v, 2 * columns * len(values_of_v))
    column, row = np.divmod(known, len(values_of_v))
    is_turned, column = np.divmod(column, columns)
    values = np.where(is_turned, [-values_of_v[row], -column], [column, values_of_v[row]]).T
    return TextureCoordinates(values + 0.0, corners, vertical | frame)


def _reduced(tiles: Ints) -> Ints:
    """Return the tiles of each face less whole images: the lowest is in 0..TILES - 1."""
    lowest = tiles.min(axis=1, keepdims=True)
    return np.asarray(tiles - lowest + lowest % TILES)
