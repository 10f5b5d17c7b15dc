"""PyTorch: the blocks of many maps in a tensor, made on the device on which a learner needs them.

    levels = build_many(recipe, range(16384), device="cuda")    # (maps, n_x, n_y), int16, on the GPU

The levels equal `rsegen.build_many`'s, bit for bit: the same formulas, in integers and floats of 64 bits, run over
tensors (params/arrays.py). A GPU makes the random numbers of all cells, the levels of random kinds, blends, difficulty,
and a largest step of the recipe. The processor makes, by numpy, the seeds, one hash for each map and obstacle; drawn
ends, and the profiles between them, of which each is made once; and, map by map, all that `rsegen.build_many` makes map
by map. A device without floats of 64 bits, such as Apple's MPS, cannot do it.
"""

from __future__ import annotations

from collections.abc import Iterable

import torch

from rsegen.errors import ParameterError, TooLarge, shown
from rsegen.recipe.batch import build_many as of_numpy
from rsegen.recipe.batch import checked_indices, fill
from rsegen.recipe.map_design import MapDesign

_CELLS_AT_ONCE = 2**22
"""Cells that are made together: an array of numbers for them takes 32 MB, and about ten of them exist at a time."""


def build_many(recipe: MapDesign, indices: Iterable[int], device: str | torch.device = "cuda") -> torch.Tensor:
    """Return the levels of the blocks of these maps of a recipe, frames left out: (maps, n_x, n_y), int16, on a device.

    ParameterError if the device is not there or has no floats of 64 bits, or an index is no whole number from 0 on;
    TooLarge if the device has not enough memory.
    """
    maps = checked_indices(indices)
    try:  # floats of 64 bits can be added there
        place = torch.device(device)
        (torch.ones(1, dtype=torch.float64, device=place) + 1).item()
    except (RuntimeError, TypeError, AssertionError, NotImplementedError) as error:
        reason = str(error).partition("\n")[0].partition(". ")[0]
        raise ParameterError("device", f"{shown(str(device))} cannot be used ({reason}); use cuda or cpu") from None
    if place.type == "cpu":
        return torch.from_numpy(of_numpy(recipe, maps))  # several times as fast as tensors
    try:
        levels = torch.zeros((len(maps), *recipe.grid.shape), dtype=torch.int16, device=place)
        fill(levels, recipe, maps, _CELLS_AT_ONCE, _CELLS_AT_ONCE)
    except torch.OutOfMemoryError:
        n_x, n_y = recipe.grid.shape
        raise TooLarge(f"indices: {len(maps)} maps of {n_x} x {n_y} blocks exceed the memory of {place}") from None
    return levels
