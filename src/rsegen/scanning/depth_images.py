"""Points of depth images: a depth z at pixel (u, v) is the point

    x = (u - cx) z / fx,   y = (v - cy) z / fy,   z        (pinhole camera; x right, y down, z away from it)

It fails for images whose numbers are distances from the camera, and for those of lenses that bend lines.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from rsegen.errors import ParameterError
from rsegen.field.stepfield import Array

_LOST = 65535
"""Depth that some cameras write where they measured none; as millimetres it is farther than any of them measures."""

_OFF_CENTRE, _NOT_SQUARE = 0.1, 1.1
"""Share of an image by which a camera's centre is off its middle, and fx / fy, from which on intrinsics are doubtful:
cameras have 3 % and 1.01 or less, intrinsics of another resolution, or in another order, much more; so has an image
that was cut out of another one.
"""

Intrinsics = Sequence[float]
"""Focal lengths fx, fy and the centre cx, cy of a depth camera, in pixels."""


def points_of_depth(path: Path, depth: Array, intrinsics: Intrinsics | None) -> Array:
    """Return the points of a depth image (rows, columns), in its unit; 0, nan and the largest of 16 bits are holes."""
    if intrinsics is None:
        raise ParameterError("intrinsics", f"{path} is a depth image; pass fx,fy,cx,cy of its camera in pixels")
    fx, fy, cx, cy = intrinsics
    if fx <= 0 or fy <= 0:
        raise ParameterError("intrinsics", f"fx {fx:g} and fy {fy:g} have to be above 0")
    v, u = np.indices(depth.shape)
    z = depth.astype(np.float64)
    z[~np.isfinite(z) | (z <= 0) | (z == _LOST)] = np.nan
    points = np.stack([(u - cx) / fx * z, (v - cy) / fy * z, z], axis=-1).reshape(-1, 3)
    return np.asarray(points[np.isfinite(points[:, 2])])


def doubt_of_camera(intrinsics: Intrinsics, shape: Sequence[int]) -> str:
    """Return why intrinsics are perhaps not those of an image (rows, columns); empty if nothing speaks against them."""
    fx, fy, cx, cy = intrinsics
    rows, columns = shape
    off = max(abs(cx / columns - 0.5), abs(cy / rows - 0.5))
    if off < _OFF_CENTRE and 1 / _NOT_SQUARE < fx / fy < _NOT_SQUARE:
        return ""
    said = ",".join(f"{number:g}" for number in intrinsics)
    return f"intrinsics {said} are perhaps of another image than one of {columns} x {rows} pixels"
