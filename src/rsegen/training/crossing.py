"""A robot on tracks or wheels that learns to cross fields: its observations, actions and rewards.

    crossing = Crossing(recipe, robot="crawler")
    CrossingEnv(crossing)             # of `gymnasium`: one world of MuJoCo
    CrossingWorlds(crossing, 4096)    # of `worlds`: thousands of mujoco_warp, on a GPU

It begins west of a field, each time another one, and has to get beyond the east end, as in `rsegen drive`. Every
`period` it chooses its speed, its turn rate and the angles of its flippers (servos on which belts hang). They are
driven as in `rsegen drive`: belts with two frictions, motors with limits. The same arrays are computed for one world by
numpy, and for thousands by torch on their device.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import pi
from typing import Any, NamedTuple

import numpy as np

from rsegen.errors import ParameterError, refuse_other
from rsegen.field.stepfield import Array
from rsegen.learning.arrays import array_like, library_of
from rsegen.learning.ground import Ground
from rsegen.learning.mujoco import BlockGrid
from rsegen.learning.patterns import scan_points
from rsegen.mujoco.map_model import NamedBoxes
from rsegen.mujoco.settings import STEP
from rsegen.mujoco.turning import turn_gain
from rsegen.mujoco.world import MujocoWorld
from rsegen.params.sorts import Flag, Float
from rsegen.recipe.recipe import Recipe
from rsegen.robots.lookup import DrivableRobot, robot_of
from rsegen.scene.scene import compose
from rsegen.simulators.embedded import PlacedRobot
from rsegen.simulators.poses import DROP_HEIGHT, Pose
from rsegen.standing.spots import GAP

NAME = "robot"
"""The name of the robot in its worlds."""

_AHEAD, _ASIDE, _APART = 0.8, 0.1, 0.1
"""Metres that a robot sees ahead, and to either side, and the distance between the points that it sees."""

_SEES = 0.5
"""Metres above or below the robot's origin up to which ground is seen; higher or lower ground counts as that."""

_TIPPED = 0.3
"""Cosine of the tilt from which on a robot lies on its side or back."""

_HEADING = 0.35
"""Largest heading at the start, radians, to either side."""

_ARRIVED, _FELL, _CLOCK, _STEERED = 5.0, -2.0, -0.01, -0.02
"""Rewards, in metres of way: for getting across, for tipping over or leaving the lane, for each period, and for each
radian between the robot's heading and east."""

_SECONDS, _FLIPPER_SPEED = Float(STEP, 1e6, unit="s"), Float(0, 1000, unit="rad/s")


class Flipper(NamedTuple):
    """A servo on which a belt hangs: where its angle is in `qpos` and its target in `ctrl`; its range, radians."""

    angle_at: int
    target_at: int
    rest: float
    low: float
    high: float


class Outcome(NamedTuple):
    """Outcome of a step in each world: the reward, whether the robot got across, whether it fell or left its lane."""

    reward: Any
    is_across: Any
    has_failed: Any


