"""Rate a gait of mjlab's Unitree Go1, a robot on four legs, on fields of blocks 25 cm wide with rising steps."""

from importlib.util import find_spec
from pathlib import Path

import mujoco
import numpy as np

import rsegen
from rsegen.learning.mujoco import add_map

BLOCKS = rsegen.Recipe(
    name="go1-blocks", chunk_size=8, block_width_cm=25, boundary="none", obstacles=[rsegen.NormalRandom(levels=4)]
)
BEFORE, SECONDS = 0.6, 20.0  # metres from a start to the field; the time of a trial, of which flat ground takes a third

# The motors as mjlab has them (go1_constants.py): the gear and the largest torque [N m] of each joint of a leg.
MOTORS = {"hip": (6, 23.7), "thigh": (6, 23.7), "calf": (9, 35.55)}
ROTOR, NATURAL, DAMPING = 0.000111842, 20 * np.pi, 2.0  # kg m2, before the gear; rad/s; ratio
STANDING, HEIGHT = (0.0, 0.9, -1.8), 0.3  # radians; metres from the ground to the trunk at a start

# A trot of eight numbers. A search on flat ground found them, in 24 generations of 24 random gaits about the mean of
# the best, by speed up to 0.45 m/s, feet that rise up to 7 cm, little tilt and a straight way.
# It had three more numbers, which are left out, and these are rounded.
RATE, SWING, LIFT, LAG = 2.7, 0.72, 1.1, 2.55  # hertz; radians: of thigh and calf, and of the calf behind the thigh
THIGH, CALF = 0.035, -0.2  # radians, in addition to those of a robot that stands
TURN, ROLL = 1.2, 0.25  # how much longer and shorter the steps of the two sides are, and the angle of hips, per radian
PHASES, SIDES = np.array([0, np.pi, np.pi, 0]), np.array([-1, 1, -1, 1])  # of the legs: radians; 1 on the left
LEGS = ("FR", "FL", "RR", "RL")


def robot() -> mujoco.MjSpec:
    """Return mjlab's Go1 with its motors, on level ground."""
    package = find_spec("mjlab")  # its file of the robot is all that is needed, so it is not imported
    if package is None or package.origin is None:
        raise SystemExit("mjlab is not installed: pip install --no-deps mjlab")
    folder = Path(package.origin).parent / "asset_zoo" / "robots" / "unitree_go1" / "xmls"
    spec = mujoco.MjSpec.from_file(str(folder / "go1.xml"))
    spec.option.timestep, spec.option.integrator = 0.005, mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone, spec.option.impratio = mujoco.mjtCone.mjCONE_ELLIPTIC, 10
    for leg in LEGS:
        for name, (gear, torque) in MOTORS.items():
            joint = spec.joint(f"{leg}_{name}_joint")
            joint.armature = inertia = ROTOR * gear**2
            motor = spec.add_actuator(name=joint.name, target=joint.name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
            motor.set_to_position(kp=inertia * NATURAL**2, kv=2 * DAMPING * inertia * NATURAL)
            motor.forcelimited, motor.forcerange = True, (-torque, torque)
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=(0, 0, 1))
    return spec


def gait(seconds: float, y: float, turned: np.ndarray) -> np.ndarray:
    """Return the angles (12,) that the joints should have; turned: the trunk's rotation matrix (9,), by rows."""
    heading, roll = np.arctan2(turned[3], turned[0]), np.arctan2(turned[7], turned[8])
    to_the_right = np.clip(TURN * (heading + np.clip(y, -0.4, 0.4)), -0.5, 0.5)
    turns, grown = 2 * np.pi * RATE * seconds + PHASES, min(2 * seconds, 1)
    hip, thigh, calf = STANDING
    hips = np.full(4, hip + ROLL * roll)
    thighs = thigh + THIGH + grown * SWING * (1 + SIDES * to_the_right) * np.sin(turns)
    calves = calf + CALF - grown * LIFT * np.maximum(np.sin(turns - LAG), 0)
    return np.stack([hips, thighs, calves], axis=1).ravel()


def go1(field: rsegen.StepField, seed: int) -> bool:
    """Let the robot walk to a field and over it, and say whether it gets to the other side."""
    spec = robot()
    add_map(spec, rsegen.compose(rsegen.recipe_of(field)))
    model = spec.compile()
    state, half_x, half_y = mujoco.MjData(model), field.extent[0] / 2, field.extent[1] / 2
    y, heading = np.random.default_rng(seed).uniform(-0.1, 0.1, 2)  # a start that differs from trial to trial
    state.qpos[:7] = -half_x - BEFORE, y, HEIGHT, np.cos(heading / 2), 0, 0, np.sin(heading / 2)
    state.qpos[7:] = np.tile(STANDING, 4)
    mujoco.mj_forward(model, state)
    while state.time < SECONDS:
        x, y, turned = state.qpos[0], state.qpos[1], state.body("trunk").xmat
        if abs(y) > half_y or turned[8] < 0.5:  # it left the lane, or fell
            return False
        if x > half_x + 0.3:
            return True
        state.ctrl[:] = gait(state.time, y, turned)
        mujoco.mj_step(model, state, 2)
    return False


if __name__ == "__main__":
    print(*rsegen.rate(go1, BLOCKS, seed=7, trials=40).report(), sep="\n")
