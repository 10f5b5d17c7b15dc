"""What a map is and costs, and what a person should know of it before opening it."""

from __future__ import annotations

from dataclasses import dataclass

from rsegen.exporters.constraint_report import missing
from rsegen.exporters.gazebo import MESH_TYPES, export
from rsegen.exporters.gazebo.obj import faces
from rsegen.exporters.scene import Scene
from rsegen.recipe.plugin_record import needed_plugins
from rsegen.recipe.recipe import Recipe

MANY = 1000
"""From here on models (1.5 MB and 10 ms each in Gazebo Classic) or collisions (0.25 MB) are felt."""


@dataclass(frozen=True, kw_only=True, slots=True)
class MapSummary:
    """What a map is and costs: cells with frames, metres, blocks of each level; models, faces to be seen and bytes."""

    name: str
    seed: int
    cells: tuple[int, int]
    extent: tuple[float, float]
    unit_cm: float
    level_counts: dict[int, int]
    mesh_type: str
    models: int
    collisions: int
    faces: int
    bytes: int
    plugins: dict[str, str]
    warnings: tuple[str, ...]


def map_summary(scene: Scene) -> MapSummary:
    """The account of a map: its files are made for it, and not written."""
    size = seen = 0
    for path, content in export(scene).items():
        for piece in content:
            size += len(piece)
            seen += faces(piece) if path.match("meshes/*.obj") else 0
    mesh_type = MESH_TYPES[scene.recipe.mesh_type]
    return MapSummary(
        name=scene.name,
        seed=scene.recipe.seed,
        cells=scene.field.shape,
        extent=scene.field.extent,
        unit_cm=scene.recipe.unit_cm,
        level_counts=scene.field.level_counts(),
        mesh_type=scene.recipe.mesh_type,
        models=mesh_type.models(scene),
        collisions=mesh_type.collisions(scene),
        faces=seen or 6 * mesh_type.models(scene),
        bytes=size,
        plugins=needed_plugins(scene.recipe),
        warnings=warnings(scene),
    )


def warnings(scene: Scene) -> tuple[str, ...]:
    """What a person should know of a map before opening it."""
    found = []
    if not scene.field.levels.any():
        found.append("every block is at level 0: there is nothing to see but frames and ground")
    if lacks := missing(scene):
        found.append(lacks)
    if _is_lost_on_meshes(scene.recipe):
        found.append("Gazebo Sim gives every mesh a friction of 1; for that of the recipe give collision boxes")
    mesh_type = MESH_TYPES[scene.recipe.mesh_type]
    models = mesh_type.models(scene)
    if models > MANY:
        found.append(
            f"{models:,} models: Gazebo Classic needs about {models * 1.5 / 1000:,.1f} GB and {models / 100:,.0f} s to "
            "load them, Gazebo Sim CPU at every step; mesh_type pallet or single costs a hundredth"
        )
    elif (collisions := mesh_type.collisions(scene)) > MANY:
        found.append(
            f"{collisions:,} collisions: Gazebo Classic needs about {collisions / 4000:,.1f} GB for them and longer to "
            "load and to step, Gazebo Sim several times the CPU; collision mesh costs next to nothing"
        )
    return tuple(found)


def _is_lost_on_meshes(recipe: Recipe) -> bool:
    """Whether a simulator that the map is for takes no notice of its friction."""
    is_mesh = recipe.collision == "mesh" and recipe.mesh_type != "multi"
    return recipe.simulator == "both" and is_mesh and not (recipe.friction == 1 and recipe.is_of_one_friction)
