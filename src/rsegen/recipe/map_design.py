"""What a map is: its size, its obstacles, what it keeps to, and the seed. Nothing else decides a level of a block.

The difficulty of the maps of a recipe: one for all, or a range, drawn for each map or in even steps.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, Any

from rsegen.errors import ParameterError, shown
from rsegen.field.obstacles import Grid
from rsegen.field.obstacles.base import MOST_LEVELS
from rsegen.field.robot_limits import RobotLimits
from rsegen.params.sorts import Cell, Choice, Float, Integer, Json, ListOf, Size2D, validate
from rsegen.params.streams import SEEDS, fresh_seed, generator
from rsegen.recipe.placement import Placement, with_keys

Difficulty = float | tuple[float, float] | tuple[float, float, int]
"""One number; or the least and the most, and, if it is not to be drawn, the number of steps from one to the other."""

_SHARE, _STEPS = Float(0, 1), Integer(2, 1_000_000)

_KEY = "drawn difficulty"
"""Key of its random generator; no key of an obstacle has blanks."""


@dataclass(frozen=True)
class DifficultySort:
    """A difficulty: `0.5`, `[0, 1]` or `[0, 1, 10]`."""

    help: str = ""

    def check(self, where: str, value: object) -> Difficulty:
        if not isinstance(value, (list, tuple)):
            return _SHARE.check(where, value)
        if len(value) not in (2, 3):
            raise ParameterError(where, f"{shown(value)} is not {self.describe()}")
        low, high = (_SHARE.check(f"{where}[{place}]", one) for place, one in enumerate(value[:2]))
        if low > high:
            raise ParameterError(where, f"{shown(value)} begins above its end; give the least first")
        return (low, high) if len(value) == 2 else (low, high, _STEPS.check(f"{where}[2]", value[2]))

    def parse(self, text: str) -> object:
        parts = text.split(",")
        if len(parts) == 1:
            return _SHARE.parse(text)
        return [_SHARE.parse(part) for part in parts[:2]] + [_STEPS.parse(part) for part in parts[2:]]

    def format(self, value: Any) -> str:
        return ",".join(map(_SHARE.format, value)) if isinstance(value, (list, tuple)) else _SHARE.format(value)

    def schema(self) -> dict[str, Json]:
        one, steps = _SHARE.schema(), _STEPS.schema()
        pair = {"type": "array", "items": one, "minItems": 2, "maxItems": 2}
        stepped = {"type": "array", "prefixItems": [one, one, steps], "minItems": 3, "maxItems": 3}
        return {"anyOf": [one, pair, stepped]}

    def describe(self) -> str:
        return "a number from 0 to 1, or a range as in [0.2, 1] or, in 10 steps, [0.2, 1, 10]"


def difficulty_of_map(given: Difficulty, seed: int, index: int) -> float:
    """That of map `index`: of a range drawn evenly, by the seed, or in turn if it has steps."""
    if not isinstance(given, tuple):
        return given
    low, high, *steps = given
    share = index % steps[0] / (steps[0] - 1) if steps else generator(seed, index, _KEY).random()
    return round(low + (high - low) * share, 9)


_CENTIMETRES = Float(0.001, 100_000, unit="cm")


@dataclass(frozen=True, kw_only=True)
class MapDesign:
    """What decides the levels of the blocks of every map, in the words of the recipe file."""

    chunk_size: Annotated[int, Integer(1, 1000, unit="blocks", help="side of a single chunk (pallet)")] = 10
    chunks: Annotated[Cell, Size2D(help="map size in chunks: N for a square, or NxM")] = (1, 1)
    unit_cm: Annotated[float, replace(_CENTIMETRES, help="height discretization step")] = 10.0
    block_width_cm: Annotated[float, replace(_CENTIMETRES, help="side of a block, and depth of a frame")] = 10.0
    boundary: Annotated[
        str, Choice(("none", "divided", "outer"), help="frames: none, around every chunk, or one around the map")
    ] = "divided"
    frame_height_cm: Annotated[float, Float(0, 100_000, unit="cm", help="height of the frames")] = 10.0
    difficulty: Annotated[
        Difficulty,
        DifficultySort(
            help="how rough the map is: 1 as designed, 0 flat; a range is drawn for each map, with a third number "
            "it rises in this number of steps from map to map, and begins again"
        ),
    ] = 1.0
    max_step: Annotated[
        int | None,
        Integer(
            1,
            32767,
            unit="units",
            help="largest height difference between neighbouring blocks; steeper slopes are flattened",
        ),
    ] = None
    crossable_by: Annotated[
        tuple[float, float, float] | None,
        ListOf(
            Float(0, 100_000, unit="cm"),
            3,
            help="guarantees that a robot with this climb, drop and width can cross west to east and south to north",
        ),
    ] = None
    inventory: Annotated[
        tuple[int, ...] | None,
        ListOf(
            Integer(0, 10**9),
            help="number of blocks in stock of level 1, 2, ...: only these are used",
            most=MOST_LEVELS,
        ),
    ] = None
    seed: Annotated[
        int, Integer(0, SEEDS - 1, help="random seed; if none is given, one is drawn and saved in recipe.json")
    ] = field(default_factory=fresh_seed)
    obstacles: Sequence[Placement] = ()

    def __post_init__(self) -> None:
        validate(self)
        self.check_design()

    def check_design(self) -> None:
        """Raise a ParameterError if a parameter or an obstacle does not fit the others; give every obstacle its key."""
        self._check_frames()
        if self.inventory is not None and not any(self.inventory):
            raise ParameterError("inventory", "has no block; give the number of blocks of level 1, 2, ...")
        if not isinstance(self.obstacles, (list, tuple)):
            raise ParameterError("obstacles", f"{shown(self.obstacles)} is not a list of placements")
        for number, placement in enumerate(self.obstacles):
            self._check_placement(f"obstacles[{number}]", placement)
        object.__setattr__(self, "obstacles", with_keys(tuple(self.obstacles)))

    @property
    def grid(self) -> Grid:
        """The block cells of a map."""
        m_x, m_y = self.chunks
        return Grid(m_x * self.chunk_size, m_y * self.chunk_size, self.chunk_size)

    @property
    def climber(self) -> RobotLimits | None:
        """The robot that gets across every map."""
        if self.crossable_by is None:
            return None
        climb, drop, width = self.crossable_by
        return RobotLimits(climb_cm=climb, drop_cm=drop, width_cm=width)

    def difficulty_of(self, index: int) -> float:
        """The difficulty of map `index`."""
        return difficulty_of_map(self.difficulty, self.seed, index)

    @property
    def is_constrained(self) -> bool:
        """Whether its maps keep to anything."""
        return not (self.max_step is None and self.crossable_by is None and self.inventory is None)

    @property
    def top_level(self) -> int:
        """The largest level that any of its obstacles has; 0 where there is none."""
        return max((placement.obstacle.max_height - 1 for placement in self.obstacles), default=0)

    @property
    def highest_level(self) -> int:
        """The largest level that any of its blocks may have: an inventory may replace blocks by higher ones."""
        owned = (level for level, blocks in enumerate(self.inventory or (), 1) if blocks)
        return max([self.top_level, *owned])

    def _check_frames(self) -> None:
        """Raise a ParameterError where a robot that is to get across can't get over the frames."""
        least = min(self.crossable_by[:2]) if self.crossable_by else self.frame_height_cm
        if self.boundary != "none" and self.frame_height_cm > least:
            raise ParameterError(
                "crossable_by",
                f"the robot gets over {least:g} cm, and the frames are {self.frame_height_cm:g} cm high; "
                f"give boundary none, or a frame_height_cm of up to {least:g}",
            )

    def _check_placement(self, where: str, placement: object) -> None:
        if not isinstance(placement, Placement):
            raise ParameterError(where, f"{shown(placement)} is not a placement, rsegen.Placement(obstacle=..., ...)")
        for end in ("first", "last"):
            for axis, cells in enumerate(self.grid.shape):
                at = (getattr(placement, end) or (0, 0))[axis]
                if at != "random" and at >= cells:
                    raise ParameterError(f"{where}.{end}[{axis}]", f"{shown(at)} is outside 0..{cells - 1}")
        try:
            placement.obstacle.check_size(self.grid, placement.first, placement.last)
        except ParameterError as error:
            raise error.inside(where) from None
