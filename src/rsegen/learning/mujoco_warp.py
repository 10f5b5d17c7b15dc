"""mujoco_warp: one map per world, which changes without compiling anew (4.0).

model, data = mjw.put_model(compiled), mjw.make_data(compiled, nworld=64)
blocks = BlocksOfWorlds(grid, compiled, model, data)
blocks.write(rsegen.build_many(recipe, range(64)))
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import warp as wp

from rsegen.errors import ParameterError, refuse_other
from rsegen.field.stepfield import Array, Ints
from rsegen.learning.arrays import is_whole
from rsegen.learning.blocks import BELOW
from rsegen.learning.ground import Ground
from rsegen.learning.mujoco import BlockGrid


class BlocksOfWorlds:
    """The blocks of a grid in the worlds of mujoco_warp; until they are written, all are as in the compiled model.

    compiled: the MjModel with the blocks, from which model and data were made. The arrays of the model get a row for
    each world here, so a CUDA graph has to be captured after this; `write` then changes them in place.
    ground: the blocks as heights, friction and scans; it follows `write`. It is of numpy; for tensors on a GPU make one
    of a tensor of the levels, `grid.ground(tensor)`, and write into both.
    """

    def __init__(self, grid: BlockGrid, compiled: Any, model: Any, data: Any) -> None:
        refuse_other("grid", grid, BlockGrid)
        self.grid: BlockGrid = grid
        self._part, self._data = grid.geoms(compiled), data
        self.worlds: int = data.nworld
        # mujoco_warp has one row for all worlds as long as they are alike.
        for name in ("geom_pos", "geom_size", "geom_rgba", "geom_friction"):
            array = getattr(model, name)
            rows = np.broadcast_to(array.numpy(), (self.worlds, *array.numpy().shape[1:]))
            setattr(model, name, wp.array(rows, dtype=array.dtype, device=array.device))
        self._model = model
        self._tables: list[Any] = [
            wp.array(table, dtype=wp.float32, device=data.geom_xpos.device) for table in (grid.colours, grid.frictions)
        ]
        self.ground: Ground = grid.ground(np.broadcast_to(np.int16(grid.highest), (self.worlds, *grid.shape)))

    def write(self, levels: Ints, worlds: Sequence[int] | Any = None) -> None:
        """Put maps, (worlds, n_x, n_y), into these worlds, or into all: heights, friction and colours.

        Positions go into the data too, as mujoco_warp does not compute them again for static geoms. Levels in a tensor
        of torch stay on its device, and nothing waits for the host; `ground` does not follow them.
        """
        if hasattr(levels, "is_cuda"):  # a tensor, not an array of numpy
            self._write_tensor(levels, worlds)
            return
        rows = np.arange(self.worlds) if worlds is None else np.asarray(worlds)
        self.ground.write(np.asarray(levels), rows)  # refuses worlds and levels before anything is written
        grid, model, position = self.grid, self._model, self.grid.pos(levels)
        self._put(model.geom_pos, rows, position)
        self._put(self._data.geom_xpos, rows, position)
        self._put(model.geom_size, rows, grid.size(levels))
        self._put(model.geom_rgba, rows, grid.rgba(levels))
        self._put(model.geom_friction, rows, grid.friction(levels))

    def _write_tensor(self, levels: Any, worlds: Any) -> None:
        """Write levels in a tensor of torch; of centres and sides only z depends on a map.

        Levels are clipped to the levels of the recipe, as in a Ground: a check would wait for the device.
        """
        grid, rows = self.grid, slice(None) if worlds is None else worlds
        rows = rows.long() if hasattr(rows, "long") else rows  # bytes are a mask for torch
        expected = (self.worlds if worlds is None else len(worlds), *grid.shape)
        if tuple(levels.shape) != expected or not is_whole(levels):
            problem = f"{levels.dtype} of shape {tuple(levels.shape)}"
            raise ParameterError("levels", f"{problem}; expected integers, in units, of shape {expected}")
        part, blocks = self._part, levels.flatten(1).long().clamp(0, grid.recipe.highest_level)
        heights = blocks * (grid.recipe.unit_cm / 100)
        model, centres = self._model, (heights - BELOW) / 2 + float(grid.position[2])
        wp.to_torch(model.geom_pos)[rows, part, 2] = centres
        wp.to_torch(self._data.geom_xpos)[rows, part, 2] = centres
        wp.to_torch(model.geom_size)[rows, part, 2] = (heights + BELOW) / 2
        colours, frictions = map(wp.to_torch, self._tables)
        wp.to_torch(model.geom_rgba)[rows, part] = colours[blocks]
        wp.to_torch(model.geom_friction)[rows, part, 0] = frictions[blocks]

    def _put(self, array: Any, rows: Ints, values: Array) -> None:
        """Write the values of the blocks into some rows of an array (worlds, geoms)."""
        geoms = np.arange(self._part.start, self._part.stop)
        places: list[Any] = [wp.array(part, dtype=wp.int32, device=array.device) for part in (rows, geoms)]
        new: Any = wp.array(values, dtype=array.dtype, device=array.device)
        blocks: Any = wp.indexedarray(array, places)
        wp.copy(blocks, new)
