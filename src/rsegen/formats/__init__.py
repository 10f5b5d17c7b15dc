"""Maps in the formats of other programs; every module with a class under `@register` is a format."""

from rsegen.params.capabilities import Capability, Command
from rsegen.params.extras import Extra

MAT = Extra("mat", "scipy", "MATLAB files of the formats arrays and posture")
MESH = Extra("mesh", "trimesh", "the formats stl, ply and glb")
USD = Extra("usd", "pxr", "the format usd")

CAPABILITY = Capability(
    summary="maps for other programs: meshes, arrays, images, occupancy grids",
    commands=(
        Command(
            "export",
            "for other programs",
            "write maps for other programs: meshes, arrays, images, occupancy grids",
            "rsegen.formats.commands",
            "export_maps",
            title="Export maps",
            also=("convert", "save", "mesh", "formats"),
        ),
    ),
    public={
        "rsegen.formats.base": ("FORMATS",),
        "rsegen.formats.commands": ("export", "export_maps"),
        "rsegen.formats.exports": ("Exported", "ExportedMap"),
    },
    extras=(MAT, MESH, USD),
    sidecars=("rsegen.formats.sidecar:FormatFiles",),
    words={"formats": "rsegen.formats.base:FORMATS"},
    manual="formats",
)
