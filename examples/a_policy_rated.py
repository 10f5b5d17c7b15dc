"""Rate a policy of your own: a robot in MuJoCo that steers by a small linear policy, on fields with rising steps."""

import mujoco
import numpy as np

import rsegen

ROBOT = """<mujoco><option timestep="0.004" cone="elliptic" integrator="implicitfast"/><worldbody>
  <geom type="plane" size="3 3 0.1"/>
  <body name="robot" pos="-0.75 0 0.08"><freejoint/><geom type="box" size="0.12 0.08 0.03" mass="2"/>{wheels}</body>
</worldbody><actuator>{motors}</actuator></mujoco>"""
WHEEL = """<body pos="{x} {y} -0.02"><joint name="{name}" axis="0 1 0"/>
  <geom type="sphere" size="0.06" mass="0.3"/></body>"""
PLACES = {"left_0": (0.1, 0.11), "left_1": (-0.1, 0.11), "right_0": (0.1, -0.11), "right_1": (-0.1, -0.11)}
WEIGHTS = np.array([[1.8, 1.2], [-1.8, -1.2]])  # of heading [rad] and y [m]: rad/s for the wheels left and right


def policy(field: rsegen.StepField, seed: int) -> bool:
    """Drive the robot over a field for ten seconds at most, and say whether it gets to the other side."""
    wheels = "".join(WHEEL.format(name=name, x=x, y=y) for name, (x, y) in PLACES.items())
    motors = "".join(f'<velocity joint="{name}" kv="1" forcerange="-2 2"/>' for name in PLACES)
    spec = mujoco.MjSpec.from_string(ROBOT.format(wheels=wheels, motors=motors))
    half, middles = field.block_width / 2, field.middles()
    for (i, j), height in np.ndenumerate(field.heights):
        if height:
            place, size = (middles[0][i], middles[1][j], height / 2), (half, half, height / 2)
            spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, pos=place, size=size)
    model = spec.compile()
    state = mujoco.MjData(model)
    state.qpos[1] = np.random.default_rng(seed).uniform(-0.1, 0.1)  # a start that differs from trial to trial
    mujoco.mj_forward(model, state)
    while state.time < 10:
        turned = state.body("robot").xmat
        left, right = 5 + WEIGHTS @ (np.arctan2(turned[3], turned[0]), state.qpos[1])
        state.ctrl[:] = left, left, right, right
        mujoco.mj_step(model, state, 10)
        if state.qpos[0] > field.extent[0] / 2 + 0.2:
            return True
    return False


if __name__ == "__main__":
    rating = rsegen.rate(policy, seed=7, trials=40)
    print(*rating.report(), sep="\n")
