"""Small files of running processes in the user's state folder, which a later process reads: drafts, open simulations.

    $XDG_STATE_HOME/rsegen/NAME-PID.json    what the process PID says under a name; only the user can read it

A file is written whole, next to its place, and then renamed, so a kill leaves the one before. One of a process that was
killed stays: whether its process still runs is asked of the system, by its id and its time of start.
"""

from __future__ import annotations

import getpass
import json
import os
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any


def home_folder() -> Path:
    """Return the user's home; of a user of whom the system knows none, as in containers, a place that has no files."""
    try:
        return Path.home()
    except RuntimeError:
        return Path(os.devnull)


def user_name() -> str:
    """Return the name that the system has of the user; the number of one whom it does not know, as in containers."""
    if sys.platform == "win32":
        return getpass.getuser()
    import pwd

    try:
        return pwd.getpwuid(os.getuid()).pw_name
    except KeyError:
        return str(os.getuid())


def state_folder() -> Path:
    """Return the folder for what programs keep of a user between their runs, after the XDG base directories."""
    named = os.environ.get("XDG_STATE_HOME", "")  # the specification says that a relative path is to be ignored
    return (Path(named) if os.path.isabs(named) else home_folder() / ".local" / "state") / "rsegen"


def state_file(name: str) -> Path:
    """Return the file of this process under a name."""
    return state_folder() / f"{name}-{os.getpid()}.json"


def create_private(path: Path, text: str) -> None:
    """Write a new file in the state folder that only the user can read; an OSError if it cannot be, or exists."""
    path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
    with open(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="utf-8") as file:
        file.write(text)


def write_state(name: str, content: Any) -> None:
    """Write the file of this process; an OSError if that fails, which leaves the one before."""
    path = state_file(name)
    new = path.with_suffix(f".{os.urandom(4).hex()}")
    try:
        create_private(new, json.dumps(content))
        new.replace(path)
    except OSError:
        with suppress(OSError):
            new.unlink(missing_ok=True)
        raise


def state_files(name: str) -> Iterator[tuple[Path, bool]]:
    """Yield the files under a name, the newest first, and whether the process of each still runs."""
    paths = [path for path in state_folder().glob(f"{name}-*.json") if path.stem.rpartition("-")[2].isdecimal()]
    for path in sorted(paths, key=_changed_at, reverse=True):
        yield path, _runs(path)


def _changed_at(path: Path) -> float:
    with suppress(OSError):
        return path.stat().st_mtime
    return 0.0


def _runs(path: Path) -> bool:
    """Return whether the process that wrote a file still runs; a later process may have its id, but started later."""
    import psutil

    try:
        process = psutil.Process(int(path.stem.rpartition("-")[2]))
        ended = process.status() in (psutil.STATUS_ZOMBIE, psutil.STATUS_DEAD)  # a parent has not asked for it yet
        return not ended and process.create_time() < _changed_at(path) + 1
    except (psutil.NoSuchProcess, OverflowError):
        return False
    except psutil.Error:  # of another user, perhaps
        return True
