"""Ray: a robot's quantities, rollouts, sampling-based control and environments, on all machines of a cluster.

Needs Ray (``pip install robot-dynamics[ray]``), which starts, feeds and restarts the workers. Each worker is
a process with one thread that keeps the robot. Results depend on the states alone. So they have the same bits
for any number of workers, on processors with the same instructions. Ray restarts a worker that dies and
repeats its work, on another machine if necessary.

    import ray
    from robot_dynamics.ray import Workers, compute

    states = ray.data.read_parquet("s3://recordings")       # columns q, v, a, tau
    torques = compute(states, robot, "inverse_dynamics")     # lazy; any quantity, also `audit`
    torques.write_parquet("s3://torques")                    # streams with bounded memory

    workers = Workers(robot)
    ends = workers.rollout(q, v, tau, steps=1000, dt=1e-3)

`Environments` are the environments of `robot_dynamics.gym` on actors.
"""

from __future__ import annotations

import logging
import os
import pickle
import time
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from dataclasses import fields
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

import robot_dynamics as rd
from robot_dynamics.arrow import Computation
from robot_dynamics.motion import Rollout
from robot_dynamics.numbers import Numbers
from robot_dynamics.robot import Robot

try:
    import ray
    import ray.data
    import ray.exceptions
except ImportError:
    raise ImportError("robot_dynamics.ray needs Ray: pip install robot-dynamics[ray]") from None

from robot_dynamics.ray_environments import Collected as Collected  # noqa: E402 (it needs Ray)
from robot_dynamics.ray_environments import Environments as Environments  # noqa: E402
from robot_dynamics.ray_environments import core_count as _core_count  # noqa: E402

if TYPE_CHECKING:
    from robot_dynamics.parquet import Counter, Job, Part, Runner

T = TypeVar("T")
_remote: Any = ray.remote
_ANSWER_LIMIT = 10.0
"""Time without an answer after which calls are repeated on other workers [s]."""


class Compute:
    """Callable that `compute` maps over the batches of a data set, with one thread. Ray creates copies of it.

    For your own pipelines: ``dataset.map_batches(Compute, fn_constructor_args=[computation],
    batch_format="pyarrow", ...)``.

    Parameters
    ----------
    computation : Computation
        Quantities to compute.
    """

    def __init__(self, computation: Computation) -> None:
        rd.set_num_threads(1)
        self._computation = computation

    def __call__(self, batch: Any) -> Any:
        """Compute the quantities of a batch.

        Parameters
        ----------
        batch : pyarrow.Table
            States.

        Returns
        -------
        pyarrow.Table
            The kept columns, then the results.
        """
        return self._computation(batch)


def compute(dataset: Any, robot: Robot, *quantities: str, workers: int | None = None, **options: Any) -> Any:
    """Compute quantities of the rows of a data set, lazily as usual for pipelines of Ray.

    Ray determines the order of the rows. `keep` a column that identifies them, or set `preserve_order` in
    Ray's execution options.

    Parameters
    ----------
    dataset : ray.data.Dataset
        States.
    robot : Robot
        Robot to compute the quantities of.
    *quantities : str
        Names of quantities; see `robot_dynamics.arrow.Computation`.
    workers : int, optional
        Number of processes; default: up to the number of cores.
    **options
        Options of `robot_dynamics.arrow.Computation`.

    Returns
    -------
    ray.data.Dataset
        The kept columns, then the results.

    Raises
    ------
    ValueError
        If a quantity or the value of an option is invalid.
    """
    computation = Computation(robot, quantities, **{"threads": 1, **options})
    pool = (
        ray.data.ActorPoolStrategy(size=workers)
        if workers
        else ray.data.ActorPoolStrategy(min_size=1, max_size=_core_count())
    )
    return dataset.map_batches(
        Compute,
        fn_constructor_args=[computation],
        compute=pool,
        num_cpus=1,
        batch_size=None,
        batch_format="pyarrow",
        zero_copy_batch=True,
    )


