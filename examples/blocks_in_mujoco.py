"""Drop balls onto the blocks of a map in MuJoCo, and see at which heights they come to rest."""

import mujoco

import rsegen
from rsegen.learning.mujoco import add_map

scene = rsegen.compose(rsegen.Recipe(seed=7, obstacles=[rsegen.Peak(levels=4, first=(2, 2), last=(7, 7))]))
spec = mujoco.MjSpec()
spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=(2, 2, 0.1))
# Balls would roll on for ever on blocks that have friction against sliding alone.
add_map(spec, scene, contact=rsegen.Contact(condim=6, torsional=0.01, rolling=0.01))
for x, y in ((0.05, 0.05), (0.45, 0.45)):
    ball = spec.worldbody.add_body(pos=(x, y, 1))
    ball.add_freejoint()
    ball.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=(0.02, 0, 0))
model = spec.compile()
state = mujoco.MjData(model)
while state.time < 2:
    mujoco.mj_step(model, state)
print("heights of the balls [m]:", state.qpos.reshape(-1, 7)[:, 2].round(3).tolist())
