"""A plan says what a run will make, what exists and what it needs; making one writes nothing, whatever it finds."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import rsegen
from rsegen import Random, Recipe
from rsegen.datasets import making
from rsegen.datasets.layout import ShardLayout
from rsegen.datasets.making import plan_dataset
from rsegen.datasets.series import plan_series
from rsegen.datasets.series_rows import SeriesPlan
from rsegen.errors import OutputError, ParameterError, TooLarge, UserError
from rsegen.formats.exports import plan_exports
from rsegen.formats.heightmap import Heightmap
from rsegen.formats.stl import Stl
from rsegen.writing import resources
from rsegen.writing.execute import Execution
from rsegen.writing.plan import OnExisting, run_in
from rsegen.writing.store import open_store
from rsegen.writing.worlds import plan_worlds
from tests.support.complaints import snapshot

RECIPE = Recipe(seed=7, maps=4, chunk_size=4, obstacles=(Random(levels=3),))
HUGE = replace(RECIPE, chunks=(4000, 4000), chunk_size=100)
MANY = replace(RECIPE, maps=10**14)

Run = Callable[..., object]
RUNS: dict[str, Run] = {
    "generate": rsegen.generate,
    "series": rsegen.series,
    "dataset": rsegen.make_dataset,
    "export": lambda recipe, folder, **_: rsegen.export_maps([recipe], folder, [Heightmap()]),
}
EVERY_RUN = pytest.mark.parametrize("run", RUNS.values(), ids=RUNS)


def refused(run: Run, recipe: Recipe, folder: Path, error: type[UserError], **flags: Any) -> str:
    """The message of a run that is refused and writes nothing."""
    above = folder.parent
    before = snapshot(above)
    with pytest.raises(error) as found:
        run(recipe, folder, **flags)
    assert snapshot(above) == before
    return str(found.value)


@EVERY_RUN
def test_a_file_in_place_of_the_folder_is_left_alone(tmp_path: Path, run: Run) -> None:
    (tmp_path / "out").write_text("mine")
    assert "out: is a file; use a folder" in refused(run, RECIPE, tmp_path / "out", OutputError)


@EVERY_RUN
def test_maps_that_are_too_large_for_the_memory_leave_nothing(tmp_path: Path, run: Run) -> None:
    message = refused(run, HUGE, tmp_path / "out", TooLarge)
    assert "a map of 408000 x 408000 cells needs about " in message


@EVERY_RUN
def test_more_maps_than_fit_leave_nothing(tmp_path: Path, run: Run) -> None:
    assert refused(run, MANY, tmp_path / "out", TooLarge).startswith("maps: ")


@EVERY_RUN
def test_a_folder_of_something_else_is_left_alone(tmp_path: Path, run: Run) -> None:
    (tmp_path / "out" / "rse_0002").mkdir(parents=True)
    (tmp_path / "out" / "rse_0002" / "thesis.tex").write_text("years of work")
    assert "out" in refused(run, RECIPE, tmp_path / "out", OutputError)


@pytest.mark.parametrize("name", ["generate", "series", "dataset"])
def test_existing_outputs_stay_without_force_or_resume(tmp_path: Path, name: str) -> None:
    RUNS[name](RECIPE, tmp_path / "out")
    message = refused(RUNS[name], RECIPE, tmp_path / "out", OutputError)
    assert re.search(r"already; use (force|resume)=True", message)


@pytest.mark.parametrize("name", ["generate", "series", "dataset"])
def test_to_keep_and_to_replace_exclude_each_other(tmp_path: Path, name: str) -> None:
    message = refused(RUNS[name], RECIPE, tmp_path / "out", ParameterError, force=True, resume=True)
    assert message == "resume: resume=True and force=True exclude each other"


@pytest.mark.parametrize("name", ["generate", "series"])
def test_maps_that_cannot_be_built_by_hand_leave_nothing(tmp_path: Path, name: str) -> None:
    recipe = replace(RECIPE, chunk_size=1000)
    refused(RUNS[name], recipe, tmp_path / "out", ParameterError, sheet=True)


@pytest.mark.parametrize("name", ["generate", "series"])
def test_a_format_without_its_package_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    monkeypatch.setattr("rsegen.params.extras.find_spec", lambda _: None)
    message = refused(RUNS[name], RECIPE, tmp_path / "out", UserError, formats=[Stl()])
    assert "stl needs trimesh" in message


def test_a_plan_of_worlds_has_new_and_existing_maps_and_the_resources(tmp_path: Path) -> None:
    rsegen.generate(replace(RECIPE, maps=1, first_map=2), tmp_path)
    before = snapshot(tmp_path)
    plan = plan_worlds(RECIPE, tmp_path, (), OnExisting.KEEP, Execution(workers=3))
    assert (list(plan.to_make), list(plan.existing), plan.execution.workers) == ([0, 1, 3], [2], 3)
    assert snapshot(tmp_path) == before


def test_a_plan_does_not_make_the_folder(tmp_path: Path) -> None:
    plan_worlds(RECIPE, tmp_path / "a", (), OnExisting.REFUSE)
    plan_exports([RECIPE], tmp_path / "b", [Heightmap()], OnExisting.REFUSE)
    plan_series(SeriesPlan(recipe=RECIPE), tmp_path / "c", (), OnExisting.KEEP)
    plan_dataset(ShardLayout(recipes=[RECIPE]), tmp_path / "d", OnExisting.KEEP)
    assert list(tmp_path.iterdir()) == []


def test_a_plan_of_a_series_says_which_of_its_maps_exist(tmp_path: Path) -> None:
    rsegen.series(RECIPE, tmp_path)
    (tmp_path / "rse_0001").rename(tmp_path / "elsewhere")
    plan = plan_series(SeriesPlan(recipe=RECIPE), tmp_path, (), OnExisting.KEEP)
    assert list(plan.existing) == [0, 2, 3]


def test_a_plan_of_a_data_set_says_which_shards_are_missing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rsegen.make_dataset(RECIPE, tmp_path, shard_maps=1)
    (tmp_path / "levels-00002.npy").unlink()
    sizes: list[int] = []
    monkeypatch.setattr(making, "refuse_full", lambda size, _: sizes.append(size))
    plan = plan_dataset(ShardLayout(recipes=[RECIPE], shard_maps=1), tmp_path, OnExisting.KEEP)
    assert (list(plan.run.to_make), sorted(plan.run.existing)) == ([2], [0, 1, 3])
    assert sizes == [plan.layout.bytes_per_map]


def test_workers_are_no_more_than_fit_into_the_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(resources, "_free_memory", lambda: 5 * resources.BYTES_PER_WORKER)
    plan = plan_worlds(RECIPE, tmp_path, (), OnExisting.REFUSE, Execution(workers=100))
    assert plan.execution.workers == 4


@pytest.mark.parametrize("workers", [1, 2])
def test_memory_and_disk_are_measured_once_in_a_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, workers: int
) -> None:
    asked: list[str] = []

    def counted(name: str) -> Callable[..., float]:
        measure: Callable[..., float] = getattr(resources, name)

        def measured(*arguments: Any) -> float:
            asked.append(name)
            return measure(*arguments)

        return measured

    for name in ("_free_memory", "_free_disk"):
        monkeypatch.setattr(resources, name, counted(name))
    rsegen.generate(RECIPE, tmp_path / "out", workers=workers)
    assert asked == ["_free_memory", "_free_disk"]


def test_nothing_is_checked_again_once_the_first_map_is_made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def late(*_: object, **__: object) -> None:
        pytest.fail("checked after the plan")

    plan = plan_worlds(RECIPE, tmp_path / "out", (), OnExisting.REFUSE)
    for name in ("check_needs", "refuse_taken", "refuse_busy", "existing_maps"):
        monkeypatch.setattr(f"rsegen.writing.worlds.{name}", late)
    monkeypatch.setattr("rsegen.writing.store.refuse_taken", late)
    with open_store(plan.folder) as store:
        assert len(run_in(store, plan)) == 4
