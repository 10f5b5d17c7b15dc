"""The report of a command: lines for people, the same as JSON for programs; and its progress, as a bar or as JSON.

Nothing of it with --quiet.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

from rsegen.cli.parser import Parser
from rsegen.params.command import add_flags, declared, flags_in_errors, given
from rsegen.params.sorts import Choice, Flag, plain
from rsegen.params.watch import watched

if TYPE_CHECKING:
    from rsegen.recipe.recipe import Recipe
    from rsegen.writing.worlds import GeneratedMap


R = TypeVar("R")


@dataclass(frozen=True, kw_only=True)
class Report:
    """The outcome of a command.

    lines: for people, made while they are printed; content: for --json, or a function that gives it; notes: lines that
    go to stderr with --json; code: the exit code
    """

    lines: Iterable[str]
    content: object
    notes: Iterable[str] = ()
    code: int = 0

    def show(self, arguments: argparse.Namespace, spelled: Callable[[str], str]) -> int:
        """Print it as the flags ask for, each line as `spelled` for a shell, and return the exit code."""
        if arguments.json:
            print(json.dumps(self.content() if callable(self.content) else self.content, indent=2))
        for line in () if arguments.json else self.lines:
            _print(spelled(line), arguments)
        if arguments.json and _PROGRESS.get() == "json" and sys.stderr:
            print(json.dumps({"report": [*map(spelled, self.lines)]}), file=sys.stderr, flush=True)
        for line in self.notes:
            _print(spelled(line), arguments, sys.stderr if arguments.json else sys.stdout)
        return self.code


def _print(line: str, arguments: argparse.Namespace, file: Any = None) -> None:
    if not arguments.quiet:
        print(line, file=file)


@dataclass(frozen=True, kw_only=True, slots=True)
class _Shared:
    """Options that commands share: all have `progress`, and commands that write files `dry_run`."""

    progress: Annotated[
        str, Choice(("bar", "json", "none"), help="show progress as a bar on a terminal, or as lines of JSON on stderr")
    ] = "bar"
    dry_run: Annotated[
        bool, Flag(help="print which files would be written, replaced, removed or kept, and change nothing")
    ] = False


def planned(arguments: argparse.Namespace) -> Report | None:
    """Run a command dry, and return the files that it would write."""
    from rsegen.writing.dry import dry_run

    with dry_run() as notes:
        arguments.run(arguments)
    return Report(lines=notes.lines(), content=notes.by_fate)


def add_shared_flags(command: Parser, add: Callable[[Parser], None]) -> None:
    """Add the flags that all commands have, and by `add` the flags of this one."""
    command.add_argument("--json", action="store_true", help="print the result as JSON, lengths in metres")
    command.add_argument("-q", "--quiet", action="store_true", help="print no report and no progress")
    add_flags(command, _Shared, only=["progress"])
    add(command)
    if "--force" in command.flags:  # it writes files
        add_flags(command, _Shared, only=["dry_run"])


def call(function: Callable[..., R], arguments: argparse.Namespace, *positional: Any, **named: Any) -> R:
    """Call a command with what its flags say, and what else is given; its errors name the flags."""
    with flags_in_errors(function):
        return function(*positional, **{**given(function, arguments), **named})


def checked_flags(owner: Callable[..., Any], arguments: argparse.Namespace) -> dict[str, Any]:
    """Return what the flags of a command, or of a dataclass of options, say; errors name the flags."""
    with flags_in_errors(owner):
        known, given_values = declared(owner), given(owner, arguments)
        return {name: known[name].sort.check(name, value) for name, value in given_values.items()}


_PROGRESS: ContextVar[str] = ContextVar("how progress is shown", default="bar")


def progress_is_wanted() -> bool:
    """Return whether progress is shown in any way."""
    return _PROGRESS.get() != "none"


@contextmanager
def progress_of(arguments: argparse.Namespace) -> Iterator[None]:
    """Show progress inside as the flags of a command ask for; a ParameterError if they say what is not known."""
    shown = _Shared(**checked_flags(_Shared, arguments))
    token = _PROGRESS.set("none" if arguments.quiet else shown.progress)
    try:
        with ExitStack() as all_bars, watched(_bars_of_work(all_bars)):
            yield
    finally:
        _PROGRESS.reset(token)


def _bars_of_work(all_bars: ExitStack) -> Callable[[str, float], None]:
    """Return the watcher that shows the progress of all work as a bar; a search may be within a measuring."""
    bars: dict[str, tuple[ExitStack, Callable[[float], None]]] = {}

    def tell(what: str, share: float) -> None:
        if share >= 1:
            if what in bars:
                bars.pop(what)[0].close()
            return
        if what not in bars:
            own = all_bars.enter_context(ExitStack())
            bars[what] = own, own.enter_context(share_bar(what))
        bars[what][1](share)

    return tell


_LINES_APART = 0.05
"""Seconds between two lines of progress: of a thousand maps in a second nobody reads each."""


class ProgressLines:
    """Progress as lines of JSON on stderr, such as `{"done": 2, "total": 7, "unit": "map", "step": ""}`, or not shown.

    It has the part of tqdm's interface that is used here.
    """

    n = initial = 0.0

    def __init__(self, total: float, unit: str, step: str, *, is_shown: bool) -> None:
        self.total, self._unit, self._step, self.is_shown = total, unit, step, is_shown
        self.refresh()

    def update(self, steps: float = 1) -> None:
        """Go on by some steps; the last one is always said."""
        self.n += steps
        if steps and (self.n >= self.total or time.monotonic() - self._printed_at > _LINES_APART):
            self.refresh()

    def set_description(self, step: str) -> None:
        """Say what is done now."""
        self._step = step
        self.refresh()

    def refresh(self) -> None:
        """Say how far it is."""
        self._printed_at = time.monotonic()
        if self.is_shown:
            state = {"done": plain(self.n), "total": plain(self.total), "unit": self._unit, "step": self._step}
            print(json.dumps(state), file=sys.stderr, flush=True)


@contextmanager
def progress_shown(total: float, unit: str, **style: Any) -> Iterator[Any]:
    """Yield what shows the progress: a bar, with a style of tqdm's, lines of JSON, or nothing."""
    how = _PROGRESS.get()
    if how == "bar" and sys.stderr and sys.stderr.isatty():
        from tqdm import tqdm

        # A terminal that does not know its size, as that of `script` or of a container, says 0: no bar would be drawn.
        with suppress(OSError):
            if not os.get_terminal_size(sys.stderr.fileno()).columns:
                style |= {"ncols": 80, "nrows": 24}
        with tqdm(total=total, unit=unit, **style) as bar:
            yield bar
    else:
        yield ProgressLines(total, unit, style.get("desc", ""), is_shown=how == "json" and bool(sys.stderr))


