"""The edge of the command line: what goes wrong becomes one line and an exit code; a signal stops a command.

The first Ctrl-C, polite kill or closed terminal stops a command in one line. A later one ends it at once, which is
safe, as nothing half written is ever at its place. All that is shown is printable.

Advice in messages is translated, as what Python writes as `force=True` is `--force` in a shell:

    force=True                         --force
    tracks='LEFT,RIGHT'                --tracks LEFT,RIGHT
    at=[X, Y, Z]                       --at X,Y,Z
    rsegen.open('DIR', shared=True)    rsegen open DIR --shared

Every message recommends arguments of Python, in one of these forms. The flags are those that the parser of the command
declares, so a new parameter is translated without a word here. What breaks it: a text of a user's that has such a form.
A message that begins with a parameter names its flag, if that was given: `unit_cm: ...` is `--unit-cm: ...`.
"""

from __future__ import annotations

import io
import logging
import os
import re
import signal
import sys
import threading
import time
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, redirect_stdout, suppress
from functools import partial
from types import FrameType
from typing import TYPE_CHECKING, Any, TextIO

from rsegen.cli.command_line import OVERVIEW, load_plugins, parsed, parser_of
from rsegen.cli.parser import FLAG
from rsegen.errors import (
    REFUSED,
    PluginError,
    PluginWarning,
    RsegenError,
    Stopped,
    UserError,
    line_of,
    printable,
    shown,
    system_message,
)
from rsegen.params.capabilities import commands, used_sources
from rsegen.params.plugins import failure_of_plugin
from rsegen.writing import stop

if TYPE_CHECKING:
    from rsegen.recipe.recipe import Recipe


