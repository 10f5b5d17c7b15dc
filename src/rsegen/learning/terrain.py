"""A terrain for a curriculum: many maps side by side in one field, harder from row to row, a kind in each column.

    recipes --build, at the difficulty of each row--> tiles --with flat ground around them--> StepField

Rows go along +x, from the easiest; columns along +y. A column has as many maps of its recipe as there are rows. As they
differ in roughness, more difficulty of a smoother map may be less than less of a rougher one, so the rougher maps of a
column are in its harder rows. That costs the metric of each map as designed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import gcd

import numpy as np

from rsegen.datasets.difficulty_tiles import (
    Span,
    amid,
    check_tile,
    eased,
    kind_of_column,
    mean_span,
    refuse_unlike,
    share_of,
    span_of,
    tile_levels,
    top_of_tile,
)
from rsegen.errors import ParameterError, TooLarge, inside
from rsegen.field.crossing import SIDE, CrossingModel
from rsegen.field.stepfield import Array, Ints, Levels, StepField, make_read_only, read_only_copies
from rsegen.learning.ground import Ground, friction_by_level
from rsegen.learning.terrain_design import TerrainDesign
from rsegen.measuring.catalogue import RMS, By, metric_by
from rsegen.obstacles.matrix import Matrix
from rsegen.params.sorts import MOST_LEVELS, NANOMETRE_DIGITS, Integer, ListOf, validate
from rsegen.recipe.building import build
from rsegen.recipe.recipe import Recipe, as_recipes
from rsegen.scene.contact import CONTACT, Contact

_ALIKE = ("unit_cm", "block_width_cm", "level_colours")
"""Parameters that must be the same in all recipes, as the whole terrain has one value of each."""

_FRICTIONS = ("friction", "level_friction")
"""Parameters that must be the same if the terrain is to be one map: a map has a friction for each level."""

_LARGEST_CHUNK = 1000
"""Largest `chunk_size` of a recipe, of which a terrain as one map is made."""

_MOST_CELLS = 2**27
"""Largest number of cells of a terrain: a mesh takes hundreds of bytes for each."""

SIZE, _COUNT = ListOf(SIDE, 2), Integer(1, 1000)
_ENVIRONMENTS = Integer(1, 10_000_000)


@read_only_copies
@dataclass(frozen=True, kw_only=True)
class Terrain(TerrainDesign):
    """Maps of one or several recipes as one field, harder from row to row.

    Frames become blocks of their height. The flat ground around tiles is at the highest `ground_level` of the recipes,
    and tiles of a lower one are raised to it. Each tile has the friction of its recipe. In difficulty 0 is flat, and 1
    as designed; the rows between the first and the last rise evenly.

    Parameters
    ----------
    recipes : Recipe or sequence of Recipe
        Its kinds, each in as many neighbouring columns as the others; all tiles are of the same size.
    by : str or callable, default 'steps.rms'
        What rises evenly from row to row, by its name in `rsegen metrics --csv` or a function StepField -> float. By
        `steps.rms` each tile has the row's share of its own; by another one a row has one value, from the mean of level
        tiles to the mean of full ones, as near as each tile comes to it.
    robot : Crosser, optional
        For metrics of a robot, such as `reach.west_east.cost`; a full tile is then the hardest that it crosses.
    progress : callable, optional
        Called for each tile that is made.

    Raises
    ------
    UserError
        If the recipes do not go together, or it is too large.
    """

    recipes: Recipe | Sequence[Recipe]
    by: By = RMS
    robot: CrossingModel | None = None
    progress: Callable[[], object] | None = None

    def __post_init__(self) -> None:
        validate(self)
        if not 0 < len(self._kinds) <= self.columns:
            raise ParameterError(
                "recipes", f"{len(self._kinds)} for {self.columns} columns; use at most one per column"
            )
        refuse_unlike(self._kinds, _ALIKE)
        first = self._kinds[0].cells
        for index, recipe in enumerate(self._kinds):
            with inside(f"recipes[{index}]"):
                if (tile := recipe.cells) != first:
                    sides = " and ".join(f"{n_x} x {n_y}" for n_x, n_y in (tile, first))
                    raise ParameterError("", f"tiles of {sides} cells with their frames; use recipes of one size")
                check_tile(recipe)
                # Tiles of lower ground are raised to the highest one: their blocks must still have a level.
                if (top := top_of_tile(recipe)) + self._raised(recipe) >= MOST_LEVELS:
                    raised = f"tiles are raised to {self._ground}, and blocks of {top}"
                    problem = f"{recipe.ground_level}: {raised} are then above the highest level, {MOST_LEVELS - 1}"
                    raise ParameterError("ground_level", f"{problem}; use one ground_level for all")
        metric_by(self.by, self.robot)
        n_x, n_y = self._shape
        if n_x * n_y > _MOST_CELLS:
            raise TooLarge(f"rows: a terrain of {n_x:,} x {n_y:,} cells is too large; use fewer or smaller tiles")

    @property
    def _kinds(self) -> tuple[Recipe, ...]:
        return as_recipes(self.recipes)

    @property
    def kinds(self) -> tuple[str, ...]:
        """The name of the recipe of each column."""
        return tuple(self._kinds[self._kind_of(column)].name for column in range(self.columns))

    @property
    def difficulties(self) -> Array:
        """The difficulty of each row, (rows,): how far it is from level (0) to as designed (1), by the metric."""
        easiest, hardest = self.difficulty
        return np.linspace(easiest, hardest, self.rows)

    @cached_property
    def maps(self) -> Ints:
        """The index of the map of each tile in its recipe, (rows, columns): a column has every `columns`-th map.

        They are in the order in which the metric of the whole map rises along the rows, if the difficulty does.
        """
        maps = np.arange(self.rows * self.columns).reshape(self.rows, self.columns)
        rising = np.sign(self.difficulty[1] - self.difficulty[0])
        # Rougher maps of a column go into its harder rows; of equally hard rows the order stays.
        for column in range(self.columns if rising and self.rows > 1 else 0):
            full = [self._fullness(self._kind_of(column), int(index)) for index in maps[:, column]]
            maps[:, column] = maps[np.argsort(rising * np.array(full), kind="stable"), column]
        make_read_only(maps)
        return maps

    @cached_property
    def levels(self) -> Levels:
        """The levels of the cells of each tile, frames counted: (rows, columns, n_x, n_y)."""
        n_x, n_y = self._kinds[0].cells
        levels = np.empty((self.rows, self.columns, n_x, n_y), dtype=np.int16)
        recipes: dict[tuple[int, float], Recipe] = {}  # one for all tiles of a kind and a difficulty
        for row, column in np.ndindex(self.rows, self.columns):
            key = self._kind_of(column), self._share(row, column)
            recipe = recipes[key] = recipes.get(key) or eased(self._kinds[key[0]], key[1])
            levels[row, column] = tile_levels(recipe, int(self.maps[row, column])) + np.int16(self._raised(recipe))
            if self.progress:
                self.progress()
        make_read_only(levels)
        return levels

    @cached_property
    def field(self) -> StepField:
        """The field of all tiles, whose middle is the origin."""
        first = self._kinds[0]
        levels = np.full(self._shape, self._ground, dtype=np.int16)
        for row, column in np.ndindex(self.rows, self.columns):
            levels[self._window(row, column)] = self.levels[row, column]
        return StepField(
            levels=levels,
            frame=np.zeros(levels.shape, dtype=bool),
            block_width=self._block_width,
            unit=first.unit_cm / 100,
            frame_height=first.frame_height_cm / 100,
        )

    @property
    def tile_size(self) -> tuple[float, float]:
        """Metres of a tile along x and y, frames counted."""
        n_x, n_y = self._kinds[0].cells
        width = self._block_width
        return round(n_x * width, NANOMETRE_DIGITS), round(n_y * width, NANOMETRE_DIGITS)

    @property
    def origins(self) -> Array:
        """The middle of each tile, (rows, columns, 3), metres; z is the highest of the cells that meet there."""
        x, y = (
            (np.arange(tiles) - (tiles - 1) / 2) * (cells + self.gap) * self._block_width
            for tiles, cells in zip((self.rows, self.columns), self._kinds[0].cells, strict=True)
        )
        middles = np.round(np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1), NANOMETRE_DIGITS)
        return np.concatenate([middles, amid(self.levels)[..., None] * (self._kinds[0].unit_cm / 100)], axis=2)

    def grid_origins(self, count: int) -> Array:
        """Return places for `count` environments in an even grid over all tiles, (count, 3), metres, along x first.

        z is the highest of the cells that meet there, as in `origins`: for policies that stay where they are.
        """
        count = _ENVIRONMENTS.check("count", count)
        field, extent = self.field, np.array(self.field.extent)
        along_x = max(1, min(count, round(float(np.sqrt(count * extent[0] / extent[1])))))
        shape = np.array([along_x, -(-count // along_x)])
        places = (np.stack(np.unravel_index(np.arange(count), shape), axis=1) + 0.5) / shape
        # A place on an edge is on two cells: one ends there, and one begins there.
        cells = np.round(places * field.shape, NANOMETRE_DIGITS)
        i, j = (np.stack([np.ceil(at) - 1, np.floor(at)]).astype(int) for at in cells.T)
        heights = field.heights[i[:, None], j[None, :]].max(axis=(0, 1))
        return np.column_stack([places * extent - extent / 2, heights])

    def spots(self, size: Sequence[float], count: int = 1, *, seed: int = 0) -> Array:
        """Return places on each tile to start, (rows, columns, count, 4): x, y, z [m] and yaw [rad], as `Ground.spots`.

        size: length and width of a rectangle along x and y, metres, with the most level ground of its tile below it; z:
        of the highest block there.
        """
        size, count = SIZE.check("size", size), _COUNT.check("count", count)
        recipe = replace(self._as_one, ground_level=self._ground)
        ground = Ground(recipe, self.levels.reshape(-1, *self.levels.shape[2:]))
        spots = np.array(ground.spots(size, count, seed=seed)).reshape(self.rows, self.columns, count, 4)
        spots[..., :2] += self.origins[:, :, None, :2]
        return spots

    @property
    def frictions(self) -> Array:
        """The friction coefficient of each cell of the field, (n_x, n_y): in a tile as its recipe has it for the level.

        The flat ground around tiles has the friction of the first recipe.
        """
        frictions = np.full(self._shape, self._kinds[0].friction)
        tables = [friction_by_level(recipe, int(self.levels.max())) for recipe in self._kinds]
        for row, column in np.ndindex(self.rows, self.columns):
            kind = self._kind_of(column)
            own = self.levels[row, column] - self._raised(self._kinds[kind])
            frictions[self._window(row, column)] = tables[kind][own]
        return frictions

    def ground(self, pos: Sequence[float] = (0, 0, 0), contact: Contact = CONTACT) -> Ground:
        """Return the ground of the whole terrain, its middle at `pos` in metres; each tile has its own friction.

        contact: of its blocks in MuJoCo.
        """
        return Ground.of_cells(self._kinds[0], self.field, self.frictions, pos, contact)

    @property
    def recipe(self) -> Recipe:
        """The recipe of the whole terrain as one map: all that rsegen does with a map it does with this one.

        ParameterError if its recipes have several frictions, or levels with frictions of their own in tiles that are
        raised, as a map has one for each level.
        """
        refuse_unlike(self._kinds, _FRICTIONS)
        for index, recipe in enumerate(self._kinds):
            if self._raised(recipe) and not recipe.is_of_one_friction:
                problem = f"is by levels, and its tiles are raised from level {recipe.ground_level} to {self._ground}"
                raise ParameterError(f"recipes[{index}].level_friction", f"{problem}; use one ground_level for all")
        return self._as_one

    @cached_property
    def _as_one(self) -> Recipe:
        first, (n_x, n_y) = self._kinds[0], self._shape
        # As few chunks as possible, which are squares.
        side = next(side for side in range(min(gcd(n_x, n_y), _LARGEST_CHUNK), 0, -1) if gcd(n_x, n_y) % side == 0)
        # The levels are final: whatever would change them, as difficulty or constraints, is switched off.
        return replace(
            first,
            name=self.name,
            description="",
            maps=1,
            first_map=0,
            chunk_size=side,
            chunks=(n_x // side, n_y // side),
            boundary="none",
            ground_level=0,
            difficulty=1.0,
            max_step=None,
            crossable_by=None,
            inventory=None,
            obstacles=(Matrix.of(self.field.levels, key="terrain"),),
        )

    @property
    def _block_width(self) -> float:
        """Side of a block, metres."""
        return self._kinds[0].block_width_cm / 100

    @property
    def _ground(self) -> int:
        """Level of the flat ground around the tiles, and of all tiles."""
        return max(recipe.ground_level for recipe in self._kinds)

    def _raised(self, recipe: Recipe) -> int:
        """Return by how many levels the tiles of a recipe are raised."""
        return self._ground - recipe.ground_level

    @property
    def _shape(self) -> tuple[int, int]:
        """Cells of the whole field."""
        n_x, n_y = self._kinds[0].cells
        along_x, along_y = (
            tiles * cells + (tiles - 1) * self.gap + 2 * self.border
            for tiles, cells in ((self.rows, n_x), (self.columns, n_y))
        )
        return along_x, along_y

    def _window(self, row: int, column: int) -> tuple[slice, slice]:
        """Return the cells of a tile in the field."""
        n_x, n_y = self._kinds[0].cells
        x, y = (self.border + tile * (cells + self.gap) for tile, cells in ((row, n_x), (column, n_y)))
        return slice(x, x + n_x), slice(y, y + n_y)

    def _share(self, row: int, column: int) -> float:
        """Return the share of its recipe's difficulty that a tile has."""
        difficulty = float(self.difficulties[row])
        if self.by == RMS:
            return difficulty
        kind, index, metric = self._kind_of(column), int(self.maps[row, column]), metric_by(self.by, self.robot)
        spans, mean = self._spans[kind]
        return share_of(self._kinds[kind], index, metric, spans[index], mean, difficulty)

    def _fullness(self, kind: int, index: int) -> float:
        """Return how far the metric of a map as designed is from its value on level ground; less for smoother maps."""
        if self.by == RMS:
            return metric_by(RMS)(build(self._kinds[kind], index))
        spans, mean = self._spans[kind]
        return (spans[index].full - mean.level) * (1 if mean.full > mean.level else -1)

    @cached_property
    def _spans(self) -> list[tuple[dict[int, Span], Span]]:
        """The metric's range on each map of each recipe by its index, and the mean range."""
        spans_of_kinds = []
        metric = metric_by(self.by, self.robot)
        for kind, recipe in enumerate(self._kinds):
            # Map i is in column i % columns, see `maps`; every kind measures its own maps alone.
            indices = (i for i in range(self.rows * self.columns) if self._kind_of(i % self.columns) == kind)
            spans = {index: span_of(recipe, index, metric) for index in indices}
            spans_of_kinds.append((spans, mean_span(list(spans.values()), metric.name)))
        return spans_of_kinds

    def _kind_of(self, column: int) -> int:
        return kind_of_column(column, self.columns, len(self._kinds))
