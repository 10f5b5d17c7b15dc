"""A store replaces only what rsegen wrote, in one swap, and loses nothing when a run fails or is stopped."""

from __future__ import annotations

import errno
import json
import shutil
from collections.abc import Iterator
from contextlib import ExitStack
from hashlib import sha256
from pathlib import Path, PurePosixPath

import pytest

from rsegen.errors import OutputError, Stopped, WriteError
from rsegen.input_files import JOURNAL
from rsegen.run import store as store_module
from rsegen.run import swap
from rsegen.run.store import (
    Store,
    new_root,
    open_store,
    replacing,
    stage_all,
    write_file,
    write_folder,
)

BUNDLE = {PurePosixPath("recipe.json"): [b"{", b"}"], PurePosixPath("meshes/a.obj"): [b"v 0 0 0\n"]}


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def full_disk() -> Iterator[bytes]:
    yield b"half"
    raise OSError(errno.ENOSPC, "No space left on device")


def interrupted() -> Iterator[bytes]:
    yield b"half"
    raise KeyboardInterrupt


def test_every_file_is_written(tmp_path: Path) -> None:
    names = write_folder(BUNDLE, tmp_path / "above" / "map")
    found = contents(tmp_path / "above" / "map")
    assert found == {"recipe.json": b"{}", "meshes/a.obj": b"v 0 0 0\n", JOURNAL: found[JOURNAL]}
    assert names == ("meshes/a.obj", "recipe.json")


def test_the_journal_has_the_size_and_checksum_of_every_file(tmp_path: Path) -> None:
    write_folder(BUNDLE, tmp_path / "map")
    first, *lines = map(json.loads, (tmp_path / "map" / JOURNAL).read_text("utf-8").splitlines())
    assert first == {"rsegen_journal": 1, "holds": "map"}
    assert lines == [
        {"file": name, "bytes": len(content), "sha256": sha256(content).hexdigest()}
        for name, content in sorted(contents(tmp_path / "map").items())
        if name != JOURNAL
    ]


def test_an_existing_folder_stays_unchanged(tmp_path: Path) -> None:
    write_folder(BUNDLE, tmp_path / "map")
    with pytest.raises(OutputError, match="give force=True to replace it"):
        write_folder({PurePosixPath("recipe.json"): [b"new"]}, tmp_path / "map")
    assert contents(tmp_path)["map/recipe.json"] == b"{}"


def test_force_replaces_the_whole_folder(tmp_path: Path) -> None:
    write_folder(BUNDLE, tmp_path / "map")
    write_folder({PurePosixPath("recipe.json"): [b"new"]}, tmp_path / "map", force=True)
    assert contents(tmp_path).keys() == {"map/recipe.json", f"map/{JOURNAL}"}
    assert contents(tmp_path)["map/recipe.json"] == b"new"


def test_force_spares_a_folder_that_rsegen_did_not_make(tmp_path: Path) -> None:
    (tmp_path / "map").mkdir()
    (tmp_path / "map" / "thesis.tex").write_text("years of work")
    with pytest.raises(OutputError, match=r"map/thesis\.tex: was not written by rsegen, and would be lost"):
        write_folder(BUNDLE, tmp_path / "map", force=True)
    assert contents(tmp_path) == {"map/thesis.tex": b"years of work"}


@pytest.mark.parametrize(("content", "error"), [(full_disk, WriteError), (interrupted, KeyboardInterrupt)])
def test_a_failure_in_the_middle_leaves_nothing(tmp_path: Path, content: object, error: type[BaseException]) -> None:
    assert callable(content)
    with pytest.raises(error):
        write_folder({**BUNDLE, PurePosixPath("b"): content()}, tmp_path / "above" / "map")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("content", "error"), [(full_disk, WriteError), (interrupted, KeyboardInterrupt)])
def test_a_failure_in_the_middle_leaves_the_old_map(
    tmp_path: Path, content: object, error: type[BaseException]
) -> None:
    assert callable(content)
    write_folder(BUNDLE, tmp_path / "map")
    before = contents(tmp_path)
    with pytest.raises(error):
        write_folder({**BUNDLE, PurePosixPath("b"): content()}, tmp_path / "map", force=True)
    assert contents(tmp_path) == before


