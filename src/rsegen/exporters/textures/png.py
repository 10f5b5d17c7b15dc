"""PNG files of at most 256 colours (ISO/IEC 15948), with the standard library alone."""

from __future__ import annotations

import struct
import zlib

import numpy as np

from rsegen.field.stepfield import Array

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
