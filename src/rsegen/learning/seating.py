"""Any MuJoCo model, on wheels or legs, put on the ground: touching nothing, or dropped until it rests.

    data.qpos[:2], data.qpos[7:] = (0.3, 0.2), standing     # where it is to be, and how it holds its joints
    seat(model, data, ground)                               # a millimetre above the blocks
    seat(model, data, ground, seconds=3)                    # at rest on them

Idea: the ground is full below its surface, so a robot that is in it at one height is in it at every lower one, and the
height at which it touches is found by bisection. MuJoCo itself says whether it touches, geom by geom, if the model has
the blocks; the boxes around the geoms bound the height, and are all there is if it does not. A drop is a simulation of
a stiff robot: all joints but those by which it moves as a whole are too inert to move (`armature`).

Cost: about fifteen collisions of the model per robot, and the steps of a drop. What breaks it: a robot that starts
under something that overhangs; meshes touch by their convex hulls, as in MuJoCo.
"""

from __future__ import annotations

from copy import copy
from typing import Any

import mujoco
import numpy as np

from rsegen.errors import ParameterError
from rsegen.field.stepfield import Array, Ints, Mask
from rsegen.learning.ground import Ground
from rsegen.learning.mujoco import BlockGrid, Root, geom_bounds, roots_of
from rsegen.params.sorts import Float

CLEARANCE = 1e-3
"""Metres that stay free below a robot that is put on the ground."""

_PRECISION = 1e-4
"""Metres to which the height is found."""

_BELOW = 0.01
"""Metres below the lowest ground under a robot at which it would surely be in it."""

_CHECK = 0.05
"""Seconds between two looks at whether a robot rests."""

_STILL = 5e-3
"""Metres and radians per second up to which it does, at two looks one after the other."""

_SLOWED = 0.2
"""Seconds in which a falling robot loses most of its speed: it is put down gently, at two metres per second at most."""

_HELD = 1e6
"""Inertia of joints that are held, over the mass of the model times the square of its extent."""

_BOUNDS = ("geom_rbound", "geom_aabb", "bvh_aabb")
"""Arrays of a model that say where geoms may touch, which `mj_setConst` computes anew (4.0)."""

_SECONDS = Float(0, 1e6, unit="s")


def seat(model: Any, data: Any, ground: Ground, *, seconds: float = 0.0) -> bool:
    """Put the bodies of a MjData that can rise on the ground where they are, still; return whether they rest there.

    Parameters
    ----------
    model : mujoco.MjModel
        The model, with the blocks of the ground in it (`BlockGrid`, `add_map`), or boxes around geoms decide.
    data : mujoco.MjData
        Positions of the joints; the heights of roots, free joints or slides along z, are written.
    ground : Ground
        The ground, of one map.
    seconds : float, default 0
        Simulated seconds for which it is dropped at most, with its joints held; 0 leaves it above the ground.

    Returns
    -------
    bool
        Whether everything came to rest; False if nothing was dropped.
    """
    positions, rests = seat_many(model, data.qpos[None], ground, seconds=seconds)
    data.qpos[:], data.qvel[:] = positions[0], 0.0
    mujoco.mj_forward(model, data)
    return bool(rests[0])


def seat_many(
    model: Any, qpos: Array, ground: Ground, grid: BlockGrid | None = None, *, seconds: float = 0.0
) -> tuple[Array, Mask]:
    """Return positions of joints (robots, nq) with each robot on the ground, and which of them came to rest.

    Parameters
    ----------
    model : mujoco.MjModel
        The model of one robot, with the blocks.
    qpos : array, shape (robots, nq)
        Positions of the joints of each robot.
    ground : Ground
        The ground: one map for all robots, or a world for each.
    grid : BlockGrid, optional
        The blocks of the model, into which the map of each world is written; the model itself stays as it is.
    seconds : float, default 0
        As of `seat`.

    Returns
    -------
    positions : ndarray, shape (robots, nq)
        The positions of the joints.
    rests : ndarray of bool, shape (robots,)
        Whether a robot came to rest.
    """
    positions, seconds = np.array(qpos, dtype=float), _SECONDS.check("seconds", seconds)
    if positions.ndim != 2 or positions.shape[1] != model.nq:
        raise ParameterError("qpos", f"of shape {positions.shape}; expected (robots, {model.nq})")
    if not np.isfinite(positions).all():
        robot, joint = np.argwhere(~np.isfinite(positions))[0]
        raise ParameterError(f"qpos[{robot}, {joint}]", f"{positions[robot, joint]} is not a finite number")
    if ground.worlds is not None and (ground.worlds != len(positions) or grid is None):
        problem = f"{len(positions)} robots on the ground of {ground.worlds} worlds"
        raise ParameterError("ground", f"{problem}; use as many of both, and the grid whose blocks are in the model")
    seats = Seats(model)
    rests = np.zeros(len(positions), dtype=bool)
    for robot, own in enumerate(positions):
        if grid is not None:
            grid.write(seats.model, ground.field(robot).levels)
        seats.put(own, ground, None if ground.worlds is None else robot)
        if seconds > 0:
            rests[robot] = seats.drop(seconds)
        positions[robot] = seats.data.qpos
    return positions, rests


