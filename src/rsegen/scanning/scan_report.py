"""A scan for programs: what was found of each block, so that a hole differs from a block that was not seen."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from rsegen.field.stepfield import Array, Ints, Mask
from rsegen.params.sorts import Json
from rsegen.scanning.evidence import bits_saved, stepped_lines
from rsegen.scanning.scan import SURE, Scan
from rsegen.scene.scene import north_up

_LEAST = 0.0001
"""Confidence that is written at least of a block that was seen: 0 is for those that were not."""


def confidence_csv(scan: Scan) -> bytes:
    """Return the confidence of each block in the layout of levels.csv: 0 where it was not seen."""
    head = "confidence of the levels, 0 to 1; 0: not seen, so the level in levels.csv is made up"
    return b"".join(north_up(scan.of_blocks(_confidence(scan)), head))


def scan_content(scan: Scan, points: int, left_out: int = 0) -> dict[str, Any]:
    """Return what was found in a cloud as JSON values, lengths in metres; points: of the field; left_out: all others.

    levels, confidence, residuals_m: of the blocks, [x][y], frames left out, null where a block was not seen; cells that
    are named have x and y of their block as recipes count them, none for a frame, and cell, in which frames count.
    """
    # A block that was not seen is null in levels and 0 in confidence, which no block that was seen has.
    seen, residuals = scan.seen, np.abs(scan.errors[scan.seen])
    unsure = seen & (scan.confidence < SURE)
    return {
        "points": points,
        "points_left_out": left_out,
        "blocks": list(scan.blocks.shape),
        "cells": scan.seen.size,
        "cells_seen": int(seen.sum()),
        "block_width_m": _metres(scan.block_width),
        "measured_block_width_m": _metres(scan.measured_width),
        "confidence_of_field": round(stepped_lines(scan).confidence, 4),
        "bits_of_grid": round(bits_saved(scan), 1),
        "unit_m": _metres(scan.unit),
        "measured_unit_m": _metres(scan.measured_unit),
        "boundary": scan.boundary,
        "frame_height_m": None if scan.boundary == "none" else _metres(scan.frame_height),
        "base_m": _metres(scan.base),
        "noise_m": _metres(scan.noise),
        "residual_mean_m": _metres(residuals.mean()) if residuals.size else None,
        "residual_most_m": _metres(residuals.max()) if residuals.size else None,
        "not_seen": _named(scan, ~seen),
        "unsure": [
            named | {"confidence": float(share)}
            for named, share in zip(_named(scan, unsure), _confidence(scan)[unsure], strict=True)
        ],
        "level_0_is_assumed": not scan.has_floor,
        "open_sides": list(scan.open_sides),
        "sides_of_few_raised_cells": list(scan.sparse_edges),
        "raised_cells_beside": scan.beside,
        "rotation": np.round(scan.rotation, 9).tolist(),
        "translation_m": np.round(scan.translation, 6).tolist(),
        "levels": _lists(scan, scan.levels, seen),
        "confidence": _lists(scan, _confidence(scan), np.ones_like(seen)),
        "residuals_m": _lists(scan, np.round(scan.errors, 6), seen),
    }


def named_cells(scan: Scan, chosen: Mask) -> Iterator[tuple[int, int]]:
    """Yield the chosen cells that are no frames as recipes count them, x and y of their blocks."""
    numbers_x, numbers_y = (scan.field.numbered(axis) for axis in (0, 1))
    for x, y in np.argwhere(chosen & ~scan.frame).tolist():
        yield int(numbers_x[x]), int(numbers_y[y])


def _named(scan: Scan, chosen: Mask) -> list[dict[str, Any]]:
    numbers = iter(named_cells(scan, chosen))
    return [
        dict(zip("xy", (None, None) if scan.frame[x, y] else next(numbers), strict=True)) | {"cell": [x, y]}
        for x, y in np.argwhere(chosen).tolist()
    ]


def _confidence(scan: Scan) -> Array:
    """Return the confidence of each cell, 0 only where it was not seen."""
    return np.where(scan.seen, np.round(scan.confidence.clip(_LEAST, 1), 4), 0.0)


def _lists(scan: Scan, values: Array | Ints, known: Mask) -> list[Sequence[Json]]:
    """Return values of the blocks as lists [x][y], null where they are not known."""
    rows = zip(scan.of_blocks(values).tolist(), scan.of_blocks(known).tolist(), strict=True)
    return [[value if is_known else None for value, is_known in zip(*row, strict=True)] for row in rows]


def _metres(length: float) -> float:
    return round(float(length), 6)
