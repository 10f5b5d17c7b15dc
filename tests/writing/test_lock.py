"""Two runs never write into one folder at the same time; a dead run is told from one that is alive."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from rsegen.errors import OutputError
from rsegen.input_files import JOURNAL
from rsegen.writing import lock
from rsegen.writing.journal import HIDDEN
from rsegen.writing.store import open_store, write_file
from tests.support.complaints import exit_code, snapshot, the_line
from tests.support.runs import contents, ended, started, until_there

HOLD = """
import sys, time
from pathlib import Path
from rsegen.writing.store import open_store
with open_store(Path(sys.argv[1])):
    print("held", flush=True)
    time.sleep(600)
"""


def holding(folder: Path) -> subprocess.Popen[str]:
    """Start a process that has a folder."""
    process = subprocess.Popen([sys.executable, "-c", HOLD, str(folder)], stdout=subprocess.PIPE, text=True)
    assert process.stdout
    assert process.stdout.readline() == "held\n"
    return process


@pytest.fixture(params=["locks", "no locks"])
def disk(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """A disk with locks, and one without."""
    if request.param == "no locks":
        monkeypatch.setattr(lock, "_locked", lambda _: None)
    return str(request.param)


def test_a_second_run_is_refused_by_name(tmp_path: Path) -> None:
    with holding(tmp_path) as process:
        expected = f"another run is writing there .process {process.pid} on"
        with pytest.raises(OutputError, match=expected), open_store(tmp_path):
            pass
        process.kill()
    with open_store(tmp_path):
        pass
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
@pytest.mark.parametrize("seeds", [("7", "7"), ("7", "8")], ids=["the same maps", "other maps"])
def test_of_two_shells_that_generate_into_one_folder_at_once_one_is_refused(
    tmp_path: Path, seeds: tuple[str, str]
) -> None:
    command = ("generate", "--obstacle", "random levels=5", "--chunk-size", "60", "--maps", "20", "--workers", "1")
    processes = [started(*command, "--seed", seed, "-o", tmp_path / "out") for seed in seeds]
    ends = [ended(process) for process in processes]
    (winner,) = (number for number, (code, _) in enumerate(ends) if code == 0)
    code, err = ends[1 - winner]
    assert code == 2
    # The second is as a rule refused while the first writes; if it began late, all maps are there.
    assert "another run is writing there" in the_line(err) or "exists already" in err
    assert exit_code(*command, "--seed", seeds[winner], "-o", tmp_path / "alone") == 0
    assert len(list((tmp_path / "alone").iterdir())) == 20
    assert contents(tmp_path / "out") == contents(tmp_path / "alone")


def test_a_folder_that_another_run_makes_at_the_same_moment_is_no_failure(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It looks whether the folder is there, the other one makes it, and then it makes it too."""
    make = Path.mkdir
    raced: list[Path] = []

    def mkdir(place: Path, *arguments: Any, **named: Any) -> None:
        if place == tmp_path / "out" and not raced:
            raced.append(place)
            make(place)
        make(place, *arguments, **named)

    monkeypatch.setattr(Path, "mkdir", mkdir)
    with open_store(tmp_path / "out") as store:
        store.put({"a": [b"1"]})
    assert raced
    assert (tmp_path / "out" / "a").read_bytes() == b"1"


def test_a_run_that_ends_just_after_the_last_try_of_the_next_lets_it_in(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    try_ = lock.Lock._try
    tries: list[bool] = []

    def refused_up_to_the_last(self: lock.Lock, *, is_last: bool) -> None:
        if not any(tries):
            tries.append(is_last)
            return
        try_(self, is_last=is_last)

    monkeypatch.setattr(lock.Lock, "_try", refused_up_to_the_last)
    with open_store(tmp_path) as store:
        store.put({"a": [b"1"]})
    assert tries[-1]
    assert (tmp_path / "a").read_bytes() == b"1"


def test_a_run_whose_lock_is_not_yet_written_is_named_without_a_process(tmp_path: Path) -> None:
    (tmp_path / ".rsegen").mkdir()
    with (tmp_path / ".rsegen" / "lock").open("w+b") as file:
        assert lock._locked(file.fileno())
        with pytest.raises(OutputError) as refused, open_store(tmp_path):
            pass
    assert f"{tmp_path}: another run is writing there; wait for it, or stop it; if" in str(refused.value)


@pytest.mark.usefixtures("disk")
def test_a_killed_run_keeps_nobody_out(tmp_path: Path) -> None:
    with holding(tmp_path) as process:
        process.kill()
    assert (tmp_path / ".rsegen" / "lock").exists()
    with open_store(tmp_path):
        pass
    assert list(tmp_path.iterdir()) == []


def test_a_run_that_was_killed_and_not_yet_reaped_is_dead(tmp_path: Path) -> None:
    with holding(tmp_path) as process:
        process.kill()
        os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOWAIT)
        with open_store(tmp_path) as store:
            store.put({"a": [b"1"]})
    assert (tmp_path / "a").read_bytes() == b"1"


