"""Rate a policy for Gymnasium's Ant, here a small gait, on fields of blocks 40 cm wide with rising steps."""

from pathlib import Path
from tempfile import TemporaryDirectory

import gymnasium
import mujoco
import numpy as np

import rsegen
from rsegen.learning.mujoco import add_map

BLOCKS = rsegen.Recipe(
    name="ant-blocks", chunk_size=8, block_width_cm=40, boundary="none", obstacles=[rsegen.NormalRandom(levels=4)]
)
ANT = Path(gymnasium.__file__).parent / "envs" / "mujoco" / "assets" / "ant.xml"
MIDDLE, SECONDS = 2.6, 12.0  # x of the middle of the field, metres before the robot; the time of a trial

# A gait of ten numbers, found by random search on flat ground: each joint follows a sine about the middle of its range.
RATE, HIP, ANKLE, LAG = 2.386, 0.197, 0.371, -1.493  # hertz; radians: amplitudes, and of the ankle behind the hip
PHASES = np.array([1.853, -1.431, -0.773, 0.371])  # radians, of the legs in the order of the actions: 4, 1, 2, 3
REST = np.array([0.872, 0.872, -0.872, -0.872])  # radians, of their ankles
STIFFNESS, DAMPING, TURN = 5.484, 0.223, -0.747


def gait(observation: np.ndarray, seconds: float) -> np.ndarray:
    """Return the action of a time; observation: as Ant-v5 gives it, z, the quaternion and 8 angles, then 14 speeds."""
    w, x, y, z = observation[1:5]
    heading = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    turns = 2 * np.pi * RATE * seconds + PHASES
    hips = HIP * np.sin(turns) + np.clip(TURN * heading, -0.5, 0.5)
    ankles = REST + ANKLE * np.sign(REST) * np.sin(turns + LAG)
    of_actions = np.roll(np.arange(8), 2)  # actions begin with leg 4, angles with leg 1
    wanted = np.stack([hips, ankles], axis=1).ravel()
    angles, speeds = observation[5:13][of_actions], observation[19:27][of_actions]
    return np.clip(STIFFNESS * (wanted - angles) - DAMPING * speeds, -1, 1)


def ant(field: rsegen.StepField, seed: int) -> bool:
    """Let the ant walk to a field and over it, and say whether it gets to the other side."""
    spec = mujoco.MjSpec.from_file(str(ANT))
    add_map(spec, rsegen.compose(rsegen.recipe_of(field)), pos=(MIDDLE, 0, 0))
    spec.compile()
    with TemporaryDirectory() as folder:
        file = Path(folder, "ant.xml")
        file.write_text(spec.to_xml())
        env = gymnasium.make("Ant-v5", xml_file=str(file), frame_skip=1, terminate_when_unhealthy=False)
    observation, _ = env.reset(seed=seed)
    finish, step = MIDDLE + field.extent[0] / 2 + 0.3, env.unwrapped.dt
    for count in range(int(SECONDS / step)):
        observation, _, _, _, info = env.step(gait(observation, count * step))
        if info["x_position"] > finish:
            return True
    return False


if __name__ == "__main__":
    print(*rsegen.rate(ant, BLOCKS, seed=7, trials=24).report(), sep="\n")
