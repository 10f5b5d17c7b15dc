"""The bytes of every example, shape and format, as hashes in bytes.json: whatever the code becomes, these stay.

`python tests/golden/test_bytes.py` records them anew. A line more is a new case; a line that has changed means that
users' bytes change, which is for CHANGELOG.md.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from hashlib import blake2b
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest

import rsegen
from rsegen import (
    DiagonalBarrier,
    HorizontalBarrier,
    Matrix,
    NormalRandom,
    Pallet,
    Peak,
    Pit,
    Rails,
    Random,
    Recipe,
    Stairs,
    Stones,
)
from rsegen.params.sorts import ANYWHERE

FILE = Path(__file__).with_name("bytes.json")
RECORDED: Mapping[str, str] = json.loads(FILE.read_text("utf-8")) if FILE.is_file() else {}

Case = Callable[[Path], object]
"""Fills an empty folder."""

PATTERNS = ("flat", "hill", "diagonal")
ROUGH = Random(levels=5)
TWIN = Peak(levels=4, softness=50, blend="add")

RECIPES: Mapping[str, Recipe] = {
    "random": Recipe(seed=1, chunk_size=4, chunks=(2, 1), obstacles=[Random(levels=4, weights=(3, 2, 2, 1))]),
    "normal": Recipe(
        seed=2,
        chunk_size=6,
        boundary="outer",
        frame_height_cm=12.34,
        obstacles=[NormalRandom(levels=6, softness=20, spread=0.3)],
    ),
    "peak": Recipe(
        name="2nd.Peak-field",  # neither USD nor ROS has such names
        seed=3,
        maps=2,
        chunk_size=4,
        chunks=(2, 2),
        boundary="none",
        unit_cm=3.3,
        block_width_cm=7.5,
        obstacles=[
            HorizontalBarrier(levels=3, softness=30),
            Peak(levels=5, softness=60, blend="add"),
            Peak(levels=4, first=(1, 1), last=(3, 3), blend="max"),
        ],
    ),
    "diagonal": Recipe(
        seed=4,
        maps=2,
        first_map=9,
        chunk_size=5,
        chunks=(1, 2),
        obstacles=[
            Random(levels=3),
            DiagonalBarrier(levels=4, softness=30),
            DiagonalBarrier(levels=3, first=("random", 0), last=(4, "random"), blend="min"),
        ],
    ),
    "pallet": Recipe(
        seed=5,
        chunk_size=5,
        chunks=(3, 1),
        obstacles=[Pallet(levels=5, pattern=PATTERNS, symmetry="symmetric", turns=(0, 1, 2))],
    ),
    "matrix": Recipe(  # with blocks that touch along an edge alone, cells left alone, and empty pallets
        seed=6,
        chunk_size=2,
        chunks=(2, 3),
        boundary="none",
        obstacles=[
            Matrix(levels=4, rows=("3 0", "0 1")),
            Matrix(levels=3, rows=(". 2 1",), first=(3, 2), last=(0, 3)),
        ],
    ),
    "difficulty": Recipe(
        seed=7,
        chunk_size=6,
        difficulty=0.5,
        frame_height_cm=0,
        obstacles=[ROUGH, Peak(levels=7, softness=80, first=(1, 1), last=(4, 4))],
    ),
    "constraints": Recipe(
        seed=8,
        chunk_size=4,
        chunks=(2, 1),
        boundary="outer",
        unit_cm=5,
        frame_height_cm=5,
        max_step=3,
        crossable_by=(10, 10, 15),
        inventory=(9, 7, 5, 2),
        obstacles=[Random(levels=6)],
    ),
    "deck": Recipe(
        seed=13,
        chunk_size=12,
        chunks=(2, 2),
        boundary="outer",
        ground_level=3,
        frame_height_cm=30,
        difficulty=0.8,
        obstacles=[
            Stairs(levels=4, first=(0, 0), last=(11, 11)),
            Stones(levels=4, uneven=2, first=(12, 0), last=(23, 11)),
            Pit(levels=4, gap_width=3, beam_width=2, first=(0, 12), last=(11, 23)),
            Rails(levels=3, first=(12, 12), last=(23, 23)),
            Stairs(levels=3, direction="down", shape="y", first=ANYWHERE, last=ANYWHERE, blend="add"),
        ],
    ),
    "friction and colours": Recipe(
        seed=9,
        chunk_size=3,
        chunks=(2, 1),
        friction=0.8,
        frame_friction=0.3,
        level_friction=(0.5, 0.8, 1.25),
        frame_colour="#203040",
        level_colours=("#ff0000", "#00FF7f"),
        obstacles=[ROUGH],
    ),
}

COUNTED = Random(levels=4, counts=(5, 8, 8, 4), max_step=2)
LEVELS: Mapping[str, Recipe] = {
    **RECIPES,
    "pallet": replace(RECIPES["pallet"], chunk_size=10),  # the smaller ones are slow to arrange
    "twins": Recipe(
        seed=10, chunk_size=5, boundary="none", obstacles=[ROUGH, TWIN, TWIN, replace(ROUGH, blend="min"), TWIN]
    ),
    "counted": Recipe(seed=11, chunk_size=5, obstacles=[COUNTED]),
}
HIGH = Recipe(seed=12, maps=5, chunk_size=4, obstacles=[Random(levels=300)])

SHAPES: Mapping[str, tuple[Any, ...]] = {
    "mesh_type": ("single", "multi", "pallet"),
    "mesh": ("merged", "watertight", "blocks"),
    "collision": ("mesh", "boxes", "blocks"),
    "simulator": ("both", "classic"),
    "tile": (0, 3),
}

LOOKS: Mapping[str, tuple[Any, ...]] = {
    "look": ("levels", "wood", "friction"),
    "mesh_type": ("single", "multi", "pallet"),
}

OPTIONS: Mapping[str, tuple[dict[str, Any], ...]] = {
    "heightmap": ({"pixels": 3},),
    "mjcf": ({"shape": "mesh"}, {"shape": "hfield"}, {"shape": "hfield", "pixels": 2}),
    "occupancy": ({"climb_cm": 6.6, "pixels": 2},),
    "posture": ({"per_block": 2, "climb_cm": 6.6, "clearance_cm": 30},),
    "usd": ({"binary": True},),
}
"""Beside the default ones, which every format is tried with."""


def _examples() -> Iterator[tuple[str, Case]]:
    for path in sorted(Path(rsegen.__file__).parent.rglob("examples/*.yaml")):
        recipe = rsegen.load(path)
        yield f"example {path.stem}", partial(rsegen.generate, replace(recipe, maps=min(recipe.maps, 2)))


def _shapes() -> Iterator[tuple[str, Case]]:
    """Every shape that models may have."""
    for (name, recipe), values in product(RECIPES.items(), product(*SHAPES.values())):
        try:
            shaped = replace(recipe, **dict(zip(SHAPES, values, strict=True)))
        except rsegen.UserError:
            continue
        yield f"{name}: {' '.join(map(str, values))}", partial(rsegen.generate, shaped)


def _looks() -> Iterator[tuple[str, Case]]:
    """Textures, with shadows and a sky."""
    for values in product(*LOOKS.values()):
        recipe = replace(
            RECIPES["friction and colours"], **dict(zip(LOOKS, values, strict=True)), shadows=True, sky=True
        )
        yield f"looks: {' '.join(values)}", partial(rsegen.generate, recipe)


def _formats() -> Iterator[tuple[str, Case]]:
    for name, cls in rsegen.FORMATS.items():
        for options in ({}, *OPTIONS.get(name, ())):
            told = " ".join([name, *(f"{key}={value}" for key, value in options.items())])
            for of in ("peak", "matrix", "deck", "friction and colours"):
                if options.get("shape") != "hfield" or not RECIPES[of].level_friction:  # it has but one
                    yield f"{of}: {told}", partial(_exported, RECIPES[of], cls(**options))
    every = [cls() for cls in rsegen.FORMATS.values()]
    yield "normal: world and every format", partial(rsegen.generate, RECIPES["normal"], formats=every)


def _levels() -> Iterator[tuple[str, Case]]:
    for name, recipe in LEVELS.items():
        yield f"{name}: levels of 50 maps", partial(_built, recipe)


def _datasets() -> Iterator[tuple[str, Case]]:
    for name, metrics in product(("diagonal", "constraints"), ("npy", "parquet", "none")):
        made = partial(rsegen.make_dataset, replace(RECIPES[name], maps=8), metrics=metrics, shard_maps=3)
        yield f"{name}: data set, metrics {metrics}", made
    yield "high: data set", partial(rsegen.make_dataset, HIGH)


def _sheets() -> Iterator[tuple[str, Case]]:
    """As tables; their PDF has fonts in it."""
    for name in ("normal", "pallet", "deck", "constraints"):
        yield f"{name}: sheet", partial(_listed, RECIPES[name])


def _exported(recipe: Recipe, format_: Any, folder: Path) -> None:
    rsegen.export_maps([recipe], folder, [format_])


def _built(recipe: Recipe, folder: Path) -> None:
    np.save(folder / "levels.npy", np.stack([rsegen.build(recipe, index).levels for index in range(50)]))


def _listed(recipe: Recipe, folder: Path) -> None:
    lines = rsegen.sheet(rsegen.compose(recipe), format="csv").splitlines(keepends=True)
    (folder / "sheet.csv").write_bytes(b"".join(line for line in lines if not line.startswith(b"# rsegen ")))


CASES: Mapping[str, Case] = dict(
    case for cases in (_examples, _shapes, _looks, _formats, _levels, _datasets, _sheets) for case in cases()
)

LEFT_OUT = {"recipe.json", "formats.json", "manifest.json", ".rsegen.jsonl"}
"""Files that make a map again, with rsegen's version and perhaps new words, and the checksums of them."""

