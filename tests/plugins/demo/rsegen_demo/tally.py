"""The command `rsegen tally`, `rsegen.tally` in Python, and `generate --tally`."""

from __future__ import annotations

import argparse
import os
from pathlib import PurePosixPath
from typing import TYPE_CHECKING, Annotated, ClassVar

from rsegen.cli.flags import add_target_flags, add_target_recipe_flags, scene_of_flags
from rsegen.cli.parser import Parser
from rsegen.cli.report import Report
from rsegen.params.command import add_flags, command, given
from rsegen.params.sorts import Flag, Integer
from rsegen.writing.sidecars import Sidecar

if TYPE_CHECKING:
    from rsegen.field.stepfield import StepField
    from rsegen.gazebo import Bundle
    from rsegen.scene.scene import Scene


@command
def tally(
    field: StepField, *, above: Annotated[int, Integer(0, 1000, unit="units", help="lowest level that counts")] = 1
) -> int:
    """Count the blocks of a field.

    Parameters
    ----------
    field : StepField
        The field.

    Returns
    -------
    int
        The number of blocks.
    """
    return sum(count for level, count in field.level_counts().items() if level >= above)


def add_tally(command: Parser) -> None:
    """Add the flags."""
    command.explain(tally.__doc__)
    add_target_flags(command)
    add_flags(command, tally)
    add_target_recipe_flags(command)


def run_tally(arguments: argparse.Namespace) -> Report:
    """Count."""
    count = tally(scene_of_flags(arguments).field, **given(tally, arguments))
    return Report(lines=[f"{count} blocks"], content={"blocks": count})


class Tally(Sidecar):
    """The number of blocks, next to each world."""

    name: ClassVar[str] = "tally"
    parameter = Annotated[bool, Flag(help="add the number of blocks, tally.txt, to every map")]

    def files(self, scene: Scene) -> Bundle:
        """Return the file."""
        return {PurePosixPath("tally.txt"): [f"{tally(scene.field)}\n".encode()]}

    def are_in(self, home: str) -> bool:
        """Return whether a map has it."""
        return os.path.isfile(os.path.join(home, "tally.txt"))
