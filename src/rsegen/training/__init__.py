"""Robots of rsegen's, and of files, that learn to cross fields: a task, and worlds of it for those who train.

crossing     Crossing: what such a robot sees, what it does, what it gets for that
gymnasium    CrossingEnv: one world of MuJoCo
worlds       CrossingWorlds: thousands of mujoco_warp, for trainers of torch
"""

from rsegen.params.capabilities import Capability

CAPABILITY = Capability(
    summary="robots that learn to cross fields",
    needs=("driving", "learning", "mujoco", "robots", "simulators", "standing"),
    manual="learned",
)
