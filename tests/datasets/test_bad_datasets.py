"""Manifests from strangers: no name in them is followed, no size believed, no array read that is not what it says."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rsegen import Dataset
from rsegen.datasets.layout import ROW
from rsegen.datasets.reading import read_parquet
from rsegen.errors import FileError
from tests.support.complaints import MANY_DIGITS, OBSTACLE, Refused, exit_code, the_line

MADE = ["dataset", *OBSTACLE, "--maps", "10", "--shard-maps", "4"]

MANIFESTS: Mapping[str, tuple[dict[str, Any], str]] = {
    "another format": ({"dataset": 2}, "is not a manifest of a data set in format 3"),
    "a format in a list": ({"dataset": [1]}, "is not a manifest of a data set in format 3"),
    "no list of recipes": ({"recipes": "all"}, "recipes: 'all' is not a list of recipes"),
    "recipes that are none": ({"recipes": [1, 2]}, "recipes[0]: 1 is not a recipe"),
    "no recipe": ({"recipes": []}, "recipes: 0 of them; use 1 to 1,000"),
    "a recipe that cannot be": ({"recipes.0.unit_cm": -1}, "recipes[0].unit_cm: -1 is outside"),
    "more maps than the recipe": ({"maps": 11}, "maps: 11 does not match the recipes, which give 10"),
    "more maps than there are": ({"recipes.0.maps": MANY_DIGITS}, "recipes[0].maps: 999"),
    "more maps than shards": (
        {"recipes.0.maps": 10**15, "maps": 10**15},
        "shard_maps: 4 would make 250000000000000 shards",
    ),
    "one map more": ({"recipes.0.maps": 13, "maps": 13}, "shards: are not the 4 that 13 maps need"),
    "another shape": ({"shape": [10**9, 10**9]}, "shape: [1000000000, 1000000000] does not match"),
    "another sort of number": ({"dtype": "object"}, "dtype: 'object' does not match"),
    "axes the other way round": ({"axes": "levels[j, i]"}, "axes: 'levels[j, i]' does not match"),
    "shards of no map": ({"shard_maps": 0}, "shard_maps: 0 does not match"),
    "shards in a word": ({"shard_maps": "few"}, "shard_maps: 'few' is not a whole number"),
    "metrics in a form unknown": ({"metrics": "pickle"}, "metrics: 'pickle' is not one of npy, parquet, none"),
    "no shards": ({"shards": []}, "shards: are not the 3 that 10 maps need"),
    "shards in a word ": ({"shards": "abc"}, "shards[0].levels: an empty value is not the file levels-00000.npy"),
    "a path that leads out": ({"shards.1.levels.file": "../../etc/passwd"}, "is not the file levels-00001.npy"),
    "another shard's file": ({"shards.1.levels.file": "levels-00000.npy"}, "is not the file levels-00001.npy"),
    "a size below nothing": ({"shards.1.levels.bytes": -1}, "shards[1].levels.bytes: -1 is not 0 or more"),
    "a size in a word": ({"shards.1.levels.bytes": "many"}, "shards[1].levels.bytes: 'many' is not a whole number"),
    "no checksum": ({"shards.1.levels.sha256": "0"}, "shards[1].levels.sha256: invalid value '0': expected"),
}


def changed(found: Any, place: str, value: object) -> None:
    *way, last = place.split(".")
    for key in way:
        found = found[int(key) if key.isdecimal() else key]
    found[last] = value


@pytest.mark.parametrize(("changes", "words"), MANIFESTS.values(), ids=MANIFESTS)
def test_a_manifest(refused: Refused, changes: dict[str, Any], words: str) -> None:
    assert exit_code(*MADE, "-o", "set") == 0
    path = Path("set/manifest.json")
    found = json.loads(path.read_text("utf-8"))
    for place, value in changes.items():
        changed(found, place, value)
    path.write_text(json.dumps(found, indent=1), "utf-8")
    assert words in refused("dataset", "--verify", "set")


def test_a_size_that_is_not_the_file_s(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code(*MADE, "-o", tmp_path) == 0
    path = tmp_path / "manifest.json"
    found = json.loads(path.read_text("utf-8"))
    changed(found, "shards.1.levels.bytes", 10**18)
    path.write_text(json.dumps(found), "utf-8")
    assert exit_code("dataset", "--verify", tmp_path) == 1
    assert "levels-00001.npy: has 528 bytes" in the_line(capsys.readouterr().err)


@pytest.mark.parametrize("text", ["", "[]", "{", "null", '{"dataset": 1}', "[" * 100_000, '{"a": 1, "a": 2}'])
def test_an_invalid_manifest_is_refused(refused: Refused, text: str) -> None:
    Path("set").mkdir()
    Path("set/manifest.json").write_text(text)
    assert "set/manifest.json" in refused("info", "set#0")


def test_a_map_beyond(refused: Refused) -> None:
    assert exit_code(*MADE, "-o", "set") == 0
    for index in ("10", "9" * 19):
        assert "there is no map" in refused("info", f"set#{index}")
    assert "No such file" in refused("info", f"set#{'9' * 30}")
    assert "DIR#0" in refused("info", "set")
    assert "DIR#0" in refused("generate", "set", "-o", "out")


def test_several_recipes(refused: Refused) -> None:
    assert "recipes[1].name: 'peak' is the name of recipes[0] too" in refused("dataset", "peak", "peak", "-o", "set")
    assert "recipes[1].chunks: (5, 1), and (1, 1)" in refused("dataset", "peak", "five-pallet-dash", "-o", "set")
    assert "No such file" in refused("dataset", "peak", "hill.yaml", "-o", "set")
    assert exit_code("dataset", "peak", "diagonal-barrier", "--maps", "1", "-o", "set") == 0
    assert "there is no map 2 in the data set; use 0..1" in refused("info", "set#2")
    assert "--verify: needs no recipe" in refused("dataset", "peak", "--verify", "set")
    assert "--verify: needs no recipe" in refused("dataset", "--maps", "5", "--verify", "set")
    assert "--shard-maps: is for a data set that is made" in refused("dataset", "--verify", "set", "--shard-maps", "3")
    assert "--force: is for a data set that is made" in refused("dataset", "--verify", "set", "--force")
    assert "--no-sync: is for a data set that is made" in refused("dataset", "--verify", "set", "--no-sync")
    assert "--rebuild: is for --verify DIR" in refused("dataset", "peak", "--rebuild", "3", "-o", "other")


def test_a_series_is_no_unfinished_data_set(refused: Refused) -> None:
    assert exit_code("series", *OBSTACLE, "--maps", "2", "-o", "series") == 0
    assert "series: has no manifest.json, so it is not a data set of rsegen" in refused("info", "series#0")


def test_an_existing_or_unfinished_data_set_is_refused(refused: Refused) -> None:
    assert exit_code(*MADE, "-o", "set") == 0
    assert "set: a data set exists already; use --resume" in refused(*MADE, "-o", "set")
    Path("set/manifest.json").unlink()
    assert "set: is a data set that is not complete; resume the command that began it" in refused("info", "set#0")
    Path("set/.rsegen.jsonl").unlink()
    assert "set: is not empty, and not a data set" in refused(*MADE, "--resume", "-o", "set")


@pytest.mark.parametrize(
    "array",
    [
        np.zeros((4, 10, 10), dtype=np.int8),
        np.zeros((4, 100, 1), dtype=np.uint8),
        np.array([{}], dtype=object),
        None,
    ],
    ids=["signed", "another shape", "objects", "no array"],
)
def test_an_array_of_another_sort_is_not_read(tmp_path: Path, array: np.ndarray[Any, Any] | None) -> None:
    assert exit_code(*MADE, "-o", tmp_path) == 0
    found, path = Dataset(tmp_path), tmp_path / "levels-00001.npy"
    if array is None:
        path.write_bytes(b"x" * path.stat().st_size)
    else:
        np.save(path, array, allow_pickle=True)
    with pytest.raises(FileError, match=r"levels-00001\.npy: "):
        found[5]


def test_parquet_without_pyarrow(refused: Refused, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    assert "pip install 'pyarrow" in refused(*MADE, "--metrics", "parquet", "-o", "set")


def test_more_than_the_disk_has(refused: Refused) -> None:
    assert "of disk, " in refused("dataset", *OBSTACLE, "--maps", "1000000000000", "-o", "set")


def test_maps_larger_than_memory(refused: Refused) -> None:
    assert "chunks: a map of" in refused("dataset", *OBSTACLE, "--chunks", "1000000", "-o", "set")


def test_a_table_of_metrics_with_other_types(tmp_path: Path) -> None:
    pyarrow = pytest.importorskip("pyarrow", reason="pyarrow is not installed")
    from pyarrow import parquet

    names = [name for name in ROW.names or () if name != "map"]
    parquet.write_table(pyarrow.table({"map": [0], **{name: ["x" * 1000] for name in names}}), tmp_path / "a.parquet")
    with pytest.raises(FileError, match=r"a\.parquet: is not the metrics of 1 maps"):
        read_parquet(tmp_path / "a.parquet", 1)


@pytest.mark.parametrize("name", ["manifest.json", ".rsegen.jsonl", "levels-00000.npy", "metrics-00000.npy"])
def test_a_pipe_in_a_data_set_is_no_file_of_it(tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str) -> None:
    folder = tmp_path / "set"
    assert exit_code(*MADE, "-o", folder) == 0
    (folder / name).unlink(missing_ok=True)
    os.mkfifo(folder / name)
    capsys.readouterr()
    code = exit_code("dataset", "--verify", folder)
    assert code == {"manifest.json": 2, ".rsegen.jsonl": 0}.get(name, 1)
    assert code == 0 or str(folder) in the_line(capsys.readouterr().err)