@contextmanager
def counting(count: int, unit: str = "map") -> Iterator[Callable[..., None]]:
    """Yield a function to call with each thing that is done; a single one has no bar."""
    with progress_shown(count, unit, miniters=1, disable=count == 1) as bar:
        yield lambda *_: bar.update()


@contextmanager
def maps_bar(recipe: Recipe) -> Iterator[Callable[[GeneratedMap], None]]:
    """Yield a function to call with each map of a recipe; maps that exist already count as done."""
    with progress_shown(recipe.maps, "map", miniters=1, disable=recipe.maps == 1) as bar:

        def done(generated: GeneratedMap) -> None:
            # Maps come in the order of their indices, so all before this one are done, or existed already.
            place = generated.index - recipe.first_map + 1
            if not bar.n:
                bar.initial = bar.n = place - 1  # of no weight in the time that is left
            bar.update(place - bar.n)

        yield done
        bar.update(recipe.maps - bar.n)


@contextmanager
def seconds_bar(seconds: float) -> Iterator[Callable[[float], None]]:
    """Yield a function for the simulation time; what ends before all of these seconds is complete all the same."""
    style = "{l_bar}{bar}| {n:.0f}/{total:.0f} simulated s [{elapsed}<{remaining}, {rate_fmt}]"
    with progress_shown(seconds, "s", bar_format=style) as bar:
        yield lambda done: bar.update(done - bar.n)
        bar.total = bar.n
        bar.refresh()


@contextmanager
def share_bar(what: str) -> Iterator[Callable[[float], None]]:
    """Yield a function for the share of some work that is done, 0..1."""
    shape = "{desc} {percentage:3.0f}%|{bar}| [{elapsed}<{remaining}]"
    with progress_shown(100, "%", bar_format=shape, desc=what, leave=False, delay=0.5, miniters=0) as bar:
        yield lambda share: bar.update(max(100 * share - bar.n, 0))  # a way that was lowered is looked at once more
