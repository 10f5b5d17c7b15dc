"""MuJoCo, a simulator in the box: a library of one wheel, in which robots drive without a Gazebo."""

from rsegen.params.capabilities import Capability
from rsegen.params.extras import Extra

WARP = Extra(
    "warp", "mujoco_warp", "rsegen drives --simulator mujoco-warp: many maps at once, on a GPU if there is one"
)

CAPABILITY = Capability(
    summary="MuJoCo, a simulator in the box",
    needs=("pictures", "robots", "simulators"),
    offers={
        "rsegen.embedded_simulators": {"mujoco": "rsegen.mujoco.simulator"},
        "rsegen.batch_simulators": {"mujoco-warp": "rsegen.mujoco.batch_simulator"},
    },
    extras=(WARP,),
    manual="mujoco",
)
