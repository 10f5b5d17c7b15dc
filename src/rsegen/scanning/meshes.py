"""The points of a mesh that a camera above it sees.

Walls have half of the area of a step field, or more, and no height of a block. So points are spread over the faces by
area as it is seen from above, and those that something covers are left out, such as a floor below blocks, and their
undersides. That also makes it the same which way faces are wound, which scanning apps and people mix up.

    seen    ______        ______        pixels from above hold the highest point in them; what is lower than
                 |       |              this by more than its own face rises across a pixel is covered
    covered .....|_______|......

Up is not known, but a field is flat: of the directions that most faces have, up is the one from which most is seen;
if nearly as much is seen from another one, as of a few high blocks from aside, the one whose undersides are all equally
high, or whose faces all look to one side.
From below, closed blocks are all equally high, and a surface is the same from either side; so up is where the heights
differ more, or where walls go down below all that is seen. Closed blocks of one height are the same from either side
too: then the axis of the file decides, which the report says. If nothing tells, and no field is found, up is where the
faces look. Blocks without a floor stand on the ground: its points are added around them, as high as their undersides.
Cost: linear in the faces; some seconds for a million. What breaks it: a wall that is larger than the field and its
floor, if `up` is not given.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from rsegen.field.stepfield import Array, Ints, Mask

if TYPE_CHECKING:
    import trimesh

_SAMPLED = 400_000
"""Points that are kept: 40 on each of 10,000 blocks; with fewer, blocks are not seen."""

_SPREAD, _SPREAD_ROUGHLY = 2_000_000, 200_000
"""Points that are spread over a mesh to see what is covered, and to choose the direction."""

_PER_PIXEL = 8
"""Points of a face in a pixel on average: exp(-8) = 0.03 % of the pixels that it covers have none."""

_FINEST = 2_000
"""Pixels along a side at most, 4 mm of 8 m."""

_RISES = 2.0
"""Times the rise of a face along the side of a pixel by which points in the pixel differ: its diagonal, and a rest."""

_DIRECTIONS = 4
"""Directions that are tried: three of blocks, and one of something else."""

_SAME = float(np.cos(np.radians(15)))
"""Cosine of the angle up to which faces have one direction: those of a phone's mesh are uneven."""

_APART = float(np.cos(np.radians(30)))
"""Cosine of the angle up to which a direction is another's, or the one that is given as up."""

_FLATTER = 1.25
"""Times the range of heights from the other side that there has to be from the one that is up: of a surface that is
open, both have the same, and up is found by the ground (ground.py)."""


_WALLED = 0.12
"""Share of the height of a mesh from which on it has walls of blocks below all that is seen, as those of one of eight
units are; the edges of uneven surfaces of phones reach down 0.06 of it."""

_ROUNDED = 1e-3
"""Share of its height by which heights of a mesh differ by rounding alone: of 32 bits, and of coordinates of maps."""

_LOOKING = 0.9
"""Share of the area of a surface, less that which looks the other way, from which on it looks to one side."""


class Cloud(NamedTuple):
    """Points (n, 3), and the direction up (3,) of the object in them, None if it is not known.

    facing: the direction (3,) to which an open surface looks, as its faces are wound: up, if they are wound rightly
    clearer: the direction (3,) from which more of a mesh, or of its heights, is seen than from the one given as up
    has_floor: False if it is a mesh that has no floor, so that blocks at level 0 are not in it
    is_up_assumed: whether up is that of the file, as both sides of the mesh look alike
    doubt: why the camera of a depth image is perhaps another one than was said; empty if nothing speaks against it
    """

    points: Array
    up: Array | None = None
    facing: Array | None = None
    clearer: Array | None = None
    has_floor: bool = True
    is_up_assumed: bool = False
    doubt: str = ""


