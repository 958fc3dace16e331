"""Conversion between columns of Arrow batches and arrays, without a copy if the memory layouts agree."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from robot_dynamics.errors import ColumnError


def array_of(batch: Any, column: str, name: str, width: int, part: slice, robot: str) -> NDArray[Any]:
    """Numbers of a column of lists, or of a slice of each list; NaN for null.

    Lists of fixed size, and others whose numbers are adjacent in memory, are not copied.

    Parameters
    ----------
    batch : pyarrow.RecordBatch
        Batch with the column.
    column : str
        Name of the column.
    name : str
        Name of the argument, for messages.
    width : int
        Required numbers for each row.
    part : slice
        Slice of each list.
    robot : str
        Name of the robot, for messages.

    Returns
    -------
    ndarray, shape (rows, width)
        Numbers of the column.

    Raises
    ------
    ColumnError
        The column is missing or has the wrong type or width.
    """
    index = batch.schema.get_field_index(column)
    if index < 0:
        times = batch.schema.names.count(column)
        found = f"{times} columns `{column}`" if times else f"no column `{column}`"
        raise ColumnError(f"{found} for {name}; there are {batch.schema.names}; `columns` can name the one of {name}")
    array = batch.column(index)
    where = f"column `{column}`" if part == slice(None) else f"column `{column}[{_text(part)}]`"
    if isinstance(array, pa.ExtensionArray):  # for example a tensor of fixed shape
        array = array.storage
    kind = array.type
    if pa.types.is_floating(kind):  # one number for each row
        table = _numbers(array, where).reshape(-1, 1)
    elif pa.types.is_fixed_size_list(kind):
        # `values` is the whole child array, not only the slice of this array.
        values = array.values.slice(array.offset * kind.list_size, len(array) * kind.list_size)
        table = _numbers(values, where).reshape(len(array), kind.list_size)
    elif pa.types.is_list(kind) or pa.types.is_large_list(kind):
        if array.null_count == len(array):
            return np.full((len(array), width), np.nan, _dtype(kind, where))
        table = _of_lists(array, where, name)
    else:
        raise ColumnError(f"{where} for {name} is of type {kind}; it must be lists of float64 or float32")
    table = table[:, part]
    if table.shape[1] != width:
        raise ColumnError(f"{where} has {table.shape[1]} numbers a row, robot `{robot}` needs {width} for {name}")
    if array.null_count:
        table = table.copy()
        table[array.is_null().to_numpy(zero_copy_only=False)] = np.nan
    return table


def column_of(array: NDArray[Any], bad: NDArray[np.intp]) -> Any:
    """Column of an array (rows, ...), with null for bad rows, on the array's memory as nested lists.

    Parameters
    ----------
    array : ndarray, shape (rows, ...)
        Numbers of the column.
    bad : ndarray of int
        Rows that become null.

    Returns
    -------
    pyarrow.Array
        Column of numbers or of nested lists of fixed size.
    """
    rows = len(array)
    mask = None
    if len(bad):
        hidden = np.zeros(rows, bool)
        hidden[bad] = True
        mask = pa.array(hidden)
    if array.ndim == 1:
        return pa.array(array, mask=None if mask is None else hidden)
    column = pa.array(np.ascontiguousarray(array).reshape(-1))
    for axis in range(array.ndim - 1, 0, -1):
        kind = pa.list_(column.type, array.shape[axis])
        column = pa.FixedSizeListArray.from_arrays(column, type=kind, mask=mask if axis == 1 else None)
    return column


def _numbers(values: Any, where: str) -> NDArray[Any]:
    """Memory of a column of numbers; a copy with NaN if some are null."""
    _dtype(values.type, where)
    array: NDArray[Any] = values.to_numpy(zero_copy_only=values.null_count == 0)
    return array


def _dtype(kind: Any, where: str) -> Any:
    """NumPy dtype of a column's numbers."""
    kind = getattr(kind, "value_type", kind)
    if not (pa.types.is_float64(kind) or pa.types.is_float32(kind)):
        raise ColumnError(f"{where} has numbers of type {kind}; they must be float64 or float32")
    return np.dtype(np.float32 if pa.types.is_float32(kind) else np.float64)


def _of_lists(array: Any, where: str, name: str) -> NDArray[Any]:
    """Numbers of variable-size lists that all have the same length; null lists may have any."""
    is_valid = array.is_valid().to_numpy(zero_copy_only=False)
    lengths = np.diff(array.offsets.to_numpy())[is_valid]
    width = int(lengths[0])
    if (lengths != width).any():
        row = int(np.flatnonzero(is_valid)[np.flatnonzero(lengths != width)[0]])
        raise ColumnError(
            f"{where} for {name} has lists of {width} numbers and of others, the first in row {row} of a batch"
        )
    # `flatten` omits the content of null lists, and numbers before and after the slice.
    values = _numbers(array.flatten(), where).reshape(len(lengths), width)
    if len(values) == len(array):
        return values
    table = np.full((len(array), width), np.nan, values.dtype)
    table[is_valid] = values
    return table


def _text(part: slice) -> str:
    return f"{'' if part.start is None else part.start}:{'' if part.stop is None else part.stop}"
