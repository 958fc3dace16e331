"""Energy accounts of recorded motion."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from robot_dynamics.errors import ColumnError
from robot_dynamics.quantities import AUDIT


def energy_accounts(audited: Any, *, time: str = "timestamp", episode: str = "episode_index") -> Any:
    """Compute the energy account of each episode of recorded motion, from its audit.

    Integrals use the trapezoidal rule. Each row of the result has:

    - `rows` and `duration` [s],
    - `energy_start` and `energy_end` [J],
    - `work` of the motors and the `dissipated` energy [J],
    - `imbalance`, the largest |E − E₀ − work + dissipated| [J],
    - `energy_moved`, max K + max V − min V [J], as a scale for the imbalance,
    - `torque_residual` (nv,), the root mean square of the residual [N·m or N].

    Parameters
    ----------
    audited : Arrow table
        Columns of the quantity ``audit``, `time` and `episode`. The rows of an episode are ordered by time
        and need not be adjacent.
    time : str
        Column of the time [s].
    episode : str
        Column of the episode.

    Returns
    -------
    pyarrow.Table
        One row for each episode.

    Raises
    ------
    ColumnError
        A column is missing or has nulls, or the time of an episode does not increase.

    Examples
    --------
    >>> import pyarrow as pa
    >>> from robot_dynamics import arrow
    >>> robot = rd.example("two_r")
    >>> motion = robot.simulate([0.3, 0.2], duration=1.0, dt=1e-3)
    >>> a = robot.forward_dynamics(motion.q, motion.v, motion.tau)
    >>> recorded = pa.table({
    ...     **{name: list(x) for name, x in (("q", motion.q), ("v", motion.v), ("a", a), ("tau", motion.tau))},
    ...     "timestamp": motion.times, "episode_index": np.zeros(len(motion.times), np.int64)})
    >>> accounts = arrow.energy_accounts(arrow.compute(robot, recorded, "audit", keep=["timestamp", "episode_index"]))
    >>> accounts["imbalance"][0].as_py() < 1e-8 * accounts["energy_moved"][0].as_py()
    True
    """
    table = audited if isinstance(audited, pa.Table) else pa.table(audited)
    needed = [time, episode, *(f"audit.{name}" for name in AUDIT)]
    missing = [name for name in needed if name not in table.column_names]
    if missing:
        raise ColumnError(f"no columns {missing} for energy accounts; there are {table.column_names}")
    table = table.select(needed).combine_chunks()
    null = [name for name in needed if table[name].null_count]
    if null:
        raise ColumnError(f"columns {null} have nulls: an energy account needs every row of an episode, leave such episodes out")
    batches = table.to_batches()
    accounts = [account for batch in batches[:1] for account in _accounts(batch, time, episode)]
    kinds = dict.fromkeys(_FIELDS, pa.float64()) | {"rows": pa.int64(), "torque_residual": pa.list_(pa.float64())}
    return pa.Table.from_pylist(accounts, pa.schema([(episode, table.schema.field(episode).type), *kinds.items()]))


_FIELDS = (
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


def _accounts(batch: Any, time: str, episode: str) -> Iterator[dict[str, Any]]:
    """Account of each episode of a batch, in the order of the episodes."""
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
    """Lists of equal length as an array (rows, length)."""
    numbers: NDArray[np.float64] = column.flatten().to_numpy().astype(np.float64)
    return numbers.reshape(len(column), -1)


def _integral(t: NDArray[np.float64], power: NDArray[np.float64]) -> NDArray[np.float64]:
    """∫ power dt from the first row to each row, by the trapezoidal rule."""
    steps: NDArray[np.float64] = np.diff(t) * (power[1:] + power[:-1]) / 2.0
    return np.concatenate([[0.0], np.cumsum(steps)])
