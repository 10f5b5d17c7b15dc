"""Even places for a robot on a field: its wheels or tracks stand level, and nothing else touches a block.

Footprint --search--> Candidates --sample--> Spots. All geometry is exact: a turned rectangle overlaps a cell or not.
"""

from __future__ import annotations

from rsegen.footprints.footprint import Footprint, Rectangle, Underside
from rsegen.footprints.sampling import Spot, even_spots
from rsegen.footprints.search import fits

__all__ = ["Footprint", "Rectangle", "Spot", "Underside", "even_spots", "fits"]
