"""Ratings from the parameters of `rsegen.rate` to its result: the fields, the robot, its judges, and the folder."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from rsegen.driving.drive import drivable
from rsegen.driving.many import ManyPlan, make_drives
from rsegen.driving.routes import Straight
from rsegen.errors import ParameterError, Stopped
from rsegen.input_files import checksum_of
from rsegen.obstacles.random import NormalRandom
from rsegen.params.plugins import Source
from rsegen.params.sorts import Json
from rsegen.rating.axes import AXES, refuse_unusable
from rsegen.rating.judges import Crosses, Judge, judge_by, judge_of, usual_duration
from rsegen.rating.rating import FILES, HOLDS, Curve, Rating
from rsegen.rating.reliability import ReliabilityTest
from rsegen.rating.run import Progress, RatingPlan, entry, make_curve, opened, read_entries
from rsegen.recipe.building import build
from rsegen.recipe.codec import encode, plugin_identities
from rsegen.recipe.recipe import Recipe
from rsegen.robots.base import ROBOTS
from rsegen.robots.files.sdf_file import is_robot_file
from rsegen.robots.files.xacro_files import with_arguments
from rsegen.robots.lookup import DrivableRobot, robot_file
from rsegen.writing.execute import Execution
from rsegen.writing.resources import refuse_too_large
from rsegen.writing.store import Store, refuse_taken


def usual_fields() -> Recipe:
    """Return the recipe of the usual fields: normal random blocks, 10 x 10 of 10 cm, without a frame; a fresh seed."""
    return Recipe(name="normal-random", boundary="none", obstacles=[NormalRandom(levels=4)])


@dataclass(frozen=True, kw_only=True, slots=True)
class Target:
    """The options of a run: where trials are made and written."""

    output: Path | None
    force: bool
    execution: Execution
    progress: Progress


@dataclass(frozen=True, kw_only=True, slots=True)
class Rated:
    """The rated subject: a robot with its motors and the longest time of a drive, or a function.

    robot: as the user gave it; limits: wheels, tracks and so on of the robot of a file
    """

    robot: str | os.PathLike[str] | DrivableRobot | Crosses
    limits: dict[str, Any]
    motors: str | None
    duration: float | None

    @property
    def is_function(self) -> bool:
        """Return whether this is a function of a user, and no robot."""
        return callable(self.robot)

    def model(self) -> DrivableRobot:
        """Return the robot; not for a function."""
        limits = {name: value for name, value in self.limits.items() if name not in ("wheels", "tracks")}
        return drivable(self.robot, self.limits["wheels"], self.limits["tracks"], **limits)  # type: ignore[arg-type]  # no function

    def judges(self, names: Sequence[str]) -> list[Judge]:
        """Return the judges of these names."""
        if callable(self.robot):
            self._refuse_for_function(names)
            return [judge_by(self.robot)]
        model = self.model()
        return [judge_of(name, model, self.motors, self.duration) for name in dict.fromkeys(names)]

    def _refuse_for_function(self, names: Sequence[str]) -> None:
        of_robots = {**self.limits, "motors": self.motors, "duration": self.duration}
        for name, value in of_robots.items():
            if value is not None:
                raise ParameterError(name, "is for a robot, not for a function that says whether it gets across")
        if tuple(names) != ("mujoco",):
            raise ParameterError("by", "is for a robot; a function judges by itself")

    @property
    def is_registered(self) -> bool:
        """Return whether a shell can name the robot: a kind or a file, not a robot made in Python."""
        return isinstance(self.robot, str | os.PathLike) or any(self.robot is known for known in ROBOTS.values())

    @property
    def source(self) -> Source | None:
        """The plug-in that the robot comes from; None without one."""
        if self.is_function or not self.is_registered:
            return None
        return ROBOTS.source(str(self.robot) if isinstance(self.robot, str | os.PathLike) else self.model().kind)

    def replay(self, folder: Path | None = None) -> tuple[str, ...]:
        """Return the flags of the robot for `rsegen drive` in a folder; empty if a shell cannot name it."""
        if not self.is_registered:
            return ()
        words = [_from(folder, str(self.robot)) if isinstance(self.robot, str | os.PathLike) else self.model().kind]
        for name, value in {**self.limits, "motors": self.motors}.items():
            if value is not None:
                words += [f"--{name}", ",".join(f"{part:g}" for part in value) if name == "size" else f"{value}"]
        return ("--robot", *words)

    def described(self) -> dict[str, Json]:
        """Return all that decides the robot's trials, for the journal; a file by its checksum, as it may change."""
        if callable(self.robot):
            return {"function": judge_by(self.robot).title}
        is_file = isinstance(self.robot, str | os.PathLike) and is_robot_file(self.robot)
        checksum = checksum_of(Path(with_arguments(self.robot)[0])) if is_file else None  # type: ignore[arg-type]  # a path
        return {
            "robot": str(self.robot) if isinstance(self.robot, str | os.PathLike) else self.model().kind,
            "made": "" if self.is_registered else hashlib.sha256(repr(self.robot).encode()).hexdigest(),
            "file": checksum.sha256 if checksum else None,
            "limits": {name: list(value) if isinstance(value, tuple) else value for name, value in self.limits.items()},
            "motors": self.motors,
            "duration": self.duration,
        }


