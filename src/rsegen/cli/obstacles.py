"""rsegen obstacles: the kinds, their parameters and ranges."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from rsegen.cli.report import Report, Subparsers, add_command

if TYPE_CHECKING:
    from rsegen.params.sorts import Parameter


def add(commands: Subparsers) -> None:
    """Add the parser of this command."""
    text = "List the kinds of obstacles with their parameters, ranges and meaning; as JSON their schemas."
    add_command(commands, "obstacles", text=text)


def run(arguments: argparse.Namespace) -> Report:
    """List them."""
    from rsegen.recipe.codec import schema

    return Report(lines=_lines(), content=lambda: schema()["properties"]["obstacles"]["items"]["oneOf"])


def _lines() -> Iterator[str]:
    from rsegen.field.obstacles import KINDS
    from rsegen.field.obstacles.base import PLACING, own_parameters
    from rsegen.params.registry import summary

    yield "An obstacle is its kind, the parameters of that kind, and a place: 'peak levels=5 first=2,2 last=7,7'."
    yield "first and last, its place, are the same for every kind: they are at the end."
    yield ""
    for name, cls in KINDS.items():
        source = KINDS.source(name)
        yield f"{name}\n    {summary(cls)}" + (f" From {source}." if source else "")
        yield from _rows(own_parameters(cls))
        yield ""
    yield "every kind"
    yield from _rows(PLACING)


def _rows(known: Mapping[str, Parameter]) -> Iterator[str]:
    for name, parameter in known.items():
        yield f"    {name:<11} {parameter.help}: {parameter.describe()}"
