"""Formats: options with their bounds, and the files that a format makes of a scene.

    Scene --Format.files--> files in a folder of the format's name, inside the map's own

A format is a file of this folder with a class: a frozen dataclass whose annotated fields are its options, under
`@register`. Nothing else needs to know of it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import ClassVar, Literal

from rsegen.errors import ParameterError, UserError
from rsegen.formats import MAT
from rsegen.formats.encoded import as_json
from rsegen.gazebo import Bundle
from rsegen.params.extras import Extra, pip_install
from rsegen.params.registry import Contract, Registry, name_conflict
from rsegen.params.sorts import Json, parameters, validate
from rsegen.recipe.codec import map_json
from rsegen.scene.scene import Scene
from rsegen.writing.sidecars import READING, RESERVED_FLAGS, files_of

Step = Literal["build", "measure", "surface", "mesh"]
"""A step of making a map, by its memory: a field; its metrics; its surface or boxes; a watertight mesh of all of it."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Format(ABC):
    """A way to write a map, with its options. Its docstring says in one line what it is."""

    name: ClassVar[str]
    also: ClassVar[tuple[str, ...]] = ()
    extra: ClassVar[Extra | None] = None
    """The extra without which none of its files can be written."""

    step: ClassVar[Step] = "measure"
    """Step of making a map that needs about as much memory as making its files."""

    mat_file: ClassVar[str] = ""
    """The file that needs scipy, and is left out if that is not installed; empty if no file needs it."""

    def __post_init__(self) -> None:
        validate(self)

    @property
    def array_bytes(self) -> int:
        """Bytes per cell of the largest array that has several values per cell; 0 if none has."""
        return 0

    @property
    def options(self) -> dict[str, Json]:
        """Value of each option."""
        return {name: getattr(self, name) for name in parameters(type(self))}

    @property
    def joins(self) -> str:
        """Folder at the top of its files, if an export of several maps joins them in one folder; else empty."""
        return ""

    @abstractmethod
    def files(self, scene: Scene) -> Mapping[str, Iterable[bytes]]:
        """Return the files by path in the format's folder, each to be read once; equal scenes give equal bytes."""

    @property
    def left_out(self) -> str:
        """Message about the file that is not written as scipy is not installed; empty if all are written."""
        if not self.mat_file or not MAT.is_missing:
            return ""
        return f"{self.name}: {self.mat_file} is left out, as scipy is not installed; {pip_install([MAT.name])}"


_OF_EXPORT = frozenset({"path", "format", "index"})
"""Parameters of `rsegen.export` that no flag has; it takes a format's options too."""


def _problem(cls: type[Format]) -> str:
    """Return the problem of the name and the options of a plug-in's format; an empty text if all is well."""
    if not (cls.name.isidentifier() and cls.name.islower()):
        return f"has the name {cls.name!r}; use one of small letters, digits and _, as its folder is called so"
    return name_conflict(cls, RESERVED_FLAGS | READING | _OF_EXPORT, others=FORMATS.own()) or (
        "" if cls() else "cannot be made without options"
    )


FORMATS: Registry[type[Format]] = Registry(
    "format",
    package="rsegen.formats",
    group="rsegen.formats",
    contract=Contract(base=Format, names=lambda cls: (cls.name,), check=_problem),
    elsewhere={
        "obj": "rsegen generate writes meshes as OBJ",
        "sdf": "rsegen generate writes worlds and models in SDF",
        "world": "rsegen generate writes worlds and models in SDF",
        "gazebo": "rsegen generate writes worlds and models for Gazebo",
    },
)
"""Every format by its name."""

register = FORMATS.register
"""Decorator of a format, which is known by its name then."""


def refuse_unready(formats: Iterable[Format]) -> None:
    """Raise a UserError if a format is given twice, or if packages of formats, all of which it names, are missing."""
    formats = tuple(formats)
    for name, count in Counter(format_.name for format_ in formats).items():
        if count > 1:
            raise ParameterError("formats", f"{name} is given twice")
    lacking = {format_.name: format_.extra for format_ in formats if format_.extra and format_.extra.is_missing}
    if not lacking:
        return
    modules, extras = (dict.fromkeys(getattr(extra, key) for extra in lacking.values()) for key in ("module", "name"))
    need, are = ("needs", "is") if len(lacking) == 1 else ("need", "are" if len(modules) > 1 else "is")
    raise UserError(
        f"{', '.join(lacking)} {need} {', '.join(modules)}, which {are} not installed; {pip_install(extras)}"
    )


def recorded_options(formats: Sequence[Format]) -> dict[str, Json]:
    """Return the content of a map's formats.json: the options of each format, and the plug-in that it is from."""
    return {
        format_.name: format_.options | ({"plugin": str(source)} if (source := FORMATS.source(format_.name)) else {})
        for format_ in formats
    }


def added(scene: Scene, formats: Sequence[Format]) -> Bundle:
    """Return the files that formats add to a map's own, with the list of the formats; none without formats."""
    files: dict[PurePosixPath, Iterable[bytes]] = {
        format_.name / path: content for format_ in formats for path, content in files_of(format_, scene).items()
    }
    return files | ({PurePosixPath("formats.json"): [as_json(recorded_options(formats))]} if formats else {})


def exported(scene: Scene, formats: Sequence[Format]) -> Bundle:
    """Return the files of a map in some formats alone, with the recipe that makes it again."""
    return {PurePosixPath("recipe.json"): [map_json(scene.recipe, scene.index)], **added(scene, formats)}
