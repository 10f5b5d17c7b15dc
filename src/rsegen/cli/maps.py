"""What the commands share that change a running simulation: flags, and the maps of a target."""

from __future__ import annotations

import argparse
import os.path
from pathlib import Path

from rsegen.cli.targets import found, recipe_files
from rsegen.io.dataset.map_reference import recipe_in
from rsegen.simulation.simulators import SIMULATORS
from rsegen.simulation.spawning.maps import Map, made


def add_running_flags(command: argparse.ArgumentParser) -> None:
    """Which simulation, where maps are, and how to report."""
    names = " or ".join(f"{name} ({each.title})" for name, each in SIMULATORS.items())
    command.add_argument("--simulator", metavar="NAME", help=f"{names}; by default whichever runs")
    command.add_argument("--json", action="store_true", help="print what was done for programs")


def add_output_flag(command: argparse.ArgumentParser) -> None:
    """Where maps of recipes go."""
    text = "folder of the maps that are made of recipes; they stay there (default: worlds)"
    command.add_argument("-o", "--output", type=Path, default=Path("worlds"), metavar="DIR", help=text)


def map_of(target: str, which: str | None, output: Path) -> Map:
    """The map of a target: the given one, or the first; one of a recipe is to be in the output folder."""
    file, recipe, index = found(target, which)
    return Map(recipe=recipe.alone(index), folder=file.parent) if os.path.isdir(target) else made(recipe, index, output)


def maps_in(folder: str) -> list[Map]:
    """Every map in a folder, or the one whose folder it is."""
    return [Map(recipe=recipe_in(file), folder=file.parent) for file in recipe_files(folder)]
