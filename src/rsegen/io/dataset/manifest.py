"""The manifest of a data set: its recipes, and the size and checksum of every file. Nothing in it is trusted.

It is the last file that is written: a data set with a manifest is complete.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rsegen.errors import FileError, ParameterError, inside, shown
from rsegen.io.checksums import JOURNAL, Checksum
from rsegen.io.dataset.layout import ShardLayout
from rsegen.io.recipe_file import content
from rsegen.params.sorts import Integer, Text
from rsegen.recipe.codec import decode, encode
from rsegen.recipe.recipe import Recipe

MANIFEST = "manifest.json"
FORMAT = 3
AXES = "levels[k, i, j]: map k, cell i along +x, cell j along +y, frames left out; height = level * unit_cm"
_SHA256 = Text(r"[0-9a-f]{64}", "64 hexadecimal digits")
_SIZE = Integer(0, unit="bytes")


@dataclass(frozen=True, kw_only=True, slots=True)
class Shard:
    """The files of one shard by their content: levels and, unless there are none, metrics."""

    number: int
    files: Mapping[str, Checksum]


def header(layout: ShardLayout) -> dict[str, Any]:
    """Return the manifest without the shards."""
    return {
        "dataset": FORMAT,
        "recipes": [encode(recipe) for recipe in layout.recipes],
        "maps": layout.maps,
        "shape": list(layout.grid_shape),
        "dtype": layout.dtype.name,
        "axes": AXES,
        "shard_maps": layout.shard_maps,
        "metrics": layout.metrics,
    }


def manifest(layout: ShardLayout, shards: Iterable[Shard]) -> bytes:
    """The text of a manifest, one line per shard."""
    lines = [f"  {json.dumps(key)}: {json.dumps(value)}" for key, value in header(layout).items()]
    rows = ",\n".join(f"    {json.dumps(_entry(layout, shard))}" for shard in shards)
    return ("{\n" + ",\n".join([*lines, f'  "shards": [\n{rows}\n  ]']) + "\n}\n").encode()


def read_manifest(folder: Path) -> tuple[ShardLayout, list[Shard]]:
    """The content of a data set's manifest; FileError if there is none, ParameterError if a value is wrong."""
    path = folder / MANIFEST
    if not path.is_file():
        unfinished = (folder / JOURNAL).is_file()
        why = "is not finished; the command that began it goes on with --resume" if unfinished else "has no " + MANIFEST
        raise FileError(f"{folder}: {why}" + ("" if unfinished else ", so it is not a data set of rsegen"))
    found = content(path)
    try:
        if not isinstance(found, Mapping) or found.get("dataset") != FORMAT:
            raise ParameterError("", f"is not a manifest of a data set in format {FORMAT}")
        layout = _layout(found)
        return layout, _shards(layout, found["shards"])
    except ParameterError as error:
        raise error.of(str(path)) from None


def _entry(layout: ShardLayout, shard: Shard) -> dict[str, object]:
    names = layout.names(shard.number)
    return {
        what: {"file": names[what], "bytes": part.bytes, "sha256": part.sha256} for what, part in shard.files.items()
    }


def _layout(found: Mapping[str, Any]) -> ShardLayout:
    """Return the layout of a manifest; ParameterError if other values of it contradict the recipes."""
    for key in ("recipes", "shard_maps", "metrics", "shards"):
        if key not in found:
            raise ParameterError(key, "is missing")
    entries = found["recipes"]
    if not isinstance(entries, list):
        raise ParameterError("recipes", f"{shown(entries)} is not a list of recipes")
    layout = ShardLayout(
        recipes=[_recipe(f"recipes[{number}]", entry) for number, entry in enumerate(entries)],
        shard_maps=found["shard_maps"],
        metrics=found["metrics"],
    )
    expected = header(layout)
    for key in ("maps", "shape", "dtype", "axes", "shard_maps"):
        if found.get(key) != expected[key]:
            raise ParameterError(
                key, f"{shown(found.get(key))} does not match the recipes, which give {shown(expected[key])}"
            )
    return layout


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
        files[what] = Checksum(
            bytes=_SIZE.check(f"{where}.{what}.bytes", found.get("bytes")),
            sha256=_SHA256.check(f"{where}.{what}.sha256", found.get("sha256")),
        )
    return Shard(number=number, files=files)