def test_a_suspended_run_keeps_its_folder(tmp_path: Path) -> None:
    with holding(tmp_path) as process:
        process.send_signal(signal.SIGSTOP)
        with pytest.raises(OutputError, match="another run is writing there"), open_store(tmp_path):
            pass
        process.kill()


def test_a_hidden_folder_that_another_run_removes_meanwhile_is_made_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is there when this run wants to make it, and gone when it looks for it."""
    calls: list[Path] = []
    really = Path.mkdir

    def mkdir(path: Path, *arguments: Any, **options: Any) -> None:
        if path.name == HIDDEN and not calls:
            calls.append(path)
            raise FileExistsError(17, "File exists", str(path))
        really(path, *arguments, **options)

    monkeypatch.setattr(Path, "mkdir", mkdir)
    with open_store(tmp_path, wait=5.0, sync=False) as store:
        store.put({"a": [b"1"]})
    assert calls == [tmp_path / HIDDEN]
    assert {path.name for path in tmp_path.iterdir()} == {JOURNAL, "a"}


def test_a_disk_on_which_no_folder_can_be_made_is_no_other_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As /proc is."""

    def refused(folder: Path, *_: object, **__: object) -> None:
        raise FileNotFoundError(2, "No such file or directory", str(folder))

    monkeypatch.setattr(Path, "mkdir", refused)
    with pytest.raises(OutputError, match=r"a\.png: cannot be written: No such file or directory"):
        write_file([b""], tmp_path / "a.png")
    assert not list(tmp_path.iterdir())


@pytest.mark.usefixtures("disk")
def test_of_many_threads_one_has_a_folder_at_a_time(tmp_path: Path) -> None:
    inside = []

    def write(number: int) -> None:
        with open_store(tmp_path, wait=600.0, sync=False) as store:
            inside.append(number)
            assert len(inside) == 1
            store.put({f"{number}": [b"1"]})
            inside.remove(number)

    with ThreadPoolExecutor(8) as pool:
        assert [*pool.map(write, range(16))] == [None] * 16
    assert {path.name for path in tmp_path.iterdir()} == {JOURNAL, *map(str, range(16))}


@pytest.mark.parametrize(
    ("says", "is_gone"),
    [("{", True), ("", True), ({"host": "elsewhere", "pid": 1}, False), ({"pid": 0}, True), ({"pid": 2**22 + 1}, True)],
)
def test_without_locks_a_run_of_another_computer_is_never_taken_for_dead(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, says: str | dict[str, object], is_gone: bool
) -> None:
    monkeypatch.setattr(lock, "_locked", lambda _: None)
    file = tmp_path / ".rsegen" / "lock"
    file.parent.mkdir()
    file.write_text(says if isinstance(says, str) else json.dumps({**lock._here(), **says}))
    if is_gone:
        write_file([b"1"], tmp_path / "a")
        assert [path.name for path in tmp_path.iterdir()] == ["a"]
        return
    refusal = r"process 1 on 'elsewhere'.*; if it no longer exists, delete .*lock"
    with pytest.raises(OutputError, match=refusal), open_store(tmp_path):
        pass
    assert file.exists()
    assert not (tmp_path / "a").exists()


def test_a_run_whose_lock_was_removed_writes_nothing_more(tmp_path: Path) -> None:
    with open_store(tmp_path) as store:
        (store.home / "lock").unlink()
        with pytest.raises(OutputError, match="another run took this folder"):
            store.put({"a": [b"1"]})
    assert not (tmp_path / "a").exists()


@pytest.mark.slow
def test_a_command_in_the_folder_of_another_one_changes_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    flags = ["--obstacle", "random levels=5", "--seed", "7", "--maps", "5000", "--workers", "1"]
    many: list[str | Path] = ["generate", *flags, "-o", tmp_path / "out"]
    process = started(*many)
    until_there(process, tmp_path / "out", 5)
    process.send_signal(signal.SIGSTOP)
    os.waitid(os.P_PID, process.pid, os.WSTOPPED | os.WNOWAIT)  # it writes until then
    before = snapshot(tmp_path)
    commands: list[list[str | Path]] = [many, [*many, "--resume"], [*many, "--force"], ["dataset", *many[1:]]]
    for command in commands:
        assert exit_code(*command) == 2
        assert f"another run is writing there (process {process.pid}" in the_line(capsys.readouterr().err)
        assert snapshot(tmp_path) == before
    process.send_signal(signal.SIGCONT)
    process.send_signal(signal.SIGINT)
    assert ended(process)[0] == 130
