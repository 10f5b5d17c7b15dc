"""The report of a command: lines for people, the same as JSON for programs, and a progress bar on a terminal.

Nothing of it with --quiet.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

from rsegen.cli.parser import Parser
from rsegen.params.command import flags_in_errors, given
from rsegen.params.registry import offered_names

if TYPE_CHECKING:
    from rsegen.recipe.recipe import Recipe
    from rsegen.run.dataset import Progress
    from rsegen.run.worlds import GeneratedMap
    from rsegen.simulation.experiment.plan import Cell, ExperimentPlan


Subparsers: TypeAlias = "argparse._SubParsersAction[Parser]"

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

    def show(self, arguments: argparse.Namespace) -> int:
        """Print it as the flags ask for, and return the exit code."""
        if arguments.json:
            print(json.dumps(self.content() if callable(self.content) else self.content, indent=2))
        for line in () if arguments.json else self.lines:
            _print(line, arguments)
        for line in self.notes:
            _print(line, arguments, sys.stderr if arguments.json else sys.stdout)
        return self.code


def _print(line: str, arguments: argparse.Namespace, file: Any = None) -> None:
    if not arguments.quiet:
        print(line, file=file)


def add_command(
    commands: Subparsers, name: str, function: Callable[..., object] | None = None, *, text: str = "", epilog: str = ""
) -> Parser:
    """Add the parser of a command, with the flags that all have; its text is the first line of its function."""
    description = text or ((function.__doc__ or "").partition("\n")[0] if function else "")
    parser = commands.add_parser(name, description=description.replace("%", "%%"), epilog=epilog)
    parser.add_argument("--json", action="store_true", help="print the result as JSON, lengths in metres")
    parser.add_argument("-q", "--quiet", action="store_true", help="print no report and no progress")
    return parser


def robot_kinds() -> str:
    """Return the kinds of robots for a help, without importing one."""
    return f"Kinds of robots: {', '.join(offered_names('rsegen.robots', 'rsegen.robots'))}."


def call(function: Callable[..., R], arguments: argparse.Namespace, *positional: Any, **named: Any) -> R:
    """Call a command with what its flags say, and what else is given; its errors name the flags."""
    with flags_in_errors(function):
        return function(*positional, **{**given(function, arguments), **named})


QUIET: ContextVar[bool] = ContextVar("no progress bars", default=False)


@contextmanager
def quiet(*, is_asked_for: bool) -> Iterator[None]:
    """Show no progress inside, if that is asked for."""
    token = QUIET.set(is_asked_for)
    try:
        yield
    finally:
        QUIET.reset(token)


def watched() -> bool:
    """Return whether there is a terminal for a progress bar, and somebody who wants one."""
    return bool(sys.stderr and sys.stderr.isatty()) and not QUIET.get()


@contextmanager
def counting(count: int, unit: str = "map") -> Iterator[Callable[..., None] | None]:
    """Yield a function to call with each thing that is done; None without a terminal, or for a single one."""
    if count == 1 or not watched():
        yield None
        return
    from tqdm import tqdm

    with tqdm(total=count, unit=unit, miniters=1) as bar:

        def done(*_: object) -> None:
            bar.update()

        yield done


@contextmanager
def maps_bar(recipe: Recipe) -> Iterator[Callable[[GeneratedMap], None] | None]:
    """Yield a function to call with each map of a recipe; maps that exist already count as done."""
    if recipe.maps == 1 or not watched():
        yield None
        return
    from tqdm import tqdm

    with tqdm(total=recipe.maps, unit="map", miniters=1) as bar:

        def done(generated: GeneratedMap) -> None:
            place = generated.index - recipe.first_map + 1
            if not bar.n:
                bar.initial = bar.n = place - 1  # of no weight in the time that is left
            bar.update(place - bar.n)

        yield done
        bar.update(recipe.maps - bar.n)


@contextmanager
def shards_bar(maps: int) -> Iterator[Progress | None]:
    """Yield a function for maps in shards; those that exist already are of no weight in the time that is left."""
    if not watched():
        yield None
        return
    from tqdm import tqdm

    with tqdm(total=maps, unit="map", unit_scale=True) as bar:

        def done(maps: int, *, already: bool) -> None:
            bar.initial += maps * already
            bar.update(maps)

        yield done


@contextmanager
def seconds_bar(seconds: float) -> Iterator[Callable[[float], None]]:
    """Yield a function for the simulation time."""
    if not watched():
        yield lambda _: None
        return
    from tqdm import tqdm

    with tqdm(total=seconds, unit="s", bar_format="{l_bar}{bar}| {n:.0f}/{total:.0f} simulated s [{elapsed}]") as bar:

        def progress(done: float) -> None:
            bar.update(done - bar.n)

        yield progress


@contextmanager
def trials_bar(plan: ExperimentPlan) -> Iterator[Callable[[int, Cell], None]]:
    """Yield a function for the trials of an experiment; without a terminal each is a line, but with --quiet."""
    trials = len(plan.cells) * plan.repeats
    if not watched():

        def line(done: int, cell: Cell) -> None:
            if not QUIET.get():
                print(f"{done + 1} of {trials}: {cell.name}", file=sys.stderr, flush=True)

        yield line
        return
    from tqdm import tqdm

    with tqdm(total=trials, unit="trial") as bar:

        def progress(done: int, cell: Cell) -> None:
            bar.update(done - bar.n)
            bar.set_description(cell.name)

        yield progress
        bar.update(trials - bar.n)
