"""Arrays and metadata as the bytes of NPY, MAT and JSON files, without dates."""

from __future__ import annotations

import json
from collections.abc import Mapping
from io import BytesIO

from rsegen import __version__
from rsegen.params.sorts import Json
from rsegen.scene.scene import Scene

AXES = "axis 0 along +x, axis 1 along +y, cell (0, 0) in the corner of smallest x and y; z up, the ground is z = 0"

_MAT_HEAD = b"MATLAB 5.0 MAT-file, written by rsegen".ljust(116)
"""The header text of 116 bytes, which MATLAB ignores; scipy writes the date into it."""


def mat(variables: Mapping[str, object]) -> bytes:
    """Return variables as the bytes of a MAT file (version 5); 1D arrays become columns."""
    from scipy.io import savemat

    buffer = BytesIO()
    savemat(buffer, dict(variables), oned_as="column")
    return _MAT_HEAD + buffer.getvalue()[len(_MAT_HEAD) :]


def as_json(content: Mapping[str, Json]) -> bytes:
    """Return a dict as the bytes of a JSON file."""
    return (json.dumps(content, indent=2) + "\n").encode()


def metadata(scene: Scene) -> dict[str, Json]:
    """Return the metadata of a map for JSON: name, seed, generator, lengths in metres, axes and origin."""
    field = scene.field
    return {
        "name": scene.name,
        "seed": scene.recipe.seed,
        "generator": f"rsegen {__version__}",
        "unit_m": field.unit,
        "block_width_m": field.block_width,
        "frame_height_m": field.frame_height,
        "cells": list(field.shape),
        "size_m": list(field.extent),
        "axes": AXES,
        "origin": "the middle of the map",
    }
