"""The manifest of a data set: its recipes, and the size and checksum of every file. Nothing in it is trusted.

While a data set is being made, a record has the same content line by line, with a new line for each shard; when the
last one is made, the manifest replaces it.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rsegen.errors import FileError, ParameterError, inside, shown
from rsegen.io.dataset.layout import ShardLayout
from rsegen.io.recipe_file import content
from rsegen.io.record import WrittenFile
from rsegen.io.text_files import text_of
from rsegen.params.sorts import Integer, Text
from rsegen.recipe.codec import decode, encode
from rsegen.recipe.recipe import Recipe

MANIFEST = "manifest.json"
RECORD = "unfinished.jsonl"
FORMAT, FORMAT_OF_SEVERAL = 1, 2
"""That of one recipe, and that of several."""
AXES = "levels[k, i, j]: map k, cell i along +x, cell j along +y, frames left out; height = level * unit_cm"
LARGEST_MIB = 256
"""MiB of a record at most: that of a hundred million small maps has 5."""

_SHA256 = Text(r"[0-9a-f]{64}", "64 hexadecimal digits")
_SIZE = Integer(0, unit="bytes")


@dataclass(frozen=True, kw_only=True, slots=True)
class Shard:
    """The files of one shard by their content: levels and, unless there are none, metrics."""

    number: int
    files: Mapping[str, WrittenFile]


def header(layout: ShardLayout) -> dict[str, Any]:
    """The manifest without the shards."""
    return {
        **_encoded(layout),
        "maps": layout.maps,
        "shape": list(layout.grid_shape),
        "dtype": layout.dtype.name,
        "axes": AXES,
        "shard_maps": layout.shard_maps,
        "metrics": layout.metrics,
    }


def _encoded(layout: ShardLayout) -> dict[str, Any]:
    if len(layout.recipes) == 1:
        return {"dataset": FORMAT, "recipe": encode(layout.recipes[0])}
    return {"dataset": FORMAT_OF_SEVERAL, "recipes": [encode(recipe) for recipe in layout.recipes]}


def manifest(layout: ShardLayout, shards: Iterable[Shard]) -> bytes:
    """The text of a manifest, one line per shard."""
    lines = [f"  {json.dumps(key)}: {json.dumps(value)}" for key, value in header(layout).items()]
    rows = ",\n".join(f"    {json.dumps(_entry(layout, shard))}" for shard in shards)
    return ("{\n" + ",\n".join([*lines, f'  "shards": [\n{rows}\n  ]']) + "\n}\n").encode()


def record_header(layout: ShardLayout) -> str:
    """The first line of a record."""
    return f"{json.dumps(header(layout))}\n"


def record_entry(layout: ShardLayout, shard: Shard) -> str:
    """The line of a record for one more shard."""
    return f"{json.dumps({'shard': shard.number, **_entry(layout, shard)})}\n"


def read_manifest(folder: Path) -> tuple[ShardLayout, list[Shard]]:
    """The content of a data set's manifest; FileError if there is none, ParameterError if a value is wrong."""
    path = folder / MANIFEST
    if not path.is_file():
        unfinished = (folder / RECORD).is_file()
        why = "is not finished; the command that began it goes on with --resume" if unfinished else "has no " + MANIFEST
        raise FileError(f"{folder}: {why}" + ("" if unfinished else ", so it is not a data set of rsegen"))
    found = content(path)
    try:
        if not isinstance(found, Mapping) or found.get("dataset") not in (FORMAT, FORMAT_OF_SEVERAL):
            raise ParameterError("", f"is not a manifest of a data set in format {FORMAT} or {FORMAT_OF_SEVERAL}")
        layout = _layout(found)
        return layout, _shards(layout, found["shards"])
    except ParameterError as error:
        raise error.of(str(path)) from None


