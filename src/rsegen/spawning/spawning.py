"""`rsegen.spawn`, `respawn` and `remove`: maps and robots spawned in the running simulation, never inside blocks.

A new map or robot gets the free place nearest to the origin, unless a place is given; a robot is put on top of the maps
under it. A map is known by its recipe.json, in the folder of its mesh or in a folder of its name; of other models only
the origin is known. The map to replace is the one of the same recipes, else the only one whose recipe is known; the new
one is the next in the folder, or the next index of the recipe. It comes before the old one goes, while the world is
paused, and models on it are put upright on top of the blocks under them, as high above these as before. Maps are models
in folders that stay, as the simulator reads their meshes as long as it runs. What breaks it: a map without a known
recipe, which counts as flat ground, and a map that is not upright.
"""

from __future__ import annotations

import os
import os.path
import re
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from math import hypot
from pathlib import Path
from typing import TypeAlias

from rsegen.errors import ParameterError, UnknownName, shown
from rsegen.field.stepfield import StepField
from rsegen.gazebo.sdf import numbers
from rsegen.geometry.poses import rotation
from rsegen.params.streams import generator
from rsegen.recipe.examples import EXAMPLES
from rsegen.recipe.recipe import Recipe
from rsegen.recipe.recipe_file import recipe_in
from rsegen.robots.base import ROBOTS, Robot
from rsegen.robots.files.sdf_file import SdfRobot, from_file, is_robot_file
from rsegen.robots.lookup import DrivableRobot, robot_of
from rsegen.scene.scene import Scene, compose
from rsegen.simulators.connecting import connected, opened_folder
from rsegen.simulators.live_world import LiveWorld
from rsegen.simulators.poses import DROP_HEIGHT, Pose
from rsegen.spawning.map_models import MapModel, known_recipes, map_model, map_of, unknown_map_notes
from rsegen.spawning.placement import (
    GROUND,
    Area,
    SpawnedMap,
    crowded_map_notes,
    crowded_robot_notes,
    free_area,
    model_radius,
    occupied,
)
from rsegen.standing.resting import resting_poses
from rsegen.standing.spots import find_spots
from rsegen.writing.target_worlds import Target, path_of, recipe_files


def spawn_map(live: LiveWorld, sdf: str, new: SpawnedMap, old: SpawnedMap | None = None) -> tuple[str, ...]:
    """Spawn a map, and delete the old one, if given, in a paused world; return the models that were put on top."""
    was_paused = live.clock().paused
    try:
        if not was_paused:  # inside, as Ctrl-C may come between the order to pause and its report
            live.pause()
        live.spawn(sdf, new.at)
        moved = _raise_models(live, new, old)
        if old:
            live.delete(old.name)
    finally:
        if not was_paused:
            live.unpause()
    return moved


def _raise_models(live: LiveWorld, new: SpawnedMap, old: SpawnedMap | None) -> tuple[str, ...]:
    """Put movable models above a map upright on top of the blocks under them, as high above these as before."""
    movable = live.movable() - {new.name, old.name if old else ""}
    # Models above either map: on the old one they would fall, inside the new one they would be thrown out.
    models = {
        name: at
        for name, at in live.poses().items()
        if name in movable and any(spawned.covers(at, model_radius(name)) for spawned in (new, old) if spawned)
    }
    for name, at in models.items():
        above = max(at.z - (old.top(at) if old else new.at.z), 0.0)
        live.move(name, Pose(x=at.x, y=at.y, z=new.top(at, model_radius(name)) + above + DROP_HEIGHT, yaw=at.yaw))
    return tuple(models)


_TRIES = 10
"""Spots that are tried until one is free; if ten are taken, the robot is put next to the map."""

_NO_SPOT = "{map} has no free spot for {robot}, which is put next to it; to put it on the map, set pose=[X, Y, YAW]"

_Spawnable: TypeAlias = DrivableRobot | MapModel


@dataclass(frozen=True, kw_only=True, slots=True)
class SpawnResult:
    """The result of `rsegen.spawn`.

    Attributes
    ----------
    name : str
        Name of the model.
    simulator : str
        Title and version.
    at : Pose
        Its pose, metres and radians.
    put_on_top : tuple of str
        Names of the models that were put on top of the map.
    on : str or None
        The map under the robot, if it was to be put on one.
    notes : tuple of str
        A sentence each on what could not be known, or was spawned too.
    """

    name: str
    simulator: str
    at: Pose
    put_on_top: tuple[str, ...] = ()
    on: str | None = None
    notes: tuple[str, ...] = ()


