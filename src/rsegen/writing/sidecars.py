"""Sidecars: optional files next to the world of each map, such as a picture or files for other programs.

A capability brings a kind of them as a class, whose name becomes a parameter of `rsegen.generate` and of all that
writes worlds, and so a flag of their commands:

    --preview  --chosen_sidecars-->  Preview()  --files-->  preview.png in the folder of every map
"""

from __future__ import annotations

import inspect
import os
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

from rsegen.errors import PluginError
from rsegen.params.capabilities import hooks
from rsegen.params.sorts import parameters
from rsegen.recipe.recipe import Recipe

if TYPE_CHECKING:
    from rsegen.cli.parser import Rows
    from rsegen.gazebo import Bundle
    from rsegen.scene.scene import Scene
    from rsegen.writing.resources import InMemory

F = TypeVar("F", bound=Callable[..., Any])


class Sidecar(ABC):
    """Files of one kind for every map of a run; an instance is what a run was asked for."""

    name: ClassVar[str]
    """Name of the parameter and of the flag."""

    parameter: ClassVar[Any]
    """The parameter's declaration: an annotated type."""

    default: ClassVar[object] = False
    """The value of the parameter with which there are none."""

    rows: ClassVar[Rows | None] = None
    """Rows of names that the help of a command that writes worlds has for it, and their title."""

    @classmethod
    def of(cls, value: Any) -> Sidecar:
        """Return what a value of the parameter asks for."""
        return cls()

    @property
    def in_memory(self) -> Collection[InMemory]:
        """Outputs made in memory for the files of a map, from which the memory of a run is estimated."""
        return ()

    @property
    def notes(self) -> Sequence[str]:
        """Notes for the user before the run, a line each."""
        return ()

    def refuse(self, recipe: Recipe) -> None:  # noqa: B027  # most can be made of all maps
        """Raise a UserError if the files cannot be made of a recipe's maps, or need what is not installed."""

    @abstractmethod
    def files(self, scene: Scene) -> Bundle:
        """Return their content, by path in the map's folder; it is made when it is read."""

    @abstractmethod
    def are_in(self, home: str) -> bool:
        """Return whether the folder of a map has them."""

    def seconds(self, cells: int) -> float:
        """Return about how long they take for a map with this many cells; half a second for a picture or a sheet."""
        return 0.5


@cache
def sidecar_kinds() -> tuple[type[Sidecar], ...]:
    """Return the kinds of sidecars that capabilities bring."""
    return tuple(hooks("sidecars", _problem))


def _problem(kind: object) -> str:
    """Return why something is no kind of sidecar; an empty text if it is one."""
    if not (isinstance(kind, type) and issubclass(kind, Sidecar)) or inspect.isabstract(kind):
        return "is not a subclass of rsegen.writing.sidecars.Sidecar with all its methods"
    if not str(getattr(kind, "name", "")).isidentifier() or not hasattr(kind, "parameter"):
        return "has no name or no parameter"
    return f"has the name of a parameter of recipes: {kind.name}" if kind.name in parameters(Recipe) else ""


def chosen_sidecars(values: Mapping[str, Any]) -> tuple[Sidecar, ...]:
    """Return the sidecars that the values of parameters ask for, by the names of their kinds."""
    return tuple(kind.of(values[kind.name]) for kind in sidecar_kinds() if values.get(kind.name))


def are_complete(sidecars: Iterable[Sidecar], home: str) -> bool:
    """Return whether a map's folder has its world, and all files of these sidecars."""
    has_world = os.path.isfile(os.path.join(home, f"{os.path.basename(home)}.world"))
    return has_world and all(sidecar.are_in(home) for sidecar in sidecars)


def with_sidecars(function: F) -> F:
    """Give a command a declared parameter for every kind of sidecar, in place of `**sidecars` in its signature."""
    shape = inspect.signature(function)
    own = [each for each in shape.parameters.values() if each.kind is not inspect.Parameter.VAR_KEYWORD]
    for kind in sidecar_kinds():
        if kind.name in shape.parameters:
            place = f"{kind.__module__}:{kind.__name__}"
            raise PluginError(f"plug-in {place}: {kind.name!r} is a parameter of rsegen already; rename it")
    added = [
        inspect.Parameter(kind.name, inspect.Parameter.KEYWORD_ONLY, default=kind.default, annotation=kind.parameter)
        for kind in sidecar_kinds()
    ]
    function.__signature__ = shape.replace(parameters=[*own, *added])  # type: ignore[attr-defined]  # PEP 362
    function.__annotations__ = function.__annotations__ | {kind.name: kind.parameter for kind in sidecar_kinds()}
    return function
