"""A signal at any moment: one line at most, never a traceback."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from itertools import product
from pathlib import Path

import pytest

from rsegen.cli.edge import main
from tests.support.long import long_unless
from tests.support.patience import PATIENCE, run, until
from tests.support.runs import started

MOMENTS = [0, 0.003, 0.01, 0.02, 0.03, 0.05, 0.08, 0.12, 0.2, 0.3, 0.5, 1.0, 1.5]
"""Seconds between the moment from which on rsegen catches signals and the signal."""
COMMANDS = {
    "generate": ["generate", "peak", "--maps", "300", "--workers", "1", "--force", "-o", "out"],
    "help": ["--help"],
    "info": ["info", "--obstacle", "random levels=5", "--chunks", "40"],
    "preview": ["preview", "peak", "--force", "-o", "p.png"],
}


def catches(process: subprocess.Popen[str], number: int) -> bool:
    """Return whether a process has a function for a signal, as Linux says; or has ended."""
    try:
        lines = Path(f"/proc/{process.pid}/status").read_text().splitlines()
    except OSError:
        return True
    masks = [int(line.split()[1], 16) for line in lines if line.startswith("SigCgt:")]
    return not masks or bool(masks[0] >> (number - 1) & 1)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="only Linux says which signals a process catches")
@pytest.mark.parametrize(
    ("command", "name"),
    long_unless(
        {("generate", "SIGINT"), ("preview", "SIGTERM")}.__contains__,
        product(COMMANDS, ["SIGINT", "SIGTERM"]),
        reason="many moments per command and signal",
    ),
)
def test_a_signal_at_any_moment_ends_a_command_in_one_line(folder: Path, command: str, name: str) -> None:
    for moment in MOMENTS:
        process = started(*COMMANDS[command], stdout=subprocess.DEVNULL)
        until(lambda process=process: catches(process, signal.SIGTERM) or process.poll() is not None)  # type: ignore[misc]
        time.sleep(moment)
        process.send_signal(getattr(signal, name))
        _, err = process.communicate(timeout=PATIENCE)
        ended = process.returncode, err.count("\n")
        number = getattr(signal, name)  # CPython ends by SIGINT itself if that came during an `exec`: 130 to a shell
        assert ended in {(128 + number, 1), (-number, 1), (0, 0)}, (moment, ended, err)
        if ended == (0, 0):  # and so will it be at every later moment
            break
        assert err.startswith("rsegen: stopped"), err


def test_signals_are_heeded_before_anything_heavy_is_imported() -> None:
    code = "import sys, rsegen.__main__; print(*sys.modules)"
    modules = run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert "rsegen.__main__" in modules
    assert not {"argparse", "numpy", "re", "typing", "rsegen.cli", "rsegen.errors"} & set(modules)


def plugin(folder: Path, *lines: str) -> None:
    """Let `examples` do something else."""
    run = "".join(f"    {line}\n" for line in lines)
    (folder / "plugin.py").write_text(
        "import signal, time\nfrom rsegen.cli import reference\n"
        f"def run(arguments):\n{run}reference.run_examples = run\n"
    )


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_the_exit_code_names_the_signal(folder: Path, name: str) -> None:
    plugin(folder, f"signal.raise_signal(signal.{name})", "time.sleep(60)")
    process = started("--plugin", "plugin.py", "examples")
    _, err = process.communicate(timeout=PATIENCE)
    assert (process.returncode, err) == (128 + getattr(signal, name), "rsegen: stopped\n")


def test_a_later_ctrl_c_ends_a_command_that_ignored_the_first(folder: Path) -> None:
    lose = "try: signal.raise_signal(signal.SIGINT)", "except BaseException: print('lost', flush=True)"
    plugin(folder, *lose, "time.sleep(1.1)", "signal.raise_signal(signal.SIGINT)", "time.sleep(60)")
    process = started("--plugin", "plugin.py", "examples")
    out, err = process.communicate(timeout=PATIENCE)
    assert (process.returncode, out, err) == (130, "lost\n", "rsegen: ended at once; what is complete stays\n")


def test_signals_that_follow_at_once_are_one_stop(folder: Path) -> None:
    clearing = "finally: [signal.raise_signal(each) for each in (signal.SIGINT, signal.SIGHUP, signal.SIGTERM)]"
    plugin(folder, "try: signal.raise_signal(signal.SIGINT)", clearing)
    process = started("--plugin", "plugin.py", "examples")
    _, err = process.communicate(timeout=PATIENCE)
    assert (process.returncode, err) == (130, "rsegen: stopped\n")


@pytest.mark.slow
def test_a_closed_terminal_ends_workers_without_a_word(folder: Path) -> None:
    many = ["generate", "--obstacle", "random levels=5", "--seed", "7", "--maps", "50000", "--workers", "2"]
    command = [sys.executable, "-m", "rsegen", *many, "-o", "out"]
    process = subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    until(lambda: len(list(folder.glob("out/*"))) > 20)
    os.killpg(process.pid, signal.SIGHUP)
    _, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 129
    assert err.count("\n") == 1
    assert err.startswith("rsegen: stopped; ")
    assert not list(folder.glob("out/.rsegen"))


@pytest.mark.parametrize(
    "command", [["info", "peak"], ["obstacles"], ["metrics", "peak"], ["schema"]], ids=lambda c: c[0]
)
def test_a_command_that_writes_nothing_says_stopped_and_no_more(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, command: list[str]
) -> None:
    from importlib import import_module

    from rsegen.cli.edge import main
    from rsegen.params.capabilities import commands

    def stopped(_: object) -> None:
        signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(import_module(commands()[command[0]].module), f"run_{command[0]}", stopped)
    assert main(command) == 130
    assert capsys.readouterr() == ("", "rsegen: stopped\n")


@pytest.mark.parametrize(("signals", "code", "said"), [(1, 130, "rsegen: stopped\n"), (0, 1, "rsegen: internal error")])
def test_an_import_that_a_signal_breaks_is_a_stop(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], signals: int, code: int, said: str
) -> None:
    """numpy's core raises an ImportError of its own in place of the KeyboardInterrupt."""

    def importing(_: object) -> None:
        with suppress(KeyboardInterrupt):
            for _ in range(signals):
                signal.raise_signal(signal.SIGINT)
        raise ImportError("PyCapsule_Import could not import module")

    monkeypatch.setattr("rsegen.cli.reference.run_examples", importing)
    assert main(["examples"]) == code
    assert capsys.readouterr().err.startswith(said)
