"""Gazebo worlds and models of a map as bytes; nothing is written to disk here."""

from rsegen.gazebo.bundle import MESH_TYPES, Bundle, export

__all__ = ["MESH_TYPES", "Bundle", "export"]
