"""Formulas that are written once, for a number, an array of numpy, or a tensor of torch on any device.

Operators are the same in all of them; this file has the functions that are not. Every one of them gives the same bits
in numpy and torch: integers, and floats of 64 bits that are added, multiplied, divided, rounded down or compared, which
IEEE 754 fixes. torch is never imported here: whoever has a tensor has imported it.

array-api-compat would replace little of it, as plain numbers, casts, draws and minima at indices are not in the array
API, and would be a requirement of the core whose look-up of a namespace takes 15 us, a hundred times as long as ours.
"""

from __future__ import annotations

import sys
from typing import Any

import numpy as np


def namespace(array: Any) -> Any:
    """Return numpy, or torch for a tensor: the module whose functions take this array."""
    return np if isinstance(array, (np.ndarray, np.generic, int, float)) else sys.modules["torch"]


def where(condition: Any, yes: Any, no: Any) -> Any:
    """Return `yes` where a condition holds, else `no`: one of two numbers, or an array."""
    if isinstance(condition, bool):
        return yes if condition else no
    return namespace(condition).where(condition, yes, no)


def least(values: Any, bound: Any) -> Any:
    """Return the smaller of two values; the first one may be an array."""
    if isinstance(values, (int, float)) and isinstance(bound, (int, float)):
        return min(values, bound)
    xp = namespace(values)
    return np.minimum(values, bound) if xp is np else xp.clamp(values, max=bound)


def greatest(values: Any, bound: Any) -> Any:
    """Return the larger of two values; the first one may be an array."""
    if isinstance(values, (int, float)) and isinstance(bound, (int, float)):
        return max(values, bound)
    xp = namespace(values)
    return np.maximum(values, bound) if xp is np else xp.clamp(values, min=bound)


def cast(values: Any, kind: str) -> Any:
    """Return values as numbers of another type, such as `int16`; floats are cut off towards 0. Not always a copy."""
    xp = namespace(values)
    return np.asarray(values).astype(kind, copy=False) if xp is np else values.to(getattr(xp, kind))


def level_of(bounds: Any, values: Any) -> Any:
    """Return for each value how many of the ascending bounds are not above it."""
    xp = namespace(values)
    if xp is np:
        return np.searchsorted(bounds, values, side="right")
    return xp.searchsorted(xp.as_tensor(bounds, device=values.device), values, right=True)


def arange(count: int, like: Any) -> Any:
    """Return 0, 1, .. count - 1 as int64, where the array `like` is."""
    xp = namespace(like)
    return np.arange(count) if xp is np else xp.arange(count, device=like.device)


def asarray(values: Any, like: Any) -> Any:
    """Return an array of numpy, or a tensor, where the array `like` is."""
    xp = namespace(like)
    if xp is np:
        return values
    if isinstance(values, np.ndarray) and min(values.strides, default=0) < 0:
        values = values.copy()  # a mirrored view, which torch cannot take
    return xp.as_tensor(values, device=like.device)


def as_numpy(values: Any) -> Any:
    """Return an array of numpy, or the values of a tensor as one."""
    return values if namespace(values) is np else values.cpu().numpy()


def overwrite(values: Any, new: Any, mask: Any) -> None:
    """Put new values in place where a mask is true."""
    xp = namespace(values)
    if xp is np:
        np.copyto(values, new, where=mask)
    else:
        values[:] = xp.where(mask, new, values)


def least_at(values: Any, indices: Any, bounds: Any) -> None:
    """Lower values at some indices, which may repeat, to the bounds that are given for them."""
    xp = namespace(values)
    if xp is np:
        np.minimum.at(values, indices, bounds)
    else:
        values.scatter_reduce_(0, indices, bounds, "amin")


_FEW = 2**11
"""Values of a row whose index fits into an integer of 64 bits behind the 53 bits of a random number."""


def order_of_draws(values: Any) -> Any:
    """Return the indices that sort each row of random numbers, equal ones as they lie.

    Short rows are sorted as integers of a number and its index, in a tenth of the time of a stable sort of floats.
    """
    xp, columns = namespace(values), values.shape[1]
    if columns <= _FEW:
        # 53 bits with their sign, in front of those of the index; exact, and in place, as memory limits this.
        scaled = values - 0.5
        scaled *= 2.0**53 * _FEW
        keys = cast(scaled, "int64")
        keys += arange(columns, values)
        keys = np.sort(keys, axis=-1) if xp is np else xp.sort(keys, dim=-1).values
        keys &= _FEW - 1
        return keys
    return np.argsort(values, axis=-1, kind="stable") if xp is np else xp.argsort(values, dim=-1, stable=True)


def ranks_of_draws(values: Any) -> Any:
    """Return the place of each random number in the ascending order of its row, equal ones as they lie."""
    rows, columns = values.shape
    order = order_of_draws(values)
    places = namespace(values).empty_like(order)
    places[arange(rows, values)[:, None], order] = arange(columns, values)
    return places


def take_along_rows(values: Any, indices: Any) -> Any:
    """Return the values of each row at the indices of that row."""
    return np.take_along_axis(values, indices, 1) if namespace(values) is np else values.gather(1, indices)


def places_of(mask: Any) -> Any:
    """Return the indices at which a mask of one axis is true."""
    return np.flatnonzero(mask) if namespace(mask) is np else mask.nonzero()[:, 0]


def maps_last(values: Any, kind: str = "float64") -> Any:
    """Return (maps, n_x, n_y) as (n_x, n_y, maps), where arithmetic on small maps runs along long rows of memory."""
    xp, turned = namespace(values), cast(namespace(values).moveaxis(values, 0, -1), kind)
    return np.ascontiguousarray(turned) if xp is np else turned.contiguous()


def maps_first(fields: Any) -> Any:
    """Return whole numbers (n_x, n_y, maps) as levels (maps, n_x, n_y), int16."""
    return namespace(fields).moveaxis(cast(fields, "int16"), -1, 0)
