"""The picture of coloured triangles from a camera, in perspective with shadows, without OpenGL and without a screen.

Each pixel keeps the nearest triangle (a visibility buffer), as one number whose high half is its nearness and whose low
half is its index: the maximum of several is the nearest. Of triangles, rows and pixels come in arrays: a triangle is
cut into rows, a row into pixels. The inverse of the distance along the camera's axis is linear in a picture, so it
is known at each pixel. The sun looks at the same triangles in parallel, and what it does not see is in the shadow.

    triangles --rows--> spans --pixels--> nearest triangle --sun--> colours --mean of 2 x 2--> picture

What does not move is drawn once. What moves changes pixels only around it and around its shadow, and these alone are
drawn anew. Cost: with 1280 x 720 pixels two seconds, most of it for pixels, and at 640 x 360 some 20 milliseconds for a
frame in which a robot moves. What breaks it: a triangle that reaches behind the camera, which is left out.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from math import atan2, hypot, sqrt, tan
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rsegen.field.stepfield import Array, Ints
from rsegen.geometry.rectangles import ragged

Pixels = NDArray[np.uint8]
"""A picture: (height, width, 3), the first row at the top."""

_Lit = NDArray[np.float32]
"""Depth image of the sun: distance of the first surface at each pixel towards it, metres."""

_NEAR = 0.05
"""Metres in front of a camera from which on it sees, as Gazebo's does."""

_FINER = 2
"""Rows and columns that are drawn for each of the picture, so that edges have no stairs."""

_AT_ONCE = 1_000_000
"""Pixels of triangles that are drawn at once: 100 MB of memory."""

_SUN = np.array([0.40, -0.50, 0.77])
"""Direction to the sun, in the south-east: of a camera in the south-west it is on the right, so that shadows are seen
on the left, and of the sides that are seen the southern ones are lit."""

_AMBIENT = 0.52
"""Light that comes from all directions, as a share of all light; shadows and sides away from the sun have it alone."""

_RIM = 4
"""Pixels around what moves and around its shadow that may change too."""

_SHARED = 1e-9
"""Pixels by which a row of a triangle is longer: a pixel on an edge of two belongs to one of them, or to both."""

_SUN_PIXELS = 2048
"""Pixels along a side of what the sun sees."""


class Triangles(NamedTuple):
    """Triangles with a colour each: corners (m, 3, 3), metres; colours (m, 3), 0..1."""

    corners: Array
    colours: Array

    @classmethod
    def joined(cls, parts: Iterable[Triangles]) -> Triangles:
        """Return all triangles of the parts."""
        every = list(parts)
        corners = [np.empty((0, 3, 3)), *(part.corners for part in every)]
        return cls(np.concatenate(corners), np.concatenate([np.empty((0, 3)), *(part.colours for part in every)]))

    def moved(self, pose: Array) -> Triangles:
        """Return them at a pose, (4, 4)."""
        return Triangles(self.corners @ pose[:3, :3].T + pose[:3, 3], self.colours)


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Camera:
    """A camera that looks down on the ground.

    place: metres; pitch, yaw: radians, as in SDF, where a positive pitch looks down; view: its horizontal angle,
    radians; pixels: width and height of its pictures
    """

    place: tuple[float, float, float]
    pitch: float
    yaw: float
    view: float = 0.9
    pixels: tuple[int, int] = (1280, 720)

    @property
    def axes(self) -> Array:
        """Rows: its directions right, down and forward, (3, 3)."""
        (s, c), (down, along) = ((np.sin(angle), np.cos(angle)) for angle in (self.yaw, self.pitch))
        return np.array([[s, -c, 0.0], [-down * c, -down * s, -along], [along * c, along * s, -down]])

    def projected(self, points: Array, finer: int = 1) -> Array:
        """Return points (..., 3) in its picture: x, y in pixels, and nearness, 1/m; not finite behind the camera."""
        wide, high = (finer * side for side in self.pixels)
        seen = (points - self.place) @ self.axes.T
        away = np.where(seen[..., 2] > _NEAR, seen[..., 2], np.nan)
        scale = wide / 2 / tan(self.view / 2) / away
        return np.stack([wide / 2 + seen[..., 0] * scale, high / 2 + seen[..., 1] * scale, 1 / away], axis=-1)

    def ground(self) -> Array:
        """Return the corners of the ground that it sees, as two triangles (2, 3, 3)."""
        slope = tan(self.view / 2) * 1.01  # a rim of a pixel or more
        wide, high = self.pixels
        ends = np.array([[-1, 1], [1, 1], [1, -1], [-1, -1]]) * (slope, slope * high / wide)
        rays = np.column_stack([ends, np.ones(4)]) @ self.axes
        # A ray that does not come down ends far away, on the horizon.
        lengths = self.place[2] / np.maximum(-rays[:, 2], 1e-3)
        corners = (self.place + lengths[:, None] * rays) * (1, 1, 0)
        return corners[[[0, 1, 2], [0, 2, 3]]]


