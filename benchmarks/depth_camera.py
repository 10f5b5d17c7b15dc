"""A ray caster of our own: what a depth camera sees of a step field that stands on a floor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rsegen.field.stepfield import Array, StepField

FARTHEST = 4.0
"""Metres of floor around the middle that a camera sees, as in a room."""


@dataclass(frozen=True, kw_only=True, slots=True)
class DepthCamera:
    """A pinhole camera: pixels, focal length in pixels, place [m] and the point that it looks at [m]."""

    place: tuple[float, float, float]
    target: tuple[float, float, float] = (0.0, 0.0, 0.0)
    columns: int = 320
    rows: int = 240
    focal: float = 280.0

    def directions(self) -> Array:
        """Unit vectors of all pixels in the world, (rows * columns, 3)."""
        forward = np.subtract(self.target, self.place)
        forward = forward / np.linalg.norm(forward)
        aside = np.cross(forward, (0.0, 0.0, 1.0)) if abs(forward[2]) < 0.999 else np.array([1.0, 0.0, 0.0])
        right = aside / np.linalg.norm(aside)
        down = np.cross(forward, right)
        u = (np.arange(self.columns) - (self.columns - 1) / 2) / self.focal
        v = (np.arange(self.rows) - (self.rows - 1) / 2) / self.focal
        rays = forward + u[None, :, None] * right + v[:, None, None] * down
        rays = rays.reshape(-1, 3)
        return np.asarray(rays / np.linalg.norm(rays, axis=1)[:, None])


def cast(field: StepField, camera: DepthCamera) -> Array:
    """Length of each ray of a camera until it meets a field or the floor [m], (rows * columns,); nan if it does not.

    The field's middle is the origin. A ray is followed from one line of the grid to the next.
    """
    directions, place = camera.directions(), np.asarray(camera.place)
    reached = np.full(len(directions), np.nan)
    for start in range(0, len(directions), 20_000):
        part = slice(start, start + 20_000)
        reached[part] = _cast(field, directions[part], place)
    ends = place + directions * reached[:, None]
    with np.errstate(invalid="ignore"):
        far = np.hypot(ends[:, 0], ends[:, 1]) > FARTHEST
    reached[far] = np.nan
    return reached


def _cast(field: StepField, rays: Array, place: Array) -> Array:
    edges_x, edges_y = field.edges()
    with np.errstate(divide="ignore", invalid="ignore"):
        to_x = (edges_x[None] - place[0]) / rays[:, :1]
        to_y = (edges_y[None] - place[1]) / rays[:, 1:2]
        to_floor = np.where(rays[:, 2] < 0, -place[2] / rays[:, 2], np.inf)
    crossings = np.sort(np.clip(np.nan_to_num(np.hstack([to_x, to_y]), nan=0.0), 0, 1e3), axis=1)
    starts = np.hstack([np.zeros((len(rays), 1)), crossings])
    ends = np.hstack([crossings, np.full((len(rays), 1), 1e3)])
    middles = (starts + ends) / 2
    i = np.searchsorted(edges_x, place[0] + middles * rays[:, :1]) - 1
    j = np.searchsorted(edges_y, place[1] + middles * rays[:, 1:2]) - 1
    n_x, n_y = field.shape
    inside = (i >= 0) & (i < n_x) & (j >= 0) & (j < n_y)
    heights = np.where(inside, field.heights[np.clip(i, 0, n_x - 1), np.clip(j, 0, n_y - 1)], 0.0)
    z_start = place[2] + starts * rays[:, 2:]
    with np.errstate(divide="ignore", invalid="ignore"):
        to_top = (heights - place[2]) / rays[:, 2:]
    side = z_start < heights
    top = ~side & (to_top >= starts) & (to_top <= ends) & (rays[:, 2:] < 0)
    met = (side | top) & inside
    first = met.argmax(axis=1)
    rows = np.arange(len(rays))
    found = np.where(side[rows, first], starts[rows, first], to_top[rows, first])
    return np.minimum(np.where(met.any(axis=1), found, np.inf), to_floor)


@dataclass(frozen=True, kw_only=True, slots=True)
class Flaws:
    """Flaws of a real scan: noise along each ray [m], share of missing points, share of outliers.

    blur: standard deviation of the Gauss filter of each depth image [pixels], as phones smooth depths: at an edge of a
    block the depths of both sides are mixed into points that are on neither.
    """

    blur: float = 0.0
    noise: float = 0.0
    missing: float = 0.0
    outliers: float = 0.0


def scanned(field: StepField, cameras: Sequence[DepthCamera], flaws: Flaws, rng: np.random.Generator) -> Array:
    """The points (n, 3) that some cameras see of a field, in the field's own frame [m]."""
    clouds = []
    for camera in cameras:
        depth = blurred(cast(field, camera).reshape(camera.rows, camera.columns), flaws.blur).ravel()
        seen = np.isfinite(depth)
        place = np.asarray(camera.place)
        clouds.append((place, place + camera.directions()[seen] * depth[seen, None]))
    return with_flaws(clouds, flaws, rng)


def blurred(depth: Array, deviation: float) -> Array:
    """A depth image (rows, columns) after a Gauss filter of a deviation in pixels; pixels without depth stay so."""
    if not deviation:
        return depth
    reach = int(np.ceil(3 * deviation))
    weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) / deviation) ** 2)
    known = np.isfinite(depth)
    sums, shares = np.where(known, depth, 0.0), known.astype(float)
    for axis in (0, 1):
        sums, shares = (np.apply_along_axis(np.convolve, axis, each, weights, "same") for each in (sums, shares))
    return np.where(known, sums / np.maximum(shares, 1e-12), np.nan)


def with_flaws(clouds: Sequence[tuple[Array, Array]], flaws: Flaws, rng: np.random.Generator) -> Array:
    """The points (n, 3) of some clouds together, each with the place of its camera, as a real camera gives them."""
    found = []
    for place, points in clouds:
        kept = points[rng.random(len(points)) >= flaws.missing]
        rays = kept - place
        rays /= np.linalg.norm(rays, axis=1)[:, None]
        found.append(kept + rays * (_normal(rng, (len(kept), 1)) * flaws.noise))
    cloud = np.concatenate(found)
    wrong = rng.random(len(cloud)) < flaws.outliers
    low, high = cloud.min(axis=0), cloud.max(axis=0)
    cloud[wrong] = low + rng.random((int(wrong.sum()), 3)) * (high - low + (0, 0, 0.5))
    return cloud


def _normal(rng: np.random.Generator, shape: tuple[int, ...]) -> Array:
    """Standard normal numbers, by Box and Muller's formula."""
    return np.asarray(np.sqrt(-2 * np.log1p(-rng.random(shape))) * np.cos(2 * np.pi * rng.random(shape)))


def turned(points: Array, rng: np.random.Generator, tilt: float = 1.0) -> Array:
    """A cloud in a frame of its own: turned at random, tilted up to so many radians, and moved."""
    yaw, roll, pitch = 2 * np.pi * rng.random(), tilt * (2 * rng.random() - 1), tilt * (2 * rng.random() - 1)
    c, s = np.cos(yaw), np.sin(yaw)
    about_z = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    c, s = np.cos(roll), np.sin(roll)
    about_x = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    c, s = np.cos(pitch), np.sin(pitch)
    about_y = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    return np.asarray(points @ (about_y @ about_x @ about_z).T + 4 * rng.random(3) - 2)
