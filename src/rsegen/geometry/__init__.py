"""From a step field to geometry: the merged surface of a map."""

from rsegen.geometry.mesh import NORMALS, Mesh
from rsegen.geometry.surface import surface

__all__ = ["NORMALS", "Mesh", "surface"]
