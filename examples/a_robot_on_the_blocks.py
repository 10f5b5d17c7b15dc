"""Put a robot down at many places of a field: how far it tilts, where it stands, and where a drive could start."""

import numpy as np

import rsegen

recipe = rsegen.Recipe(seed=7, unit_cm=3, chunk_size=20, boundary="none", obstacles=[rsegen.Random(levels=4)])
field = rsegen.build(recipe)
x, y = np.meshgrid(np.linspace(-0.6, 0.6, 25), np.linspace(-0.6, 0.6, 25))
found = rsegen.poses(field, "jackal", x.ravel(), y.ravel(), 0.0)
print(f"stands at {found.stands.mean():.0%} of the places, tilted by {np.degrees(np.median(found.tilt)):.1f} degrees")

for spot in rsegen.spots(recipe, robot="jackal", count=2, max_tilt=10):
    print(f"a start at x = {spot.x:.2f}, y = {spot.y:.2f} m, heading {np.degrees(spot.yaw):.0f} degrees")