def seen_from_above(mesh: trimesh.Trimesh, up: Sequence[float] | None = None) -> Cloud:
    """Return what a camera above a mesh sees of it, and of the ground on which it stands.

    up: nearly its direction, if it is known. Nothing is seen of a mesh without an area.
    """
    normals, areas = np.asarray(mesh.face_normals), np.asarray(mesh.area_faces)
    directions = list(_directions(normals, areas))
    wanted = None if up is None else np.asarray(up, dtype=float) / np.linalg.norm(up)
    if wanted is not None:
        directions = [normal * (np.sign(normal @ wanted) or 1.0) for normal in directions]
        if not any(normal @ wanted > _APART for normal in directions):
            directions.append(wanted)
    views = [_view(mesh, normals, areas, direction, _SPREAD_ROUGHLY) for direction in directions]
    if not views or not any(view.area for view in views):
        return Cloud(np.empty((0, 3)))
    if wanted is not None:
        return _seen_along(wanted, mesh, directions, views)
    # The axis first, by what is seen along it; then which way along it is up, by heights or walls below them.
    best = _upright(mesh, directions, views)
    direction, side = directions[best], views[best]
    other = _view(mesh, normals, areas, -direction, _SPREAD_ROUGHLY)
    known = _tells(side, other)
    if not known and _tells(other, side):
        direction, known = -direction, True
    view = _view(mesh, normals, areas, direction, _SPREAD)
    if known or view.lacks_floor:
        return Cloud(view.points(), direction, has_floor=not view.lacks_floor, is_up_assumed=not known)
    # An open surface shows the same from both sides: how its faces are wound is kept for when the ground does not tell.
    along = areas * (normals @ direction)
    looks = float(along.sum() / np.abs(along).sum())
    facing = direction * np.sign(looks) if abs(looks) > _LOOKING else None
    return Cloud(view.points(), None, facing)


def _upright(mesh: trimesh.Trimesh, directions: Sequence[Array], views: Sequence[_View]) -> int:
    """Return the index of the direction that is up or down: of those from which nearly the most is seen, the first one
    along which all undersides are equally high, or all faces look to one side; else that from which most is seen.
    """
    normals, areas = np.asarray(mesh.face_normals), np.asarray(mesh.area_faces)
    order = np.argsort([-view.area for view in views], kind="stable").tolist()
    nearly = [at for at in order if _FLATTER * views[at].area >= views[order[0]].area]
    for at in nearly if len(nearly) > 1 else ():
        along = areas * (normals @ directions[at])
        ranges = views[at].range, _view(mesh, normals, areas, -directions[at], _SPREAD_ROUGHLY).range
        if min(ranges) <= _ROUNDED * max(ranges) or abs(along.sum()) > _LOOKING * np.abs(along).sum():
            return int(at)
    return int(order[0])


def _tells(side: _View, other: _View) -> bool:
    """Return whether a side is surely up: it has more heights than the other one, or it alone has walls that go down
    below all that is seen.
    """
    if max(side.range, other.range) > _FLATTER * min(side.range, other.range) + _ROUNDED * (side.high - side.bottom):
        return side.range > other.range
    return side.below > _WALLED and not other.is_thick


def _seen_along(wanted: Array, mesh: trimesh.Trimesh, directions: Sequence[Array], views: Sequence[_View]) -> Cloud:
    """Return what is seen from a direction, or the one near it from which most is, and whether another shows more."""
    normals, areas = np.asarray(mesh.face_normals), np.asarray(mesh.area_faces)
    seen = [view.area * (direction @ wanted > _APART) for view, direction in zip(views, directions, strict=True)]
    best, chosen = int(np.argmax([view.area for view in views])), int(np.argmax(seen))
    direction, clearer = directions[chosen], None
    if views[best].area > _FLATTER * seen[chosen]:
        clearer = directions[best]
    elif _view(mesh, normals, areas, -direction, _SPREAD_ROUGHLY).range > _FLATTER * views[chosen].range:
        clearer = -direction
    view = _view(mesh, normals, areas, direction, _SPREAD)
    return Cloud(view.points(), direction, None, clearer, has_floor=not view.lacks_floor)


