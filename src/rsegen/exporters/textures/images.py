"""Smooth random images, of additions and multiplications only.

PNG files of at most 256 colours (ISO/IEC 15948), with the standard library alone.
"""

from __future__ import annotations

import struct
import zlib

import numpy as np

from rsegen.field.stepfield import Array


def noise(rng: np.random.Generator, shape: tuple[int, int, int], cells: tuple[int, int]) -> Array:
    """Images (count, rows, columns) of values -1..1 that change smoothly between random ones on a grid of `cells`."""
    count, rows, columns = shape
    known = rng.random((count, cells[0] + 1, cells[1] + 1)) * 2 - 1
    (top, bottom, down), (left, right, across) = (_between(n, k) for n, k in ((rows, cells[0]), (columns, cells[1])))
    upper, lower = (known[:, row] for row in (top, bottom))
    lines = upper + (lower - upper) * down[:, None]
    return np.asarray(lines[:, :, left] + (lines[:, :, right] - lines[:, :, left]) * across)


def _between(pixels: int, cells: int) -> tuple[Array, Array, Array]:
    """Of every pixel the grid line before it, the one after it, and how far it is on the way, eased: 0..1."""
    place = np.arange(pixels) / pixels * cells
    before = place.astype(int)
    share = place - before
    return before, before + 1, share * share * (3 - 2 * share)


def each(rng: np.random.Generator, count: int, low: float, high: float) -> Array:
    """One number between `low` and `high` per image, (count, 1, 1)."""
    return low + (high - low) * rng.random((count, 1, 1))


_SIGNATURE = b"\x89PNG\r\n\x1a\n"


def png(indices: Array, palette: Array) -> bytes:
    """The PNG file of an image: indices uint8 (rows, columns) into a palette uint8 (n, 3) of sRGB colours."""
    rows, columns = indices.shape
    head = struct.pack(">IIBBBBB", columns, rows, 8, 3, 0, 0, 0)
    lines = np.pad(indices, ((0, 0), (1, 0)))  # each line begins with its filter, 0
    parts = (
        (b"IHDR", head),
        (b"PLTE", palette.tobytes()),
        (b"IDAT", zlib.compress(lines.tobytes(), 9)),
        (b"IEND", b""),
    )
    return _SIGNATURE + b"".join(_chunk(kind, content) for kind, content in parts)


def _chunk(kind: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
