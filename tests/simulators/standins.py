"""Programs that stand in for a simulator's: they tell a version, and write down how they were started.

They print the variable SAYS to stdout and COMPLAINS to stderr, write NOTES to Gazebo Sim's own log, and stay for STAYS
seconds.
"""

from __future__ import annotations

import _thread
import os
import sys
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

import pytest

from rsegen.simulators.process import OutputFiles

_SCRIPT = """\
#!/bin/sh
case "$*" in *--version*) printf '%b' '{told}'; exit 255 ;; esac
{{ pwd; echo "$0"; for each; do echo "$each"; done; echo; env; }} >"$0.new"
mv "$0.new" "$0.started"
if [ "$NOTES" ]; then
  mkdir -p "$HOME/.gz/sim/log/2026"
  printf '%b' "$NOTES" >"$HOME/.gz/sim/log/2026/server_console.log"
fi
printf '%b' "$SAYS"
printf '%b' "$COMPLAINS" >&2
exec sleep "${{STAYS:-0}}"
"""

CLASSIC = "Gazebo multi-robot simulator, version {}\\n"
"""Output of Gazebo Classic's programs for --version, before they exit with 255."""

PROGRAMS: Mapping[str, Mapping[str, str]] = MappingProxyType(
    {
        "classic": {name: CLASSIC.format("11.14.0") for name in ("gzserver", "gzclient", "gazebo", "gz")},
        "sim": {"gz": "8.9.0\\n"},
    }
)
"""For every simulator: its programs, and what each says when it is asked for its version."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Start:
    """Start of a stand-in: folder, command and variables."""

    folder: Path
    command: tuple[str, ...]
    variables: Mapping[str, str]


def put(folder: Path, programs: Mapping[str, str]) -> None:
    """Put stand-ins into a folder."""
    folder.mkdir(exist_ok=True)
    for name, told in programs.items():
        (folder / name).write_text(_SCRIPT.format(told=told))
        (folder / name).chmod(0o755)


def start(program: Path) -> Start:
    """Last start of it."""
    command, _, variables = Path(f"{program}.started").read_text().partition("\n\n")
    folder, *words = command.split("\n")
    pairs = (line.split("=", 1) for line in variables.splitlines() if "=" in line)
    return Start(folder=Path(folder), command=tuple(words), variables=dict(pairs))


def alone_on_path(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of stand-ins, which with their tools are all that is on PATH; and another home."""
    programs = folder / "programs"
    programs.mkdir()
    put_tools(programs)
    monkeypatch.setenv("PATH", path_with(programs))
    monkeypatch.setenv("HOME", str(folder / "home"))
    monkeypatch.setenv("SAYS", "")
    return programs


def path_with(folder: Path) -> str:
    """A PATH on which nothing is but these stand-ins, and what their shell needs."""
    return os.pathsep.join([str(folder), str(folder.parent / "tools")])


def put_tools(folder: Path) -> None:
    """Put the tools that the stand-ins' shell needs, and no simulator."""
    tools = folder.parent / "tools"
    tools.mkdir(exist_ok=True)
    for name in ("env", "mkdir", "mv", "sleep"):
        (tools / name).symlink_to(next(path for path in (Path("/bin", name), Path("/usr/bin", name)) if path.exists()))


@contextmanager
def interrupted_when_started(program: Path, *, while_read: bool = False) -> Iterator[None]:
    """Ctrl-C as soon as a stand-in has started, however long that takes; or then, while its output is read.

    The latter is for what runs without the command line, whose handler makes a Ctrl-C wait until a process is started:
    Python's own raises in the middle of `Popen`, which leaves a process to nobody.
    """
    ended, main = threading.Event(), threading.main_thread().ident

    def may() -> bool:
        frame = sys._current_frames().get(main or 0)
        return not while_read or (frame is not None and frame.f_code is OutputFiles.lines.__code__)

    def interrupt() -> None:
        while not ended.is_set():
            if program.with_name(f"{program.name}.started").exists() and may():
                _thread.interrupt_main()
                return
            time.sleep(0.02)

    watching = threading.Thread(target=interrupt)
    watching.start()
    try:
        yield
    finally:
        ended.set()
        watching.join()
