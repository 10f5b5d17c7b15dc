"""A store replaces only what rsegen wrote, in one swap, and loses nothing when a run fails or is stopped."""

from __future__ import annotations

import errno
import json
import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import ExitStack, nullcontext
from functools import partial
from hashlib import sha256
from itertools import count
from pathlib import Path, PurePosixPath

import pytest

from rsegen.errors import FilesDamaged, OutputError, Stopped, WriteError
from rsegen.input_files import JOURNAL
from rsegen.writing import swap
from rsegen.writing import undo as undo_module
from rsegen.writing.dry import dry_run
from rsegen.writing.journal import verify
from rsegen.writing.store import (
    Store,
    continued,
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
    assert {**first, "crc32": ""} == {"rsegen_journal": 1, "holds": "map", "crc32": ""}
    assert [{name: value for name, value in line.items() if name != "crc32"} for line in lines] == [
        {"file": name, "bytes": len(content), "sha256": sha256(content).hexdigest()}
        for name, content in sorted(contents(tmp_path / "map").items())
        if name != JOURNAL
    ]


def test_an_existing_folder_stays_unchanged(tmp_path: Path) -> None:
    write_folder(BUNDLE, tmp_path / "map")
    with pytest.raises(OutputError, match="use force=True to replace it"):
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
    with pytest.raises(OutputError, match=r"map/thesis\.tex: was not written by rsegen, and would be overwritten"):
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


def test_a_single_file_is_replaced_only_by_force_and_leaves_nothing_next_to_it(tmp_path: Path) -> None:
    (tmp_path / "map.png").write_bytes(b"mine")
    with pytest.raises(OutputError, match="exists already"):
        write_file([b"new"], tmp_path / "map.png")
    assert contents(tmp_path) == {"map.png": b"mine"}
    for content in (b"new", b"newer"):
        write_file([content], tmp_path / "map.png", force=True)
        assert contents(tmp_path) == {"map.png": content}


def test_the_journal_of_a_folder_lists_a_single_file_that_is_put_into_it(tmp_path: Path) -> None:
    write_folder(BUNDLE, tmp_path / "map")
    (tmp_path / "map" / "b.png").write_bytes(b"mine")
    write_file([b"1"], tmp_path / "map" / "a.png")
    write_file([b"2"], tmp_path / "map" / "b.png", force=True)
    write_file([b"3"], tmp_path / "map" / "recipe.json", force=True)
    assert verify(tmp_path / "map").files == len(BUNDLE) + 2
    write_folder(BUNDLE, tmp_path / "map", force=True)
    assert verify(tmp_path / "map").files == len(BUNDLE)


def test_a_single_file_that_fails_leaves_the_old_one(tmp_path: Path) -> None:
    write_file([b"old"], tmp_path / "map.png")
    before = contents(tmp_path)
    with pytest.raises(WriteError, match="nothing was changed"):
        write_file(full_disk(), tmp_path / "map.png", force=True)
    assert contents(tmp_path) == before


class Killed(Exception):
    """The end of a process, after which only the disk is left."""


def replaced_until(
    folder: Path, monkeypatch: pytest.MonkeyPatch, renames: int, put_new: Callable[[Store], object]
) -> bool:
    """Replace a map on a disk that cannot exchange two names, killed after some renames; whether it was."""
    left = count(renames, -1)

    def rename(do: Callable[[Path, Path], None], source: Path, place: Path) -> None:
        if next(left) <= 0:
            raise Killed
        do(source, place)

    with monkeypatch.context() as patches:
        patches.setattr(swap, "_of_libc", lambda _: None)
        store = Store(folder, sync=False)
        store.lock.take(0.0)
        store.staging.mkdir()
        for name in ("rename", "replace"):
            patches.setattr(os, name, partial(rename, getattr(os, name)))
        try:
            put_new(store)
        except Killed:
            return True
        finally:
            store.lock.release()
    return False


@pytest.mark.parametrize("renames", range(4))
def test_a_map_that_lies_aside_when_the_run_is_killed_comes_back_and_is_never_merged(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, renames: int
) -> None:
    write_folder({**BUNDLE, PurePosixPath("arrays/levels.npy"): [b"old"]}, tmp_path / "map")
    old = contents(tmp_path / "map")

    def put_new(store: Store) -> None:
        root = new_root(store.staging)
        files = stage_all(root, {PurePosixPath("recipe.json"): [b"new"]})
        store.put_complete(root, files, "map", "map", force=True)

    is_killed = replaced_until(tmp_path, monkeypatch, renames, put_new)
    assert is_killed == (renames < 3)
    is_aside = not (tmp_path / "map").exists()
    assert is_aside == (renames == 1)
    if is_aside:
        with pytest.raises(FilesDamaged, match=r"map: lies in .*, as a run that replaced it did not get to its end"):
            verify(tmp_path)
    write_folder(BUNDLE, tmp_path / "other")
    assert (contents(tmp_path / "map") == old) == (renames < 2)
    assert contents(tmp_path / "map").keys() == (old.keys() if renames < 2 else {"recipe.json", JOURNAL})
    assert {path.name for path in tmp_path.iterdir()} == {"map", "other"}
    assert verify(tmp_path).unlisted == ()


@pytest.mark.parametrize("renames", range(4))
def test_a_format_that_lies_aside_when_the_run_is_killed_comes_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, renames: int
) -> None:
    write_folder({**BUNDLE, PurePosixPath("arrays/levels.npy"): [b"old"]}, tmp_path / "map")
    old = contents(tmp_path)

    def put_new(store: Store) -> None:
        root = new_root(store.staging)
        files = stage_all(root, {PurePosixPath("arrays/other.npy"): [b"new"]})
        whole = {"arrays"}
        store.put_staged(root, files, below="map", force=whole, whole=whole, holds="map")

    replaced_until(tmp_path, monkeypatch, renames, put_new)
    assert (tmp_path / "map" / "arrays").exists() == (renames != 1)
    write_folder(BUNDLE, tmp_path / "other")
    is_old = contents(tmp_path / "map" / "arrays") == {"levels.npy": b"old"}
    assert is_old == (renames < 2)
    assert is_old or contents(tmp_path / "map" / "arrays") == {"other.npy": b"new"}
    assert old.keys() - {"map/arrays/levels.npy"} <= contents(tmp_path).keys()


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
    swapped = undo_module.Swaps.swap

    def fails(self: undo_module.Swaps, new: Path, place: Path, undo: ExitStack, *, replaces: bool) -> None:
        if place.name == "c":
            raise OSError(errno.EIO, "Input/output error")
        swapped(self, new, place, undo, replaces=replaces)

    monkeypatch.setattr(undo_module.Swaps, "swap", fails)
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

    monkeypatch.setattr(undo_module, "put", late)
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