class _Printable:
    """A text stream that shows what is written to it with escapes in place of what is not printable."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        """Write it, and say how much was given."""
        self._stream.write(printable(text))
        return len(text)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


@contextmanager
def printable_output() -> Iterator[None]:
    """Print escapes inside for what is not printable: a folder may have any name."""
    if not sys.stdout:
        yield
        return
    if isinstance(sys.stdout, io.TextIOWrapper) and sys.stdout.errors == "strict":
        sys.stdout.reconfigure(errors="backslashreplace")  # letters that the terminal has not
    with redirect_stdout(_Printable(sys.stdout)):
        yield


@contextmanager
def short_warnings() -> Iterator[None]:
    """Print one line on stderr for each plug-in that is wrong and not needed.

    Warnings and logs of libraries are for developers: they are shown where Python was told which ones to show.
    """
    usual = warnings.showwarning
    for_developers = bool(sys.warnoptions or sys.flags.dev_mode)

    def show(message: Warning | str, category: type[Warning], *where: Any, **others: Any) -> None:
        if issubclass(category, PluginWarning):
            if sys.stderr:
                print(f"rsegen: warning: {line_of(in_flags(str(message)))}", file=sys.stderr)
        elif for_developers:
            usual(message, category, *where, **others)

    warnings.showwarning = show
    nowhere = logging.NullHandler()  # Python prints records to stderr only if nobody has set up logging
    if not for_developers:
        logging.root.addHandler(nowhere)
    try:
        yield
    finally:
        warnings.showwarning = usual
        logging.root.removeHandler(nowhere)


def failed(error: BaseException, signal: int, command: str | None = None, words: Sequence[str] = ()) -> int:
    """Print what went wrong in one line on stderr, if that is open, and return the exit code.

    signal: the number of the signal that stopped the command, if one did; command: its name, for the flags in messages
    words: of the command line
    """
    code, message = _code_and_words(error, signal)
    message = in_flags(_of_flag(message, command, words), command)
    if sys.stderr and message:
        with suppress(OSError):  # a terminal that was closed
            print(f"rsegen: {line_of(message)}", file=sys.stderr, flush=True)
    try:
        if sys.stdout:
            sys.stdout.flush()
    except OSError:  # or Python would try it again at its end, and complain
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return code


def _code_and_words(error: BaseException, signal: int) -> tuple[int, str]:
    """Return the exit code, and what to say; nothing to whoever has stopped listening."""
    match error:
        case RsegenError():
            return 2 if isinstance(error, UserError) else 1, str(error)
        case KeyboardInterrupt():
            return 128 + signal, f"stopped; {error}" if str(error) else "stopped"
        case OSError() if error.filename or isinstance(error, BrokenPipeError) or not failure_of_plugin(error):
            message = "" if isinstance(error, BrokenPipeError) else system_message(error, "the output")
            return 2 if error.errno in REFUSED else 1, message
        case MemoryError():
            return 1, "out of memory; use fewer chunks or a smaller chunk_size"
    if message := failure_of_plugin(error):
        return 1, message
    message = f"{type(error).__name__}: {error} (python -X dev -m rsegen shows where)"
    plugins = ", ".join(map(str, used_sources()))
    of_both = f"error in rsegen, or in what a plug-in gave it ({plugins})"
    return 1, f"{of_both if plugins else 'internal error, please report it'}: {message}"


_ONE_STOP = 1.0
"""Seconds in which further signals are the same stop: Ctrl-C held down, or all that a closing terminal sends."""


class Signals:
    """The signals that stop a command: whether one came, and its number."""

    number: int = signal.SIGINT
    came = False
    _first = 0.0

    @contextmanager
    def stop_it(self) -> Iterator[None]:
        """Let a signal raise a KeyboardInterrupt inside; one that was ignored before stays so.

        Python drops one that comes in some callbacks, and would print where: a run looks for it by itself.
        """
        can_stop = threading.current_thread() is threading.main_thread()  # no other one may set handlers
        names = ("SIGINT", "SIGTERM", "SIGHUP") if can_stop else ()
        known = [getattr(signal, name) for name in names if hasattr(signal, name)]
        before = {code: signal.getsignal(code) for code in known if signal.getsignal(code) is not signal.SIG_IGN}
        stop.STATE.asked, unraisable = False, sys.unraisablehook
        for code in before:
            signal.signal(code, self._stop)
        sys.unraisablehook = lambda lost: None if lost.exc_type is KeyboardInterrupt else unraisable(lost)
        try:
            yield
        finally:
            stop.STATE.asked = False  # a later call of this process is not to stop
            sys.unraisablehook = unraisable
            for code, handler in before.items():
                signal.signal(code, handler)

    def _stop(self, number: int, frame: FrameType | None) -> None:
        if not self.came:
            self.came, self._first, self.number = True, time.monotonic(), number
            stop.ask()
        elif time.monotonic() - self._first > _ONE_STOP:
            if sys.stderr:
                os.write(2, b"rsegen: ended at once; what is complete stays\n")
            os._exit(128 + number)


@contextmanager
def how_to_go_on(*recipes: Recipe, resume: bool = False, then: str = "goes on") -> Iterator[None]:
    """Add to the message of a run that is stopped what the same command does `then`, and with which flags.

    The seed is named if all recipes have the same one.
    """
    try:
        yield
    except Stopped as stopped:
        if not stopped.changed:
            raise
        seeds = {recipe.seed for recipe in recipes}
        flags = [*(f"--seed {seed}" for seed in seeds if len(seeds) == 1), *(["--resume"] if resume else [])]
        with_flags = f" with {' '.join(flags)}" if flags else ""
        raise Stopped(f"{stopped}; the same command{with_flags} {then}") from None


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command, and return the exit code."""
    words, signals = sys.argv[1:] if arguments is None else arguments, Signals()
    with short_warnings(), printable_output():
        try:
            return _run(words, signals)
        except (KeyboardInterrupt, SystemExit, Exception) as error:
            if isinstance(error, SystemExit) and not failure_of_plugin(error):  # --help
                raise
            ours = not isinstance(error, (RsegenError, KeyboardInterrupt, OSError))
            if ours and sys.flags.dev_mode:
                raise
            # A compiled module that a signal interrupts while it is imported raises its own ImportError.
            shown_error = KeyboardInterrupt() if ours and signals.came else error
            if not str(shown_error):  # it names no flags; to ask for commands is to import capabilities once more
                words = ()
            return failed(shown_error, signals.number, _command_in(words), words)


