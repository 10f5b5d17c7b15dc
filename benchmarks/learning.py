"""How fast maps for learning are made, and what they cost in engines: `python -m benchmarks.learning`, two minutes.

Each row is beside another way in the same run, so that the ratio says something on any machine: the median of the
ratios of several turns, seconds of CPU; engines are beside one another. Kept in benchmarks/results/learning.json;
docs/learning.md has them.
"""

from __future__ import annotations

import argparse
import json
import statistics
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

import numpy as np

import rsegen
from benchmarks import engines
from benchmarks.figures import RESULTS
from benchmarks.machine import machine
from rsegen import Random, Recipe, Terrain

FILE = RESULTS / "learning.json"
LEVELS = 5
TURNS = 7
SIDE_IN_ENGINES = 40


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
    if options.meshes:
        return _meshes_anew()
    in_engines = [asdict(row) for row in engines.rows(_recipe(SIDE_IN_ENGINES))]
    record = {"machine": machine(), "rows": [asdict(row) for row in rows()], "engines": in_engines}
    print("\n".join(table(record)))
    if not options.only_print:
        FILE.write_text(json.dumps(record, indent=1) + "\n", "utf-8")
    return 0


def _meshes_anew() -> int:
    """Measure the rows of closed meshes alone; the rest of the record stays. Exit code: 0."""
    record, anew = json.loads(FILE.read_text("utf-8")), [asdict(row) for row in _meshes()]
    kept = [row for row in record["rows"] if "rsegen.mesh(" not in row["work"]]
    place = next(number for number, row in enumerate(kept) if "BlockGrid" in row["work"])
    record["rows"] = [*kept[:place], *anew, *kept[place:]]
    record["machine"] = f"{record['machine'].partition('; closed meshes')[0]}; closed meshes later, on {machine()}"
    FILE.write_text(json.dumps(record, indent=1) + "\n", "utf-8")
    return 0


def rows() -> Iterator[Row]:
    """All of them."""
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
    small, few = _recipe(10), 2_000
    yield _compared(
        "`build_many`, random 10 x 10",
        lambda: rsegen.build_many(small, range(few)),
        few,
        "maps",
        "`build` in a loop",
        lambda: [rsegen.build(small, index) for index in range(few)],
    )
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
    yield from _in_place()
    yield from _worlds()


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
    """Both in turns, after one of each that is not counted."""
    pairs = [(_seconds(ours), _seconds(other)) for _ in range(TURNS + 1)][1:]
    mine, its = (statistics.median(times) for times in zip(*pairs, strict=True))
    ratio = statistics.median(one / two for one, two in pairs)
    return Row(work=work, seconds=mine, count=count, unit=unit, beside=beside, beside_seconds=its, ratio=ratio)


def _seconds(work: Callable[[], object]) -> float:
    """Of CPU."""
    begin = time.process_time()
    work()
    return time.process_time() - begin


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
    yield f"\nMeasured by `python -m benchmarks.learning` on: {record['machine']}."


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.learning", description=__doc__.splitlines()[0])
    parser.add_argument("--only-print", action="store_true", help="keep no record")
    parser.add_argument("--meshes", action="store_true", help="closed meshes alone; the rest of the record stays")
    return parser.parse_args(arguments)


if __name__ == "__main__":
    sys.exit(main())
