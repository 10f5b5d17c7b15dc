"""Clouds of fields that rsegen makes, as a depth camera sees them, spoiled a little or a lot, and what is found.

number --> field --camera--> points --spoiled--> file --rsegen.scan--> field
             |_______________ the same, as far as it was seen ___________|   unless it was spoiled a lot
"""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

import rsegen
from benchmarks.depth_camera import DepthCamera, Flaws, scanned, turned
from rsegen.errors import ScanError
from rsegen.field.stepfield import Array, StepField
from rsegen.scanning.scan_options import ScanOptions

VIEW = DepthCamera(place=(0.6, 0.2, 2.2), columns=160, rows=120, focal=140)
VIEWS = (VIEW, replace(VIEW, place=(-0.5, -0.4, 2.2)))
_SEEN = 0.75
"""Share of cells that must be seen if little was spoiled: two views see behind nearly all blocks."""


class Wrong(AssertionError):
    """A field that was found and is another one, though little was spoiled."""


@dataclass(kw_only=True)
class _Spoiled:
    """A cloud, what it is spoiled by, and whether by more than a scan can have; known: what is said of the field."""

    points: Array
    flaws: list[str] = field(default_factory=list)
    is_beyond: bool = False
    known: dict[str, Any] = field(default_factory=dict)


Outcome = Literal["found", "found halved", "missed", "found in spite of much", "refused for much"]


def scan_of(number: int) -> Outcome:
    """Scan a cloud that a number stands for, and return what became of it.

    Wrong if a cloud was spoiled a little and another field was found in it. Of few such clouds nothing is found, or,
    where the width of the blocks is not said, blocks of half of it: neither is a failure, and tests count them.
    """
    rng = random.Random(number)  # noqa: S311  # no secret
    made = _field(rng)
    cloud = _spoiled(rng, made)
    try:
        found = rsegen.scan(_written(rng, cloud), ScanOptions(**cloud.known))
    except ScanError:
        return "refused for much" if cloud.is_beyond else "missed"
    scan = found.scan
    told = f"{', '.join(cloud.flaws)}; known: {cloud.known}"
    if not ((scan.confidence >= 0) & (scan.confidence <= 1)).all() or not scan.seen.any():
        raise Wrong(f"found without a confidence ({told})")
    levels = np.where(scan.frame, 0, found.field.levels)
    if not np.array_equal(levels[scan.seen], np.where(scan.frame, 0, scan.levels)[scan.seen]):
        raise Wrong(f"the recipe makes another field than was found ({told})")
    if cloud.is_beyond:
        return "found in spite of much"
    if "block_width_cm" not in cloud.known and abs(2 * scan.block_width - made.block_width) < 0.002:
        return "found halved"
    _refuse_other(scan, made, told)
    return "found"


def _refuse_other(scan: Any, made: StepField, told: str) -> None:
    """Raise Wrong if a scan is not of this field, as far as it was seen, in any of four headings."""
    if abs(scan.unit - made.unit) > 0.003 or abs(scan.block_width - made.block_width) > 0.002:
        raise Wrong(f"blocks of {scan.block_width:.4f} m, a unit of {scan.unit:.4f} m ({told})")
    if scan.seen.mean() < _SEEN:
        raise Wrong(f"{scan.seen.mean():.0%} of the cells were seen ({told})")
    for turns in range(4):
        levels, seen = np.rot90(scan.levels, turns), np.rot90(scan.seen, turns)
        if levels.shape == made.levels.shape and (levels == made.levels)[seen].all():
            return
    raise Wrong(f"levels of {scan.levels.shape} cells are not those of {made.levels.shape} ({told})")


def _field(rng: random.Random) -> StepField:
    """Draw a field of random blocks, with or without frames."""
    kinds: Sequence[dict[str, Any]] = (
        {"boundary": "none", "chunk_size": 8},
        {"boundary": "outer", "chunk_size": 9},
        {"boundary": "outer", "chunk_size": 7, "chunks": (1, 2)},
        {"boundary": "divided", "chunk_size": 6, "chunks": (2, 1)},
        {"boundary": "none", "chunk_size": 10, "unit_cm": 5},
    )
    obstacle = rsegen.Random(levels=rng.randint(4, 6))
    return rsegen.build(rsegen.Recipe(seed=rng.randrange(10**6), obstacles=[obstacle], **rng.choice(kinds)))


def _spoiled(rng: random.Random, made: StepField) -> _Spoiled:
    """Return the cloud of a field, spoiled a little in several ways, and in every third case a lot in one."""
    numbers = np.random.default_rng(rng.randrange(2**32))
    flaws = Flaws(noise=rng.uniform(0, 0.005), missing=rng.uniform(0, 0.2), outliers=rng.uniform(0, 0.02))
    cloud = _Spoiled(points=scanned(made, VIEWS, flaws, numbers), flaws=[str(flaws)])
    if rng.random() < 0.5:
        n_x, n_y = (len(np.flatnonzero(~made.frame.all(axis=axis))) for axis in (1, 0))
        cloud.known["size"] = (n_x, n_y)
    if rng.random() < 0.5:
        cloud.known["block_width_cm"] = made.block_width * 100
    for change in rng.sample(_LITTLE, rng.randint(0, len(_LITTLE))):
        change(rng, numbers, cloud)
    if rng.random() < 0.3:
        _millimetres(rng, numbers, cloud)
    if "size" in cloud.known and "turned" in cloud.flaws:
        del cloud.known["size"]  # which side is along x, a person sees who stands before it
    if rng.random() < 0.35:
        cloud.is_beyond = True
        rng.choice(_MUCH)(rng, numbers, cloud)
    return cloud