class Workers:
    """Processes of a cluster that keep a robot, for rollouts and for your own functions.

    A worker that dies is restarted and its work is repeated.

    Parameters
    ----------
    robot : Robot
        Robot that the workers keep.
    workers : int, optional
        Number of workers; default: the number of cores.
    """

    def __init__(self, robot: Robot, workers: int | None = None) -> None:
        self.robot = robot
        self._workers = _start_workers(_Worker, robot, workers or _core_count())

    def __len__(self) -> int:
        return len(self._workers)

    def processes(self) -> list[int]:
        """Process numbers of the workers.

        Returns
        -------
        list of int
            Process numbers.
        """
        found: list[int] = ray.get([worker.process.remote() for worker in self._workers])
        return found

    def map(self, function: Callable[..., T], items: Sequence[tuple[Any, ...]]) -> list[T]:
        """Call a function for each item, in parallel.

        A worker gets its next item when it is done. Random numbers should depend on a seed in the item, not
        on the worker.

        Parameters
        ----------
        function : callable
            Function `f(robot, *item)`.
        items : sequence of tuple
            Arguments of the calls. Arrays are read-only in the workers.

        Returns
        -------
        list
            Results in the order of the items.

        Raises
        ------
        Exception
            The error of the first call that failed.
        """
        sent = ray.put(function)
        results: dict[int, T] = {}
        for number, result in _run_calls(self._workers, [("call", (sent, *item)) for item in items]):
            results[number] = result
        return [results[number] for number in range(len(items))]

    def rollout(
        self, q: Numbers, v: Numbers | None = None, tau: Numbers | None = None, *, group: int = 4096, **options: Any
    ) -> Rollout:
        """`Robot.rollout` of many states by all workers, with the same bits.

        Parameters
        ----------
        q : array_like, shape (n, nq)
            Initial configurations.
        v : array_like, shape (n, nv), optional
            Initial velocities [rad/s or m/s]; default: 0.
        tau : array_like, shape (nv,), (n, nv) or (n, steps, nv), optional
            Torques [N·m or N], held over all steps or given for each step; default: 0.
        group : int
            Number of states in a call of a worker.
        **options
            Options of `Robot.rollout`.

        Returns
        -------
        Rollout
            Final states and trajectories.

        Raises
        ------
        BadStatesError
            Some states have no valid motion; `result` has the others.
        ShapeError
            `q` or `tau` has the wrong shape.
        """
        states = np.asarray(q)
        if states.ndim != 2:
            raise rd.ShapeError(f"q has shape {states.shape}; states for workers are (n, {self.robot.nq})")
        count = len(states)
        velocities = np.zeros((count, self.robot.nv), states.dtype) if v is None else np.asarray(v)
        velocities = np.broadcast_to(velocities, (count, velocities.shape[-1]))
        forces = None if tau is None else np.asarray(tau)
        if forces is not None and forces.ndim == 1:
            forces = np.broadcast_to(forces, (count, len(forces)))
        if forces is not None and len(forces) != count:
            raise rd.ShapeError(f"tau has shape {forces.shape} for {count} states")
        cuts = [slice(start, start + group) for start in range(0, max(count, 1), group)]
        items = [(states[cut], velocities[cut], None if forces is None else forces[cut], options) for cut in cuts]
        parts = self.map(_rollout_group, items)
        names = [field.name for field in fields(Rollout)]
        whole = Rollout(*(_concatenate([getattr(ends, name) for ends, _, _ in parts]) for name in names))
        bad = np.concatenate([cut.start + rows for cut, (_, rows, _) in zip(cuts, parts, strict=True)])
        if len(bad):
            reason = next(reason for _, _, reason in parts if reason)
            message = f"{len(bad)} of {count} states have no rollout, the first is state {bad[0]}: {reason}"
            raise rd.BadStatesError(message, indices=bad, result=whole)
        return whole

    def close(self) -> None:
        """End the workers."""
        for worker in self._workers:
            ray.kill(worker)
        self._workers = []


class _Worker:
    """Process with one thread that keeps a robot."""

    def __init__(self, pickled: bytes) -> None:
        rd.set_num_threads(1)
        self._robot: Robot = pickle.loads(pickled)

    def process(self) -> int:
        return os.getpid()

    def call(self, function: Callable[..., Any], *item: Any) -> Any:
        return function(self._robot, *item)


class _PartWorker:
    """Process with one thread that writes parts of a job."""

    def __init__(self, pickled: bytes) -> None:
        rd.set_num_threads(1)
        self._job: Job = pickle.loads(pickled)

    def write(self, part: Part) -> Part:
        return self._job.write(part)


