"""The machine fails, or is told to stop: one line, and an exit code that says so, whole maps or nothing."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from rsegen.writing import plan
from tests.support.complaints import (
    OBSTACLE,
    Refused,
    exit_code,
    recipe,
    snapshot,
    the_line,
)
from tests.support.runs import ended, started, started_with_small_files, until_it_has, until_there, whole_maps_only


def test_a_mistake_of_ours_is_one_line_that_asks_for_a_report(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def broken(*_: object) -> None:
        raise ZeroDivisionError("of ours")

    monkeypatch.setattr(plan, "stage_all", broken)
    assert exit_code("generate", *OBSTACLE, "-o", tmp_path / "out") == 1
    err = capsys.readouterr().err
    assert err.count("\n") == 1
    assert "please report it: ZeroDivisionError: of ours" in err
    assert list(tmp_path.iterdir()) == []


def test_running_out_of_memory_is_reported_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def full(*_: object) -> None:
        raise MemoryError

    monkeypatch.setattr(plan, "stage_all", full)
    assert exit_code("generate", *OBSTACLE, "-o", tmp_path / "out") == 1
    assert "out of memory; use fewer chunks" in the_line(capsys.readouterr().err)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(threading.current_thread() is not threading.main_thread(), reason="signals need the main thread")
@pytest.mark.parametrize("force", [False, True])
def test_an_impatient_second_ctrl_c_does_not_disturb_the_clearing_up(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], force: bool
) -> None:
    assert exit_code("generate", *OBSTACLE, "-o", tmp_path) == 0
    before, remove = snapshot(tmp_path), shutil.rmtree

    def stopped(*_: object) -> None:
        signal.raise_signal(signal.SIGINT)

    def stopped_again(*arguments: Any, **options: Any) -> None:
        signal.raise_signal(signal.SIGINT)
        remove(*arguments, **options)

    monkeypatch.setattr(plan, "stage_all", stopped)
    monkeypatch.setattr(shutil, "rmtree", stopped_again)
    capsys.readouterr()
    flags = ["--force"] if force else ["--first-map", "1"]
    assert exit_code("generate", *OBSTACLE, *flags, "-o", tmp_path) == 130
    assert f"stopped; nothing was changed in {tmp_path}" in the_line(capsys.readouterr().err)
    assert snapshot(tmp_path) == before


@pytest.mark.slow
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_a_run_that_is_stopped_leaves_whole_maps_only(tmp_path: Path, name: str) -> None:
    process = started("generate", *OBSTACLE, "--maps", "100000", "-o", tmp_path / "out")
    until_there(process, tmp_path / "out", 3)
    process.send_signal(getattr(signal, name))
    code, err = ended(process)
    made = len(list((tmp_path / "out").iterdir()))
    words = f"stopped; {made} of 100000 maps are complete in {tmp_path / 'out'}; the same command with --seed 7"
    number = 128 + getattr(signal, name)
    assert (code, the_line(err)) == (number, f"rsegen: {words} --resume makes the others")
    assert whole_maps_only(tmp_path / "out")


def test_a_run_that_is_stopped_in_its_only_map_leaves_nothing(tmp_path: Path) -> None:
    process = started("generate", *OBSTACLE, "--chunks", "200", "--mesh-type", "multi", "-o", tmp_path / "a" / "b")
    until_it_has(process, lambda: list(tmp_path.glob("a/b/.rsegen/new/*")))
    process.send_signal(signal.SIGINT)
    code, err = ended(process)
    assert (code, the_line(err)) == (130, f"rsegen: stopped; nothing was changed in {tmp_path / 'a' / 'b'}")
    assert list(tmp_path.iterdir()) == []


def test_a_file_that_grows_too_large_for_the_system_leaves_nothing(tmp_path: Path) -> None:
    code, err = ended(started_with_small_files("generate", *OBSTACLE, "--chunks", "5", "-o", tmp_path / "a" / "b"))
    assert code == 1
    assert "b: cannot be written: File too large; nothing was changed" in the_line(err)
    assert list(tmp_path.iterdir()) == []


@pytest.fixture
def disk(tmp_path: Path) -> Iterator[Path]:
    """A file system of 200 kB."""
    folder = tmp_path / "disk"
    folder.mkdir()
    try:
        done = subprocess.run(
            ["mount", "-t", "tmpfs", "-o", "size=200k", "tmpfs", folder], capture_output=True, text=True, check=False
        )
    except OSError as error:
        pytest.skip(f"a small disk cannot be mounted here: {error}")
    if done.returncode:
        pytest.skip(f"a small disk cannot be mounted here: {' '.join(done.stderr.split())}")
    yield folder
    subprocess.run(["umount", "--lazy", folder], check=True)


def test_a_full_disk_leaves_whole_maps_only(disk: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code("generate", *OBSTACLE, "--maps", "14", "-o", disk / "out") == 1
    line = the_line(capsys.readouterr().err)
    assert "cannot be written: No space left on device; " in line
    made = len(list((disk / "out").iterdir())) if (disk / "out").exists() else 0
    assert f"; {made} of 14 maps are complete in" in line if made else "; nothing was changed" in line
    assert not made or whole_maps_only(disk / "out")


@pytest.mark.parametrize(
    "command",
    [["generate", "--chunks", "10", "-o", "a/b"], ["preview", "recipe.yaml", "-o", "a/b.png"]],
    ids=lambda c: c[0],
)
def test_a_full_disk_leaves_no_partial_output(
    disk: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], command: list[str]
) -> None:
    monkeypatch.chdir(disk)
    recipe("seed: 7\n")
    recipe(bytes(120_000), "ballast")
    before = snapshot(disk)
    assert exit_code(*command, *(OBSTACLE if command[0] == "generate" else [])) == 1
    assert "cannot be written: No space left on device" in the_line(capsys.readouterr().err)
    assert snapshot(disk) == before


def test_a_full_disk_leaves_the_map_that_was_to_be_replaced(disk: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code("generate", *OBSTACLE, "-o", disk) == 0
    before = snapshot(disk)
    capsys.readouterr()
    assert exit_code("generate", *OBSTACLE, "--chunks", "10", "--force", "-o", disk) == 1
    assert "No space left on device" in the_line(capsys.readouterr().err)
    assert snapshot(disk) == before


def test_a_disk_that_may_only_be_read(disk: Path, refused: Refused) -> None:
    subprocess.run(["mount", "-o", "remount,ro", disk], check=True)
    for command in (["generate", "-o", f"{disk}/out"], ["preview", recipe("seed: 7\n"), "-o", f"{disk}/p.png"]):
        assert "cannot be written: Read-only file system" in refused(*command)


@pytest.mark.slow
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full here")
@pytest.mark.parametrize(
    "command", [["schema"], ["obstacles", "--json"], ["--version"], ["generate", "--help"]], ids=" ".join
)
def test_a_report_that_cannot_be_printed(command: list[str]) -> None:
    with Path("/dev/full").open("w") as full:
        code, err = ended(started(*command, stdout=full))
    assert (code, the_line(err)) == (1, "rsegen: the output: No space left on device")


@pytest.mark.slow
@pytest.mark.parametrize("command", [["schema"], ["obstacles"], ["--help"]], ids=" ".join)
def test_a_closed_pipe_ends_the_output_silently(command: list[str]) -> None:
    reader, pipe = os.pipe()
    os.close(reader)
    try:
        assert ended(started(*command, stdout=pipe)) == (1, "")
    finally:
        os.close(pipe)


@pytest.mark.slow
@pytest.mark.parametrize("closed", [">&-", "2>&-"])
def test_closed_output_does_not_keep_a_map_from_being_made(tmp_path: Path, closed: str) -> None:
    process = started("generate", *OBSTACLE, "--maps", "2", "-o", tmp_path / "out", after=closed)
    assert ended(process) == (0, "")
    assert whole_maps_only(tmp_path / "out")


@pytest.mark.slow
def test_a_folder_that_cannot_be_printed_is_written_all_the_same(tmp_path: Path) -> None:
    for code, words in ((0, ""), (2, "exists already")):
        process = started("generate", *OBSTACLE, "-o", tmp_path / "über", PYTHONIOENCODING="ascii")
        found, err = ended(process)
        assert found == code
        assert words in err
    assert whole_maps_only(tmp_path / "über")
