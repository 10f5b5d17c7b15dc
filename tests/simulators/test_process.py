"""Nothing is left of what was started, however it ends and whatever it started itself."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from contextlib import suppress
from itertools import product
from pathlib import Path
from typing import Any

import psutil
import pytest

from rsegen.cli.edge import Signals
from rsegen.errors import SimulatorFailed
from rsegen.simulators import process
from rsegen.simulators.patience import Patience
from rsegen.simulators.process import OutputFiles, Work, command_output
from rsegen.writing.programs import LaunchCommand, running
from tests.support.leftovers import MARK, left, left_in_the_end
from tests.support.long import long_unless

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="sessions of processes are POSIX")

PATIENCE = 180
"""Seconds, many times what a busy machine needs: only a hang takes so long."""

POLITE = 'trap "echo asked >>told; exit 0" INT; echo begun >>told; while :; do sleep 0.05; done'
STUBBORN = 'trap "" INT; echo begun >>told; while :; do sleep 0.05; done'
A_GROUP_OF_ITS_OWN = f"""{sys.executable} -c 'import os, time
os.setpgid(0, 0)
open("told", "w").close()
time.sleep(60)' & wait"""
A_CHILD_LEFT_BEHIND = "sleep 60 & echo begun >>told"
SCRIPTS = (POLITE, STUBBORN, A_GROUP_OF_ITS_OWN, A_CHILD_LEFT_BEHIND)

OUTER = """
import sys, time
from pathlib import Path
from rsegen.writing.programs import LaunchCommand
from rsegen.writing.programs import running
launch = LaunchCommand(command=("/bin/sh", "-c", sys.argv[1]), environment={}, folder=Path(sys.argv[2]))
with running(launch, sys.stderr):
    Path(sys.argv[2], "entered").touch()
    time.sleep(60)
"""


@pytest.fixture(autouse=True)
def mark(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """A variable by which all is known that a test has started."""
    monkeypatch.setenv(MARK, str(tmp_path))
    return str(tmp_path)


def shell(script: str, folder: Path) -> LaunchCommand:
    return LaunchCommand(command=("/bin/sh", "-c", script), environment={}, folder=folder)


def until_begun(folder: Path, sign: str = "told") -> None:
    end = time.monotonic() + PATIENCE
    while not (folder / sign).exists():
        assert time.monotonic() < end
        time.sleep(0.01)


@pytest.mark.parametrize(
    "script", long_unless({POLITE, STUBBORN}.__contains__, SCRIPTS, reason="seconds until what does not obey is killed")
)
def test_nothing_is_left_after_the_end(script: str, tmp_path: Path, mark: str) -> None:
    with running(shell(script, tmp_path), subprocess.DEVNULL) as program:
        until_begun(tmp_path)
        assert left(mark)
    assert program.exit_code is not None
    assert left(mark) == []


def test_it_is_asked_before_it_is_killed(tmp_path: Path, mark: str) -> None:
    with running(shell(POLITE, tmp_path), subprocess.DEVNULL) as program:
        until_begun(tmp_path)
    assert (tmp_path / "told").read_text() == "begun\nasked\n"
    assert program.exit_code == 0


def test_a_server_is_killed_if_its_watch_was_killed(tmp_path: Path, mark: str) -> None:
    with running(shell(STUBBORN, tmp_path), subprocess.DEVNULL) as program:
        until_begun(tmp_path)
        program.watch.kill()
    assert program.exit_code == -signal.SIGKILL
    assert left_in_the_end(mark) == []


def test_nothing_is_left_after_an_exception(tmp_path: Path, mark: str) -> None:
    def fail() -> None:
        with running(shell(POLITE, tmp_path), subprocess.DEVNULL):
            until_begun(tmp_path)
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail()
    assert left(mark) == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("script", "word"),
    long_unless(
        {(POLITE, "SIGINT"), (A_GROUP_OF_ITS_OWN, "SIGKILL")}.__contains__,
        [
            *product([POLITE], ["SIGINT", "SIGTERM", "SIGHUP"]),
            *product([STUBBORN], ["SIGINT", "SIGKILL"]),
            *product([A_GROUP_OF_ITS_OWN], ["SIGKILL"]),
        ],
        reason="seconds until what does not obey is killed",
    ),
)
def test_nothing_is_left_when_rsegen_is_killed(script: str, word: str, tmp_path: Path, mark: str) -> None:
    outer = subprocess.Popen([sys.executable, "-c", OUTER, script, str(tmp_path)], stderr=subprocess.DEVNULL)
    until_begun(tmp_path)
    until_begun(tmp_path, "entered")  # before that, Python may lose an interrupt in a destructor
    outer.send_signal(signal.Signals[word])
    outer.wait(PATIENCE)
    assert left_in_the_end(mark) == []


def test_a_command_that_does_not_answer_in_time_is_gone_and_an_error_if_it_printed_nothing(
    mark: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(process, "_SHORT_COMMAND", Patience(seconds=0.3))
    with pytest.raises(SimulatorFailed, match=r"^/bin/sh -c 'sleep 60' prints nothing, after 0.3 s without progress$"):
        command_output(["/bin/sh", "-c", "sleep 60"])
    assert command_output(["/bin/sh", "-c", "echo something; sleep 60"]) == "something\n"
    assert left(mark) == []


def test_an_interrupt_waits_until_a_program_is_started(
    tmp_path: Path, mark: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Else a process could be left of which nobody knows."""
    start, started = subprocess.Popen, []

    def interrupted(command: Any, **how: Any) -> subprocess.Popen[str]:
        program: subprocess.Popen[str] = start(command, **how)
        if command[0] == "/bin/sh":  # not the watch
            signal.raise_signal(signal.SIGINT)
            started.append(program)
        return program

    monkeypatch.setattr(subprocess, "Popen", interrupted)
    with (
        Signals().stop_it(),
        pytest.raises(KeyboardInterrupt),
        running(shell("sleep 60", tmp_path), subprocess.DEVNULL),
    ):
        pytest.fail("the interrupt was lost")
    assert started[0].poll() is not None
    assert left(mark) == []


def test_an_interrupt_waits_until_the_work_of_a_program_is_known(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Else psutil leaves open what it reads."""
    children, complete = psutil.Process.children, []

    def interrupted(of: psutil.Process, *, recursive: bool) -> list[psutil.Process]:
        signal.raise_signal(signal.SIGINT)
        complete.append(True)
        return children(of, recursive=recursive)

    monkeypatch.setattr(psutil.Process, "children", interrupted)
    with running(shell("sleep 60", tmp_path), subprocess.DEVNULL) as program, Signals().stop_it():
        with pytest.raises(KeyboardInterrupt):
            Work(program)()
        assert complete


def test_an_interrupt_that_python_drops_ends_the_reading_of_lines_too(tmp_path: Path) -> None:
    output = OutputFiles(folder=tmp_path)
    with output.running(shell("sleep 60", tmp_path)), Signals().stop_it():
        with suppress(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)  # as in a destructor
        with pytest.raises(KeyboardInterrupt):
            next(output.lines(lambda: True))


def test_the_output_of_a_command_is_both_outputs() -> None:
    assert command_output(["/bin/sh", "-c", "echo out; echo err >&2; cat"]) == "out\nerr\n"