def _command_in(words: Sequence[str]) -> str | None:
    return next((word for word in words if word in commands()), None)


def _in_shell(line: str, command: str | None) -> str:
    """Return a line of a report; in a note are flags in place of arguments."""
    return in_flags(line, command) if line.startswith("note: ") else line


def _run(words: Sequence[str], signals: Signals) -> int:
    try:
        if "_ARGCOMPLETE" in os.environ:  # argcomplete's own: a shell asks what may follow
            from rsegen.cli.completion import complete

            complete()
        arguments = parsed(load_plugins(words))
        if not hasattr(arguments, "run"):
            print(OVERVIEW, end="")
            return 0
        from rsegen.cli.report import Report, planned, progress_of

        with signals.stop_it(), progress_of(arguments):
            outcome = planned(arguments) if getattr(arguments, "dry_run", False) else arguments.run(arguments)
            if outcome is None:
                return 0
            if not isinstance(outcome, Report) or not isinstance(outcome.code, int):
                problem = f"{_command_in(words)} gave {shown(outcome)}; expected a rsegen.cli.report.Report"
                raise PluginError(f"plug-in {', '.join(map(str, used_sources()))}: the command {problem}")
            return outcome.show(arguments, partial(_in_shell, command=_command_in(words)))
    finally:
        if sys.stdout:
            sys.stdout.flush()


_ARGUMENT = re.compile(r"\b(\w+)=(True\b|'[^']*'|\[[^]]*\])")
_CALL = re.compile(r"\brsegen\.(\w+)\(([^()]*)\)")


def in_flags(message: str, command: str | None = None) -> str:
    """Return a message with the flags of `command` in place of arguments, and command lines in place of calls."""
    called = _CALL.sub(_command_line, message)
    return _with_flags(called, command) if command and command in commands() else called


def _command_line(call: re.Match[str]) -> str:
    """Return the command line of a call; a call of what is no command stays."""
    name, arguments = call[1], call[2]
    if name == "load_plugin":
        return f"{FLAG} {_text(arguments)}"
    if name not in commands():
        return call[0]
    words = (_with_flags(argument.strip(), name) for argument in arguments.split(","))
    return " ".join(["rsegen", name, *map(_text, words)])


def _of_flag(message: str, command: str | None, words: Sequence[str]) -> str:
    """Return a message about a parameter as one about its flag, if that is in the words of a command."""
    where = re.match(r"\w+(?=(\[\d+\])*: )", message)
    if where is None or command is None or command not in commands():
        return message
    flag = _flags(command).get(where[0])
    is_given = any(word.partition("=")[0] == flag for word in words)
    return f"{flag}{message[where.end() :]}" if is_given else message


def _flags(command: str) -> dict[str, str]:
    """Return the flag of each declared parameter of a command."""
    try:
        actions = parser_of(command).actions
    except Exception:  # of a plug-in's command: it may be the parser that failed, which has been reported
        return {}
    declared = ((getattr(action, "declared", None), action.option_strings) for action in actions)
    return {parameter.name.strip("_"): names[-1] for parameter, names in declared if parameter and names}


def _with_flags(text: str, command: str) -> str:
    if not _ARGUMENT.search(text):
        return text  # most messages have no advice, and no parser is made for them
    flags = _flags(command)

    def flag(argument: re.Match[str]) -> str:
        name, value = argument[1], argument[2]
        if name not in flags:
            return argument[0]
        return flags[name] if value == "True" else f"{flags[name]} {_text(value)}"

    return _ARGUMENT.sub(flag, text)


def _text(value: str) -> str:
    """Return a text, or a list, as a shell has it."""
    return value.strip("'[]").replace(", ", ",")
