"""Sidecars: optional files next to the world of each map, such as a picture or files for other programs.

A capability brings a kind of them as a class, whose name becomes a parameter of `rsegen.generate` and of all that
writes worlds, and so a flag of their commands:

    --preview  --chosen_sidecars-->  Preview()  --files-->  preview.png in the folder of every map
"""

from __future__ import annotations

import inspect
import os
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from functools import cache
from pathlib import PurePosixPath
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, TypeVar

from rsegen.errors import PluginError, shown
from rsegen.params.capabilities import hooks
from rsegen.params.command import HelpText, declare
from rsegen.params.registry import is_own
from rsegen.params.sorts import parameters
from rsegen.recipe.recipe import Recipe

if TYPE_CHECKING:
    from rsegen.gazebo import Bundle
    from rsegen.scene.scene import Scene
    from rsegen.writing.resources import InMemory

RESERVED_FLAGS = frozenset(
    {"recipe", "target", "file", "folder", "map", "to", "output", "force", "resume", "workers", "scheduler", "sync"}
    | {"no_sync", "preview", "sheet", "formats", "obstacle", "json", "quiet", "progress", "dry_run", "plugin", "help"}
    | {"list", "errors", "run", "beside", *parameters(Recipe)}
)
"""Flags and parameters of all that writes maps: nothing that a plug-in adds to them has such a name."""

READING = frozenset(
    {"values", "rounded", "any_heights", "datum_cm", "fill_holes", "size", "cells_per_block", "origin", "rotation"}
    | {"levels", "invert", "threshold", "framed", "camera_cm", "unknown", "topic", "layer"}
)
"""Options of importers, which are flags of `rsegen import`."""

OF_SOME = frozenset(
    {"from", "from_", "by", "robot", "same_field", "recipes", "rows", "columns", "border", "gap", "spots"}
    | {"base_cm", "clouds", "fit", "intrinsics", "up"}
)
"""Flags that only some of the commands that write worlds have, such as series, terrain and scan."""

F = TypeVar("F", bound=Callable[..., Any])


class Sidecar(ABC):
    """Files of one kind for every map of a run; an instance is what a run was asked for."""

    name: ClassVar[str]
    """Name of the parameter and of the flag."""

    parameter: ClassVar[Any]
    """The parameter's declaration: an annotated type."""

    default: ClassVar[object] = False
    """The value of the parameter with which there are none."""

    help_text: ClassVar[HelpText | None] = None
    """The title of a paragraph in the help of commands that write worlds, and what makes its text."""

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

    def lists(self, home: str) -> Bundle:
        """Return the files that list a map's files, made anew with the files that an earlier run left in its folder."""
        return {}

    @abstractmethod
    def are_in(self, home: str) -> bool:
        """Return whether the folder of a map has them."""

    def seconds(self, cells: int) -> float:
        """Return about how long they take for a map with this many cells; half a second for a picture or a sheet."""
        return 0.5


class FileMaker(Protocol):
    """Maker of files of a map: a sidecar, or a format."""

    @property
    def name(self) -> str:
        """The name that users know."""

    def files(self, scene: Scene) -> Mapping[Any, Iterable[bytes]]:
        """Return their content, by path; it is made when it is read."""


def files_of(maker: FileMaker, scene: Scene) -> Bundle:
    """Return the files that are made for a map; PluginError if a plug-in gives none, or, once it is read, no bytes."""
    files: object = maker.files(scene)
    where = f"plug-in {maker.name}: files() gave"
    if not isinstance(files, Mapping):
        raise PluginError(f"{where} {shown(files)}; expected iterables of bytes by their paths")
    for path, content in files.items():
        if not isinstance(path, (str, PurePosixPath)) or not PurePosixPath(path).name or "\0" in str(path):
            raise PluginError(f"{where} {shown(path)} as the path of a file")
        if isinstance(content, (str, bytes)) or not isinstance(content, Iterable):
            raise PluginError(f"{where} {shown(content)} for {path}; expected an iterable of bytes, as in [bytes]")
    if is_own(maker):
        return {PurePosixPath(path): content for path, content in files.items()}
    return {PurePosixPath(path): _bytes(content, f"{where} {path}") for path, content in files.items()}


def _bytes(content: Iterable[object], where: str) -> Iterator[bytes]:
    """Yield what a plug-in gives as the content of a file; a PluginError for what are no bytes."""
    for part in content:
        if not isinstance(part, (bytes, bytearray, memoryview)):
            raise PluginError(f"{where} with {shown(part)} in it; expected bytes")
        yield bytes(part)


@cache
def sidecar_kinds() -> tuple[type[Sidecar], ...]:
    """Return the kinds of sidecars that capabilities bring; of two with one name the first."""
    by_name: dict[str, type[Sidecar]] = {}
    for kind in hooks("sidecars", lambda kind: _problem(kind, by_name)):
        by_name[kind.name] = kind
    return tuple(by_name.values())


def _problem(kind: object, known: Mapping[str, type[Sidecar]]) -> str:
    """Return why something is no kind of sidecar to add to known ones; an empty text if it is one."""
    if not (isinstance(kind, type) and issubclass(kind, Sidecar)) or inspect.isabstract(kind):
        return "is not a subclass of rsegen.writing.sidecars.Sidecar with all its methods"
    if not str(getattr(kind, "name", "")).isidentifier() or not hasattr(getattr(kind, "parameter", 0), "__metadata__"):
        return "has no name, or its parameter is no annotated type"
    if is_own(kind):
        return ""
    flags = declare(kind.name, kind.parameter, kind.default).flags
    for name in (kind.name, *(flag.lstrip("-").replace("-", "_") for flag in flags)):
        if name in RESERVED_FLAGS | READING | OF_SOME:
            return f"has the name {name!r}, which is a parameter or a flag of rsegen; rename it"
        if other := known.get(name):
            return f"has the name {name!r}, which is taken by {other.__module__}:{other.__name__}"
    return ""


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
    added = [
        inspect.Parameter(kind.name, inspect.Parameter.KEYWORD_ONLY, default=kind.default, annotation=kind.parameter)
        for kind in sidecar_kinds()
    ]
    function.__signature__ = shape.replace(parameters=[*own, *added])  # type: ignore[attr-defined]  # PEP 362
    function.__annotations__ = function.__annotations__ | {kind.name: kind.parameter for kind in sidecar_kinds()}
    return function