def spawn_model(  # noqa: PLR0913, PLR0917  # as `rsegen.spawn`
    target: Target | DrivableRobot,
    which: int | str | None,
    name: str | None,
    at: Sequence[float] | None,
    robot: str | os.PathLike[str] | DrivableRobot | None,
    pose: Sequence[float] | None,
    output: Path,
    simulator: str | None,
    timeout: float,
) -> SpawnResult:
    """Spawn a map, by its index or name if the target has several, or a robot; see `rsegen.spawn`."""
    place = list(at or [])
    spawnable = _robot_or_map(target, which, output)
    rider = _rider(spawnable, robot, pose)
    if name is None:
        name = rider.kind if rider else spawnable.name if isinstance(spawnable, MapModel) else spawnable.kind
    with connected(simulator, timeout) as (running, live):
        poses = live.poses()
        if name in poses:
            raise ParameterError("name", f"{shown(name)} exists already; use another name, or remove {name} first")
        own = [spawnable.folder.parent] if isinstance(spawnable, MapModel) else []
        homes = [*opened_folder(running), output, *own]
        maps = [
            SpawnedMap(name=known, field=compose(recipe, recipe.first_map).field, at=poses[known])
            for known, recipe in known_recipes(live, poses, homes).items()
        ]
        # Three cases: a robot alone, a map alone, and a robot on a map, which is spawned first if it is not there.
        if not isinstance(spawnable, MapModel):
            spot = None if place else _on_map(spawnable, name, maps, poses)
            start = spot or _on_top(spawnable, occupied(poses, maps), maps, place)
            live.spawn(spawnable.file(name, live.backend), start)
            notes = list(unknown_map_notes(poses, maps)) if not spot and len(place) <= 2 else []
            notes += _own_notes(spawnable, start, live, poses, maps)
            return SpawnResult(name=name, simulator=running.name, at=start, notes=tuple(notes))
        if rider is None:
            new, moved = _spawned(live, spawnable, name, place, poses, maps)
            notes = list(crowded_map_notes(new, maps))
            return SpawnResult(name=name, simulator=running.name, at=new.at, put_on_top=moved, notes=tuple(notes))
        at_rest = _at_rest(spawnable.field, rider, pose) if pose else None
        ground, moved, notes = _running_map(spawnable, poses, maps, place), (), []
        if ground is None:
            ground, moved = _spawned(live, spawnable, spawnable.name, place, poses, maps)
            notes = [f"{ground.name} was not in the simulation, and was spawned too", *crowded_map_notes(ground, maps)]
            poses, maps = live.poses(), [*maps, ground]
        if at_rest:
            start = _in_world(at_rest, rider, ground)
        else:
            spot = _on_map(rider, name, [ground], poses)
            start = spot or _on_top(rider, occupied(poses, maps), maps, [])
            notes += [] if spot else [_NO_SPOT.format(map=ground.name, robot=rider.kind)]
        live.spawn(rider.file(name, live.backend), start)
        notes += _own_notes(rider, start, live, poses, maps)
        on = ground.name if ground.covers(start, 0.0) else None
        return SpawnResult(name=name, simulator=running.name, at=start, put_on_top=moved, on=on, notes=tuple(notes))


def _rider(
    spawnable: _Spawnable, robot: str | os.PathLike[str] | DrivableRobot | None, pose: object
) -> DrivableRobot | None:
    """Return the robot that is to be put on a map, if one is; a ParameterError for one without a map."""
    if robot is None:
        if pose is not None:
            raise ParameterError("pose", "is the place of a robot on a map; set robot too")
        return None
    if not isinstance(spawnable, MapModel):
        raise ParameterError("robot", f"{spawnable.kind} is a robot already; pass the map that this one is put on")
    return robot_of(robot, "robot")


def _spawned(
    live: LiveWorld, model: MapModel, name: str, place: list[float], poses: Mapping[str, Pose], maps: list[SpawnedMap]
) -> tuple[SpawnedMap, tuple[str, ...]]:
    """Spawn a map at a place, or at a free one, and return it with the names of the models put on top of it."""
    model.check_spawnable()
    new = SpawnedMap(name=name, field=model.field, at=_pose(place or [0, 0]))
    if not place:
        new = replace(new, at=_pose(free_area(*new.area[2:], occupied(poses, maps))[:2]))
    return new, spawn_map(live, model.sdf(name), new)


def _running_map(
    model: MapModel, poses: Mapping[str, Pose], maps: Sequence[SpawnedMap], place: list[float]
) -> SpawnedMap | None:
    """Return the map of this name in the simulation, None if it has none.

    A ParameterError if that map has other blocks, or if a place is set for it.
    """
    if model.name not in poses:
        return None
    running = next((spawned for spawned in maps if spawned.name == model.name), None)
    if running is None or running.field != model.field:
        raise ParameterError("", f"{model.name} in the simulation has other blocks; remove it first, or respawn it")
    if place:
        raise ParameterError(
            "at", f"{model.name} is in the simulation already; leave the place out, or remove it first"
        )
    return running


