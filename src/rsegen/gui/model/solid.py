"""A scene as points, faces and lines in space, which the 3D view draws."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rsegen.exporters.scene import Scene
from rsegen.field.stepfield import Array, CellWindow, StepField
from rsegen.geometry import surface
from rsegen.gui.model.bounds import border
from rsegen.gui.model.colours import GROUND, Bytes, surface_palette
from rsegen.gui.model.grain import finest, with_grain
from rsegen.gui.model.shading import Floats, Shading, foot, shading

_LIT = np.array([0.88, 0.68, 0.80, 0.66, 1.0, 0.5])
"""How bright faces are, by the row of NORMALS that they look along; tops have the colour of the legend itself."""

_WALL_TEXELS, _WALL_BLOCKS = 32, 1.5
"""The strip of the light map for walls: its texels, from the foot of a wall up to this many widths of a block."""

_RING = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])


class Solid(NamedTuple):
    """points: (n, 3) metres; faces: (m, 4) numbers of points; colours: (m, 3); places: (n, 2) 0..1, in a light map."""

    points: Floats
    faces: NDArray[np.int32]
    colours: Bytes
    places: Floats


class Lit(NamedTuple):
    """The blocks and frames of a scene and the ground under them; light: (n, m), x along the first axis, of both."""

    blocks: Solid
    ground: Solid
    light: Floats


class Lines(NamedTuple):
    """points: (n, 3) metres; pairs: (m, 2) numbers of points."""

    points: Array
    pairs: NDArray[np.int64]


def lit(scene: Scene) -> Lit:
    """The merged surface of a scene's blocks and frames, empty for a flat scene, and the ground around them."""
    found = with_grain(shading(scene.field, border(scene.field), finest(scene)), scene)
    strip = foot(np.linspace(0, _WALL_BLOCKS, _WALL_TEXELS)).astype(np.float32)
    light = np.hstack([found.light, np.broadcast_to(strip, (len(found.light), _WALL_TEXELS))])
    share = found.light.shape[1] / light.shape[1]
    blocks = _placed(solid(scene), found, share, scene.field.block_width)
    return Lit(blocks, _ground(scene.field, found, share), light)


def solid(scene: Scene) -> Solid:
    """The merged surface of a scene's blocks and frames, each face with points of its own; without a light map."""
    mesh = surface(scene.field)
    shades = surface_palette(scene)[mesh.materials] * _LIT[mesh.normals][:, None]
    points = mesh.vertices.astype(np.float32)[mesh.faces].reshape(-1, 3)
    faces = np.arange(len(points), dtype=np.int32).reshape(-1, 4)
    return Solid(points, faces, np.round(shades).astype(np.uint8), np.zeros_like(points[:, :2]))


def _placed(made: Solid, found: Shading, share: float, block_width: float) -> Solid:
    """A solid with the places of its points in a light map, of which a share is for tops."""
    points = made.points.reshape(-1, 4, 3)
    places = _on_light_map(points[..., :2], found, share)
    walls = np.ptp(points[..., 2], axis=1) > 0
    places[walls, :, 1] = _up_walls(points[walls, :, 2] / np.float32(block_width), share)
    return made._replace(places=places.reshape(-1, 2))


def _ground(field: StepField, found: Shading, share: float) -> Solid:
    """A plate just below the map, a little larger than it."""
    (west, south), (east, north) = found.low, found.high
    depth = border(field) / 100
    corners = [(west, south, -depth), (east, south, -depth), (east, north, -depth), (west, north, -depth)]
    points = np.array(corners, dtype=np.float32)
    faces = np.arange(4, dtype=np.int32)[None]
    return Solid(points, faces, np.array([GROUND], dtype=np.uint8), _on_light_map(points[:, :2], found, share))


def _on_light_map(points: Floats, found: Shading, share: float) -> Floats:
    low, high = np.array([found.low, found.high], dtype=np.float32)
    return np.asarray((points - low) / (high - low) * np.array([1, share], dtype=np.float32))


def _up_walls(heights: Floats, share: float) -> Floats:
    """Where the corners of walls (m, 4) of some heights, in widths of a block, are along the strip for walls."""
    above = np.minimum((heights - heights.min(axis=1, keepdims=True)) / _WALL_BLOCKS, 1)
    texel = (1 - share) / _WALL_TEXELS
    return np.asarray(share + texel / 2 + above * (1 - share - texel), dtype=np.float32)


def block_edges(field: StepField) -> Lines:
    """The edges of all blocks: a ring round every top, and a post at every corner, up to the highest block there."""
    edges_x, edges_y = field.edges()
    i, j = (index.ravel() for index in np.indices(field.shape))
    corners = np.stack([i, j], axis=1)[:, None, :] + _RING
    heights = np.broadcast_to(field.heights.ravel()[:, None], corners.shape[:2])
    rings = np.stack([edges_x[corners[..., 0]], edges_y[corners[..., 1]], heights], axis=2)
    return _joined([rings.reshape(-1, 3), _posts(field)], [_ring_pairs(len(i)), None])


def box_edges(field: StepField, cells: CellWindow) -> Lines:
    """The twelve edges of a box around some cells, a fifth of a block higher than their highest block."""
    edges = [line[[part.start, part.stop]] for line, part in zip(field.edges(), cells, strict=True)]
    top = float(field.heights[cells].max(initial=0.0)) + field.block_width / 5
    rings = [np.column_stack([edges[0][_RING[:, 0]], edges[1][_RING[:, 1]], np.full(4, z)]) for z in (0.0, top)]
    posts = np.stack(rings, axis=1).reshape(-1, 3)
    return _joined([*rings, posts], [_ring_pairs(1), _ring_pairs(1), None])


def _posts(field: StepField) -> Array:
    """(2 n, 3): from the ground up to the highest of the four cells at a corner, where any block is."""
    around = np.pad(field.heights, 1)
    highest = np.max([around[:-1, :-1], around[1:, :-1], around[:-1, 1:], around[1:, 1:]], axis=0)
    i, j = np.nonzero(highest)
    edges_x, edges_y = field.edges()
    feet = np.column_stack([edges_x[i], edges_y[j], np.zeros(len(i))])
    heads = np.column_stack([edges_x[i], edges_y[j], highest[i, j]])
    return np.stack([feet, heads], axis=1).reshape(-1, 3)


def _ring_pairs(rings: int) -> NDArray[np.int64]:
    """(4 n, 2): the sides of rings of four points each."""
    four = np.arange(4)
    sides = np.stack([four, (four + 1) % 4], axis=1)
    return (np.arange(rings)[:, None, None] * 4 + sides).reshape(-1, 2)


def _joined(points: list[Array], pairs: list[NDArray[np.int64] | None]) -> Lines:
    """All lines in one value; without pairs, each two consecutive points are a line."""
    starts = np.cumsum([0, *map(len, points)])
    round_numbers = [
        (np.arange(len(some)).reshape(-1, 2) if joins is None else joins) + start
        for some, joins, start in zip(points, pairs, starts[:-1], strict=True)
    ]
    return Lines(np.concatenate(points), np.concatenate(round_numbers))
