"""Any map of a data set is the one that its recipe makes."""

from __future__ import annotations

import pickle
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rsegen
from rsegen import Dataset, Recipe, make_dataset
from rsegen.errors import DatasetDamaged, ParameterError
from rsegen.field.traversability import percolation
from rsegen.measuring.batch import COLUMNS
from rsegen.measuring.catalogue import flattened, nested
from tests.support.complaints import exit_code, the_line
from tests.support.runs import contents
from tests.support.strategies import recipes

RECIPE = Recipe(
    seed=7,
    maps=20,
    chunk_size=4,
    chunks=(2, 3),
    obstacles=[rsegen.Random(levels=4), rsegen.Peak(levels=6)],
)


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    return make_dataset(RECIPE, tmp_path_factory.mktemp("set"), shard_maps=6)


@pytest.mark.slow
@given(recipes(), st.integers(1, 4), st.integers(0, 10**6), st.sampled_from([None, 1]))
def test_every_map_is_built_alike(recipe: Recipe, shard: int, first: int, max_step: int | None) -> None:
    recipe = replace(recipe, maps=5, first_map=first, max_step=max_step)
    with tempfile.TemporaryDirectory() as folder:
        found = make_dataset(recipe, folder, shard_maps=shard)
        assert len(found) == 5
        assert found.levels.shape == (5, *recipe.grid.shape)
        for place, index in enumerate(recipe.indices):
            field = rsegen.build(recipe, index)
            assert np.array_equal(found[place], field.blocks)
            assert found.field(place) == field
            assert np.array_equal(found.heights(place), field.heights)


def test_levels_are_read_as_one_array(dataset: Dataset) -> None:
    every = np.array([rsegen.build(RECIPE, index).blocks for index in range(20)])
    levels = dataset.levels
    assert (levels.shape, levels.dtype.name, len(levels)) == ((20, 8, 12), "uint8", 20)
    assert np.array_equal(np.asarray(levels), every)
    assert np.array_equal(list(dataset), every)
    several: list[Any] = [slice(3, 9), slice(None, None, -3), slice(30, 40), [5, 0, 17, 5], np.array([-20, -1, 4])]
    for places in [*several, every[:, 0, 0] > 1]:
        assert np.array_equal(dataset[places], every[places])
        assert dataset[places].dtype == np.uint8
    assert np.array_equal(dataset[-1], every[-1])
    assert dataset[[]].shape == (0, 8, 12)
    for wrong in ([0.5], [[1]], [True, False]):
        with pytest.raises(IndexError, match="expected a list of integers"):
            dataset[np.array(wrong)]
    for other in (1.5, "3", None):
        with pytest.raises(IndexError, match="is not the place of a map; use an integer"):
            dataset[other]  # type: ignore[index]
    for beyond in (20, -21):
        with pytest.raises(IndexError, match=f"there is no map {beyond}"):
            dataset[beyond]
    with pytest.raises(ValueError, match="read-only"):
        dataset.levels[0][0, 0] = 1


@pytest.mark.slow
def test_it_goes_to_other_processes(dataset: Dataset) -> None:
    dataset[0]
    assert np.array_equal(pickle.loads(pickle.dumps(dataset))[7], dataset[7])  # noqa: S301  # our own
    assert np.array_equal(pickle.loads(pickle.dumps(dataset.levels))[7], dataset[7])  # noqa: S301


@pytest.mark.parametrize("form", ["npy", "parquet", "none"])
def test_metrics_equal_the_metrics_of_each_map(tmp_path: Path, form: str) -> None:
    found = make_dataset(RECIPE, tmp_path, shard_maps=6, metrics=form).metrics
    assert tuple(found) == ("map", *COLUMNS)
    assert found["map"].tolist() == list(range(20))
    for index in range(20):
        alone = dict(flattened(nested(rsegen.metrics(rsegen.build(RECIPE, index)))))
        assert {name: found[name][index] for name in COLUMNS} == pytest.approx(
            {name: alone[name] for name in COLUMNS}, rel=1e-6
        )


def test_arrays_that_were_read_are_writable_and_the_files_stay(dataset: Dataset) -> None:
    """As torch wants it of what it makes tensors of."""
    for found in (dataset[3], dataset[-1], dataset[:2], dataset[[1, 2]], dataset.__getitems__([4, 0, 4])):
        assert found.flags.writeable
        found[:] = 1
    assert np.array_equal(dataset.__getitems__([4, 0, 4]), np.stack([dataset[4], dataset[0], dataset[4]]))
    dataset.verify()


