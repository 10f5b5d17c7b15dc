"""The ground plane of a point cloud, and which way is up: all tops of blocks are parallel to it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rsegen.errors import ScanError
from rsegen.field.stepfield import Array, Ints

MOST_POINTS = 200_000
"""Of a cloud, for every search; the levels are read from all points."""

_HYPOTHESES = 6_000
_SCORED = 2_000
"""Points on which every plane through three points is scored."""

_REFINED = 24
_LEAST_SHARE = 0.01
"""Of all points: a layer of fewer is taken for noise."""

_LEAST_LAYERED = 0.35
"""Share of the points that lie in layers; of points spread evenly over a volume, about a tenth does."""


@dataclass(frozen=True, kw_only=True, slots=True)
class GroundFrame:
    """Turns a cloud upright: x and y in the ground plane, z the height above it.

    rotation: (3, 3); offset: height of the ground after it [m]; noise: standard deviation of the ground's points [m]
    """

    rotation: Array
    offset: float
    noise: float

    def apply(self, points: Array) -> Array:
        """Points of shape (n, 3) as x, y and height above the ground [m]."""
        turned = points @ self.rotation.T
        turned[:, 2] -= self.offset
        return turned


def sample(points: Array, most: int = MOST_POINTS) -> Array:
    """At most so many of the points, spread evenly over the whole cloud; the same ones every time."""
    if len(points) <= most:
        return points
    step = round(len(points) * 0.6180339887498949) | 1
    while np.gcd(step, len(points)) != 1:
        step += 2
    chosen: Ints = np.arange(most, dtype=np.int64) * step % len(points)
    return points[chosen]


def level_frame(
    points: Array, up: Sequence[float] | None = None, eye: Sequence[float] | Array | None = None
) -> GroundFrame:
    """The frame of the ground plane, by a robust fit.

    points: (n, 3) [m]; up: a direction that is nearly up, if it is known; eye: the place of the camera, above the
    ground, if it is known; else the ground is on the side of the cloud where its lowest layer is widest. A ScanError
    if there is no plane.
    """
    few = sample(points, 20_000)
    scale = float(np.linalg.norm(np.quantile(few, 0.98, axis=0) - np.quantile(few, 0.02, axis=0)))
    normal = _normal(few, scale / 150, up)
    heights = few @ normal
    if eye is not None:
        normal = normal * (np.sign(np.median(np.asarray(eye, dtype=float) @ normal - heights)) or 1.0)
    elif up is None:
        normal = normal * _side(few, heights, normal, scale / 150)
    heights = few @ normal
    return _refined(few, normal, _lowest_layer(heights, scale / 150), scale / 150)


def _normal(points: Array, tolerance: float, up: Sequence[float] | None) -> Array:
    """The unit normal along which the cloud has the clearest layers."""
    normals, heights = _hypotheses(points)
    if up is not None:
        direction = np.asarray(up, dtype=float) / np.linalg.norm(up)
        turn = np.sign(normals @ direction)
        normals, heights = normals * turn[:, None], heights * turn
        near = normals @ direction > np.cos(np.radians(30))
        normals, heights = normals[near], heights[near]
    if not len(normals):
        raise ScanError("no plane was found in the direction that is given as up")
    scored = sample(points, _SCORED)
    counts = (np.abs(normals @ scored.T - heights[:, None]) < tolerance).sum(axis=1)
    best = np.argsort(-counts, kind="stable")[:_REFINED]
    refined = [_plane_fit(points, normals[at], heights[at], tolerance) for at in best]
    layered = [_layered(points @ normal, tolerance) for normal in refined]
    if max(layered) < _LEAST_LAYERED:
        raise ScanError("no ground plane: the points are not in level layers; give a cloud of blocks and some floor")
    return refined[int(np.argmax(layered))]


def _hypotheses(points: Array) -> tuple[Array, Array]:
    """Planes through three points each: unit normals (n, 3) and heights (n,)."""
    draws = np.random.default_rng(0).random((_HYPOTHESES, 3))
    a, b, c = (points[(draws[:, k] * len(points)).astype(np.int64)] for k in range(3))
    normals = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=1)
    kept = lengths > 1e-12
    normals = normals[kept] / lengths[kept, None]
    return normals, (normals * a[kept]).sum(axis=1)


def _plane_fit(points: Array, normal: Array, height: float, tolerance: float) -> Array:
    """The normal of the plane through the points near a plane, by total least squares, three times."""
    for _ in range(3):
        near = points[np.abs(points @ normal - height) < tolerance]
        if len(near) < 3:
            break
        middle = near.mean(axis=0)
        found = np.linalg.eigh((near - middle).T @ (near - middle))[1][:, 0]
        normal = found * (np.sign(found @ normal) or 1.0)
        height = float(middle @ normal)
    return normal


def _layers(heights: Array, tolerance: float) -> tuple[Ints, float]:
    """How many points there are per slice of one tolerance, and where the first slice starts."""
    low = float(heights.min())
    slices = np.floor((heights - low) / tolerance).astype(np.int64)
    return np.bincount(slices), low


def _layered(heights: Array, tolerance: float) -> float:
    """Share of the points in the ten fullest slices, of at least forty."""
    inner = heights[(heights > np.quantile(heights, 0.01)) & (heights < np.quantile(heights, 0.99))]
    if len(inner) < 3:
        return 1.0
    counts, _ = _layers(inner, tolerance)
    fullest = np.sort(counts)[::-1]
    share = 10 if len(counts) >= 40 else max(1, len(counts) // 4)
    return float(fullest[:share].sum() / len(inner))


def _side(points: Array, heights: Array, normal: Array, tolerance: float) -> float:
    """1 if the ground is at the low end of the heights, -1 if it is at the high end."""
    areas = []
    across = _upright(normal)[:2] @ points.T
    for sign in (1.0, -1.0):
        ground = _lowest_layer(sign * heights, tolerance)
        near = across[:, np.abs(sign * heights - ground) < 1.5 * tolerance]
        some = near if near.shape[1] else np.zeros((2, 1))
        areas.append(float(np.prod(np.quantile(some, 0.97, axis=1) - np.quantile(some, 0.03, axis=1))))
    if max(areas) < 1.25 * min(areas):
        return 1.0 if normal[2] >= 0 else -1.0
    return 1.0 if areas[0] > areas[1] else -1.0


def _lowest_layer(heights: Array, tolerance: float) -> float:
    """The height of the lowest slice that is a local maximum with enough points."""
    counts, low = _layers(heights, tolerance)
    summed = np.convolve(counts, [0.5, 1, 0.5], mode="same")
    enough = np.flatnonzero(summed > max(_LEAST_SHARE * len(heights), 0.04 * summed.max()))
    at = int(enough[0])
    while at + 1 < len(summed) and summed[at + 1] > summed[at]:
        at += 1
    near = heights[np.abs(heights - low - (at + 0.5) * tolerance) < 1.5 * tolerance]
    return float(np.median(near)) if len(near) else low + (at + 0.5) * tolerance


def _refined(points: Array, normal: Array, height: float, tolerance: float) -> GroundFrame:
    """The ground's plane by least squares of its points, those beyond three standard deviations left out."""
    within, noise = 1.5 * tolerance, tolerance
    for _ in range(5):
        heights = points @ normal
        near = points[np.abs(heights - height) < within]
        if len(near) < 3:
            break
        middle = near.mean(axis=0)
        values, vectors = np.linalg.eigh((near - middle).T @ (near - middle))
        if values[1] > 1e-9 * values[2]:  # else they lie on a line, which has no normal
            normal = vectors[:, 0] * (np.sign(vectors[:, 0] @ normal) or 1.0)
        residuals = near @ normal - float(np.median(near @ normal))
        height = float(np.median(near @ normal))
        noise = 1.4826 * float(np.median(np.abs(residuals)))
        within = float(np.clip(3 * noise, tolerance / 10, 1.5 * tolerance))
    return GroundFrame(rotation=_upright(normal), offset=height, noise=noise)


def _upright(normal: Array) -> Array:
    """The rotation (3, 3) that takes a unit normal to +z and keeps x as nearly as it can."""
    z = np.asarray(normal, dtype=float)
    nearest = np.eye(3)[0] if abs(z[0]) < 0.9 else np.eye(3)[1]
    x = nearest - z * (nearest @ z)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z])
