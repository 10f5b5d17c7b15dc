"""A running simulation changed: a model put in, a map replaced; nothing ends up inside a block."""

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
"""What Gazebo's worlds call the ground, on which everything may stand."""

REACH = 0.3
"""Metres around its origin that a model other than our robots is taken to reach."""


def occupied(poses: Mapping[str, Pose], maps: Sequence[SpawnedMap]) -> list[Rectangle]:
    """Where something stands; of what is not one of these maps, only its origin is known."""
    known = {each.name: each.rectangle for each in maps}
    return [known.get(name) or Rectangle(at.x, at.y) for name, at in poses.items() if name != GROUND]


def at_free_place(new: SpawnedMap, poses: Mapping[str, Pose], maps: Sequence[SpawnedMap]) -> SpawnedMap:
    """A map at the free place that is nearest to the origin."""
    place = free_rectangle(*new.rectangle[2:], occupied(poses, maps))
    return replace(new, at=Pose(x=place.x, y=place.y, z=0))


def put(live: LiveWorld, sdf: str, new: SpawnedMap, old: SpawnedMap | None = None) -> list[str]:
    """Put a map in, instead of another if one is given, while time stands still; gives what was put on top of it."""
    with _standing(live):
        live.spawn(sdf, new.at)
        moved = _lifted(live, new, old)
        if old:
            live.delete(old.name)
    return moved


def model_radius(name: str) -> float:
    """How far a model reaches around its origin, metres; robots of ours are known by how their names begin."""
    kind = next((robot for kind, robot in ROBOTS.items() if name.startswith(kind)), None)
    return hypot(*kind.size[:2]) / 2 if kind else REACH


@contextmanager
def _standing(live: LiveWorld) -> Iterator[None]:
    """While time stands still; it goes on only where it went before."""
    if live.clock().paused:
        yield
        return
    live.pause()
    try:
        yield
    finally:
        live.unpause()


def _lifted(live: LiveWorld, new: SpawnedMap, old: SpawnedMap | None) -> list[str]:
    """Put what can move and is above a map upright on top of the blocks under it, as high above them as it was."""
    movable = live.movable() - {new.name, old.name if old else ""}
    found = {
        name: at
        for name, at in live.poses().items()
        if name in movable and any(each.covers(at, model_radius(name)) for each in (new, old) if each)
    }
    for name, at in found.items():
        above = max(at.z - (old.top(at) if old else new.at.z), 0.0)
        live.move(name, Pose(x=at.x, y=at.y, z=new.top(at, model_radius(name)) + above + DROP_HEIGHT, yaw=at.yaw))
    return list(found)
