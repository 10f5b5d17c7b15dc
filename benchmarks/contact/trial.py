"""A construction tried on a course: the world, the run of the server, and what came of it."""

from __future__ import annotations

import os
import re
import tempfile
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.contact.constructions import Construction
from benchmarks.contact.courses import DROP, SECONDS, Drop, course, drops, nothing, starts
from rsegen import StepField
from sim.bodies import SIZE, body
from sim.burger import BURGER_WHEELS, RADIUS, Start, Way, Wheels, burger, way
from sim.gazebo import ATTEMPTS, Gazebo, Lost, Pose, Server

ROBOTS: Mapping[str, Wheels] = {
    "soft": BURGER_WHEELS,
    "light": BURGER_WHEELS._replace(
        friction="<friction><ode><mu>100000</mu><mu2>100000</mu2></ode></friction>",
        moments=(1.12e-5, 1.12e-5, 2.07e-5),
        gain=0.01,
    ),
    "stiff": BURGER_WHEELS._replace(contact="", friction=""),
    "sphere": BURGER_WHEELS._replace(shape=f"<sphere><radius>{RADIUS}</radius></sphere>"),
}
"""A TurtleBot3's soft wheels; the same light and without a direction of friction; Gazebo's default contact; spheres."""

PERIOD = 0.05
"""Seconds between two poses of the record."""

IDLE = 0.5
"""Processors in use, below which a server stands still."""

_STATE = re.compile(r"<sim_time>(\d+) (\d+)</sim_time>(.*?)</state>", re.DOTALL)
_MODEL = re.compile(r"<model name='([^']+)'>\s*<pose>([^<]+)</pose>")


@dataclass(frozen=True, kw_only=True, slots=True)
class Drive:
    """How a robot drove: mm off its course at the end, mrad of yaw, mrad of roll (sd), metres ahead."""

    robot: str
    ground: str
    heading: int
    aside: float
    yaw: float
    roll: float
    ahead: float


@dataclass(frozen=True, kw_only=True, slots=True)
class Rest:
    """How a dropped body rests: mm above its place, mm aside, mm of height that it still moves through."""

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
    """What came of a run; cost: CPU s a simulated second; load: s and CPU s; memory: MB when loaded and at its most."""

    construction: str
    seed: int
    drives: list[Drive]
    rests: list[Rest]
    cost: float
    load: float
    load_cpu: float
    memory: float
    errors: list[str]


@dataclass(frozen=True, kw_only=True, slots=True)
class _Usage:
    cpu: float
    memory: float


def tried(construction: Construction, seed: int, gazebo: Gazebo) -> Trial:
    """Drive and drop everything; a server that is lost is tried again."""
    with tempfile.TemporaryDirectory() as folder:
        world = _world(construction, _field(construction, seed), Path(folder))
        return _attempt(construction, seed, world, gazebo, ATTEMPTS - 1)


def _attempt(construction: Construction, seed: int, world: Path, gazebo: Gazebo, left: int) -> Trial:
    try:
        return _run(construction, seed, world, gazebo)
    except Lost:
        if not left:
            raise
    return _attempt(construction, seed, world, gazebo, left - 1)


def _run(construction: Construction, seed: int, world: Path, gazebo: Gazebo) -> Trial:
    field = _field(construction, seed)
    began = time.monotonic()
    with gazebo.serving(world, None, "--record_encoding", "txt", "--record_period", str(PERIOD)) as server:
        loaded, load = _usage(server), time.monotonic() - began
        server.begin(SECONDS * 1000)
        done = _when_idle(server)
        poses, errors = server.poses(), server.errors()
        server.end()
        record = _record(server.state.read_text())
    if max(at for at, _ in record) < SECONDS - PERIOD:
        raise Lost("stopped early")
    return Trial(
        construction=construction.name,
        seed=seed,
        drives=list(_drives(field, poses, record)),
        rests=[_rest(drop, poses, record) for drop in drops(field)] if construction.levels else [],
        cost=(done.cpu - loaded.cpu) / SECONDS,
        load=load,
        load_cpu=loaded.cpu,
        memory=loaded.memory,
        errors=errors,
    )


def _drives(
    field: StepField, poses: Mapping[str, Pose], record: list[tuple[float, dict[str, list[float]]]]
) -> Iterator[Drive]:
    for name, robot, (ground, heading), start in _robots(field):
        end = poses[name]
        gone: Way = way(start, end)
        turned = (end.yaw - start.heading + np.pi) % (2 * np.pi) - np.pi
        rolls = [at[name][3] for second, at in record if second >= 0.5 and name in at]
        yield Drive(
            robot=robot,
            ground=ground,
            heading=heading,
            aside=1000 * gone.aside,
            yaw=1000 * turned,
            roll=1000 * float(np.std(rolls)),
            ahead=gone.ahead,
        )


