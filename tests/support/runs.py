"""The command as a process of its own, and what it leaves."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tests.support.patience import CPU_SECONDS, PATIENCE, until


def started(
    *arguments: str | Path, before: str = "", after: str = "", stdout: Any = subprocess.PIPE, **environment: str
) -> subprocess.Popen[str]:
    """The command as a process of its own, which buffers what it prints; `before` and `after` are the shell's.

    The system ends it if it has used more CPU time than any test needs.
    """
    own = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")} | environment
    shell = ["/bin/sh", "-c", f'ulimit -t {CPU_SECONDS}; {before} exec "$@" {after}', "sh"]
    command = [*shell, sys.executable, "-m", "rsegen", *map(str, arguments)]
    return subprocess.Popen(command, stdout=stdout, stderr=subprocess.PIPE, text=True, env=own)


def started_with_small_files(*arguments: str | Path) -> subprocess.Popen[str]:
    """It may write no file above a few kilobytes; nor any of Python's own, which Python would leave cut off."""
    return started(*arguments, before="ulimit -f 20;", PYTHONDONTWRITEBYTECODE="1")


def ended(process: subprocess.Popen[str]) -> tuple[int, str]:
    """Its exit code and what it said on stderr."""
    _, err = process.communicate(timeout=PATIENCE)
    return process.returncode, err


def whole_maps_only(folder: Path) -> bool:
    made = {frozenset(path.name.replace(one.name, "") for path in one.rglob("*")) for one in folder.iterdir()}
    return len(made) == 1 and all(one.name.startswith("rse_") for one in folder.iterdir())


def until_it_has(process: subprocess.Popen[str], made: Callable[[], object]) -> None:
    """Wait until a process has made something; it may not end before."""

    def holds() -> object:
        assert process.poll() is None, process.communicate()
        return made()

    until(holds)


def until_there(process: subprocess.Popen[str], folder: Path, maps: int) -> None:
    """Wait until a run has made this many maps."""
    until_it_has(process, lambda: len(list(folder.glob("[!.]*"))) >= maps)


def contents(folder: Path) -> dict[str, bytes]:
    """Every file in a folder."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
