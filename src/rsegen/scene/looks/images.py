"""Smooth random images, of additions and multiplications only, and their PNG files.

Noise is value noise: random numbers on a coarse grid, between which pixels are interpolated with the cubic
s^2 (3 - 2 s), which has no slope at the grid lines (as in Perlin 1985). PNG files have a palette of at most 256 colours
(ISO/IEC 15948) and are written with the standard library alone; their bytes depend on zlib's version, their pixels do
not.
"""

from __future__ import annotations

import struct
import zlib

import numpy as np

from rsegen.field.stepfield import Array


def noise(rng: np.random.Generator, shape: tuple[int, int, int], cells: tuple[int, int]) -> Array:
    """Return images (count, rows, columns) of values -1..1, smooth between random ones on a grid of `cells`."""
    count, rows, columns = shape
    known = rng.random((count, cells[0] + 1, cells[1] + 1)) * 2 - 1
    (top, bottom, down), (left, right, across) = (_between(n, k) for n, k in ((rows, cells[0]), (columns, cells[1])))
    upper, lower = (known[:, row] for row in (top, bottom))
    lines = upper + (lower - upper) * down[:, None]
    return np.asarray(lines[:, :, left] + (lines[:, :, right] - lines[:, :, left]) * across)


def _between(pixels: int, cells: int) -> tuple[Array, Array, Array]:
    """Return for every pixel the grid line before it, the one after it, and its eased place between them: 0..1."""
    place = np.arange(pixels) / pixels * cells
    before = place.astype(int)
    share = place - before
    return before, before + 1, share * share * (3 - 2 * share)


def one_per_image(rng: np.random.Generator, count: int, low: float, high: float) -> Array:
    """Return a random number between `low` and `high` per image, (count, 1, 1)."""
    return low + (high - low) * rng.random((count, 1, 1))


def png(indices: Array, palette: Array) -> bytes:
    """Return the PNG file of an image: indices uint8 (rows, columns) into a palette uint8 (n, 3) of sRGB colours."""
    rows, columns = indices.shape
    lines = np.pad(indices, ((0, 0), (1, 0)))  # each line begins with its filter, 0
    parts = {
        b"IHDR": struct.pack(">IIBBBBB", columns, rows, 8, 3, 0, 0, 0),
        b"PLTE": palette.tobytes(),
        b"IDAT": zlib.compress(lines.tobytes(), 9),
        b"IEND": b"",
    }
    file = b"\x89PNG\r\n\x1a\n"
    for kind, content in parts.items():
        file += struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
    return file
