"""Find the step field in a point cloud, and compare it with the recipe by which it was built."""

import numpy as np

import rsegen

wanted = rsegen.Recipe(name="pallet", seed=7, boundary="none", obstacles=[rsegen.Random(levels=4)])
field = rsegen.build(wanted)

# Points on the blocks and the floor around them, with noise of 5 mm; one block was forgotten.
rng = np.random.default_rng(1)
x, y = rng.uniform(-0.8, 0.8, (2, 50_000))
i, j = (np.floor(at / field.block_width).astype(int) + 5 for at in (x, y))
inside = (i >= 0) & (i < 10) & (j >= 0) & (j < 10)
z = np.where(inside, field.heights[np.clip(i, 0, 9), np.clip(j, 0, 9)], 0.0)
forgotten = np.argwhere(field.levels == field.levels.max())[0]
z[inside & (i == forgotten[0]) & (j == forgotten[1])] = 0
np.savetxt("pallet.xyz", np.column_stack([x, y, z + rng.normal(0, 0.005, x.shape)]), fmt="%.4f")

found = rsegen.compare("pallet.xyz", wanted)
print(f"wrong: {np.argwhere(found.comparison.wrong).tolist()}; forgotten: {forgotten.tolist()}")
with open("changes.png", "wb") as file:
    file.write(found.picture())