_RECIPE_TEXT = re.compile(rb'\n  "(generator": "[^"]*"|recipe": \{.*?\n  \}),?', re.DOTALL)
"""The same among the facts of arrays, heightmap and posture."""


def _without_recipe(path: Path) -> bytes:
    return _RECIPE_TEXT.sub(b"", path.read_bytes())


def _pixels(path: Path) -> bytes:
    """A compressed image has other bytes with another zlib."""
    from PIL import Image

    with Image.open(path) as image:
        return f"{image.mode} {image.size} ".encode() + image.tobytes()


def _meshes(path: Path) -> bytes:
    """All of a GLB but how its nodes hang together, which other versions of trimesh have otherwise."""
    content = path.read_bytes()
    end = 20 + int.from_bytes(content[12:16], "little")
    head = json.loads(content[20:end])
    nodes = sorted((node["name"], node["mesh"]) for node in head["nodes"] if "mesh" in node)
    kept = {key: value for key, value in head.items() if key not in ("asset", "nodes", "scenes")}
    return repr((nodes, kept)).encode() + content[end:]


def _usd_text(path: Path) -> bytes:
    """The binary form has the version that the library gave that form in it."""
    from pxr import Sdf

    return bytes(Sdf.Layer.OpenAsAnonymous(str(path)).ExportToString(), "utf-8")


