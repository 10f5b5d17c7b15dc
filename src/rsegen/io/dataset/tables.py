"""Converts arrays and tables of metrics to files and back: the same values give the same bytes."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rsegen.errors import FileError, ParameterError, pip_install
from rsegen.field.metrics.batch import COLUMNS, Table
from rsegen.io import npy_files
from rsegen.io.dataset.layout import ROW
from rsegen.io.input_files import open_regular
from rsegen.params.extras import DATASET


def npy(array: NDArray[Any]) -> bytes:
    """An array as the content of a .npy file."""
    file = io.BytesIO()
    np.save(file, array, allow_pickle=False)
    return file.getvalue()


def table(form: str, maps: range, figures: Table) -> bytes:
    """The metrics of maps, whose indices in their recipe are given, as a file: a row of ROW for each, or Parquet."""
    if form == "parquet":
        return _parquet(maps, figures)
    rows = np.empty(len(maps), dtype=ROW)
    rows["map"] = maps
    for name in COLUMNS:
        rows[name] = figures[name]
    return npy(rows)


def _parquet(maps: range, figures: Table) -> bytes:
    pyarrow, parquet = arrow()
    columns = {"map": np.array(maps, dtype=np.int64), **figures}
    file = io.BytesIO()
    parquet.write_table(pyarrow.table(columns), file)
    return file.getvalue()


def mapped(path: Path, shape: tuple[int, ...], dtype: np.dtype[Any]) -> NDArray[Any]:
    """The array in a file, mapped into memory; FileError if it has another shape or type, or does not exist."""
    found = npy_files.mapped(path)
    if found.shape != shape or found.dtype != dtype:
        raise FileError(f"{path}: has shape {found.shape} of {found.dtype}; expected {shape} of {dtype}")
    return np.asarray(found)


def read_parquet(path: Path, maps: int) -> dict[str, NDArray[Any]]:
    """The columns of a Parquet table; FileError if it is another table, or does not exist."""
    pyarrow, parquet = arrow()
    try:
        with open_regular(path) as opened:
            file = parquet.ParquetFile(opened)
            types = {field.name: field.type for field in file.schema_arrow}
            if file.metadata.num_rows != maps or types != _arrow_types(pyarrow):
                raise FileError(f"{path}: is not the metrics of {maps} maps")
            found = file.read()
    except (OSError, pyarrow.ArrowException) as error:
        why = getattr(error, "strerror", None) or str(error).partition("\n")[0][:200]
        raise FileError(f"{path}: not a table in Parquet: {why}") from None
    return {name: found[name].to_numpy() for name in ROW.names or ()}


def _arrow_types(pyarrow: Any) -> dict[str, Any]:
    """The types of the columns of metrics, by name."""
    return {"map": pyarrow.int64(), **dict.fromkeys(COLUMNS, pyarrow.float32())}


def arrow() -> tuple[Any, Any]:
    """pyarrow and its Parquet; a ParameterError that says how to install it, if it is missing."""
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        raise ParameterError("metrics", f"parquet needs pyarrow: {pip_install([DATASET.name])}; or give npy") from None
    return pyarrow, parquet
