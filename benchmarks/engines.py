"""Cost of a map in an engine, by the shape in which it is given: compiling, memory, and a step with bodies on it.

Part of `python -m benchmarks.learning`; an engine that is not installed has no rows.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import rsegen
from rsegen import Recipe, Scene

TURNS = 5
SETTLING, STEPS = 500, 500
"""Steps until the bodies lie still, about, and steps that are measured."""
PLACES = [(0.3 * x, 0.3 * y, 0.6) for x in (-1, 0, 1) for y in (-1, 0, 1)]
"""Places from which nine bodies fall, metres: boxes and balls in turn."""
HALF = 0.06
"""Half of the side of a box, and the radius of a ball, metres."""


@dataclass(frozen=True, kw_only=True, slots=True)
class EngineRow:
    """A map in an engine: its geoms, CPU seconds to compile it, bytes of the model if known, CPU us of a step."""

    engine: str
    shape: str
    geoms: int
    compile_seconds: float
    bytes: int | None
    step_microseconds: float


def rows(recipe: Recipe) -> Iterator[EngineRow]:
    """Map 0 of a recipe in every engine that is installed."""
    with suppress(ImportError):
        yield from _mujoco(recipe)
    with suppress(ImportError):
        yield from _newton(recipe)


def _mujoco(recipe: Recipe) -> Iterator[EngineRow]:
    import mujoco

    with TemporaryDirectory() as folder:
        for shape in ("boxes", "a box per block", "hfield", "mesh"):
            specs = [_mujoco_spec(mujoco, recipe, shape, Path(folder, shape)) for _ in range(TURNS)]
            seconds = statistics.median(_seconds(spec.compile) for spec in specs)
            model = specs[0].compile()
            steps = partial(mujoco.mj_step, model, mujoco.MjData(model))
            steps(SETTLING)
            yield EngineRow(
                engine=f"MuJoCo {mujoco.__version__}",
                shape=shape,
                geoms=model.ngeom - len(PLACES),
                compile_seconds=seconds,
                bytes=mujoco.mj_sizeModel(model),
                step_microseconds=_step(steps),
            )


def _mujoco_spec(mujoco: Any, recipe: Recipe, shape: str, folder: Path) -> Any:
    """The map with bodies above it; compiling reads the files of its meshes and heights."""
    from rsegen.learning.mujoco import BlockGrid

    if shape == "a box per block":
        spec = mujoco.MjSpec()
        BlockGrid(recipe).add_to(spec)
    else:
        rsegen.export(recipe, folder, "mjcf", shape=shape, force=True)
        spec = mujoco.MjSpec.from_file(str(next(folder.rglob(f"{recipe.map_name(0)}.xml"))))
    _add_bodies(mujoco, spec)
    return spec


def _add_bodies(mujoco: Any, spec: Any) -> None:
    kinds = mujoco.mjtGeom.mjGEOM_BOX, mujoco.mjtGeom.mjGEOM_SPHERE
    for number, place in enumerate(PLACES):
        body = spec.worldbody.add_body(pos=place)
        body.add_freejoint()
        body.add_geom(type=kinds[number % 2], size=[HALF] * 3)


def _newton(recipe: Recipe) -> Iterator[EngineRow]:
    """On the processor, by XPBD; kernels are compiled before anything is measured."""
    import newton

    scene = rsegen.compose(recipe, 0)
    for shape in ("boxes", "mesh"):
        model, geoms = _newton_model(newton, scene, shape)
        seconds = statistics.median(_seconds(partial(_newton_model, newton, scene, shape)) for _ in range(TURNS))
        pipeline, states = newton.CollisionPipeline(model), [model.state(), model.state()]
        solver, step = newton.solvers.SolverXPBD(model), (model.control(), pipeline.contacts(), 0.002)
        steps = partial(_newton_steps, pipeline, solver, states, step)
        steps(SETTLING)
        yield EngineRow(
            engine=f"Newton {newton.__version__}, XPBD",
            shape=shape,
            geoms=geoms,
            compile_seconds=seconds,
            bytes=None,
            step_microseconds=_step(steps),
        )


def _newton_model(newton: Any, scene: Scene, shape: str) -> tuple[Any, int]:
    """The map with bodies above it, and how many shapes it has."""
    import warp

    from rsegen.learning.newton import add_map

    builder = newton.ModelBuilder()
    shapes = add_map(builder, scene, shape=shape)
    for number, place in enumerate(PLACES):
        body = builder.add_body(xform=warp.transform(warp.vec3(*place), warp.quat_identity()))
        if number % 2:
            builder.add_shape_sphere(body, radius=HALF)
        else:
            builder.add_shape_box(body, hx=HALF, hy=HALF, hz=HALF)
    return builder.finalize(device="cpu"), len(shapes)


def _newton_steps(pipeline: Any, solver: Any, states: list[Any], step: tuple[Any, Any, float], count: int) -> None:
    """step: control, contacts and seconds of a step."""
    for _ in range(count):
        states[0].clear_forces()
        pipeline.collide(states[0], step[1])
        solver.step(*states, *step)
        states.reverse()


def _seconds(work: Callable[[], object]) -> float:
    """Of CPU."""
    begin = time.process_time()
    work()
    return time.process_time() - begin


def _step(steps: Callable[[int], object]) -> float:
    """CPU microseconds of one of STEPS."""
    return statistics.median(_seconds(partial(steps, STEPS)) for _ in range(TURNS)) / STEPS * 1e6


def table(entries: Iterable[Mapping[str, Any]]) -> Iterator[str]:
    """The figures as lines of Markdown."""
    yield "| engine | shape | geoms | compiling, CPU s | model, MB | CPU us per step |"
    yield "|---|---|---|---|---|---|"
    for row in (EngineRow(**entry) for entry in entries):
        size = "" if row.bytes is None else f"{row.bytes / 1e6:.3g}"
        figures = f"{row.compile_seconds:.3g} | {size} | {row.step_microseconds:,.0f}"
        yield f"| {row.engine} | {row.shape} | {row.geoms:,} | {figures} |"
