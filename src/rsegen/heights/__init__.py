"""Heights as maps: from tables, arrays, images and occupancy grids; every module is an importer for some file names.

file --Importer.read--> Heights --imported--> Recipe of one matrix
"""

from rsegen.params.capabilities import Capability, Command
from rsegen.params.extras import Extra

BAG = Extra("bag", "rosbags", "rsegen import: grid maps in bags of ROS (mcap, db3, bag)")

CAPABILITY = Capability(
    summary="maps of measured heights, images and occupancy grids",
    needs=("pictures",),
    commands=(
        Command(
            "import",
            "make worlds",
            "write a world from measured heights, an image or an occupancy grid of ROS",
            "rsegen.heights.commands",
            title="World from measured heights",
            also=("read", "heightmap", "from"),
        ),
    ),
    public={"rsegen.heights.base": ("imported",)},
    extras=(BAG,),
    reads="rsegen.heights.base:reads",
    manual="heights",
)
