"""Arrow tables: states in columns, and any quantity of the package as columns.

Needs pyarrow (``pip install robot-dynamics[arrow]``). Input is any object with the Arrow PyCapsule interface:
tables of pyarrow, Polars, DuckDB, Daft, DataFusion. Output is a table of pyarrow, which these libraries read
directly. Numbers are not copied if the memory layouts agree.

A row is a state. The columns `q` (nq numbers), `v`, `a` and `tau` (nv numbers) are lists of float64 or
float32, of fixed size or not. A result of shape (..., nv) is a column of lists of fixed size. (..., nv, nv)
is one of nested lists, and (...,) one of numbers. Rows are independent: results do not depend on how a table
is split into batches.

>>> import pyarrow as pa
>>> from robot_dynamics import arrow
>>> robot = rd.example("two_r")
>>> states = pa.table({"q": [[0.0, 0.0], [0.5, 1.0]], "v": [[0.0, 0.0], [1.0, -1.0]]})
>>> arrow.compute(robot, states, "bias", "potential_energy").column_names
['bias', 'potential_energy']

For recordings with other column names, as those of LeRobot, `columns` maps the arguments to columns. `keep`
names columns to copy to the result.

>>> recording = pa.table({"observation.state": [[0.1, 0.2, 0.7]], "episode_index": [3]})  # the last one is a gripper
>>> found = arrow.compute(robot, recording, "gravity", columns={"q": "observation.state[0:2]"}, keep=["episode_index"])
>>> found.column_names
['episode_index', 'gravity']
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from robot_dynamics.columns import array_of, column_of
from robot_dynamics.energy_accounts import energy_accounts
from robot_dynamics.errors import BadStatesError, ColumnError, StateError
from robot_dynamics.quantities import AUDIT, Quantity, quantity, quantity_names
from robot_dynamics.robot import Robot

try:
    import pyarrow as pa
except ImportError:
    raise ImportError("robot_dynamics.arrow needs pyarrow: pip install robot-dynamics[arrow]") from None

__all__ = ["AUDIT", "Computation", "compute", "energy_accounts", "quantity_names", "stream"]


class Computation:
    """Quantities of one robot for the rows of tables. The object is callable and can be pickled.

    Parameters
    ----------
    robot : Robot
        Robot to compute the quantities of.
    quantities : sequence of str
        Names of methods of `Robot`; a frame follows a colon (``frame_pose:panda_link8``), and a reference
        frame another one (``frame_velocity:panda_link8:local``). ``audit`` is the audit of recorded motion,
        see `robot_dynamics.quantities.AUDIT`.
    columns : mapping of str to str, optional
        Column of each argument whose column has another name; ``state[0:7]`` is a slice of its lists.
    keep : iterable of str
        Columns to copy to the result.
    dtype : {"float64", "float32"}, optional
        Type to compute in; default: that of the columns, which must be the same for all.
    bad_states : {"raise", "null"}
        Whether a row without a valid result (a NaN, a null, an invalid quaternion) raises `BadStatesError` or
        is null.
    threads : int, optional
        Threads for a batch; default: `num_threads()`.

    Raises
    ------
    QuantityError
        A quantity does not exist.
    FrameError
        A frame is missing or does not exist.
    ColumnError
        `columns` names an argument that no quantity reads, or a result has the name of a kept column.
    ValueError
        An option is invalid, or there is no quantity.

    Examples
    --------
    >>> import pyarrow as pa
    >>> from robot_dynamics.arrow import Computation
    >>> energy = Computation(rd.example("two_r"), ["kinetic_energy"])
    >>> energy.reads
    {'q': 'q', 'v': 'v'}
    >>> energy(pa.table({"q": [[0.0, 0.0]], "v": [[1.0, 0.0]]}))["kinetic_energy"].to_numpy().round(9)
    array([1.5])
    """

    def __init__(
        self,
        robot: Robot,
        quantities: Sequence[str],
        *,
        columns: Mapping[str, str] | None = None,
        keep: Iterable[str] = (),
        dtype: Literal["float64", "float32"] | None = None,
        bad_states: Literal["raise", "null"] = "raise",
        threads: int | None = None,
    ) -> None:
        self.robot = robot
        self.quantities = tuple(quantities)
        self.columns = dict(columns or {})
        self.keep = tuple(keep)
        self.dtype = dtype
        self.bad_states = bad_states
        self.threads = threads
        if bad_states not in ("raise", "null"):
            raise ValueError(f"bad_states = {bad_states!r} must be 'raise' or 'null'")
        if dtype not in (None, "float64", "float32"):
            raise ValueError(f"dtype = {dtype!r} must be 'float64' or 'float32'")
        if not quantities:
            raise ValueError("no quantity: name at least one, for example 'inverse_dynamics'")
        self._quantities: list[Quantity] = [quantity(robot, name) for name in self.quantities]
        read = dict.fromkeys(name for each in self._quantities for name in each.reads)
        unread = [name for name in self.columns if name not in read]
        if unread:
            raise ColumnError(f"columns names {unread}, but {list(self.quantities)} read {list(read)}")
        self.sources = {name: _parse_source(self.columns.get(name, name)) for name in read}
        """Column and slice of its lists, for each argument."""
        twice = sorted(set(self.keep) & {name for each in self._quantities for name in each.names})
        if twice:
            raise ColumnError(f"kept columns {twice} have the names of results: rename them first")

    @property
    def reads(self) -> dict[str, str]:
        """Column of each argument, as in `columns`."""
        return {name: self.columns.get(name, name) for name in self.sources}

    def __call__(self, data: Any) -> Any:
        """Compute the quantities of a table's rows.

        Parameters
        ----------
        data : Arrow table or pyarrow.RecordBatch
            States.

        Returns
        -------
        pyarrow.Table or pyarrow.RecordBatch
            The kept columns, then the results; a batch for a batch.

        Raises
        ------
        BadStatesError
            Some rows have no valid result; `result` has the others.
        ColumnError
            A column is missing or has the wrong type.
        """
        if isinstance(data, pa.RecordBatch):
            batches, schema = [data], data.schema
        else:
            table = data if isinstance(data, pa.Table) else pa.table(data)
            batches, schema = table.to_batches(), table.schema
        results, bad, first = [], [], 0
        for batch in batches:
            result, found = self.rows(batch, first)
            results.append(result)
            bad += found
            first += batch.num_rows
        if isinstance(data, pa.RecordBatch):
            whole = results[0]
        else:
            whole = pa.Table.from_batches(results, self.schema(schema))
        if bad and self.bad_states == "raise":
            raise self.bad_rows_error(bad, first, whole)
        return whole

    def schema(self, schema: Any) -> Any:
        """Columns of the results for a table.

        Parameters
        ----------
        schema : pyarrow.Schema
            Columns of the table.

        Returns
        -------
        pyarrow.Schema
            Columns of the results.

        Raises
        ------
        ColumnError
            A column is missing or has the wrong type.
        """
        return self.rows(_empty_batch(schema))[0].schema

    def rows(self, batch: Any, first: int = 0) -> tuple[Any, list[tuple[str, int, str]]]:
        """Quantities of a batch, null in rows without a valid result.

        Parameters
        ----------
        batch : pyarrow.RecordBatch
            States.
        first : int
            Number of the first row.

        Returns
        -------
        pyarrow.RecordBatch
            The kept columns, then the results.
        list of tuple (str, int, str)
            Quantity, row number and reason of each invalid result. The reason is empty except for the first
            invalid row of each quantity.

        Raises
        ------
        ColumnError
            A column is missing or has the wrong type.
        """
        missing = [name for name in self.keep if batch.schema.get_field_index(name) < 0]
        if missing:
            raise ColumnError(f"no column {missing} to keep; there are {batch.schema.names}")
        widths = {"nq": self.robot.nq, "nv": self.robot.nv, "3nv": 3 * self.robot.nv, "6": 6, "1": 1}
        state: dict[str, NDArray[Any]] = {}
        for name, (column, part) in self.sources.items():
            width = widths[_WIDTHS.get(name, "nv")]
            array = array_of(batch, column, name, width, part, self.robot.name)
            state[name] = array if self.dtype is None else array.astype(self.dtype, copy=False)
        kept = [batch.column(batch.schema.get_field_index(name)) for name in self.keep]
        names, bad = list(self.keep), []
        for each in self._quantities:
            rows = np.zeros(0, np.intp)
            try:
                results = each.compute(state, self.threads)
            except BadStatesError as error:
                rows, results = error.indices, each.split(error.result)
                bad += [(each.name, first + int(row), "") for row in rows]
                bad[-len(rows)] = (each.name, first + int(rows[0]), self._reason(each, state, int(rows[0])))
            names += each.names
            kept += [column_of(result, rows) for result in results]
        fields = [
            batch.schema.field(name) if name in self.keep else pa.field(name, column.type)
            for name, column in zip(names, kept, strict=True)
        ]
        return pa.RecordBatch.from_arrays(kept, schema=pa.schema(fields)), bad

    def _reason(self, each: Quantity, state: dict[str, NDArray[Any]], row: int) -> str:
        """Error message of one row."""
        try:
            each.compute({name: array[row] for name, array in state.items()}, None)
        except StateError as error:
            return str(error)
        return "no valid result"

    def bad_rows_error(self, bad: list[tuple[str, int, str]], rows: int, result: Any) -> BadStatesError:
        """Exception for rows without a valid result.

        Parameters
        ----------
        bad : list of tuple (str, int, str)
            Invalid results, as `rows` returns them.
        rows : int
            Number of all rows.
        result : pyarrow.Table or pyarrow.RecordBatch
            Results with null in the invalid rows.

        Returns
        -------
        BadStatesError
            The exception.
        """
        name, row, reason = bad[0]
        indices = np.unique(np.array([row for _, row, _ in bad], np.intp))
        verb = "has" if len(indices) == 1 else "have"
        return BadStatesError(
            f"{len(indices)} of {rows} rows {verb} no `{name}`, the first is row {row}: {reason}; "
            "bad_states='null' leaves them empty",
            indices=indices,
            result=result,
        )


def compute(robot: Robot, data: Any, *quantities: str, **options: Any) -> Any:
    """Compute quantities of the rows of a table.

    Parameters
    ----------
    robot : Robot
        Robot to compute the quantities of.
    data : Arrow table or pyarrow.RecordBatch
        States.
    *quantities : str
        Names of quantities; see `Computation`.
    **options
        Options of `Computation`.

    Returns
    -------
    pyarrow.Table or pyarrow.RecordBatch
        The kept columns, then the results; a batch for a batch.

    Raises
    ------
    BadStatesError
        Some rows have no valid result; `result` has the others.
    ColumnError
        A column is missing or has the wrong type.

    Examples
    --------
    >>> import polars as pl
    >>> from robot_dynamics import arrow
    >>> states = pl.DataFrame({"q": [[0.0, 0.0], [0.5, 1.0]]})
    >>> pl.DataFrame(arrow.compute(rd.example("two_r"), states, "mass_matrix")).schema
    Schema([('mass_matrix', Array(Float64, shape=(2, 2)))])
    """
    return Computation(robot, quantities, **options)(data)


def stream(robot: Robot, data: Any, *quantities: str, **options: Any) -> Any:
    """Compute quantities batch by batch, for tables larger than memory.

    Parameters
    ----------
    robot : Robot
        Robot to compute the quantities of.
    data : pyarrow.RecordBatchReader or Arrow stream
        States.
    *quantities : str
        Names of quantities; see `Computation`.
    **options
        Options of `Computation`.

    Returns
    -------
    pyarrow.RecordBatchReader
        Reader that computes each batch when it is read. It raises `BadStatesError` at a batch with invalid
        rows.

    Raises
    ------
    ColumnError
        A column is missing or has the wrong type.

    Examples
    --------
    >>> import pyarrow as pa
    >>> from robot_dynamics import arrow
    >>> states = pa.table({"q": [[0.0, 0.0], [0.5, 1.0]]}).to_reader(max_chunksize=1)
    >>> [batch.num_rows for batch in arrow.stream(rd.example("two_r"), states, "gravity")]
    [1, 1]
    """
    computation = Computation(robot, quantities, **options)
    reader = data if isinstance(data, pa.RecordBatchReader) else pa.RecordBatchReader.from_stream(data)

    def results() -> Iterator[Any]:
        first = 0
        for batch in reader:
            result, bad = computation.rows(batch, first)
            first += batch.num_rows
            if bad and computation.bad_states == "raise":
                raise computation.bad_rows_error(bad, first, result)
            yield result

    return pa.RecordBatchReader.from_batches(computation.schema(reader.schema), results())


_WIDTHS = {"q": "nq", "q0": "nq", "q1": "nq", "coordinates": "nq", "direction": "3nv", "weights": "6", "s": "1"}


def _parse_source(text: str) -> tuple[str, slice]:
    """Column and slice of its lists: ``state[0:7]`` or ``state``."""
    found = re.fullmatch(r"(.+)\[(\d*):(\d*)\]", text)
    if not found:
        return text, slice(None)
    start, stop = (int(number) if number else None for number in found.groups()[1:])
    return found[1], slice(start, stop)


def _empty_batch(schema: Any) -> Any:
    """Batch without rows."""
    return pa.RecordBatch.from_arrays([pa.nulls(0, field.type) for field in schema], schema=schema)
