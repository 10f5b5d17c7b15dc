"""A construction tried on a course, and what came of it."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import astuple, dataclass, replace
from pathlib import Path

import numpy as np

from benchmarks.contact.constructions import Construction
from benchmarks.contact.courses import SECONDS, Drop, drops
from benchmarks.contact.worlds import TOGETHER, field_of, robots_on, written
from rsegen import StepField
from rsegen.errors import SimulatorFailed
from rsegen.simulators.base import Installation
from rsegen.simulators.live_world import LiveWorld
from rsegen.simulators.poses import Pose, Record
from rsegen.simulators.process import usage
from rsegen.simulators.server import attempted, running_server
from tests.real.bodies import SIZE
from tests.real.burger import way

PERIOD = 0.05
"""Seconds between two poses of the record."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Drive:
    """Drive of a robot: mm off its course at the end, mrad of yaw, mrad of roll (sd), metres ahead."""

    robot: str
    ground: str
    heading: int
    aside: float
    yaw: float
    roll: float
    ahead: float


@dataclass(frozen=True, kw_only=True, slots=True)
class Rest:
    """Rest of a dropped body: mm above its place, mm aside, mm of height that it still moves through."""

    name: str
    above: float
    aside: float
    jitter: float

    @property
    def failed(self) -> bool:
        """More than 1 mm too high or too low, moved by more than 1 cm, or still moving."""
        return abs(self.above) > 1 or self.aside > 10 or self.jitter > 0.2


@dataclass(frozen=True, kw_only=True, slots=True)
class Trial:
    """Outcome of a run; cost: CPU s a simulated second; load: s, and CPU s; memory: MiB when loaded."""

    construction: str
    seed: int
    drives: list[Drive]
    rests: list[Rest]
    cost: float
    load: float
    load_cpu: float
    memory: float
    errors: list[str]


def tried(construction: Construction, seed: int, gazebo: Installation) -> Trial:
    """Drive and drop everything; a server that is lost is tried again."""
    first, *others = (_tried(construction, seed, gazebo, kinds) for kinds in TOGETHER[gazebo.simulator.name])
    drives = [drive for trial in (first, *others) for drive in trial.drives]
    return replace(first, drives=drives, errors=sorted({line for trial in (first, *others) for line in trial.errors}))


def _tried(construction: Construction, seed: int, gazebo: Installation, kinds: Sequence[str]) -> Trial:
    """With these robots in one world."""
    with tempfile.TemporaryDirectory() as folder:
        world = written(construction, field_of(construction, seed), Path(folder), gazebo.backend, kinds)
        return attempted(lambda: _run(construction, seed, world, gazebo, kinds))[0]


def _run(construction: Construction, seed: int, world: Path, gazebo: Installation, kinds: Sequence[str]) -> Trial:
    field = field_of(construction, seed)
    began = time.monotonic()
    options = gazebo.simulator.record_options(PERIOD)
    with running_server(gazebo, world, options=options) as server:
        loaded, load = usage(server.pid), time.monotonic() - began
        with server.connect() as live:
            seen = _stepped(live, SECONDS if options else PERIOD)
            done, ended, errors = usage(server.pid), live.poses(), server.errors
        server.stop()
        told = gazebo.simulator.read_record(server.home) or seen
    if max((at for at, _ in told), default=0) < SECONDS - PERIOD:
        raise SimulatorFailed("stopped early")
    return Trial(
        construction=construction.name,
        seed=seed,
        drives=list(_drives(field, kinds, ended, told)),
        rests=[_rest(drop, ended, told) for drop in drops(field)] if construction.levels else [],
        cost=(done.cpu - loaded.cpu) / SECONDS,
        load=load,
        load_cpu=loaded.cpu,
        memory=loaded.memory,
        errors=sorted(set(errors)),
    )


def _stepped(live: LiveWorld, period: float) -> Record:
    """The poses of all models every `period` seconds; a server that keeps no record is asked."""
    seen = Record()
    for turn in range(1, round(SECONDS / period) + 1):
        live.step(round(period * 1000))
        seen.append((turn * period, {name: list(astuple(pose)) for name, pose in live.poses().items()}))
    return seen


def _drives(field: StepField, kinds: Sequence[str], poses: Mapping[str, Pose], told: Record) -> Iterator[Drive]:
    for name, robot, (ground, heading), start in robots_on(field, kinds):
        end = poses[name]
        gone = way(start, end)
        turned = (end.yaw - start.heading + np.pi) % (2 * np.pi) - np.pi
        rolls = [at[name][3] for second, at in told if second >= 0.5 and name in at]
        yield Drive(
            robot=robot,
            ground=ground,
            heading=heading,
            aside=1000 * gone.aside,
            yaw=1000 * turned,
            roll=1000 * float(np.std(rolls)),
            ahead=gone.ahead,
        )


def _rest(drop: Drop, poses: Mapping[str, Pose], told: Record) -> Rest:
    end = poses[drop.name]
    heights = [at[drop.name][2] for second, at in told if second >= SECONDS - 2 and drop.name in at]
    return Rest(
        name=drop.name,
        above=1000 * (end.z - drop.top - SIZE / 2),
        aside=1000 * float(np.hypot(end.x - drop.x, end.y - drop.y)),
        jitter=1000 * (max(heights) - min(heights)),
    )
