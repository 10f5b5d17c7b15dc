"""Judges, which decide whether a robot crosses a field, each in its own way.

    mujoco        a drive as in `rsegen drive`, straight from the west side
    prediction    the robot's poses on its lane (standing/lanes.py), without a simulator
    classic, sim  a drive in a Gazebo server
    a function    of the user, called with a field and a seed

A judge is a picklable value for workers. The field of a trial is the map of its index, so no two trials have the same
field, and all judges see the same fields at a level.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import ceil
from typing import NamedTuple

import numpy as np

from rsegen.driving.commands import drive
from rsegen.driving.many import ManyPlan, drive_over
from rsegen.driving.planning import required_simulator
from rsegen.driving.prediction import DRIVE_SECONDS
from rsegen.driving.robot_runs import finish_x
from rsegen.driving.routes import Straight
from rsegen.errors import ParameterError, SimulatorFailed, shown
from rsegen.field.stepfield import StepField
from rsegen.params.streams import SEEDS
from rsegen.rating.axes import Axis
from rsegen.recipe.building import build
from rsegen.recipe.recipe import Recipe
from rsegen.robots.lookup import DrivableRobot
from rsegen.robots.parameters import MOTORS
from rsegen.scene.scene import compose
from rsegen.simulators.poses import adjacent_pose
from rsegen.simulators.server import choose_installation
from rsegen.standing.lanes import straight

Crosses = Callable[[StepField, int], bool]
"""A function that returns whether a robot gets across a field; the seed is for its random numbers."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Trial:
    """A robot on one field.

    map: the index of the field; level: on the axis; crossed: None without a result, for which failed has the reason
    seconds: until it was across; x: where it was at the end, metres; tipped: how often it tipped over; duration: the
    longest time of the drive, seconds. These four are None for a judge that does not drive.
    """

    map: int
    level: float
    crossed: bool | None
    seconds: float | None = None
    x: float | None = None
    tipped: int | None = None
    duration: float | None = None
    failed: str = ""


class Asked(NamedTuple):
    """A trial to be made: the index of its field, and its level."""

    map: int
    level: float


@dataclass(frozen=True, kw_only=True, slots=True)
class Judge(ABC):
    """A maker of trials. name: as `by` takes it; title: for people; cost: CPU seconds of a trial, about."""

    name: str
    title: str
    cost: float

    @abstractmethod
    def trial(self, recipe: Recipe, asked: Asked) -> Trial:
        """Return the trial on the map `asked.map` of a recipe, which has the level already."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Driven(Judge):
    """Drives straight from the west side; duration: seconds at most, None for the usual duration on each field."""

    robot: DrivableRobot
    duration: float | None

    def trial(self, recipe: Recipe, asked: Asked) -> Trial:
        """Return the trial of a drive."""
        duration = self.duration or usual_duration(self.robot, build(recipe, asked.map))
        known = Trial(map=asked.map, level=asked.level, crossed=None, duration=duration)
        return self.driven(recipe, duration, known)

    @abstractmethod
    def driven(self, recipe: Recipe, duration: float, known: Trial) -> Trial:
        """Return a trial with what the drive over its map showed."""


@dataclass(frozen=True, kw_only=True, slots=True)
class InMujoco(Driven):
    """Drives in the embedded simulator, each the same as `rsegen drive` over that map, bit by bit."""

    motors: str | None

    def driven(self, recipe: Recipe, duration: float, known: Trial) -> Trial:
        """Return a trial with what the drive over its map showed."""
        plan = ManyPlan(
            recipe=recipe,
            robot=self.robot,
            motors=self.motors,
            route=Straight.name,
            best="length",
            duration=duration,
        )
        row = drive_over(plan, known.map)
        if row.failed:
            return replace(known, failed=row.failed)
        return replace(known, crossed=row.crossed is not None, seconds=row.crossed, x=row.x, tipped=row.tipped)


@dataclass(frozen=True, kw_only=True, slots=True)
class InGazebo(Driven):
    """Drives in Gazebo, each in a server of its own."""

    def driven(self, recipe: Recipe, duration: float, known: Trial) -> Trial:
        """Return a trial with what the drive over its map showed."""
        # Neither contacts nor a prediction decides a trial, and both take time; a straight route draws nothing.
        try:
            result = drive(
                recipe.alone(known.map),
                robot=self.robot,
                simulator=self.name,
                duration=duration,
                contacts=False,
                seed=recipe.seed,
                predict=False,
            )
        except SimulatorFailed as error:
            return replace(known, failed=str(error))
        metrics, rows = result.robots[0].metrics, result.robots[0].trajectory.rows
        return replace(
            known,
            crossed=metrics.crossed is not None,
            seconds=metrics.crossed,
            x=round(float(rows[-1, 1]), 4),
            tipped=metrics.tipped,
        )


@dataclass(frozen=True, kw_only=True, slots=True)
class Predicted(Judge):
    """Predictions, by poses, of the lane on which the drives start."""

    robot: DrivableRobot

    def trial(self, recipe: Recipe, asked: Asked) -> Trial:
        """Return the trial of a prediction."""
        field, body = compose(recipe, asked.map).field, self.robot.body
        lane = straight(field, body, 0, np.array([adjacent_pose(field, body).y]))
        return Trial(map=asked.map, level=asked.level, crossed=bool(lane.passed[0]))


@dataclass(frozen=True, kw_only=True, slots=True)
class ByFunction(Judge):
    """A judge that calls a function of the user."""

    crosses: Crosses

    def trial(self, recipe: Recipe, asked: Asked) -> Trial:
        """Return the trial of the function; its seed is the recipe's plus the index."""
        crossed = self.crosses(compose(recipe, asked.map).field, (recipe.seed + asked.map) % SEEDS)
        if not isinstance(crossed, bool | np.bool_):
            raise ParameterError("robot", f"{_name(self.crosses)} returned {shown(crossed)}; a function returns a bool")
        return Trial(map=asked.map, level=asked.level, crossed=bool(crossed))


def trials(judge: Judge, axis: Axis, recipe: Recipe, several: Sequence[Asked]) -> list[Trial]:
    """Return several trials: the work of a worker."""
    return [judge.trial(axis.recipe_at(recipe, asked.level), asked) for asked in several]


_TIMES = 3
"""Longest duration of a drive, in times of that on level ground: hardly any that crossed took more than twice."""


def usual_duration(robot: DrivableRobot, field: StepField) -> float:
    """Return the usual longest duration of a drive across a field, whole seconds."""
    way = finish_x(field, robot) - adjacent_pose(field, robot.body_or_box).x
    return float(ceil(_TIMES * way / robot.driving_speed))


def judge_of(by: str, robot: DrivableRobot, motors: str | None, duration: float | None) -> Judge:
    """Return a judge of a robot by its name; NoSimulator if its simulator is not installed."""
    if by == "mujoco":
        title = f"{required_simulator('ratings need')}, motors as {motors or MOTORS[0]}"
        return InMujoco(name=by, title=title, cost=DRIVE_SECONDS, robot=robot, duration=duration, motors=motors)
    if by == "prediction":
        return Predicted(name=by, title="the prediction by its poses", cost=0.02, robot=robot)
    title = str(choose_installation("both", by))
    return InGazebo(name=by, title=title, cost=5.0, robot=robot, duration=duration)


def judge_by(crosses: Crosses) -> Judge:
    """Return the judge that calls a function."""
    return ByFunction(name="function", title=_name(crosses), cost=0.1, crosses=crosses)


def _name(crosses: Crosses) -> str:
    return str(getattr(crosses, "__name__", type(crosses).__name__))
