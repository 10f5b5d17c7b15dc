"""Two runs never write into one folder at the same time; a dead run is told from one that is alive."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
from itertools import count
from pathlib import Path

import pytest

from rsegen.errors import OutputError
from rsegen.run import lease
from rsegen.run.store import open_store, write_file
from tests.support.complaints import exit_code, snapshot, the_line
from tests.support.runs import ended, started, until_there

HOLD = """
import sys, time
from pathlib import Path
from rsegen.run.store import open_store
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


def of_another_machine(folder: Path) -> Path:
    """Make the lease of a folder look as if a run of another machine had it."""
    (held,) = (folder / ".rsegen").glob("lease-*")
    held.write_text(json.dumps({**json.loads(held.read_text("utf-8")), "host": "elsewhere", "boot": "x"}), "utf-8")
    return held


def test_a_second_run_is_refused_by_name(tmp_path: Path) -> None:
    with holding(tmp_path) as process:
        expected = f"another run is writing there .process {process.pid} on"
        with pytest.raises(OutputError, match=expected), open_store(tmp_path):
            pass
        process.kill()
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


def test_a_run_of_another_machine_is_alive_while_its_heart_beats(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(lease, "SILENCE", 1.0)
    with holding(tmp_path) as process:
        process.send_signal(signal.SIGSTOP)
        held, ended = of_another_machine(tmp_path), threading.Event()

        def beat() -> None:
            for beats in count():
                held.write_text(json.dumps({"host": "elsewhere", "beat": beats}), "utf-8")
                if ended.wait(0.1):
                    return

        heart = threading.Thread(target=beat)
        heart.start()
        with pytest.raises(OutputError, match="another run is writing there"), open_store(tmp_path):
            pass
        ended.set()
        heart.join()
        with open_store(tmp_path):
            assert not held.exists()
        process.kill()


def test_a_run_whose_folder_was_taken_writes_nothing_more(tmp_path: Path) -> None:
    with open_store(tmp_path) as store:
        (held,) = store.home.glob("lease-*")
        held.unlink()
        with pytest.raises(OutputError, match="another run took this folder"):
            store.put({"a": [b"1"]})
    assert not (tmp_path / "a").exists()


def test_a_lease_that_is_half_written_is_dead_if_nobody_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(lease, "SILENCE", 0.2)
    (tmp_path / ".rsegen").mkdir()
    (tmp_path / ".rsegen" / "lease-7").write_text("{")
    write_file([b"1"], tmp_path / "a")
    assert (tmp_path / "a").read_bytes() == b"1"


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