@pytest.mark.parametrize("below", ["", "new"])
@pytest.mark.parametrize("is_dry", [True, False])
def test_a_folder_that_is_a_link_to_nothing_is_named_with_where_it_leads(
    tmp_path: Path, below: str, is_dry: bool
) -> None:
    (tmp_path / "out").symlink_to(tmp_path / "disk" / "worlds")
    with (
        dry_run() if is_dry else nullcontext(),
        pytest.raises(OutputError, match=f"out: is a link to {tmp_path}/disk/worlds, which does not exist"),
        open_store(tmp_path / "out" / below),
    ):
        pass
    assert not (tmp_path / "disk").exists()


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


def test_a_folder_that_lies_aside_when_its_replacement_is_killed_is_not_taken_for_a_new_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, new = tmp_path / "sets" / "set", tmp_path / "new"
    made(folder, "old", "a")
    made(new, "new", "b")
    old = contents(folder)

    def put_new(store: Store) -> None:
        shutil.copytree(new, store.staging / "set")
        store.put_folder(store.staging / "set", "set", "data set", force=True)

    assert replaced_until(folder.parent, monkeypatch, 1, put_new)
    assert not folder.exists()
    with (
        pytest.raises(OutputError, match="has another"),
        continued(folder, "data set", "third", (), force=False, other="another"),
    ):
        pass
    assert contents(folder) == old
    assert [path.name for path in folder.parent.iterdir()] == ["set"]


def test_another_replacement_begins_anew(tmp_path: Path) -> None:
    made(tmp_path / "set", "old", "a")
    stopped(tmp_path / "set", "new")
    with replacing(tmp_path / "set", "data set", "third") as store:
        store.put({"d": [b"third"]})
    assert contents(tmp_path / "set").keys() == {"d", JOURNAL}
