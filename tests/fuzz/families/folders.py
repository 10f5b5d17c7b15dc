"""Folders that rsegen wrote, and that something else has changed: maps and data sets."""

from __future__ import annotations

import json
import random

from tests.fuzz import seeds
from tests.fuzz.case import Case, Content, Special
from tests.fuzz.damage import damaged_bytes, damaged_npy, damaged_text
from tests.fuzz.families.recipes import written

_FLAGS = ["--maps", "2", "--chunk-size", "4", "--seed", "7", "--workers", "1", "--obstacle", "random levels=3"]
_MAP_COMMANDS: tuple[tuple[list[str], tuple[str, ...]], ...] = (
    (["info", "maps"], ()),
    (["info", "maps/rse_0000"], ()),
    (["info", "maps", "--map", "1"], ()),
    (["metrics", "maps"], ()),
    (["generate", *_FLAGS, "--formats", "heightmap,ply", "--resume", "-o", "maps"], ("maps",)),
    (["generate", *_FLAGS, "--formats", "heightmap", "--resume", "-o", "maps"], ("maps",)),
    (["generate", *_FLAGS, "--resume", "-o", "maps"], ("maps",)),
    (["generate", *_FLAGS, "--force", "-o", "maps"], ("maps",)),
    (["generate", *_FLAGS, "-o", "maps"], ("maps",)),
    (["generate", "maps/rse_0001", "--workers", "1", "-o", "out"], ("out",)),
    (["export", "maps", "--to", "stl", "--workers", "1", "-o", "maps"], ("maps",)),
    (["export", "maps", "--to", "stl,heightmap", "--workers", "1", "--force", "-o", "maps"], ("maps",)),
    (["export", "maps", "--to", "stl", "--workers", "1", "-o", "out"], ("out",)),
    (["open", "maps", "--print"], ()),
    (["open", "maps/rse_0000/rse_0000.world", "--print"], ()),
    (["drive", "maps/rse_0000", "--duration", "1"], ()),
    (["spawn", "maps"], ()),
    (["respawn", "maps"], ()),
)
_SET = [
    "dataset",
    "--maps",
    "4",
    "--chunk-size",
    "4",
    "--seed",
    "7",
    "--shard-maps",
    "2",
    "--obstacle",
    "random levels=3",
]
_SET += ["--workers", "1", "-o", "set", "--metrics"]


def damaged_map(rng: random.Random) -> Case:
    """Two maps on disk, of which something is damaged."""
    files = _damaged(rng, dict(seeds.map_folder()))
    argv, outputs = rng.choice(_MAP_COMMANDS)
    return Case(family="map", argv=tuple(argv), files=files, outputs=outputs)


def damaged_data_set(rng: random.Random) -> Case:
    """A data set of one recipe or two, whole or unfinished, of which something is damaged."""
    metrics = rng.choice(("npy", "npy", "npy", "none", "parquet"))
    start = rng.choices((seeds.data_set, seeds.data_set_of_several, seeds.unfinished), (4, 3, 3))[0]
    files = _damaged(rng, dict(start(metrics)))
    commands: list[tuple[list[str], tuple[str, ...]]] = [
        (["dataset", "--verify", "set"], ()),
        (["dataset", "--verify", "set", "--rebuild", "0"], ()),
        (["info", "set#0"], ()),
        (["generate", "set#3", "--workers", "1", "-o", "out"], ("out",)),
        ([*_SET, metrics, "--resume"], ("set",)),
        ([*_SET, metrics, "--force"], ("set",)),
        ([*_SET, metrics], ("set",)),
        (["@dataset", "set"], ()),
        (["@dataset", "set"], ()),
    ]
    argv, outputs = rng.choice(commands)
    return Case(family="data set", argv=tuple(argv), files=files, outputs=outputs)


def _damaged(rng: random.Random, files: dict[str, bytes]) -> dict[str, Content]:
    found: dict[str, Content] = dict(files)
    for _ in range(1 + (rng.random() < 0.2)):
        _damage(rng, found)
    return found


def _damage(rng: random.Random, files: dict[str, Content]) -> None:
    """Something of one file: the small ones that are read most often."""
    texts = [name for name in files if name.endswith((".json", ".jsonl"))]
    name = rng.choice(texts) if texts and rng.random() < 0.7 else rng.choice(sorted(files))
    content = files.pop(name)
    if not isinstance(content, bytes) or rng.random() < 0.05:
        return
    if rng.random() < 0.05:
        kinds = (
            Special(kind="folder"),
            Special(kind="fifo"),
            Special(kind="link", target=rng.choice(("/dev/zero", "loop", "/"))),
        )
        files[name] = rng.choice(kinds)
        return
    files[name] = _damaged_file(rng, name, content)


def _damaged_file(rng: random.Random, name: str, content: bytes) -> bytes:
    if name.endswith(".json"):
        return written(rng, _tree(content), yaml_=False)
    if name.endswith(".jsonl"):
        lines = content.splitlines(keepends=True)
        number = rng.randrange(len(lines))
        lines[number] = written(rng, _tree(lines[number]), yaml_=False) + b"\n" * (rng.random() < 0.8)
        return b"".join(lines)
    if name.endswith(".npy"):
        return damaged_npy(rng, content) if rng.random() < 0.7 else damaged_bytes(rng, content)
    return damaged_bytes(rng, content) if rng.random() < 0.6 else damaged_text(rng, content)


def _tree(content: bytes) -> object:
    try:
        return json.loads(content)
    except (ValueError, RecursionError):  # it is damaged already
        return {}
