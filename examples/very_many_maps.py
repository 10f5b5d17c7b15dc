"""Ten thousand maps in one array, and the same in a few files with their metrics, for training."""

import numpy as np

import rsegen

rubble = rsegen.Recipe(name="rubble", seed=7, maps=10_000, boundary="none", obstacles=[rsegen.Random(levels=6)])
levels = rsegen.build_many(rubble, range(10_000))  # int16 (maps, n_x, n_y)
heights = levels * rubble.unit_cm / 100
rms = np.sqrt((np.diff(heights, axis=1) ** 2).mean(axis=(1, 2)))
print(f"{levels.shape}: rms steps along x of {rms.min():.3f} to {rms.max():.3f} m")

stored = rsegen.make_dataset(rubble, "rubble")  # goes on with resume=True if it was stopped
print(f"{len(stored)} maps in rubble/; number 1234 again: {np.array_equal(stored.levels[1234], levels[1234])}")
