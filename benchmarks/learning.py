"""Cost of maps for learning, and of them in engines: `python -m benchmarks.learning`, five minutes.

Each row is beside another way in the same run, so that the ratio says something on any machine: the median of the
ratios of several turns, seconds of CPU; engines are beside one another. Kept in benchmarks/results/learning.json;
docs/learning.md has them.
"""

from __future__ import annotations

import argparse
import statistics
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import Any

import numpy as np

import rsegen
from benchmarks import engines
from benchmarks.figures import RESULTS, keep, record_in
from benchmarks.machine import machine
from rsegen import (
    DiagonalBarrier,
    DiscreteObstacles,
    HorizontalBarrier,
    Matrix,
    Noise,
    NormalRandom,
    Pallet,
    Peak,
    Pit,
    Platform,
    Rails,
    Random,
    Recipe,
    Slope,
    Stairs,
    Stones,
    Terrain,
    Waves,
)
from rsegen.params.sorts import ANYWHERE

FILE = RESULTS / "learning.json"
LEVELS = 5
TURNS = 7
SIDE_IN_ENGINES = 40

_BARRIER = DiagonalBarrier(levels=LEVELS, softness=30)

DESIGNS: Mapping[str, Mapping[str, Any]] = {
    "random": {},
    "random, weights": {"obstacles": [Random(levels=LEVELS, weights=(1, 2, 2, 2, 1))]},
    "normal random": {"obstacles": [NormalRandom(levels=LEVELS)]},
    "horizontal barrier": {"obstacles": [HorizontalBarrier(levels=LEVELS, softness=30)]},
    "diagonal barrier": {"obstacles": [_BARRIER]},
    "diagonal barrier with drawn ends": {"obstacles": [replace(_BARRIER, first=(0, "random"), last=ANYWHERE)]},
    "peak": {"obstacles": [Peak(levels=LEVELS, softness=50)]},
    "platform": {"obstacles": [Platform(levels=LEVELS, softness=20)]},
    "matrix at a drawn place": {"obstacles": [Matrix(rows=("1 2 1", "2 . 3"), first=ANYWHERE)]},
    "random, barrier and peak, blends": {
        "obstacles": [Random(levels=LEVELS), replace(_BARRIER, blend="max"), Peak(levels=LEVELS, blend="add")]
    },
    "random, difficulty 0.5": {"difficulty": 0.5},
    "random, difficulty 0 to 1": {"difficulty": (0, 1)},
    "diagonal barrier, difficulty 0.5": {"obstacles": [_BARRIER], "difficulty": 0.5},
    "random, max_step of the recipe": {"max_step": 2},
}
"""Recipes of maps that are made together: what changes of one of random blocks."""

OF_KINDS: Mapping[str, tuple[Mapping[str, Any], int]] = {
    "random": ({}, 4096),
    "random, weights": (DESIGNS["random, weights"], 4096),
    "random, counts": ({"obstacles": [Random(levels=LEVELS, counts=(20,) * 5)]}, 4096),
    "random, `max_step` of the recipe": ({"max_step": 2}, 4096),
    "random, `max_step` of its own": ({"obstacles": [Random(levels=LEVELS, max_step=2)]}, 4096),
    "random, `crossable_by`": ({"crossable_by": (10, 10, 20)}, 4096),
    "random, difficulty 0.5": ({"difficulty": 0.5}, 4096),
    "normal random": (DESIGNS["normal random"], 4096),
    "barriers at drawn ends": (DESIGNS["diagonal barrier with drawn ends"], 4096),
    "random, barrier and peak, blends": (DESIGNS["random, barrier and peak, blends"], 4096),
    "peak": (DESIGNS["peak"], 4096),
    "platform": (DESIGNS["platform"], 4096),
    "matrix": (DESIGNS["matrix at a drawn place"], 4096),
    "stairs": ({"obstacles": [Stairs(levels=LEVELS)]}, 4096),
    "rails": ({"obstacles": [Rails(levels=LEVELS)]}, 4096),
    "pit": ({"ground_level": 4, "obstacles": [Pit(levels=LEVELS)]}, 4096),
    "stones": ({"ground_level": 4, "obstacles": [Stones(levels=LEVELS)]}, 4096),
    "stones, uneven": ({"ground_level": 4, "obstacles": [Stones(levels=LEVELS, uneven=2)]}, 4096),
    "rails, uneven": ({"obstacles": [Rails(levels=LEVELS, uneven=2)]}, 4096),
    "slope": ({"obstacles": [Slope(levels=LEVELS)]}, 4096),
    "waves": ({"obstacles": [Waves(levels=LEVELS)]}, 4096),
    "noise": ({"obstacles": [Noise(levels=LEVELS)]}, 4096),
    "discrete obstacles": ({"obstacles": [DiscreteObstacles(levels=LEVELS)]}, 4096),
    "pallet": ({"obstacles": [Pallet(levels=LEVELS)]}, 4096),
}
"""Changes to a recipe of random blocks for each kind of map, and how many maps are made."""

