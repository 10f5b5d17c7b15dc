"""A data set of several recipes: the maps of each as alone, in shards of their own, and a recipe a column of tiles."""

from __future__ import annotations

import json
import pickle
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rsegen
from rsegen import Dataset, Peak, Random, Recipe, make_dataset
from rsegen.datasets import making as dataset_module
from rsegen.datasets.layout import MOST, ShardLayout
from rsegen.errors import DatasetDamaged, OutputError, UserError
from rsegen.writing import execute as execute_module
from tests.support.complaints import exit_code, the_line
from tests.support.runs import contents

RUBBLE = Recipe(
    name="rubble",
    seed=7,
    maps=13,
    chunk_size=4,
    chunks=(1, 2),
    difficulty=(0, 1),
    obstacles=[Random(levels=4)],
)
HILL = replace(
    RUBBLE,
    name="hill",
    seed=8,
    maps=9,
    first_map=100,
    obstacles=[Peak(levels=300, softness=40)],
)
FLAT = replace(RUBBLE, name="flat", maps=1, obstacles=())
ALL = (RUBBLE, HILL, FLAT)
MAPS = [(recipe, index) for recipe in ALL for index in recipe.indices]


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    return make_dataset(ALL, tmp_path_factory.mktemp("set"), shard_maps=4)


def test_every_map_is_that_of_its_recipe(dataset: Dataset) -> None:
    assert len(dataset) == len(MAPS) == 23
    assert dataset.recipes == ALL
    assert dataset.levels.dtype == np.int16
    every = np.array([rsegen.build(*one).blocks for one in MAPS])
    assert np.array_equal(np.asarray(dataset.levels), every)
    assert np.array_equal(list(dataset), every)
    for places in (slice(10, 17), [22, 0, 13, 12, -1], every[:, 0, 0] > 0):
        assert np.array_equal(dataset[places], every[places])
    for place, (recipe, index) in enumerate(MAPS):
        assert np.array_equal(dataset[place], every[place])
        assert dataset.field(place) == rsegen.build(recipe, index)
        assert dataset.recipe_of(place) == recipe.alone(index)
    assert dataset.recipe_numbers.tolist() == [0] * 13 + [1] * 9 + [2]
    assert dataset.metrics["map"].tolist() == [index for _, index in MAPS]
    assert dataset.metrics["spread.highest"] == pytest.approx(every.max(axis=(1, 2)) * 0.1)
    dataset.verify(23)
    assert np.array_equal(pickle.loads(pickle.dumps(dataset))[14], every[14])  # noqa: S301  # our own


def test_no_shard_has_maps_of_two_recipes(dataset: Dataset) -> None:
    shards = [np.load(dataset.folder / f"levels-{number:05d}.npy") for number in range(8)]
    assert [len(shard) for shard in shards] == [4, 4, 4, 1, 4, 4, 1, 1]
    assert np.array_equal(np.concatenate(shards), dataset[:])
    said = json.loads((dataset.folder / "manifest.json").read_text("utf-8"))
    assert [said["dataset"], said["maps"], len(said["shards"])] == [3, 23, 8]
    assert [entry["name"] for entry in said["recipes"]] == ["rubble", "hill", "flat"]


def test_a_list_of_one_recipe_makes_the_same_bytes_as_the_recipe(tmp_path: Path) -> None:
    make_dataset(RUBBLE, tmp_path / "one", shard_maps=3)
    make_dataset([RUBBLE], tmp_path / "list", shard_maps=3)
    assert contents(tmp_path / "one") == contents(tmp_path / "list")


@pytest.mark.long(reason="tests/writing/test_execute.py has workers once for all commands")
@pytest.mark.slow
@pytest.mark.parametrize("metrics", ["npy", "parquet", "none"])
def test_several_recipes_give_the_same_data_set_with_workers_and_a_cluster(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, metrics: str
) -> None:
    monkeypatch.setattr(execute_module, "WORTHWHILE", 0.0)
    made = [
        make_dataset(ALL, tmp_path / name, metrics=metrics, shard_maps=4, workers=2, scheduler=scheduler)
        for name, scheduler in (("workers", None), ("cluster", "local"))
    ]
    made.append(make_dataset(ALL, tmp_path / "here", metrics=metrics, shard_maps=4))
    assert contents(made[0].folder) == contents(made[1].folder) == contents(made[2].folder)
    for one in made:
        assert one.metrics["map"].tolist() == [index for _, index in MAPS]