@pytest.mark.parametrize("path", ["../out", "/out", "a/../../out"])
def test_no_path_leaves_the_folder(tmp_path: Path, path: str) -> None:
    with pytest.raises(OutputError, match="leaves the output folder"):
        write_folder({PurePosixPath(path): [b"x"]}, tmp_path / "map")
    assert list(tmp_path.rglob("*")) == []


def test_a_single_file_is_replaced_only_by_force_and_only_if_it_is_unchanged(tmp_path: Path) -> None:
    write_file([b"old"], tmp_path / "map.png")
    with pytest.raises(OutputError, match="exists already"):
        write_file([b"new"], tmp_path / "map.png")
    for content in (b"new", b"newer"):
        write_file([content], tmp_path / "map.png", force=True)
    assert contents(tmp_path)["map.png"] == b"newer"
    (tmp_path / "map.png").write_bytes(b"mine")
    with pytest.raises(OutputError, match=r"map\.png: was changed after rsegen wrote it"):
        write_file([b"new"], tmp_path / "map.png", force=True)
    (tmp_path / "theirs.png").write_bytes(b"mine")
    with pytest.raises(OutputError, match=r"theirs\.png: was not written by rsegen"):
        write_file([b"new"], tmp_path / "theirs.png", force=True)
    assert contents(tmp_path).keys() == {"map.png", "theirs.png", JOURNAL}
    assert {contents(tmp_path)[name] for name in ("map.png", "theirs.png")} == {b"mine"}


def test_a_single_file_that_fails_leaves_the_old_one(tmp_path: Path) -> None:
    write_file([b"old"], tmp_path / "map.png")
    before = contents(tmp_path)
    with pytest.raises(WriteError, match="nothing was changed"):
        write_file(full_disk(), tmp_path / "map.png", force=True)
    assert contents(tmp_path) == before


def left_by_a_killed_run(folder: Path, replaced: str) -> None:
    """Lay out what a run leaves that is killed while it replaces a folder on a disk that cannot exchange two names."""
    hidden = folder / ".rsegen"
    (hidden / "new" / "0123abcd").mkdir(parents=True)
    (hidden / "old" / "4567abcd").mkdir(parents=True)
    (folder / replaced).rename(hidden / "old" / "4567abcd" / replaced)


def test_a_map_that_was_moved_aside_when_the_run_was_killed_comes_back(tmp_path: Path) -> None:
    write_folder(BUNDLE, tmp_path / "map")
    before = contents(tmp_path)
    left_by_a_killed_run(tmp_path, "map")
    write_folder(BUNDLE, tmp_path / "other")
    assert contents(tmp_path / "map") == {name.removeprefix("map/"): content for name, content in before.items()}
    assert {path.name for path in tmp_path.iterdir()} == {"map", "other"}


def test_ctrl_c_while_the_hidden_folder_is_removed_leaves_nothing_that_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rmtree = shutil.rmtree

    def stopped(path: Path, *, ignore_errors: bool) -> None:
        monkeypatch.setattr(shutil, "rmtree", rmtree)
        raise KeyboardInterrupt

    monkeypatch.setattr(shutil, "rmtree", stopped)
    with pytest.raises(KeyboardInterrupt):
        write_folder(BUNDLE, tmp_path / "map")
    write_folder(BUNDLE, tmp_path / "other")
    assert {path.name for path in tmp_path.iterdir()} == {"map", "other"}


# Swaps, on disks that can exchange two names and on those that cannot.