LARGE = ("random", "diagonal barrier", "peak", "random, difficulty 0.5", "random, max_step of the recipe")
"""Designs of which maps of 40 x 40 blocks are measured too."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Row:
    """One work beside another: seconds of CPU of both, how many things it makes, and the median of their ratios."""

    work: str
    seconds: float
    count: int
    unit: str
    beside: str
    beside_seconds: float
    ratio: float


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit code: 0."""
    options = _options(arguments)
    if options.only:
        record = _measured_anew(options.only)
    else:
        in_engines = [asdict(row) for row in engines.rows(_recipe(SIDE_IN_ENGINES))]
        record = {"machine": machine(), "rows": [asdict(row) for row in rows()], "engines": in_engines}
    print("\n".join(table(record)))
    if not options.only_print:
        keep(record, FILE)
    return 0


def _measured_anew(part: str) -> dict[str, Any]:
    """Return the record with some of the rows measured anew."""
    record: dict[str, Any] = record_in(FILE)
    anew, word = PARTS[part]
    place = next((number for number, row in enumerate(record["rows"]) if word in row["work"]), len(record["rows"]))
    kept = [row for row in record["rows"] if word not in row["work"]]
    record["rows"] = [*kept[:place], *(asdict(row) for row in anew()), *kept[place:]]
    record["later"] = {**record.get("later", {}), part: machine()}
    return record


def rows() -> Iterator[Row]:
    """All of them."""
    yield from _kinds()
    yield from _many()
    terrain = Terrain(recipes=_recipe(40), rows=10, columns=20)
    yield _compared(
        "`Terrain`, 10 x 20 tiles of 40 x 40, its field",
        lambda: Terrain(recipes=_recipe(40), rows=10, columns=20).field,
        200,
        "tiles",
        "its merged mesh",
        lambda: rsegen.mesh(terrain.field),
    )
    yield from _meshes()
    yield from _ground()
    yield from _in_place()
    yield from _worlds()


def _kinds() -> Iterator[Row]:
    """Maps of every kind, beside as many random numbers of numpy."""
    for name, (changes, count) in OF_KINDS.items():
        recipe = replace(_recipe(10), **changes)
        numbers = partial(_in_one_call, 10, 4096)
        row = _compared(
            f"maps of {name}", partial(rsegen.build_many, recipe, range(count)), count, "maps", "numpy", numbers
        )
        # As many maps as numpy's numbers are for: those that are made one by one take long.
        share = 4096 / count
        its = row.beside_seconds / share
        yield replace(row, beside="numpy, a number per block", beside_seconds=its, ratio=row.ratio * share)


def _many() -> Iterator[Row]:
    """Many maps at once, of every sort of recipe, beside one after the other."""
    for side, maps in ((10, 50_000), (40, 3_000)):
        recipe = _recipe(side)
        yield _compared(
            f"`build_many`, random {side} x {side}",
            partial(rsegen.build_many, recipe, range(maps)),
            maps,
            "maps",
            "numpy, as many numbers in one call",
            partial(_in_one_call, side, maps),
        )
    for side, count, names in ((10, 4096, DESIGNS), (40, 512, LARGE)):
        for name in names:
            yield _beside_build(f"{name} {side} x {side}", replace(_recipe(side), **DESIGNS[name]), count)
    yield from _on_a_device()


def _beside_build(name: str, recipe: Recipe, count: int) -> Row:
    """Many maps at once, beside `build` for each of them."""
    return _compared(
        f"`build_many`, {name}",
        lambda: rsegen.build_many(recipe, range(count)),
        count,
        "maps",
        "`build` in a loop",
        lambda: [rsegen.build(recipe, index) for index in range(count)],
    )


def _on_a_device() -> Iterator[Row]:
    """Maps of 16,384 worlds made on a GPU, beside those that numpy makes and copies there; seconds of the clock."""
    try:
        import torch

        from rsegen.learning.torch import build_many
    except ImportError:
        return
    if not torch.cuda.is_available():
        return
    worlds = range(16_384)

    def made(recipe: Recipe) -> None:
        build_many(recipe, worlds, device="cuda")
        torch.cuda.synchronize()

    def copied(recipe: Recipe) -> None:
        torch.from_numpy(rsegen.build_many(recipe, worlds)).to("cuda")
        torch.cuda.synchronize()

    for name in ("random", "random, weights", "diagonal barrier", "random, difficulty 0.5"):
        recipe = replace(_recipe(40), **DESIGNS[name])
        # By the clock, as the processor waits for the device.
        seconds, its, ratio = _in_turns(partial(made, recipe), partial(copied, recipe), time.perf_counter)
        yield Row(
            work=f"`build_many` of `rsegen.learning.torch`, {name} 40 x 40, on {torch.cuda.get_device_name()}",
            seconds=seconds,
            count=len(worlds),
            unit="maps",
            beside="`rsegen.build_many`, copied there",
            beside_seconds=its,
            ratio=ratio,
        )


