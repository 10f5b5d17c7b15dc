"""Step fields for those who train robots: what plugs into their frameworks, a file for each, and what all of them need.

    ground       Ground: heights, friction, scans and places to start, in numpy, torch or jax
    curriculum   next_rows: which row of a terrain a robot goes to next
    scans        ScanSensor: scans with noise, steps, lost rays, a delay, and a map that drifts
    isaaclab     StepFieldTerrainCfg, a sub-terrain of Isaac Lab
    mjlab        StepFieldTerrainCfg, a sub-terrain of mjlab
    legged_gym   StepFieldTerrain, in place of the terrain of legged_gym and its forks
    mujoco       add_map and add_terrain to an MjSpec; BlockGrid, whose map changes without compiling anew
    seating      seat: any MuJoCo model put on the ground, or dropped until it rests
    mujoco_warp  BlocksOfWorlds: one map per world
    playground   Floor, a field for each world of MuJoCo Playground
    newton       add_map to a ModelBuilder; BlockGrid
    genesis      terrain_morph, a height-field morph
    sapien       add_map to an ActorBuilder of SAPIEN, and so of ManiSkill
    gymnasium    NewFieldAtReset, a wrapper around an environment
    torch        build_many, the blocks of many maps in a tensor on any device

Only the file of a framework imports it, so none of them is needed for the others.
"""

from rsegen.params.capabilities import Capability, Command
from rsegen.params.extras import Extra

MESH = Extra("mesh", "trimesh", "terrain for Isaac Lab")

CAPABILITY = Capability(
    summary="step fields where robots learn",
    needs=("datasets", "measuring"),
    commands=(
        Command(
            "terrain",
            "for learning",
            "write one field of many maps, in rows of rising difficulty, for learning",
            "rsegen.learning.commands",
            title="Terrain of many maps",
            also=("train", "isaac", "gym", "curriculum"),
        ),
    ),
    public={
        "rsegen.learning.curriculum": ("next_rows",),
        "rsegen.learning.ground": ("Ground",),
        "rsegen.learning.patterns": ("scan_points",),
        "rsegen.learning.scans": ("ScanSensor",),
        "rsegen.learning.terrain": ("Terrain",),
    },
    extras=(MESH,),
    manual="learning",
)
