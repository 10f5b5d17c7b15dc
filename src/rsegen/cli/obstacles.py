"""rsegen obstacles: the kinds, their parameters and ranges."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Mapping

from rsegen.cli.flags import Subparsers
from rsegen.field.obstacles import KINDS
from rsegen.field.obstacles.base import PLACING, own_parameters
from rsegen.params.registry import summary
from rsegen.params.sorts import Parameter
from rsegen.recipe.codec import schema


def add(commands: Subparsers) -> None:
    """The parser of this command."""
    command = commands.add_parser(
        "obstacles",
        description="List the kinds of obstacles with their parameters, ranges and meaning.",
    )
    command.add_argument("--json", action="store_true", help="print their JSON Schemas, for programs")
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Print them."""
    if arguments.json:
        print(json.dumps(schema()["properties"]["obstacles"]["items"]["oneOf"], indent=2))
    else:
        print("\n".join(_report()))


def _report() -> Iterator[str]:
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
