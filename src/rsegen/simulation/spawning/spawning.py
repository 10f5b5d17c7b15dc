"""Maps put into a running simulation so that no model ends up inside a block."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from math import hypot

from rsegen.simulation.driving.start_poses import DROP_HEIGHT
from rsegen.simulation.robots import ROBOTS
from rsegen.simulation.simulators.live_world import LiveWorld, Pose
from rsegen.simulation.spawning.placement import Rectangle, free_rectangle
from rsegen.simulation.spawning.spawned_map import SpawnedMap

GROUND = "ground_plane"
"""The name of the ground in Gazebo's worlds, on which everything may be placed."""

RADIUS = 0.3
"""Metres: the assumed radius of a model that is not one of rsegen's robots."""


def occupied(poses: Mapping[str, Pose], maps: Sequence[SpawnedMap]) -> list[Rectangle]:
    """The rectangles that models occupy; of a model that is not one of these maps, only the origin is known."""
    known = {each.name: each.rectangle for each in maps}
    return [known.get(name) or Rectangle(at.x, at.y) for name, at in poses.items() if name != GROUND]


def at_free_place(new: SpawnedMap, poses: Mapping[str, Pose], maps: Sequence[SpawnedMap]) -> SpawnedMap:
    """The map moved to the free place that is nearest to the origin."""
    place = free_rectangle(*new.rectangle[2:], occupied(poses, maps))
    return replace(new, at=Pose(x=place.x, y=place.y, z=0))


def spawn_map(live: LiveWorld, sdf: str, new: SpawnedMap, old: SpawnedMap | None = None) -> tuple[str, ...]:
    """Spawn a map in a paused world and delete the old one, if given; gives the names of models put on top of it."""
    with _paused(live):
        live.spawn(sdf, new.at)
        moved = _raise_models(live, new, old)
        if old:
            live.delete(old.name)
    return moved


def model_radius(name: str) -> float:
    """Metres around its origin that a model covers; rsegen's robots are known by the beginning of their names."""
    kind = next((robot for kind, robot in ROBOTS.items() if name.startswith(kind)), None)
    return hypot(*kind.size[:2]) / 2 if kind else RADIUS


@contextmanager
def _paused(live: LiveWorld) -> Iterator[None]:
    """The world is paused inside; afterwards it runs only if it ran before."""
    if live.clock().paused:
        yield
        return
    live.pause()
    try:
        yield
    finally:
        live.unpause()


def _raise_models(live: LiveWorld, new: SpawnedMap, old: SpawnedMap | None) -> tuple[str, ...]:
    """Put movable models above a map upright on top of the blocks under them, as high above these as before."""
    movable = live.movable() - {new.name, old.name if old else ""}
    found = {
        name: at
        for name, at in live.poses().items()
        if name in movable and any(each.covers(at, model_radius(name)) for each in (new, old) if each)
    }
    for name, at in found.items():
        above = max(at.z - (old.top(at) if old else new.at.z), 0.0)
        live.move(name, Pose(x=at.x, y=at.y, z=new.top(at, model_radius(name)) + above + DROP_HEIGHT, yaw=at.yaw))
    return tuple(found)
