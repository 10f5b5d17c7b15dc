"""The extras of rsegen: what each is for, and the libraries that `pip install 'rsegen[NAME]'` brings."""

from __future__ import annotations

from importlib.util import find_spec
from typing import NamedTuple


class Extra(NamedTuple):
    """Libraries that a part of rsegen needs: pip installs rsegen[name], which brings the module, and perhaps more.

    use: what is not possible without it, in words.
    """

    name: str
    module: str
    use: str = ""
    more: tuple[str, ...] = ()

    @property
    def is_missing(self) -> bool:
        """Return whether a library of it is not installed for this Python."""
        return bool(self.missing_modules)

    @property
    def missing_modules(self) -> tuple[str, ...]:
        """Modules of it that are not installed for this Python."""
        return tuple(module for module in (self.module, *self.more) if find_spec(module) is None)


CLUSTER = Extra("cluster", "distributed", "--scheduler: many maps made on a Dask cluster")
DATASET = Extra("dataset", "pyarrow", "rsegen dataset --metrics parquet: metrics of a data set as Parquet")
MAT = Extra("mat", "scipy", "MATLAB files of the formats arrays and posture")
MESH = Extra("mesh", "trimesh", "the formats stl, ply and glb; terrain for Isaac Lab; other robots' meshes")
SCAN = Extra(
    "scan", "trimesh", "rsegen scan, compare: clouds and meshes in PLY, OBJ, STL, GLB and PCD files", ("pypcd4",)
)
USD = Extra("usd", "pxr", "the format usd")
XACRO = Extra("xacro", "xacro", "robots in Xacro files, as ROS has them")

EXTRAS: tuple[Extra, ...] = (CLUSTER, DATASET, MAT, MESH, SCAN, USD, XACRO)
"""Every extra of rsegen, as in pyproject.toml, but for `all`."""
