"""rsegen metrics: how rough maps are, and what a robot can do on them."""

from __future__ import annotations

import argparse
import csv
import json
import sys
from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import Any

from rsegen.cli.flags import Subparsers, add_force_flag, add_parameter_flags, add_target_recipe_flags, given
from rsegen.cli.measured import Measured, report
from rsegen.cli.parser import HelpRow
from rsegen.cli.picture_path import picture_path
from rsegen.cli.targets import add_target_flags, scenes_of
from rsegen.errors import ParameterError
from rsegen.exporters.pictures.preview import image_format
from rsegen.exporters.pictures.robot_plots import path_plot
from rsegen.exporters.scene import Scene
from rsegen.field.metrics import Metrics, RobotLimits, metrics
from rsegen.field.metrics.catalogue import custom, flattened, nested
from rsegen.robots import ROBOTS, robot
from rsegen.run.store import write_file

_NO_ROBOT = "give a robot, as in --robot burger or --climb-cm 10"


def add(commands: Subparsers) -> None:
    """The parser of this command."""
    command = commands.add_parser(
        "metrics",
        description="Measure how rough maps are: heights, steps, scale, ruggedness, and the smallest step with "
        "which they can be crossed. With a robot, also the area that it can reach, and its cheapest paths across.",
        epilog="docs/metrics.md has every formula.",
    )
    add_target_flags(command, usual="all")
    group = command.add_argument_group("robot", "the limits of a kind of robot, each overridden by a flag")
    group.add_argument(
        "--robot", metavar="KIND", help="use the highest step that this robot usually crosses, and its width"
    )
    add_parameter_flags(group, RobotLimits)
    output = command.add_argument_group("output")
    form = output.add_mutually_exclusive_group()
    form.add_argument("--json", action="store_true", help="print a list as JSON, lengths in metres")
    form.add_argument("--csv", action="store_true", help="print a table as CSV, lengths in metres")
    text = "draw the robot's cheapest paths over the first map, and the area that it can reach"
    output.add_argument("-o", "--output", metavar="PICTURE", help=text)
    add_force_flag(output, "an existing picture")
    add_target_recipe_flags(command)
    command.add_rows("kinds of robots", lambda: [HelpRow(kind, each.title) for kind, each in ROBOTS.items()])
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Measure, draw and print."""
    climber = _climber(arguments)
    path = _picture(arguments, climber)
    scenes = scenes_of(arguments, "measure")
    first = next(scenes)
    found = metrics(first.field, climber)
    if path and found.reach:
        write_file([path_plot(first, found.reach, image_format(path))], path, force=arguments.force)
    _print(chain([(first, found)], ((scene, metrics(scene.field, climber)) for scene in scenes)), arguments)


def _picture(arguments: argparse.Namespace, climber: RobotLimits | None) -> Path | None:
    """Where the picture goes, if one is wanted and can be."""
    path = picture_path(arguments.output, force=arguments.force)
    if path and climber is None:
        raise ParameterError("-o/--output", f"there is nothing to draw without a robot; {_NO_ROBOT}")
    return path


def _climber(arguments: argparse.Namespace) -> RobotLimits | None:
    """The robot that the flags describe."""
    said = given(RobotLimits, arguments)
    if arguments.robot is not None:
        return replace(robot(arguments.robot, "--robot").limits, **said)
    if said and "climb_cm" not in said:
        raise ParameterError("--climb-cm", f"is missing; {_NO_ROBOT}")
    return RobotLimits(**said) if said else None


def _print(measured: Iterable[Measured], arguments: argparse.Namespace) -> None:
    if arguments.json:
        print(json.dumps([_entry(*one) for one in measured], indent=2))
    elif arguments.csv:
        _print_table(dict(flattened(_entry(*one))) for one in measured)
    else:
        for line in report(measured):
            print(line)


def _entry(scene: Scene, found: Metrics) -> dict[str, Any]:
    whole: dict[str, Any] = {"map": scene.name, "seed": scene.recipe.seed, **nested(found)}
    return {name: value for name, value in whole.items() if value is not None} | custom(scene.field)


def _print_table(rows: Iterator[dict[str, object]]) -> None:
    first = next(rows)
    writer = csv.DictWriter(sys.stdout, list(first), lineterminator="\n")
    writer.writeheader()
    writer.writerows(chain([first], rows))
