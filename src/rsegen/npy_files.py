"""Arrays in files of numpy (.npy): the header is checked against the file before anything is allocated.

The format is numpy's own (numpy.lib.format): a magic string, a version, the length of the header, and the header as
Python text. A header from anybody may promise more than the file holds, be a megabyte long, or hold objects to
unpickle; all of these are refused first. The array is then mapped into memory, so only what is used is read.
"""

from __future__ import annotations

import math
import os
from io import BufferedReader, BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from rsegen.errors import FileError
from rsegen.input_files import open_regular, refuse_pointer, silent_libraries, unreadable

_LONGEST_HEADER = 10_000
"""Bytes of a header at most: that of an array of numbers has 128, and numpy parses no more by itself."""

_SIZE_BYTES = {(1, 0): 2, (2, 0): 4}
"""Bytes of the length of a header, by the version of the format; version 3 is for names that Latin-1 cannot write."""


def npy_bytes(array: NDArray[Any]) -> bytes:
    """Return an array as the content of a .npy file, row by row."""
    file = BytesIO()
    npy.write_array(file, np.ascontiguousarray(array), allow_pickle=False)
    return file.getvalue()


def mapped(path: Path) -> NDArray[Any]:
    """Return the array in a file, mapped into memory, read-only; FileError if the file is not what its header says."""
    refuse_pointer(path)
    try:
        with open_regular(path) as file:
            shape, is_fortran, dtype = _header(file)
            if dtype.hasobject or not dtype.itemsize:
                raise ValueError(f"its values are {str(dtype)[:40]}")
            if any(cells < 0 for cells in shape):
                raise ValueError(f"a shape of {str(shape)[:60]}")
            start, promised = file.tell(), math.prod(shape) * dtype.itemsize
            size = os.fstat(file.fileno()).st_size - start
            if promised > size:
                raise ValueError(f"its header promises {str(promised)[:40]} bytes, {size} are there")
            return np.memmap(path, dtype=dtype, shape=shape, order="F" if is_fortran else "C", mode="r", offset=start)
    except OSError as error:
        raise FileError(unreadable(path, error)) from None
    except (EOFError, MemoryError, OverflowError, TypeError, ValueError) as error:
        why = str(error).partition("\n")[0][:100]
        raise FileError(f"{path}: not an array of numbers that numpy saved (.npy): {why}") from None


def _header(file: BufferedReader) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    """Return shape, Fortran order and type, of no more bytes than a header has; ValueError if it is none."""
    version = npy.read_magic(file)
    if version not in _SIZE_BYTES:
        raise ValueError(f"version {version[0]}.{version[1]} of the format")
    start = file.read(_SIZE_BYTES[version])
    length = int.from_bytes(start, "little")
    if length > _LONGEST_HEADER:
        raise ValueError(f"a header of {length} bytes")
    text = BytesIO(start + file.read(length))
    reader = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
    try:
        with silent_libraries():  # numpy warns of headers that Python 2 wrote
            return reader(text)
    except Exception:  # numpy parses it as Python, which fails in many ways
        raise ValueError("its header is damaged") from None