def by_actors(workers: int | None, address: str, count: Counter | None = None) -> Runner:
    """Create a runner for `robot_dynamics.parquet.run` that uses a Ray cluster.

    Every machine of the cluster must find the files under the same path.

    Parameters
    ----------
    workers : int or None
        Number of workers; default: the number of cores.
    address : str
        Address of the cluster; ``local`` starts one on this machine.
    count : callable, optional
        Function that is called with numbers of new rows.

    Returns
    -------
    callable
        Runner for `robot_dynamics.parquet.run`.

    Raises
    ------
    ConnectionError
        If no cluster answers at the address; the runner raises it when it starts.
    """

    def runner(job: Job, parts: list[Part]) -> Generator[Part, None, None]:
        is_ours = not ray.is_initialized()
        if is_ours:
            here = {"num_cpus": workers, "include_dashboard": False} if address == "local" else {"address": address}
            ray.init(log_to_driver=False, logging_level=logging.ERROR, **here)
        pool: list[Any] = []
        try:
            pool = _start_workers(_PartWorker, job.for_worker(), min(workers or _core_count(), max(len(parts), 1)))
            for number, part in _run_calls(pool, [("write", (part,)) for part in parts]):
                yield part
                if count is not None:
                    count(parts[number].rows)
        finally:
            for worker in pool:  # kill at once, even if other references exist: other jobs need the cores
                ray.kill(worker)
            if is_ours:
                ray.shutdown()

    return runner


def _start_workers(kind: type, kept: Any, count: int) -> list[Any]:
    """Workers that keep an object, and restart if they die.

    The object is pickled once and sent with the request to start a worker. Ray keeps that request longer than
    any machine's shared memory.
    """
    pickled = pickle.dumps(kept)
    actor = _remote(num_cpus=1, max_restarts=-1, max_task_retries=-1)(kind)
    return [actor.remote(pickled) for _ in range(count)]


def _run_calls(workers: Sequence[Any], calls: Iterable[tuple[str, tuple[Any, ...]]]) -> Iterator[tuple[int, Any]]:
    """Call methods of the workers, and yield the number and the result of each call when it is done.

    Each worker has up to two calls at a time. A worker may never start, or its machine may disappear: it
    answers when there is another machine. Meanwhile idle workers repeat its calls, and the first answer
    counts. The results are the same.
    """
    every = list(calls)
    waiting, left = deque(range(len(every))), dict.fromkeys(range(len(every)))
    busy: dict[Any, tuple[int, int, float]] = {}
    load = [0] * len(workers)
    answered: dict[int, float] = {}
    longest, heard = 0.0, time.monotonic()

    def send(number: int, worker: int) -> None:
        method, arguments = every[number]
        busy[getattr(workers[worker], method).remote(*arguments)] = number, worker, time.monotonic()
        load[worker] += 1

    while left:
        for depth in (1, 2):
            for worker in range(len(workers)):
                if waiting and load[worker] < depth:
                    send(waiting.popleft(), worker)
        done, _ = ray.wait(list(busy), num_returns=1, timeout=0.2)
        now = time.monotonic()
        for reference in done:
            number, worker, sent = busy.pop(reference)
            load[worker] -= 1
            if worker in answered:  # the time of the first answer includes the start of the process
                longest = max(longest, now - max(sent, answered[worker]))
            answered[worker] = heard = now
            if number in left:
                del left[number]
                yield number, _result_of(reference)
        if answered and now - heard > max(_ANSWER_LIMIT, 3.0 * longest):
            idle = [worker for worker in range(len(workers)) if load[worker] == 0]
            for number, worker in zip(left, idle, strict=False):
                send(number, worker)
            heard = now


def _result_of(reference: Any) -> Any:
    """Result of a call, or the exception that the worker raised."""
    try:
        return ray.get(reference)
    except ray.exceptions.RayTaskError as error:
        raise error.cause from None


def _rollout_group(robot: Robot, q: Any, v: Any, tau: Any, options: dict[str, Any]) -> tuple[Rollout, Any, str]:
    """Rollout of states, the indices of invalid ones, and the reason."""
    try:
        ends = robot.rollout(q, v, tau, **{"threads": 1, **options})
    except rd.BadStatesError as error:
        return error.result, error.indices, str(error)
    return ends, np.zeros(0, np.intp), ""


def _concatenate(parts: Sequence[NDArray[Any]]) -> NDArray[Any]:
    return np.concatenate(parts) if len(parts) > 1 else parts[0]
