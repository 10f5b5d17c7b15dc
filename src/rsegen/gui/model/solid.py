"""A scene as points, faces and lines for the 3D view, with shadows and end grain once per map, and its scale."""

from __future__ import annotations

import itertools
from functools import lru_cache
from math import floor, log10
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rsegen.exporters.numbers import decimal
from rsegen.exporters.scene import Scene
from rsegen.exporters.textures import pine
from rsegen.field.stepfield import Array, CellWindow, StepField
from rsegen.geometry import surface
from rsegen.geometry.texture import SHIFT, TILES
from rsegen.gui.model.colours import GROUND, Bytes, surface_palette
from rsegen.params.streams import generator

Floats = NDArray[np.float32]

SUN = (0.8, 0.45, 1.0)
"""The direction from the map to the sun."""

_TEXELS = 500_000
FINEST = 10
"""Texels along a cell, which suffice for shadows."""

_SHADOW, _CORNER = 0.36, 0.42
_STEPS = 40
_PENUMBRA = 0.35
"""The width of the rim of a shadow, as a share of its distance from what casts it."""


class Shading(NamedTuple):
    """light: (n, m) 0..1, for points on the ground and on tops, x along the first axis; low, high: its corners [m];
    fine: texels along a cell; rim: cells of ground around the field.
    """

    light: Floats
    low: tuple[float, float]
    high: tuple[float, float]
    fine: int
    rim: int


def shading(field: StepField, border: float, finest: int = FINEST) -> Shading:
    """The light on a field and on the ground around it, up to `border` metres away.

    finest: texels along a cell, at most; fewer on maps of many cells
    """
    fine = int(np.clip(np.sqrt(_TEXELS / field.levels.size), 1, finest))
    rim = int(np.ceil(border / field.block_width))
    heights = np.pad(field.heights.astype(np.float32) / np.float32(field.block_width), rim)
    fine_heights = heights.repeat(fine, axis=0).repeat(fine, axis=1) * np.float32(fine)
    light = (1 - _SHADOW * _in_shadow(fine_heights)) * (1 - _CORNER * _in_corners(fine_heights, fine))
    half_x, half_y = (side / 2 + rim * field.block_width for side in field.extent)
    return Shading(light.astype(np.float32), (-half_x, -half_y), (half_x, half_y), fine, rim)


def foot(height: Array) -> Array:
    """The light on a wall at some heights above its foot, in widths of a block: 1 from a width and a half upward."""
    return 1 - _CORNER * 0.8 * np.clip(1 - height / 1.5, 0, 1) ** 2


def _in_shadow(heights: Floats) -> Floats:
    """How much of the sun other blocks hide, 0..1; heights in texels, as are the steps towards the sun."""
    x, y, z = np.array(SUN) / np.hypot(*SUN[:2])
    far = min(float(heights.max() - heights.min()) / z, float(max(heights.shape)))
    hidden = np.zeros_like(heights)
    for distance in np.linspace(0, far, min(int(far), _STEPS) + 1)[1:].tolist():
        di, dj = round(distance * x), round(distance * y)
        if di < heights.shape[0] and dj < heights.shape[1]:
            here = (slice(0, heights.shape[0] - di), slice(0, heights.shape[1] - dj))
            above = heights[di:, dj:] - heights[here] - np.float32(distance * z)
            np.maximum(hidden[here], above / np.float32(_PENUMBRA * distance + 1), out=hidden[here])
    return np.minimum(hidden, 1)


