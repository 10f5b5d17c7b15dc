"""From a scene to the files of a map, as bytes: nothing here touches a disk."""

from rsegen.exporters.gazebo.bundle import MESH_TYPES, Bundle, export

__all__ = ["MESH_TYPES", "Bundle", "export"]
