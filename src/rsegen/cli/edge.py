"""The edge of the command line: what goes wrong becomes one line and an exit code; what is stopped leaves no mess."""

from __future__ import annotations

import os
import signal
import sys
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NoReturn

from rsegen.errors import REFUSED, PluginWarning, RsegenError, UserError


@contextmanager
def stoppable() -> Iterator[None]:
    """Ctrl-C, a polite kill and a closed terminal stop what runs here, once: what is half written goes, undisturbed."""
    names = ("SIGINT", "SIGTERM", "SIGHUP")
    found = [getattr(signal, name) for name in names if hasattr(signal, name)]
    heeded = {each: signal.getsignal(each) for each in found if signal.getsignal(each) is not signal.SIG_IGN}
    if threading.current_thread() is not threading.main_thread():
        heeded = {}

    def stop(signal_: int, frame: object) -> NoReturn:
        for each in heeded:
            signal.signal(each, signal.SIG_IGN)
        raise KeyboardInterrupt

    try:
        for each in heeded:
            signal.signal(each, stop)
        yield
    finally:
        for each, before in heeded.items():
            signal.signal(each, before)


@contextmanager
def short_warnings() -> Iterator[None]:
    """What is wrong with plug-ins that are not needed is one line each on stderr."""
    usual = warnings.showwarning

    def show(message: Warning | str, category: type[Warning], *where: Any, **others: Any) -> None:
        if not issubclass(category, PluginWarning):
            usual(message, category, *where, **others)
        elif sys.stderr:
            print(f"rsegen: warning: {' '.join(str(message).split())}", file=sys.stderr)

    warnings.showwarning = show
    try:
        yield
    finally:
        warnings.showwarning = usual


def failed(error: BaseException) -> int:
    """Say what went wrong in one line, if there is anyone to hear it, and no more after it; gives the exit code."""
    exec("")  # noqa: S102  # CPython ends by SIGINT if one interrupted an `exec`, as of dataclasses; the next one forgets it
    code, message = _code_and_words(error)
    if sys.stderr and message:
        print(f"rsegen: {' '.join(message.split())}", file=sys.stderr)
    try:
        if sys.stdout:
            sys.stdout.flush()
    except OSError:  # or Python would try it again at its end, and complain
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return code


def _code_and_words(error: BaseException) -> tuple[int, str]:
    """The exit code, and what to say; nothing to whoever has stopped listening."""
    match error:
        case RsegenError():
            return 2 if isinstance(error, UserError) else 1, str(error)
        case KeyboardInterrupt():
            return 1, str(error) or "stopped; the maps that were complete are there, nothing else is"
        case OSError():
            where = error.filename or "what was to be printed"
            said = "" if isinstance(error, BrokenPipeError) else f"{where}: {error.strerror or error}"
            return 2 if error.errno in REFUSED else 1, said
        case MemoryError():
            return 1, "out of memory; give fewer chunks or a smaller chunk_size"
    said = f"{type(error).__name__}: {error}"
    return 1, f"internal error, please report it: {said} (python -X dev -m rsegen shows where)"
