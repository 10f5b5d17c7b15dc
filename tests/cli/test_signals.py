"""A signal at any moment: one line at most, never a traceback."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

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
    """Whether a process has a function for a signal, as Linux says; or has ended."""
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
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM"])
@pytest.mark.parametrize("command", COMMANDS.values(), ids=COMMANDS)
def test_a_signal_at_any_moment_ends_a_command_in_one_line(folder: Path, command: list[str], name: str) -> None:
    for moment in MOMENTS:
        process = started(*command, stdout=subprocess.DEVNULL)
        until(lambda process=process: catches(process, signal.SIGTERM) or process.poll() is not None)  # type: ignore[misc]
        time.sleep(moment)
        process.send_signal(getattr(signal, name))
        _, err = process.communicate(timeout=PATIENCE)
        ended = process.returncode, err.count("\n")
        assert ended in {(1, 1), (0, 0)}, (moment, ended, err)
        if ended == (0, 0):  # and so will it be at every later moment
            break
        assert err.startswith("rsegen: stopped"), err


def test_signals_are_heeded_before_anything_heavy_is_imported() -> None:
    code = "import sys, rsegen.__main__; print(*sys.modules)"
    modules = run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert "rsegen.__main__" in modules
    assert not {"argparse", "numpy", "re", "typing", "rsegen.cli", "rsegen.errors"} & set(modules)


def test_a_stop_that_python_loses_is_repeated(folder: Path) -> None:
    """An exception in a callback of a weak reference, as the import system has them, goes nowhere."""
    (folder / "plugin.py").write_text(
        "import signal, time, weakref\n"
        "from rsegen.cli import examples\n"
        "class Some: pass\n"
        "def run(arguments):\n"
        "    one = Some()\n"
        "    lost = weakref.ref(one, lambda _: signal.raise_signal(signal.SIGINT))\n"
        "    del one\n"
        "    time.sleep(60)\n"
        "examples.run = run\n"
    )
    process = started("--plugin", "plugin.py", "examples")
    _, err = process.communicate(timeout=PATIENCE)
    assert (process.returncode, err) == (1, "rsegen: stopped\n")


IMPORTS = {
    "drops it": "try: signal.raise_signal(signal.SIGINT)\nexcept: pass\n",  # as compiled modules do
    "never ends": "signal.raise_signal(signal.SIGINT)\nwhile True: time.sleep(60)\n",
}


@pytest.mark.parametrize("lines", IMPORTS.values(), ids=IMPORTS)
def test_a_stop_while_a_module_is_imported_is_not_lost(folder: Path, lines: str) -> None:
    (folder / "imported.py").write_text("import signal, time\n" + lines)
    (folder / "plugin.py").write_text(
        "import sys, time\n"
        "from rsegen.cli import examples\n"
        "sys.path.append('.')\n"
        "def run(arguments):\n"
        "    import imported\n"
        "    time.sleep(60)\n"
        "examples.run = run\n"
    )
    process = started("--plugin", "plugin.py", "examples")
    _, err = process.communicate(timeout=PATIENCE)
    assert (process.returncode, err) == (1, "rsegen: stopped\n")


@pytest.mark.parametrize(
    "command", [["info", "peak"], ["obstacles"], ["metrics", "peak"], ["schema"]], ids=lambda c: c[0]
)
def test_a_command_that_writes_nothing_says_stopped_and_no_more(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, command: list[str]
) -> None:
    from importlib import import_module

    from rsegen.cli import main

    def stopped(_: object) -> None:
        signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(import_module(f"rsegen.cli.{command[0]}"), "run", stopped)
    assert main(command) == 1
    assert capsys.readouterr() == ("", "rsegen: stopped\n")
