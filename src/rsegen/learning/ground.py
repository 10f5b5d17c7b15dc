"""The ground under robots that learn: heights, friction, scans, and places to start.

    levels = rsegen.build_many(recipe, range(4096))  # or a torch tensor of them, on any device
    ground = rsegen.Ground(recipe, levels)
    ground.heights(feet)                             # (4096, 4, 3) -> (4096, 4), metres

Idea: a point divided by the block width is its cell; one that is on an edge gets the higher block, as everywhere in
rsegen. A square around a point is looked at in places less than a block apart, so no cell under it is missed. Levels
and results stay arrays of the library that the levels came from (numpy, torch or jax), on their device. Arrays of Warp
are viewed without a copy: as numpy's on the CPU, as torch's on a GPU. No question about heights and friction asks the
device for a number, so none waits for it, and all can be compiled (`jax.jit`, `jax.vmap`, `torch.compile`). Levels and
indices of worlds are checked where that costs no waiting: levels of torch when a Ground is made, and all of numpy.

Cost: four look-ups per point, and as many more as blocks are under a square. What breaks it: a ground that overhangs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import ceil, floor, inf, isfinite
from typing import Any

import numpy as np

from rsegen.errors import ParameterError, TooLarge, refuse_other, shown
from rsegen.field.stepfield import Array, Ints, StepField
from rsegen.learning.arrays import (
    array_like,
    as_type,
    can_be_asked,
    class_of,
    extremes,
    is_real,
    is_whole,
    library_of,
    with_values,
)
from rsegen.learning.patterns import check_pattern, sides_of
from rsegen.params.sorts import Integer, as_int
from rsegen.recipe.recipe import Recipe
from rsegen.scene.contact import CONTACT, Contact
from rsegen.scene.scene import Scene

_EDGE = 1e-5
"""Metres from an edge up to which a point is on both blocks: single precision has steps of 1e-6 m at 10 m."""

_SINGLE = 4
"""Bytes of a number of single precision."""

_PLANE = 5
"""Places along each side of a square, through whose heights the plane of a normal is laid."""

_HOLE = 1e4
"""Units by which a place in a hole counts as more uneven than any other one."""

_COUNT = Integer(1)


def position_of(pos: Sequence[float] | Array) -> Array:
    """Return a position in the world as an array, (3,), metres; ParameterError if it is none."""
    try:
        own = np.array(pos, dtype=float)
    except (TypeError, ValueError):
        own = np.empty(0)
    if own.shape != (3,) or not all(map(isfinite, own.tolist())):
        raise ParameterError("pos", f"{shown(pos)} is not x, y and z in metres")
    return own


def friction_by_level(recipe: Recipe, highest: int | None = None) -> Array:
    """Return the friction coefficient of each level from 0 to the highest, by default of a recipe; 0 is the ground."""
    scene = Scene(recipe=recipe, index=0, field=unframed(np.zeros((1, 1), dtype=np.int16), 1.0, 1.0))
    levels = range(1, (recipe.highest_level if highest is None else highest) + 1)
    return np.array([recipe.friction, *map(scene.friction_of, levels)])


def check_levels(levels: Any, highest: int) -> None:
    """Raise a ParameterError if any of the levels, of which there is one at least, is not one of a recipe's."""
    low, high = int(levels.min()), int(levels.max())
    if not 0 <= low <= high <= highest:
        raise ParameterError("levels", f"{low}..{high} are not all in 0..{highest}, the levels of the recipe")