def _meshes() -> Iterator[Row]:
    """Closed meshes, beside the merged surface."""
    for side in (200, 1000):
        field = rsegen.build(_recipe(side), 0)
        yield _compared(
            f'`rsegen.mesh(field, "watertight")`, random {side} x {side}',
            partial(rsegen.mesh, field, "watertight"),
            side**2,
            "blocks",
            "`rsegen.mesh(field)`, merged",
            partial(rsegen.mesh, field),
        )


def _ground() -> Iterator[Row]:
    """Heights of a ground, beside a look-up of the same points in an array."""
    recipe, worlds = _recipe(40), 1024
    levels = rsegen.build_many(recipe, range(worlds))
    points = np.random.default_rng(7).uniform(-1.9, 1.9, (worlds, 187, 2)).astype(np.float32)
    for name, array, compiled in _libraries():
        ground, tops = rsegen.Ground(recipe, array(levels)), array((levels * 0.05).astype(np.float32))
        own, rows = array(points), array(np.arange(worlds)[:, None])
        in_blocks = array(np.float32(0.1)), array(np.float32(20))
        ours = compiled(ground.heights)
        plain = compiled(partial(_looked_up, tops, rows, in_blocks))
        if abs(np.asarray(ours(own)) - np.asarray(plain(own))).mean() > 1e-3:
            raise AssertionError(f"{name}: the heights of a ground are not those of its blocks")
        for turn in (ours, plain):  # compiled, and warm
            _waited(turn(own))
        seconds, its, ratio = _in_turns(
            lambda ours=ours, own=own: _repeated(ours, own),  # type: ignore[misc]  # at once, in this turn
            lambda plain=plain, own=own: _repeated(plain, own),  # type: ignore[misc]  # the same
            time.process_time,
        )
        yield Row(
            work=f"`Ground.heights`, {name}",
            seconds=seconds,
            count=REPEATED * points.size // 2,
            unit="points",
            beside="a look-up in an array",
            beside_seconds=its,
            ratio=ratio,
        )


REPEATED = 10


def _repeated(ask: Callable[[Any], Any], points: Any) -> None:
    for _ in range(REPEATED):
        _waited(ask(points))


def _waited(answer: Any) -> None:
    if hasattr(answer, "block_until_ready"):
        answer.block_until_ready()


def _looked_up(tops: Any, rows: Any, in_blocks: tuple[Any, Any], points: Any) -> Any:
    """The height of the block below each point: no edges, nothing around the map, no check."""
    cells = points / in_blocks[0] + in_blocks[1]
    whole = cells.long() if hasattr(cells, "long") else cells.astype(np.int32)
    return tops[rows, whole[..., 0], whole[..., 1]]


def _libraries() -> Iterator[tuple[str, Callable[[Any], Any], Callable[[Any], Any]]]:
    """The libraries that are here: a name, what makes an array, and what compiles a function."""
    yield "numpy", np.asarray, lambda ask: ask
    try:
        import jax

        yield "`jax.jit`", jax.numpy.asarray, jax.jit
    except ImportError:
        pass
    try:
        import torch

        torch.set_num_threads(1)  # several wait for one another: on a busy machine a hundred times as long as they work
        yield "`torch.compile`", torch.as_tensor, torch.compile
    except ImportError:
        pass


def _in_place() -> Iterator[Row]:
    """New maps in a compiled model of MuJoCo, beside steps of physics on it."""
    try:
        import mujoco

        from rsegen.learning.mujoco import BlockGrid
    except ImportError:
        return
    grid, count = BlockGrid(_recipe(10)), 4096
    model = _with_balls(mujoco, grid)
    state = mujoco.MjData(model)
    levels = rsegen.build_many(grid.recipe, range(count))

    def writes() -> None:
        for one in levels:
            grid.write(model, one)

    def steps() -> None:
        mujoco.mj_resetData(model, state)
        for _ in range(count):
            mujoco.mj_step(model, state)

    steps_of_physics = f"{count:,} steps of MuJoCo on it, with four balls"
    yield _compared(
        "`BlockGrid.write`, 10 x 10 blocks",
        writes,
        count,
        "maps",
        steps_of_physics,
        steps,
    )
    yield _compared(
        f"its arrays for {count:,} worlds at once",
        lambda: (grid.pos(levels), grid.size(levels)),
        count,
        "maps",
        steps_of_physics,
        steps,
    )