def _directions(normals: Array, areas: Array) -> Iterator[Array]:
    """Yield unit vectors (3,) along which much of the area faces, either way, the most first."""
    if not areas.sum() > 0:
        return
    # Some thousand faces by area tell the directions; each is then the principal axis of all normals near it.
    few = normals[np.random.default_rng(0).choice(len(areas), 2_000, p=areas / areas.sum())]
    for _ in range(_DIRECTIONS):
        if not len(few):
            return
        middle = few[int((np.abs(few @ few.T) > _SAME).sum(axis=1).argmax())]
        near = np.abs(normals @ middle) > _SAME
        axis = np.linalg.eigh((normals[near] * areas[near, None]).T @ normals[near])[1][:, 2]
        yield axis * np.sign(axis[int(np.abs(axis).argmax())])
        few = few[np.abs(few @ axis) < _APART]


_LOW, _HIGH = 0.01, 0.99
"""Quantiles of heights that count as the lowest and the highest: a few points at edges are seen through."""

_FOOT = 0.005
"""Quantile of the heights of corners that counts as the height of the undersides, or of the lower ends of walls."""

_THICK = 0.05
"""Share of the range of heights from which on these are below the lowest that is seen, and no noise."""

_AS_THICK = 0.75
"""Share of the first step above it from which on the lowest that is seen is a block or a frame, and no floor."""

_EVEN, _MOST_EVEN = 0.1, 0.9
"""Share of the range of heights up to which a rim is at the lowest, and share of it from which on it is a floor: the
rim of blocks without one has all their heights."""

_MOST_HOLES = 0.005
"""Share of the pixels inside that may have no points in a floor: blocks at level 0 are holes of many."""

_MARGIN = 0.1
"""Width of the ground that is added around, as a share of that of the mesh: a block or more of 10."""


class _View(NamedTuple):
    """The view along a direction, which is z of `axes` (3, 3).

    placed: points (3, n) along the axes; raster: their pixels; seen: those that nothing covers; bottom: the height of
    undersides; area: of what is seen; low, high: heights
    """

    axes: Array
    placed: Array
    raster: _Raster
    seen: Mask
    bottom: float
    area: float
    low: float
    high: float

    @property
    def range(self) -> float:
        """Range of the heights that are seen."""
        return self.high - self.low

    @property
    def below(self) -> float:
        """Share of the height of the mesh that is below the lowest that is seen."""
        return (self.low - self.bottom) / (self.high - self.bottom) if self.high > self.bottom else 0.0

    @property
    def is_thick(self) -> bool:
        """True if walls or undersides are below the lowest that is seen."""
        return self.below > _THICK

    @property
    def lacks_floor(self) -> bool:
        """True if the lowest that is seen are blocks on a ground that the mesh does not have."""
        return self.is_thick and not _has_floor(self.raster, self.placed, self.seen, self.bottom)

    def points(self) -> Array:
        """Return points (n, 3) that are seen, and of the ground around them if they have no floor."""
        seen, placed = self.seen, self.placed
        ground = self.raster.ground(self.bottom) if self.lacks_floor else np.empty((0, 3))
        order = np.random.default_rng(0).permutation(int(seen.sum()) + len(ground))  # so that the first are any
        return np.asarray(np.concatenate([placed[:, seen].T, ground])[order[:_SAMPLED]] @ self.axes)


def _view(mesh: trimesh.Trimesh, normals: Array, areas: Array, up: Array, count: int) -> _View:
    """Return what is seen from a direction, of `count` points that are spread evenly as seen from there."""
    cosines = np.abs(normals @ up)
    weights = areas * cosines
    points, faces = _spread(mesh, weights, count)
    rises = np.sqrt(np.maximum(1 - cosines**2, 0)) / np.maximum(cosines, 1e-6)
    axes = np.stack([*np.linalg.svd(up[None])[2][1:], up])  # any two directions across it, from its null space
    placed = axes @ points
    # A corner that is far away by mistake makes no raster without end.
    pixel = max(float(np.sqrt(_PER_PIXEL * weights.sum() / count)), float(np.ptp(placed[:2], axis=1).max()) / _FINEST)
    raster = _Raster.of(placed[:2], pixel)
    seen = raster.uncovered(placed[2], _RISES * pixel * rises[faces] + pixel / 10)
    low, high = (float(height) for height in np.quantile(placed[2, seen], [_LOW, _HIGH]))
    bottom = float(np.quantile(np.asarray(mesh.vertices) @ up, _FOOT))
    return _View(axes, placed, raster, seen, bottom, float(weights.sum() * seen.mean()), low, high)


