"""A recipe: everything that determines a set of maps."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, fields, replace
from itertools import count
from typing import Annotated

from rsegen.errors import ParameterError, shown
from rsegen.field.metrics import RobotLimits
from rsegen.field.obstacles import Grid, Obstacle
from rsegen.params.places import Cell, CellRef, Place, Size2D
from rsegen.params.sorts import Choice, Float, Integer, Json, ListOf, Text, parameters, validate
from rsegen.params.streams import SEEDS, fresh_seed

_CENTIMETRES = Float(0.001, 100_000, unit="cm")
_FRICTION = Float(0, 1000, help="friction coefficient of blocks, frames and ground")
_COLOUR = Text("#[0-9A-Fa-f]{6}", "#rrggbb, in quotes")


@dataclass(frozen=True, kw_only=True, slots=True)
class Placement:
    """An obstacle at its place: one row of the recipe's list.

    `key` names its randomness: while it stays, so does what was drawn for it. Where none is given the recipe derives
    one from the row itself, so that rows added, moved or removed leave the others as they were.
    """

    obstacle: Obstacle
    first: Annotated[Place | None, CellRef(help="one end or corner, x and y in block cells of the map")] = None
    last: Annotated[Place | None, CellRef(help="the other end or corner")] = None
    blend: Annotated[
        str, Choice(("replace", "max", "add", "min"), help="how it is combined with earlier obstacles")
    ] = "replace"
    key: Annotated[
        str | None,
        Text(
            r"[A-Za-z0-9_.\-]{1,64}",
            "1..64 letters, digits, _ . -",
            help="name of its random stream: the same key draws the same",
        ),
    ] = None

    def __post_init__(self) -> None:
        if not isinstance(self.obstacle, Obstacle):
            raise ParameterError("obstacle", f"{shown(self.obstacle)} is not an obstacle, such as rsegen.Peak(...)")
        validate(self)
        if self.first and self.last:
            self.obstacle.check(self.first, self.last)

    def entry(self) -> dict[str, Json]:
        """The row as a recipe file has it: what differs from the defaults, the kind first."""
        return {"kind": self.obstacle.kind} | _stated(self.obstacle) | _stated(self)


@dataclass(frozen=True, kw_only=True, slots=True)
class Recipe:
    """What to generate; every field is a global parameter of the method, in the words of the recipe file."""

    name: Annotated[
        str,
        Text(
            r"[A-Za-z0-9_][A-Za-z0-9_.\-]{0,63}",
            "1..64 letters, digits, _ . - (no . or - first)",
            help="name of the maps",
        ),
    ] = "rse"
    description: Annotated[str, Text(r"[^\x00-\x1f]{0,500}", "one line of up to 500 characters", help="for people")] = (
        ""
    )
    maps: Annotated[int, Integer(1, help="number of maps to generate")] = 1
    first_map: Annotated[int, Integer(0, SEEDS - 1, help="index of the first of them")] = 0
    chunk_size: Annotated[int, Integer(1, 1000, unit="blocks", help="side of a single chunk (pallet)")] = 10
    chunks: Annotated[Cell, Size2D(help="map size in chunks: N for a square, or NxM")] = (1, 1)
    unit_cm: Annotated[float, replace(_CENTIMETRES, help="height discretization step")] = 10.0
    block_width_cm: Annotated[float, replace(_CENTIMETRES, help="side of a block, and depth of a frame")] = 10.0
    boundary: Annotated[
        str, Choice(("none", "divided", "outer"), help="frames: none, round every chunk, or one round the map")
    ] = "divided"
    frame_height_cm: Annotated[float, Float(0, 100_000, unit="cm", help="height of the frames")] = 10.0
    difficulty: Annotated[float, Float(0, 1, help="how rough the map is: 1 as designed, 0 flat")] = 1.0
    mesh_type: Annotated[
        str, Choice(("single", "multi", "pallet"), help="one model per map, per block, or per chunk")
    ] = "single"
    simulator: Annotated[
        str,
        Choice(
            ("both", "classic"), help="target simulator: both, or classic for smoother floors in Gazebo Classic only"
        ),
    ] = "both"
    mesh: Annotated[
        str,
        Choice(
            ("merged", "watertight", "blocks"),
            help="mesh: the exposed surface in few rectangles, closed and without gaps, or 6 faces per block",
        ),
    ] = "merged"
    collision: Annotated[
        str,
        Choice(
            ("mesh", "boxes", "blocks"),
            help="collision shape: the visual mesh, a few merged boxes, or one box per block",
        ),
    ] = "mesh"
    tile: Annotated[
        int,
        Integer(
            0, 100_000, unit="cells", help="cut the mesh into square parts of this side, one file each; 0: one mesh"
        ),
    ] = 0
    friction: Annotated[float, _FRICTION] = 1.0
    frame_friction: Annotated[float | None, replace(_FRICTION, help="friction of the frames, if different")] = None
    level_friction: Annotated[
        tuple[float, ...] | None,
        ListOf(_FRICTION, help="friction of blocks of level 1, 2, ...; higher levels have that of the map"),
    ] = None
    frame_colour: Annotated[str | None, replace(_COLOUR, help="colour of the frames")] = None
    level_colours: Annotated[
        tuple[str, ...] | None,
        ListOf(_COLOUR, help="colours of blocks of level 1, 2, ...; higher levels keep the default ones"),
    ] = None
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
        ListOf(Integer(0, 10**9), help="number of blocks in stock of level 1, 2, ...: only these are used"),
    ] = None
    seed: Annotated[
        int, Integer(0, SEEDS - 1, help="random seed; if none is given, one is drawn and saved in recipe.json")
    ] = field(default_factory=fresh_seed)
    obstacles: Sequence[Placement] = ()

    def __post_init__(self) -> None:
        validate(self)
        if self.first_map + self.maps > SEEDS:
            raise ParameterError("maps", f"{shown(self.maps)} from first_map {self.first_map} on go beyond {SEEDS - 1}")
        self._check_shapes()
        self._check_frames()
        if not isinstance(self.obstacles, (list, tuple)):
            raise ParameterError("obstacles", f"{shown(self.obstacles)} is not a list of placements")
        for number, placement in enumerate(self.obstacles):
            self._check_placement(f"obstacles[{number}]", placement)
        object.__setattr__(self, "obstacles", _with_keys(tuple(self.obstacles)))

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

    @property
    def is_constrained(self) -> bool:
        """Whether its maps keep to anything."""
        return not (self.max_step is None and self.crossable_by is None and self.inventory is None)

    @property
    def is_of_one_friction(self) -> bool:
        """Whether blocks, frames and ground all have the same coefficient."""
        given = (self.frame_friction, *(self.level_friction or ()))
        return all(friction in (None, self.friction) for friction in given)

    @property
    def indices(self) -> range:
        """The indices of its maps."""
        return range(self.first_map, self.first_map + self.maps)

    @property
    def top_level(self) -> int:
        """The largest level that any of its obstacles has; 0 where there is none."""
        return max((placement.obstacle.max_height - 1 for placement in self.obstacles), default=0)

    @property
    def highest_level(self) -> int:
        """The largest level that any of its blocks may have: an inventory may replace blocks by higher ones."""
        owned = (level for level, blocks in enumerate(self.inventory or (), 1) if blocks)
        return max([self.top_level, *owned])

    def map_name(self, index: int) -> str:
        """What map `index` is called, on disk and in the simulator."""
        return f"{self.name}_{index:04d}"

    def alone(self, index: int) -> Recipe:
        """The recipe of map `index` and no other."""
        return replace(self, first_map=index, maps=1)

    def values(self) -> dict[str, Json]:
        """Every global parameter that is not left open, as a file has it."""
        values = {name: getattr(self, name) for name in parameters(Recipe)}
        return {name: _plain(value) for name, value in values.items() if value is not None}

    def entry(self) -> dict[str, Json]:
        """The recipe as a file has it: every parameter in full, but for difficulty 1, which changes nothing."""
        stated = {name: value for name, value in self.values().items() if (name, value) != ("difficulty", 1)}
        return stated | {"obstacles": [placement.entry() for placement in self.obstacles]}

    def _check_shapes(self) -> None:
        """Raise a ParameterError for a shape that models of this mesh type cannot have."""
        if self.mesh_type == "multi" and self.mesh != "merged":
            raise ParameterError("mesh", f"'{self.mesh}' is for mesh_type single and pallet; multi is made of boxes")
        if self.mesh_type == "multi" and self.collision == "boxes":
            raise ParameterError("collision", "'boxes' is for mesh_type single and pallet; in multi every block is one")
        if self.simulator == "classic" and self.mesh_type != "single":
            raise ParameterError("simulator", f"'classic' is for mesh_type single; give both with {self.mesh_type}")
        if self.tile and self.mesh_type != "single":
            raise ParameterError("tile", f"{self.tile} is for mesh_type single; give 0 with mesh_type {self.mesh_type}")
        if self.tile and self.mesh == "watertight":
            raise ParameterError("tile", f"{self.tile} would cut a watertight mesh open; give 0, or mesh merged")

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


def _with_keys(placements: tuple[Placement, ...]) -> tuple[Placement, ...]:
    """Every placement with a key of its own: the given ones, and for the rest one from their content."""
    taken = set()
    for number, placement in enumerate(placements):
        if placement.key in taken:
            raise ParameterError(f"obstacles[{number}].key", f"{shown(placement.key)} is another obstacle's key too")
        taken |= {placement.key} - {None}
    free: dict[str, Iterator[str]] = {}
    return tuple(placement if placement.key else _with_key(placement, taken, free) for placement in placements)


def _with_key(placement: Placement, taken: set[str | None], free: dict[str, Iterator[str]]) -> Placement:
    """Named after its content; `free` goes on numbering the rows of one content, `taken` are the given keys."""
    content = json.dumps(placement.entry(), sort_keys=True).encode()
    stem = f"{placement.obstacle.kind}-{hashlib.blake2b(content, digest_size=4).hexdigest()}"
    twins = free.setdefault(stem, (f"{stem}-{twin}" if twin else stem for twin in count()))
    return replace(placement, key=next(key for key in twins if key not in taken))


def _stated(instance: Obstacle | Placement) -> dict[str, Json]:
    """The parameters that differ from their defaults."""
    defaults = {each.name: each.default for each in fields(instance)}
    values = {name: getattr(instance, name) for name in parameters(type(instance))}
    return {name: _plain(value) for name, value in values.items() if value != defaults[name]}


def _plain(value: object) -> Json:
    """A value as a file has it: lists for tuples, and 10 for 10.0."""
    if isinstance(value, tuple):
        return [_plain(one) for one in value]
    if isinstance(value, float) and value.is_integer():
        return int(value)
    return value
