"""Plans of experiments: rows of robots and maps, each in several sizes, paces and repeats.

A cell of the table is a row at a size and a pace. In each repeat all cells are tried once, in a mixed order, so that a
noisy hour of the machine does not favour one of them. The seed decides the order, so a stopped experiment keeps it.
"""

from __future__ import annotations

import json
import random
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.resources import files
from itertools import product
from pathlib import Path
from typing import Annotated

from rsegen.driving.drive import drivable
from rsegen.errors import ParameterError, UnknownName, inside, refuse_unknown, shown
from rsegen.field.crossing import SIDE, SPEED, TURN
from rsegen.params.sorts import Choice, Float, Integer, Json, ListOf, Reference, Text, parameters, validate
from rsegen.recipe.codec import decode
from rsegen.recipe.recipe import Recipe
from rsegen.recipe.recipe_file import recipe_content
from rsegen.robots.base import ROBOTS
from rsegen.robots.files.sdf_file import is_robot_file
from rsegen.robots.lookup import DrivableRobot
from rsegen.simulators.base import SIMULATORS
from rsegen.simulators.embedded import EMBEDDED

PACES = ("real", "free", "beside", "camera", "window")
"""Paces of a trial: in real time; at full speed, which shows what a map costs; at full speed in turns with an empty
world, second by second, whose ratio is right on a noisy machine too; in real time with a camera in the server; in real
time with the simulator's own window."""

IN_REAL_TIME = ("real", "camera", "window")
"""The paces in real time."""

PLANS = {path.name.removesuffix(".yaml"): path for path in files("rsegen.experiments").joinpath("plans").iterdir()}
"""The included plans, by name."""

_BLOCKS = 10
"""Blocks per side of a chunk, as in the paper's maps; sizes are multiples of it."""


@dataclass(frozen=True)
class _KindOrFile(Choice):
    """A kind of robot, or the file of one, which is read when its trials are prepared."""

    def check(self, where: str, value: object) -> str:
        return str(value) if is_robot_file(value) else super().check(where, value)

    def describe(self) -> str:
        return f"{super().describe()}, or an SDF, URDF, Xacro or MJCF file"


_SINGLE: Mapping[str, Mapping[str, Json]] = {
    "horizontal_barrier": {"softness": 50, "first": [0, 5], "last": [9, 5]},
    "diagonal_barrier": {"softness": 40, "first": [0, 0], "last": [9, 9]},
    "peak": {"first": [2, 2], "last": [7, 7]},
}
"""The single obstacles of the paper's small worlds, its figures 1 to 3, as the examples of these names have them."""

LARGER = "barriers and peaks"
"""The maps of the paper's larger worlds: one of each of these kinds for every chunk along a side, at random places."""

KINDS_OF_MAPS = ("random", *_SINGLE, LARGER)
"""Words for the maps of a row: random blocks, a single obstacle, or several."""


_OF_THE_ROW = {
    "chunk_size": "the sizes of the row",
    "chunks": "the sizes of the row",
    "unit_cm": "that of the row",
    "seed": "that of the plan, plus 1 for each repeat",
}
"""Parameters that a row's recipe may not have: tables would name other maps than those that are driven on."""