def _from(folder: Path | None, robot: str) -> str:
    """Return a kind of robot, or its file with arguments, by its path from a folder."""
    if folder is None or not is_robot_file(robot):
        return robot
    file, _ = with_arguments(robot)
    try:
        path = os.path.relpath(file, folder)
    except ValueError:  # on Windows, on another drive
        path = os.path.abspath(file)
    return path + robot[len(file) :]


def rate_robot(  # noqa: PLR0913  # as `rsegen.rate`
    rated: Rated,
    recipe: Recipe,
    axis_name: str,
    by: Sequence[str],
    *,
    trials: int | None,
    precision: float,
    target: Target,
) -> Rating:
    """Return the rating of a robot on the fields of a recipe; see `rsegen.rate`."""
    # A trial is on the map of its number, so the recipe's own choice of maps is left out.
    axis, recipe = AXES[axis_name], replace(recipe, maps=1, first_map=0)
    refuse_unusable(axis, recipe)
    refuse_too_large(recipe)
    judges = rated.judges(by)
    plan = RatingPlan(recipe=recipe, axis=axis, trials=trials, precision=precision)
    # The folder is continued only if all of this is the same; precision and trials may differ, to narrow an interval.
    plugins = plugin_identities([recipe], [rated.source])
    content = {**rated.described(), **plugins, "axis": axis.name, "recipe": encode(recipe)}
    of: Json = json.loads(json.dumps(content))
    with opened(target.output, of, force=target.force) if target.output else nullcontext() as store:
        if store:
            store.announce_files(FILES)
        curves = _curves(plan, judges, store, target)
        rating = Rating(
            recipe=recipe,
            robot=judges[0].title if rated.is_function else rated.model().kind,
            axis=axis,
            curves=tuple(curves),
            replay=rated.replay(target.output),
            notes=tuple(_notes(recipe, curves)),
        )
        if store:
            store.put(rating.files(), force=True, holds=HOLDS)
    return rating


def _curves(plan: RatingPlan, judges: Sequence[Judge], store: Store | None, target: Target) -> list[Curve]:
    """Return the curve of each judge; Stopped, with how many trials are kept, after Ctrl-C."""
    begun = read_entries(store.folder, store.journal.content) if store else {}
    made = sum(len(begun.get(judge.title, ())) for judge in judges)
    curves: list[Curve] = []

    def keep(judge: Judge) -> Callable[[Any], None]:
        def note(trial: Any) -> None:
            nonlocal made
            if store:
                store.note(entry(judge, trial))
            made += 1

        return note

    def tell(count: int, share: float) -> None:
        target.progress(count, (len(curves) + share) / len(judges))

    try:
        for judge in judges:
            # A server of Gazebo takes a whole core or two by itself.
            alone = judge.name in ("classic", "sim")
            where = replace(target.execution, workers=1) if alone else target.execution
            curves.append(make_curve(plan, judge, begun.get(judge.title, ()), where, keep(judge), tell))
    except KeyboardInterrupt:
        if store is None:
            raise Stopped(f"{_trials(made)} made, and not kept", changed=False) from None
        raise Stopped(f"{_trials(made)} complete in {store.folder}", changed=bool(made)) from None
    return curves


def _trials(count: int) -> str:
    return f"{count} trial{'s'[: count != 1]}"


def _notes(recipe: Recipe, curves: Sequence[Curve]) -> list[str]:
    """Return notes on the fields, and on a curve without a level at which half are crossed."""
    notes = []
    if _are_alike(recipe):
        notes.append("all fields of this recipe are equal, so the interval only shows how finely levels were tried")
    if recipe.boundary != "none" and any(curve.outside == "hard" for curve in curves):
        notes.append("the frames are equally high at every level; boundary='none' leaves them out")
    return notes


def _are_alike(recipe: Recipe) -> bool:
    """Return whether all fields of a recipe are equal, as nothing in it is random."""
    first = build(recipe, 0).levels
    return all(np.array_equal(first, build(recipe, index).levels) for index in range(1, _COMPARED))


_COMPARED = 10
"""Fields of a recipe that are compared, until one differs: if there are only two, the first ones are often alike."""


def reliability_shown(  # as `rsegen.rate`
    rated: Rated,
    recipe: Recipe,
    *,
    reliability: float,
    confidence: float,
    repetitions: int,
    target: Target,
) -> ReliabilityTest:
    """Return the test of a robot on as many fields of a recipe as there are repetitions; see `rsegen.rate`."""
    if rated.is_function:
        raise ParameterError("reliability", "is for a robot; rsegen.failures_allowed says how many may fail")
    recipe = replace(recipe, maps=repetitions, first_map=0)
    if _are_alike(recipe):
        raise ParameterError("recipe", "has nothing random, so all repetitions would be the same drive")
    if target.output is not None:
        refuse_taken([target.output], force=target.force, holds="files")
    robot = rated.model()
    plan = ManyPlan(
        recipe=recipe,
        robot=robot,
        motors=rated.motors,
        route=Straight.name,
        best="length",
        duration=rated.duration or usual_duration(robot, build(recipe)),
        file=robot_file(rated.robot),
    )
    made = 0

    def tell(more: int) -> None:
        nonlocal made
        made += more
        target.progress(made, made / repetitions)

    result = ReliabilityTest(
        drives=make_drives(plan, target.execution, tell), reliability=reliability, confidence=confidence
    )
    if target.output is not None:
        result.write(target.output, force=target.force)
    return result
