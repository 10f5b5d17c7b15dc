"""Models of crossing a field: a robot by its poses, or limits of steps by a path of cells.

The core knows limits of steps (`field/limits.py`). Robots come with the capabilities that know them, which find one by
its kind or file (`Capability.crossers`).
"""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from rsegen.errors import ParameterError, shown
from rsegen.params.capabilities import hooks
from rsegen.params.registry import offered_names

if TYPE_CHECKING:
    from rsegen.field.stepfield import Ints, Mask, StepField

NO_CAP = 2**30
"""A level above all levels, for cells without a limit; twice it still fits into 32 bits."""


class CrossingModel(ABC):
    """A robot, or limits of steps: where it gets on a field, and its ways across."""

    __slots__ = ()

    @property
    @abstractmethod
    def width(self) -> float:
        """Width, metres, for the percolation step."""

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


def robot_that_crosses(what: object, where: str, *, kind_only: bool = False) -> CrossingModel:
    """Return the robot of a kind or, unless `kind_only`, of a file; UnknownName or FileError if there is none."""
    for find in hooks("crossers"):
        robot: CrossingModel = find(what, where, kind_only=kind_only)
        return robot
    named = os.fspath(what) if isinstance(what, str | os.PathLike) else what
    raise ParameterError(where, f"{shown(named)}: no robots are installed; use limits of steps")


def predictions(robot: CrossingModel, scene: Any) -> Mapping[str, Any]:
    """Return how surely a robot gets across a scene, by its sides, west_east and south_north, from drives.

    Each has a `probability`, a text, and `as_json`; empty for limits of steps, and where nothing can drive.
    """
    for predict in hooks("predictor"):
        found: Mapping[str, Any] = predict(robot, scene)
        return found
    return {}


def robot_kinds() -> str:
    """Return a sentence on the kinds of robots for a help, without importing one; empty if none are installed."""
    kinds = offered_names("rsegen.robots", "rsegen.robots")
    return f"Kinds of robots: {', '.join(kinds)}." if kinds else ""
