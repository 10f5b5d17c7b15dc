"""A step field found in a point cloud: ground plane, grid of blocks, a level for every cell with its confidence.

points --level_frame--> heights above the ground --find_unit, find_grid, refined--> cells --read_cells--> levels
"""

from rsegen.params.capabilities import Capability, Command
from rsegen.params.extras import Extra

SCAN = Extra(
    "scan",
    "trimesh",
    "rsegen scan, compare: clouds and meshes in PLY, OBJ, STL, GLB, PCD, LAS and LAZ files",
    ("pypcd4", "laspy", "lazrs"),
)

E57 = Extra("e57", "pye57", "rsegen scan, compare: laser scans in E57 files")

BAG = Extra("bag", "rosbags", "rsegen scan, compare: PointCloud2 in bags of ROS (mcap, db3, bag)")

CAPABILITY = Capability(
    summary="fields found in point clouds and depth images",
    needs=("heights", "pictures"),
    commands=(
        Command(
            "scan",
            "make worlds",
            "write the world of a real field from a point cloud or a depth image of it",
            "rsegen.scanning.commands",
            title="World from a scan",
            also=("pointcloud", "cloud", "reconstruct"),
        ),
        Command(
            "compare",
            "measure",
            "show which blocks of a scan, or of a map, differ from those of a map",
            "rsegen.scanning.commands",
            title="Compare with a scan",
            also=("diff",),
        ),
    ),
    public={
        "rsegen.scanning.scan_options": ("ScanOptions",),
        "rsegen.scanning.scans": ("ComparedMap", "ScannedMap", "compare", "scan"),
    },
    extras=(SCAN, E57, BAG),
    reads="rsegen.scanning.clouds:reads",
    manual="scan",
)
