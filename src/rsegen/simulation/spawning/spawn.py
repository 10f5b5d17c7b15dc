"""`rsegen.spawn`: a map or a robot put into the running simulation, at a given or a free place.

A robot is put on top of the maps under it, as far as their heights are known; a map lifts the models on it
(`spawning`).
"""

from __future__ import annotations

import os
import os.path
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from math import hypot
from pathlib import Path
from typing import TypeAlias

from rsegen.errors import ParameterError, UnknownName, shown
from rsegen.params.streams import generator
from rsegen.recipe.examples import EXAMPLES
from rsegen.robots import ROBOTS, Robot, SdfRobot, from_file, is_robot_file
from rsegen.simulation.driving.robot_runs import DROP_HEIGHT, spots_on_map, start_pose
from rsegen.simulation.simulators.connecting import connected
from rsegen.simulation.simulators.live_world import Pose
from rsegen.simulation.spawning.spawning import (
    GROUND,
    RADIUS,
    Area,
    MapModel,
    SpawnedMap,
    at_free_place,
    free_area,
    known_maps,
    map_of,
    occupied,
    spawn_map,
    unknown_maps,
)
from rsegen.simulation.worlds import Target

_TRIES = 10
"""Spots that are tried until one is free; if ten are taken, the robot is put next to the map."""

_Spawnable: TypeAlias = Robot | SdfRobot | MapModel


@dataclass(frozen=True, kw_only=True, slots=True)
class SpawnResult:
    """The result of `rsegen.spawn`: the names of model and simulator, the pose, and the models put on top of the map.

    notes: what could not be known, in a sentence each
    """

    name: str
    simulator: str
    at: Pose
    put_on_top: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()


def spawn_model(  # noqa: PLR0913, PLR0917  # as `rsegen.spawn`
    target: Target | Robot | SdfRobot,
    which: int | str | None,
    name: str | None,
    at: Sequence[float] | None,
    output: Path,
    simulator: str | None,
    timeout: float,
) -> SpawnResult:
    """Spawn a map, by its index or name if the target has several, or a robot; see `rsegen.spawn`."""
    place = list(at or [])
    what = _robot_or_map(target, which, output)
    if name is None:
        name = what.name if isinstance(what, MapModel) else what.kind
    with connected(simulator, timeout) as (running, live):
        poses = live.poses()
        if name in poses:
            raise ParameterError("name", f"{shown(name)} exists already; give another name, or remove {name} first")
        homes = [output, *([what.folder.parent] if isinstance(what, MapModel) else [])]
        maps = known_maps(live, poses, homes)
        if isinstance(what, Robot | SdfRobot):
            spot = None if place else _on_map(what, name, maps, poses)
            pose = spot or _on_top(what, occupied(poses, maps), maps, place)
            live.spawn(what.file(name, live.backend), pose)
            notes = list(_notes(poses, maps)) if not spot and len(place) <= 2 else []
            notes += what.spawn_notes(live.backend) if isinstance(what, SdfRobot) else []
            return SpawnResult(name=name, simulator=running.name, at=pose, notes=tuple(notes))
        what.check_spawnable()
        new = SpawnedMap(name=name, field=what.field, at=_pose(place or [0, 0]))
        new = new if place else at_free_place(new, poses, maps)
        moved = spawn_map(live, what.sdf(name), new)
        return SpawnResult(name=name, simulator=running.name, at=new.at, put_on_top=moved)


def _notes(poses: Mapping[str, Pose], maps: Sequence[SpawnedMap]) -> Iterator[str]:
    """Yield a warning if there are maps whose blocks the robot may be put into."""
    for name in unknown_maps(poses, maps):
        advice = "the robot may be inside them; give the folder that it is in with -o, or X, Y and Z with --at"
        yield f"the heights of the blocks of {name} are unknown, as its recipe.json was not found; {advice}"


def _on_top(robot: Robot | SdfRobot, taken: list[Area], maps: list[SpawnedMap], at: list[float]) -> Pose:
    """Return the pose of a robot on top of the maps under it, unless z is given."""
    radius = hypot(*robot.size[:2]) / 2
    x, y = at[:2] if at else free_area(radius, radius, taken)[:2]
    ground = max((spawned.top(Pose(x=x, y=y, z=0), radius) for spawned in maps), default=0.0)
    return _pose([x, y, ground + robot.lift + DROP_HEIGHT] if len(at) <= 2 else at)


def _on_map(robot: Robot | SdfRobot, name: str, maps: list[SpawnedMap], poses: Mapping[str, Pose]) -> Pose | None:
    """Return the pose at a free spot of the first map that has one."""
    radius, body = hypot(*robot.size[:2]) / 2, robot.body_or_box
    for spawned in maps:
        others = [
            at for other, at in poses.items() if other not in (spawned.name, GROUND) and spawned.covers(at, radius)
        ]
        with suppress(ParameterError):  # no spot is left
            for seed in range(_TRIES):
                (spot,) = spots_on_map(spawned.field, body, 1, generator(seed, 0, name))
                x, y = spawned.outside(spot.x, spot.y)
                if all(hypot(at.x - x, at.y - y) > radius + RADIUS for at in others):
                    inside = start_pose(spot)
                    z, yaw = spawned.at.z + inside.z + robot.lift, spawned.at.yaw + spot.yaw
                    return replace(inside, x=x, y=y, z=z, yaw=yaw)
    return None


def _robot_or_map(target: Target | Robot | SdfRobot, which: int | str | None, output: Path) -> _Spawnable:
    if isinstance(target, str) and target in ROBOTS:
        target = ROBOTS[target]
    elif isinstance(target, str | os.PathLike) and is_robot_file(os.fspath(target)):
        target = from_file(target)
    if isinstance(target, Robot | SdfRobot):
        if which is not None:
            raise ParameterError("map", f"{target.kind} is a robot and has no maps")
        return target
    if isinstance(target, str):
        _refuse_unknown_word(target)
    return map_of(target, which, output)


def _refuse_unknown_word(target: str) -> None:
    """UnknownName for a bare word that names nothing."""
    bare = not (os.path.exists(target) or Path(target).suffix or os.sep in target or "#" in target)
    if bare and target not in EXAMPLES:
        raise UnknownName.among("", "folder, recipe, example or robot", target, [*ROBOTS, *EXAMPLES])


def _pose(at: Sequence[float]) -> Pose:
    x, y, z, yaw = [*at, 0.0, 0.0, 0.0][:4]
    return Pose(x=x, y=y, z=z, yaw=yaw)
