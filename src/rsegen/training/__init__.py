"""Robots of rsegen, and of files, that learn to cross fields: a task, and worlds of it for trainers.

crossing     Crossing: observations, actions and rewards
gymnasium    CrossingEnv: one world of MuJoCo
worlds       CrossingWorlds: thousands of worlds of mujoco_warp, for trainers of torch
"""

from rsegen.params.capabilities import Capability

CAPABILITY = Capability(
    summary="robots that learn to cross fields",
    needs=("driving", "learning", "mujoco", "robots", "simulators", "standing"),
    manual="learned",
)
