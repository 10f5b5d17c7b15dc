"""Arrays of numpy, torch and jax by one set of names: what comes in on a device goes out on it.

The three agree on most functions, if axes are given by position. Warp's arrays have no functions: they are viewed
without a copy, as numpy's on the CPU and as torch's on a GPU.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from functools import partial, reduce
from importlib import import_module
from typing import Any

import numpy as np

from rsegen.errors import ParameterError, shown

_LIBRARIES = {"numpy": "numpy", "torch": "torch", "jax": "jax.numpy", "jaxlib": "jax.numpy"}

_CLASSES = {"numpy": "ndarray", "torch": "Tensor", "jax.numpy": "ndarray"}
"""The class of all arrays of a library, those of functions that are being compiled too."""


def library_of(where: str, given: Any) -> tuple[Any, Any]:
    """Return the library of an array, and the array; numbers in lists become numpy's. ParameterError if it is none."""
    if _package(given) == "warp":
        given = given.numpy() if given.device.is_cpu else import_module("warp").to_torch(given)
    if isinstance(given, list | tuple | range | int | float):
        try:
            given = np.asarray(given)
        except ValueError:  # rows of several lengths
            given = np.asarray(given, dtype=object)
    if _package(given) not in _LIBRARIES or str(given.dtype) == "object":
        raise ParameterError(where, f"{shown(given)} is not an array of numpy, torch, jax or Warp")
    return _library(_package(given)), given


def array_like(other: Any, values: Any, dtype: Any = None) -> Any:
    """Return values as an array of the library of another one, in torch on its device; jax places them itself."""
    library = _library(_package(other))
    return library.asarray(values, dtype=dtype, **({"device": other.device} if library.__name__ == "torch" else {}))


def class_of(library: Any) -> type:
    """Return the class of the arrays of a library."""
    return getattr(library, _CLASSES[library.__name__])  # type: ignore[no-any-return]


def is_whole(array: Any) -> bool:
    """Return whether an array has integers, of any library."""
    return "int" in str(array.dtype)


def is_real(array: Any) -> bool:
    """Return whether an array has floating-point numbers, of any library."""
    return "float" in str(array.dtype)


def can_be_asked(array: Any) -> bool:
    """Return whether an array is one of torch whose values can be read now; in jax and `torch.compile` they may not."""
    return hasattr(array, "is_cuda") and not import_module("torch").compiler.is_compiling()


def as_type(array: Any, dtype: Any) -> Any:
    """Return an array in a type of its library, on its device: without a copy if it is of that type."""
    return array.to(dtype) if hasattr(array, "to") else array.astype(dtype, copy=False)


def with_values(array: Any, place: tuple[Any, ...], values: Any) -> Any:
    """Return an array with values at a place: the same one, in place, but for jax, whose arrays do not change."""
    if hasattr(array, "at"):
        return array.at[place].set(values)
    array[place] = values
    return array


def extremes(levels: Any, wide: Sequence[int]) -> tuple[Any, Any]:
    """Return the least and the highest level in each rectangle of `wide` cells along x and y: (..., n_x, n_y) each."""
    library, ends = _library(_package(levels)), []
    for combine in (library.minimum, library.maximum):
        combined = levels
        for axis, cells in enumerate(wide):
            # First along x, then along y: each place is combined with the cells after it on the axis.
            places, y_axis = combined.shape[axis - 2] - cells + 1, [slice(None)] * (1 - axis)
            shifted = [combined[(..., slice(first, first + places), *y_axis)] for first in range(cells)]
            combined = reduce(combine, shifted)
        ends.append(combined)
    return ends[0], ends[1]


def draws_of(random: Any, library: Any, where: str = "random") -> Iterator[Callable[[str, Any], Any]]:
    """Yield functions of a distribution and an array, which give random numbers of its shape, type and device.

    random: a Generator of numpy or torch, None for torch's own, or a key of jax; ParameterError if another library's
    """
    if not _is_of(random, library):
        name = library.__name__.partition(".")[0]
        sort = "key" if name == "jax" else "Generator"
        raise ParameterError(where, f"{shown(random)} is no {sort} of {name}, and the arrays are of {name}")
    while True:
        if library is np:
            yield partial(_of_numpy, random)
        elif hasattr(library, "Generator"):
            yield partial(_of_torch, random, library)
        else:
            random, own = import_module("jax.random").split(random)  # a key gives the same numbers each time
            yield partial(_of_jax, own)


def _is_of(random: Any, library: Any) -> bool:
    """Return whether a library can draw from this."""
    if library is np:
        return isinstance(random, np.random.Generator)
    if hasattr(library, "Generator"):
        return random is None or isinstance(random, library.Generator)
    return hasattr(random, "dtype")  # a key may be a new one of jax, or an array


def _of_numpy(random: np.random.Generator, name: str, like: Any) -> Any:
    drawn = random.standard_normal(like.shape) if name == "normal" else random.random(like.shape)
    return drawn.astype(like.dtype)


def _of_torch(random: Any, torch: Any, name: str, like: Any) -> Any:
    draw = torch.randn if name == "normal" else torch.rand
    return draw(like.shape, generator=random, dtype=like.dtype, device=like.device)


def _of_jax(key: Any, name: str, like: Any) -> Any:
    return getattr(import_module("jax.random"), name)(key, like.shape, like.dtype)


def is_traced(array: Any) -> bool:
    """Return whether jax is compiling, so that an array stands for numbers that come later."""
    return _package(array) == "jax" and isinstance(array, import_module("jax.core").Tracer)


def _package(value: Any) -> str:
    return type(value).__module__.split(".")[0]


def _library(package: str) -> Any:
    return sys.modules[_LIBRARIES[package]]