@pytest.mark.parametrize("kept", [0, 3, 6])
def test_a_run_that_was_stopped_goes_on(tmp_path: Path, kept: int) -> None:
    make_dataset(ALL, tmp_path, shard_maps=4)
    expected, inodes = contents(tmp_path), {path.name: path.stat().st_ino for path in tmp_path.iterdir()}
    for path in tmp_path.glob("[a-z]*.*"):
        if not any(path.stem.endswith(f"-{number:05d}") for number in range(kept)):
            path.unlink()
    make_dataset(ALL, tmp_path, shard_maps=4, resume=True)
    assert contents(tmp_path) == expected
    same = {path.name for path in tmp_path.glob("levels-*") if path.stat().st_ino == inodes[path.name]}
    assert {f"levels-{number:05d}.npy" for number in range(kept)} <= same


@pytest.mark.parametrize(
    "other", [RUBBLE, (HILL, RUBBLE, FLAT), ALL[:2], (RUBBLE, replace(HILL, seed=9), FLAT)], ids=range(4)
)
def test_other_recipes_do_not_go_on(tmp_path: Path, other: Any) -> None:
    make_dataset(ALL, tmp_path, shard_maps=4)
    before = contents(tmp_path)
    with pytest.raises(OutputError, match="contains a different data set"):
        make_dataset(other, tmp_path, shard_maps=4, resume=True)
    assert contents(tmp_path) == before


def test_one_recipe_is_asked_of_several(dataset: Dataset) -> None:
    with pytest.raises(UserError, match=r"has 3 recipes; take recipes, or recipe_of\(place\)"):
        _ = dataset.recipe
    with pytest.raises(UserError, match=r"place: 23 is outside 0\.\.22"):
        dataset.recipe_of(23)


def test_a_map_of_another_recipe_is_found(tmp_path: Path) -> None:
    make_dataset(ALL, tmp_path, shard_maps=4)
    path = tmp_path / "manifest.json"
    path.write_text(path.read_text("utf-8").replace('"seed": 8', '"seed": 9'), "utf-8")
    with pytest.raises(DatasetDamaged, match=r"#1[3-9]: is not the map|#2[01]: is not the map"):
        Dataset(tmp_path).verify(23)


def test_columns_have_a_recipe_each_and_rows_rise_in_it(tmp_path: Path) -> None:
    rubble, hill = replace(RUBBLE, maps=200), replace(HILL, maps=300)
    found = make_dataset([rubble, hill], tmp_path)
    terrain = found.tiles(5, 4)
    assert found.recipe_numbers[terrain.places].tolist() == [[0, 0, 1, 1]] * 5
    for kind, columns in ((0, slice(0, 2)), (1, slice(2, 4))):
        own = found.metrics["steps.rms"][found.recipe_numbers == kind]
        rows = terrain.difficulty[:, columns]
        assert rows[0, 0] == own.min()
        assert rows[-1, -1] == own.max()
        assert np.abs(rows.mean(axis=1) - np.linspace(own.min(), own.max(), 5)).max() < 0.05 * own.max()
    assert terrain.difficulty[-1, -1] > 10 * terrain.difficulty[-1, 0]
    by_name = found.tiles(5, 3, "spread.mean", recipes=["hill", "hill", "rubble"], spacing="rank")
    assert found.recipe_numbers[by_name.places].tolist() == [[1, 1, 0]] * 5
    assert len(set(by_name.places.ravel().tolist())) == 15
    assert (np.diff(by_name.difficulty, axis=0) >= 0).all()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (
            {"recipes": ["hills"]},
            r"recipes\[0\]: unknown recipe 'hills'; did you mean 'hill'\? \(known: flat, hill, rub",
        ),
        ({"recipes": []}, "recipes: 0 for 3 columns"),
        ({"recipes": "hill"}, "recipes: 'hill' is not a list of names"),
        ({"recipes": [["hill"]]}, r"recipes\[0\]: unknown recipe"),
        ({"columns": 2}, "recipes: 3 for 2 columns; use at most one per column"),
        ({"rows": 2}, "rows: 2 x 1 tiles of flat need as many maps, and 1 have a steps.rms"),
    ],
)
def test_tiles_that_cannot_be(dataset: Dataset, given: Mapping[str, Any], message: str) -> None:
    with pytest.raises(UserError, match=message):
        dataset.tiles(**{"rows": 1, "columns": 3, **given})