def _rest(drop: Drop, poses: Mapping[str, Pose], record: list[tuple[float, dict[str, list[float]]]]) -> Rest:
    end = poses[drop.name]
    heights = [at[drop.name][2] for second, at in record if second >= SECONDS - 2 and drop.name in at]
    return Rest(
        name=drop.name,
        above=1000 * (end.z - drop.top - SIZE / 2),
        aside=1000 * float(np.hypot(end.x - drop.x, end.y - drop.y)),
        jitter=1000 * (max(heights) - min(heights)),
    )


def _field(construction: Construction, seed: int) -> StepField:
    return course(seed) if construction.levels else nothing()


def _robots(field: StepField) -> Iterator[tuple[str, str, tuple[str, int], Start]]:
    for place, start in starts(field).items():
        ground, heading = place
        for robot in ROBOTS if ground != "plain" and heading % 90 else ("soft",):
            yield f"{robot}_{place[0]}_{place[1]}", robot, place, start


def _world(construction: Construction, field: StepField, folder: Path) -> Path:
    """The world's file in a folder, with the files that it names."""
    models = [_model(construction, field, folder)] if construction.levels else []
    kinds = list(ROBOTS)
    models += [burger(name, start, ROBOTS[robot], 1 << kinds.index(robot)) for name, robot, _, start in _robots(field)]
    if construction.levels:
        models += [body(drop.name, drop.shape, (drop.x, drop.y, drop.top + DROP)) for drop in drops(field)]
    path = folder / "course.world"
    path.write_text(_WORLD.format(models="".join(models)))
    return path


_FRICTION = "<friction><ode><mu>1</mu><mu2>1</mu2></ode></friction>"

_WORLD = f"""\
<?xml version="1.0"?>
<sdf version="1.6">
  <world name="course">
    <physics type="ode">
      <max_step_size>0.001</max_step_size>
      <real_time_update_rate>2000</real_time_update_rate>
    </physics>
    <model name="ground_plane">
      <static>true</static>
      <link name="link">
        <collision name="collision">
          <geometry><plane><normal>0 0 1</normal><size>100 100</size></plane></geometry>
          <surface>{_FRICTION}</surface>
        </collision>
      </link>
    </model>
{{models}}
  </world>
</sdf>
"""


def _model(construction: Construction, field: StepField, folder: Path) -> str:
    collisions = []
    kd = f"<kd>{construction.kd}</kd>" if construction.kd else ""
    for number, shape in enumerate(construction.shapes(field)):
        for name, content in shape.files(f"shape_{number}").items():
            (folder / name).write_bytes(content)
        x, y, z = shape.centre
        geometry = shape.geometry(f"shape_{number}").replace("file://", f"file://{folder}/")
        surface = f"<surface><contact><ode>{kd}</ode></contact>{_FRICTION}</surface>"
        collisions.append(
            f'<collision name="collision_{number}"><pose>{x} {y} {z} 0 0 0</pose>'
            f"<geometry>{geometry}</geometry>{surface}</collision>\n"
        )
    link = f'<link name="link">{construction.link}{"".join(collisions)}</link>'
    return f'<model name="field">{link}{construction.held}</model>\n'


def _when_idle(server: Server) -> _Usage:
    """What the server has used when it stands still again."""
    calm, before = 0, _usage(server)
    while calm < 3:
        time.sleep(0.4)
        now = _usage(server)
        calm = calm + 1 if now.cpu - before.cpu < IDLE * 0.4 else 0
        before = now
    return before


def _usage(server: Server) -> _Usage:
    """From /proc, of which a server that is gone has no more to say."""
    try:
        stat = Path(f"/proc/{server.process.pid}/stat").read_text().rpartition(")")[2].split()
        status = Path(f"/proc/{server.process.pid}/status").read_text()
    except OSError as error:
        raise Lost(str(error)) from error
    resident = re.search(r"VmRSS:\s+(\d+)", status)
    if not resident:
        raise Lost("the server is dead")
    return _Usage(cpu=(int(stat[11]) + int(stat[12])) / os.sysconf("SC_CLK_TCK"), memory=int(resident[1]) / 1024)


def _record(text: str) -> list[tuple[float, dict[str, list[float]]]]:
    """Second and poses (x, y, z, roll, pitch, yaw) of the models that are told, state by state."""
    return [
        (
            int(seconds) + int(nanos) / 1e9,
            {name: [float(number) for number in pose.split()] for name, pose in _MODEL.findall(models)},
        )
        for seconds, nanos, models in _STATE.findall(text)
    ]