@pytest.mark.parametrize("spacing", ["value", "rank"])
def test_tiles_get_harder_from_row_to_row(spacing: str, dataset: Dataset) -> None:
    found = dataset.tiles(3, 5, by="spread.deviation", spacing=spacing)
    assert (np.diff(found.difficulty.ravel()) >= 0).all()
    assert len(set(found.places.ravel())) == 15
    assert found.difficulty[0, 0] == dataset.metrics["spread.deviation"].min()
    assert found.difficulty[-1, -1] == dataset.metrics["spread.deviation"].max()
    for row_, column in np.ndindex(3, 5):
        place = found.places[row_, column]
        assert np.array_equal(found.levels[row_, column], dataset[place])
        assert np.array_equal(found.heights[row_, column], dataset.heights(int(place)))


def test_the_last_row_is_the_hardest_of_maps_that_are_seldom_hard(tmp_path: Path) -> None:
    """Most maps are in the middle, so the maps nearest to a row near an end were the hardest of all."""
    found = make_dataset(rsegen.Recipe(seed=1, maps=600, obstacles=[rsegen.Random(levels=5)]), tmp_path)
    every = np.sort(found.metrics["steps.rms"])
    for rows, columns in ((10, 20), (20, 5), (6, 100)):
        tiles = found.tiles(rows, columns)
        assert (np.diff(tiles.difficulty.ravel()) >= 0).all()
        assert np.array_equal(tiles.difficulty[0], every[:columns])
        assert np.array_equal(tiles.difficulty[-1], every[-columns:])
        assert len(set(tiles.places.ravel())) == rows * columns


def test_tiles_by_a_metric_of_a_robot_can_be_crossed_by_it(dataset: Dataset) -> None:
    robot = rsegen.StepLimits(climb_cm=10, width_cm=5)
    found = dataset.tiles(2, 3, by="reach.west_east.cost", robot=robot)
    costs = [rsegen.metrics(dataset.field(place), robot).reach for place in range(20)]
    every = {place: one.west_east.cost for place, one in enumerate(costs) if one and one.west_east.cost}
    assert 6 <= len(every) < 20
    assert found.difficulty.ravel().tolist() == pytest.approx([every[int(place)] for place in found.places.ravel()])
    assert found.difficulty[0, 0] == pytest.approx(min(every.values()))


def test_tiles_by_the_climb_that_a_way_needs_are_of_the_width_of_the_robot(dataset: Dataset) -> None:
    robot = rsegen.StepLimits(climb_cm=10, width_cm=25)
    found = dataset.tiles(2, 3, by="opening.west_east", robot=robot)
    climbs = [percolation(dataset.field(int(place)), 0.25).west_east for place in found.places.ravel()]
    assert found.difficulty.ravel().tolist() == pytest.approx(climbs)
    assert climbs != pytest.approx(dataset.metrics["opening.west_east"][found.places.ravel()].tolist())


def test_rows_are_nearest_to_evenly_spaced_values(dataset: Dataset) -> None:
    found, every = dataset.tiles(3, 4, by="spread.deviation"), dataset.metrics["spread.deviation"]
    low, high = every.min(), every.max()
    for row, wanted in zip(found.difficulty, (low, (low + high) / 2, high), strict=True):
        assert np.abs(row - wanted).max() <= np.sort(np.abs(every - wanted))[11]
    middle = np.sort(np.abs(every - (low + high) / 2))[:4]
    assert np.abs(found.difficulty[1] - (low + high) / 2).max() == pytest.approx(middle.max())


def test_origins_are_the_middles_of_the_tiles_on_top_of_their_blocks(dataset: Dataset) -> None:
    found = dataset.tiles(2, 3)
    assert found.size == dataset.field(0).extent == pytest.approx((1.2, 1.8))
    assert found.origins[:, :, 0].tolist() == [pytest.approx([x] * 3) for x in (-0.6, 0.6)]
    assert found.origins[:, :, 1].tolist() == [pytest.approx([-1.8, 0, 1.8])] * 2
    assert np.array_equal(found.origins[:, :, 2], found.heights[:, :, 5:7, 8:10].max(axis=(2, 3)))