@pytest.mark.parametrize(
    ("recipes", "message"),
    [
        ((), "recipes: 0 of them; use 1 to 1,000"),
        ("rubble", "recipes: 'rubble' is not a recipe or a list of recipes"),
        ((RUBBLE, "hill"), "is not a recipe or a list of recipes"),
        ((RUBBLE, FLAT, RUBBLE), r"recipes\[2\].name: 'rubble' is the name of recipes\[0\] too"),
        ((RUBBLE, replace(HILL, chunk_size=5)), r"recipes\[1\].chunk_size: 5, and 4 in the first recipe"),
        ((RUBBLE, replace(HILL, unit_cm=5)), r"recipes\[1\].unit_cm: 5.0, and 10.0 in the first"),
        ((RUBBLE, replace(HILL, boundary="none")), r"recipes\[1\].boundary: 'none', and 'divided'"),
    ],
    ids=range(7),
)
def test_recipes_that_do_not_go_together(tmp_path: Path, recipes: Any, message: str) -> None:
    with pytest.raises(UserError, match=message):
        make_dataset(recipes, tmp_path / "set")
    assert not list(tmp_path.iterdir())


def test_the_manifest_never_lists_too_many_shards() -> None:
    recipes = [replace(FLAT, name=f"r{number}", maps=10**9 + number) for number in range(7)]
    assert ShardLayout(recipes=recipes).shards <= MOST
    with pytest.raises(UserError, match="shard_maps: 60000 would make 1166"):
        ShardLayout(recipes=recipes, shard_maps=60_000)


def test_the_command_makes_it_and_names_its_maps(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    for recipe in ALL:
        rsegen.save(recipe, f"{recipe.name}.yaml")
    names = [f"{recipe.name}.yaml" for recipe in ALL]
    assert exit_code("dataset", *names, "--shard-maps", "4", "-o", "set") == 0
    made = capsys.readouterr().out
    assert "23 maps of 4 x 8 blocks, 13 of rubble (seed 7), 9 of hill (seed 8), 1 of flat (seed 7): " in made
    make_dataset(ALL, "other", shard_maps=4)
    assert contents(tmp_path / "set") == contents(tmp_path / "other")
    assert exit_code("generate", "set#14", "-o", "worlds") == 0
    assert [path.name for path in Path("worlds").iterdir()] == ["hill_0101"]
    assert exit_code("dataset", "--verify", "set", "--json") == 0
    capsys.readouterr()
    assert exit_code("dataset", *names, "--maps", "2", "--seed", "5", "--json", "-o", "small") == 0
    said = json.loads(capsys.readouterr().out)
    assert said["maps"] == 6
    assert said["recipes"] == [{"name": one.name, "seed": 5, "maps": 2} for one in ALL]


def test_a_stopped_command_says_how_to_go_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    real = rsegen.build_many
    for recipe in ALL[:2]:
        rsegen.save(recipe, f"{recipe.name}.yaml")

    def stops_at_the_second(recipe: Recipe, indices: range) -> Any:
        if recipe.name == "hill":
            raise KeyboardInterrupt
        return real(recipe, indices)

    monkeypatch.setattr(dataset_module, "build_many", stops_at_the_second)
    for name, flags, said in (("a", (), "with --resume"), ("b", ("--seed", "3"), "with --seed 3 --resume")):
        monkeypatch.setattr(execute_module, "BATCH", 1e-9)
        recipes = ("rubble.yaml", "hill.yaml", "--maps", "3", "--workers", "1", *flags)
        assert exit_code("dataset", *recipes, "-o", name) == 130
        line = the_line(capsys.readouterr().err)
        assert line.endswith(f"1 of 2 shards are complete in {name}; the same command {said} makes the others")


def test_the_command_says_how_many_of_its_maps_are_different(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A barrier has few places, so maps that were kept for a test would be those of the training."""
    barrier = Recipe(name="barrier", seed=1, maps=60, obstacles=[rsegen.HorizontalBarrier(levels=3)])
    rubble = replace(barrier, name="rubble", obstacles=[Random(levels=4)])
    dataset = make_dataset([barrier, rubble], tmp_path / "both")
    different = len(np.unique(dataset.levels[:60], axis=0))
    assert dataset.distinct("barrier") == (different, 60)
    assert dataset.distinct("rubble") == (60, 60)
    with pytest.raises(UserError, match="name: unknown recipe 'ruble'"):
        dataset.distinct("ruble")
    assert exit_code("dataset", "--verify", tmp_path / "both") == 0
    (said,) = (line for line in capsys.readouterr().out.splitlines() if line.startswith("note: "))
    assert said.startswith(f"note: {different} of the first 60 maps of barrier are different")
