"""The design of a map: its size, obstacles, difficulty, constraints and seed. Nothing else decides a level of a block.

Every map and obstacle has a random stream of its own, named by (seed, index of the map, key of the obstacle). So maps
do not depend on each other, nor obstacles on the order of the rows.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Sequence, Set
from copy import copy
from dataclasses import dataclass, field, replace
from itertools import count
from typing import TYPE_CHECKING, Annotated, Any

from rsegen.errors import ParameterError, inside, shown
from rsegen.field.crossing import CrossingModel, StepLimits, robot_that_crosses
from rsegen.params.sorts import MOST_LEVELS, Choice, Float, Integer, Json, ListOf, Size2D, list_parts, validate
from rsegen.params.streams import SEEDS, Streams, fresh_seed, generator

if TYPE_CHECKING:
    from rsegen.obstacles import Grid, Obstacle

Difficulty = float | Sequence[float]
"""Number for all maps; (least, most), drawn for each map; or (least, most, steps), rising from map to map."""

_SHARE, _STEPS = Float(0, 1), Integer(2, 1_000_000)

_KEY = "drawn difficulty"
"""Name of the random stream of drawn difficulties; no key of an obstacle has blanks."""


@dataclass(frozen=True)
class DifficultySort:
    """A difficulty: `0.5`, `[0, 1]` or `[0, 1, 10]`."""

    help: str = ""

    def check(self, where: str, value: object) -> Difficulty:
        if not isinstance(value, (list, tuple)):
            return _SHARE.check(where, value)
        if len(value) not in (2, 3):
            raise ParameterError(where, f"{shown(value)} is not {self.describe()}")
        low, high = (_SHARE.check(f"{where}[{index}]", share) for index, share in enumerate(value[:2]))
        if low > high:
            raise ParameterError(where, f"{shown(value)} begins above its end; write the smaller number first")
        return (low, high) if len(value) == 2 else (low, high, _STEPS.check(f"{where}[2]", value[2]))

    def parse(self, text: str) -> object:
        parts = list_parts(text)
        if len(parts) == 1:
            return _SHARE.parse(text)
        return [_SHARE.parse(part) for part in parts[:2]] + [_STEPS.parse(part) for part in parts[2:]]

    def format(self, value: Any) -> str:
        return ",".join(map(_SHARE.format, value)) if isinstance(value, (list, tuple)) else _SHARE.format(value)

    def schema(self) -> dict[str, Json]:
        share, steps = _SHARE.schema(), _STEPS.schema()
        pair = {"title": "drawn from a range", "type": "array", "items": share, "minItems": 2, "maxItems": 2}
        rising = {"type": "array", "prefixItems": [share, share, steps], "minItems": 3, "maxItems": 3}
        return {"anyOf": [{"title": "fixed", **share}, pair, {"title": "rising in steps", **rising}]}

    def describe(self) -> str:
        return "a number from 0 to 1, or a range as in [0.2, 1] or, in 10 steps, [0.2, 1, 10]"


def asked_certainty(asked: str) -> tuple[str, str] | None:
    """Return the robot and the certainty of a text such as `crawler:0.9`; None of one without, as `/a:b/FILE A:=1`."""
    robot, colon, share = asked.rpartition(":")
    return (robot, share) if colon and not share.startswith("=") and "/" not in share else None


@dataclass(frozen=True)
class CrossableBySort:
    """A kind of robot that crosses every map, or the climb, drop and width [cm] of a path of cells."""

    help: str = ""

    def check(self, where: str, value: object) -> str | tuple[float, ...]:
        if isinstance(value, str):
            if asked_certainty(value):  # a recipe has what came out of it
                problem = f"{shown(value)} asks for a certainty, which files, flags and rsegen.with_certainty answer"
                raise ParameterError(where, problem)
            robot_that_crosses(value, where, kind_only=True)
            return value
        return _FIGURES.check(where, value)

    def parse(self, text: str) -> object:
        return _FIGURES.parse(text) if text.lstrip("[ ")[:1].isdecimal() or not text else text

    def format(self, value: Any) -> str:
        return value if isinstance(value, str) else _FIGURES.format(value)

    def schema(self) -> dict[str, Json]:
        limits = {"title": "climb, drop and width", **_FIGURES.schema()}
        return {"anyOf": [{"title": "a robot", "type": "string"}, limits]}

    def describe(self) -> str:
        return f"a kind of robot, as in burger, or {_FIGURES.describe()}"


_FIGURES = ListOf(Float(0, 100_000, unit="cm"), 3)

_CENTIMETRES = Float(0.001, 100_000, unit="cm")


@dataclass(frozen=True, kw_only=True)
class MapDesign:
    """Parameters that decide the levels of the blocks of every map, in the words of the recipe file."""

    chunk_size: Annotated[
        int, Integer(1, 1000, unit="blocks", usual=(4, 40), help="blocks along one side of a chunk (pallet)")
    ] = 10
    chunks: Annotated[Sequence[int], Size2D(help="map size in chunks: N for a square, or NxM")] = (1, 1)
    unit_cm: Annotated[
        float, replace(_CENTIMETRES, help="unit of height; each block is a whole number of units high")
    ] = 10.0
    block_width_cm: Annotated[float, replace(_CENTIMETRES, help="width of a block, and of a frame")] = 10.0
    boundary: Annotated[
        str, Choice(("none", "divided", "outer"), help="frames: none, around every chunk, or one around the map")
    ] = "divided"
    frame_height_cm: Annotated[float, Float(0, 100_000, unit="cm", help="height of the frames")] = 10.0
    ground_level: Annotated[
        int,
        Integer(
            0,
            MOST_LEVELS - 1,
            unit="units",
            usual=(0, 10),
            help="level of the blocks that no obstacle covers; obstacles stand on it, and pits reach down from it",
        ),
    ] = 0
    difficulty: Annotated[
        Difficulty,
        DifficultySort(
            help="how rough the map is: 1 as designed, 0 flat; a value is drawn for each map from a range; with a "
            "third number it rises in that many steps from map to map, then starts over"
        ),
    ] = 1.0
    max_step: Annotated[
        int | None,
        Integer(
            1,
            32767,
            unit="units",
            usual=(1, 10),
            help="largest height difference between neighbouring blocks; steeper slopes are flattened",
        ),
    ] = None
    crossable_by: Annotated[
        str | Sequence[float] | None,
        CrossableBySort(
            help="lower blocks for a way from west to east and one from south to north: a straight lane for a kind of "
            "robot, checked by its poses, or also by drives that cross so surely, as in crawler:0.9; or a path of "
            "cells with these steps up and down and this width"
        ),
    ] = None
    crossable_room: Annotated[
        float,
        Float(
            0,
            2,
            help="how much room to spare the lanes of a robot in crossable_by have, as a share of what is usual: 0 "
            "leaves maps as rough as poses allow, more than 1 makes lanes level",
        ),
    ] = 1.0
    inventory: Annotated[
        Sequence[int] | None,
        ListOf(
            Integer(0, 10**9),
            help="blocks in stock, of level 1, 2, ...; no others are used",
            most=MOST_LEVELS,
        ),
    ] = None
    seed: Annotated[
        int, Integer(0, SEEDS - 1, help="random seed; if none is given, one is drawn and saved in recipe.json")
    ] = field(default_factory=fresh_seed)
    obstacles: Sequence[Obstacle] = ()

    def __post_init__(self) -> None:
        validate(self)
        self.check_design()

    def check_design(self) -> None:
        """Raise a ParameterError if a parameter or an obstacle does not fit the others; give every obstacle its key."""
        self._check_frames()
        if self.inventory is not None and not any(self.inventory):
            raise ParameterError("inventory", "has no block; list the number of blocks of level 1, 2, ...")
        if not isinstance(self.obstacles, (list, tuple)):
            raise ParameterError("obstacles", f"{shown(self.obstacles)} is not a list of obstacles")
        for index, obstacle in enumerate(self.obstacles):
            self._check_obstacle(f"obstacles[{index}]", obstacle)
        self._check_ground()
        object.__setattr__(self, "obstacles", with_keys(tuple(self.obstacles)))

    @property
    def grid(self) -> Grid:
        """The block cells of a map."""
        from rsegen.obstacles import Grid

        m_x, m_y = self.chunks
        return Grid(m_x * self.chunk_size, m_y * self.chunk_size, self.chunk_size)

    @property
    def cells(self) -> tuple[int, int]:
        """The cells of a map along x and y, frames counted, which are a cell wide."""
        n_x, n_y = self.grid.shape
        if self.boundary == "none":
            return n_x, n_y
        frames_x, frames_y = self.chunks if self.boundary == "divided" else (1, 1)
        return n_x + 2 * frames_x, n_y + 2 * frames_y

    @property
    def crosser(self) -> CrossingModel | None:
        """The robot that crosses every map, or limits of steps; None if the recipe demands nothing of the sort."""
        if self.crossable_by is None:
            return None
        if isinstance(self.crossable_by, str):
            return robot_that_crosses(self.crossable_by, "crossable_by", kind_only=True, room=self.crossable_room)
        climb, drop, width = self.crossable_by
        return StepLimits(climb_cm=climb, drop_cm=drop, width_cm=width)

    def difficulty_of(self, index: int) -> float:
        """Return the difficulty of map `index`."""
        return self.difficulties_of([index])[0]

    def difficulties_of(self, indices: Sequence[int]) -> list[float]:
        """Return the difficulties of several maps: of a range a draw for each, or with steps the next in turn."""
        if isinstance(self.difficulty, float):
            return [self.difficulty] * len(indices)
        low, high, *steps = self.difficulty
        if steps:
            shares = [index % steps[0] / (steps[0] - 1) for index in indices]
        elif len(indices) == 1:  # streams of many maps cost more than one generator
            shares = [generator(self.seed, indices[0], _KEY).random()]
        else:
            shares = Streams.of(self.seed, indices, _KEY).random().tolist()
        return [round(low + (high - low) * share, 9) for share in shares]  # as files have it: not 0.30000000000000004

    @property
    def is_constrained(self) -> bool:
        """Return whether the maps have to meet any constraint."""
        return not (self.max_step is None and self.crossable_by is None and self.inventory is None)

    @property
    def enabled_obstacles(self) -> Sequence[tuple[int, Obstacle]]:
        """The obstacles that are in the maps, each with its row."""
        return [(row, obstacle) for row, obstacle in enumerate(self.obstacles) if obstacle.enabled]

    @property
    def level_range(self) -> tuple[int, int]:
        """The lowest and the highest level of any obstacle in the maps, from the ground: 0 or less, 0 or more."""
        low = high = 0
        for _, obstacle in self.enabled_obstacles:
            lowest, highest = obstacle.level_range
            low, high = min(low, lowest), max(high, highest)
        return low, high

    @property
    def top_level(self) -> int:
        """The largest level that the ground or any obstacle in the maps has."""
        return self.ground_level + self.level_range[1]

    @property
    def highest_level(self) -> int:
        """The largest level that any block may have: an inventory may replace blocks by higher ones."""
        owned = (level for level, blocks in enumerate(self.inventory or (), 1) if blocks)
        return max([self.top_level, *owned])

    def _check_ground(self) -> None:
        """Raise a ParameterError if an obstacle reaches below the floor or too high, or no robot gets onto the map."""
        top = MOST_LEVELS - 1
        if self.top_level > top:
            problem = (
                f"{self.ground_level} and obstacles of {self.level_range[1]} units are above the highest level, {top}"
            )
            raise ParameterError("ground_level", problem)
        for index, obstacle in self.enabled_obstacles:
            if (depth := -obstacle.level_range[0]) > self.ground_level:
                problem = f"{obstacle.kind} reaches {depth} units down, and the ground is at level {self.ground_level}"
                raise ParameterError(f"obstacles[{index}]", f"{problem}; use a ground_level of {depth} or more")
        if self.ground_level and isinstance(self.crossable_by, str):
            raise ParameterError(
                "crossable_by",
                f"{self.crossable_by} starts on the floor, {self.ground_level} units below the ground of the map; "
                "use limits of steps, as in [10, 10, 30], or ground_level 0",
            )

    def _check_frames(self) -> None:
        """Raise a ParameterError if frames are too high for a path that is to lead across; poses show it of a robot."""
        if self.crossable_by is None or isinstance(self.crossable_by, str):
            return
        least = min(self.crossable_by[:2])
        if self.boundary != "none" and self.frame_height_cm > least:
            raise ParameterError(
                "crossable_by",
                f"the path goes over {least:g} cm, and the frames are {self.frame_height_cm:g} cm high; "
                f"use boundary none, or a frame_height_cm of up to {least:g}",
            )

    def _check_obstacle(self, where: str, obstacle: object) -> None:
        """Raise a ParameterError for what is no obstacle, or is switched on and lies outside the map."""
        from rsegen.obstacles import Obstacle

        if not isinstance(obstacle, Obstacle):
            raise ParameterError(where, f"{shown(obstacle)} is not an obstacle, such as rsegen.Peak(levels=5)")
        if not obstacle.enabled:
            return
        # Random coordinates are drawn inside the map; only given ones can lie outside.
        for end in ("first", "last"):
            for axis, cells in enumerate(self.grid.shape):
                at = (getattr(obstacle, end) or (0, 0))[axis]
                if at != "random" and at >= cells:
                    n_x, n_y = self.grid.shape
                    raise ParameterError(
                        f"{where}.{end}[{axis}]",
                        f"{shown(at)} is outside 0..{cells - 1}: the map has {n_x} x {n_y} blocks; "
                        "larger chunks or chunk_size give more",
                    )
        with inside(where):
            obstacle.check_size(self.grid)


def with_keys(obstacles: tuple[Obstacle, ...]) -> tuple[Obstacle, ...]:
    """Return obstacles that all have their own key: the given one, or one that is derived from their row."""
    taken: set[str] = set()
    for index, obstacle in enumerate(obstacles):
        if obstacle.key in taken:
            raise ParameterError(f"obstacles[{index}].key", f"{shown(obstacle.key)} is another obstacle's key too")
        taken |= {obstacle.key} if obstacle.key else set()
    # A key is a hash of the row, and identical rows get -1, -2, ... behind it: for each hash, the keys that are left.
    free: dict[str, Iterator[str]] = {}
    keyed = list(obstacles)
    for row, obstacle in enumerate(obstacles):
        if not obstacle.key:
            stem = key_stem(obstacle)
            keyed[row] = _under(obstacle, next(free.setdefault(stem, derived_keys(stem, taken))))
    return tuple(keyed)


_HASHED_NAMES = {"levels": "max_height"}
"""Old names of parameters, which remain in the text of which a key is made: the key decides what is drawn, so
another word would change every map whose rows have no key of their own."""


def derived_keys(stem: str, taken: Set[str]) -> Iterator[str]:
    """Yield the keys of rows like each other, in their order, without those that other rows were given."""
    numbered = (f"{stem}-{place}" if place else stem for place in count())
    return (key for key in numbered if key not in taken)


def key_stem(obstacle: Obstacle) -> str:
    """Return the key of an obstacle that has none, if no other row is like it."""
    # Switched off, a row has the key that it has switched on, so that no other row is drawn anew.
    left_out = ("enabled", "key")
    row = {_HASHED_NAMES.get(name, name): value for name, value in obstacle.entry().items() if name not in left_out}
    digest = hashlib.blake2b(json.dumps(row, sort_keys=True).encode(), digest_size=4).hexdigest()
    return f"{obstacle.kind}-{digest}"


def _under(obstacle: Obstacle, key: str | None) -> Obstacle:
    """Return an obstacle under another key, or under none."""
    keyed = copy(obstacle)  # not `replace`, which would check every cell of a large matrix once more
    object.__setattr__(keyed, "key", key)
    return keyed


def without_derived_keys(obstacles: Sequence[Obstacle]) -> tuple[Obstacle, ...]:
    """Return obstacles without the keys that `with_keys` would give them again, as people write them."""
    own = {row for row, obstacle in enumerate(obstacles) if not (obstacle.key or "").startswith(key_stem(obstacle))}
    while True:
        bare = tuple(obstacle if row in own else _under(obstacle, None) for row, obstacle in enumerate(obstacles))
        pairs = zip(with_keys(bare), obstacles, strict=True)
        # A row like another one may have a number that its place in the list would not give it.
        others = {row for row, (again, before) in enumerate(pairs) if again.key != before.key}
        if not others:
            return bare
        own |= others
