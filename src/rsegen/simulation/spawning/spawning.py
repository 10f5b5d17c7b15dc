"""Maps put into a running simulation so that no model ends up inside a block.

A new map or robot gets the free place nearest to the origin; a map that replaces another comes while the world is
paused, and models on it are put upright on top of the blocks under them, as high above these as before. A map is known
by its recipe.json, in the folder of its mesh or in a folder of its name; of other models only the origin is known. Maps
are models in folders that stay, as the simulator reads their meshes as long as it runs. What breaks it: a map whose
recipe is not found, whose blocks are taken for flat ground, and a map that is not upright.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain, count, product
from math import cos, floor, hypot, sin
from pathlib import Path
from typing import NamedTuple

from rsegen.errors import OutputError, ParameterError, RsegenError
from rsegen.exporters.scene import Scene, compose
from rsegen.field.stepfield import StepField
from rsegen.io.input_files import text_of
from rsegen.io.recipe_file import load
from rsegen.io.targets import recipe_files, recipe_in
from rsegen.recipe.recipe import Recipe
from rsegen.robots import ROBOTS
from rsegen.simulation.driving.robot_runs import DROP_HEIGHT
from rsegen.simulation.simulators.live_world import LiveWorld, Pose
from rsegen.simulation.worlds import Target, chosen, scene_of, write_world

_ROUNDING = 1e-3
"""Slack of a gap, metres: positions on the grid are rounded to millimetres."""

GAP = 0.5
"""Gap, metres, between a new model and those that are there: a small robot passes between them."""


class Area(NamedTuple):
    """An axis-aligned rectangle of ground: its centre, and half of its length and width, metres."""

    x: float
    y: float
    half_x: float = 0.0
    half_y: float = 0.0

    def is_clear_of(self, other: Area) -> bool:
        """Return whether there is a gap between both."""
        return (
            abs(self.x - other.x) > self.half_x + other.half_x + GAP - _ROUNDING
            or abs(self.y - other.y) > self.half_y + other.half_y + GAP - _ROUNDING
        )


def free_area(half_x: float, half_y: float, occupied: Sequence[Area]) -> Area:
    """Return the area nearest to the origin, on a grid around it, that is clear of all occupied ones."""
    candidates = (
        Area(round(i * (2 * half_x + GAP), 3), round(j * (2 * half_y + GAP), 3), half_x, half_y)
        for i, j in chain.from_iterable(map(_ring, count()))
    )
    return next(place for place in candidates if all(map(place.is_clear_of, occupied)))


def _ring(away: int) -> Iterator[tuple[int, int]]:
    """Yield the cells of a square ring around the origin, the nearest first; east and north before west and south."""
    line = range(-away, away + 1)
    cells = (cell for cell in product(line, line) if max(map(abs, cell)) == away)
    return iter(sorted(cells, key=lambda cell: (hypot(*cell), -cell[0], -cell[1])))


@dataclass(frozen=True, kw_only=True, slots=True)
class SpawnedMap:
    """A map under its name in the simulation, and the pose of its centre; it is upright."""

    name: str
    field: StepField
    at: Pose

    @property
    def area(self) -> Area:
        """The smallest axis-aligned rectangle around it."""
        (x, y), c, s = self.field.extent, abs(cos(self.at.yaw)), abs(sin(self.at.yaw))
        return Area(self.at.x, self.at.y, (x * c + y * s) / 2, (x * s + y * c) / 2)

    def covers(self, at: Pose, reach: float) -> bool:
        """Return whether a model at a pose, with this radius, is above the map."""
        return all(abs(x) <= along / 2 + reach for x, along in zip(self._seen(at), self.field.extent, strict=True))

    def top(self, at: Pose, reach: float = 0.0) -> float:
        """Return the z of the highest block within a radius of a pose; of the ground if there is no block."""
        window = []
        for x, along in zip(self._seen(at), self.field.extent, strict=True):
            first, last = (floor((x + along / 2 + side) / self.field.block_width) for side in (-reach, reach))
            window.append(slice(max(first, 0), max(last + 1, 0)))
        return self.at.z + float(self.field.heights[tuple(window)].max(initial=0.0))

    def outside(self, x: float, y: float) -> tuple[float, float]:
        """Return the place in the world of one in the map's own axes, from its middle."""
        c, s = cos(self.at.yaw), sin(self.at.yaw)
        return self.at.x + x * c - y * s, self.at.y + x * s + y * c

    def _seen(self, at: Pose) -> tuple[float, float]:
        """Return a place in the map's own axes, from its middle."""
        x, y, c, s = at.x - self.at.x, at.y - self.at.y, cos(self.at.yaw), sin(self.at.yaw)
        return x * c + y * s, y * c - x * s


GROUND = "ground_plane"
"""The name of the ground in Gazebo's worlds, on which everything may be placed."""

RADIUS = 0.3
"""The assumed radius, metres, of a model that is not one of rsegen's robots: that of a robot of a Jackal's class.

A larger model may be put into a block; a smaller one is only put higher than need be, and falls.
"""


def occupied(poses: Mapping[str, Pose], maps: Sequence[SpawnedMap]) -> list[Area]:
    """Return the rectangles that models occupy; of a model that is not one of these maps, only the origin is known."""
    known = {spawned.name: spawned.area for spawned in maps}
    return [known.get(name) or Area(at.x, at.y) for name, at in poses.items() if name != GROUND]


def spawn_map(live: LiveWorld, sdf: str, new: SpawnedMap, old: SpawnedMap | None = None) -> tuple[str, ...]:
    """Spawn a map and delete the old one, if given, while the world is paused; gives the models put on top of it."""
    was_paused = live.clock().paused
    if not was_paused:
        live.pause()
    try:
        live.spawn(sdf, new.at)
        moved = _raise_models(live, new, old)
        if old:
            live.delete(old.name)
    finally:
        if not was_paused:
            live.unpause()
    return moved


