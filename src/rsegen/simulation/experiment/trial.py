"""One trial: a world, robots in it that wander, and what it costs the simulator."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import astuple, dataclass, replace
from math import ceil
from pathlib import Path
from statistics import fmean

from rsegen.exporters.gazebo import sdf
from rsegen.exporters.scene import compose
from rsegen.io.worlds import generate
from rsegen.simulation.driving.routes import Wandering
from rsegen.simulation.driving.runs import crew
from rsegen.simulation.driving.world_with_robots import arena
from rsegen.simulation.experiment.plan import Cell, Plan
from rsegen.simulation.experiment.trial_server import Setup, staged, total
from rsegen.simulation.robots import robot
from rsegen.simulation.simulators import Installation
from rsegen.simulation.simulators.server import attempted

RESTS = {"real": 1.0, "free": 0.2, "beside": 0.2}
"""Seconds between what robots are told, at each pace: about a simulated second."""

TURN = 1.0
"""Seconds that a world is simulated for until it is the turn of the one beside it."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Outcome:
    """What a trial cost.

    load: seconds until the world was there; memory: MB at the end; cpu: processors in use while robots drove
    speed: simulated seconds for each second of CPU; rtf_min, rtf, rtf_max: real-time factors in real time, else None
    share: of the speed of the empty world beside it, else None
    """

    load: float
    memory: float
    cpu: float | None
    speed: float
    rtf_min: float | None
    rtf: float | None
    rtf_max: float | None
    share: float | None = None


def tried(plan: Plan, cell: Cell, repeat: int, here: Installation) -> Outcome:
    """A cell tried once, each repeat on a map and from places of its own; a server that is lost is tried again."""
    cells = [cell, replace(cell, size=0)] if cell.pace == "beside" else [cell]
    with ExitStack() as stack:
        setups = [stack.enter_context(_setup(plan, each, plan.seed + repeat, here)) for each in cells]
        return attempted(lambda: _outcome(setups, plan.seconds, here, real=cell.pace == "real"))


@contextmanager
def _setup(plan: Plan, cell: Cell, seed: int, here: Installation) -> Iterator[Setup]:
    """As long as this lasts, the world of a map, or one without a map, with robots in it."""
    row = plan.rows[cell.row]
    recipe = row.map_of(cell.size, seed)
    scene = compose(recipe)
    drivers = crew(scene.field, robot(row.robot), Wandering.name, count=row.robots, seed=seed)
    models = [driver.robot.model(driver.name, here.dialect, astuple(driver.start)) for driver in drivers]
    with tempfile.TemporaryDirectory(prefix="rsegen-") as folder:
        if cell.size:
            world = generate(recipe, folder).maps[0].world
        else:
            world = Path(folder, "empty.world")
            world.write_bytes(b"".join(sdf.utf8(sdf.world(scene, ()))))
        file = world.with_name("experiment.world")
        file.write_text(arena(world, models, unthrottled=cell.pace != "real"), "utf-8")
        yield Setup(file=file, drivers=drivers, rest=RESTS[cell.pace])


def _outcome(setups: Sequence[Setup], seconds: float, here: Installation, *, real: bool) -> Outcome:
    """Robots wander in the first setup, in turns with those in the second where there is one."""
    with ExitStack() as stack:
        stages = [stack.enter_context(staged(setup, here)) for setup in setups]
        turns = [seconds] if len(stages) == 1 else [TURN] * ceil(seconds / TURN)
        spans = [[stage.measured(turn) for stage in stages] for turn in turns]
        ours, *others = (total(each) for each in zip(*spans, strict=True))
        return Outcome(
            load=round(stages[0].load, 3),
            memory=round(stages[0].memory, 1),
            cpu=round(ours.cpu / ours.real, 4) if real else None,
            speed=round(ours.speed, 3),
            rtf_min=round(min(ours.factors), 3) if real else None,
            rtf=round(fmean(ours.factors), 3) if real else None,
            rtf_max=round(max(ours.factors), 3) if real else None,
            share=round(ours.speed / others[0].speed, 4) if others else None,
        )
