"""The command line: parse, call, report. No arithmetic of the domain.

Exit codes: 0 done, 2 the user's mistake (one line), 1 anything else.
"""

from __future__ import annotations

import argparse
import io
import os
import signal
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NoReturn

from rsegen.cli import generate, info, obstacles, preview, schema
from rsegen.errors import REFUSED, RsegenError, UnknownName, UserError, shown
from rsegen.version import __version__

COMMANDS = (generate, preview, info, obstacles, schema)


class Parser(argparse.ArgumentParser):
    """Says what is wrong in one line, and takes flags in full only."""

    def __init__(self, **options: Any) -> None:
        super().__init__(allow_abbrev=False, formatter_class=_Help, **options)

    def error(self, message: str) -> NoReturn:
        """End with exit code 2."""
        self.exit(2, f"{self.prog}: error: {' '.join(message.split())} (see {self.prog} --help)\n")

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """What is unknown is known to be so by the command itself, which has the flags to compare it with."""
        parsed, unknown = super().parse_known_args(args, namespace)
        for text in unknown[:1]:
            flags = [flag for action in self._actions for flag in action.option_strings]
            named = text.startswith("-")
            self.error(str(UnknownName.among("", "flag", text, flags)) if named else f"{shown(text)} is too much")
        return parsed, unknown

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.choices is not None and value not in action.choices:
            self.error(str(UnknownName.among("", "command", value, action.choices)))


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; gives the exit code."""
    with _stoppable():
        try:
            return _run(arguments)
        except (KeyboardInterrupt, Exception) as error:
            if sys.flags.dev_mode and not isinstance(error, (RsegenError, KeyboardInterrupt, OSError)):
                raise
            return _failed(*_code_and_words(error))


def _code_and_words(error: BaseException) -> tuple[int, str]:
    """The exit code, and what to say; nothing to whoever has stopped listening."""
    match error:
        case RsegenError():
            return 2 if isinstance(error, UserError) else 1, str(error)
        case KeyboardInterrupt():
            return 1, "stopped; the maps that were complete are there, nothing else is"
        case OSError():
            where = error.filename or "what was to be printed"
            said = "" if isinstance(error, BrokenPipeError) else f"{where}: {error.strerror or error}"
            return 2 if error.errno in REFUSED else 1, said
        case MemoryError():
            return 1, "out of memory; give fewer chunks or a smaller chunk_size"
    said = f"{type(error).__name__}: {error}"
    return 1, f"a mistake in rsegen, please report it: {said} (python -X dev -m rsegen shows where)"


def _run(arguments: Sequence[str] | None) -> int:
    if isinstance(sys.stdout, io.TextIOWrapper) and sys.stdout.errors == "strict":
        sys.stdout.reconfigure(errors="backslashreplace")  # a folder may have a name that cannot be printed
    try:
        parsed = parser().parse_args(arguments)
        parsed.run(parsed)
        return 0
    finally:
        if sys.stdout:
            sys.stdout.flush()


def parser() -> Parser:
    """The parser of every command."""
    top = Parser(
        prog="rsegen",
        description="Random Step Environments (NIST stepfields) as worlds and models for robot simulators.",
        epilog="Start with: rsegen generate --obstacle 'random max_height=5' -o worlds",
    )
    top.add_argument("--version", action="version", version=f"rsegen {__version__}")
    commands = top.add_subparsers(title="commands", metavar="COMMAND", required=True)
    for command in COMMANDS:
        command.add(commands)
    return top


class _Help(argparse.HelpFormatter):
    def __init__(self, prog: str) -> None:
        super().__init__(prog, max_help_position=26)


@contextmanager
def _stoppable() -> Iterator[None]:
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


def _failed(code: int, message: str) -> int:
    """Say so in one line, where there is anyone to hear it; and print nothing more."""
    if sys.stderr and message:
        print(f"rsegen: {' '.join(message.split())}", file=sys.stderr)
    try:
        if sys.stdout:
            sys.stdout.flush()
    except OSError:  # or Python would try it again at its end, and complain
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return code
