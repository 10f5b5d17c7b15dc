"""The files of a data set: which maps are in which file, their names and sizes, and the manifest, which lists them.

    DIR/manifest.json       the recipes, and the size and checksum of every file
    DIR/levels-00000.npy    block levels of the first maps, (maps, n_x, n_y), frames left out
    DIR/metrics-00000.npy   a row of metrics for each of them; or .parquet
    DIR/levels-00001.npy    of the next maps ...

Of several recipes, the maps of the first come first; no shard has maps of two, and all but the last of a recipe have as
many, so a division finds a map (decision 12). All of it follows from the recipes, so no name is ever taken from a file.

The manifest may come from anybody: whatever in it contradicts the recipes is refused. It is the last file that is
written: a data set with a manifest is complete.
"""

from __future__ import annotations

import json
import re
from bisect import bisect_right
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import accumulate
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from rsegen.datasets.difficulty_tiles import refuse_unlike
from rsegen.errors import DatasetDamaged, FileError, ParameterError, inside, shown
from rsegen.field.stepfield import Ints, StepField
from rsegen.input_files import Checksum, checksum_of
from rsegen.measuring.batch import COLUMNS
from rsegen.params.sorts import Choice, Integer, Text, parameters, validate
from rsegen.recipe.building import field_of
from rsegen.recipe.codec import decode, encode, plugin_identities
from rsegen.recipe.map_design import MapDesign
from rsegen.recipe.recipe import Recipe, as_recipes
from rsegen.recipe.recipe_file import recipe_content

CELLS = 1_000_000
"""Cells in a shard, about: a second of work or less, a megabyte."""

MOST = 100_000
"""Shards in a data set at most: the manifest is read as a whole."""

ROW = np.dtype([("map", "<i8"), *((name, "<f4") for name in COLUMNS)])
"""A row of a table of metrics: the index of the map in its recipe, and its metrics."""

_ALIKE = ("chunk_size", "chunks", "unit_cm", "block_width_cm", "boundary", "frame_height_cm")
"""Parameters that all recipes of a data set have in common: what a level is, and where there are frames."""

_MOST_RECIPES = 1000
"""Recipes of a data set at most: each is compared with the first, and the manifest has all of them."""


