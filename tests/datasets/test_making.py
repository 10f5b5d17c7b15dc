"""A data set has the same bytes whoever makes it, and whatever stops it on the way."""

from __future__ import annotations

import re
import signal
import subprocess
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import psutil
import pytest

import rsegen
from rsegen import Dataset, Recipe, make_dataset
from rsegen.datasets import making as dataset_module
from rsegen.errors import OutputError, TooLarge
from rsegen.input_files import JOURNAL
from rsegen.recipe.codec import decode
from rsegen.writing import execute as execute_module
from tests.support.complaints import exit_code, snapshot, the_line
from tests.support.long import long_unless
from tests.support.runs import contents, ended, started, until_it_has

OBSTACLE = ["--obstacle", "random levels=5", "--seed", "7"]
MANY = ["dataset", *OBSTACLE, "--maps", "40000", "--shard-maps", "500", "--workers", "2"]
RECIPE = Recipe(
    seed=7,
    maps=13,
    first_map=9_995,
    chunk_size=4,
    chunks=(1, 2),
    obstacles=[rsegen.Random(levels=3), rsegen.Peak(levels=5)],
)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """Files of a run that nobody stops."""
    folder = tmp_path_factory.mktemp("whole") / "set"
    assert exit_code(*MANY, "-o", folder) == 0
    return contents(folder)


@pytest.mark.slow
@pytest.mark.parametrize(
    "metrics",
    long_unless("npy".__eq__, ["npy", "parquet", "none"], reason="workers once; the formats have tests of their own"),
)
def test_a_data_set_is_the_same_for_any_number_of_workers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, metrics: str
) -> None:
    monkeypatch.setattr(execute_module, "WORTHWHILE", 0.0)
    for workers in (1, 2, 3):
        make_dataset(RECIPE, tmp_path / str(workers), metrics=metrics, shard_maps=3, workers=workers)
    assert contents(tmp_path / "1") == contents(tmp_path / "2") == contents(tmp_path / "3")
    assert len(contents(tmp_path / "1")) == 2 + 5 * (1 + (metrics != "none"))


def test_the_maps_of_a_constrained_recipe_keep_to_it(tmp_path: Path) -> None:
    recipe = replace(RECIPE, max_step=1)
    made = make_dataset(recipe, tmp_path, shard_maps=5)
    fields = [rsegen.build(recipe, index) for index in recipe.indices]
    assert [field.blocks.tolist() for field in fields] == np.asarray(made[:]).tolist()
    assert fields != [rsegen.build(RECIPE, index) for index in recipe.indices]