def model_radius(name: str) -> float:
    """Return the radius, metres, of a model; rsegen's robots are known by the beginning of their names."""
    kind = next((robot for kind, robot in ROBOTS.items() if name.startswith(kind)), None)
    return hypot(*kind.size[:2]) / 2 if kind else RADIUS


def _raise_models(live: LiveWorld, new: SpawnedMap, old: SpawnedMap | None) -> tuple[str, ...]:
    """Put movable models above a map upright on top of the blocks under them, as high above these as before."""
    movable = live.movable() - {new.name, old.name if old else ""}
    models = {
        name: at
        for name, at in live.poses().items()
        if name in movable and any(spawned.covers(at, model_radius(name)) for spawned in (new, old) if spawned)
    }
    for name, at in models.items():
        above = max(at.z - (old.top(at) if old else new.at.z), 0.0)
        live.move(name, Pose(x=at.x, y=at.y, z=new.top(at, model_radius(name)) + above + DROP_HEIGHT, yaw=at.yaw))
    return tuple(models)


_MOST_MIB = 512
"""The largest model that is read, MiB, and sent to the simulator as one message."""

_MODEL_FILE = "model.sdf"


@dataclass(frozen=True, kw_only=True)
class MapModel:
    """The recipe of one map alone, its folder, which need not exist yet, and its scene if a caller gave one."""

    recipe: Recipe
    folder: Path
    made_of: Scene | None = None

    @property
    def name(self) -> str:
        """The map's name."""
        return self.folder.name

    @property
    def field(self) -> StepField:
        """The map's blocks."""
        return self.scene.field

    @cached_property
    def scene(self) -> Scene:
        """The map's scene; TooLarge if it does not fit into memory."""
        return self.made_of or scene_of(self.recipe)

    def check_spawnable(self) -> None:
        """Raise a ParameterError if this cannot be spawned as one model."""
        if self.recipe.mesh_type != "single":
            problem = f"{self.recipe.mesh_type} makes a map of many models; only single can be spawned"
            raise ParameterError("mesh_type", problem)

    def sdf(self, name: str) -> str:
        """Return its model file under a name, with absolute paths of meshes; the map is written first if need be."""
        if not self.folder.is_dir():
            write_world(self.scene, self.folder.parent)
        file = self.folder / _MODEL_FILE
        text = text_of(file, _MOST_MIB, "a model")
        renamed = text.replace(f'<model name="{self.name}">', f'<model name="{name}">', 1)
        return renamed.replace(f"model://{self.name}/", f"{self.folder.resolve()}/")


def map_model(recipe: Recipe, output: Path, scene: Scene | None = None) -> MapModel:
    """Return the map of a recipe in an output folder; OutputError if a different map of its name exists there."""
    model = MapModel(recipe=recipe, folder=output / recipe.map_name(recipe.first_map), made_of=scene)
    if model.folder.exists() and _recipe_in(model.folder) != model.recipe:
        advice = "give that folder to spawn it as it is, or another output folder, or the recipe a seed"
        raise OutputError(f"{model.folder}: exists already and is a different map; {advice}")
    return model


def map_of(target: Target, which: int | str | None, output: Path) -> MapModel:
    """Return the map of a target, by index or name, by default the first; a recipe's goes into the output folder."""
    recipe, folder, scene = chosen(target, which)
    return MapModel(recipe=recipe, folder=folder) if folder else map_model(recipe, output, scene)


def maps_in(folder: str) -> list[MapModel]:
    """Return every map in a folder, or the map whose folder it is."""
    return [MapModel(recipe=recipe_in(file), folder=file.parent) for file in recipe_files(folder)]


def known_recipes(live: LiveWorld, poses: Mapping[str, Pose], homes: Iterable[Path]) -> dict[str, Recipe]:
    """Return the known recipes of the maps in a simulation, by their names.

    A recipe is known if it is in the folder of the mesh, or in a folder of the map's name in one of `homes`.
    """
    meshes, homes = live.mesh_files(), list(homes)
    recipes = {}
    for name in poses:
        mesh = Path(meshes.get(name, ""))
        folders = [mesh.parents[1]] if mesh.is_absolute() and len(mesh.parts) > 3 else []
        folders += [home / name for home in homes if _is_map_name(name)]
        if recipe := next(filter(None, map(_recipe_in, folders)), None):
            recipes[name] = recipe
    return recipes


def known_maps(live: LiveWorld, poses: Mapping[str, Pose], homes: Iterable[Path]) -> list[SpawnedMap]:
    """Return the maps among the models of a simulation whose recipe is known."""
    return [
        SpawnedMap(name=name, field=compose(recipe, recipe.first_map).field, at=poses[name])
        for name, recipe in known_recipes(live, poses, homes).items()
    ]


def unknown_map_notes(poses: Mapping[str, Pose], known: Iterable[SpawnedMap]) -> Iterator[str]:
    """Yield a warning for each model that is called like a map and is none of these: its heights are unknown."""
    names = {spawned.name for spawned in known}
    for name in poses:
        if _is_map_name(name) and name not in names:
            advice = "the robot may be inside them; give output='DIR', the folder that it is in, or at=[X, Y, Z]"
            yield f"the heights of the blocks of {name} are unknown, as its recipe.json was not found; {advice}"


def _is_map_name(name: str) -> bool:
    return re.fullmatch(r"[\w-]+_\d{4,}", name) is not None


def _recipe_in(folder: Path) -> Recipe | None:
    try:
        return load(folder / "recipe.json")
    except RsegenError:
        return None
