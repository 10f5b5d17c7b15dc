"""Waits for a simulator, on a clock that the tests turn."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable
from itertools import count
from pathlib import Path

import pytest

from rsegen.simulators import patience
from rsegen.simulators.patience import Patience
from rsegen.simulators.process import OutputFiles, Work
from rsegen.writing.programs import LaunchCommand
from tests.support.patience import until

STEP = 0.25


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> None:
    """A clock that goes on by STEP at each look, on a machine with a processor to spare."""
    monkeypatch.setattr(time, "monotonic", map(STEP.__mul__, count()).__next__)
    monkeypatch.setattr(patience, "share", lambda: 1.0)


def waited(seconds: float, works: Callable[[], bool] = lambda: False) -> float:
    """Seconds of the clock until patience is over."""
    wait = Patience(seconds=seconds, works=works).begin()
    return STEP * next(look for look in count(1) if wait.is_over)


@pytest.mark.usefixtures("clock")
def test_on_a_quiet_machine_patience_is_over_after_its_seconds() -> None:
    assert waited(20) == 20


@pytest.mark.usefixtures("clock")
def test_among_fifty_programs_on_two_processors_it_lasts_25_times_as_long(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(patience, "share", lambda: 2 / 50)
    assert waited(20) == pytest.approx(500, rel=0.06)


@pytest.mark.usefixtures("clock")
def test_a_program_that_works_is_waited_for_and_one_in_an_endless_loop_is_given_up() -> None:
    looks = iter([True] * 50)
    assert waited(20, lambda: next(looks, False)) == 70
    assert waited(20, lambda: True) == 600


def test_the_share_is_a_half_if_twice_as_many_programs_as_processors_want_to_run(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    processors = os.cpu_count() or 1
    for running, share in ((1, 1.0), (processors, 1.0), (2 * processors, 0.5)):
        monkeypatch.setattr(patience, "_programs_that_run", lambda running=running: float(running))
        assert patience.share() == share


@pytest.mark.skipif(not Path("/proc/loadavg").exists(), reason="elsewhere the system gives a mean of a minute")
def test_programs_that_run_are_counted_at_once() -> None:
    busy = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(5)]
    try:
        until(lambda: patience._programs_that_run() >= len(busy))
    finally:
        for program in busy:
            program.kill()
            program.wait()


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="a shell's script")
@pytest.mark.parametrize(
    ("script", "works"), [("sleep 60", False), ("while :; do :; done", True), ("(while :; do :; done) & wait", True)]
)
def test_a_program_works_that_uses_a_processor(script: str, works: bool, tmp_path: Path) -> None:
    launch = LaunchCommand(command=("/bin/sh", "-c", script), environment={}, folder=tmp_path)
    with OutputFiles(folder=tmp_path).running(launch) as program:
        work = Work(program, tmp_path)
        if works:
            until(work)
        else:
            work()
            assert not any(work() for _ in range(20))


@pytest.mark.skipif(sys.platform == "win32", reason="a shell's script")
def test_a_program_works_that_writes_into_its_log(tmp_path: Path) -> None:
    launch = LaunchCommand(
        command=("/bin/sh", "-c", "while read line; do :; done; sleep 60"), environment={}, folder=tmp_path
    )
    output = OutputFiles(folder=tmp_path)
    with output.running(launch) as program:
        work = Work(program, tmp_path)
        until(lambda: not work())
        with output.paths[1].open("a") as log:
            log.write("[Msg] more\n")
        assert work()