@dataclass(frozen=True, kw_only=True)
class Crossing:
    """A robot that crosses the fields of a recipe, which has no frames; ParameterError for one that cannot drive.

    robot: a kind, or the file of a robot; uses_flippers: False to hold them at rest
    period: seconds between two choices; seconds: of an episode; flipper_speed: rad/s at most
    """

    recipe: Recipe
    robot: str | DrivableRobot = "crawler"
    uses_flippers: bool = True
    period: float = 0.1
    seconds: float = 20.0
    flipper_speed: float = 1.5

    def __post_init__(self) -> None:
        refuse_other("recipe", self.recipe, Recipe)
        Flag().check("uses_flippers", self.uses_flippers)
        if not self.recipe.is_of_one_friction:
            raise ParameterError("level_friction", "robots of rsegen cross fields of one friction; set only `friction`")
        _SECONDS.check("seconds", self.seconds)
        _SECONDS.check("period", self.period)
        _FLIPPER_SPEED.check("flipper_speed", self.flipper_speed)
        if self.period > self.seconds:
            raise ParameterError("period", f"{self.period} s; an episode has only {self.seconds} s")

    @cached_property
    def driven(self) -> DrivableRobot:
        """The robot."""
        return robot_of(self.robot)

    @cached_property
    def grid(self) -> BlockGrid:
        """The blocks of the field."""
        return BlockGrid(self.recipe)

    @property
    def steps(self) -> int:
        """Steps of the simulator in a period."""
        return round(self.period / STEP)

    @property
    def periods(self) -> int:
        """Periods of an episode."""
        return round(self.seconds / self.period)

    @cached_property
    def pattern(self) -> Array:
        """The points that the robot sees, (points, 2), metres, in its frame."""
        low, high = self.driven.body_or_box.low, self.driven.body_or_box.high
        length, width = float(high[0] - low[0]) + _AHEAD, float(high[1] - low[1]) + 2 * _ASIDE
        middle = float(high[0] + low[0] + _AHEAD) / 2
        return np.asarray(scan_points((length, width), _APART) + np.array([middle, 0.0]))

    @cached_property
    def lane(self) -> tuple[float, float, float]:
        """The x of the start, the x beyond which the robot is across, and half of the lane's width, metres."""
        body, block = self.driven.body_or_box, self.recipe.block_width_cm / 100
        length, width = (count * block for count in self.recipe.grid.shape)
        return -length / 2 - GAP - float(body.high[0]), length / 2 - float(body.low[0]), width / 2

    @cached_property
    def blocks(self) -> slice:
        """The numbers of the blocks' geoms: MuJoCo has the plane before them."""
        return slice(1, 1 + len(self.grid.names))

    @property
    def placed(self) -> PlacedRobot:
        """The robot in the middle of the lane at its start."""
        return PlacedRobot(name=NAME, robot=self.driven, start=self.start(0.0, 0.0))

    def world(self) -> MujocoWorld:
        """Return a world of MuJoCo with the robot at its start, and all blocks as high as the highest."""
        grid, highest = self.grid, self.grid.highest
        flat = compose(Recipe(name="flat", boundary="none", friction=self.recipe.friction))
        boxes = NamedBoxes(grid.name, grid.names, grid.pos(highest), grid.size(highest))
        return MujocoWorld(flat, [self.placed], period=float("inf"), gains=[turn_gain(self.driven)], boxes=boxes)

    def start(self, aside: float, heading: float) -> Pose:
        """Return a start pose; aside, heading: from -1 to 1, as shares of `spread`."""
        return Pose(x=self.lane[0], y=aside * self.spread[0], z=DROP_HEIGHT, yaw=heading * self.spread[1])

    @cached_property
    def spread(self) -> tuple[float, float]:
        """Largest offset to the side at a start, metres, so that blocks are ahead, and largest heading, radians."""
        body = self.driven.body_or_box
        return max(self.lane[2] - float(body.high[1] - body.low[1]) / 2, 0.0), _HEADING

    def flippers(self, world: MujocoWorld) -> list[Flipper]:
        """Return the flippers of the robot; empty if they are held at rest."""
        if not self.uses_flippers:
            return []
        (robot,), model = world.robots, world.model
        belts = {f"{NAME}/{link}" for link in (*robot.drive.left, *robot.drive.right)}
        flippers = []
        for name, servo in robot.servos:
            joint = model.joint(name)
            if model.body(int(model.jnt_bodyid[joint.id])).name in belts:
                low, high = joint.range if model.jnt_limited[joint.id] else (-pi, pi)
                target_at = model.actuator(name).id
                flippers.append(Flipper(int(joint.qposadr[0]), target_at, servo.rest, float(low), float(high)))
        return flippers

    # Arrays of all worlds, (worlds, ...), of numpy or torch.

    def speeds(self, action: Any) -> tuple[Any, Any]:
        """Return the speed, m/s, and the turn rate, rad/s, of actions, (worlds, 2 or more) from -1 to 1."""
        drive = self.driven.drive
        return action[..., 0] * drive.speed, action[..., 1] * drive.turn

    def angles(self, action: Any, targets: Any, flippers: list[Flipper]) -> Any:
        """Return the next targets of flippers, (worlds, flippers), radians: from the last ones towards the actions."""
        library, action = library_of("action", action)
        low = array_like(action, [flipper.low for flipper in flippers], action.dtype)
        high = array_like(action, [flipper.high for flipper in flippers], action.dtype)
        chosen = low + (high - low) * (action[..., 2:] + 1) / 2
        most = self.flipper_speed * self.period
        return targets + library.clip(chosen - targets, -most, most)

    def observe(self, qpos: Any, qvel: Any, angles: Any, action: Any, ground: Ground) -> Any:
        """Return observations, (worlds, numbers): ground, tilt, speeds, heading, place, flippers, last action.

        qpos: (worlds, 7) of its origin; qvel: (worlds, 6); angles: of flippers; ground: of all worlds
        """
        library, qpos = library_of("qpos", qpos)
        turn = _rotation(library, qpos[..., 3:7])
        yaw = library.arctan2(turn[..., 1, 0], turn[..., 0, 0])[..., None]
        pattern = array_like(qpos, self.pattern, qpos.dtype)
        below = ground.scan(pattern, library.concatenate([qpos[..., :3], yaw], -1))
        # A free joint has its velocity in the world's frame, and its turn rate in its own: here both are in its own.
        back = library.swapaxes(turn, -1, -2)
        ahead = (back @ qvel[..., :3, None])[..., 0]
        return library.concatenate(
            [
                library.clip(below, -_SEES, _SEES) / _SEES,
                turn[..., 2, :],  # up, in its own frame
                ahead,
                qvel[..., 3:6],
                library.sin(yaw),
                library.cos(yaw),
                qpos[..., 1:2] / self.lane[2],
                angles,
                action,
            ],
            -1,
        )

    def judge(self, before: Any, qpos: Any) -> Outcome:
        """Return the outcome of a period; before: x of the robots before it, (worlds,); qpos: poses after it."""
        library, qpos = library_of("qpos", qpos)
        _, finish, half = self.lane
        turn = _rotation(library, qpos[..., 3:7])
        heading = library.abs(library.arctan2(turn[..., 1, 0], turn[..., 0, 0]))
        is_across = qpos[..., 0] >= finish
        has_failed = ~is_across & ((turn[..., 2, 2] < _TIPPED) | (library.abs(qpos[..., 1]) > half))
        reward = qpos[..., 0] - before + _CLOCK + _STEERED * self.period * heading
        return Outcome(reward + _ARRIVED * is_across + _FELL * has_failed, is_across, has_failed)


def _rotation(library: Any, quaternion: Any) -> Any:
    """Return the rotation matrices, (..., 3, 3), of quaternions, (..., 4), w first."""
    w, x, y, z = (quaternion[..., at] for at in range(4))
    rows = (
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )
    return library.stack([library.stack(row, -1) for row in rows], -2)
