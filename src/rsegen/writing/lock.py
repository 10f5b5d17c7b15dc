"""The lock of a folder: one run writes there, and one that was killed never keeps others out.

    DIR/.rsegen/lock     {"host": "lab-3", "pid": 4711, "key": "0a1b2c3d"}, locked by the system

A lock of the system ends with its process, however that ends: flock(2) on Linux and macOS, also between containers and,
over NFS, between computers; a locked byte on Windows. So no process has to be looked for, no clock is compared, and a
run that is suspended keeps its folder. What the file says is only for the message of a run that is refused.

On a disk without locks the file itself is the lock: it is new, or it says a process of this computer that is gone. Else
the run is refused, and the message names the file to delete. Of runs that take a dead one's file at once, the last that
writes its key has it; the others see that after `_POLL`, or at their next `check`, before they put anything in place.
Cost: a file of 60 bytes. What breaks it, on a disk without locks: two containers of one host name.
"""

from __future__ import annotations

import errno
import json
import os
import secrets
import stat
import sys
import time
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from rsegen.errors import OutputError, shown
from rsegen.input_files import JOURNAL
from rsegen.writing.stop import held

_POLL = 0.05
"""Seconds between two tries: a release is noticed at once, at 20 small calls a second."""

_TRIES = 0.2
"""Seconds after which a folder counts as taken: longer than another run takes to look whether it is."""

_TAKEN = frozenset({errno.EWOULDBLOCK, errno.EAGAIN, errno.EACCES, errno.EDEADLK})
_NO_LOCKS = frozenset({errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP, errno.ENOTSUP, errno.EINVAL})
"""Errors of a file that another process has locked, and of a disk that has no locks."""

_FAR = 2**30
"""The byte that is locked on Windows: far behind the content, which others read."""

_OPEN = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
"""Flags that open neither a link nor, for ever, a pipe."""


class Lock:
    """The right to write into a folder: from `take` until `release`, or as long as this process lives."""

    def __init__(self, folder: Path, home: Path) -> None:
        self._folder, self._path = folder, home / "lock"
        self._descriptor: int | None = None
        self._entry = {**_here(), "key": secrets.token_hex(4)}

    @property
    def is_taken(self) -> bool:
        """Return whether this run has the folder."""
        return self._descriptor is not None

    def take(self, wait: float) -> None:
        """Take the lock, by a file in the hidden folder, which is made; an OutputError if another run has it.

        wait: seconds to wait for the other run
        """
        end = time.monotonic() + max(wait, _TRIES)
        while True:
            is_last, gone = time.monotonic() > end, None
            with held():
                try:
                    self._make_home()
                    self._try(is_last=is_last)
                except FileNotFoundError as error:  # the run that had it has just removed the hidden folder
                    gone = error
            if self.is_taken:
                return
            if is_last:
                refuse_locked(self._folder)
                if gone:  # for good: a disk such as /proc, on which no folder can be made
                    raise gone
                if time.monotonic() > end + _TRIES:  # until then: the other run ended after the last try
                    raise _busy(self._folder, {})
            time.sleep(_POLL)

    def _make_home(self) -> None:
        """Make the hidden folder if it is missing; FileNotFoundError if another run removes it meanwhile.

        `Path.mkdir(exist_ok=True)` looks once more whether it is there, and then says that it exists.
        """
        home = self._path.parent
        try:
            home.mkdir()
        except FileExistsError:
            if not stat.S_ISDIR(home.stat().st_mode):
                raise

    def check(self) -> None:
        """Raise an OutputError if the file of the lock is gone, or says another run."""
        entry: Mapping[str, object] = {}
        with suppress(OSError, ValueError):
            entry = json.loads(self._path.read_bytes())
        if entry != self._entry:
            raise OutputError(f"{self._folder}: another run took this folder, or its lock was removed")

    def release(self) -> None:
        """End the lock."""
        descriptor, self._descriptor = self._descriptor, None
        if descriptor is None:
            return
        if sys.platform == "win32":  # which removes no file that is open
            os.close(descriptor)
        with suppress(OSError):
            self._path.unlink()
        if sys.platform != "win32":  # nobody gets the lock of a file that is still to be removed
            os.close(descriptor)

    def _try(self, *, is_last: bool) -> None:
        """Take the lock if no other run has it; a file that is still empty on the last try was left by a killed run."""
        try:
            descriptor, is_new = os.open(self._path, os.O_RDWR | os.O_CREAT | os.O_EXCL | _OPEN, 0o666), True
        except FileExistsError:
            descriptor, is_new = os.open(self._path, os.O_RDWR | _OPEN), False
        try:
            # Without locks of the disk only what the file says is known, and a dead run's file may be taken over.
            is_ours, entry = _locked(descriptor), _entry(descriptor)
            takes_over = is_ours is None and not is_new
            if is_ours is False or (takes_over and not (_is_gone(entry) and (entry or is_last))):
                return
            if not os.path.samestat(os.fstat(descriptor), os.stat(self._path)):  # removed since it was opened
                return
            self._descriptor = descriptor
            os.ftruncate(descriptor, 0)
            os.lseek(descriptor, 0, os.SEEK_SET)
            os.write(descriptor, json.dumps(self._entry).encode())
            if takes_over:  # several runs may do so at once: the last to write its key has the lock
                time.sleep(_POLL)
                if _entry(descriptor) != self._entry:
                    self._descriptor = None
        except BaseException:
            self.release()
            raise
        finally:
            if self._descriptor is None:
                with suppress(OSError):  # closed already by `release`
                    os.close(descriptor)


