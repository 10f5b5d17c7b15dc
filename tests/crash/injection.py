"""Which call of a run fails, and how: the settings of inject.c, which is compiled here, and the memory they share."""

from __future__ import annotations

import ctypes
import errno
import functools
import mmap
import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

_SOURCE = Path(__file__).with_name("inject.c")
_FILES = 4096

MODES = ("count", "kill", "killafter", "fail", "full", "short", "interrupt", "stop", "stuck", "dead")
"""Events at the k-th call, in the order of inject.c; from it on, `stuck` renames fail, or all calls: `dead`."""

ERRORS = (errno.EIO, errno.ENOSPC, errno.EACCES, errno.EPERM, errno.EDQUOT, errno.EROFS)


class _File(ctypes.Structure):
    _fields_ = (("inode", ctypes.c_uint64), ("size", ctypes.c_int64))


class Control(ctypes.Structure):
    """`struct control` of inject.c."""

    _fields_ = (
        *((name, ctypes.c_int32) for name in ("group", "main", "mode", "error", "alone", "no_locks", "no_exchange")),
        *((name, ctypes.c_int32) for name in ("full", "cut", "busy", "every", "renames")),
        *((name, ctypes.c_int64) for name in ("k", "calls", "by_workers", "files")),
        ("unsynced", _File * _FILES),
        ("call", ctypes.c_char * 32),
        ("path", ctypes.c_char * 1024),
        ("root", ctypes.c_char * 1024),
    )


@dataclass(frozen=True, kw_only=True, slots=True)
class Injection:
    """Event in a run at the k-th of its calls that write below the folder; nothing if k is 0.

    error: errno of `fail`, `stuck`, `dead` and of the end of `short`   every: which renames are `stuck`, 1: all
    alone: `kill` kills one process only
    power: the power fails with the kill: what was not synced is lost   no_locks, no_exchange: what the disk lacks
    """

    mode: str = "count"
    k: int = 0
    error: int = 0
    every: int = 1
    alone: bool = False
    power: bool = False
    no_locks: bool = False
    no_exchange: int = 0

    @property
    def kills(self) -> bool:
        """Return whether it kills."""
        return self.mode in ("kill", "killafter")

    def __str__(self) -> str:
        words = [f"{self.mode} at call {self.k}"]
        words += [errno.errorcode[self.error]] if self.error else []
        words += [f"every {self.every}"] if self.mode == "stuck" else []
        words += [word for word in ("alone", "power", "no_locks") if getattr(self, word)]
        words += [f"no exchange ({errno.errorcode[self.no_exchange]})"] if self.no_exchange else []
        return ", ".join(words)

    def set(self, control: Control, root: str) -> None:
        """Write it into the shared memory, with nothing counted; no process is watched yet."""
        ctypes.memset(ctypes.addressof(control), 0, ctypes.sizeof(control))
        control.mode, control.k, control.error = MODES.index(self.mode), self.k, self.error or errno.ENOSPC
        control.alone, control.no_locks, control.no_exchange = self.alone, self.no_locks, self.no_exchange
        control.every, control.root = self.every, os.fsencode(root)


def mapped_control(path: str | Path) -> Control:
    """The shared memory in a file, which is made if it does not exist."""
    with open(path, "ab") as file:
        file.truncate(ctypes.sizeof(Control))
    with open(path, "r+b") as file:
        return Control.from_buffer(mmap.mmap(file.fileno(), ctypes.sizeof(Control)))


@functools.cache
def missing() -> str:
    """Reason why no call can be made to fail here; an empty text if it can."""
    if sys.platform != "linux":
        return "only Linux has LD_PRELOAD and /proc/self/fd"
    return "" if shutil.which("cc") else "no C compiler: apt-get install gcc libc6-dev"


def compiled(folder: Path) -> Path:
    """The library, compiled into a folder."""
    library = folder / "inject.so"
    subprocess.run(["cc", "-shared", "-fPIC", "-O1", "-o", library, _SOURCE, "-ldl"], check=True)
    return library