def _worlds() -> Iterator[Row]:
    """A new map in each world of mujoco_warp, beside a step of all worlds, on the processor."""
    try:
        import mujoco
        import mujoco_warp

        from rsegen.learning.mujoco import BlockGrid
        from rsegen.learning.mujoco_warp import BlocksOfWorlds
    except ImportError:
        return
    grid, count = BlockGrid(_recipe(10)), 4096
    compiled = _with_balls(mujoco, grid)
    model, data = mujoco_warp.put_model(compiled), mujoco_warp.make_data(compiled, nworld=count)
    blocks, levels = BlocksOfWorlds(grid, compiled, model, data), rsegen.build_many(grid.recipe, range(count))
    blocks.write(levels)
    yield _compared(
        f"`BlocksOfWorlds.write`, {count:,} worlds of 10 x 10 blocks",
        lambda: blocks.write(levels),
        count,
        "maps",
        "a step of mujoco_warp of all of them, on the processor",
        lambda: mujoco_warp.step(model, data),
    )


def _with_balls(mujoco: Any, grid: Any) -> Any:
    """A compiled model of a grid with four balls above it."""
    spec = mujoco.MjSpec()
    grid.add_to(spec)
    for number in range(4):
        body = spec.worldbody.add_body(pos=[0.2 * number - 0.3, 0, 0.6])
        body.add_freejoint()
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.05, 0, 0])
    return spec.compile()


def _recipe(side: int) -> Recipe:
    obstacle = Random(levels=LEVELS)
    return Recipe(seed=7, chunk_size=side, boundary="none", unit_cm=5, obstacles=(obstacle,))


def _in_one_call(side: int, maps: int) -> np.ndarray:
    return (LEVELS * np.random.default_rng(7).random((maps, side, side))).astype(np.int16)


def _compared(
    work: str, ours: Callable[[], object], count: int, unit: str, beside: str, other: Callable[[], object]
) -> Row:
    """Both in turns, in seconds of CPU."""
    seconds, beside_seconds, ratio = _in_turns(ours, other, time.process_time)
    return Row(
        work=work,
        seconds=seconds,
        count=count,
        unit=unit,
        beside=beside,
        beside_seconds=beside_seconds,
        ratio=ratio,
    )


def _in_turns(
    ours: Callable[[], object], other: Callable[[], object], clock: Callable[[], float]
) -> tuple[float, float, float]:
    """The medians of both times, and of their ratios, after one turn that is not counted."""
    pairs = [(_seconds(ours, clock), _seconds(other, clock)) for _ in range(TURNS + 1)][1:]
    mine, its = (statistics.median(times) for times in zip(*pairs, strict=True))
    return mine, its, statistics.median(one / two for one, two in pairs)


def _seconds(work: Callable[[], object], clock: Callable[[], float]) -> float:
    begin = clock()
    work()
    return clock() - begin


PARTS: Mapping[str, tuple[Callable[[], Iterator[Row]], str]] = {
    "kinds of maps": (_kinds, "maps of "),
    "maps at once": (_many, "`build_many`"),
    "closed meshes": (_meshes, "rsegen.mesh("),
    "the ground": (_ground, "`Ground.heights`"),
}
"""Rows that can be measured alone, and what their names have in common."""


def table(record: Mapping[str, Any]) -> Iterator[str]:
    """The figures as lines of Markdown."""
    yield "| work | CPU s | per second | compared with | CPU s | ratio |"
    yield "|---|---|---|---|---|---|"
    for row in (Row(**each) for each in record["rows"]):
        rate = f"{row.count / row.seconds:,.0f} {row.unit}"
        yield f"| {row.work} | {row.seconds:.3g} | {rate} | {row.beside} | {row.beside_seconds:.3g} | {row.ratio:.3g} |"
    side = SIDE_IN_ENGINES
    yield f"\nA random map of {side} x {side} blocks in engines, with nine bodies that lie on it:\n"
    yield from engines.table(record["engines"])
    later = (f"; {part} later, on {where}" for part, where in record.get("later", {}).items())
    yield f"\nMeasured by `python -m benchmarks.learning` on: {record['machine']}{''.join(later)}."


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.learning", description=__doc__.splitlines()[0])
    parser.add_argument("--only-print", action="store_true", help="keep no record")
    parser.add_argument("--only", choices=sorted(PARTS), help="these rows alone; the rest of the record stays")
    return parser.parse_args(arguments)


if __name__ == "__main__":
    sys.exit(main())
