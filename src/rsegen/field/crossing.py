"""Models of crossing a field: a robot by its poses, or limits of steps by a path of cells.

The core knows limits of steps: the largest one up and down on a path of cells, and its width; nothing stands or tips
there. Robots come with the capabilities that know them, which find one by its kind or file (`Capability.crossers`).
"""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

from rsegen.errors import ParameterError, shown
from rsegen.params.capabilities import hooks
from rsegen.params.registry import offered_names
from rsegen.params.sorts import NANOMETRES, Float, validate

if TYPE_CHECKING:
    from rsegen.field.stepfield import Ints, Mask, StepField
    from rsegen.field.traversability import Crossing, Traversability
    from rsegen.params.plugins import Source

# Centimetres to a hundred metres, and a millimetre per second to 360 km/h: all robots, and no model in millimetres.
SIDE = Float(0.01, 100, unit="m")
SPEED, TURN = Float(0.001, 100, unit="m/s"), Float(0.001, 100, unit="rad/s")
"""Bounds of a robot's size, speed and turn rate, whether a flag gives them or an SDF file."""


class CrossingModel(ABC):
    """A robot, or limits of steps: where it gets on a field, and its ways across."""

    __slots__ = ()

    @property
    @abstractmethod
    def width(self) -> float:
        """Width, metres, for the percolation step."""

    @property
    def plugin(self) -> Source | None:
        """The package or file that it comes from; None for rsegen's own."""
        return None

    @abstractmethod
    def reach(self, field: StepField) -> Any:
        """Return what it reaches, with `coverage`, `west_east`, `south_north` and `region`, a mask (n_x, n_y)."""

    @abstractmethod
    def crossing(self, field: StepField, axis: int) -> Any:
        """Return its way across along an axis, 0 for x and 1 for y, with `crosses` and `length` [m]."""

    @abstractmethod
    def caps(self, field: StepField, axis: int) -> Ints | None:
        """Return the highest levels (n_x, n_y) with which it crosses along an axis; None if it does already."""

    def lanes(self, field: StepField) -> Mask | None:
        """Return the cells that must stay as they are so that it still crosses; None if `caps` is quick to ask."""
        return None

    @property
    def search(self) -> str:
        """Name of the search of `caps` for a progress bar; empty if it takes no time."""
        return ""

    @abstractmethod
    def in_words(self, units: str) -> str:
        """Return what crosses, in words; units: of lengths, as in recipes."""

    def watched(self, watch: Callable[[float], None]) -> CrossingModel:
        """Return the same that reports the progress of its search, 0..1; `watch` may end the search."""
        return self

    def events(self, way: Any) -> list[str]:
        """Return what happens on a way of it, in words."""
        return []

    def pose_maps(self, scene: Any, heading: float, format: str) -> bytes:  # noqa: A002  # matplotlib's word
        """Return maps of its poses on a scene at a heading [rad], as an image file."""
        raise ParameterError("heading", "limits of steps have no poses; choose a robot")


@dataclass(frozen=True, kw_only=True, slots=True)
class StepLimits(CrossingModel):
    """Limits of a path from cell to cell: steps of up to `climb_cm` up and `drop_cm` down, `width_cm` wide."""

    climb_cm: Annotated[float, Float(0, 100_000, unit="cm", help="highest step up on a path of cells")]
    drop_cm: Annotated[float | None, Float(0, 100_000, unit="cm", help="highest step down; default: as climb")] = None
    width_cm: Annotated[
        float, Float(0, 100_000, unit="cm", help="width of the path, whose highest cell counts; 0: one cell")
    ] = 0.0

    def __post_init__(self) -> None:
        validate(self)

    @classmethod
    def of(cls, climb: float, width: float) -> StepLimits:
        """Return the limits of a climb and a width in metres."""
        return cls(climb_cm=round(climb * 100, 7), width_cm=round(width * 100, 7))

    @property
    def limits(self) -> tuple[int, int]:
        """Highest step up and highest step down, nanometres."""
        climb_cm, drop_cm, _ = self.climb_drop_width
        return round(climb_cm * NANOMETRES / 100), round(drop_cm * NANOMETRES / 100)

    @property
    def climb_drop_width(self) -> tuple[float, float, float]:
        """Climb, drop and width in centimetres."""
        return self.climb_cm, self.climb_cm if self.drop_cm is None else self.drop_cm, self.width_cm

    @property
    def width(self) -> float:
        """Width in metres."""
        return self.width_cm / 100

    def reach(self, field: StepField) -> Traversability:
        """Return the traversability of a field within these limits."""
        from rsegen.field.traversability import traversability

        return traversability(field, self)

    def crossing(self, field: StepField, axis: int) -> Crossing:
        """Return the cheapest path across a field, along x for axis 0, along y for axis 1."""
        from rsegen.field.traversability import crossing

        return crossing(field, self, axis)

    def caps(self, field: StepField, axis: int) -> Ints | None:
        """Return the highest levels along the cheapest path of the least highest step; None if one leads across."""
        from rsegen.field.traversability import path_caps

        return path_caps(field, self, axis)

    def in_words(self, units: str) -> str:
        """Return the limits in words; units: of lengths, as in recipes."""
        from rsegen.params.numbers import lengths_in

        written = lengths_in(units)
        up, down = (f"{written.short(limit)} {written.unit}" for limit in self.limits)
        wide = f", {written.with_unit(self.width, 3)} wide" if self.width_cm else ""
        return f"a path of steps of up to {up} up and {down} down{wide}"


def robot_that_crosses(what: object, where: str, *, kind_only: bool = False, room: float = 1.0) -> CrossingModel:
    """Return the robot of a kind or, unless `kind_only`, of a file; UnknownName or FileError if it does not exist.

    room: how much room to spare lanes for it have, as a share of what is usual
    """
    for find in hooks("crossers"):
        robot: CrossingModel = find(what, where, kind_only=kind_only, room=room)
        return robot
    named = os.fspath(what) if isinstance(what, str | os.PathLike) else what
    raise ParameterError(where, f"{shown(named)}: no robots are installed; use limits of steps")


def predictions(robot: CrossingModel, scene: Any) -> Mapping[str, Any]:
    """Return how surely a robot gets across a scene, by its sides, west_east and south_north, from drives.

    Each has a `probability`, a text, and `as_json`; empty for limits of steps, and where nothing can drive.
    """
    for predict in hooks("predictor"):
        by_side: Mapping[str, Any] = predict(robot, scene)
        return by_side
    return {}


def robot_kinds() -> str:
    """Return a sentence on the kinds of robots for a help, without importing one; empty if none are installed."""
    kinds = offered_names("rsegen.robots", "rsegen.robots")
    return f"Kinds of robots: {', '.join(kinds)}." if kinds else ""
