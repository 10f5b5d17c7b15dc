"""Build a step field, look at its levels as an array, and measure how rough it is."""

import rsegen

recipe = rsegen.Recipe(
    seed=7,
    obstacles=[
        rsegen.Random(levels=3),
        rsegen.Peak(levels=5, softness=50, first=(2, 2), last=(7, 7)),
    ],
)
field = rsegen.build(recipe)  # field.levels: int16 (n_x, n_y), in units of field.unit metres
print(field.blocks[::, ::-1].T)  # north up, without the frame

found = rsegen.metrics(field, rsegen.StepLimits(climb_cm=10, drop_cm=20))
print(f"rms step {found.steps.rms:.3f} m; {found.steps.share_above(0.1):.0%} of the steps are higher than 10 cm")
print(f"a robot that climbs 10 cm reaches {found.reach.coverage:.0%} of the cells")

with open("field.png", "wb") as file:
    file.write(rsegen.preview(rsegen.compose(recipe)))
