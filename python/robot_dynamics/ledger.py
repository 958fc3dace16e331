"""The energy's books of recorded motion."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from robot_dynamics.errors import ColumnError
from robot_dynamics.quantities import AUDIT


def ledger(audited: Any, *, time: str = "timestamp", episode: str = "episode_index") -> Any:
    """The energy's books of each episode of recorded motion, from its audit and the time of each row [s].

    `audited` is a table with the columns of the quantity ``audit``, `time` and `episode`; the rows of an
    episode are in the order of time, and need not lie side by side. Of each episode: `rows`, `duration` [s],
    `energy_start`, `energy_end`, `work` of the motors, what was `dissipated`, the largest `imbalance` |E − E₀
    − work + dissipated| [J], all by the trapezoidal rule, `energy_moved`, max K + max V − min V, to compare
    it with, and `torque_residual` (nv), its root mean square.

    >>> import pyarrow as pa
    >>> from robot_dynamics import arrow
    >>> robot = rd.example("two_r")
    >>> motion = robot.simulate([0.3, 0.2], duration=1.0, step=1e-3)
    >>> a = robot.forward_dynamics(motion.q, motion.v, motion.tau)
    >>> recorded = pa.table({
    ...     **{name: list(x) for name, x in (("q", motion.q), ("v", motion.v), ("a", a), ("tau", motion.tau))},
    ...     "timestamp": motion.times, "episode_index": np.zeros(len(motion.times), np.int64)})
    >>> books = arrow.ledger(arrow.compute(robot, recorded, "audit", keep=["timestamp", "episode_index"]))
    >>> books["imbalance"][0].as_py() < 1e-8 * books["energy_moved"][0].as_py()
    True
    """
    table = audited if isinstance(audited, pa.Table) else pa.table(audited)
    needed = [time, episode, *(f"audit.{name}" for name in AUDIT)]
    missing = [name for name in needed if name not in table.column_names]
    if missing:
        raise ColumnError(f"no columns {missing} for a ledger; there are {table.column_names}")
    table = table.select(needed).combine_chunks()
    null = [name for name in needed if table[name].null_count]
    if null:
        raise ColumnError(f"columns {null} have nulls: a ledger needs every row of an episode, leave such episodes out")
    batches = table.to_batches()
    books = [book for batch in batches[:1] for book in _books(batch, time, episode)]
    kinds = dict.fromkeys(_BOOKS, pa.float64()) | {"rows": pa.int64(), "torque_residual": pa.list_(pa.float64())}
    return pa.Table.from_pylist(books, pa.schema([(episode, table.schema.field(episode).type), *kinds.items()]))


_BOOKS = (
    "rows",
    "duration",
    "energy_start",
    "energy_end",
    "work",
    "dissipated",
    "imbalance",
    "energy_moved",
    "torque_residual",
)


def _books(batch: Any, time: str, episode: str) -> Iterator[dict[str, Any]]:
    """The books of each episode of a batch, in the order of their names."""
    numbers = {name: batch[f"audit.{name}"].to_numpy().astype(np.float64) for name in AUDIT[:-1]}
    residuals = _lists(batch["audit.torque_residual"])
    times = batch[time].cast(pa.float64()).to_numpy()
    names = batch[episode].to_numpy(zero_copy_only=False)
    order = np.argsort(names, kind="stable")
    begins = np.flatnonzero(names[order][1:] != names[order][:-1]) + 1
    for rows in np.split(order, begins):
        own = {name: column[rows] for name, column in numbers.items()}
        t, K, V = times[rows], own["kinetic_energy"], own["potential_energy"]
        name = batch[episode][int(rows[0])].as_py()
        if not (np.diff(t) > 0.0).all():
            raise ColumnError(f"episode {name}: column `{time}` does not increase from row to row")
        work, dissipated = (_integral(t, own[each]) for each in ("power", "dissipated_power"))
        energy = K + V
        yield {
            episode: name,
            "rows": len(rows),
            "duration": t[-1] - t[0],
            "energy_start": energy[0],
            "energy_end": energy[-1],
            "work": work[-1],
            "dissipated": dissipated[-1],
            "imbalance": np.abs(energy - energy[0] - work + dissipated).max(),
            "energy_moved": K.max() + np.ptp(V),
            "torque_residual": np.sqrt((residuals[rows] ** 2).mean(axis=0)),
        }


def _lists(column: Any) -> NDArray[np.float64]:
    """Lists of one length as an array (rows, length)."""
    numbers: NDArray[np.float64] = column.flatten().to_numpy().astype(np.float64)
    return numbers.reshape(len(column), -1)


def _integral(t: NDArray[np.float64], power: NDArray[np.float64]) -> NDArray[np.float64]:
    """∫ power dt from the first row to each, by the trapezoidal rule."""
    steps: NDArray[np.float64] = np.diff(t) * (power[1:] + power[:-1]) / 2.0
    return np.concatenate([[0.0], np.cumsum(steps)])
