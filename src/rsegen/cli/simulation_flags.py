"""Flags that the commands share which change a running simulation, and their names in error messages."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rsegen.errors import ParameterError
from rsegen.simulation.simulators import SIMULATORS


def simulator_names() -> str:
    """What --simulator takes, for its help."""
    return " or ".join(f"{name} ({each.title})" for name, each in SIMULATORS.items())


def add_running_flags(command: argparse.ArgumentParser) -> None:
    """Add --simulator and --json."""
    command.add_argument("--simulator", metavar="NAME", help=f"{simulator_names()} (default: whichever runs)")
    command.add_argument("--json", action="store_true", help="print the result as JSON")


def add_output_flag(command: argparse.ArgumentParser) -> None:
    """Add --output, for maps that are made of recipes."""
    text = "folder for maps that are made of recipes, which are kept there (default: worlds)"
    command.add_argument("-o", "--output", type=Path, default=Path("worlds"), metavar="DIR", help=text)


@contextmanager
def flags_in_errors(*names: str) -> Iterator[None]:
    """Errors raised inside name the flag instead of the parameter: `robots: 0 is ...` becomes `--robots: 0 is ...`."""
    try:
        yield
    except ParameterError as error:
        name, bracket, rest = error.where.partition("[")
        if name not in names:
            raise
        raise type(error)(f"--{name.replace('_', '-')}{bracket}{rest}", error.problem) from None
