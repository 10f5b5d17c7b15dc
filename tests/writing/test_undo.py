"""A disk whose renames go on failing: what could not be put back is named, nothing is lost, the next run mends it."""

from __future__ import annotations

import errno
import os
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from itertools import count
from pathlib import Path, PurePosixPath
from typing import Any

import pytest

from rsegen.errors import FilesDamaged, OutputError, RsegenError, Stuck
from rsegen.input_files import JOURNAL
from rsegen.writing import swap, undo
from rsegen.writing.journal import verify
from rsegen.writing.store import new_root, open_store, replacing, stage_all, write_folder

Files = dict[str, bytes]


def visible(folder: Path) -> Files:
    """Return the files of a folder that are not hidden, by their paths."""
    files = (path for path in folder.rglob("*") if path.is_file() and ".rsegen" not in str(path.relative_to(folder)))
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}


@contextmanager
def stuck_after(renames: int, *, exchanges: bool) -> Iterator[list[str]]:
    """Let renames fail after some of them, on a disk that exchanges two names or not; yield those that failed."""
    counted, failed = count(), list[str]()

    def wrapped(rename: Callable[..., Any]) -> Callable[..., Any]:
        def late(source: Path, place: Path, *flags: int) -> Any:
            if next(counted) < renames:
                return rename(source, place, *flags)
            failed.append(str(place))
            raise OSError(errno.EIO, "Input/output error", str(place))

        return late

    with pytest.MonkeyPatch.context() as patches:
        if exchanges:
            patches.setattr(swap, "_renamed", wrapped(swap._renamed))
        else:
            patches.setattr(swap, "_of_libc", lambda _: None)
        for name in ("rename", "replace"):
            patches.setattr(os, name, wrapped(getattr(os, name)))
        yield failed


def put_files(folder: Path, content: str, names: str, *, force: bool = True) -> None:
    """Put files, of which some are in a folder, in one swap each."""
    with open_store(folder) as store:
        store.put({f"{name}.csv": [f"{content} {name}".encode()] for name in names}, force=force)


def put_map(folder: Path, content: str, names: str) -> None:
    """Put a whole folder in the place of another."""
    bundle = {PurePosixPath(f"{name}.csv"): [f"{content} {name}".encode()] for name in names}
    write_folder(bundle, folder / "map", force=True)


def put_set(folder: Path, content: str, names: str) -> None:
    """Replace a folder by one that grows in it."""
    with replacing(folder / "set", "data set", content) as store:
        store.put({f"{name}.csv": [f"{content} {name}".encode()] for name in names}, force=True)


PUTS = {"files": put_files, "map": put_map, "set": put_set}
STUCK = {
    ("files", True): 2,
    ("map", True): 0,
    ("set", True): 0,
    ("files", False): 4,
    ("map", False): 2,
    ("set", False): 2,
}
"""The moments in which a lasting failure leaves something else than the old; one exchange of a folder has none."""


@pytest.mark.parametrize("exchanges", [True, False], ids=["exchange", "two steps"])
@pytest.mark.parametrize("kind", PUTS)
def test_what_could_not_be_put_back_is_named_and_the_next_run_mends_it(
    tmp_path: Path, kind: str, exchanges: bool
) -> None:
    before, replaced = tmp_path / "before", PUTS[kind]
    (before / "set").mkdir(parents=True)
    replaced(before, "old", "abc")
    old, new, stuck = visible(before), dict[str, bytes](), 0
    news = {f"{name}.csv" if kind == "files" else f"{kind}/{name}.csv" for name in "abd"}
    for renames in count():
        folder = tmp_path / f"after {renames}"
        shutil.copytree(before, folder)
        message = ""
        with stuck_after(renames, exchanges=exchanges) as failed:
            try:
                replaced(folder, "new", "abd")
            except RsegenError as error:
                message, is_stuck = str(error), isinstance(error, Stuck)
        now = visible(folder)
        if not failed:
            new = now
            break
        if message:
            changed = [name for name in old.keys() | now.keys() if old.get(name) != now.get(name)]
            assert is_stuck or not changed
            if kind == "files":
                assert all(name in message for name in changed)
            elif changed:
                assert str(folder / kind) in message
            stuck += bool(changed)
        replaced(folder, "new", "abd")
        assert not [path for path in folder.rglob("*") if path.name == ".rsegen"]
        assert verify(folder).unlisted == ()
        mended = visible(folder)
        assert {name for name in mended if mended[name].startswith(b"new")} == news
        assert mended.keys() - news == ({"c.csv"} if kind == "files" else set())
    assert new.keys() == mended.keys()
    assert stuck == STUCK[kind, exchanges]