@dataclass(frozen=True, kw_only=True, slots=True)
class TableRow:
    """Robots of a kind, or of a file, on maps of several sizes; `recipe` holds more parameters of these maps.

    wheels, tracks, size, speed, turn: as in `rsegen.drive`, for the robot of a file
    """

    robot: Annotated[str, _KindOrFile(tuple(ROBOTS), help="kind of robot, or file of a model")] = "burger"
    wheels: Annotated[str | None, Reference("LEFT,RIGHT", help="joints of the wheels of a model in a file")] = None
    tracks: Annotated[str | None, Reference("LEFT,RIGHT", help="links of the tracks of a model in a file")] = None
    size: Annotated[Sequence[float] | None, ListOf(SIDE, 3, help="length, width and height")] = None
    speed: Annotated[float | None, SPEED] = None
    turn: Annotated[float | None, TURN] = None
    robots: Annotated[int, Integer(1, 100, help="number of robots")] = 3
    sizes: Annotated[
        Sequence[int],
        ListOf(Integer(0, 4000, unit="blocks"), help="sides of the maps in blocks, 0 for an empty world"),
    ] = (0, 10, 20, 40, 60, 80)
    maps: Annotated[str, Choice(KINDS_OF_MAPS, help="what stands on the maps")] = "random"
    levels: Annotated[int, Integer(2, 1000, help="number of levels")] = 3
    unit_cm: Annotated[
        float, Float(0.001, 1000, unit="cm", help="unit of height; each block is a whole number of units high")
    ] = 0.3
    recipe: Mapping[str, Json] | None = None
    simulator: Annotated[
        str | None, Choice((*SIMULATORS, *EMBEDDED), help="default: the newest Gazebo that is installed")
    ] = None

    def __post_init__(self) -> None:
        validate(self)
        if not isinstance(self.recipe, Mapping | None):
            raise ParameterError(
                "recipe", f"{shown(self.recipe)} is not parameters of a recipe, such as {{collision: boxes}}"
            )
        for key, here in _OF_THE_ROW.items():
            if key in (self.recipe or {}):
                raise ParameterError("recipe", f"{key} follows from {here}; leave it out")
        for size in self.sizes:
            if size % _BLOCKS:
                raise ParameterError("sizes", f"{size} is no multiple of {_BLOCKS} blocks")
            if size > _BLOCKS and self.maps in _SINGLE:
                raise ParameterError("sizes", f"{size}: a single {self.maps} is on {_BLOCKS} x {_BLOCKS} blocks")
        self.map_of(_BLOCKS, 0)

    def map_of(self, size: int, seed: int, room: int = 1) -> Recipe:
        """Return the recipe of the row's map with this number of blocks per side; 0 for an empty world without frames.

        room: chunks along each side of the ground of an empty world on which robots start
        """
        own = {
            "name": f"random-{size}",
            "chunk_size": _BLOCKS,
            "chunks": [size // _BLOCKS or room] * 2,
            "unit_cm": self.unit_cm,
            "boundary": "none",
            "seed": seed,
            "obstacles": self._obstacles(size // _BLOCKS),
        }
        empty = {} if size else {"boundary": "none", "obstacles": []}
        with inside("recipe"):
            return decode({**own, **(self.recipe or {}), **empty})

    def _obstacles(self, chunks: int) -> list[dict[str, Json]]:
        """Return the obstacles of a map with this number of chunks along each side."""
        if self.maps == "random":
            return [{"kind": "random", "levels": self.levels}]
        if self.maps in _SINGLE:
            return [{"kind": self.maps, "levels": self.levels, **_SINGLE[self.maps]}]
        # As soft as a single one of their kind, at random places of each map.
        kinds = [
            {"kind": kind, "levels": self.levels, "softness": _SINGLE[kind].get("softness", 0)} for kind in _SINGLE
        ]
        return kinds * chunks

    @property
    def model(self) -> DrivableRobot:
        """The robot; a UserError if its file cannot be read or driven, or if a kind has parameters of a file."""
        return drivable(self.robot, self.wheels, self.tracks, size=self.size, speed=self.speed, turn=self.turn)

    @property
    def label(self) -> str:
        """The row in a few words."""
        shape = ", ".join(f"{key} {_in_words(value)}" for key, value in (self.recipe or {}).items())
        return self.robots_and_maps + (f", {shape}" if shape else "")

    @property
    def robots_and_maps(self) -> str:
        """The robots of the row and the obstacles of its maps, in a few words."""
        robots = f"{self.robots} {Path(self.robot).name}, unit {self.unit_cm:g} cm"
        if "obstacles" in (self.recipe or {}):
            return robots  # they have levels of their own, and stand in place of `maps`
        robots += f", {self.levels} levels"
        return robots if self.maps == "random" else f"{robots}, {self.maps.replace('_', ' ')}"

    def differs_by_simulator(self, other: TableRow) -> bool:
        """Return whether both differ, and only by the simulator."""
        return self.simulator != other.simulator and replace(self, simulator=other.simulator) == other


def _in_words(value: Json) -> str:
    """Return a value of a recipe as text of a heading; for obstacles their kinds."""
    if isinstance(value, Mapping):
        return str(value.get("kind", "")) or json.dumps(value)
    if isinstance(value, list):
        return " and ".join(map(_in_words, value))
    return str(value)


@dataclass(frozen=True, kw_only=True, slots=True)
class Cell:
    """A field of the table: a row at a size and a pace."""

    row: int
    size: int
    pace: str

    @property
    def name(self) -> str:
        """The name of the cell in its plan."""
        return f"row {self.row + 1}, {self.size or 'empty'}, {self.pace}"


@dataclass(frozen=True, kw_only=True, slots=True)
class ExperimentPlan:
    """The trials of an experiment, and their repeats; each takes `seconds` of wall time, whatever the pace."""

    name: Annotated[str, Text(r"[A-Za-z0-9_.\-]{1,64}", "1..64 letters, digits, _ . -", help="name of the experiment")]
    rows: tuple[TableRow, ...]
    paces: Annotated[
        Sequence[str],
        ListOf(
            Choice(PACES),
            help="real time, full speed, full speed alternating with an empty world, real time with camera or window",
        ),
    ] = ("real", "free")
    seconds: Annotated[float, Float(1, 1e5, unit="s", help="wall time of each trial, after its world is loaded")] = 20.0
    repeats: Annotated[int, Integer(1, 1000, help="trials per cell of the table")] = 3
    seed: Annotated[int, Integer(0, 2**62, help="seed of maps, places, routes and order; plus 1 for each repeat")] = 1

    def __post_init__(self) -> None:
        validate(self)
        if not self.rows:
            raise ParameterError("rows", "is empty; add a row, such as {robot: burger, sizes: [0, 80]}")

    @property
    def cells(self) -> tuple[Cell, ...]:
        """The fields of the table, row by row."""
        return tuple(
            Cell(row=index, size=size, pace=pace)
            for pace, (index, row) in product(self.paces, enumerate(self.rows))
            for size in row.sizes
        )

    def in_simulators(self, names: Sequence[str]) -> ExperimentPlan:
        """Return the plan with each row that names no simulator repeated for each of these."""
        rows = (
            replace(row, simulator=name) for row in self.rows for name in ((row.simulator,) if row.simulator else names)
        )
        return replace(self, rows=tuple(rows))

    @property
    def tables(self) -> Sequence[Sequence[int]]:
        """The tables, as indices of rows: rows that differ by the simulator only share a table."""
        tables: list[list[int]] = []
        for index, row in enumerate(self.rows):
            alike = (table for table in tables if all(self.rows[known].differs_by_simulator(row) for known in table))
            if (own := next(alike, None)) is None:
                tables.append([index])
            else:
                own.append(index)
        return tables

    def order(self) -> Iterator[tuple[Cell, int]]:
        """Yield each cell and the number of its repeat, mixed, so that a noisy hour does not favour one cell."""
        for repeat in range(self.repeats):
            cells = list(self.cells)
            random.Random(f"{self.seed}/{repeat}").shuffle(cells)  # noqa: S311  # an order, no secret
            yield from ((cell, repeat) for cell in cells)


def load_plan(name: str) -> ExperimentPlan:
    """Return an included plan by its name, or the plan in a YAML file."""
    path = Path(str(PLANS.get(name, name)))
    if not path.suffix:
        raise UnknownName.among("", "plan", name, PLANS)
    try:
        return read_plan(path.stem, recipe_content(path))
    except ParameterError as error:
        raise error.of(str(path)) from None


def read_plan(name: str, content: Json) -> ExperimentPlan:
    """Return the plan of a file's content, called `name` if it has no name; ParameterError for a wrong value."""
    if not isinstance(content, Mapping) or not isinstance(content.get("rows"), list):
        raise ParameterError("", "not a plan of an experiment; it has name: and a list of rows:")
    known = [*parameters(ExperimentPlan), "rows"]
    refuse_unknown("key", content, known)
    rows = []
    for index, row in enumerate(content["rows"]):
        with inside(f"rows[{index}]"):
            if not isinstance(row, Mapping):
                raise ParameterError("", f"{shown(row)} is not a row, such as {{robot: burger, sizes: [0, 80]}}")
            refuse_unknown("key of a row", row, [*parameters(TableRow), "recipe"])
            rows.append(TableRow(**row))
    return ExperimentPlan(**{"name": name, **content, "rows": tuple(rows)})
