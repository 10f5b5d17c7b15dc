"""Search for the step field in a point cloud: ground plane, grid of blocks, a level for every cell with its confidence.

points --level_frame--> heights above the ground --find_unit, find_grid, refined--> cells --read_cells--> levels
"""

from __future__ import annotations

from rsegen.scanning.finding import find_field
from rsegen.scanning.scan import SURE, Scan, ScanSettings

__all__ = ["SURE", "Scan", "ScanSettings", "find_field"]
