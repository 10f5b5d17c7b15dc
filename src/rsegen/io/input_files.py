"""Opens files to read so that nothing waits for ever: a pipe that nobody writes to is an error like any other.

Who reads a file of a user opens it by one of these two, and by no other `open`.
"""

from __future__ import annotations

import errno
import os
import select
import stat
from io import BufferedReader
from pathlib import Path

_SECONDS_FOR_A_WRITER = 2.0
"""A program that is started together with rsegen, as by `<(...)`, opens its end of a pipe within this time."""

_SECONDS_OF_SILENCE = 60.0
"""A program that writes into a pipe may work this long before it writes more."""


def open_regular(path: str | Path) -> BufferedReader:
    """A regular file, opened to be read; OSError for anything else, such as a folder, a pipe or a device."""
    file = _opened(path)
    if stat.S_ISREG(os.fstat(file.fileno()).st_mode):
        return file
    file.close()
    raise OSError(errno.EINVAL, "not a regular file", str(path))


def read_start(path: str | Path, most: int) -> bytes:
    """Up to `most` bytes of a file, a device, or a pipe that somebody writes to; OSError if it cannot be read."""
    with _opened(path) as file:
        descriptor = file.fileno()
        kind = os.fstat(descriptor).st_mode
        if stat.S_ISFIFO(kind):
            return _read_pipe(descriptor, most)
        if not stat.S_ISREG(kind):
            os.set_blocking(descriptor, True)  # a terminal, at which a person types
        return file.read(most)


def regular_content(path: str | Path, most: int) -> bytes | None:
    """Up to `most` bytes of a regular file; None if there is none at the path, or it cannot be read."""
    try:
        with open_regular(path) as file:
            return file.read(most)
    except OSError:
        return None


def _opened(path: str | Path) -> BufferedReader:
    """Opened at once: without O_NONBLOCK the system waits until somebody writes to a pipe."""
    return open(path, "rb", opener=lambda name, flags: os.open(name, flags | getattr(os, "O_NONBLOCK", 0)))


def _read_pipe(descriptor: int, most: int) -> bytes:
    """Until `most` bytes are read or every writer has closed it."""
    found, had_a_writer = bytearray(), False
    while len(found) < most:
        try:
            piece = os.read(descriptor, min(most - len(found), 2**20))
        except BlockingIOError:  # a writer has it open
            _wait(descriptor, _SECONDS_OF_SILENCE)
            had_a_writer = True
            continue
        if not piece and had_a_writer:
            break
        if not piece:
            _wait(descriptor, _SECONDS_FOR_A_WRITER)
        found += piece
        had_a_writer = True
    return bytes(found)


def _wait(descriptor: int, seconds: float) -> None:
    """Return as soon as there is something to read, or a writer has closed the pipe; OSError if neither happens."""
    if not select.select([descriptor], [], [], seconds)[0]:
        raise OSError(errno.ETIMEDOUT, f"a pipe to which nobody writes, for {seconds:g} seconds")
