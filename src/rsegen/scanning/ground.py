"""The ground plane of a point cloud, and the direction up.

The plane with the most points is not always the floor, as scans are cut tightly; but all tops of blocks are parallel to
the floor. So the normal that counts is the one along which the cloud is layered most:

    heights along a normal, as a histogram       ground  |#########
                                                 level 1 |###          a few slices have most of the points
                                                 level 2 |####         for the right normal; for others none has
                                                 level 3 |##

1. RANSAC (Fischler and Bolles 1981): 6,000 planes through three points each, scored by the points near them.
2. The best 24 are fitted again by total least squares, and the one with the clearest layers is kept.
3. Up is the side on which the camera is, or on which the lowest layer is the wide one: floor is wider than blocks,
   and than walls, of which a layer has few places.
4. The ground is the lowest slice that is a local maximum; a fit of its points with a robust deviation ends it.

A tolerance of 1/150 of the cloud's size (2 cm of 3 m) is a slice: far less than a block, more than the noise of depth
cameras. Cost: 6,000 x 2,000 distances and 24 fits of 20,000 points, some hundredths of a second. It fails if no tops
are seen, and if a wall has more and clearer layers than the floor.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rsegen.errors import ScanError
from rsegen.field.stepfield import Array, Ints
from rsegen.params.sorts import CENTIMETRES

_FEWEST_POINTS = 500
"""Points of a cloud, at the least: five, which a height needs (levels.py), for each of 10 x 10 cells."""

_SMALLEST = 0.05
_LARGEST = 200.0
"""Widths of a cloud in metres: others are in another unit, as centimetres taken for metres are 100 times as wide."""

_COARSE = 0.01
"""Metres to which places may be rounded: a tenth of a block of 10 cm, as numbers of 32 bits are 130 km away."""

MOST_POINTS = 200_000
"""Points of a cloud that the searches use: 2,000 per cell of 10 x 10; the levels are read from all points."""

_HYPOTHESES = 6_000
"""Planes through three points. If one layer has a tenth of the points, 6 of them have all three points in it."""

_SCORED = 2_000
"""Points on which every plane is scored: a plane with 5 % of the points then has 100 +- 10 of them."""

_AT_ONCE = 64
"""Planes that are scored together: the distances of 2,000 points from them are 1 MB."""

_REFINED = 24
"""Best planes that are fitted again: the planes of most points are often those of one wall, several times."""

_LEAST_SHARE = 0.01
"""Share of all points below which a layer is taken for noise: 2 % of outliers spread over 150 slices are far fewer."""

_LEAST_LAYERED = 0.35
"""Share of the points that lie in layers, at the least; of points spread evenly over a volume, about a tenth does."""

SLICES = 150
"""Slices of one tolerance per size of the cloud; see above."""

_CELL = 4
"""Side of the cells in which the area of a layer is counted, in slices: 4 cm of a cloud of 1.5 m, half a block."""


@dataclass(frozen=True, kw_only=True, slots=True)
class GroundFrame:
    """The upright frame of a cloud: x and y in the ground plane, z the height above it.

    rotation: (3, 3); offset: height of the ground after it [m]; noise: standard deviation of the ground's points [m]
    """

    rotation: Array
    offset: float
    noise: float

    def apply(self, points: Array) -> Array:
        """Return points (n, 3) as x, y and height above the ground [m]."""
        turned = points @ self.rotation.T
        turned[:, 2] -= self.offset
        return turned


def sample(points: Array, most: int = MOST_POINTS) -> Array:
    """Return at most `most` of the points, spread evenly over the cloud; always the same ones.

    The step is the golden section of the number of points, coprime to it: its multiples are the most evenly spread ones
    (three-distance theorem), and no point is taken twice.
    """
    if len(points) <= most:
        return points
    step = round(len(points) * 0.6180339887498949) | 1
    while np.gcd(step, len(points)) != 1:
        step += 2
    chosen: Ints = np.arange(most, dtype=np.int64) * step % len(points)
    return points[chosen]


def usable(points: Array) -> tuple[Array, Array]:
    """Return the points without far outliers, about their middle, and it, (3,); a ScanError if they are too few."""
    points = np.asarray(points, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3:
        raise ScanError(f"points have shape {points.shape}; expected (n, 3)")
    # Some programs write zeros for a point that was not measured, as others write nan.
    points = points[np.isfinite(points).all(axis=1) & points.any(axis=1)]
    if len(points) < _FEWEST_POINTS:
        raise ScanError(f"too few points for a field: {len(points):,}; at least {_FEWEST_POINTS} are needed")
    # The middle 96 % is free of outliers, up to 2 % at either end; points farther than its width from it are left out.
    low, high = np.quantile(sample(points), [0.02, 0.98], axis=0)
    extent = float((high - low).max())
    if not _SMALLEST < extent < _LARGEST:
        raise ScanError(
            f"the cloud is {extent:{',.0f' if extent > 1 else '.3g'}} m wide, not {_SMALLEST:g} to {_LARGEST:g} m; set "
            f"the unit of its numbers ({', '.join(CENTIMETRES)}) with values, or cut all but the field out of it"
        )
    _refuse_coarse(points, float(np.abs([low, high]).max()))
    near = ((points > low - extent) & (points < high + extent)).all(axis=1)
    return points[near] - (low + high) / 2, (low + high) / 2


def _refuse_coarse(points: Array, farthest: float) -> None:
    """Raise a ScanError if places as far from the origin as those of maps were written in numbers of 32 bits."""
    apart = float(np.spacing(np.float32(farthest)))
    if apart > _COARSE and (points.astype(np.float32) == points).all():
        raise ScanError(
            f"the points are {farthest:,.0f} m from the origin, where numbers of 32 bits are {apart:.2g} m apart; "
            "write them in 64 bits, or subtract the place of one of them from all"
        )


def plan_width(upright: Array) -> float:
    """Return how wide an upright cloud (n, 3) is along x or y, without outliers [m]."""
    return float(np.ptp(np.quantile(sample(upright)[:, :2], [0.02, 0.98], axis=0), axis=0).max())


def level_frame(
    points: Array, up: Sequence[float] | None = None, eye: Sequence[float] | Array | None = None
) -> GroundFrame:
    """Return the frame of the ground plane, by a robust fit.

    points: (n, 3) [m]; up: a direction that is nearly up, if it is known; eye: the place of the camera, above the
    ground, if it is known; else the ground is on the side of the cloud where its lowest layer is widest. Raises
    a ScanError if there is no plane.
    """
    few = sample(points, 20_000)  # ten times as many as the planes are scored on; the fit itself is linear in them
    scale = float(np.linalg.norm(np.quantile(few, 0.98, axis=0) - np.quantile(few, 0.02, axis=0)))  # without outliers
    normal = _normal(few, scale / SLICES, up)
    heights = few @ normal
    if eye is not None:
        normal = normal * (np.sign(np.median(np.asarray(eye, dtype=float) @ normal - heights)) or 1.0)
    elif up is None:
        normal = normal * _side(few, heights, normal, scale / SLICES)
    heights = few @ normal
    return _refined(few, normal, _lowest_layer(heights, scale / SLICES), scale / SLICES)


def _normal(points: Array, tolerance: float, up: Sequence[float] | None) -> Array:
    """Return the unit normal along which the cloud has the clearest layers."""
    normals, heights = _hypotheses(points)
    if up is not None:
        direction = np.asarray(up, dtype=float) / np.linalg.norm(up)
        turn = np.sign(normals @ direction)
        normals, heights = normals * turn[:, None], heights * turn
        near = normals @ direction > np.cos(np.radians(30))  # as people hold a camera; beyond 45 degrees walls count
        normals, heights = normals[near], heights[near]
    if not len(normals):
        raise ScanError("no plane was found in the direction that is given as up")
    # Points near a plane choose the planes that are fitted; layers choose among these.
    scored = sample(points, _SCORED)
    counts = _points_near(normals, heights, scored, tolerance)
    best = np.argsort(-counts, kind="stable")[:_REFINED]
    refined = [_plane_fit(points, normals[at], heights[at], tolerance) for at in best]
    if up is not None:  # it may be exact, as that of a mesh is
        refined.append(direction)
    layered = [_layered(points @ normal, tolerance) for normal in refined]
    if max(layered) < _LEAST_LAYERED:
        raise ScanError("no ground plane: the points are not in level layers; use a cloud of blocks and some floor")
    return refined[int(np.argmax(layered))]


def _hypotheses(points: Array) -> tuple[Array, Array]:
    """Return planes through three points each: unit normals (n, 3) and heights (n,)."""
    draws = np.random.default_rng(0).random((_HYPOTHESES, 3))
    a, b, c = (points[(draws[:, k] * len(points)).astype(np.int64)] for k in range(3))
    normals = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=1)
    kept = lengths > 1e-12  # three points on a line span no plane
    normals = normals[kept] / lengths[kept, None]
    return normals, (normals * a[kept]).sum(axis=1)


def _points_near(normals: Array, heights: Array, points: Array, tolerance: float) -> Ints:
    """Return how many points are near each plane."""
    counts, places = np.empty(len(normals), dtype=np.int64), np.ascontiguousarray(points.T)
    # Some planes at a time: their distances stay in the cache of the processor, which is eight times as fast as all.
    for first in range(0, len(normals), _AT_ONCE):
        part = slice(first, first + _AT_ONCE)
        distances = normals[part] @ places
        distances -= heights[part, None]
        np.abs(distances, out=distances)
        counts[part] = np.count_nonzero(distances < tolerance, axis=1)
    return counts


def _plane_fit(points: Array, normal: Array, height: float, tolerance: float) -> Array:
    """Return the normal of the plane through the points near a plane, by total least squares.

    Three times, as each fit brings other points near; the last one hardly changes anything.
    """
    for _ in range(3):
        near = points[np.abs(points @ normal - height) < tolerance]
        if len(near) < 3:
            break
        middle = near.mean(axis=0)
        fitted = np.linalg.eigh((near - middle).T @ (near - middle))[1][:, 0]  # the direction of least variance
        normal = fitted * (np.sign(fitted @ normal) or 1.0)
        height = float(middle @ normal)
    return normal


def _layers(heights: Array, tolerance: float) -> tuple[Ints, float]:
    """Return the number of points per slice of one tolerance, and the start of the first slice."""
    low = float(heights.min())
    slices = np.floor((heights - low) / tolerance).astype(np.int64)
    return np.bincount(slices), low


def _layered(heights: Array, tolerance: float) -> float:
    """Return the share of the points in the ten fullest slices: five levels of blocks, each across two slices.

    Of fewer than forty slices only a quarter, as ten would hold most of the points by themselves.
    """
    inner = heights[(heights >= np.quantile(heights, 0.01)) & (heights <= np.quantile(heights, 0.99))]
    if len(inner) < 3:
        return 1.0
    counts, _ = _layers(inner, tolerance)
    fullest = np.sort(counts)[::-1]
    share = 10 if len(counts) >= 40 else max(1, len(counts) // 4)
    return float(fullest[:share].sum() / len(inner))


def _side(points: Array, heights: Array, normal: Array, tolerance: float) -> float:
    """Return 1 if the ground is at the low end of the heights, -1 if it is at the high end."""
    # Cells of the plan that the lowest layer has points in: walls around a room have few, however far apart they are.
    areas = []
    plan = np.floor(points @ _upright(normal)[:2].T / (_CELL * tolerance)).astype(np.int64)
    for sign in (1.0, -1.0):
        ground = _lowest_layer(sign * heights, tolerance)
        near = np.abs(sign * heights - ground) < 1.5 * tolerance
        areas.append(len(np.unique(plan[near], axis=0)))
    if max(areas) < 1.25 * min(areas):  # as wide as each other within the error of the areas
        return 1.0 if normal[int(np.abs(normal).argmax())] >= 0 else -1.0  # z of the cloud decides, or y if that is up
    return 1.0 if areas[0] > areas[1] else -1.0


def _lowest_layer(heights: Array, tolerance: float) -> float:
    """Return the height of the lowest slice that is a local maximum with enough points."""
    counts, low = _layers(heights, tolerance)
    # Smoothed, as a layer may be split between two slices; enough is 1 % of all points, or 4 % of the fullest slice.
    summed = np.convolve(counts, [0.5, 1, 0.5], mode="same")
    enough = np.flatnonzero(summed > max(_LEAST_SHARE * len(heights), 0.04 * summed.max()))
    at = int(enough[0])
    while at + 1 < len(summed) and summed[at + 1] > summed[at]:
        at += 1
    near = heights[np.abs(heights - low - (at + 0.5) * tolerance) < 1.5 * tolerance]
    return float(np.median(near)) if len(near) else low + (at + 0.5) * tolerance


def _refined(points: Array, normal: Array, height: float, tolerance: float) -> GroundFrame:
    """Fit the ground's plane to its points, without those beyond three standard deviations."""
    within, noise = 1.5 * tolerance, tolerance
    for _ in range(5):  # the cut follows the noise, which follows the cut; it settles in three or four rounds
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
        noise = 1.4826 * float(np.median(np.abs(residuals)))  # the standard deviation of a normal distribution
        within = float(np.clip(3 * noise, tolerance / 10, 1.5 * tolerance))
    return GroundFrame(rotation=_upright(normal), offset=height, noise=noise)


def _upright(normal: Array) -> Array:
    """Return the rotation (3, 3) that takes a unit normal to +z and keeps x as nearly as it can."""
    z = np.asarray(normal, dtype=float)
    nearest = np.eye(3)[0] if abs(z[0]) < 0.9 else np.eye(3)[1]
    x = nearest - z * (nearest @ z)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z])
