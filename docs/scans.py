"""The pictures of scans in the manual: `python -m docs.scans`."""

from __future__ import annotations

import sys
from dataclasses import replace
from io import BytesIO
from pathlib import Path

import numpy as np
from PIL import Image

import rsegen
from benchmarks.depth_camera import DepthCamera, Flaws, scanned, turned
from rsegen import Random, Recipe

PICTURES = Path(__file__).parent / "pictures"
WANTED = Recipe(name="wanted", seed=7, boundary="outer", obstacles=(Random(levels=5),))
EYES = (DepthCamera(place=(0.7, 0.2, 2.2)), DepthCamera(place=(-0.7, -0.1, 2.2)))
WRONG = {(4, 4): -1, (7, 9): 1, (8, 2): 2}
"""Cells that are built otherwise than they should, frames counted, and by how many levels."""


def main() -> int:
    """Make both pictures: the fit of a scan with two views, and what is built wrong."""
    field = rsegen.build(WANTED, 0)
    levels = field.levels.copy()
    for cell, more in WRONG.items():
        levels[cell] = max(levels[cell] + more, 0)
    rng = np.random.default_rng(1)
    flaws = Flaws(noise=0.005, missing=0.2, outliers=0.02)
    cloud = turned(scanned(replace(field, levels=levels), EYES, flaws, rng), rng)
    fit = Image.open(BytesIO(rsegen.scan(cloud).picture())).convert("RGB")
    fit.save(PICTURES / "scan-fit.jpg", quality=85)
    (PICTURES / "compare.png").write_bytes(rsegen.compare(cloud, WANTED).picture())
    return 0


if __name__ == "__main__":
    sys.exit(main())
