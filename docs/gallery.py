"""The page of the gallery, and pictures of maps side by side: softness, boundaries, mesh types, constraints."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from docs import catalogue
from rsegen import KINDS, Recipe, Scene, compose
from rsegen.field.stepfield import Ints
from rsegen.pictures.plan import ColouredField
from rsegen.pictures.preview import draw_view, figure_bytes, view_bounds
from rsegen.robots.base import ROBOTS
from rsegen.scene.colours import Colour

PICTURES = Path(__file__).parent / "pictures"
BOUNDARIES = PICTURES / "gallery-boundaries.png"
MESH_TYPES = PICTURES / "gallery-mesh-types.png"
CONSTRAINTS = PICTURES / "constraints.png"

_HEIGHT = 3.4
"""Inches of a view."""

_MESH_TYPES = {"single": 0, "pallet": 1, "multi": 2}
"""Parts into which a map falls apart: not, into its chunks, into its blocks."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Apart(ColouredField):
    """The models of a map moved apart, in the colours of the map."""

    scene: Scene

    @classmethod
    def of(cls, scene: Scene, mesh_type: str) -> Apart:
        """The models in cells of a third of a block, with empty ones between them."""
        field, gap = scene.field, _MESH_TYPES[mesh_type]
        along_x, along_y = (_apart(side, scene.recipe.chunk_size + 2, gap) for side in field.shape)
        empty = (along_x < 0)[:, None] | (along_y < 0)
        levels, frame = (each[np.ix_(along_x, along_y)] for each in (field.levels, field.frame))
        thirds = replace(
            field,
            levels=np.where(empty, np.int16(0), levels),
            frame=frame & ~empty,
            block_width=field.block_width / 3,
        )
        return cls(scene=scene, field=thirds)

    def plan_colour(self, material: int) -> Colour:
        """The colour of the map in plans."""
        return self.scene.plan_colour(material)

    view_colour = surface_colour = plan_colour


def pictures() -> dict[Path, Recipe]:
    """The recipe that each picture carries: that of its first view."""
    shown = {path: next(catalogue.softnesses(kind))[1] for kind, path in _softness().items()}
    _, divided, _ = catalogue.boundaries()
    shown |= {BOUNDARIES: next(catalogue.boundaries())[1], CONSTRAINTS: next(catalogue.constrained())[1]}
    return shown | {MESH_TYPES: divided[1]}


def picture(path: Path) -> bytes:
    """One of the pictures."""
    if path == MESH_TYPES:
        scene = compose(pictures()[path])
        return _beside([(name, Apart.of(scene, name)) for name in _MESH_TYPES], scene)
    by_path: dict[Path, Callable[[], Iterator[tuple[str, Recipe]]]] = {
        BOUNDARIES: catalogue.boundaries,
        CONSTRAINTS: catalogue.constrained,
        **{path: partial(catalogue.softnesses, kind) for kind, path in _softness().items()},
    }
    scenes = [(title, compose(recipe)) for title, recipe in by_path[path]()]
    return _beside(scenes, scenes[0][1])


def page() -> Iterator[str]:
    """The page, in parts."""
    yield _ALL
    yield from _kinds_and_robots()
    yield _SOFTNESS
    for kind, path in _softness().items():
        yield f"\n### `{kind}`\n\n![{kind} with softness 0, 50 and 100](pictures/{path.name})"
    yield f"{_BOUNDARIES}\n![Four chunks without frames, with divided and with outer ones](pictures/{BOUNDARIES.name})"
    yield f"{_MODELS}\n![One model, four models and a model for each block](pictures/{MESH_TYPES.name})"


def _kinds_and_robots() -> Iterator[str]:
    """Yield a table of small pictures: every kind of obstacle, then every robot, four in a row."""
    shown = {kind: f"`{kind}`" for kind in KINDS}
    shown |= {kind: f"`{kind}`, {robot.title}" for kind, robot in ROBOTS.items()}
    cells = [
        f'<img src="pictures/small-{name}.webp" width="180" alt="{name}"><br>{text}' for name, text in shown.items()
    ]
    yield "| " * _ACROSS + "|\n" + "|---" * _ACROSS + "|"
    for first in range(0, len(cells), _ACROSS):
        row = cells[first : first + _ACROSS]
        yield "| " + " | ".join([*row, *[""] * (_ACROSS - len(row))]) + " |"


_ACROSS = 4

_ALL = """# Gallery

Made by `make docs`. The kinds with all their parameters are on the page of [obstacles](obstacles.md), the robots on
that of [robots](robots.md).

## Obstacles and robots
"""

_SOFTNESS = """
## Softness

`softness` is the width of the slopes as a share of the chunk: 0 gives vertical walls, 100 slopes as wide as a chunk;
those of a peak end at the edge of its base. It reduces all heights and depths of the other kinds: at 100 the
map is flat. Maps of 20 x 20 blocks in levels of 5 cm:"""

_BOUNDARIES = """
## Boundaries

`boundary` sets where frames are: nowhere (`none`), around every chunk (`divided`, the default), or around the map
(`outer`). The blocks are the same.
"""

_MODELS = """
## Mesh types

`mesh_type` sets what is a separate model, which can be moved in a simulator: the whole map (`single`, the default),
every chunk with its frame (`pallet`), or every block (`multi`). Here they are moved apart.
[Which is for what](gazebo.md#mesh-types).
"""


def _softness() -> dict[str, Path]:
    """The picture of each kind that softness changes."""
    return {kind: PICTURES / f"softness-{kind}.png" for kind in KINDS}


def _beside(shown: Sequence[tuple[str, Scene | Apart]], carried: Scene) -> bytes:
    """Views side by side, at one scale, as the bytes of a PNG file."""
    from matplotlib.figure import Figure

    sizes = [np.ptp(view_bounds(each), axis=0) for _, each in shown]
    scale = _HEIGHT / max(high for _, high in sizes)
    width = max(wide for wide, _ in sizes) * scale
    figure = Figure(figsize=(len(shown) * (width + 0.2), _HEIGHT + 0.5), dpi=80)
    for number, (title, drawn) in enumerate(shown):
        axes = figure.add_axes((number / len(shown), 0.02, 1 / len(shown) - 0.01, _HEIGHT / (_HEIGHT + 0.5)))
        draw_view(axes, drawn)
        axes.set_anchor("S")
        across, up = np.array([width, _HEIGHT]) / scale / 2
        (left, low), (right, _) = view_bounds(drawn)
        axes.set(xlim=((left + right) / 2 - across, (left + right) / 2 + across), ylim=(low, low + 2 * up))
        figure.text((number + 0.5) / len(shown), 0.99, title, ha="center", va="top", fontsize=13)
    return figure_bytes(figure, carried, "png")


def _apart(cells: int, chunk: int, gap: int) -> Ints:
    """For each third of a block along an axis the cell that it is of; -1 between models."""
    found: list[int] = []
    for cell in range(cells):
        if cell and (gap == 2 or (gap == 1 and cell % chunk == 0)):
            found += [-1] * (4 if cell % chunk == 0 and gap == 1 else 1)
        found += [cell] * 3
    return np.array(found)