def read_record(folder: Path, layout: ShardLayout) -> list[Shard] | None:
    """The shards in the record of a run that was stopped; None if that run was making another data set.

    An incomplete last line does not count, nor does an incomplete first one.
    """
    path = folder / RECORD
    start, *lines = text_of(path, LARGEST_MIB, "a record of a data set").split("\n")
    if not lines:
        return []
    if not _is_begun_by(start, layout):
        return None
    try:
        found = [json.loads(line) for line in lines[:-1]]
        return [_shard(layout, entry.get("shard"), entry) for entry in found]
    except (AttributeError, RecursionError, ValueError) as error:
        raise FileError(f"{path}: was changed by something else: {error}") from None


def same_maps(one: ShardLayout, other: ShardLayout) -> bool:
    """Whether two data sets have the same files: the same maps of one design, in the same shards."""
    return _content(one) == _content(other)


def _content(layout: ShardLayout) -> tuple[object, ...]:
    maps = [(recipe.design, recipe.indices) for recipe in layout.recipes]
    return maps, layout.shard_maps, layout.metrics


def _is_begun_by(line: str, layout: ShardLayout) -> bool:
    """Whether a record with this first line was begun by this version of rsegen, for the same maps."""
    try:
        found = json.loads(line)
        begun = _layout({**found, "shards": []})
    except (RecursionError, TypeError, ValueError):  # a ParameterError is one
        return False
    generators = [entry["generator"] for entry in _entries(found).values()]
    return generators == [encode(recipe)["generator"] for recipe in layout.recipes] and same_maps(begun, layout)


def _entry(layout: ShardLayout, shard: Shard) -> dict[str, object]:
    names = layout.names(shard.number)
    return {
        what: {"file": names[what], "bytes": part.bytes, "sha256": part.sha256} for what, part in shard.files.items()
    }


def _layout(found: Mapping[str, Any]) -> ShardLayout:
    """The layout of a manifest; ParameterError if other values of it contradict the recipes."""
    for key in (_key(found), "shard_maps", "metrics", "shards"):
        if key not in found:
            raise ParameterError(key, "is missing")
    layout = ShardLayout(
        recipes=[_recipe(where, entry) for where, entry in _entries(found).items()],
        shard_maps=found["shard_maps"],
        metrics=found["metrics"],
    )
    expected = header(layout)
    for key in ("maps", "shape", "dtype", "axes", "shard_maps"):
        if found.get(key) != expected[key]:
            raise ParameterError(
                key, f"{shown(found.get(key))} does not match the {_key(found)}, which gives {shown(expected[key])}"
            )
    return layout


def _key(found: Mapping[str, Any]) -> str:
    return "recipe" if found.get("dataset") == FORMAT else "recipes"


def _entries(found: Mapping[str, Any]) -> dict[str, Any]:
    """The entry of each recipe in a manifest, by where it is."""
    entries = found[_key(found)]
    if _key(found) == "recipe":
        return {"recipe": entries}
    if not isinstance(entries, list) or len(entries) < 2:
        raise ParameterError("recipes", f"{shown(entries)} is not a list of 2 recipes or more")
    return {f"recipes[{number}]": entry for number, entry in enumerate(entries)}


def _recipe(where: str, entry: object) -> Recipe:
    with inside(where):
        return decode(entry)


def _shards(layout: ShardLayout, entries: object) -> list[Shard]:
    if not isinstance(entries, Sequence) or len(entries) != layout.shards:
        raise ParameterError("shards", f"are not the {layout.shards} that {layout.maps} maps need")
    return [_shard(layout, number, entry) for number, entry in enumerate(entries)]


def _shard(layout: ShardLayout, number: object, entry: object) -> Shard:
    """One shard; ParameterError if a file has a wrong name or an impossible size."""
    number = Integer(0, layout.shards - 1).check("shard", number)
    where, names = f"shards[{number}]", layout.names(number)
    files = {}
    for what, name in names.items():
        found = entry.get(what) if isinstance(entry, Mapping) else None
        if not isinstance(found, Mapping) or found.get("file") != name:
            raise ParameterError(f"{where}.{what}", f"{shown(found)} is not the file {name}")
        files[what] = WrittenFile(
            bytes=_SIZE.check(f"{where}.{what}.bytes", found.get("bytes")),
            sha256=_SHA256.check(f"{where}.{what}.sha256", found.get("sha256")),
        )
    return Shard(number=number, files=files)