def _at_rest(field: StepField, robot: DrivableRobot, place: Sequence[float]) -> Pose:
    """Return the pose of a robot at rest on a map; a ParameterError if it does not stand there."""
    try:
        rest = resting_poses(field, robot.body_or_box, *place)
    except ParameterError as error:  # of x, y or the robot
        where = {"x": "pose[0]", "y": "pose[1]"}.get(error.where, error.where)
        raise ParameterError(where, error.problem) from None
    if not rest.stands[0]:
        raise ParameterError("pose", f"{robot.kind} tips over at {numbers(place)}; choose a place where it stands")
    x, y, z, roll, pitch, yaw = (float(of[0]) for of in (rest.x, rest.y, rest.z, rest.roll, rest.pitch, rest.yaw))
    return Pose(x=x, y=y, z=z + DROP_HEIGHT, roll=roll, pitch=pitch, yaw=yaw)


def _in_world(rest: Pose, robot: DrivableRobot, ground: SpawnedMap) -> Pose:
    """Return the pose of a robot's model in the world, from the pose of its body on a map."""
    # A body has its origin on the ground below the robot, a model `lift` above, along the robot's own z.
    up = robot.lift * rotation(rest.roll, rest.pitch, rest.yaw)[:, 2]
    x, y = ground.outside(rest.x + float(up[0]), rest.y + float(up[1]))
    return replace(rest, x=x, y=y, z=ground.at.z + rest.z + float(up[2]), yaw=ground.at.yaw + rest.yaw)


def _own_notes(
    robot: DrivableRobot, start: Pose, live: LiveWorld, poses: Mapping[str, Pose], maps: Sequence[SpawnedMap]
) -> list[str]:
    crowded = crowded_robot_notes(start, hypot(*robot.size[:2]) / 2, poses, maps)
    return [*crowded, *(robot.spawn_notes(live.backend) if isinstance(robot, SdfRobot) else ())]


def _on_top(robot: DrivableRobot, taken: list[Area], maps: list[SpawnedMap], at: list[float]) -> Pose:
    """Return the pose of a robot on top of the maps under it, unless z is given."""
    radius = hypot(*robot.size[:2]) / 2
    x, y = at[:2] if at else free_area(radius, radius, taken)[:2]
    ground = max((spawned.top(Pose(x=x, y=y, z=0), radius) for spawned in maps), default=0.0)
    return _pose([x, y, ground + robot.lift + DROP_HEIGHT] if len(at) <= 2 else at)


def _on_map(robot: DrivableRobot, name: str, maps: list[SpawnedMap], poses: Mapping[str, Pose]) -> Pose | None:
    """Return the pose at a free spot of the first map that has one."""
    radius, body = hypot(*robot.size[:2]) / 2, robot.body_or_box
    for spawned in maps:
        others = [
            (at, model_radius(model))
            for model, at in poses.items()
            if model not in (spawned.name, GROUND) and spawned.covers(at, radius)
        ]
        with suppress(ParameterError):  # no spot is left
            for seed in range(_TRIES):  # with its name: the same model on the same map gets the same spot
                (spot,) = find_spots(spawned.field, body, 1, generator(seed, 0, name))
                start = _in_world(Pose.above(spot), robot, spawned)
                if all(hypot(at.x - start.x, at.y - start.y) > radius + other for at, other in others):
                    return start
    return None


def _robot_or_map(target: Target | DrivableRobot, which: int | str | None, output: Path) -> _Spawnable:
    if isinstance(target, str) and target in ROBOTS:
        target = ROBOTS[target]
    elif isinstance(target, str | os.PathLike) and is_robot_file(os.fspath(target)):
        target = from_file(target)
    if isinstance(target, Robot | SdfRobot):
        if which is not None:
            raise ParameterError("map", f"{target.kind} is a robot and has no maps")
        return target
    # A bare word that names nothing may be a robot's, so both are listed.
    if (
        isinstance(target, str)
        and target not in EXAMPLES
        and not (os.path.exists(target) or Path(target).suffix or os.sep in target or "#" in target)
    ):
        raise UnknownName.among("", "folder, recipe, example or robot", target, [*ROBOTS, *EXAMPLES])
    return map_of(target, which, output)


def _pose(at: Sequence[float]) -> Pose:
    x, y, z, yaw = [*at, 0.0, 0.0, 0.0][:4]
    return Pose(x=x, y=y, z=z, yaw=yaw)


@dataclass(frozen=True, kw_only=True, slots=True)
class RespawnResult:
    """The result of `rsegen.respawn`.

    Attributes
    ----------
    name : str
        Name of the new map's model.
    instead_of : str
        Name of the old one.
    simulator : str
        Title and version.
    at : Pose
        Pose of both, metres and radians.
    put_on_top : tuple of str
        Names of the models that were put on top of the new blocks.
    """

    name: str
    instead_of: str
    simulator: str
    at: Pose
    put_on_top: tuple[str, ...] = ()