def _columns(path: Path) -> bytes:
    """Parquet has the version of pyarrow in it."""
    from pyarrow import parquet

    table = parquet.read_table(path)
    return repr([(name, str(table[name].type), table[name].to_pylist()) for name in table.column_names]).encode()


_CONTENTS: Mapping[str, Callable[[Path], bytes]] = {
    ".glb": _meshes,
    ".json": _without_recipe,
    ".parquet": _columns,
    ".png": _pixels,
    ".usdc": _usd_text,
}
"""Parts of files that count, by the ends of names; of all others every byte. Other libraries write MAT, PLY, STL
and USDA too, but nothing there tells their versions.
"""


def fingerprint(folder: Path) -> str:
    """A hash of all paths in a folder and their content."""
    found = blake2b(digest_size=16)
    files = {path.relative_to(folder).as_posix(): path for path in folder.rglob("*") if path.is_file()}
    for name, path in sorted(files.items()):
        if path.name not in LEFT_OUT:
            content = _CONTENTS.get(path.suffix, Path.read_bytes)(path)
            found.update(f"{name}\n{len(content)}\n".encode() + content)
    return found.hexdigest()


def test_every_case_is_recorded() -> None:
    assert CASES.keys() == RECORDED.keys()


@pytest.mark.parametrize("case", CASES)
def test_the_bytes_equal_the_recorded_ones(case: str, tmp_path: Path) -> None:
    CASES[case](tmp_path)
    assert fingerprint(tmp_path) == RECORDED[case]


def record() -> None:
    """Write bytes.json anew, a case a line."""
    found = {}
    for name, case in CASES.items():
        with TemporaryDirectory() as folder:
            case(Path(folder))
            found[name] = fingerprint(Path(folder))
    FILE.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8", newline="\n")


if __name__ == "__main__":
    record()