def south_west_of(extent: tuple[float, float], pixels: tuple[int, int] = (1280, 720)) -> Camera:
    """Return a camera that looks from the south-west at all of a map of these sides, metres."""
    # At 1.1 diagonals and a metre to the south-west, half the diagonal is within half the view: 1.1 tan(0.9 / 2) > 0.5.
    # From 0.8 / sqrt(2) of that distance up it looks down by 29 degrees: over walls, and yet along the ground.
    away = (1.1 * hypot(*extent) + 1.0) / sqrt(2)
    high = 0.8 * away
    place, pitch, yaw = (-away, -away, high), round(atan2(high, away * sqrt(2)), 4), round(np.pi / 4, 4)
    return Camera(place=place, pitch=pitch, yaw=yaw, pixels=pixels)


class View:
    """The view of a camera on fixed triangles, and on others that move from picture to picture.

    radius: of the circle around the origin, metres, in which there are shadows; ground: the colour of the ground
    """

    def __init__(self, camera: Camera, still: Triangles, radius: float, ground: tuple[float, float, float]) -> None:
        self._camera, self._sun = camera, _Sun(radius)
        level = Triangles(camera.ground(), np.tile(ground, (2, 1)))
        self._still = Triangles.joined([level, still])
        wide, high = camera.pixels
        self._nearest = np.zeros((_FINER * high, _FINER * wide), dtype=np.uint64)
        _draw(self._nearest, camera.projected(self._still.corners, _FINER))
        self._lit = np.full((_SUN_PIXELS, _SUN_PIXELS), -np.inf, dtype=np.float32)
        self._sun.draw(self._lit, still.corners)
        whole = slice(0, high), slice(0, wide)
        self._picture = self._shaded(self._nearest, self._lit, self._still, whole)

    def picture(self, moving: Triangles) -> Pixels:
        """Return the picture with triangles that move where they are now."""
        picture = self._picture.copy()
        window = self._window(moving.corners)
        if window is None:
            return picture
        rows, columns = (slice(_FINER * part.start, _FINER * part.stop) for part in window)
        nearest, lit = self._nearest[rows, columns].copy(), self._lit.copy()
        seen = self._camera.projected(moving.corners, _FINER) - (columns.start, rows.start, 0)
        _draw(nearest, seen, first=len(self._still.corners))
        self._sun.draw(lit, moving.corners)
        picture[window] = self._shaded(nearest, lit, Triangles.joined([self._still, moving]), window)
        return picture

    def _window(self, corners: Array) -> tuple[slice, slice] | None:
        """Return rows and columns of the picture that triangles and their shadows may change; None if none."""
        # The shadow of a corner is on the ground where the line through it to the sun meets z = 0.
        heights = np.maximum(corners[..., 2:], 0.0)
        seen = self._camera.projected(np.concatenate([corners, corners - heights / _SUN[2] * _SUN]))
        parts = []
        for axis, side in ((1, self._camera.pixels[1]), (0, self._camera.pixels[0])):
            places = seen[..., axis].ravel()  # not finite behind the camera
            low, end = np.fmin.reduce(places, initial=np.inf), np.fmax.reduce(places, initial=-np.inf)
            if not low < end:
                return None
            # Shadows are soft by some pixels of what the sun sees.
            parts.append(slice(*(int(np.clip(place, 0, side)) for place in (low - _RIM, end + _RIM + 1))))
        rows, columns = parts
        return (rows, columns) if rows.start < rows.stop and columns.start < columns.stop else None

    def _shaded(self, nearest: NDArray[np.uint64], lit: _Lit, of: Triangles, window: tuple[slice, slice]) -> Pixels:
        """Return the colours of the pixels of a window, whose nearest triangles are known."""
        camera, (rows, columns) = self._camera, window
        (high, wide), (width, height) = nearest.shape, (_FINER * side for side in camera.pixels)
        triangle = (nearest & np.uint64(0xFFFFFFFF)).astype(np.int64)
        away = 1 / (nearest >> np.uint64(32)).astype(np.uint32).view(np.float32)
        # The side of a triangle that is seen is the one towards the camera.
        normals = _normals(of.corners)
        normals[(normals * (camera.place - of.corners[:, 0])).sum(axis=1) < 0] *= -1
        # A place is the camera's plus `away` times a ray, whose length along the axis is 1.
        step = tan(camera.view / 2) * 2 / width
        x = (np.arange(wide) + _FINER * columns.start + 0.5 - width / 2) * step
        y = (np.arange(high) + _FINER * rows.start + 0.5 - height / 2) * step
        share = self._sun.share(lit, np.array(camera.place), (camera.axes, x, y), away, (normals, triangle))
        # Tops that the sun sees have all the light.
        facing = np.clip(normals @ _UNIT_SUN / _UNIT_SUN[2], 0, 1)
        light = _AMBIENT + (1 - _AMBIENT) * facing[:, None] * np.linspace(0, 1, _Sun.SHARES)
        shades = (of.colours[:, None] * light[..., None]).reshape(-1, 3).astype(np.float32)
        colours = shades[triangle * _Sun.SHARES + share]
        parts = [colours[row::_FINER, column::_FINER] for row in range(_FINER) for column in range(_FINER)]
        return np.asarray(np.rint(255 * np.clip(sum(parts) / len(parts), 0, 1)), dtype=np.uint8)


