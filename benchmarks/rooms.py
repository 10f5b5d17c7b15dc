"""Scans of rooms in which a field stands among walls, furniture and people, and of rooms without a field.

python -m benchmarks.rooms             prints the table and keeps benchmarks/results/rooms.json; ten minutes
python -m benchmarks.rooms --seed 7    the same rooms again; by default the seed is drawn

MuJoCo casts the rays of two to four depth cameras that look at the middle of a room of one to four walls with one to
three things: people, cartons, tables, chairs, of which none touches the field. Small fields stand on a table. Of the
points 20 % are missing, 2 % are outliers, and all have 5 mm of noise, or 2 mm of the nearer table; the cloud is turned
and tilted. Nothing is told to the scan.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from time import process_time
from typing import Any

import numpy as np

import rsegen
from benchmarks.depth_camera import DepthCamera, Flaws, turned, with_flaws
from benchmarks.figures import RESULTS, keep, say
from benchmarks.machine import machine
from benchmarks.scan import KINDS, TILT
from rsegen.errors import ScanError
from rsegen.field.stepfield import Array, StepField
from rsegen.recipe.codec import decode
from rsegen.scanning.finding import find_field
from rsegen.scanning.scan import SURE, Scan

FILE = RESULTS / "rooms.json"
FLAWS = Flaws(noise=0.005, missing=0.2, outliers=0.02)
ON_TABLE = "5 cm, on a table"
FIELDS = {**KINDS, ON_TABLE: {"boundary": "outer", "block_width_cm": 5, "unit_cm": 2.5, "frame_height_cm": 5}}
_TABLE = 0.7
"""Height of the table [m]."""

_HALF_FIELD = 0.95
"""Metres from the middle to a corner of the largest field: things stand beyond."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Visit:
    """One room: what was found of its field.

    in_all: whether one was found in the whole cloud; found: by rsegen.scan, with its cells, those seen, and the wrong
    ones of those; sure_wrong: those among them that are said to be sure; unit_off: share by which the measured unit is
    off; seconds: CPU time of rsegen.scan.
    """

    seed: int
    kind: str
    in_all: bool
    found: bool
    cells: int = 0
    seen: int = 0
    wrong: int = 0
    sure_wrong: int = 0
    unit_off: float = 0.0
    seconds: float


def field_in(seed: int, kind: str) -> rsegen.Recipe:
    """Return the recipe of the field in a room: random blocks of five levels."""
    return decode({"name": "room", "seed": seed, "obstacles": [{"kind": "random", "levels": 5}], **FIELDS[kind]})


def room(seed: int, kind: str) -> Array:
    """Return the cloud of a room (n, 3) [m], with a field of some kind in its middle; without a kind there is none."""
    rng = np.random.default_rng(seed)
    on_table = kind == ON_TABLE
    away, focal, high, flaws = (0.7, 260, _TABLE, replace(FLAWS, noise=0.002)) if on_table else (0.9, 170, 0.0, FLAWS)
    field = _blocks(rsegen.build(field_in(seed, kind), 0), high, rng.uniform(0, 90)) if kind else ()
    table = (_box((0, 0, _TABLE / 2), (*rng.uniform(0.5, 0.7, 2), _TABLE / 2), rng.uniform(0, 90)),) if on_table else ()
    geoms = [*field, *table, *_walls(rng), *_things(rng, is_empty=not kind)]
    views = int(rng.integers(2, 5))
    cameras = [
        DepthCamera(
            place=(away * np.cos(angle), away * np.sin(angle), rng.uniform(1.5, 1.9)), target=(0, 0, high), focal=focal
        )
        for angle in 2 * np.pi * (np.arange(views) + rng.uniform(0, 0.3, views)) / views
    ]
    return turned(with_flaws(cast_by_mujoco("".join(geoms), cameras, farthest=6), flaws, rng), rng, TILT)


def cast_by_mujoco(geoms: str, cameras: Sequence[DepthCamera], farthest: float = 2) -> list[tuple[Array, Array]]:
    """Return the points that rays of some cameras meet on geoms and level floor, each with its camera's place [m]."""
    import mujoco

    floor = '<geom type="plane" size="9 9 1"/>'
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{floor}{geoms}</worldbody></mujoco>")
    scene = mujoco.MjData(model)
    mujoco.mj_forward(model, scene)
    clouds = []
    for camera in cameras:
        place, rays = np.array(camera.place), camera.directions()
        hit, nothing = np.zeros(1, np.int32), None
        distances = np.array([mujoco.mj_ray(model, scene, place, ray, nothing, 1, -1, hit) for ray in rays])
        points = place + rays * distances[:, None]
        clouds.append((place, points[(distances > 0) & (np.hypot(*points[:, :2].T) < farthest)]))
    return clouds


def _box(place: Sequence[float], half: Sequence[float], degrees: float = 0) -> str:
    x, y, z = place
    return f'<geom type="box" pos="{x} {y} {z}" size="{half[0]} {half[1]} {half[2]}" euler="0 0 {degrees}"/>'


def _blocks(field: StepField, floor: float, degrees: float) -> Iterator[str]:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    width = field.block_width
    for i, j in np.argwhere(field.heights > 0):
        x, y = ((at + 0.5 - cells / 2) * width for at, cells in zip((i, j), field.shape, strict=True))
        half = field.heights[i, j] / 2
        yield _box((c * x - s * y, s * x + c * y, floor + half), (width / 2, width / 2, half), degrees)