@dataclass(frozen=True, kw_only=True)
class ShardLayout:
    """Recipes of many maps, how many of them a shard has (0: about a million cells), and the form of the metrics."""

    recipes: Sequence[Recipe]
    shard_maps: Annotated[int, Integer(0, 10**9, unit="maps", help="maps per file; 0: about a million cells")] = 0
    metrics: Annotated[
        str, Choice(("npy", "parquet", "none"), help="form of the table of metrics; parquet needs rsegen[dataset]")
    ] = "npy"

    def __post_init__(self) -> None:
        validate(self)
        object.__setattr__(self, "recipes", as_recipes(self.recipes))
        _check_kinds(self.recipes)
        n_x, n_y = self.grid_shape
        # The last shard of each recipe may be nearly empty, which adds less than one shard per recipe.
        least = -(-self.maps // (MOST - len(self.recipes) + 1))
        object.__setattr__(self, "shard_maps", self.shard_maps or max(CELLS // (n_x * n_y), least))
        if self.shard_maps < least:
            raise ParameterError(
                "shard_maps", f"{self.shard_maps} would make {self.shards} shards; use {least} or more"
            )

    @property
    def grid_shape(self) -> tuple[int, int]:
        """Blocks of a map along x and y."""
        return self.recipes[0].grid.shape

    @property
    def maps(self) -> int:
        """The number of maps."""
        return self._first_places[-1]

    @property
    def shards(self) -> int:
        """The number of shards."""
        return self._first_shards[-1]

    @cached_property
    def _first_places(self) -> list[int]:
        """The place of the first map of each recipe, and behind the last one."""
        return list(accumulate((recipe.maps for recipe in self.recipes), initial=0))

    @cached_property
    def _first_shards(self) -> list[int]:
        """The number of the first shard of each recipe, and behind the last one."""
        return list(accumulate((-(-recipe.maps // self.shard_maps) for recipe in self.recipes), initial=0))

    @property
    def dtype(self) -> np.dtype[np.integer]:
        """The smallest of uint8 and int16 that holds every level that a map of the recipes can have."""
        return np.dtype("u1" if max(recipe.highest_level for recipe in self.recipes) < 2**8 else "<i2")

    @cached_property
    def flat_field(self) -> StepField:
        """A flat field with the frames of the maps: they differ from it in nothing but their levels."""
        return self.field(np.zeros(self.grid_shape, dtype=np.int16))

    def field(self, blocks: Ints) -> StepField:
        """Return the field of a map with these block levels: frames round them, lengths in metres."""
        return field_of(self.recipes[0], blocks.astype(np.int16))

    def recipe_of_shard(self, number: int) -> Recipe:
        """Return the recipe of the maps of a shard."""
        return self.recipes[self._kind(number)]

    def places(self, number: int) -> range:
        """Return the maps of a shard, counted from 0 in the data set."""
        kind = self._kind(number)
        first = self._first_places[kind] + (number - self._first_shards[kind]) * self.shard_maps
        return range(first, min(first + self.shard_maps, self._first_places[kind + 1]))

    def indices(self, number: int) -> range:
        """Return the indices in their recipe of the maps of a shard."""
        places, before = self.places(number), self._first_places[self._kind(number)]
        return self.recipe_of_shard(number).indices[places.start - before : places.stop - before]

    def map_at(self, place: int) -> tuple[Recipe, int]:
        """Return the recipe of a map, and its index in it."""
        kind = self.kind_at(place)
        return self.recipes[kind], self.recipes[kind].indices[place - self._first_places[kind]]

    def kind_at(self, place: int) -> int:
        """Return the number of the recipe of a map."""
        return bisect_right(self._first_places, place) - 1

    def row_at(self, place: int) -> tuple[int, int]:
        """Return the shard of a map, and its row there."""
        kind = self.kind_at(place)
        number, row = divmod(place - self._first_places[kind], self.shard_maps)
        return self._first_shards[kind] + number, row

    def rows_at(self, places: Ints) -> tuple[Ints, Ints]:
        """Return the shards of many maps, and their rows there."""
        kinds = np.searchsorted(self._first_places, places, side="right") - 1
        numbers, rows = np.divmod(places - np.array(self._first_places)[kinds], self.shard_maps)
        return numbers + np.array(self._first_shards)[kinds], rows

    def _kind(self, number: int) -> int:
        """Return the number of the recipe of a shard."""
        return bisect_right(self._first_shards, number) - 1

    def shape(self, number: int) -> tuple[int, int, int]:
        """Shape of the levels of a shard: (maps, n_x, n_y)."""
        return (len(self.places(number)), *self.grid_shape)

    @property
    def bytes_per_map(self) -> int:
        """Bytes of disk that a map needs."""
        n_x, n_y = self.grid_shape
        return n_x * n_y * self.dtype.itemsize + (0 if self.metrics == "none" else ROW.itemsize)

    def names(self, number: int) -> dict[str, str]:
        """Return the names of the files of a shard, by what they hold."""
        table = {} if self.metrics == "none" else {"metrics": f"metrics-{number:05d}.{self.metrics}"}
        return {"levels": f"levels-{number:05d}.npy"} | table


def _check_kinds(recipes: Sequence[Recipe]) -> None:
    """Raise a ParameterError if there are none or too many, if they do not go together, or if two have one name."""
    if not 0 < len(recipes) <= _MOST_RECIPES:
        raise ParameterError("recipes", f"{len(recipes)} of them; use 1 to {_MOST_RECIPES:,}")
    refuse_unlike(recipes, _ALIKE)
    first: dict[str, int] = {}
    for index, recipe in enumerate(recipes):
        if first.setdefault(recipe.name, index) != index:
            problem = f"'{recipe.name}' is the name of recipes[{first[recipe.name]}] too; each needs its own name"
            raise ParameterError(f"recipes[{index}].name", problem)


MANIFEST = "manifest.json"
FORMAT = 3
"""Version of the manifest; another one is refused, and its data set made again."""

AXES = "levels[k, i, j]: map k, cell i along +x, cell j along +y, frames left out; height = level * unit_cm"
_SHA256 = Text(r"[0-9a-f]{64}", "64 hexadecimal digits")
_SIZE = Integer(0, unit="bytes")


@dataclass(frozen=True, kw_only=True, slots=True)
class Shard:
    """The files of one shard by their content: levels and, unless there are none, metrics."""

    number: int
    files: Mapping[str, Checksum]


_DECIDE = frozenset({"version", "generator", "plugins", "maps", "first_map", "obstacles", *parameters(MapDesign)})
"""Keys of a recipe's file that decide its maps."""


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


def identity(layout: ShardLayout) -> dict[str, Any]:
    """Return what decides the bytes of the shards: the header, of whose recipes only what decides the maps.

    Neither how maps are named, described and represented, nor obstacles that are switched off.
    """
    recipes = [
        replace(recipe, obstacles=[obstacle for _, obstacle in recipe.enabled_obstacles]) for recipe in layout.recipes
    ]
    entries = [{key: value for key, value in encode(recipe).items() if key in _DECIDE} for recipe in recipes]
    return header(layout) | {"recipes": entries} | plugin_identities(recipes)


def manifest(layout: ShardLayout, shards: Iterable[Shard]) -> bytes:
    """Return the text of a manifest, one line per shard."""
    lines = [f"  {json.dumps(key)}: {json.dumps(value)}" for key, value in header(layout).items()]
    entries = (
        {
            content: {"file": name, "bytes": shard.files[content].bytes, "sha256": shard.files[content].sha256}
            for content, name in layout.names(shard.number).items()
        }
        for shard in shards
    )
    rows = ",\n".join(f"    {json.dumps(entry)}" for entry in entries)
    return ("{\n" + ",\n".join([*lines, f'  "shards": [\n{rows}\n  ]']) + "\n}\n").encode()


def read_manifest(folder: Path) -> tuple[ShardLayout, list[Shard]]:
    """Return the content of a data set's manifest; FileError without a manifest, ParameterError for a wrong value."""
    path = folder / MANIFEST
    if not path.is_file():
        why = f"has no {MANIFEST}, so it is not a data set of rsegen"
        if any(folder.glob("levels-*.npy")):
            why = "is a data set that is not complete; resume the command that began it"
        raise FileError(f"{folder}: {why}")
    entries = recipe_content(path)
    try:
        if not isinstance(entries, Mapping) or entries.get("dataset") != FORMAT:
            raise ParameterError("", f"is not a manifest of a data set in format {FORMAT}")
        layout, shards = _layout(entries), entries["shards"]
        if not isinstance(shards, Sequence) or len(shards) != layout.shards:
            raise ParameterError("shards", f"are not the {layout.shards} that {layout.maps} maps need")
        return layout, [_shard(layout, number, entry) for number, entry in enumerate(shards)]
    except ParameterError as error:
        raise error.of(str(path)) from None


def _layout(content: Mapping[str, Any]) -> ShardLayout:
    """Return the layout of a manifest; ParameterError if other values of it contradict the recipes."""
    # Recipes, shard_maps and metrics decide everything; the other values only help readers, and have to agree.
    for key in ("recipes", "shard_maps", "metrics", "shards"):
        if key not in content:
            raise ParameterError(key, "is missing")
    entries, recipes = content["recipes"], []
    if not isinstance(entries, list):
        raise ParameterError("recipes", f"{shown(entries)} is not a list of recipes")
    for index, entry in enumerate(entries):
        with inside(f"recipes[{index}]"):
            recipes.append(decode(entry))
    layout = ShardLayout(recipes=recipes, shard_maps=content["shard_maps"], metrics=content["metrics"])
    expected = header(layout)
    for key in ("maps", "shape", "dtype", "axes", "shard_maps"):
        if content.get(key) != expected[key]:
            raise ParameterError(
                key, f"{shown(content.get(key))} does not match the recipes, which give {shown(expected[key])}"
            )
    return layout


def _shard(layout: ShardLayout, number: int, entry: object) -> Shard:
    """Return a shard of a manifest; ParameterError if a file has a wrong name or an impossible size."""
    where, names = f"shards[{number}]", layout.names(number)
    files = {}
    for content, name in names.items():
        part = entry.get(content) if isinstance(entry, Mapping) else None
        if not isinstance(part, Mapping) or part.get("file") != name:
            raise ParameterError(f"{where}.{content}", f"{shown(part)} is not the file {name}")
        files[content] = Checksum(
            bytes=_SIZE.check(f"{where}.{content}.bytes", part.get("bytes")),
            sha256=_SHA256.check(f"{where}.{content}.sha256", part.get("sha256")),
        )
    return Shard(number=number, files=files)


_REPAIR = "the command that made the data set makes it again with resume=True"


def refuse_other_sizes(folder: Path, layout: ShardLayout, shards: Iterable[Shard]) -> None:
    """Raise DatasetDamaged for the first file that is missing, or has another size than the manifest says."""
    for path, part in _files(folder, layout, shards):
        size = path.stat().st_size if path.is_file() else None
        if size != part.bytes:
            problem = "is missing" if size is None else f"has {size} bytes, and the manifest says {part.bytes}"
            advice = f"delete it, and {_REPAIR}" if size else _REPAIR  # an empty file is made again as it is
            raise DatasetDamaged(f"{path}: {problem}; {advice}")


def refuse_other_checksums(folder: Path, layout: ShardLayout, shards: Iterable[Shard]) -> None:
    """Raise DatasetDamaged for the first file with a wrong checksum."""
    for path, part in _files(folder, layout, shards):
        if checksum_of(path) != part:
            raise DatasetDamaged(f"{path}: has changed, its checksum is wrong; delete it, and {_REPAIR}")


def _files(folder: Path, layout: ShardLayout, shards: Iterable[Shard]) -> Iterator[tuple[Path, Checksum]]:
    for shard in shards:
        names = layout.names(shard.number)
        yield from ((folder / names[content], part) for content, part in shard.files.items())


def recipe_of_place(text: str) -> Recipe | None:
    """Return the recipe of the map of a data set that a text names, as DIR#17 does; None for any other text."""
    match = re.fullmatch(r"(.+)#([0-9]{1,19})", text)  # 19 digits: what fits into 64 bits
    if not match:
        return None
    layout, place = read_manifest(Path(match[1]))[0], int(match[2])
    if place >= layout.maps:
        raise ParameterError(text, f"there is no map {place} in the data set; use 0..{layout.maps - 1}")
    recipe, index = layout.map_at(place)
    return recipe.alone(index)