_UNIT_SUN = _SUN / np.linalg.norm(_SUN)


class _Sun:
    """The sun, which looks in parallel at a circle around the origin."""

    def __init__(self, radius: float) -> None:
        across = np.cross((0.0, 0.0, 1.0), _UNIT_SUN)
        across /= np.linalg.norm(across)
        self._axes = np.array([across, np.cross(_UNIT_SUN, across), _UNIT_SUN])
        self._pixel = 2 * radius / _SUN_PIXELS

    def _seen(self, points: Array) -> Array:
        """Return points (..., 3) as the sun sees them: x, y in pixels, and how far they are towards it, metres."""
        seen = points @ self._axes.T
        return np.concatenate([seen[..., :2] / self._pixel + _SUN_PIXELS / 2, seen[..., 2:]], axis=-1)

    def draw(self, lit: _Lit, corners: Array) -> None:
        """Draw triangles into what the sun sees: how far the first thing at each pixel is towards it."""
        for at, nearness, _ in _pixels(self._seen(corners), lit.shape):
            np.maximum.at(lit.reshape(-1), at, nearness.astype(np.float32))

    SHARES = 5
    """Shares of a place that the sun sees: 0, 1/4, ... 1, by four looks around it, so that edges are soft."""

    def share(
        self, lit: _Lit, camera: Array, rays: tuple[Array, Array, Array], away: Array, facing: tuple[Array, Ints]
    ) -> Ints:
        """Return the share of each place that the sun sees, in quarters.

        The place of a pixel is the camera's plus `away` times its ray: axes (3, 3), and x and y along the first two.
        facing: normals of triangles, and the triangle of each pixel
        """
        (axes, x, y), (normals, triangle) = rays, facing
        # A surface would shade itself between the pixels of the sun, so its places are raised by three of them.
        raised = (3 * self._pixel * normals @ self._axes.T).astype(np.float32)
        origin, turned = self._axes @ camera, (self._axes @ axes.T).astype(np.float32)
        across, along = x.astype(np.float32), y.astype(np.float32)[:, None]
        seen = []
        for axis in range(3):  # one after another, and never as rows of three numbers: a fifth of the time
            right, down, forward = turned[axis]
            ray = across * right + (along * down + forward)
            seen.append(ray * away + np.float32(origin[axis]) + raised[:, axis][triangle])
        column, row = (place / np.float32(self._pixel) + np.float32(_SUN_PIXELS / 2) for place in seen[:2])
        towards, share = seen[2] + np.float32(self._pixel), np.zeros(away.shape, dtype=np.int64)
        flat, edge = lit.reshape(-1), _SUN_PIXELS - 1
        for aside, ahead in ((-0.5, -0.5), (0.5, -0.5), (-0.5, 0.5), (0.5, 0.5)):
            # What is beyond the circle is seen: the rim of what the sun sees is empty.
            at_row = np.clip(row + np.float32(ahead), 0, edge).astype(np.int32)
            at = at_row * _SUN_PIXELS + np.clip(column + np.float32(aside), 0, edge).astype(np.int32)
            share += towards >= flat[at]
        return share