def replace_map(  # as `rsegen.respawn`
    target: Target, which: int | str | None, name: str | None, output: Path, simulator: str | None, timeout: float
) -> RespawnResult:
    """Replace the map in the simulation by another one, by default the next; see `rsegen.respawn`."""
    recipes, homes = _recipes(target), [output]
    if not isinstance(target, Scene | Recipe) and os.path.isdir(target):
        homes += [Path(target), Path(target).parent]
    with connected(simulator, timeout) as (running, live):
        poses = live.poses()
        known = known_recipes(live, poses, [*opened_folder(running), *homes])
        current = _current_map(poses, {recipe.name for recipe in recipes}, known, name)
        new = _given_or_next(target, which, output, current)
        new.check_spawnable()
        if new.name in poses:
            problem = f"{shown(new.name)} exists already; choose another"
            if which is None and new.name == current:
                problem = f"{shown(current)} is in the simulation, and {shown(str(target))} has no other map"
            raise ParameterError("" if which is None else "map", problem)
        # The blocks of a map whose folder is unknown are those that the recipe gives for its index.
        recipe = known.get(current) or recipes[0].alone(_index(recipes[0], current) or recipes[0].first_map)
        old = SpawnedMap(name=current, field=compose(recipe, recipe.first_map).field, at=poses[current])
        moved = spawn_map(live, new.sdf(new.name), SpawnedMap(name=new.name, field=new.field, at=old.at), old)
    return RespawnResult(name=new.name, instead_of=current, simulator=running.name, at=old.at, put_on_top=moved)


def _recipes(target: Target) -> list[Recipe]:
    if isinstance(target, Scene):
        return [target.recipe]
    if isinstance(target, Recipe):
        return [target]
    return [recipe_in(file) for file in recipe_files(path_of(target))]


def _current_map(poses: Mapping[str, Pose], stems: set[str], known: Iterable[str], given: str | None) -> str:
    """Return the name of the map that is to be replaced: one of the same recipes, else any other map that is known."""
    models = ", ".join(sorted(poses))
    if given is not None:
        if given not in poses:
            raise ParameterError("name", f"no model {shown(given)} in the simulation (models: {models})")
        return given
    # Maps of a recipe are called NAME_0000 and on; any other map counts only if its recipe is known.
    pattern = "|".join(rf"{re.escape(stem)}_\d{{4,}}" for stem in sorted(stems))
    candidates = sorted(name for name in poses if re.fullmatch(pattern, name)) or sorted(known)
    if not candidates:
        examples = " or ".join(f"{stem}_0000" for stem in sorted(stems))
        raise ParameterError("", f"no map such as {examples} in the simulation (models: {models})")
    if len(candidates) > 1:
        raise ParameterError("name", f"several maps could be replaced; choose one of {', '.join(candidates)}")
    return candidates[0]


def _given_or_next(target: Target, which: int | str | None, output: Path, current: str) -> MapModel:
    """Return the given map, else the one after the current map, in the folder or by its index."""
    if which is not None or isinstance(target, Scene):
        return map_of(target, which, output)
    if not isinstance(target, Recipe) and os.path.isdir(target):
        maps = [MapModel(recipe=recipe_in(file), folder=file.parent) for file in recipe_files(path_of(target))]
        names = [model.name for model in maps]
        return maps[(names.index(current) + 1) % len(maps)] if current in names else maps[0]
    (recipe,) = _recipes(target)
    index = _index(recipe, current)
    return map_model(recipe.alone(recipe.first_map if index is None else index + 1), output)


def _index(recipe: Recipe, name: str) -> int | None:
    """Return the index of the map of this name."""
    digits = name.removeprefix(f"{recipe.name}_")
    return int(digits) if digits.isdecimal() and recipe.map_name(int(digits)) == name else None


@dataclass(frozen=True, kw_only=True, slots=True)
class RemoveResult:
    """The result of `rsegen.remove`.

    Attributes
    ----------
    removed : tuple of str
        Names of the deleted models.
    simulator : str
        Title and version.
    """

    removed: tuple[str, ...]
    simulator: str


def remove_models(names: Sequence[str], simulator: str | None, timeout: float) -> RemoveResult:
    """Delete models, or none of them if one does not exist; see `rsegen.remove`."""
    if not names:
        raise ParameterError("names", "no name; pass the names of models in the simulation")
    unique = tuple(dict.fromkeys(names))
    with connected(simulator, timeout) as (running, live):
        models = live.poses()
        for name in unique:
            if name not in models:
                raise UnknownName.among("", "model", name, models)
        for name in unique:
            live.delete(name)
    return RemoveResult(removed=unique, simulator=running.name)
