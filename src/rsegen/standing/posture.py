"""The format `posture`: traversability raster and graph data, for planning over robot postures.

It has what Magid and Tsubouchi's work on static balance in Random Step Environments (2010 on) needs: a fine raster
without smoothed edges (5 x 5 or 10 x 10 cells per block), edges, start and goal, tags. The files follow no standard.

Edges are the sides of cells at which the height changes. Tags name the obstacles of the recipe in whose cells a block
is, and the peaks and pits of the field. A plateau is a connected area of blocks of one height; frames and the ground
around the map are no plateaus, but can be neighbours of one. Neighbours share a side.

    peak   a plateau that is higher than each of its neighbours by more than a limit
    pit    a plateau that is lower than each of its neighbours by more than a limit

Plateaus are connected components (field/graphs.py); the least rise to any neighbour decides. Linear in the
cells.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Annotated, Any, ClassVar

import numpy as np

from rsegen.field.graphs import component_labels, neighbours
from rsegen.field.stepfield import Array, Ints, Mask, StepField
from rsegen.formats.base import Format, Step, register
from rsegen.formats.encoded import as_json, mat, metadata
from rsegen.npy_files import npy_bytes
from rsegen.obstacles.base import Shaped
from rsegen.params.numbers import decimal
from rsegen.params.sorts import NANOMETRE_DIGITS, Float, Integer, Json
from rsegen.recipe.building import placed
from rsegen.recipe.codec import encode
from rsegen.scene.scene import Scene, north_up

_BLOCK, _FRAME, _GROUND = range(3)
"""Sorts of cells, for plateaus."""


def _obstacle_cells(scene: Scene) -> Iterator[tuple[dict[str, Any], Mask]]:
    """Yield every barrier and peak of the recipe as a dict for JSON, and its cells (n_x, n_y).

    Its ends count block cells without frames, as a recipe does. Its cells are those in which its own level is 1 or
    more, whatever later obstacles do there. A matrix and random kinds have none.
    """
    field, recipe = scene.field, scene.recipe
    for index, obstacle in recipe.enabled_obstacles:
        if isinstance(obstacle, Shaped):
            first, last, patch = placed(recipe, obstacle, scene.index)
            blocks = np.zeros(recipe.grid.shape, dtype=bool)
            blocks[patch.window] = patch.footprint
            cells = np.zeros(field.shape, dtype=bool)
            cells[np.ix_(field.inside(0), field.inside(1))] = blocks
            named = {"number": index, "kind": obstacle.kind, "key": obstacle.key or ""}
            yield {**named, "first": list(first), "last": list(last), "cells": int(cells.sum())}, cells


def peaks_and_pits(field: StepField, limit: float) -> tuple[Ints, Ints]:
    """Return for each cell the index of its peak, and of its pit, (n_x, n_y) each; -1 for none; limit: metres."""
    # Heights in nanometres, as equal ones must be equal; with a border of ground, a neighbour of the cells at the rim.
    tops = np.pad(np.rint(field.heights * 10**NANOMETRE_DIGITS).astype(np.int64), 1)
    sort = np.pad(np.where(field.frame, _FRAME, _BLOCK), 1, constant_values=_GROUND)
    a, b = neighbours(tops.shape)
    height, kind = tops.ravel(), sort.ravel()
    alike = (height[a] == height[b]) & (kind[a] == kind[b])
    plateau = component_labels(height.size, a[alike], b[alike])
    a, b = plateau[a[~alike]], plateau[b[~alike]]
    peaks, pits = np.full((2, height.size), -1)
    for indices, sign in ((peaks, 1), (pits, -1)):
        # By how much each plateau is higher than the highest of its neighbours; upside down, lower than the lowest.
        least = np.full(height.size, np.iinfo(np.int64).max)
        np.minimum.at(least, a, sign * (height[a] - height[b]))
        np.minimum.at(least, b, sign * (height[b] - height[a]))
        chosen = (least > round(limit * 10**NANOMETRE_DIGITS))[plateau] & (kind == _BLOCK)
        # Plateaus count from 0 in the order of their first cells.
        indices[chosen] = np.unique(plateau[chosen], return_inverse=True)[1].ravel()
    return peaks.reshape(tops.shape)[1:-1, 1:-1], pits.reshape(tops.shape)[1:-1, 1:-1]


COLUMNS = {
    "x0_m": "x of one end, the one of smaller x or y",
    "y0_m": "its y",
    "x1_m": "x of the other end",
    "y1_m": "its y",
    "rise_x": "direction in which the height rises: 1 or -1 along x, else 0",
    "rise_y": "the same along y",
    "low_level": "level of the lower cell; 0 outside the map, -1 for a frame",
    "low_m": "its height above the ground",
    "high_level": "level of the higher cell; -1 for a frame",
    "high_m": "its height above the ground",
}
"""The columns of `edges`, and their meaning."""

FRAME = -1
"""The level of frames in `edges`, as they have none."""


def edges(field: StepField) -> Array:
    """Return the edges of a field, one per row (n, 10): the sides of cells at which the height changes, also to the
    ground.

    First those that run along y, then those along x; by i, then by j.
    """
    line_x, line_y = field.edges()
    levels = np.pad(np.where(field.frame, FRAME, field.levels), 1).astype(np.float64)
    heights = np.pad(field.heights, 1)
    along_y = _jumps(levels[:, 1:-1], heights[:, 1:-1])
    i, j = along_y[:, :2].astype(int).T
    west_east = [line_x[i], line_y[j], line_x[i], line_y[j + 1], along_y[:, 2], np.zeros(len(i)), *along_y[:, 3:].T]
    # Found on the transposed arrays, so by j and then i, and put in the order of i and then j.
    along_x = _jumps(levels[1:-1].T, heights[1:-1].T)
    along_x = along_x[np.lexsort((along_x[:, 0], along_x[:, 1]))]
    j, i = along_x[:, :2].astype(int).T
    south_north = [line_x[i], line_y[j], line_x[i + 1], line_y[j], np.zeros(len(i)), along_x[:, 2], *along_x[:, 3:].T]
    return np.concatenate([np.stack(west_east, axis=1), np.stack(south_north, axis=1)])


def _jumps(levels: Array, heights: Array) -> Array:
    """Return the edges across the first axis: (n, 7) line, row, sign of the rise; level and height of low and high."""
    line, row = np.argwhere(heights[1:] != heights[:-1]).T
    rises = heights[line + 1, row] > heights[line, row]
    low, high = line + ~rises, line + rises
    sign = np.where(rises, 1, -1)
    columns = [line, row, sign, levels[low, row], heights[low, row], levels[high, row], heights[high, row]]
    return np.stack(columns, axis=1).astype(np.float64)


_RASTER = "float64 (n_x, n_y) * cells_per_block, height above the ground, metres; every sub-cell has its block's height"

_TAGS = {
    "i, j": "the cell, from 0 along x and y, frames counted",
    "level": "its level in the end",
    "tag": "a kind of obstacle, or peak or pit",
    "from": "recipe: cells where the obstacle's own level is 1 or more, whatever stands there in the end; field: found "
    "in the heights, as said under peak and pit",
    "number": "recipe: the obstacle's place in the recipe's list; field: the plateau; both from 0",
    "plateau": "all blocks of one height that hang together by their sides",
    "peak": "a plateau that stands above each of its neighbours by more than limit_m",
    "pit": "a plateau that lies below each of its neighbours by more than limit_m",
    "neighbours": "cells that share a side with it, frames and the ground around the map included",
}


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Posture(Format):
    """Traversability raster, edges, start and goal poses, and tags for planners over postures (NPY, CSV, MAT, JSON)."""

    name: ClassVar[str] = "posture"
    mat_file: ClassVar[str] = "posture.mat"
    step: ClassVar[Step] = "mesh"

    per_block: Annotated[int, Integer(1, 100, help="raster cells along each side of a block")] = 5
    climb_cm: Annotated[
        float | None,
        Float(0, 100_000, unit="cm", help="peaks and pits have higher steps than this on all sides; default: one unit"),
    ] = None
    clearance_cm: Annotated[
        float, Float(0, 100_000, unit="cm", help="distance of start and goal from the map's border, on flat ground")
    ] = 100.0

    @property
    def array_bytes(self) -> int:
        """Bytes of the raster, for every cell."""
        return 8 * self.per_block**2

    def _pose(self, field: StepField, side: int) -> dict[str, Json]:
        """Return the start pose, west of the map (side -1), or the goal pose, east of it (side 1); both head east."""
        x = side * (field.extent[0] / 2 + self.clearance_cm / 100)
        return {"x": round(x, NANOMETRE_DIGITS), "y": 0.0, "z": 0.0, "yaw": 0.0}

    def files(self, scene: Scene) -> Mapping[str, Iterable[bytes]]:
        """Return arrays with axis 0 along x, tables of heights north up, and metadata; lengths in metres."""
        field = scene.field
        limit = field.unit if self.climb_cm is None else self.climb_cm / 100
        peaks, pits = peaks_and_pits(field, limit)
        obstacles, lines = list(_obstacle_cells(scene)), edges(field)
        named = [obstacle for obstacle, _ in obstacles]
        raster = field.heights.repeat(self.per_block, axis=0).repeat(self.per_block, axis=1)
        start, goal = (self._pose(field, side) for side in (-1, 1))
        # For MATLAB: texts as arrays of objects become cell arrays; masks of obstacles are stacked along a third axis,
        # also if there are none; plateaus are numbered from 1, and 0 is none.
        masks = np.array([cells for _, cells in obstacles], dtype=bool)
        variables = {
            "raster": raster,
            "levels": field.levels,
            "heights": field.heights,
            "frame": field.frame,
            "cells_per_block": self.per_block,
            "unit": field.unit,
            "block_width": field.block_width,
            "edges": lines,
            "edge_columns": np.array(list(COLUMNS), dtype=object),
            "start": [list(start.values())],
            "goal": [list(goal.values())],
            "shapes": np.moveaxis(masks.reshape(len(obstacles), *field.shape), 0, 2),
            "shape_kinds": np.array([obstacle["kind"] for obstacle in named], dtype=object),
            "peaks": peaks + 1,
            "pits": pits + 1,
            "limit": limit,
            "seed": np.int64(scene.recipe.seed),
            "name": scene.name,
        }
        # Every file is explained here, as no other program writes this format.
        about: dict[str, Json] = {
            **metadata(scene),
            "cells_per_block": self.per_block,
            "cell_m": field.block_width / self.per_block,
            "raster": _RASTER,
            "start": start,
            "goal": goal,
            "poses": "metres and radians; on the flat ground, which goes on around the map; yaw 0 heads along +x",
            "edges": {"count": len(lines), "columns": COLUMNS},
            "tags": {
                "columns": _TAGS,
                "limit_m": limit,
                "recipe": named,
                "field": {"peaks": int(peaks.max()) + 1, "pits": int(pits.max()) + 1},
            },
            "recipe": encode(scene.alone),
        }
        head = f"heights in metres, {self.per_block} x {self.per_block} cells for each block"
        return {
            "raster.npy": [npy_bytes(raster)],
            "raster.csv": north_up(field.heights, head, self.per_block),
            "edges.csv": _table(COLUMNS, (map(decimal, row) for row in lines.tolist())),
            "tags.csv": _table(["i", "j", "level", "tag", "from", "number"], _tagged(field, obstacles, peaks, pits)),
            **({} if self.left_out else {"posture.mat": [mat(variables)]}),
            "posture.json": [as_json(about)],
        }


def _tagged(
    field: StepField, obstacles: Sequence[tuple[dict[str, Any], Mask]], peaks: Ints, pits: Ints
) -> Iterator[list[str]]:
    """Yield the rows of tags.csv: cells of the recipe's obstacles, then of peaks, then of pits."""
    tags = [(named["kind"], "recipe", np.where(cells, named["number"], -1)) for named, cells in obstacles]
    for tag, source, numbers in (*tags, ("peak", "field", peaks), ("pit", "field", pits)):
        for i, j in np.argwhere(numbers >= 0).tolist():
            yield [str(i), str(j), str(field.levels[i, j]), tag, source, str(numbers[i, j])]


def _table(columns: Iterable[str], rows: Iterable[Iterable[str]]) -> Iterator[bytes]:
    for row in chain([columns], rows):
        yield (",".join(row) + "\n").encode()
