"""MuJoCo, a simulator in the box: a library of one wheel, in which robots drive without a Gazebo."""

from rsegen.params.capabilities import Capability

CAPABILITY = Capability(
    summary="MuJoCo, a simulator in the box",
    needs=("pictures", "robots", "simulators"),
    offers={"rsegen.embedded_simulators": {"mujoco": "rsegen.mujoco.simulator"}},
    manual="mujoco",
)