@pytest.fixture(params=["exchange", "two steps"])
def disk(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    if request.param == "two steps":
        monkeypatch.setattr(swap, "_of_libc", lambda _: None)
    return str(request.param)


@pytest.mark.usefixtures("disk")
def test_a_folder_that_changes_in_the_last_moment_is_put_back(tmp_path: Path) -> None:
    write_folder(BUNDLE, tmp_path / "map")
    with open_store(tmp_path) as store:
        root = new_root(store.staging)
        files = stage_all(root, {PurePosixPath("recipe.json"): [b"new"]})
        (tmp_path / "map" / "notes.txt").write_text("years of work")
        with pytest.raises(OutputError, match=r"map/notes\.txt: was not written by rsegen"):
            store.put_complete(root, files, "map", "map", force=True)
    assert contents(tmp_path)["map/notes.txt"] == b"years of work"
    assert contents(tmp_path)["map/recipe.json"] == b"{}"


@pytest.mark.usefixtures("disk")
def test_files_that_cannot_all_be_put_in_place_are_all_as_before(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with open_store(tmp_path) as store:
        store.put({"a": [b"1"], "d/b": [b"2"]})
    before = contents(tmp_path)
    sync = store_module.Store._put_unit

    def fails(self: Store, new: Path, place: Path, undo: ExitStack) -> None:
        if place.name == "c":
            raise OSError(errno.EIO, "Input/output error")
        sync(self, new, place, undo)

    monkeypatch.setattr(store_module.Store, "_put_unit", fails)
    with pytest.raises(WriteError, match="nothing was changed"), open_store(tmp_path) as store:
        store.put({"a": [b"10"], "d/b": [b"20"], "e/f": [b"30"], "c": [b"40"]}, force=True)
    assert contents(tmp_path) == before
    assert not (tmp_path / "e").exists()


@pytest.mark.usefixtures("disk")
def test_a_name_that_somebody_takes_in_the_last_moment_stays_his(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    put = swap.put

    def late(new: Path, place: Path) -> None:
        place.write_text("years of work")
        put(new, place)

    monkeypatch.setattr(store_module, "put", late)
    with pytest.raises(OutputError):
        write_file([b"new"], tmp_path / "a.png")
    assert contents(tmp_path) == {"a.png": b"years of work"}


def test_the_hidden_folder_is_not_followed_if_it_is_a_link(tmp_path: Path) -> None:
    (tmp_path / "theirs").mkdir()
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / ".rsegen").symlink_to(tmp_path / "theirs")
    with pytest.raises(OutputError, match="is a link"):
        write_folder(BUNDLE, tmp_path / "out" / "map")
    assert list((tmp_path / "theirs").iterdir()) == []


# A folder that is replaced as a whole, by a run that may be stopped.


def made(folder: Path, of: str, names: str) -> None:
    """Write files into a folder that holds a data set."""
    with open_store(folder) as store:
        store.journal.begin("data set", of)
        for name in names:
            store.put({name: [of.encode()]})


def stopped(folder: Path, of: str) -> None:
    """Stop a run that replaces a data set after its first file."""

    def run() -> None:
        with replacing(folder, "data set", of) as store:
            store.put({"c": [of.encode()]})
            raise KeyboardInterrupt

    with pytest.raises(Stopped, match="what is complete"):
        run()


def test_a_folder_is_replaced_in_one_swap_by_a_run_that_goes_on(tmp_path: Path) -> None:
    made(tmp_path / "set", "old", "ab")
    before = {name: text for name, text in contents(tmp_path / "set").items() if name != JOURNAL}
    stopped(tmp_path / "set", "new")
    after = contents(tmp_path / "set")
    assert {name: after[name] for name in before} == before
    with replacing(tmp_path / "set", "data set", "new") as store:
        assert store.journal.content
        assert [*store.journal.content.files] == ["c"]
        store.put({"d": [b"new"]})
    assert contents(tmp_path / "set").keys() == {"c", "d", JOURNAL}
    assert [path.name for path in tmp_path.iterdir()] == ["set"]


def test_another_replacement_begins_anew(tmp_path: Path) -> None:
    made(tmp_path / "set", "old", "a")
    stopped(tmp_path / "set", "new")
    with replacing(tmp_path / "set", "data set", "third") as store:
        store.put({"d": [b"third"]})
    assert contents(tmp_path / "set").keys() == {"d", JOURNAL}


def test_a_confirmed_overwrite_replaces_any_file(tmp_path: Path) -> None:
    (tmp_path / "recipe.yaml").write_text("# by hand")
    write_file([b"new"], tmp_path / "recipe.yaml", confirmed=True)
    assert contents(tmp_path)["recipe.yaml"] == b"new"
