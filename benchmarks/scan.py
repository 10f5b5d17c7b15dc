"""Accuracy of `rsegen scan` and `rsegen compare` on known fields, from clouds of a ray caster and of Gazebo Classic.

python -m benchmarks.scan    prints the tables and keeps benchmarks/results/scan.json; twenty minutes

Clouds are turned at random, tilted by up to 30 degrees and moved; 20 % of their points are missing, 2 % are outliers.
Cameras stand evenly around the field and look at its middle; some smooth their depths. Without a Gazebo and a screen
its rows stay as they are.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import product
from typing import Any

import numpy as np

import rsegen
from benchmarks.depth_camera import DepthCamera, Flaws, scanned, turned, with_flaws
from benchmarks.figures import RESULTS, keep, record_in, say
from benchmarks.gazebo_depth import depth_clouds
from benchmarks.machine import machine
from rsegen.errors import RsegenError, ScanError
from rsegen.field.stepfield import Array, StepField
from rsegen.recipe.codec import decode
from rsegen.scanning.finding import find_field
from rsegen.scanning.scan import Scan
from rsegen.simulators.base import SIMULATORS, Installation

FILE = RESULTS / "scan.json"

KINDS: Mapping[str, Mapping[str, Any]] = {
    "cubes": {"boundary": "outer"},
    "half-cubes": {"boundary": "none", "unit_cm": 5, "chunks": [1, 2], "chunk_size": 8},
    "3.5 inches": {
        "boundary": "divided",
        "chunks": [2, 1],
        "chunk_size": 6,
        "unit_cm": 8.89,
        "block_width_cm": 8.89,
        "frame_height_cm": 8.89,
    },
}
"""Recipes of random blocks of five levels; what is not named is 10 x 10 blocks of 10 cm."""

PLACES = {"above": (0.7, 2.2), "aside": (1.4, 1.5)}
"""Metres from the middle and above the ground: a camera that is held over the field, and one beside it."""

VIEWS = (1, 2, 3, 4)
NOISES_MM = (0, 5, 10, 15)
BLURS = (1, 2)
"""Pixels of the Gauss filter by which depths are smoothed, in rows with 5 mm of noise."""
TILT = np.radians(30)


@dataclass(frozen=True, kw_only=True, slots=True)
class Trial:
    """One cloud of one field. found: whether a field of its cells was found without anything given.

    cells, seen, right: of a scan with nothing given; known_seen, known_right: held against the map.
    """

    camera: str
    kind: str
    place: str
    views: int
    noise_mm: int
    blur: int = 0
    seed: int
    found: bool
    cells: int
    seen: int
    right: int
    known_seen: int
    known_right: int


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit code 0."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.scan", description=__doc__)
    parser.add_argument("--seeds", type=int, default=5, help="fields of each kind (default: 5)")
    parser.add_argument("--only-print", action="store_true", help="keep nothing")
    options = parser.parse_args(arguments)
    seeds = range(1, options.seeds + 1)
    before: dict[str, Any] = record_in(FILE) if FILE.exists() else {}
    found = [asdict(each) for each in cast_trials(seeds, say)]
    here = SIMULATORS["classic"].installation()
    try:
        seen = [asdict(each) for each in gazebo_trials(seeds, here, say)] if here else []
    except RsegenError as error:
        seen = []
        print(f"no rows of Gazebo: {error}", file=sys.stderr)
    simulator = str(here) if seen else before.get("simulator", "")
    found += seen or [each for each in before.get("trials", ()) if each["camera"] == "gazebo"]
    record = {"machine": machine(), "simulator": simulator, "trials": found}
    print("\n".join(table(record)))
    if not options.only_print:
        keep(record, FILE)
    return 0


def cast_trials(seeds: Sequence[int], say: Callable[[str], None] = lambda _: None) -> Iterator[Trial]:
    """Clouds of the ray caster."""
    smoothed = [(place, views, 5, blur) for place, blur, views in product(PLACES, BLURS, VIEWS)]
    sharp = [row for row in product(PLACES, VIEWS, NOISES_MM, [0]) if row[0] == "above" or row[2] == 5]
    for (place, views, noise, blur), kind, seed in product([*sharp, *smoothed], KINDS, seeds):
        rng = np.random.default_rng([seed, views, noise])
        field = rsegen.build(field_recipe(kind, seed), 0)
        cameras = [DepthCamera(place=eye, columns=400, rows=300, focal=330) for eye in _eyes(place, views, rng)]
        cloud = scanned(field, cameras, Flaws(blur=blur, noise=noise / 1000, missing=0.2, outliers=0.02), rng)
        made = {"camera": "caster", "kind": kind, "place": place, "views": views, "noise_mm": noise, "blur": blur}
        trial = judged(field, turned(cloud, rng, TILT), made | {"seed": seed})
        say(
            f"{trial.place}, {trial.views} views, {trial.noise_mm} mm, {trial.blur} pixels, {kind}, seed {seed}: "
            f"{trial.right} of {trial.seen} seen are right"
        )
        yield trial


def gazebo_trials(
    seeds: Sequence[int], here: Installation, say: Callable[[str], None] = lambda _: None
) -> Iterator[Trial]:
    """Clouds of depth cameras in a Gazebo Classic, to which the same flaws are added."""
    for kind, seed in product(KINDS, seeds):
        rng = np.random.default_rng(seed)
        recipe = field_recipe(kind, seed)
        eyes = _eyes("above", 2, rng)
        clouds = depth_clouds(recipe, eyes, here)
        field = rsegen.build(recipe, 0)
        for noise in NOISES_MM:
            flaws = Flaws(noise=noise / 1000, missing=0.2, outliers=0.02)
            cloud = with_flaws(
                [(np.asarray(eye), points) for eye, points in zip(eyes, clouds, strict=True)], flaws, rng
            )
            made = {"camera": "gazebo", "kind": kind, "place": "above", "views": 2, "noise_mm": noise, "seed": seed}
            trial = judged(field, turned(cloud, rng, TILT), made)
            say(f"Gazebo, {noise} mm, {kind}, seed {seed}: {trial.right} of {trial.seen} seen are right")
            yield trial


def field_recipe(kind: str, seed: int) -> rsegen.Recipe:
    """A field of random blocks of one of the kinds."""
    return decode({"name": "scanned", "seed": seed, "obstacles": [{"kind": "random", "levels": 5}], **KINDS[kind]})


def _eyes(place: str, views: int, rng: np.random.Generator) -> list[tuple[float, float, float]]:
    away, high = PLACES[place]
    start = 2 * np.pi * rng.random()
    angles = [start + 2 * np.pi * view / views for view in range(views)]
    return [(float(away * np.cos(angle)), float(away * np.sin(angle)), high) for angle in angles]


def judged(field: StepField, cloud: Array, made: Mapping[str, Any]) -> Trial:
    """Results of a scan with nothing given, and of one that is held against the field; made: how the cloud was."""
    seen, right, found = 0, 0, False
    try:
        scan = find_field(cloud)
        seen, right, found = _agreement(scan, field)
    except ScanError:
        pass
    known_seen = known_right = 0
    try:
        known = find_field(cloud, known=field)
        known_seen = int(known.seen.sum())
        known_right = int(_right(known, field, 0).sum())
    except ScanError:
        pass
    return Trial(
        **made,
        found=found,
        cells=field.levels.size,
        seen=seen,
        right=right,
        known_seen=known_seen,
        known_right=known_right,
    )


def _agreement(scan: Scan, field: StepField) -> tuple[int, int, bool]:
    """Cells seen, cells right at the best quarter turn, and whether the field has as many cells as it should."""
    turns = [turn for turn in range(4) if np.rot90(scan.levels, turn).shape == field.levels.shape]
    if not turns:
        return int(scan.seen.sum()), 0, False
    return int(scan.seen.sum()), max(int(_right(scan, field, turn).sum()) for turn in turns), True


def _right(scan: Scan, field: StepField, turn: int) -> Array:
    """Cells that were seen and whose level, or height of a frame, is right."""
    levels, seen, heights = (np.rot90(each, turn) for each in (scan.levels, scan.seen, scan.heights))
    frames = np.abs(heights - field.frame_height) < field.unit / 2
    return np.asarray(seen & np.where(field.frame, frames, levels == field.levels))


def table(record: Mapping[str, Any]) -> Iterator[str]:
    """The tables as Markdown."""
    trials = [Trial(**each) for each in record["trials"]]
    fields = len({(each.kind, each.seed) for each in trials})
    yield f"Measured on: {record['machine']}. {fields} fields: {', '.join(KINDS)}; each row is one cloud of each."
    yield ""
    lines = [
        "| cloud | cameras | noise | field found | cells seen | right of those | fields without a wrong block "
        "| `compare`: right of those seen |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for key in dict.fromkeys(map(_row, trials)):
        camera, place, views, noise, blur = key
        own = [each for each in trials if _row(each) == key]
        good = [each for each in own if each.found]
        lines.append(
            f"| {'ray caster' if camera == 'caster' else 'Gazebo Classic'} | {views} {place} "
            f"| {noise} mm{f', smoothed by {blur} px' if blur else ''} "
            f"| {len(good)} of {len(own)} | {_share(sum(e.seen for e in good), sum(e.cells for e in good))} "
            f"| {_share(sum(e.right for e in good), sum(e.seen for e in good))} "
            f"| {sum(e.right == e.seen for e in good)} of {len(own)} "
            f"| {_share(sum(e.known_right for e in own), sum(e.known_seen for e in own))} |"
        )
    yield from lines


def _row(trial: Trial) -> tuple[str, str, int, int, int]:
    return trial.camera, trial.place, trial.views, trial.noise_mm, trial.blur


def _share(part: int, whole: int) -> str:
    if not whole:
        return ""
    return "100 %" if part == whole else f"{min(100 * part / whole, 99.99):.2f} %"


if __name__ == "__main__":
    sys.exit(main())