@pytest.mark.parametrize(
    ("wanted", "words"),
    [
        ((0, 3, "steps.rms"), "rows: 0 is not 1 or more"),
        ((5, 5, "steps.rms"), "need as many maps, and 20 have"),
        ((1, 1, "steps.rsm"), "did you mean 'steps.rms'"),
        ((1, 1, "reach.coverage"), "by: reach.coverage needs a robot; set robot too"),
    ],
)
def test_tiles_that_cannot_be(dataset: Dataset, wanted: tuple[int, int, str], words: str) -> None:
    with pytest.raises(ParameterError, match=words):
        dataset.tiles(*wanted)


def test_a_map_of_a_data_set_is_made_again_alone(dataset: Dataset, tmp_path: Path) -> None:
    assert exit_code("generate", f"{dataset.folder}#17", "-o", tmp_path / "one") == 0
    rsegen.generate(replace(RECIPE, first_map=17, maps=1), tmp_path / "other")
    assert contents(tmp_path / "one") == contents(tmp_path / "other")


def test_commands_look_at_a_map_of_a_data_set(
    dataset: Dataset, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    target = f"{dataset.folder}#17"
    for command in ("info", "metrics"):
        assert exit_code(command, target) == 0
        assert "rse_0017, seed 7" in capsys.readouterr().out
    assert exit_code("preview", target, "-o", tmp_path / "p.png") == 0
    assert exit_code("export", target, "--to", "arrays", "-o", tmp_path / "out") == 0
    assert (tmp_path / "out" / "rse_0017" / "arrays").is_dir()


def test_a_file_with_such_a_name_comes_first(dataset: Dataset, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    Path("set").symlink_to(dataset.folder)
    rsegen.save(replace(RECIPE, name="other"), "set#1")
    assert exit_code("generate", "set#1", "--maps", "1", "-o", "out") == 0
    assert Path("out/other_0000").is_dir()


def test_an_undamaged_data_set_is_verified(dataset: Dataset, capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code("dataset", "--verify", dataset.folder) == 0
    assert "all checksums are right, and 20 random maps" in capsys.readouterr().out


def test_a_changed_byte_is_found(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = make_dataset(RECIPE, tmp_path, shard_maps=6)
    for path in sorted(tmp_path.glob("*.npy")):
        content = path.read_bytes()
        path.write_bytes(content[:-1] + bytes([content[-1] ^ 1]))
        assert exit_code("dataset", "--verify", tmp_path) == 1
        assert f"{path}: has changed, its checksum is wrong" in the_line(capsys.readouterr().err)
        with pytest.raises(DatasetDamaged):
            found.verify(0)
        path.write_bytes(content)
    found.verify()


@pytest.mark.parametrize("damage", ["a byte", "longer", "empty", "gone"])
def test_the_advice_for_a_damaged_file_repairs_it(
    damage: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    make_dataset(RECIPE, tmp_path, shard_maps=6)
    path = tmp_path / "levels-00001.npy"
    content = path.read_bytes()
    damaged = {"a byte": content[:-1] + b"\xff", "longer": content + b"x", "empty": b""}
    path.write_bytes(damaged.get(damage, b""))
    if damage == "gone":
        path.unlink()
    assert exit_code("dataset", "--verify", tmp_path) == 1
    said = the_line(capsys.readouterr().err)
    if "delete it, and " in said:
        path.unlink()
    assert said.endswith("the command that made the data set makes it again with --resume")
    make_dataset(RECIPE, tmp_path, shard_maps=6, resume=True).verify()
    assert path.read_bytes() == content


def test_a_map_that_is_not_the_recipe_s_is_found(tmp_path: Path) -> None:
    make_dataset(RECIPE, tmp_path)
    text = (tmp_path / "manifest.json").read_text("utf-8")
    (tmp_path / "manifest.json").write_text(text.replace('"seed": 7', '"seed": 8'), "utf-8")
    with pytest.raises(DatasetDamaged, match=r"#0: is not the map that this version"):
        Dataset(tmp_path).verify(20)


def test_a_file_of_another_size_is_found(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    make_dataset(RECIPE, tmp_path)
    path = tmp_path / "levels-00000.npy"
    path.write_bytes(b"")
    assert exit_code("dataset", "--verify", tmp_path) == 1
    assert f"{path}: has 0 bytes, and the manifest says 2048" in the_line(capsys.readouterr().err)
    path.unlink()
    with pytest.raises(DatasetDamaged, match="is missing"):
        Dataset(tmp_path)
