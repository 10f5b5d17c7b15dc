"""From a recipe to worlds on disk: what command line, window and scripts call.

Recipe --build--> StepField --compose--> Scene --export--> Bundle --write--> files
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from rsegen.export import MESH_TYPES, export
from rsegen.export.obj import faces
from rsegen.recipe import Recipe
from rsegen.room import refuse_too_large, refuse_too_many
from rsegen.scene import Scene, compose
from rsegen.writer import refuse_not_a_folder, refuse_taken, write

MANY = 1000
"""From here on models (1.5 MB and 10 ms each in Gazebo Classic) or collisions (0.25 MB) are felt."""


@dataclass(frozen=True, kw_only=True, slots=True)
class GeneratedMap:
    """One map on disk: where, how large (cells with frames, metres), its blocks of each level, what to know of it."""

    name: str
    index: int
    folder: Path
    files: tuple[Path, ...]
    cells: tuple[int, int]
    extent: tuple[float, float]
    level_counts: dict[int, int]
    warnings: tuple[str, ...]

    @property
    def world(self) -> Path:
        """The file that a simulator opens."""
        return self.folder / f"{self.name}.world"


@dataclass(frozen=True, kw_only=True, slots=True)
class Generated:
    """All maps of a recipe on disk."""

    recipe: Recipe
    folder: Path
    maps: tuple[GeneratedMap, ...]


def generate(
    recipe: Recipe,
    folder: str | Path,
    *,
    force: bool = False,
    preview: bool = False,
    progress: Callable[[GeneratedMap], None] | None = None,
) -> Generated:
    """Write every map of a recipe as `folder/NAME_000k`; `progress` is told of each that is done.

    `force` replaces maps that are there already; `preview` adds a picture to each. Raises an OutputError before
    anything is written where a map's folder is taken, TooLarge where there is no room for the maps.
    """
    folder = Path(folder)
    refuse_too_large(recipe)
    refuse_not_a_folder(folder)
    refuse_too_many(recipe, folder)
    refuse_taken((folder / recipe.map_name(index) for index in recipe.indices), force=force)
    made = []
    for index in recipe.indices:
        made.append(_generate_map(compose(recipe, index), folder, force=force, preview=preview))
        if progress:
            progress(made[-1])
    return Generated(recipe=recipe, folder=folder, maps=tuple(made))


@dataclass(frozen=True, kw_only=True, slots=True)
class Account:
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
    warnings: tuple[str, ...]


def account(scene: Scene) -> Account:
    """The account of a map: its files are made for it, and not written."""
    size = seen = 0
    for path, content in export(scene).items():
        for piece in content:
            size += len(piece)
            seen += faces(piece) if path.suffix == ".obj" else 0
    mesh_type = MESH_TYPES[scene.recipe.mesh_type]
    return Account(
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
        warnings=warnings(scene),
    )


def warnings(scene: Scene) -> tuple[str, ...]:
    """What a person should know of a map before opening it."""
    found = []
    if not scene.field.levels.any():
        found.append("every block is at level 0: there is nothing to see but frames and ground")
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


def _generate_map(scene: Scene, folder: Path, *, force: bool, preview: bool) -> GeneratedMap:
    bundle = dict(export(scene))
    if preview:
        from rsegen.drawing import picture

        bundle[PurePosixPath("preview.png")] = [picture(scene)]
    home = folder / scene.name
    return GeneratedMap(
        name=scene.name,
        index=scene.index,
        folder=home,
        files=tuple(write(bundle, home, force=force)),
        cells=scene.field.shape,
        extent=scene.field.extent,
        level_counts=scene.field.level_counts(),
        warnings=warnings(scene),
    )