def _normals(corners: Array) -> Array:
    """Return the unit normals of triangles, (m, 3); zero for one without an area."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.asarray(np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0))


def _draw(nearest: NDArray[np.uint64], seen: Array, first: int = 0) -> None:
    """Draw projected triangles, the first with the index `first`, where they are nearer than what was drawn before."""
    for at, nearness, triangle in _pixels(seen, nearest.shape):
        keys = nearness.astype(np.float32).view(np.uint32).astype(np.uint64) << np.uint64(32)
        np.maximum.at(nearest.reshape(-1), at, keys | (triangle + first).astype(np.uint64))


def _pixels(seen: Array, shape: tuple[int, ...]) -> Iterator[tuple[Ints, Array, Ints]]:
    """Yield the pixels of projected triangles (m, 3, 3), some at once: place in the picture, nearness, and triangle."""
    high, wide = shape
    a, b, c = seen[:, 0], seen[:, 1], seen[:, 2]
    area = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    (visible,) = np.nonzero(np.isfinite(area) & (np.abs(area) > 1e-9))  # not behind the camera, nor seen edge on
    # Rows whose middles are between the lowest and the highest corner.
    y_a, y_b, y_c = (corner[visible, 1] for corner in (a, b, c))  # numpy is slow along short axes
    low = np.clip(np.ceil(np.minimum(np.minimum(y_a, y_b), y_c) - 0.5), 0, high).astype(np.int64)
    end = np.clip(np.floor(np.maximum(np.maximum(y_a, y_b), y_c) - 0.5) + 1, 0, high).astype(np.int64)
    which, row = ragged(np.maximum(end - low, 0))
    triangle, row = visible[which], row + low[which]
    left, right = np.full(len(row), np.inf), np.full(len(row), -np.inf)
    middle = row + 0.5
    # A row begins and ends where its middle crosses two of the three edges.
    for start_corner, end_corner in ((a, b), (b, c), (c, a)):
        (x0, y0), (x1, y1) = start_corner[triangle, :2].T, end_corner[triangle, :2].T
        crosses = (np.minimum(y0, y1) <= middle) & (middle <= np.maximum(y0, y1)) & (y0 != y1)
        share = np.divide(middle - y0, y1 - y0, out=np.zeros(len(row)), where=y0 != y1)
        x = x0 + share * (x1 - x0)
        left = np.where(crosses, np.minimum(left, x), left)
        right = np.where(crosses, np.maximum(right, x), right)
    start = np.clip(np.ceil(left - 0.5 - _SHARED), 0, wide).astype(np.int64)
    counts = np.maximum(np.clip(np.floor(right - 0.5 + _SHARED) + 1, 0, wide).astype(np.int64) - start, 0)
    # Nearness is linear in the picture: its slopes along x and y.
    up_b, up_c = (corner[:, 2] - a[:, 2] for corner in (b, c))
    with np.errstate(divide="ignore", invalid="ignore"):
        along_x = (up_b * (c[:, 1] - a[:, 1]) - up_c * (b[:, 1] - a[:, 1])) / area
        along_y = (up_c * (b[:, 0] - a[:, 0]) - up_b * (c[:, 0] - a[:, 0])) / area
    for portion in _portions(counts):
        span, column = ragged(counts[portion])
        x, y, own = column + start[portion][span], row[portion][span], triangle[portion][span]
        nearness = a[own, 2] + along_x[own] * (x + 0.5 - a[own, 0]) + along_y[own] * (y + 0.5 - a[own, 1])
        yield y * wide + x, nearness, own


def _portions(counts: Ints) -> Iterator[slice]:
    """Yield slices of counts that add up to _AT_ONCE about."""
    ends = counts.cumsum()
    portions = int(ends[-1]) // _AT_ONCE + 1 if len(ends) else 0
    cuts = np.searchsorted(ends, [_AT_ONCE * part for part in range(1, portions)]).tolist()
    for first, last in zip([0, *cuts], [*cuts, len(counts)], strict=True) if portions else ():
        yield slice(first, last)
