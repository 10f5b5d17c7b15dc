"""Geometries of collisions, as SDF and as the files that it names."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from rsegen.field.stepfield import Array
from rsegen.params.numbers import decimal

Point = tuple[float, float, float]


class Shape(Protocol):
    """A geometry somewhere in the field."""

    @property
    def centre(self) -> Point:
        """Metres."""

    def geometry(self, name: str) -> str:
        """The content of its <geometry>; `name` is that of its file."""

    def files(self, name: str) -> Mapping[str, bytes]:
        """The files that the geometry names."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Box:
    """A box by its centre and its lengths, metres."""

    centre: Point
    size: Point

    def geometry(self, name: str) -> str:
        """It needs no file."""
        return f"<box><size>{_words(self.size)}</size></box>"

    def files(self, name: str) -> Mapping[str, bytes]:
        """None."""
        return {}


@dataclass(frozen=True, kw_only=True, slots=True)
class Triangles:
    """Corners of triangles, (m, 3, 3) metres, counterclockwise seen from outside; equal corners become one vertex."""

    corners: Array
    centre: Point = (0, 0, 0)

    def geometry(self, name: str) -> str:
        """A mesh."""
        return f"<mesh><uri>{name}.obj</uri></mesh>"

    def files(self, name: str) -> Mapping[str, bytes]:
        """Wavefront OBJ with a normal for each triangle."""
        points, numbers = np.unique(np.round(self.corners, 9).reshape(-1, 3), axis=0, return_inverse=True)
        edges = self.corners[:, 1:] - self.corners[:, :1]
        normals = np.cross(edges[:, 0], edges[:, 1])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        lines = [f"v {_words(point)}" for point in points.tolist()]
        lines += [f"vn {_words(normal)}" for normal in normals.tolist()]
        for normal, (a, b, c) in enumerate(numbers.reshape(-1, 3) + 1, 1):
            lines.append(f"f {a}//{normal} {b}//{normal} {c}//{normal}")
        return {f"{name}.obj": ("\n".join(lines) + "\n").encode()}


@dataclass(frozen=True, kw_only=True, slots=True)
class Heights:
    """A height map: samples (n, n) of 0..255 along x and y, n - 1 a power of two; side and height of a 255 [m]."""

    samples: NDArray[np.uint8]
    side: float
    height: float
    centre: Point = (0, 0, 0)

    def geometry(self, name: str) -> str:
        """Gazebo stretches an image over its brightest sample."""
        size = f"{decimal(self.side)} {decimal(self.side)} {decimal(self.height * int(self.samples.max()) / 255)}"
        return (
            f"<heightmap><uri>file://{name}.png</uri><size>{size}</size>"
            "<pos>0 0 0</pos><sampling>1</sampling></heightmap>"
        )

    def files(self, name: str) -> Mapping[str, bytes]:
        """A grey PNG, its first row at the greatest y."""
        return {f"{name}.png": _png(self.samples.T[::-1])}


def _png(pixels: NDArray[np.uint8]) -> bytes:
    rows, columns = pixels.shape
    raw = np.concatenate([np.zeros((rows, 1), np.uint8), pixels], axis=1).tobytes()
    header = struct.pack(">IIBBBBB", columns, rows, 8, 0, 0, 0, 0)
    parts = [_chunk(b"IHDR", header), _chunk(b"IDAT", zlib.compress(raw)), _chunk(b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(parts)


def _chunk(kind: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))


def _words(numbers: Point) -> str:
    return " ".join(decimal(round(number, 9)) for number in numbers)