def _in_corners(heights: Floats, fine: int) -> Floats:
    """How much of the sky is hidden, 0..1: by how much the mean height around is above a point."""
    hidden: Floats = np.zeros_like(heights)
    for radius in (max(fine // 3, 1), fine):
        hidden += np.clip((_mean_around(heights, radius) - heights) / np.float32(radius), 0, 1)
    return hidden / np.float32(2)


def _mean_around(heights: Floats, radius: int) -> Floats:
    """The mean over a square of 2 radius + 1 texels a side, beyond the rim of the ground 0."""
    size = 2 * radius + 1
    for _ in (0, 1):
        sums = np.pad(heights, ((radius + 1, radius), (0, 0))).cumsum(axis=0, dtype=np.float32)
        heights = ((sums[size:] - sums[:-size]) / np.float32(size)).T
    return heights


_FINEST = 24
"""Texels along the side of a block of a small map."""

_COARSEST = 6
"""Of fewer texels the grain would be noise."""

_BRIGHTEST = 1.1
"""The brightest wood, as a share of what it has on average: the light map can only darken."""


def finest(scene: Scene) -> int:
    """Texels along a cell of a light map, at most."""
    return _FINEST if scene.recipe.look == "wood" else FINEST


def with_grain(found: Shading, scene: Scene) -> Shading:
    """The light of a scene, darker where the wood of tops is, if it has the look of wood and is fine enough."""
    if scene.recipe.look != "wood" or found.fine < _COARSEST:
        return found
    light, start = found.light.copy(), found.fine * found.rim
    tops = _tops(scene, found.fine)
    light[start : start + tops.shape[0], start : start + tops.shape[1]] *= tops
    return found._replace(light=light)


@lru_cache(maxsize=2)
def _brightness(seed: int) -> Floats:
    """How bright the texture of tops is, 1 on average; x along the first axis."""
    tones = pine.top(generator(seed, 0, "textures of blocks"))
    bright = pine.PALETTE @ (0.3, 0.59, 0.11)
    found = bright[np.clip(np.rint(tones * 63), 0, 63).astype(np.intp)] / bright[pine.MEAN]
    return np.asarray(np.minimum(found / _BRIGHTEST, 1).T, dtype=np.float32)


def _tops(scene: Scene, fine: int) -> Floats:
    """The grain of every cell, (fine n_x, fine n_y); 1 where no block stands."""
    field, texture = scene.field, _brightness(scene.recipe.seed)
    i, j = np.indices(field.shape)
    across, along = (i + SHIFT[0] * field.levels) % TILES, (j + SHIFT[1] * field.levels) % TILES
    within = ((np.arange(fine) + 0.5) / fine * pine.PIXELS).astype(np.intp)
    rows = (across[:, None, :, None] * pine.PIXELS) + within[None, :, None, None]
    columns = (along[:, None, :, None] * pine.PIXELS) + within[None, None, None, :]
    found = texture[rows, columns]
    bare = ((field.levels == 0) & ~field.frame)[:, None, :, None]
    return np.where(bare, np.float32(1), found).reshape(fine * field.shape[0], fine * field.shape[1])


Bounds = tuple[float, float, float, float, float, float]
"""Smallest and largest x, y and z, metres."""

_BORDER = 0.06


def bounds(scene: Scene) -> Bounds:
    """Smallest and largest x, y and z of a scene [m]; z up to the highest level that the recipe can have."""
    field = scene.field
    half_x, half_y = (side / 2 for side in field.extent)
    frame = field.frame_height if field.frame.any() else 0.0
    top = max(scene.recipe.top_level * field.unit, frame, float(field.heights.max(initial=0.0)), field.unit)
    return -half_x, half_x, -half_y, half_y, 0.0, top


def border(field: StepField) -> float:
    """The width of the ground around a map [m], a share of its longer side."""
    return _BORDER * max(field.extent)


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
    """The lines in one value; without pairs, each two consecutive points are a line."""
    starts = np.cumsum([0, *map(len, points)])
    round_numbers = [
        (np.arange(len(some)).reshape(-1, 2) if joins is None else joins) + start
        for some, joins, start in zip(points, pairs, starts[:-1], strict=True)
    ]
    return Lines(np.concatenate(points), np.concatenate(round_numbers))


_MARKS, _FEWEST = 6, 3
"""Numbers along the longer side of a map, and along one that is much shorter, where more would overlap."""

_BASES = (1, 2, 5)
_BELOW = 0.9
"""How far below the ground the texts are, in widths of the border."""


class Marks(NamedTuple):
    """places: (n, 3), metres, of the texts, below the ground, so that they are below it in views from the side;
    lines: the ticks themselves.
    """

    places: Array
    texts: list[str]
    lines: Lines


def tick_marks(bounds: Bounds, border: float) -> Marks:
    """Ticks across the border, x on the south side and y on the east."""
    west, east, south, north = bounds[:4]
    near, far, beyond = (np.array([east, south]) + at * np.array([1, -1]) for at in (0, border, 1.8 * border))
    longest = max(east - west, north - south)
    along_x, along_y = (
        round_numbers(low, high, max(_MARKS * min(1.5 * (high - low) / longest, 1), _FEWEST))
        for low, high in ((west, east), (south, north))
    )
    starts = [*((x, near[1]) for x in along_x), *((near[0], y) for y in along_y)]
    ends = [*((x, far[1]) for x in along_x), *((far[0], y) for y in along_y)]
    places = [*((x, beyond[1]) for x in along_x), *((beyond[0] + 0.8 * border, y) for y in along_y)]
    texts = [*_texts("x", along_x), *_texts("y", along_y)]
    pairs = np.arange(2 * len(starts)).reshape(2, -1).T
    return Marks(_at_height(places, -_BELOW * border), texts, Lines(_at_height([*starts, *ends], 0.0), pairs))


def round_numbers(low: float, high: float, marks: float = _MARKS) -> list[float]:
    """About so many round numbers in a range: multiples of 1, 2 or 5 times a power of ten."""
    rough = (high - low) / marks
    power = 10.0 ** np.floor(np.log10(rough))
    step = next((base * power for base in _BASES if base * power >= rough), 10 * power)
    first, last = (int(np.ceil(round(low / step, 6))), int(np.floor(round(high / step, 6))))
    return [round(number * step, 9) for number in range(first, last + 1)]


def _texts(axis: str, along: list[float]) -> list[str]:
    """The numbers as text, of which the last has the axis and the unit."""
    return [*map(decimal, along[:-1]), f"{axis} = {decimal(along[-1])} m"]


def _at_height(places: list[tuple[float, float]], z: float) -> Array:
    return np.array([(x, y, z) for x, y in places], dtype=np.float64).reshape(-1, 3)


SOUTH_EAST: Array = np.array([0.45, -0.85, 0.75])
"""The default direction from the map to the camera."""

VIEW_ANGLE = 16.0
"""Degrees, from the lower to the upper rim; narrow, so that near blocks are hardly larger than far ones."""


def viewpoint(bounds: Bounds, direction: Array, *, margin: float, aspect: float) -> tuple[Array, Array]:
    """Position and focal point, from where bounds, widened by a margin, fill the view.

    aspect: width by height. With r and u across and up, f away from the camera, t the tangent of half the angle, a
    corner p is seen from the distance d where |p r| <= (d + p f) t aspect and |p u| <= (d + p f) t.
    """
    low, high = np.array(bounds[::2]), np.array(bounds[1::2])
    focus = (low + high) / 2
    widened = (low - focus) - (margin, margin, 0), (high - focus) + (margin, margin, 0)
    corners = np.array(
        [[widened[side][axis] for axis, side in enumerate(at)] for at in itertools.product((0, 1), repeat=3)]
    )
    back = direction / np.linalg.norm(direction)
    across = np.cross((0.0, 0.0, 1.0), back)
    across = across / np.linalg.norm(across) if np.linalg.norm(across) > 1e-6 else np.array([1.0, 0.0, 0.0])
    up = np.cross(back, across)
    tangent = np.tan(np.radians(VIEW_ANGLE / 2))
    beside, above = np.abs(corners @ across) / (tangent * aspect), np.abs(corners @ up) / tangent
    distance = float(np.max(corners @ back + np.maximum(beside, above)))
    return focus + distance * back, focus


_ROUND = (5, 2, 1)


def round_length(most: float) -> float:
    """The largest length of 1, 2 or 5 times a power of ten up to a length, metres."""
    power = 10.0 ** floor(log10(most))
    return round(next((base * power for base in _ROUND if base * power <= most * (1 + 1e-9)), power), 9)


def length_text(metres: float) -> str:
    """A length as text: in centimetres below a metre."""
    return f"{decimal(round(metres * 100, 4))} cm" if metres < 1 else f"{decimal(metres)} m"
