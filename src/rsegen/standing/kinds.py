"""Robots that stand on fields, by their kinds. A robot is made in the room of robots, above this one, and kept here.

So a recipe can name the robot that is to get across its maps, and knows nothing of links, drives and plug-ins.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rsegen.field.stepfield import StepField
from rsegen.params.registry import Contract, Registry
from rsegen.standing.body import Body
from rsegen.standing.resting import PoseStatistics, pose_statistics
from rsegen.standing.ways import Reach, Watch, Way, crossing, reach

DRIVING_SPEED = 0.4
"""Speed, m/s, at which faster robots drive on rough ground: tracked ones climb stairs of 10 and 20 cm with it.

Faster, a robot leaves the ground at edges, and what it meets depends on its springs, which these models do not have.
"""


class Standing(ABC):
    """A robot that stands and drives on step fields: whatever has a body, and a maximum speed, m/s."""

    __slots__ = ()

    kind: str
    if TYPE_CHECKING:  # a field of the one, a property of the other

        @property
        def speed(self) -> float: ...  # noqa: D102  # the class says it

    @property
    def driving_speed(self) -> float:
        """The speed at which it is driven on a field, m/s."""
        return min(self.speed, DRIVING_SPEED)

    @property
    @abstractmethod
    def body(self) -> Body:
        """The robot from below."""

    @property
    def body_or_box(self) -> Body:
        """The robot from below; a box of its size if its shapes are unknown."""
        return self.body

    @property
    def width(self) -> float:
        """Width of the robot, metres."""
        return self.body.width

    def ros_files(self) -> Mapping[str, str]:
        """Return the text of its files in a ROS 2 package by their names; none if it has no description."""
        return {}

    def reach(self, field: StepField) -> Reach:
        """Return where it gets on a field, and its ways across."""
        return reach(field, self.body)

    def crossing(self, field: StepField, axis: int) -> Way:
        """Return its way across a field, along x for axis 0, along y for axis 1."""
        return crossing(field, self.body, axis)

    def pose_statistics(self, field: StepField) -> PoseStatistics:
        """Return how it rests all over a field."""
        return pose_statistics(field, self.body)


@dataclass(frozen=True, kw_only=True, slots=True)
class Watched:
    """A robot that stands and drives, and reports the progress of its search of a map; `watch` may end the search."""

    body: Body
    watch: Watch

    @property
    def width(self) -> float:
        """Width of the robot, metres."""
        return self.body.width

    def reach(self, field: StepField) -> Reach:
        """Return where it gets on a field, and its ways across."""
        return reach(field, self.body, self.watch)

    def crossing(self, field: StepField, axis: int) -> Way:
        """Return its way across a field, along x for axis 0, along y for axis 1."""
        return crossing(field, self.body, axis)


ROBOTS: Registry[Standing] = Registry(
    "robot",
    package="rsegen.robots",
    group="rsegen.robots",
    contract=Contract(base=Standing, names=lambda robot: (robot.kind,), is_class=False),
)
"""Every robot by its kind."""
