"""Robots that drive over maps; each of rsegen's own is one file of this folder, which is imported automatically.

Those of users are read from SDF, URDF, Xacro and MJCF files.
"""

from rsegen.params.capabilities import Capability, Command
from rsegen.params.extras import Extra

MESH = Extra("mesh", "trimesh", "other robots' meshes")
XACRO = Extra("xacro", "xacro", "robots in Xacro files, as ROS has them")

CAPABILITY = Capability(
    summary="rsegen's robots, and those of SDF, URDF, Xacro and MJCF files",
    needs=("pictures", "standing"),
    commands=(
        Command(
            "spots",
            "measure",
            "find spots for a start or a goal of a robot",
            "rsegen.robots.commands",
            "spots",
            title="Spots for a robot",
        ),
        Command(
            "robot",
            "drive a robot",
            "list the robots, or print the figures of one",
            "rsegen.robots.robot_command",
            title="The robots, and their figures",
            also=("robots", "urdf", "kinds"),
        ),
    ),
    public={
        "rsegen.robots.commands": ("spots",),
        "rsegen.robots.lookup": ("poses", "robot_of", "stable_poses"),
        "rsegen.robots.robot_picture": ("robot_picture",),
    },
    extras=(MESH, XACRO),
    reads="rsegen.robots.lookup:reads",
    crossers="rsegen.robots.lookup:crosser",
    words={"robot": "rsegen.robots.base:ROBOTS", "crossable_by": "rsegen.robots.base:ROBOTS"},
    calls=("rsegen.robots.page",),
    manual="robots",
)