def test_few_maps_start_no_worker(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(execute_module, "_processes", lambda _: pytest.fail("workers were started"))
    assert len(make_dataset(RECIPE, tmp_path, shard_maps=1, workers=8)) == 13


def until_made(process: subprocess.Popen[str], folder: Path, shards: int) -> None:
    """Wait until this many shards are in their places: the journal has two files of each."""
    journal = folder / JOURNAL
    until_it_has(process, lambda: journal.is_file() and journal.read_text("utf-8").count("\n") > 2 * shards + 2)


def end_by(signal_: signal.Signals) -> Callable[[Path], tuple[int, str]]:
    def run(folder: Path) -> tuple[int, str]:
        process = started(*MANY, "-o", folder)
        until_made(process, folder, 3)
        process.send_signal(signal_)
        return ended(process)

    return run


def kill_a_worker(folder: Path) -> tuple[int, str]:
    process = started(*MANY, "-o", folder)
    until_made(process, folder, 3)
    *_, worker = (one for one in psutil.Process(process.pid).children() if "spawn_main" in " ".join(one.cmdline()))
    worker.kill()
    return ended(process)


STOPS = {"SIGINT": end_by(signal.SIGINT), "SIGKILL": end_by(signal.SIGKILL), "a worker": kill_a_worker}


@pytest.mark.slow
@pytest.mark.parametrize(
    "stop", long_unless(lambda stop: stop is kill_a_worker, STOPS.values(), reason="another stop"), ids=STOPS
)
def test_a_run_that_was_stopped_goes_on(
    tmp_path: Path, whole: dict[str, bytes], stop: Callable[[Path], tuple[int, str]]
) -> None:
    folder = tmp_path / "set"
    code, _ = stop(folder)
    assert code != 0
    there = {path.name: path.read_bytes() for path in folder.glob("*.npy")}
    assert there == {name: whole[name] for name in there}
    assert not (folder / "manifest.json").exists()
    before = {path.name: path.stat().st_ino for path in folder.glob("levels-*")}
    assert exit_code(*MANY, "--resume", "-o", folder) == 0
    after = {path.name: path.stat().st_ino for path in folder.glob("levels-*")}
    assert sum(before[name] == after[name] for name in before) >= 3
    assert contents(folder) == whole


@pytest.mark.slow
def test_the_message_of_a_stopped_run_says_how_to_go_on(tmp_path: Path) -> None:
    code, err = STOPS["SIGINT"](tmp_path / "set")
    found = re.fullmatch(
        r"rsegen: stopped; ([0-9]+) of 80 shards are complete in .*; "
        r"the same command with --seed 7 --resume makes the others",
        the_line(err),
    )
    assert code == 130
    assert found
    assert int(found[1]) == len(list((tmp_path / "set").glob("levels-*.npy")))
    assert [path.name for path in (tmp_path / "set").glob(".*")] == [JOURNAL]


def test_a_run_that_made_nothing_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def stopped(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(dataset_module, "build_many", stopped)
    with pytest.raises(KeyboardInterrupt):
        make_dataset(RECIPE, tmp_path / "a" / "set")
    assert list(tmp_path.iterdir()) == []


def test_resume_makes_missing_outputs_only(tmp_path: Path) -> None:
    folder = tmp_path / "set"
    make_dataset(RECIPE, folder, shard_maps=3)
    before, stamps = contents(folder), {path.name: path.stat().st_ino for path in folder.iterdir()}
    (folder / "levels-00001.npy").write_bytes(b"")
    (folder / "metrics-00002.npy").unlink()
    (folder / ".rsegen" / "new").mkdir(parents=True)
    (folder / ".rsegen" / "new" / "levels-00003.npy").write_bytes(b"half")
    make_dataset(RECIPE, folder, shard_maps=3, resume=True)
    assert contents(folder) == before
    kept = {path.name for path in folder.iterdir() if path.stat().st_ino == stamps[path.name]}
    assert {name for name in kept if name.startswith("levels")} == {f"levels-0000{k}.npy" for k in (0, 3, 4)}


def test_a_journal_that_was_cut_off_is_believed_as_far_as_it_goes(tmp_path: Path) -> None:
    folder = tmp_path / "set"
    make_dataset(RECIPE, folder, shard_maps=3)
    expected = contents(folder)
    first, *lines = (folder / JOURNAL).read_text("utf-8").splitlines(keepends=True)
    kept = [line for line in lines if "00000" in line or "00001" in line]
    (folder / JOURNAL).write_text("".join([first, *kept, lines[-1][:40]]), "utf-8")
    for path in folder.glob("[a-z]*"):
        if not {"00000", "00001"} & {*path.stem.split("-")}:
            path.unlink()
    told: list[tuple[int, bool]] = []
    make_dataset(
        RECIPE,
        folder,
        shard_maps=3,
        resume=True,
        progress=lambda maps, *, already: told.append((maps, already)),
    )
    assert told == [(6, True), (3, False), (3, False), (1, False)]
    assert contents(folder) == expected


def test_a_run_that_was_killed_when_it_had_made_all_leaves_the_journal_of_one_run(tmp_path: Path) -> None:
    """It is killed between what is put in place and the journal that is written anew; the next has nothing to make."""
    folder = tmp_path / "set"
    make_dataset(RECIPE, folder, shard_maps=3)
    before = contents(folder)
    lines = before[JOURNAL].splitlines(keepends=True)
    (folder / JOURNAL).write_bytes(b"".join([lines[0], *reversed(lines[1:]), lines[2]]))
    make_dataset(RECIPE, folder, shard_maps=3, resume=True)
    assert contents(folder) == before


@pytest.mark.slow
def test_two_runs_do_not_make_one_data_set(tmp_path: Path, whole: dict[str, bytes]) -> None:
    folder = tmp_path / "set"
    process = started(*MANY, "-o", folder)
    until_made(process, folder, 1)
    with pytest.raises(OutputError, match="another run is writing there"):
        make_dataset(RECIPE, folder, shard_maps=500, resume=True)
    code, err = ended(process)
    assert code == 0, err
    assert contents(folder) == whole


@pytest.mark.parametrize("other", [{"seed": 8}, {"maps": 14}, {"unit_cm": 9}])
def test_another_recipe_does_not_go_on(tmp_path: Path, other: dict[str, int]) -> None:
    make_dataset(RECIPE, tmp_path, shard_maps=3)
    before = snapshot(tmp_path)
    with pytest.raises(OutputError, match="contains a different data set"):
        make_dataset(decode({**RECIPE.entry(), **other}), tmp_path, shard_maps=3, resume=True)
    assert snapshot(tmp_path) == before


def test_how_maps_are_represented_and_named_does_not_decide_a_data_set(tmp_path: Path) -> None:
    folder = tmp_path / "set"
    make_dataset(RECIPE, folder, shard_maps=3)
    (folder / "levels-00001.npy").unlink()
    kept = {path.name: path.stat().st_ino for path in folder.glob("*.npy") if "00001" not in path.name}
    painted = replace(RECIPE, frame_colour="#ff0000", look="wood", friction=0.5, mesh_type="multi", name="painted")

    make_dataset(painted, folder, shard_maps=3, resume=True)

    assert {name: (folder / name).stat().st_ino for name in kept} == kept
    make_dataset(painted, tmp_path / "new", shard_maps=3)
    assert contents(folder) == contents(tmp_path / "new")


_AS_ITS_MAPS: Mapping[str, Mapping[str, Any]] = {
    "the colour of frames": {"frame_colour": "#ff0000"},
    "colours of levels": {"level_colours": ("#ff0000", "#00ff00")},
    "a description": {"description": "for people"},
    "units of reports": {"units": "in"},
    "a name": {"name": "other"},
    "all of a representation": {
        "mesh": "blocks",
        "collision": "boxes",
        "simulator": "classic",
        "look": "friction",
        "friction": 0.4,
        "frame_friction": 0.3,
        "level_friction": (0.2,),
        "shadows": True,
        "sky": True,
    },
    "an obstacle that is switched off": {
        "obstacles": (*RECIPE.obstacles, rsegen.Peak(levels=9, enabled=False)),
    },
    "an obstacle that is switched off first": {
        "obstacles": (rsegen.Random(levels=3, enabled=False), *RECIPE.obstacles),
    },
}


@pytest.mark.parametrize("what", _AS_ITS_MAPS)
def test_maps_alone_decide_whether_a_data_set_goes_on(tmp_path: Path, what: str) -> None:
    other, folder = replace(RECIPE, **_AS_ITS_MAPS[what]), tmp_path / "set"
    assert other != RECIPE
    make_dataset(RECIPE, folder, shard_maps=3)
    (folder / "levels-00001.npy").unlink()
    (folder / "manifest.json").unlink()
    kept = {path.name: path.stat().st_ino for path in folder.glob("*.npy") if "00001" not in path.name}
    make_dataset(other, folder, shard_maps=3, resume=True)
    assert len(kept) > 3
    assert {name: (folder / name).stat().st_ino for name in kept} == kept
    make_dataset(other, tmp_path / "new", shard_maps=3)
    assert contents(folder) == contents(tmp_path / "new")
    make_dataset(RECIPE, folder, shard_maps=3, resume=True)  # and back


def test_an_obstacle_that_is_switched_on_decides(tmp_path: Path) -> None:
    make_dataset(replace(RECIPE, obstacles=(*RECIPE.obstacles, rsegen.Peak(levels=5, enabled=False))), tmp_path)
    with pytest.raises(OutputError, match="contains a different data set"):
        make_dataset(replace(RECIPE, obstacles=(*RECIPE.obstacles, rsegen.Peak(levels=5))), tmp_path, resume=True)


def test_a_complete_data_set_is_listed_with_the_recipe_given_last(tmp_path: Path) -> None:
    make_dataset(RECIPE, tmp_path, shard_maps=3)
    painted = replace(RECIPE, frame_colour="#ff0000")
    assert make_dataset(painted, tmp_path, shard_maps=3, resume=True).recipe == painted
    assert Dataset(tmp_path).recipe == painted


def test_force_replaces_a_data_set_if_nothing_else_is_in_its_folder(tmp_path: Path) -> None:
    make_dataset(RECIPE, tmp_path / "set", shard_maps=1)
    (tmp_path / "set" / "thesis.tex").write_text("years of work")
    with pytest.raises(OutputError, match="a data set exists already; use resume=True"):
        make_dataset(RECIPE, tmp_path / "set")
    before = snapshot(tmp_path)
    with pytest.raises(OutputError, match=r"thesis\.tex: was not written by rsegen"):
        make_dataset(RECIPE, tmp_path / "set", force=True)
    assert snapshot(tmp_path) == before
    (tmp_path / "set" / "thesis.tex").unlink()
    make_dataset(RECIPE, tmp_path / "set", force=True)
    make_dataset(RECIPE, tmp_path / "new")
    assert snapshot(tmp_path / "set") == snapshot(tmp_path / "new")


def test_a_folder_of_something_else_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("years of work")
    for flag in ("force", "resume", "neither"):
        with pytest.raises(OutputError, match="is not empty, and not a data set"):
            make_dataset(RECIPE, tmp_path, force=flag == "force", resume=flag == "resume")
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


def test_more_than_the_disk_has_is_refused_before_anything_is_made(tmp_path: Path) -> None:
    with pytest.raises(TooLarge, match=r"maps: they need .* of disk"):
        make_dataset(Recipe(seed=1, maps=10**14), tmp_path / "set")
    assert list(tmp_path.iterdir()) == []


def test_high_levels_have_room(tmp_path: Path) -> None:
    obstacle = rsegen.Random(levels=300)
    found = make_dataset(Recipe(seed=7, maps=5, obstacles=[obstacle]), tmp_path)
    assert found.levels.dtype == np.int16
    assert found.field(4) == rsegen.build(found.recipe, 4)
    assert Dataset(tmp_path).levels[:].max() > 255
