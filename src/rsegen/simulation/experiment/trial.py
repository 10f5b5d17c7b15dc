"""One trial: a world with robots that drive randomly, and what it costs the simulator."""

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
from rsegen.simulation.driving.robot_runs import robot_runs
from rsegen.simulation.driving.routes import Wandering
from rsegen.simulation.driving.world_with_robots import world_with_robots
from rsegen.simulation.experiment.plan import Cell, ExperimentPlan
from rsegen.simulation.experiment.trial_server import Setup, total, trial_server
from rsegen.simulation.robots import robot
from rsegen.simulation.simulators import Installation
from rsegen.simulation.simulators.server import retried

RESTS = {"real": 1.0, "free": 0.2, "beside": 0.2}
"""Seconds between commands to robots, at each pace: about a simulated second."""

TURN = 1.0
"""Seconds that one of two worlds is simulated before it is the other's turn."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Outcome:
    """The measured cost of a trial.

    load: seconds until the world was loaded; memory: MB at the end; cpu: processors in use while robots drove
    speed: simulated seconds per second of CPU; rtf_min, rtf, rtf_max: real-time factors at the pace `real`, else None
    share: speed divided by that of the empty world at the pace `beside`, else None
    """

    load: float
    memory: float
    cpu: float | None
    speed: float
    rtf_min: float | None
    rtf: float | None
    rtf_max: float | None
    share: float | None = None


def run_trial(plan: ExperimentPlan, cell: Cell, repeat: int, here: Installation) -> Outcome:
    """The outcome of one trial; each repeat has its own map and start poses. A failed server is tried again."""
    cells = [cell, replace(cell, size=0)] if cell.pace == "beside" else [cell]
    with ExitStack() as stack:
        setups = [stack.enter_context(_setup(plan, each, plan.seed + repeat, here)) for each in cells]
        return retried(lambda: _outcome(setups, plan.seconds, here, real=cell.pace == "real"))


@contextmanager
def _setup(plan: ExperimentPlan, cell: Cell, seed: int, here: Installation) -> Iterator[Setup]:
    """A temporary world file with robots, of a map or empty."""
    row = plan.rows[cell.row]
    recipe = row.map_of(cell.size, seed)
    scene = compose(recipe)
    runs = robot_runs(scene.field, robot(row.robot), Wandering.name, count=row.robots, seed=seed, evenest=True)
    models = [run.robot.model(run.name, here.backend, astuple(run.start)) for run in runs]
    with tempfile.TemporaryDirectory(prefix="rsegen-") as folder:
        if cell.size:
            world = generate(recipe, folder).maps[0].world
        else:
            world = Path(folder, "empty.world")
            world.write_bytes(b"".join(sdf.utf8(sdf.world(scene, ()))))
        file = world.with_name("experiment.world")
        text = world_with_robots(world, models, unthrottled=cell.pace != "real", backend=here.backend)
        file.write_text(text, "utf-8")
        yield Setup(file=file, runs=runs, rest=RESTS[cell.pace])


def _outcome(setups: Sequence[Setup], seconds: float, here: Installation, *, real: bool) -> Outcome:
    """The cost of the first setup, simulated in turns with the second, if there is one."""
    with ExitStack() as stack:
        servers = [stack.enter_context(trial_server(setup, here)) for setup in setups]
        turns = [seconds] if len(servers) == 1 else [TURN] * ceil(seconds / TURN)
        spans = [[server.measure(turn) for server in servers] for turn in turns]
        ours, *others = (total(each) for each in zip(*spans, strict=True))
        return Outcome(
            load=round(servers[0].load, 3),
            memory=round(servers[0].memory, 1),
            cpu=round(ours.cpu / ours.real, 4) if real else None,
            speed=round(ours.speed, 3),
            rtf_min=round(min(ours.factors), 3) if real else None,
            rtf=round(fmean(ours.factors), 3) if real else None,
            rtf_max=round(max(ours.factors), 3) if real else None,
            share=round(ours.speed / others[0].speed, 4) if others else None,
        )