class Ground:
    """The ground of one map, or of many worlds with a map each, in the frame of the world.

    Points are (..., 2) or (..., 3), metres, with as many axes in front as one likes; z is not looked at. Of many worlds
    the first axis is the world, and `worlds` are the indices of the worlds that it goes along; without them, all.

    Parameters
    ----------
    recipe : Recipe
        Block width, unit and friction of the maps.
    levels : array of int, shape (n_x, n_y) or (worlds, n_x, n_y)
        Level of each block, in an array of numpy, torch or jax.
    pos : sequence of float, default (0, 0, 0)
        Where the middle of the map is, metres.
    outside : int, default 0
        Level of the ground around the map.
    contact : Contact, optional
        Contact of the blocks in MuJoCo, which decides whose friction acts; default: as BlockGrid has it.
    """

    def __init__(
        self,
        recipe: Recipe,
        levels: Any,
        pos: Sequence[float] | Array = (0, 0, 0),
        outside: int = 0,
        contact: Contact = CONTACT,
    ) -> None:
        refuse_other("recipe", recipe, Recipe)
        if recipe.boundary != "none":
            raise ParameterError("boundary", f"'{recipe.boundary}' has frames; use none, or Ground.of(scene)")
        self.block_width: float = recipe.block_width_cm / 100
        self.unit: float = recipe.unit_cm / 100
        self._floor: float = recipe.ground_level * self.unit
        self.position: Array = position_of(pos)
        self.contact: Contact = contact
        self._middle: tuple[float, float, float] = tuple(self.position.tolist())
        self.library: Any
        self.library, given = library_of("levels", levels)
        self._array: type = class_of(self.library)
        if given.ndim not in (2, 3):
            raise ParameterError("levels", f"of shape {tuple(given.shape)}; expected (n_x, n_y) or (worlds, n_x, n_y)")
        if as_int(outside) is None or not 0 <= outside <= recipe.highest_level:
            raise ParameterError("outside", f"level {shown(outside)} is outside 0..{recipe.highest_level}")
        # A row of the ground around is kept on each side, so that every point has a cell.
        *many, n_x, n_y = given.shape
        try:
            around = array_like(given, np.full((*many, n_x + 2, n_y + 2), outside, dtype=np.int16))
        except MemoryError:
            worlds = f"{many[0] if many else 1} maps of {n_x} x {n_y} blocks"
            raise TooLarge(f"levels: {worlds} are more than this machine's memory; use fewer") from None
        self._keep_tables(np.arange(recipe.highest_level + 1) * self.unit, friction_by_level(recipe), like=given)
        levels = as_type(self._checked(given, is_new=True), around.dtype)
        self._cells = with_values(around, (..., slice(1, -1), slice(1, -1)), levels)
        self._all_worlds = array_like(given, np.arange(many[0] if many else 0))
        self._fixed: StepField | None = None  # of a ground that cannot be written, as its materials are no levels

    @classmethod
    def of(cls, scene: Scene, pos: Sequence[float] = (0, 0, 0), contact: Contact = CONTACT) -> Ground:
        """Return the ground of a scene of `rsegen.compose`, whose map may have frames; it cannot be written."""
        refuse_other("scene", scene, Scene)
        field, recipe = scene.field, scene.recipe
        # A frame is one more material. Materials are sorted by height, so the higher of two cells has the higher index.
        levels = range(recipe.highest_level + 1)
        heights = np.array([*(level * field.unit for level in levels), field.frame_height])
        friction = np.append(friction_by_level(recipe), scene.friction_of(0))
        order = np.argsort(heights, kind="stable")
        material = np.where(field.frame, len(levels), field.levels)
        levels_alone = replace(recipe, boundary="none")
        ground = cls(levels_alone, np.zeros(field.shape, dtype=np.int16), pos, contact=contact)
        ground._keep_tables(heights[order], friction[order], like=ground._cells)
        ground._cells[1:-1, 1:-1] = np.argsort(order)[material]  # the inverse of the order: where each one is now
        ground._fixed = field
        return ground

    @classmethod
    def of_cells(
        cls,
        recipe: Recipe,
        field: StepField,
        friction: Array,
        pos: Sequence[float] = (0, 0, 0),
        contact: Contact = CONTACT,
    ) -> Ground:
        """Return the ground of a field without frames and with a friction per cell; it cannot be written.

        friction: (n_x, n_y); recipe: its friction is also the one of the ground around the field.
        """
        levels_alone = replace(recipe, boundary="none")
        ground = cls(levels_alone, np.zeros(field.shape, dtype=np.int16), pos, contact=contact)
        # Materials are pairs of a level and a friction, sorted by level: the higher of two cells has the higher index.
        pairs = np.column_stack([np.append(0, field.levels), np.append(recipe.friction, friction)])
        known, material = np.unique(pairs, axis=0, return_inverse=True)
        ground._keep_tables(known[:, 0] * field.unit, known[:, 1], like=ground._cells)
        ground._cells[:] = material.flat[0]
        ground._cells[1:-1, 1:-1] = material.reshape(-1)[1:].reshape(field.shape)
        ground._fixed = field
        return ground

    def __getstate__(self) -> dict[str, Any]:
        """Return what a copy in another process needs: its library is found by its arrays, as no module is copied."""
        return {name: value for name, value in self.__dict__.items() if name not in ("library", "_array")}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self.library, _ = library_of("levels", self._cells)
        self._array = class_of(self.library)

    @property
    def levels(self) -> Any:
        """The levels of the blocks, as they are now: (n_x, n_y), or (worlds, n_x, n_y)."""
        return self._inner if self._fixed is None else self._fixed.levels

    @property
    def worlds(self) -> int | None:
        """Number of worlds; None for one map."""
        return self._cells.shape[0] if self._cells.ndim == 3 else None

    def write(self, levels: Any, worlds: Any = None) -> None:
        """Put maps into these worlds, (worlds, n_x, n_y), or into all: at a reset, as in BlocksOfWorlds."""
        _, given = self._library_of("levels", levels)
        if self._fixed is not None:
            raise ParameterError("levels", "the ground is that of one field; make a Ground from a recipe")
        rows = None if worlds is None else self._rows(worlds)
        shape = tuple(self.levels.shape) if rows is None else (len(rows), *self.levels.shape[1:])
        if tuple(given.shape) != shape:
            raise ParameterError("levels", f"of shape {tuple(given.shape)}; expected {shape}")
        place = (... if rows is None else rows, slice(1, -1), slice(1, -1))
        self._cells = with_values(self._cells, place, self._here(self._checked(given), self._cells.dtype))

    def heights(self, points: Any, worlds: Any = None) -> Any:
        """Return the height of the ground at points, (...,), metres."""
        return self.highest(points, 0.0, worlds)

    def friction(self, points: Any, worlds: Any = None) -> Any:
        """Return the coefficient of sliding friction of the ground at points, (...,)."""
        points = self.own("points", points)
        return self._values(self._friction, self._materials(points, 0.0, worlds), like=points)

    def acting_friction(self, points: Any, own: Any, priority: int = 0, worlds: Any = None) -> Any:
        """Return the coefficient that acts in MuJoCo between the ground and what is on it at points, (...,).

        own: the coefficient of what is on it, a number or (...,); priority: of its geoms. The higher priority
        decides; of equal ones MuJoCo takes the larger coefficient. Where blocks decide with a `condim` of 1, none acts.
        """
        ground = self.friction(points, worlds)
        if priority < self.contact.priority and self.contact.condim == 1:
            return ground * 0
        # A number too becomes an array of the shape of the ground's, on its device.
        of_robot = ground * 0 + (own if isinstance(own, int | float) else self._here(own, ground.dtype))
        if priority == self.contact.priority:
            return self.library.maximum(ground, of_robot)
        return of_robot if priority > self.contact.priority else ground

    def highest(self, points: Any, radius: float | Array, worlds: Any = None) -> Any:
        """Return the height of the highest block in squares around points, (...,), metres.

        radius: half of their side along x and y, metres; or, in numpy, (..., 2) of rectangles.
        """
        points = self.own("points", points)
        return self._values(self._heights, self._materials(points, radius, worlds), like=points) + self._middle[2]

    def normals(self, points: Any, radius: float, worlds: Any = None) -> Any:
        """Return unit normals, (..., 3), of the planes through the ground in squares around points.

        Tops are level, so the normal of the ground at a point says nothing. This is the plane of least squares through
        5 x 5 heights up to `radius` metres along x and y: the slope of the ground under a foot or a robot.
        """
        if not 0 < radius < inf:
            raise ParameterError("radius", f"{shown(radius)} m; use one above 0, as tops are level")
        points, library = self.own("points", points), self.library
        # On a symmetric grid the slope of least squares is sum(step * height) / sum(step ** 2), along each axis alone:
        # along x over the rows of `heights`, along y over its columns.
        steps = [radius * (2 * place / (_PLANE - 1) - 1) for place in range(_PLANE)]
        x, y = points[..., 0], points[..., 1]
        heights = [[self.heights(library.stack([x + dx, y + dy], -1), worlds) for dy in steps] for dx in steps]
        squares = _PLANE * sum(step**2 for step in steps)
        slopes = [
            sum(step * sum(row) for step, row in zip(steps, rows, strict=True)) / squares
            for rows in (heights, list(zip(*heights, strict=True)))
        ]
        length = (slopes[0] ** 2 + slopes[1] ** 2 + 1) ** 0.5
        return library.stack([-slopes[0] / length, -slopes[1] / length, 1 / length], -1)

    def scan(self, pattern: Any, poses: Any, worlds: Any = None) -> Any:
        """Return heights of the ground around robots, (..., points), from each robot's z: an observation.

        pattern: (points, 2), x and y in the robot's frame, such as `scan_points()`; poses: (..., 4), x, y, z [m], yaw.
        """
        poses = self.own("poses", poses, 4)
        if poses.shape[-1] != 4:
            raise ParameterError(
                "poses", f"of shape {tuple(poses.shape)}; expected (..., 4), of which the last is the yaw"
            )
        pattern = as_type(self.own("pattern", pattern), poses.dtype)
        check_pattern(pattern)
        # The pattern, x forward and y to the left, turned by the yaw and moved into the world.
        cosine, sine = self.library.cos(poses[..., 3:]), self.library.sin(poses[..., 3:])
        x = poses[..., :1] + cosine * pattern[:, 0] - sine * pattern[:, 1]
        y = poses[..., 1:2] + sine * pattern[:, 0] + cosine * pattern[:, 1]
        return self.heights(self.library.stack([x, y], -1), worlds) - poses[..., 2:3]

    def lift(self, points: Any, radius: float | Array = 0.0, worlds: Any = None) -> Any:
        """Return how far each robot has to be raised so that none of its points is in the ground, (...,), metres.

        points: (..., points, 3), its feet, or the lowest points of its shapes; radius: half of their width, metres.
        Negative for a robot above the ground, which has to be lowered so far to stand on it.
        """
        points = self.own("points", points, 3)
        if points.ndim < 2 or not points.shape[-2]:
            raise ParameterError("points", f"of shape {tuple(points.shape)}; expected (..., points, 3), one at least")
        return self.library.amax(self.highest(points, radius, worlds) - points[..., 2], -1)

    def spots(self, size: Sequence[float] | Array, count: int = 1, *, seed: int = 0) -> Any:
        """Return places for a robot to start, (count, 4) or (worlds, count, 4): x, y, z [m], yaw.

        size: length and width of a rectangle along x and y, metres, that has the most level ground below it; of equally
        level places random ones, which may overlap; holes come last. z: of the highest block below; yaw: of a square
        one of four.
        """
        size, count = sides_of(size), _COUNT.check("count", count)
        wide = [max(ceil(side / self.block_width - _EDGE), 1) for side in size]
        n_x, n_y = self._inner.shape[-2:]
        if wide[0] > n_x or wide[1] > n_y:
            raise ParameterError("size", f"{size[0]:g} x {size[1]:g} m is larger than the map of {n_x} x {n_y} blocks")
        # A place is the cell of smallest x and y of a rectangle of `wide` cells.
        low, high = extremes(self._index(self._inner), wide)
        *many, along_x, along_y = low.shape
        places = along_x * along_y
        if count > places:
            raise ParameterError("count", f"{count} is outside 1..{places}, the number of places on a map")
        rng, library = np.random.default_rng(seed), self.library
        # Ties are broken by a random number below 1, a unit: the least difference of two levels that differ.
        chance = array_like(low, rng.random((*many, along_x, along_y), dtype=np.float32))
        bottoms, tops = (self._values(self._heights, own, like=chance) for own in (low, high))
        uneven = (tops - bottoms) / self.unit + chance + _HOLE * (bottoms < self._floor - _EDGE)
        best = library.argsort(uneven.reshape((*many, places)), -1)[..., :count]
        rows = (self._all_worlds[:, None],) if many else ()
        z = tops.reshape((*many, places))[(*rows, best)]
        i, j = best // along_y, best % along_y
        x, y = (
            (at + (cells - side) / 2) * self.block_width + float(middle)
            for at, cells, side, middle in zip((i, j), wide, (n_x, n_y), self.position[:2], strict=True)
        )
        # A square may head along each of four directions, any other rectangle along two.
        turn = np.pi / 2 if wide[0] == wide[1] else np.pi
        turns = rng.integers(round(2 * np.pi / turn), size=(*many, count))
        yaw = array_like(low, turns * turn, chance.dtype)
        return library.stack([x, y, z + float(self.position[2]), yaw], -1)

    def field(self, world: int = 0) -> StepField:
        """Return the map of a world as a field, about its own middle: for `rsegen.poses`, `metrics` and `mesh`."""
        if self._fixed is not None:
            return self._fixed
        levels = self.levels
        if self.worlds is not None:
            levels = levels[Integer(0, self.worlds - 1).check("world", world)]
        own = levels.cpu().numpy() if hasattr(levels, "cpu") else np.asarray(levels)
        return unframed(own, self.block_width, self.unit)

    @property
    def _inner(self) -> Any:
        """The materials of the cells of the map, without those around it."""
        return self._cells[..., 1:-1, 1:-1]

    def _materials(self, points: Any, radius: float | Array, worlds: Any) -> Any:
        """Return the material of the highest block in squares around points: an index into the tables."""
        # Materials are sorted by height, so the highest block has the largest one. The cells are one line of numbers:
        # the cell (i, j) of a world is at (world * n_x + i) * n_y + j.
        cells, n_y = self._cells.reshape(-1), self._cells.shape[-1]
        before, highest = self._before(points, worlds), None
        rows, columns = (self._indices(points[..., axis], own, axis) for axis, own in enumerate(self._places(radius)))
        for row in rows:
            first = row * n_y + before
            for column in columns:
                own = cells[first + column]
                highest = own if highest is None else self.library.maximum(highest, own)
        return highest

    def _places(self, radius: float | Array) -> tuple[Sequence[float | Array], Sequence[float | Array]]:
        """Return the places along x and y at which a square is looked at, from its middle, in blocks."""
        # They are less than a block apart: a whole block between two of them would be missed.
        if isinstance(radius, int | float):
            _check_radius(radius, radius)
            reach = (radius + _EDGE) / self.block_width
            last = floor(2 * reach) + 1
            places = [reach * (2 * place / last - 1) for place in range(last + 1)]
            return places, places
        radii = np.asarray(radius, dtype=float)
        if radii.ndim and radii.shape[-1] != 2:
            raise ParameterError("radius", f"of shape {radii.shape}; expected a number, or (..., 2) along x and y")
        _check_radius(radii.min(initial=0.0), radii.max(initial=0.0))
        reaches = (radii + _EDGE) / self.block_width
        shares = np.linspace(-1, 1, floor(2 * float(reaches.max(initial=0.0))) + 2)
        x, y = (reaches, reaches) if reaches.ndim == 0 else (reaches[..., 0], reaches[..., 1])
        return [share * x for share in shares], [share * y for share in shares]

    def _indices(self, coordinates: Any, places: Sequence[float | Array], axis: int) -> list[Any]:
        """Return the indices of cells along an axis, at each place of a square; what is no number is outside."""
        library, last = self.library, self._cells.shape[axis - 2] - 1
        # In blocks from the corner of the row around the map, which is half of all its cells from the middle.
        middle = coordinates / self.block_width + ((last + 1) / 2 - self._middle[axis] / self.block_width)
        indices = []
        for place in places:
            cell = middle + (place if isinstance(place, float) else self._here(place, coordinates.dtype))
            if library is np:  # which warns of what is no number
                cell = np.nan_to_num(np.clip(cell, 0, last))
            indices.append(library.clip(self._index(cell), 0, last))
        return indices

    def _before(self, points: Any, worlds: Any) -> Any:
        """Return how many cells are before the worlds along the first axis of points: 0 for one map."""
        if self.worlds is None and worlds is None:
            return 0
        rows = self._rows(worlds)
        if points.ndim < 2 or points.shape[0] != len(rows):
            problem = f"of shape {tuple(points.shape)} for {len(rows)} worlds"
            raise ParameterError("points", f"{problem}; expected ({len(rows)}, ..., {points.shape[-1]})")
        return self._index(rows.reshape((-1, *[1] * (points.ndim - 2)))) * (
            self._cells.shape[-2] * self._cells.shape[-1]
        )

    def _rows(self, worlds: Any) -> Any:
        """Return indices of worlds as an array, by default of all; ParameterError if any is not there."""
        if self.worlds is None:
            raise ParameterError("worlds", f"{shown(worlds)}, and the ground is of one map; leave it out")
        if worlds is None:
            return self._all_worlds
        library, rows = self._library_of("worlds", worlds)
        if rows.ndim != 1 or (len(rows) and not is_whole(rows)):
            raise ParameterError("worlds", f"{shown(worlds)} is not a list of indices of worlds")
        if library is np and len(rows) and not 0 <= rows.min() <= rows.max() < self.worlds:
            raise ParameterError("worlds", f"{rows.min()}..{rows.max()} are not all in 0..{self.worlds - 1}")
        return self._index(self._here(rows))  # bytes are a mask for torch, and an empty list is one of floats

    def _library_of(self, where: str, given: Any) -> tuple[Any, Any]:
        """Return the library of an array, and the array; arrays of the class of the levels need no look-up."""
        return (self.library, given) if isinstance(given, self._array) else library_of(where, given)

    def _here(self, array: Any, dtype: Any = None) -> Any:
        """Return an array on the device of the levels, in a type of their library; an array of it stays where it is."""
        if not isinstance(array, self._array):
            return array_like(self._cells, array, dtype)
        return array if dtype is None else as_type(array, dtype)

    def own(self, where: str, given: Any, least: int = 2) -> Any:
        """Return an array as real numbers in the library of the levels, on their device.

        Integers become real numbers, and half precision becomes single: at 10 m its steps are 8 mm. ParameterError,
        which names `where`, if its last axis has fewer than `least` numbers.
        """
        library, array = self._library_of(where, given)
        if library is not self.library:
            if library is not np:
                own, theirs = self.library.__name__, library.__name__
                raise ParameterError(where, f"an array of {theirs}, and the levels are one of {own}; use that")
            array = array_like(self._cells, array, self.library.float32)
        elif not is_real(array) or array.dtype.itemsize < _SINGLE:
            array = as_type(array, self._heights.dtype)
        if array.ndim < 1 or array.shape[-1] < least:
            raise ParameterError(where, f"of shape {tuple(array.shape)}; expected (..., {least})")
        return array

    def _checked(self, levels: Any, *, is_new: bool = False) -> Any:
        """Return levels; ParameterError if they are no integers, or, if their values are known, none of the recipe.

        Levels on a device, or being traced, are clipped to the levels of the recipe: a check would wait for them.
        """
        if not is_whole(levels):
            raise ParameterError("levels", f"of {levels.dtype}; expected integers, in units")
        most = len(self._heights) - 1
        if isinstance(levels, np.ndarray) or (is_new and can_be_asked(levels)):
            if min(levels.shape):
                check_levels(levels, most)
            return levels
        return self.library.clip(levels, 0, most)

    def _index(self, values: Any) -> Any:
        """Return numbers as indices, in the type that the library looks up fastest; jax has no other."""
        return as_type(values, self.library.int64 if hasattr(self._cells, "dim") else self.library.int32)

    def _keep_tables(self, heights: Any, friction: Any, like: Any) -> None:
        """Keep the height and the friction of each material on the device of the levels."""
        dtype = None if self.library is np else self.library.float32
        self._heights, self._friction = (array_like(like, table, dtype) for table in (heights, friction))

    def _values(self, table: Any, materials: Any, like: Any) -> Any:
        """Return the values of materials in a table, in the type of an array of numbers."""
        values = table[self._index(materials)]
        return as_type(values, like.dtype) if is_real(like) else values


def _check_radius(low: float, high: float) -> None:
    if not 0 <= low <= high < inf:
        raise ParameterError("radius", f"{(low if isfinite(high) else high):g} m; use 0 or more")


def unframed(levels: Ints, block_width: float, unit: float) -> StepField:
    """Return levels as a field without frames; block_width, unit: metres."""
    frame = np.zeros(levels.shape, dtype=bool)
    return StepField(levels=levels.astype(np.int16), frame=frame, block_width=block_width, unit=unit, frame_height=0.0)
