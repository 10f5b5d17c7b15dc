"""The command `rsegen rate`."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from rsegen.cli.edge import how_to_go_on
from rsegen.cli.flags import add_input, add_recipe_flags, recipe_from, with_flags
from rsegen.cli.parameters import Force, Scheduler, Workers
from rsegen.cli.parser import Parser
from rsegen.cli.report import Report, share_bar
from rsegen.driving.parameters import Size, Speed, Tracks, Turn, Wheels
from rsegen.errors import ParameterError, refuse_other
from rsegen.field.crossing import robot_kinds
from rsegen.params.command import Shell, add_flags, command, declared, flags_in_errors, given
from rsegen.params.sorts import Choice, FilePath, Float, Integer, ListOf, Reference
from rsegen.robots.parameters import MotorModel
from rsegen.simulators.parameters import ignore

if TYPE_CHECKING:
    from rsegen.rating.judges import Crosses
    from rsegen.rating.rating import Rating
    from rsegen.rating.reliability import ReliabilityTest
    from rsegen.recipe.recipe import Recipe
    from rsegen.robots.lookup import DrivableRobot

_PRECISION, _CONFIDENCE, _REPETITIONS = 10.0, 0.85, 30


@command
def rate(  # noqa: PLR0913  # each is a flag
    robot: Annotated[
        str | os.PathLike[str] | DrivableRobot | Crosses,
        Reference(
            "a kind of robot, or a file of one",
            help="kind of robot, or SDF, URDF, Xacro or MJCF file, as 'FILE NAME:=VALUE ...' with arguments; in Python "
            "also a function of a StepField and a seed, which returns whether something gets across",
            types=(object,),
        ),
        Shell(
            ("ROBOT",), "KIND|FILE", help="kind of robot, or SDF, URDF, Xacro or MJCF file, as 'FILE NAME:=VALUE ...'"
        ),
    ],
    recipe: Recipe | None = None,
    *,
    axis: Annotated[
        str,
        Choice(
            ("unit", "difficulty", "block_width", "slope"),
            help="what makes fields harder: a larger unit, more difficulty, narrower blocks, or a steeper slope of one "
            "unit per block",
        ),
    ] = "unit",
    by: Annotated[
        str | Sequence[str],
        ListOf(
            Choice(("mujoco", "prediction", "classic", "sim")),
            help="what judges whether the robot crosses: mujoco, prediction (by its poses, without a simulator), "
            "classic or sim (Gazebo); or several, whose curves are drawn in one plot",
        ),
        Shell(metavar="NAME[,NAME]"),
    ] = ("mujoco",),
    precision: Annotated[
        float,
        Float(
            2, 100, unit="%", help="stop when the 95 % interval of half is at most this far up and down of its middle"
        ),
        Shell(metavar="PERCENT"),
    ] = _PRECISION,
    trials: Annotated[
        int | None,
        Integer(8, 100_000, help="fixed number of trials, instead of a precision"),
        Shell(metavar="N", default="as many as the precision needs"),
    ] = None,
    reliability: Annotated[
        float | None,
        Float(0, 1, help="test instead whether the robot crosses this share of the fields as they are"),
        Shell(metavar="SHARE"),
    ] = None,
    confidence: Annotated[
        float | None,
        Float(0, 1, help="with a reliability: probability that a worse robot fails the test"),
        Shell(metavar="SHARE", default=f"{_CONFIDENCE:g}"),
    ] = None,
    repetitions: Annotated[
        int | None,
        Integer(1, 100_000, help="with a reliability: number of drives"),
        Shell(metavar="N", default=f"{_REPETITIONS}"),
    ] = None,
    wheels: Wheels = None,
    tracks: Tracks = None,
    size: Size = None,
    speed: Speed = None,
    turn: Turn = None,
    motors: MotorModel = None,
    duration: Annotated[
        float | None,
        Float(0.1, 1e5, unit="s", help="maximum simulation time of a drive"),
        Shell(metavar="S", default="three times that on level ground"),
    ] = None,
    seed: int | None = None,
    output: Annotated[
        str | Path | None,
        FilePath(help="folder for the trials, the curve and a plot; a stopped rating is continued"),
        Shell(("-o", "--output"), "DIR"),
    ] = None,
    force: Force = False,
    workers: Workers = 1,
    scheduler: Scheduler = None,
    progress: Callable[[int, float], None] | None = None,
) -> Rating | ReliabilityTest:
    """Find how hard a field a robot crosses: the level at which it crosses half of fresh fields, with a 95 % interval.

    Each trial is a straight drive over a field that no other trial has, at the level where its outcome tells most. The
    same seed gives the same trials, wherever they are made.

    Parameters
    ----------
    recipe : Recipe, optional
        The fields; by default normal random blocks, 10 x 10 of 10 cm, without a frame.
    seed : int, optional
        Seed of the fields, by default the recipe's.
    progress : callable, optional
        Called with the number of finished trials, and an estimate of their share of all.

    Returns
    -------
    Rating or ReliabilityTest
        The levels at which half and 80 % of the fields are crossed; with a reliability the outcome of that test.

    Raises
    ------
    UserError
        If a value is wrong, a simulator is not installed, or the folder has something else.
    """
    from dataclasses import replace

    from rsegen.rating.rate import Rated, Target, rate_robot, reliability_shown, usual_fields
    from rsegen.recipe.recipe import Recipe
    from rsegen.writing.execute import Execution
    from rsegen.writing.store import unchanged_if_stopped

    fields = usual_fields() if recipe is None else recipe
    refuse_other("recipe", fields, Recipe)
    fields = fields if seed is None else replace(fields, seed=seed)
    limits = {"wheels": wheels, "tracks": tracks, "size": size, "speed": speed, "turn": turn}
    rated = Rated(robot=robot, limits=limits, motors=motors, duration=duration)
    target = Target(
        output=None if output is None else Path(output),
        force=force,
        execution=Execution(workers=workers, scheduler=scheduler),
        progress=progress or ignore,
    )
    # A rating and a test of reliability share the robot and the fields; parameters of the other one are refused.
    if reliability is None:
        for name, value in (("confidence", confidence), ("repetitions", repetitions)):
            if value is not None:
                raise ParameterError(name, "is for a test of reliability; set reliability too")
        return rate_robot(rated, fields, axis, by, trials=trials, precision=precision / 100, target=target)
    _refuse_for_reliability(trials=trials, by=tuple(by), axis=axis, precision=precision)
    with unchanged_if_stopped(output):
        return reliability_shown(
            rated,
            fields,
            reliability=reliability,
            confidence=_CONFIDENCE if confidence is None else confidence,
            repetitions=_REPETITIONS if repetitions is None else repetitions,
            target=target,
        )


_FOR_RATINGS: Mapping[str, str] = {
    "trials": "the drives of a test of reliability are repetitions",
    "by": "a test of reliability drives in MuJoCo",
    "axis": "the fields of a test of reliability are as the recipe has them",
    "precision": "a test of reliability ends after its repetitions",
}
"""Parameters that a test of reliability does not take, and why."""


def _refuse_for_reliability(**values: object) -> None:
    for name, value in values.items():
        if value != declared(rate)[name].default:
            raise ParameterError(name, f"is for a rating; {_FOR_RATINGS[name]}")


_TEST = ("reliability", "confidence", "repetitions")

_ROBOT = ("wheels", "tracks", "size", "speed", "turn", "motors", "duration")


def add_rate(command: Parser) -> None:
    """Add the flags of `rsegen rate`."""
    epilog = (
        "The folder gets rating.json, trials.csv, rating.png and recipe.json; rating.json has the command that drives "
        "each trial again. The same command continues a stopped rating, or narrows its interval. A test of reliability "
        "that is not passed ends with exit code 1."
    )
    command.explain(rate.__doc__, epilog, robot_kinds)
    model = declared(rate)["robot"]
    kinds: Any = command.add_argument("robot", metavar="ROBOT", help=model.help)
    kinds.declared = model  # for forms
    add_input(command)
    add_flags(command.group("rating"), rate, without=["robot", *_TEST, *_ROBOT])
    add_flags(command.group("robot"), rate, only=_ROBOT)
    add_flags(command.group("test of reliability"), rate, only=_TEST)
    add_recipe_flags(command)


def run_rate(arguments: argparse.Namespace) -> Report:
    """Rate a robot, and say how hard a field it crosses; the exit code is 1 if it has not passed a test."""
    from rsegen.rating.rate import usual_fields
    from rsegen.rating.reliability import ReliabilityTest
    from rsegen.writing.execute import cores

    with flags_in_errors(rate):
        is_usual = arguments.recipe is None and not arguments.obstacle
        recipe = with_flags(usual_fields(), arguments) if is_usual else recipe_from(arguments)
    options = {"workers": cores()} | {name: value for name, value in given(rate, arguments).items() if name != "robot"}
    with how_to_go_on(recipe), share_bar("rating") as bar, flags_in_errors(rate):
        result = rate(arguments.robot, recipe, **options, progress=lambda _, share: bar(share))
    is_failed = isinstance(result, ReliabilityTest) and not result.has_passed
    return Report(lines=result.report(), content=result.as_json, code=int(is_failed))