_Change = Callable[[random.Random, np.random.Generator, _Spoiled], None]


def _turn(_: random.Random, numbers: np.random.Generator, cloud: _Spoiled) -> None:
    cloud.points = turned(cloud.points, numbers)
    cloud.flaws.append("turned")


def _hole(rng: random.Random, numbers: np.random.Generator, cloud: _Spoiled) -> None:
    """Remove the points of a block's size, as where a shiny thing lay."""
    middle = cloud.points[numbers.integers(len(cloud.points))]
    cloud.points = cloud.points[np.linalg.norm(cloud.points - middle, axis=1) > rng.uniform(0.01, 0.06)]
    cloud.flaws.append("hole")


def _shuffle(_: random.Random, numbers: np.random.Generator, cloud: _Spoiled) -> None:
    cloud.points = numbers.permutation(cloud.points)
    cloud.flaws.append("shuffled")


def _twice(rng: random.Random, numbers: np.random.Generator, cloud: _Spoiled) -> None:
    again = cloud.points[numbers.random(len(cloud.points)) < rng.uniform(0.05, 0.3)]
    cloud.points = np.vstack([cloud.points, again])
    cloud.flaws.append("points twice")


def _undefined(rng: random.Random, numbers: np.random.Generator, cloud: _Spoiled) -> None:
    """Add pixels without a depth, as many cameras write them."""
    cloud.points = np.vstack([cloud.points, np.full((rng.randint(1, 500), 3), np.nan)])
    cloud.flaws.append("undefined points")


def _millimetres(_: random.Random, numbers: np.random.Generator, cloud: _Spoiled) -> None:
    cloud.points = cloud.points * 1000
    cloud.known["values"] = "mm"
    cloud.flaws.append("mm")


_LITTLE: Sequence[_Change] = (_turn, _hole, _shuffle, _twice, _undefined)
"""Changes in spite of which the field is found."""


def _much_noise(rng: random.Random, numbers: np.random.Generator, cloud: _Spoiled) -> None:
    size = 1000 if cloud.known.get("values") else 1
    cloud.points = cloud.points + numbers.normal(0, rng.uniform(0.015, 0.06) * size, cloud.points.shape)
    cloud.flaws.append("much noise")


def _few_points(rng: random.Random, numbers: np.random.Generator, cloud: _Spoiled) -> None:
    cloud.points = cloud.points[numbers.random(len(cloud.points)) < rng.uniform(0.001, 0.1)]
    cloud.flaws.append("few points")


def _other_units(rng: random.Random, _: np.random.Generator, cloud: _Spoiled) -> None:
    cloud.points = cloud.points * rng.choice((0.001, 0.0254, 0.3048, 3.28, 39.37, 1000.0))
    cloud.known.pop("block_width_cm", None)  # a cloud of 30 m with blocks of 10 cm is looked at for 12 s
    cloud.flaws.append("units that nobody says")


def _things(rng: random.Random, numbers: np.random.Generator, cloud: _Spoiled) -> None:
    """Add points in a box beside, on or under the field."""
    low, high = np.nanmin(cloud.points, axis=0), np.nanmax(cloud.points, axis=0)
    box = numbers.random((rng.randint(100, 5000), 3)) * rng.uniform(0.02, 0.5) * (high - low)
    cloud.points = np.vstack([cloud.points, low + box + numbers.random(3) * (high - low)])
    cloud.flaws.append("things beside it")


def _cut(rng: random.Random, _: np.random.Generator, cloud: _Spoiled) -> None:
    axis, share = rng.randrange(3), rng.uniform(20, 80)
    cloud.points = cloud.points[cloud.points[:, axis] < np.nanpercentile(cloud.points[:, axis], share)]
    cloud.flaws.append("cut off")


def _bent(rng: random.Random, _: np.random.Generator, cloud: _Spoiled) -> None:
    """Bend the whole, as a sensor that is not calibrated does."""
    cloud.points = cloud.points.copy()
    cloud.points[:, 2] += rng.uniform(-0.2, 0.2) * cloud.points[:, 0] ** 2
    cloud.flaws.append("bent")


_MUCH: Sequence[_Change] = (_much_noise, _few_points, _other_units, _things, _cut, _bent)
"""Changes after which a field may be found, or not, and nothing breaks."""


def _written(rng: random.Random, cloud: _Spoiled) -> Path | Array:
    """Return the points as a file in the working folder, or as they are, which is in metres."""
    kind = rng.choice((".npy", ".xyz", ".ply", *(() if "values" in cloud.known else ("array",))))
    points = cloud.points
    path = Path(f"cloud{kind}")
    if kind == "array":
        return points
    if kind == ".npy":
        np.save(path, points.astype(rng.choice(("f4", "f8"))))
    elif kind == ".xyz":
        np.savetxt(path, points[np.isfinite(points).all(axis=1)], fmt="%.5f")
    else:
        import trimesh

        trimesh.PointCloud(points[np.isfinite(points).all(axis=1)]).export(path)
    return path
