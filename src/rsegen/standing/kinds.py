"""Robots that stand on fields, whatever they are made of: `rsegen.robots` has them of links and drives, or of files."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

from rsegen.field.crossing import CrossingModel
from rsegen.field.stepfield import Ints, Mask, StepField
from rsegen.params.watch import report_share
from rsegen.standing.body import Body
from rsegen.standing.lattice import Watch
from rsegen.standing.lowering import lane_caps, lane_cells
from rsegen.standing.planner import best_way
from rsegen.standing.pose_statistics import PoseStatistics, pose_statistics
from rsegen.standing.reach import Reach, reach
from rsegen.standing.stable import stable_poses
from rsegen.standing.ways import Way, events

if TYPE_CHECKING:
    from rsegen.params.plugins import Source
    from rsegen.scene.scene import Scene
    from rsegen.standing.drawing import RobotDrawing

DRIVING_SPEED = 0.4
"""Speed, m/s, at which faster robots drive on rough ground, as tracked ones climb stairs of 10 and 20 cm: faster,
they leave the ground at edges, and springs count, which these models do not have."""


class RobotOnField(CrossingModel):
    """A robot that stands and drives on step fields: whatever has a body, and a maximum speed, m/s."""

    __slots__ = ()

    kind: str
    if TYPE_CHECKING:  # a field of some of its classes, a property of others

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

    @property
    def room(self) -> float:
        """Room to spare of lanes that are made for it, as a share of the default."""
        return 1.0

    def reach(self, field: StepField) -> Reach:
        """Return where it gets on a field, and its ways across."""
        return reach(field, self.body)

    def crossing(self, field: StepField, axis: int) -> Way:
        """Return its way across a field, along x for axis 0, along y for axis 1."""
        return best_way(field, self.body, axis)

    def pose_statistics(self, field: StepField) -> PoseStatistics:
        """Return how it rests all over a field."""
        return pose_statistics(field, self.body)

    def caps(self, field: StepField, axis: int) -> Ints | None:
        """Return the highest levels along a straight lane that the robot drives; None if it drives one already."""
        report = partial(report_share, self.search)
        return lane_caps(field, self.body, axis, room=self.room, kind=self.kind, report=report)

    def lanes(self, field: StepField) -> Mask:
        """Return the cells of the lanes that it drives: poses of each change would take too long."""
        return lane_cells(field, self.body)

    @property
    def search(self) -> str:
        """The search for lanes, in words."""
        return f"a way for the {self.kind}"

    def in_words(self, units: str) -> str:
        """Return its kind."""
        return self.kind

    def watched(self, watch: Watch) -> RobotOnField:
        """Return the same robot that reports the progress of its search."""
        return RobotWithProgress(robot=self, watch=watch)

    def events(self, way: Way) -> list[str]:
        """Return the drops and slides on a way, in words."""
        return events(way)

    def drawn_at(self, field: StepField, x: float, y: float, heading: float) -> RobotDrawing:
        """Return the robot as it settles after it was put down at x, y [m] with a heading [rad], to be drawn."""
        from rsegen.standing.drawing import RobotDrawing

        stable = stable_poses(field, self.body, x, y, heading)
        return RobotDrawing(body=self.body, rests=stable.level, stable=int(stable.count[0]))

    def pose_maps(self, scene: Scene, heading: float, format: str) -> bytes:  # noqa: A002  # matplotlib's word
        """Return maps of its tilt, margin and reason at a heading [rad], as an image file."""
        from rsegen.standing.plots import pose_maps

        return pose_maps(scene, self.body, heading, format, robot=self.kind)


@dataclass(frozen=True, kw_only=True, slots=True)
class _SameRobot(RobotOnField):
    """A robot that looks for its ways in another manner."""

    robot: RobotOnField

    @property
    def kind(self) -> str:  # type: ignore[override]  # read-only, as the robot says it
        """Kind of the robot."""
        return self.robot.kind

    @property
    def plugin(self) -> Source | None:
        """The package or file that it comes from."""
        return self.robot.plugin

    @property
    def body(self) -> Body:
        """The robot from below."""
        return self.robot.body


@dataclass(frozen=True, kw_only=True, slots=True)
class RobotWithRoom(_SameRobot):
    """A robot whose lanes have less room to spare, as a share of what is usual."""

    room: float


@dataclass(frozen=True, kw_only=True, slots=True)
class RobotWithProgress(_SameRobot):
    """A robot that reports the progress of its search of a map; `watch` may end the search."""

    watch: Watch

    def reach(self, field: StepField) -> Reach:
        """Return where it gets on a field, and its ways across."""
        return reach(field, self.body, self.watch)