def refuse_locked(folder: Path) -> None:
    """Raise an OutputError if another run writes into a folder.

    A folder with a journal, such as that of a map, may also be written to or replaced by a run in the folder above.
    """
    folder = folder.absolute()
    for locked in (folder, *([folder.parent] if (folder / JOURNAL).exists() else [])):
        try:
            descriptor = os.open(locked / ".rsegen" / "lock", os.O_RDWR | _OPEN)
        except OSError:
            continue
        try:
            entry, is_free = _entry(descriptor), _locked(descriptor)
        finally:
            os.close(descriptor)
        is_alive = is_free is False or (is_free is None and not _is_gone(entry))
        is_own = all(entry.get(key) == value for key, value in _here().items())
        if is_alive and (locked == folder or not is_own):  # this run may write below its folder too
            raise _busy(locked, entry)


def _busy(folder: Path, entry: Mapping[str, object]) -> OutputError:
    who = f" (process {shown(entry.get('pid'))} on {shown(entry.get('host'))})" if entry else ""  # not yet written
    advice = f"wait for it, or stop it; if it no longer exists, delete {folder / '.rsegen' / 'lock'}"
    return OutputError(f"{folder}: another run is writing there{who}; {advice}")


def _locked(descriptor: int) -> bool | None:
    """Lock a file until it is closed; False if another run has it, None if the disk has no locks."""
    try:
        if sys.platform == "win32":
            import msvcrt

            os.lseek(descriptor, _FAR, os.SEEK_SET)
            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        else:
            import fcntl

            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        if error.errno not in _TAKEN | _NO_LOCKS:
            raise
        return False if error.errno in _TAKEN else None
    return True


def _entry(descriptor: int) -> Mapping[str, object]:
    """Return what a lock says; nothing if it is half written."""
    try:
        os.lseek(descriptor, 0, os.SEEK_SET)
        entry = json.loads(os.read(descriptor, 4096))
    except (OSError, ValueError):
        return {}
    return entry if isinstance(entry, dict) else {}


def _here() -> dict[str, object]:
    """Return what every lock of this process says."""
    host = os.uname().nodename if hasattr(os, "uname") else os.environ.get("COMPUTERNAME", "")
    return {"host": host, "pid": os.getpid()}


def _is_gone(entry: Mapping[str, object]) -> bool:
    """Return whether the process of a lock has ended, if it was one of this computer; for disks without locks."""
    import psutil

    host, pid = (entry.get(key) for key in ("host", "pid"))
    return not entry or (host == _here()["host"] and isinstance(pid, int) and not psutil.pid_exists(pid))
