"""A lease of a folder, which says which run may write there, needs no locks of the disk, and tells a dead run.

    DIR/.rsegen/lease-3     {"host": ..., "pid": ..., "started": ..., "beat": 17, ...}

A lease is a file that is created if it does not exist, which every disk can do, also one of a network. Whoever finds a
dead one creates the next number: of two that try, one fails. On the same machine a run is dead if its process is gone.
Of another machine, whose processes cannot be seen, it is dead if its heartbeat stands still; no clock is compared. A
run that was only suspended notices by the higher number that its lease is lost, and stops before it writes on.

Source: our own (decision 15); `flock` is missing on many network disks, and tells nothing about who has it. Cost: a
file, and a thread that writes 200 bytes every two seconds. What breaks it: a disk of a network that shows a heartbeat
later than SILENCE, and two containers that share a folder, host name and process ids.
"""

from __future__ import annotations

import json
import os
import sys
import threading
import time
from collections.abc import Mapping
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

from rsegen.errors import OutputError, shown
from rsegen.input_files import JOURNAL

BEAT = 2.0
"""Seconds between two heartbeats."""

SILENCE = 10.0
"""Seconds without a heartbeat after which the run of another machine counts as dead: five beats, as disks are slow."""

_POLL = 0.05
"""Seconds between two looks at a lease: a beat or a release is noticed at once, at 20 small reads a second."""


class Lease:
    """The right to write into a folder, as long as this process lives or until `release`."""

    def __init__(self, home: Path, number: int) -> None:
        self._path = home / f"lease-{number}"
        self._next = home / f"lease-{number + 1}"
        self._entry: dict[str, Any] = {**_place(), "pid": os.getpid(), "started": _started(os.getpid()), "beat": 0}
        descriptor = os.open(self._path, os.O_WRONLY | os.O_CREAT | os.O_EXCL)
        try:
            os.write(descriptor, json.dumps(self._entry).encode())
        except BaseException:
            self._path.unlink()
            raise
        finally:
            os.close(descriptor)
        self._ended = threading.Event()
        self._heart = threading.Thread(target=self._beat, daemon=True, name="rsegen lease")
        self._heart.start()

    def check(self) -> None:
        """Raise an OutputError if another run has taken the folder, as this one seemed dead."""
        if self._next.exists() or not self._path.exists():
            raise OutputError(f"{self._path.parent.parent}: another run took this folder, as this one stood still")

    def release(self) -> None:
        """End the lease."""
        self._ended.set()
        self._heart.join()
        with suppress(OSError):
            self._path.unlink()

    def _beat(self) -> None:
        while not self._ended.wait(BEAT):
            self._entry["beat"] += 1
            with suppress(OSError), open(self._path, "r+b") as file:  # not created again once it is lost
                file.write(json.dumps(self._entry).encode())


def wait_until_free(home: Path, wait: float) -> None:
    """Return when no run that is alive has a hidden folder; an OutputError if one has it for `wait` seconds more."""
    end = time.monotonic() + wait
    while time.monotonic() < end:
        with suppress(OutputError):
            refuse_leased(home)
            return
        time.sleep(_POLL)
    refuse_leased(home)


def take(home: Path) -> Lease | None:
    """Return the lease of a hidden folder that is free, None if another run was quicker."""
    held = _held(home)
    try:
        lease = Lease(home, _number(held) + 1 if held else 1)
    except FileExistsError:
        return None
    for old in _leases(home)[:-1]:
        old.unlink(missing_ok=True)
    return lease


def refuse_leased(home: Path) -> None:
    """Raise an OutputError if a run that is alive has a folder, given by its hidden folder.

    A folder with a journal, such as that of a map, may also be written to or replaced by a run in the folder above.
    """
    folder = home.parent.absolute()
    for leased in (folder, *([folder.parent] if (folder / JOURNAL).exists() else [])):
        held = _held(leased / home.name)
        entry = (_read(held) if held else None) or {}
        is_own = entry.get("pid") == os.getpid() and _is_of_here(entry)  # which may write below the folder too
        if held and (leased == folder or not is_own) and is_alive(held):
            who = f"process {shown(entry.get('pid'))} on {shown(entry.get('host'))}"
            raise OutputError(f"{leased}: another run is writing there ({who}); wait for it, or stop it")


def is_alive(path: Path) -> bool:
    """Return whether the run of a lease is alive."""
    entry = _read(path)
    if entry is not None and _is_of_here(entry):
        return entry.get("started") == _started(entry.get("pid"))
    end = time.monotonic() + (SILENCE if entry else BEAT)  # a lease that is being written is so for a moment only
    while time.monotonic() < end:
        time.sleep(_POLL)
        if not path.exists():
            return False
        if _read(path) != entry:
            return True
    return False


def _held(home: Path) -> Path | None:
    """Return the last lease of a hidden folder."""
    leases = _leases(home)
    return leases[-1] if leases else None


def _leases(home: Path) -> list[Path]:
    with suppress(OSError):
        return sorted((path for path in home.glob("lease-*") if path.name[6:].isdecimal()), key=_number)
    return []


def _number(path: Path) -> int:
    return int(path.name[6:])


def _read(path: Path) -> Mapping[str, Any] | None:
    """Return what a lease says, None while it is being written."""
    try:
        entry = json.loads(path.read_bytes()[:4096])  # a lease has some 200 bytes
    except (OSError, ValueError):
        return None
    return entry if isinstance(entry, dict) else None


def _is_of_here(entry: Mapping[str, Any]) -> bool:
    return {key: entry.get(key) for key in _place()} == _place()


@cache
def _place() -> dict[str, str]:
    """Return where the processes are that can be seen here: one start of a machine, one container."""
    place = {"host": os.uname().nodename if hasattr(os, "uname") else os.environ.get("COMPUTERNAME", "")}
    with suppress(OSError):
        place["boot"] = Path("/proc/sys/kernel/random/boot_id").read_text("ascii").strip()
        place["processes"] = os.readlink("/proc/self/ns/pid")
    return place


def _started(pid: object) -> str | None:
    """Return when a process was started, None if there is no such process: a number alone is given again."""
    if not isinstance(pid, int) or pid <= 0:
        return None
    if sys.platform != "linux":
        import psutil

        try:
            return str(psutil.Process(pid).create_time())
        except psutil.Error:
            return None
    try:
        fields = Path(f"/proc/{pid}/stat").read_text("utf-8", "replace").rpartition(")")[2].split()
    except OSError:
        return None
    return None if fields[0] in "ZX" else fields[19]  # 3 is the state, 22 the start: proc(5)
