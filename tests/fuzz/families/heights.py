"""Inputs of `import`: tables, arrays, images and maps of ROS."""

from __future__ import annotations

import random

import numpy as np

from tests.fuzz import seeds
from tests.fuzz.case import Case, Content
from tests.fuzz.damage import damaged_bytes, damaged_npy, damaged_png, damaged_text, damaged_tiff
from tests.fuzz.families.recipes import special_or, written

_OPTIONS: tuple[list[str], ...] = (
    [],
    [],
    [],
    ["--rounded"],
    ["--unit-cm", "1"],
    ["--chunk-size", "2"],
    ["--values", "levels"],
)
_IMAGE_OPTIONS: tuple[list[str], ...] = (
    [],
    [],
    ["--levels", "9"],
    ["--size", "3x3"],
    ["--threshold", "50"],
    ["--invert"],
)


def _case(
    rng: random.Random, name: str, files: dict[str, Content], options: tuple[list[str], ...], family: str
) -> Case:
    flags = [*rng.choice(options), "-o", "out", "--workers", "1"]
    return Case(family=family, argv=("import", name, *flags), files=files, outputs=("out",))


def table(rng: random.Random) -> Case:
    """A table of heights, or a build sheet."""
    content = seeds.build_sheet() if rng.random() < 0.3 else rng.choice(seeds.TABLES)
    for _ in range(rng.choice((1, 1, 2, 3))):
        content = damaged_text(rng, content)
    return _case(rng, "t.csv", {"t.csv": special_or(rng, content)}, _OPTIONS, "table")


def array(rng: random.Random) -> Case:
    """An array of numpy."""
    values = np.arange(0, 160, 10).reshape(4, 4).astype(rng.choice(("f8", "f4", "i4", "u1", ">i2", "f2")))
    if rng.random() < 0.2:
        values = rng.choice(
            (values * 1j, values[0], values[None], values.astype("O"), values.astype("S3"), values / 0.3, values[:0])
        )
    if rng.random() < 0.2 and values.size and values.dtype.kind == "f":
        values.flat[3] = rng.choice((np.nan, np.inf, -np.inf, -1.0, 6e4))
    content = seeds.array(values)
    if rng.random() < 0.8:
        content = damaged_npy(rng, content) if rng.random() < 0.6 else damaged_bytes(rng, content)
    return _case(rng, "a.npy", {"a.npy": special_or(rng, content)}, _OPTIONS, "array")


def image(rng: random.Random) -> Case:
    """An image."""
    name = rng.choice(sorted(seeds.images()))
    content = _damaged_image(rng, name, seeds.images()[name])
    if rng.random() < 0.05:
        name = f"{name}{rng.choice(('.png', '.tif', '.jpg', '.pgm', '.bmp'))}"
    return _case(rng, name, {name: special_or(rng, content)}, _IMAGE_OPTIONS, "image")


def _damaged_image(rng: random.Random, name: str, content: bytes) -> bytes:
    kind = name.rpartition(".")[2]
    if kind == "png" and rng.random() < 0.7:
        return damaged_png(rng, content)
    if kind == "tif" and rng.random() < 0.8:
        content = damaged_tiff(rng, content)
        return damaged_tiff(rng, content) if rng.random() < 0.2 and content[:4] == b"II*\0" else content
    if kind == "pgm" and rng.random() < 0.6:
        head, rest = content[:16], content[16:]
        return damaged_text(rng, head) + rest
    return damaged_bytes(rng, content)


def ros(rng: random.Random) -> Case:
    """An occupancy map of ROS."""
    tree = dict(seeds.ROS_MAP)
    picture = seeds.images()["grey.pgm"]
    if rng.random() < 0.3:
        picture = _damaged_image(rng, "grey.pgm", picture)
    strange = (
        "../grey.pgm",
        "/dev/zero",
        "",
        ".",
        "map.yaml",
        "/",
        "grey.pgm\0",
        "\x1b.pgm",
        "none.pgm",
        "x" * 499 + ".pgm",
        "~/x.pgm",
    )
    if rng.random() < 0.2:
        tree["image"] = rng.choice(strange)
    files = {"map.yaml": special_or(rng, written(rng, tree, yaml_=True)), "grey.pgm": special_or(rng, picture)}
    return _case(rng, "map.yaml", files, ([], [], ["--chunk-size", "2"], ["--unit-cm", "5"]), "ros")