class Seats:
    """A copy of a model that is stiff but for its roots, and the state of the robot that is put down."""

    def __init__(self, model: Any) -> None:
        self.model = stiff = copy(model)
        self.data = mujoco.MjData(stiff)
        self.roots = roots_of(model)
        is_static = model.body_weldid[model.geom_bodyid] == 0
        self._static = is_static & ((model.geom_contype != 0) | (model.geom_conaffinity != 0))
        moving = [body for root in self.roots for body in root.bodies]
        is_held = ~np.isin(model.jnt_bodyid, moving)[model.dof_jntid]
        stiff.dof_armature[is_held] = _HELD * float(model.body_subtreemass[0]) * model.stat.extent**2
        stiff.dof_damping[~is_held] = model.dof_M0[~is_held] / _SLOWED
        # Nothing may move a held joint: neither motors, nor limits that a given pose violates.
        stiff.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_ACTUATION | mujoco.mjtDisableBit.mjDSBL_LIMIT
        bounds = {name: getattr(stiff, name).copy() for name in _BOUNDS}
        mujoco.mj_setConst(stiff, self.data)  # contacts are as stiff and damped as the mass behind them wants
        for name, values in bounds.items():  # those of all maps, in place of those of the one that it has now
            getattr(stiff, name)[:] = values
        # The solver judges how exact it is by the mean inertia, which is that of the held joints now: it goes on.
        stiff.opt.tolerance, stiff.opt.ls_tolerance = 0.0, 1e-6

    def put(self, qpos: Array, ground: Ground, world: int | None = None, *, lower: bool = True) -> Array:
        """Put all that can rise a little above the ground, and return the positions; lower: also what is higher."""
        mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[:] = qpos
        for root in self.roots:
            start = float(self.data.qpos[root.at])
            lowest, highest = self._bounds(root.geoms, ground, world)
            # A model without the blocks touches nothing at the lowest height either: the bounds decide.
            has_blocks = self._is_inside(root, start, lowest)
            while has_blocks and highest - lowest > _PRECISION:
                middle = (lowest + highest) / 2
                if self._is_inside(root, start, middle):
                    lowest = middle
                else:
                    highest = middle
            rise = highest + CLEARANCE if lower else max(highest + CLEARANCE, 0.0)
            self.data.qpos[root.at] = start + root.upwards * rise
        mujoco.mj_forward(self.model, self.data)
        return np.array(self.data.qpos)

    def rise(self, qpos: Array, ground: Ground) -> float:
        """Return how far a robot has to rise so that nothing of it is in the ground, metres; 0 if nothing is."""
        risen = self.put(qpos, ground, lower=False) - qpos
        return max([root.upwards * float(risen[root.at]) - CLEARANCE for root in self.roots], default=0.0)

    def _bounds(self, geoms: Ints, ground: Ground, world: int | None) -> tuple[float, float]:
        """Return how far a body has to rise to be surely in the ground, if the model has it, and surely above it."""
        mujoco.mj_kinematics(self.model, self.data)
        low, high = geom_bounds(self.model, self.data, geoms)
        lowest, half = np.column_stack([(low + high)[:, :2] / 2, low[:, 2]]), (high - low)[:, :2] / 2
        if world is None:
            rise = float(ground.lift(lowest, half))
        else:
            rise = float(ground.lift(lowest[None], half[None], [world])[0])
        return min(float(ground.position[2] - low[:, 2].min()) - _BELOW, rise), rise

    def _is_inside(self, root: Root, start: float, rise: float) -> bool:
        """Return whether a geom of a robot is in one that cannot move, if it rises so far."""
        self.data.qpos[root.at] = start + root.upwards * rise
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)
        mujoco.mj_collision(self.model, self.data)
        pairs = self.data.contact.geom
        own, static = np.isin(pairs, root.geoms), self._static[pairs]
        return bool((self.data.contact.dist[(own & static[:, ::-1]).any(axis=1)] < 0).any())

    def drop(self, seconds: float) -> bool:
        """Simulate until all rest; give whether they do."""
        still, steps = 0, max(round(_CHECK / self.model.opt.timestep), 1)
        for _ in range(round(seconds / _CHECK)):
            mujoco.mj_step(self.model, self.data, steps)
            still = still + 1 if np.abs(self.data.qvel).max(initial=0.0) < _STILL else 0
            if still == 2:
                break
        return still == 2
