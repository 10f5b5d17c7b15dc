"""What a format is: options with their bounds, and the files that it makes of a scene.

A format is one file of this folder with one class: a frozen dataclass whose annotated fields are its options, under
`@register`. Nothing else needs to know of it. Its files are in a folder of its name, inside the map's own.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from typing import ClassVar, NamedTuple, TypeVar

from rsegen.errors import UserError
from rsegen.exporters.scene import Scene
from rsegen.params.contract import Contract, clash
from rsegen.params.registry import Registry
from rsegen.params.sorts import Json, parameters, validate
from rsegen.recipe.recipe import Recipe


class Extra(NamedTuple):
    """What a format needs beyond rsegen itself: pip installs rsegen[name], and the module is there."""

    name: str
    module: str


MESH = Extra("mesh", "trimesh")
MAT = Extra("mat", "scipy")


@dataclass(frozen=True, kw_only=True, slots=True)
class Format(ABC):
    """A way to write a map, with its options. Its docstring says in one line what it is."""

    name: ClassVar[str]
    extra: ClassVar[Extra | None] = None

    def __post_init__(self) -> None:
        validate(self)

    @property
    def bytes_a_cell(self) -> int:
        """Of memory for every cell of a map, at the most, while its files are made."""
        return 300

    @property
    def options(self) -> dict[str, Json]:
        """The value of each option."""
        return {name: getattr(self, name) for name in parameters(type(self))}

    @abstractmethod
    def files(self, scene: Scene) -> Mapping[str, Iterable[bytes]]:
        """The files by their path in the format's folder, each to be read once; the same scene gives the same bytes."""

    def refuse_missing(self) -> None:
        """Raise a UserError where what it needs is not installed."""
        if self.extra and find_spec(self.extra.module) is None:
            needed = f"{self.name} needs {self.extra.module}, which is not installed"
            raise UserError(f"{needed}; pip install 'rsegen[{self.extra.name}]'")


RESERVED = frozenset(
    {"recipe", "target", "file", "map", "to", "output", "force", "resume", "preview", "sheet", "formats", "json"}
    | {"list", "workers", "obstacle", "plugin", "help", "run", *parameters(Recipe)}
)
"""The flags of the commands that write formats, so no option has such a name."""

READING = frozenset({"values", "rounded", "max_height", "invert", "threshold", "size", "unknown"})
"""The flags of `rsegen import`, which writes formats too."""


def _problem(cls: type[Format]) -> str:
    """What is wrong with the name and the options of a plug-in's format."""
    if not (cls.name.isidentifier() and cls.name.islower()):
        return f"has the name {cls.name!r}; give one of small letters, digits and _, as its folder is called so"
    return clash(cls, RESERVED | READING, FORMATS.own()) or ("" if cls() else "cannot be made without options")


FORMATS: Registry[type[Format]] = Registry(
    "format",
    package="rsegen.exporters.formats",
    group="rsegen.formats",
    contract=Contract(base=Format, names=lambda cls: (cls.name,), check=_problem),
)
"""Every format by its name."""

_Format = TypeVar("_Format", bound=type[Format])


def register(cls: _Format) -> _Format:
    """Make a format known by its name."""
    FORMATS.add(cls.name, cls)
    return cls
