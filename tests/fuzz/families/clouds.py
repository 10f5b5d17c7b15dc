"""Inputs of `scan` and `compare`: clouds that are damaged, or of shapes that no field has."""

from __future__ import annotations

import json
import random
import struct
from collections.abc import Callable, Mapping

import numpy as np

from tests.fuzz import seeds
from tests.fuzz.case import Case
from tests.fuzz.damage import damaged_bytes, damaged_headed, damaged_npy, damaged_png, damaged_text, damaged_tiff
from tests.fuzz.families.recipes import special_or
from tests.fuzz.hostile import as_text, damaged_tree

_OPTIONS: tuple[list[str], ...] = (
    [],
    [],
    ["--values", "mm"],
    ["--up", "x"],
    ["--up=-z"],
    ["--size", "2x3"],
    ["--unit-cm", "5"],
    ["--block-width-cm", "3"],
    ["--boundary", "divided", "--chunk-size", "2"],
    ["--base-cm", "2"],
    ["--fill-holes"],
    ["--intrinsics", "9,9,4,4"],
)

_SHAPES: Mapping[str, Callable[[np.random.Generator, np.ndarray], np.ndarray]] = {
    "a field": lambda _, points: points,
    "a volume": lambda numbers, points: numbers.random(points.shape),
    "a floor": lambda _, points: points * (1, 1, 0),
    "a line": lambda _, points: points * (1, 0, 0),
    "a point": lambda _, points: points * 0 + 1,
    "two points": lambda _, points: np.rint(points[:, :1]) * (1, 1, 1),
    "huge": lambda _, points: points * 1e200,
    "tiny": lambda _, points: points * 1e-9,
    "far away": lambda _, points: points + 1e9,
    "one far point": lambda _, points: np.vstack([points, [1e8, -1e8, 3e7]]),
    "holes": lambda numbers, points: np.where(numbers.random(points.shape) < 0.3, np.nan, points),
    "no end": lambda numbers, points: np.where(numbers.random(points.shape) < 0.1, np.inf, points),
    "a step": lambda _, points: points * (1, 1, 0) + np.outer(points[:, 0] > 0, (0, 0, 0.1)),
    "stripes": lambda _, points: points * (1, 1, 0) + np.outer(np.floor(points[:, 0] * 9) % 2, (0, 0, 0.1)),
    "a slope": lambda _, points: points * (1, 1, 0) + np.outer(points[:, 0], (0, 0, 1)),
    "few": lambda _, points: points[:520],
}


def case(rng: random.Random) -> Case:
    """A cloud, and what is asked of it."""
    numbers = np.random.default_rng(rng.randrange(2**32))
    shape = _SHAPES[rng.choice(sorted(_SHAPES))]
    points = shape(numbers, seeds.cloud(numbers))
    name, content = rng.choice((_text, _array, _real, _real))(rng, points)
    if rng.random() < 0.1:
        name = f"c.{rng.choice(('ply', 'pcd', 'stl', 'glb', 'obj', 'png'))}"
    flags = ["--intrinsics", "60,60,32,24"] if name.startswith("depth") and rng.random() < 0.8 else rng.choice(_OPTIONS)
    files = {name: special_or(rng, content)}
    if rng.random() < 0.5 or flags[:1] == ["--fill-holes"]:
        argv: tuple[str, ...] = ("scan", name, *flags, "-o", "out", "--workers", "1")
    else:
        argv = ("compare", name, "peak", *flags, "-o", "out.png")
    return Case(family="cloud", argv=argv, files=files, outputs=("out", "out.png"))


def _real(rng: random.Random, _: np.ndarray) -> tuple[str, bytes]:
    """A file as a library wrote it, whole or damaged."""
    name = rng.choice(sorted(seeds.clouds()))
    content = seeds.clouds()[name]
    return name, content if rng.random() < 0.05 else damaged(rng, name, content)


def damaged(rng: random.Random, name: str, content: bytes) -> bytes:
    """A file of a cloud that is damaged where its format has numbers and sizes, or anywhere."""
    kind = name.rpartition(".")[2]
    if kind in ("xyz", "csv", "obj") or name.startswith("ascii"):
        return damaged_text(rng, content)
    if kind in _HEADERS:
        return damaged_headed(rng, content, _HEADERS[kind])
    if kind == "glb" and rng.random() < 0.7:
        return _damaged_glb(rng, content)
    own = {"png": damaged_png, "tif": damaged_tiff, "npy": damaged_npy}
    return own[kind](rng, content) if kind in own and rng.random() < 0.7 else damaged_bytes(rng, content)


_HEADERS = {"ply": b"end_header\n", "pcd": b"\nDATA ", "pgm": b"65535\n"}
"""Bytes that end the text at the beginning of a file."""


def _damaged_glb(rng: random.Random, content: bytes) -> bytes:
    """A glTF in bytes whose JSON is wrong in a place or a few, and whose lengths are right."""
    (length,) = struct.unpack("<I", content[12:16])
    text = as_text(damaged_tree(rng, json.loads(content[20 : 20 + length]), yaml=False)).encode("utf-8", "replace")
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I", len(text)) + content[16:20] + text + content[20 + length :]
    return content[:8] + struct.pack("<I", 12 + len(chunks)) + chunks


def _text(rng: random.Random, points: np.ndarray) -> tuple[str, bytes]:
    content = "\n".join(" ".join(f"{value:.4g}" for value in point) for point in points).encode()
    return "c.xyz", damaged_text(rng, content) if rng.random() < 0.3 else content


def _array(rng: random.Random, points: np.ndarray) -> tuple[str, bytes]:
    with np.errstate(over="ignore"):
        content = seeds.array(points.astype(rng.choice(("f8", "f4"))))
    if rng.random() < 0.2:
        content = damaged_npy(rng, content) if rng.random() < 0.5 else damaged_bytes(rng, content)
    return "c.npy", content
