"""A map in the formats of other programs: every file of this folder with a `@register` is one, found by being there.

Scene --Format.files--> files in a folder of the format's name
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Sequence
from pathlib import PurePosixPath

from rsegen.errors import ParameterError
from rsegen.exporters.formats.base import FORMATS, Format, Step, refuse_missing
from rsegen.exporters.gazebo import Bundle
from rsegen.exporters.scene import Scene
from rsegen.params.extras import Extra
from rsegen.params.sorts import Json
from rsegen.recipe.codec import map_json


def format_named(name: str, where: str = "formats") -> type[Format]:
    """The format of a name, or an UnknownName that lists the known ones."""
    return FORMATS.named(name, where)


def refuse_unready(formats: Iterable[Format]) -> None:
    """Raise a UserError if one of the formats is given twice, or some need what is not installed."""
    formats, seen = tuple(formats), set()
    for each in formats:
        if each.name in seen:
            raise ParameterError("formats", f"{each.name} is given twice")
        seen.add(each.name)
    refuse_missing(formats)


def options(formats: Sequence[Format]) -> dict[str, Json]:
    """What formats.json of a map says: the options of each format that is there, and the plug-in that it is from."""
    return {each.name: {**each.options, **_origin(each.name)} for each in formats}


def added(scene: Scene, formats: Sequence[Format]) -> Bundle:
    """What formats add to the files of a map; nothing where there are none."""
    return dict(_added(scene, formats))


def exported(scene: Scene, formats: Sequence[Format]) -> Bundle:
    """The files of a map in these formats alone, with the recipe that makes it again."""
    return {PurePosixPath("recipe.json"): [map_json(scene.recipe, scene.index)], **added(scene, formats)}


def _origin(name: str) -> dict[str, Json]:
    source = FORMATS.source(name)
    return {"plugin": str(source)} if source else {}


def _added(scene: Scene, formats: Sequence[Format]) -> Iterator[tuple[PurePosixPath, Iterable[bytes]]]:
    for each in formats:
        for path, content in each.files(scene).items():
            yield PurePosixPath(each.name) / path, content
    if formats:
        yield PurePosixPath("formats.json"), [(json.dumps(options(formats), indent=2) + "\n").encode()]


__all__ = [
    "FORMATS",
    "Extra",
    "Format",
    "Step",
    "added",
    "exported",
    "format_named",
    "options",
    "refuse_unready",
    "summary",
]