def _spread(mesh: trimesh.Trimesh, weights: Array, count: int) -> tuple[Array, Ints]:
    """Return points (3, n) that are spread over faces by their weights, and the faces that they are on."""
    rng, sums = np.random.default_rng(0), np.cumsum(weights)
    faces = np.searchsorted(sums, rng.random(count) * sums[-1])
    along = rng.random((count, 2))
    beyond = along[:, 0] + along[:, 1] > 1  # the half of the parallelogram that is no triangle is turned onto it
    a, b = (np.abs(along[:, side] - beyond) for side in (0, 1))
    origin, first, second = np.asarray(mesh.vertices)[mesh.faces.T].transpose(0, 2, 1)
    sides = zip(first - origin, second - origin, origin, strict=True)
    return np.stack([u[faces] * a + v[faces] * b + start[faces] for u, v, start in sides]), faces


class _Raster(NamedTuple):
    """Pixels from above: the flat index of that of each point (n,), their shape, the first's corner and their side."""

    keys: Ints
    shape: tuple[int, int]
    corner: Array
    pixel: float

    @classmethod
    def of(cls, places: Array, pixel: float) -> _Raster:
        """Return the raster of places (2, n), with a margin in which none are."""
        extent = np.ptp(places, axis=1)
        corner = places.min(axis=1) - _MARGIN * extent
        n_x, n_y = (int(side) + 1 for side in extent * (1 + 2 * _MARGIN) / pixel)
        i, j = np.floor((places - corner[:, None]) / pixel).astype(np.int64)
        return cls(i * n_y + j, (n_x, n_y), corner, pixel)

    def uncovered(self, heights: Array, within: Array) -> Mask:
        """Return which of its points (n,) are at most `within` (n,) below the highest in their pixel."""
        top = np.full(self.shape[0] * self.shape[1], -np.inf)
        np.maximum.at(top, self.keys, heights)
        return np.asarray(top[self.keys] - heights <= within)

    def ground(self, height: float) -> Array:
        """Return points (n, 3) at a height, spread over the pixels without points as densely as others on average."""
        empty = np.ones(self.shape[0] * self.shape[1], dtype=bool)
        empty[self.keys] = False
        places = np.repeat(np.stack(np.unravel_index(np.flatnonzero(empty), self.shape), axis=1), _PER_PIXEL, axis=0)
        inside = np.random.default_rng(0).random(places.shape)
        return np.column_stack([self.corner + (places + inside) * self.pixel, np.full(len(places), height)])


def _has_floor(raster: _Raster, placed: Array, seen: Mask, bottom: float) -> bool:
    """Return whether a mesh has a floor around its field: a rim of one height, the lowest, without holes inside, that
    is thinner than the first step above it, as a frame around blocks is not; bottom: the height of its underside.
    """
    heights = placed[2, seen]
    low, high = np.quantile(heights, [_LOW, _HIGH])
    above = heights[heights > low + _THICK * (high - low)]
    if len(above) and low - bottom > _AS_THICK * (np.quantile(above, _LOW) - low):
        return False
    # Along every row and column of pixels: the ends are the rim, and pixels without points between them are holes.
    pixels = np.full(raster.shape[0] * raster.shape[1], np.nan)
    pixels[raster.keys[seen]] = heights
    lines = [line for lines in (pixels.reshape(raster.shape), pixels.reshape(raster.shape).T) for line in lines]
    rims, holes = [], 0
    for line in lines:
        if len(known := np.flatnonzero(np.isfinite(line))):
            rims += [line[known[0]], line[known[-1]]]
            holes += int(known[-1] - known[0]) + 1 - len(known)
    is_even = float((np.array(rims) <= low + _EVEN * (high - low)).mean()) > _MOST_EVEN
    return is_even and holes < _MOST_HOLES * 2 * int(np.isfinite(pixels).sum())  # rows and columns count each pixel
