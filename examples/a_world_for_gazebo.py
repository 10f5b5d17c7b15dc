"""Write two maps as worlds for Gazebo: `gz sim worlds/course_0000/course_0000.world`, or `rsegen open worlds`."""

import rsegen

course = rsegen.Recipe(
    name="course",
    seed=7,
    maps=2,
    chunk_size=10,
    chunks=(2, 1),  # two pallets along x
    friction=0.8,
    obstacles=[
        rsegen.NormalRandom(levels=4),
        rsegen.HorizontalBarrier(levels=3, first=(4, 0), last=(4, 9)),
    ],
)
for made in rsegen.generate(course, "worlds").maps:
    print(made.folder)
