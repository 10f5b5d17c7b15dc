"""A folder appears whole or not at all."""

from __future__ import annotations

import errno
import json
import shutil
from collections.abc import Iterator
from hashlib import sha256
from pathlib import Path, PurePosixPath

import pytest

from rsegen.errors import OutputError, WriteError
from rsegen.io.record import RECORD
from rsegen.io.staging import remove_leftovers
from rsegen.io.writer import folder_writer, write, write_file

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
    names = write(BUNDLE, tmp_path / "above" / "map")
    found = contents(tmp_path / "above" / "map")
    assert found == {"recipe.json": b"{}", "meshes/a.obj": b"v 0 0 0\n", RECORD: found[RECORD]}
    assert names == ("meshes/a.obj", "recipe.json", RECORD)


def test_the_record_has_the_size_and_checksum_of_every_file(tmp_path: Path) -> None:
    write(BUNDLE, tmp_path / "map")
    files = json.loads((tmp_path / "map" / RECORD).read_text("utf-8"))["files"]
    assert files == [
        {"file": name, "bytes": len(content), "sha256": sha256(content).hexdigest()}
        for name, content in sorted(contents(tmp_path / "map").items())
        if name != RECORD
    ]


def test_a_folder_that_is_there_is_left_alone(tmp_path: Path) -> None:
    write(BUNDLE, tmp_path / "map")
    with pytest.raises(OutputError, match="--force"):
        write({PurePosixPath("recipe.json"): [b"new"]}, tmp_path / "map")
    assert contents(tmp_path)["map/recipe.json"] == b"{}"


def test_force_replaces_the_whole_folder(tmp_path: Path) -> None:
    write(BUNDLE, tmp_path / "map")
    write({PurePosixPath("recipe.json"): [b"new"]}, tmp_path / "map", force=True)
    assert contents(tmp_path).keys() == {"map/recipe.json", f"map/{RECORD}"}
    assert contents(tmp_path)["map/recipe.json"] == b"new"


def test_force_spares_a_folder_that_rsegen_did_not_make(tmp_path: Path) -> None:
    (tmp_path / "map").mkdir()
    (tmp_path / "map" / "thesis.tex").write_text("years of work")
    with pytest.raises(OutputError, match=r"map/thesis\.tex: was not written by rsegen, and would be lost"):
        write(BUNDLE, tmp_path / "map", force=True)
    assert contents(tmp_path) == {"map/thesis.tex": b"years of work"}


@pytest.mark.parametrize(("content", "error"), [(full_disk, WriteError), (interrupted, KeyboardInterrupt)])
def test_what_fails_in_the_middle_leaves_nothing(tmp_path: Path, content: object, error: type[BaseException]) -> None:
    assert callable(content)
    with pytest.raises(error):
        write({**BUNDLE, PurePosixPath("b"): content()}, tmp_path / "above" / "map")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("content", "error"), [(full_disk, WriteError), (interrupted, KeyboardInterrupt)])
def test_what_fails_in_the_middle_leaves_the_old_map(
    tmp_path: Path, content: object, error: type[BaseException]
) -> None:
    assert callable(content)
    write(BUNDLE, tmp_path / "map")
    before = contents(tmp_path)
    with pytest.raises(error):
        write({**BUNDLE, PurePosixPath("b"): content()}, tmp_path / "map", force=True)
    assert contents(tmp_path) == before


@pytest.mark.parametrize("path", ["../out", "/out", "a/../../out"])
def test_no_path_leaves_the_folder(tmp_path: Path, path: str) -> None:
    with pytest.raises(OutputError, match="leaves the output folder"):
        write({PurePosixPath(path): [b"x"]}, tmp_path / "map")
    assert list(tmp_path.rglob("*")) == []


def test_a_single_file_is_replaced_only_by_force(tmp_path: Path) -> None:
    write_file([b"old"], tmp_path / "map.png")
    with pytest.raises(OutputError, match="exists already"):
        write_file([b"new"], tmp_path / "map.png")
    write_file([b"new"], tmp_path / "map.png", force=True)
    assert contents(tmp_path) == {"map.png": b"new"}


def test_a_single_file_that_fails_leaves_the_old_one(tmp_path: Path) -> None:
    write_file([b"old"], tmp_path / "map.png")
    with pytest.raises(WriteError):
        write_file(full_disk(), tmp_path / "map.png", force=True)
    assert contents(tmp_path) == {"map.png": b"old"}


def left_by_a_killed_run(folder: Path, replaced: str) -> Path:
    """What a run leaves that is killed while it replaces a folder."""
    hidden = folder / ".rsegen.0123abcd"
    (hidden / "new" / replaced).mkdir(parents=True)
    (hidden / "old").mkdir()
    (folder / replaced).rename(hidden / "old" / replaced)
    return hidden


def test_a_map_that_was_being_replaced_when_all_was_killed_comes_back(tmp_path: Path) -> None:
    write(BUNDLE, tmp_path / "map")
    before = contents(tmp_path)
    left_by_a_killed_run(tmp_path, "map")
    remove_leftovers(tmp_path)
    assert contents(tmp_path) == before
    assert [path.name for path in tmp_path.iterdir()] == ["map"]


def test_the_next_run_that_writes_there_clears_what_a_killed_one_left(tmp_path: Path) -> None:
    write(BUNDLE, tmp_path / "map")
    left_by_a_killed_run(tmp_path, "map")
    write_file([b"x"], tmp_path / "x.png")
    assert {path.name for path in tmp_path.iterdir()} == {"map", "x.png"}


def test_a_run_that_lives_keeps_its_hidden_folder(tmp_path: Path) -> None:
    with folder_writer(tmp_path) as writer:
        writer.write("map", BUNDLE)
        write_file([b"x"], tmp_path / "x.png")
    assert {path.name for path in tmp_path.iterdir()} == {"map", "x.png"}


def test_where_there_is_no_folder_there_is_nothing_to_clear_away(tmp_path: Path) -> None:
    remove_leftovers(tmp_path / "none")


def test_ctrl_c_while_the_hidden_folder_is_removed_leaves_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rmtree, calls = shutil.rmtree, list[object]()

    def stopped(path: Path, *, ignore_errors: bool) -> None:
        calls.append(path)
        if len(calls) == 1:
            raise KeyboardInterrupt
        rmtree(path, ignore_errors=ignore_errors)

    monkeypatch.setattr(shutil, "rmtree", stopped)
    with pytest.raises(KeyboardInterrupt):
        write(BUNDLE, tmp_path / "map")
    assert [path.name for path in tmp_path.iterdir()] == ["map"]
    write(BUNDLE, tmp_path / "other")
    assert {path.name for path in tmp_path.iterdir()} == {"map", "other"}