def _walls(rng: np.random.Generator) -> Iterator[str]:
    for wall in rng.permutation(4)[: rng.integers(1, 5)]:
        away = _HALF_FIELD + rng.uniform(0.2, 1.7)
        x, y = ((away, 0), (-away, 0), (0, away), (0, -away))[wall]
        yield _box((x, y, 1.25), (0.05, 4, 1.25) if wall < 2 else (4, 0.05, 1.25))


def _things(rng: np.random.Generator, *, is_empty: bool) -> Iterator[str]:
    for _ in range(rng.integers(1, 4)):
        angle = rng.uniform(0, 2 * np.pi)
        away = rng.uniform(0, 1.5) if is_empty else _HALF_FIELD + rng.uniform(0.3, 0.9)
        x, y, turn = away * np.cos(angle), away * np.sin(angle), rng.uniform(0, 180)
        match rng.integers(4):
            case 0:  # a person
                yield f'<geom type="cylinder" pos="{x} {y} 0.85" size="0.18 0.85"/>'
            case 1:  # a carton
                yield _box((x, y, 0.15), (0.2, 0.15, 0.15), turn)
            case 2:  # a table
                yield _box((x, y, 0.72), (0.35, 0.28, 0.02))
                legs = [(x + dx, y + dy) for dx in (-0.3, 0.3) for dy in (-0.23, 0.23)]
                yield from (_box((*leg, 0.35), (0.02, 0.02, 0.35)) for leg in legs)
            case _:  # a chair
                yield _box((x, y, 0.45), (0.2, 0.2, 0.02))
                yield _box((x + 0.19, y, 0.7), (0.02, 0.2, 0.25))


def visit(seed: int, kind: str) -> Visit:
    """Scan one room, with a field of some kind or without."""
    field = rsegen.build(field_in(seed, kind), 0) if kind else None
    cloud = room(seed, kind)
    try:
        find_field(cloud)
        in_all = True
    except ScanError:
        in_all = False
    start = process_time()
    try:
        scan = rsegen.scan(cloud).scan
    except ScanError:
        scan = None
    result = Visit(seed=seed, kind=kind, in_all=in_all, found=scan is not None, seconds=process_time() - start)
    if scan is None:
        return result
    turns = [turn for turn in range(4) if field and np.rot90(scan.levels, turn).shape == field.shape]
    seen, sure = int(scan.seen.sum()), int((scan.confidence > SURE).sum())
    wrong, sure_wrong = min((_wrong(scan, field, turn) for turn in turns if field), default=(seen, sure))
    off = abs(scan.measured_unit / field.unit - 1) if field else 0.0
    return replace(result, cells=scan.levels.size, seen=seen, wrong=wrong, sure_wrong=sure_wrong, unit_off=off)


def _wrong(scan: Scan, field: StepField, turn: int) -> tuple[int, int]:
    """Return how many levels, and sure levels, are wrong after some quarter turns."""
    levels, seen, sure = (np.rot90(each, turn) for each in (scan.levels, scan.seen, scan.confidence > SURE))
    wrong = seen & (levels != field.levels)
    return int(wrong.sum()), int((wrong & sure).sum())


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit code 0."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.rooms", description=__doc__)
    parser.add_argument("--seed", type=int, default=int(np.random.default_rng().integers(10**9)))
    parser.add_argument("--rooms", type=int, default=25, help="of each kind of field, and without one (default: 25)")
    parser.add_argument("--only-print", action="store_true", help="keep nothing")
    options = parser.parse_args(arguments)
    visits = []
    for number in range(options.rooms):
        for kind in (*FIELDS, ""):
            visits.append(visit(options.seed + number, kind))
            say(f"{kind or 'no field'}, room {options.seed + number}: {visits[-1]}")
    record = {"machine": machine(), "seed": options.seed, "visits": [asdict(each) for each in visits]}
    print("\n".join(table(record)))
    if not options.only_print:
        keep(record, FILE)
    return 0


def table(record: Mapping[str, Any]) -> Iterator[str]:
    """Yield the table as Markdown."""
    visits = [Visit(**each) for each in record["visits"]]
    yield f"Measured on: {record['machine']}. Seed {record['seed']}."
    yield ""
    yield "| rooms with | field found | in all of it | cells seen | levels wrong | sure of these | unit off | CPU s |"
    yield "|---|---|---|---|---|---|---|---|"
    for kind in (*FIELDS, ""):
        own = [each for each in visits if each.kind == kind]
        found = [each for each in own if each.found]
        names = ("cells", "seen", "wrong", "sure_wrong")
        cells, seen, wrong, sure = (sum(getattr(each, name) for each in found) for name in names)
        share, off = f"{seen / cells:.0%}" if cells else "", max((each.unit_off for each in found), default=0)
        seconds = np.mean([each.seconds for each in own])
        yield (
            f"| {kind or 'no field'} | {len(found)} of {len(own)} | {sum(each.in_all for each in own)} | {share} "
            f"| {wrong} of {seen} | {sure} | {off:.1%} | {seconds:.1f} |"
        )


if __name__ == "__main__":
    sys.exit(main())
