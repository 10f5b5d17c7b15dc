"""One trial: a world, robots in it that wander, and what it costs the simulator."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import Literal

from rsegen.driving.arena import arena
from rsegen.driving.crew import crew
from rsegen.driving.drive import Driver, steer
from rsegen.driving.routes import Wandering
from rsegen.errors import SimulatorFailed
from rsegen.experiment.machine import Usage, usage
from rsegen.experiment.plan import Cell, Plan
from rsegen.export import sdf
from rsegen.pipeline import generate
from rsegen.recipe import Recipe
from rsegen.robots import robot
from rsegen.scene import compose
from rsegen.simulators import Installation
from rsegen.simulators.live import Clock, LiveWorld
from rsegen.simulators.server import attempted, serving

RESTS = {"real": 1.0, "free": 0.2}
"""Seconds between what robots are told: about a simulated second."""

PATIENCE = 600.0
"""Seconds for the largest world to load."""

SETTLED = 2.0
"""Simulated seconds before measuring begins: robots fall to the ground, and go."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Outcome:
    """What a trial cost.

    load: seconds until the world was there; memory: MB at the end; cpu: processors in use while robots drove
    speed: simulated seconds for each second of CPU; rtf_min, rtf, rtf_max: real-time factors in real time, else None
    """

    load: float
    memory: float
    cpu: float | None
    speed: float
    rtf_min: float | None
    rtf: float | None
    rtf_max: float | None


def tried(plan: Plan, cell: Cell, here: Installation) -> Outcome:
    """A cell tried once; a server that is lost is tried again."""
    row = plan.rows[cell.row]
    recipe, kind = row.map_of(cell.size, plan.seed), robot(row.robot)
    field = compose(recipe).field
    drivers = crew(field, kind, Wandering.name, count=row.robots, seed=plan.seed)
    with _world(recipe, empty=not cell.size) as world:
        models = [driver.robot.model(driver.name, here.dialect, astuple(driver.start)) for driver in drivers]
        text = arena(world, models, unthrottled=cell.pace == "free")
        file = world.with_name("experiment.world")
        file.write_text(text, "utf-8")
        trial = _Trial(here=here, file=file, drivers=drivers, seconds=plan.seconds, pace=cell.pace)
        return attempted(trial.run)


@contextmanager
def _world(recipe: Recipe, *, empty: bool) -> Iterator[Path]:
    """The world file of a map, or one without a map."""
    with tempfile.TemporaryDirectory(prefix="rsegen-") as folder:
        if empty:
            file = Path(folder, "empty.world")
            file.write_bytes(b"".join(sdf.encoded(sdf.world(compose(recipe), ()))))
            yield file
        else:
            yield generate(recipe, folder).maps[0].world


@dataclass(frozen=True, kw_only=True, slots=True)
class _Trial:
    """A world in a file, robots in it, and the pace that it is simulated at."""

    here: Installation
    file: Path
    drivers: Sequence[Driver]
    seconds: float
    pace: str

    def run(self) -> Outcome:
        """Robots wander, without a pause but before and after: then the clock and what was used are known exactly."""
        began = time.monotonic()
        with self._served() as (pid, live):
            load = time.monotonic() - began
            self._go(live, "simulated", SETTLED)
            start, before = live.clock(), usage(pid)
            factors = self._go(live, "real", self.seconds)
            end, after = live.clock(), usage(pid)
        return _outcome(load, (before, after), (start, end), factors if self.pace == "real" else [])

    @contextmanager
    def _served(self) -> Iterator[tuple[int, LiveWorld]]:
        with serving(self.here, self.file, patience=PATIENCE) as server, server.live() as live:
            live.stop_recording()
            yield server.pid, live

    def _go(self, live: LiveWorld, hand: Literal["simulated", "real"], seconds: float) -> list[float]:
        """Have robots decide again and again for so many seconds of one hand of the clock; gives real-time factors."""
        routes = {driver.name: driver.route() for driver in self.drivers}
        start = last = live.clock()
        factors, end = [], time.monotonic() + 20 * seconds
        live.go()
        while getattr(last, hand) < getattr(start, hand) + seconds:
            steer(live, self.drivers, routes, live.poses())
            time.sleep(RESTS[self.pace])
            now = live.clock()
            if time.monotonic() > end:
                raise SimulatorFailed(f"{now.simulated - start.simulated:g} s simulated in {20 * seconds:g} s")
            factors.append((now.simulated - last.simulated) / max(now.real - last.real, 1e-9))
            last = now
        live.stand()
        return factors


def _outcome(load: float, used: tuple[Usage, Usage], passed: tuple[Clock, Clock], factors: list[float]) -> Outcome:
    cpu = max(used[1].cpu - used[0].cpu, 0.01)
    return Outcome(
        load=round(load, 3),
        memory=round(used[1].memory, 1),
        cpu=round(cpu / (passed[1].real - passed[0].real), 4) if factors else None,
        speed=round((passed[1].simulated - passed[0].simulated) / cpu, 3),
        rtf_min=round(min(factors), 3) if factors else None,
        rtf=round(sum(factors) / len(factors), 3) if factors else None,
        rtf_max=round(max(factors), 3) if factors else None,
    )
