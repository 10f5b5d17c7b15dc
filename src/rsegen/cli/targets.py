"""The flags of commands that look at maps: where the maps are, and which of them."""

from __future__ import annotations

import argparse


def add_target_flags(command: argparse.ArgumentParser, usual: str = "the first") -> None:
    """Where to look, and which map."""
    where = (
        "a recipe (YAML, JSON), the name of an example, the folder of a map, a folder of maps, or DIR#17 of a data set"
    )
    command.add_argument("target", metavar="RECIPE-or-DIR", help=where)
    command.add_argument("--map", metavar="INDEX", help=f"which map, by its index or its name (default: {usual})")