@pytest.mark.parametrize("exchanges", [True, False], ids=["exchange", "two steps"])
def test_new_files_that_could_not_be_taken_back_are_rsegens(tmp_path: Path, exchanges: bool) -> None:
    # One rename gives the journal its name, the next two files theirs, and the third file fails.
    with (
        stuck_after(3, exchanges=exchanges) as failed,
        pytest.raises(Stuck, match=r"a\.csv \(is new\), .*b\.csv \(is new"),
    ):
        put_files(tmp_path, "new", "bac", force=False)
    assert failed
    assert len(visible(tmp_path)) == 2
    with pytest.raises(FilesDamaged, match=r"c\.csv: is missing"):
        verify(tmp_path)
    put_files(tmp_path, "new", "abc")
    assert len(visible(tmp_path)) == verify(tmp_path).files == 3
    assert JOURNAL in os.listdir(tmp_path)
    assert ".rsegen" not in os.listdir(tmp_path)


@pytest.mark.parametrize("exchanges", [True, False], ids=["exchange", "two steps"])
def test_a_folder_changed_in_the_moment_of_its_swap_is_kept_if_it_cannot_be_put_back(
    tmp_path: Path, exchanges: bool
) -> None:
    def replace_while_it_changes() -> None:
        with open_store(tmp_path) as store:
            root = new_root(store.staging)
            files = stage_all(root, {PurePosixPath("a.csv"): [b"new"]})
            (tmp_path / "map" / "notes.txt").write_text("years of work")
            store.put_complete(root, files, "map", "map", force=True)

    put_map(tmp_path, "old", "abc")
    words = pytest.raises(Stuck, match=r"lies in .*; move it away")
    with stuck_after(1 if exchanges else 3, exchanges=exchanges), words as stuck:
        replace_while_it_changes()
    assert "notes.txt: was not written by rsegen" in str(stuck.value)
    lies = next((tmp_path / ".rsegen" / "new").glob("*/notes.txt")).parent
    with pytest.raises(FilesDamaged, match=f"lies in {lies}"):
        verify(tmp_path)
    for _ in range(2):
        with pytest.raises(OutputError, match=f"the changed one lies in {lies}; move that folder away"):
            put_map(tmp_path, "newer", "a")
        assert (lies / "notes.txt").read_text() == "years of work"
    lies.rename(tmp_path / "mine")
    put_map(tmp_path, "newer", "a")
    assert visible(tmp_path / "map") == {"a.csv": b"newer a"}
    assert {path.name for path in tmp_path.iterdir()} == {"map", "mine"}


@pytest.mark.parametrize("line", ['["../theirs", "map"]', '[".rsegen/new/a", "../map"]', "17", "[]", '{"a": 1}', "[["])
def test_no_line_of_what_is_kept_leads_out_of_the_folder(tmp_path: Path, line: str) -> None:
    folder = tmp_path / "out"
    (folder / ".rsegen" / "new" / "a").mkdir(parents=True)
    (tmp_path / "theirs").mkdir()
    (folder / ".rsegen" / "kept").write_text(f"{line}\n")
    put_map(folder, "new", "a")
    assert {path.name for path in tmp_path.iterdir()} == {"out", "theirs"}
    assert [path.name for path in folder.iterdir()] == ["map"]


@pytest.mark.parametrize("name", [".fuse_hidden0000000300000001", ".nfs000000000000000100000001"])
def test_a_folder_is_removed_once_its_disk_knows_that_a_file_in_it_is_closed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    """FUSE and NFS rename a file that is removed while it is open, such as that of the lock, until it is closed."""
    pauses = count(1)
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / name).touch()

    def sleep(_: float) -> None:
        if next(pauses) == 3:
            (tmp_path / "a" / name).unlink()

    monkeypatch.setattr(time, "sleep", sleep)
    undo.remove_empty(tmp_path / "a")
    assert not (tmp_path / "a").exists()
    assert next(pauses) == 4
    undo.remove_empty(tmp_path / "a")  # it is not there
    (tmp_path / "b").mkdir()
    (tmp_path / "b" / "lock").touch()  # of another run
    undo.remove_empty(tmp_path / "b")
    assert (tmp_path / "b" / "lock").exists()
    assert next(pauses) == 5


def test_folders_deeper_than_python_calls_functions_are_made_and_removed(tmp_path: Path) -> None:
    deep = tmp_path.joinpath(*["n"] * 1200)
    with ExitStack() as made:
        undo.make_folder(deep, made)
        assert deep.is_dir()
    assert list(tmp_path.iterdir()) == []


def test_no_folder_is_made_below_a_file_or_of_a_name_that_is_too_long(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    for place, number in (("new/" + "n" * 300, errno.ENAMETOOLONG), ("file/new", errno.ENOTDIR)):
        with ExitStack() as made, pytest.raises(OSError, match=os.strerror(number)):
            undo.make_folder(tmp_path / place, made)
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_damaged_files_are_counted_next_to_the_one_that_is_named(tmp_path: Path) -> None:
    put_files(tmp_path, "new", "abc")
    said = []
    for name in "abc":
        (tmp_path / f"{name}.csv").write_text("changed")
        with pytest.raises(FilesDamaged) as damaged:
            verify(tmp_path)
        said.append(str(damaged.value).partition("after rsegen wrote it")[2])
    assert said == [
        "",
        "; 1 more file in this folder is changed, missing or empty",
        "; 2 more files in this folder are changed, missing or empty",
    ]
