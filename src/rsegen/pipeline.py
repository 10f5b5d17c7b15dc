"""From a recipe to worlds on disk: what command line, window and scripts call.

    Recipe --build--> StepField --compose--> Scene --export--> Bundle --write--> files
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from rsegen.errors import OutputError
from rsegen.export import export
from rsegen.memory import refuse_too_large
from rsegen.recipe import Recipe
from rsegen.scene import Scene, compose
from rsegen.writer import refuse_taken, write

MANY_MODELS = 1000
"""From here on a world of many models is slow to load (about 1.5 MB and 10 ms each in Gazebo Classic)."""


@dataclass(frozen=True, kw_only=True, slots=True)
class GeneratedMap:
    """One map on disk: where, how large (cells with frames), how many blocks of each level, and what to know of it."""

    name: str
    index: int
    folder: Path
    files: tuple[Path, ...]
    cells: tuple[int, int]
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
    anything is written where a map's folder is taken, TooLarge where it would not fit into memory.
    """
    folder = Path(folder)
    refuse_too_large(recipe)
    if folder.exists() and not folder.is_dir():
        raise OutputError(f"{folder}: is a file; give a folder")
    refuse_taken((folder / recipe.map_name(index) for index in recipe.indices), force=force)
    made = []
    for index in recipe.indices:
        made.append(_generate_map(compose(recipe, index), folder, force=force, preview=preview))
        if progress:
            progress(made[-1])
    return Generated(recipe=recipe, folder=folder, maps=tuple(made))


def warnings(scene: Scene) -> tuple[str, ...]:
    """What a person should know of a map before opening it."""
    found = []
    if not scene.field.levels.any():
        found.append("every block is at level 0: there is nothing to see but frames and ground")
    models = _models(scene)
    if models > MANY_MODELS:
        found.append(
            f"{models:,} models: Gazebo Classic needs about {models * 1.5 / 1000:,.1f} GB and {models / 100:,.0f} s to "
            "load them, Gazebo Sim CPU at every step; mesh_type pallet or single costs a hundredth"
        )
    return tuple(found)


def _models(scene: Scene) -> int:
    chunks_x, chunks_y = scene.recipe.chunks
    counts = {"single": 1, "pallet": chunks_x * chunks_y, "multi": int((scene.field.heights > 0).sum())}
    return counts[scene.recipe.mesh_type]


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
        level_counts=scene.field.level_counts(),
        warnings=warnings(scene),
    )
