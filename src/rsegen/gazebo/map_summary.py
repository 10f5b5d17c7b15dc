"""The summary of a map: its size, what it costs to simulate, and warnings to read before opening it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from rsegen.gazebo import MESH_TYPES, export
from rsegen.gazebo.obj import face_count
from rsegen.recipe.building import covered_obstacles
from rsegen.recipe.recipe import Recipe
from rsegen.scene.scene import Scene

MANY = 1000
"""Models (1.5 MB and 10 ms each in Gazebo Classic) or collisions (0.25 MB each) above which there is a warning: 1.5 GB
and ten seconds, or 0.25 GB, which a small laptop feels."""


class Costs(NamedTuple):
    """The cost of a map: models and collision shapes in the simulator, visual faces, and bytes of its files."""

    models: int
    collisions: int
    faces: int
    bytes: int


def costs(scene: Scene) -> Costs:
    """Return the cost of a map; makes its files in memory and does not write them."""
    # Sizes and faces are counted in the files themselves, piece by piece, so that they are those that are written.
    size = faces = 0
    for path, content in export(scene).items():
        for piece in content:
            size += len(piece)
            faces += face_count(piece) if path.match("meshes/*.obj") else 0
    models, collisions = MESH_TYPES[scene.recipe.mesh_type].counts(scene)
    return Costs(models, collisions, faces or 6 * models, size)


def switched_off(recipe: Recipe) -> list[str]:
    """Return the obstacles of a recipe that are not in its maps, as in messages."""
    return [
        f"obstacles[{row}]: {obstacle.kind}" for row, obstacle in enumerate(recipe.obstacles) if not obstacle.enabled
    ]


def size_in_words(grid: tuple[int, int], cells: tuple[int, int]) -> str:
    """Return the size of a map as `10 x 10 blocks (12 x 12 cells with frames)`, a frame being a cell wide."""
    blocks = f"{grid[0]} x {grid[1]} blocks"
    return blocks if cells == grid else f"{blocks} ({cells[0]} x {cells[1]} cells with frames)"


def covered_obstacles_in_words(scene: Scene) -> Iterator[str]:
    """Yield a line for each obstacle of a map that later ones cover wholly."""
    rows = scene.recipe.obstacles
    for row, over in covered_obstacles(scene.recipe, scene.index):
        names = [f"obstacles[{place}] ({rows[place].kind})" for place in (row, *over)]
        more = f" and {len(over) - 3} more" if len(over) > 3 else ""
        yield f"{names[0]} is wholly covered by {', '.join(names[1:4])}{more}; the map has no block of it"


def warnings(scene: Scene) -> tuple[str, ...]:
    """Return the warnings of a map, a line each: nothing to see, obstacles under others, missing blocks, lost friction,
    slow in a simulator.
    """
    lines = []
    if not scene.field.levels.any():
        lines.append("every block is at level 0: there is nothing to see except frames and ground")
    lines += covered_obstacles_in_words(scene)
    recipe = scene.recipe
    if recipe.is_constrained:
        from rsegen.gazebo.constraint_report import block_warnings

        lines += block_warnings(scene)
    is_mesh = recipe.collision == "mesh" and recipe.mesh_type != "multi"
    if recipe.simulator == "both" and is_mesh and not (recipe.friction == 1 and recipe.is_of_one_friction):
        lines.append(
            "Gazebo Sim ignores the friction of mesh collisions (it uses 1); "
            "set collision: boxes to keep it, which costs CPU time"
        )
    models, collisions = MESH_TYPES[recipe.mesh_type].counts(scene)
    # The figures are those of MANY; collisions matter only if the models do not already.
    if models > MANY:
        lines.append(
            f"{models:,} models: Gazebo Classic needs about {models * 1.5 / 1000:,.1f} GB and {models / 100:,.0f} s to "
            "load them, Gazebo Sim CPU time in every step; mesh_type: pallet or single is about 100 times cheaper"
        )
    elif collisions > MANY:
        lines.append(
            f"{collisions:,} collisions: Gazebo Classic needs about {collisions / 4000:,.1f} GB for them and longer to "
            "load and to step, Gazebo Sim several times the CPU time; collision: mesh costs almost nothing"
        )
    return tuple(lines)
