"""Ray: a robot's quantities, rollouts and control by sampling, on all machines of a cluster.

Needs Ray (``pip install robot-dynamics[ray]``), which starts, feeds and restarts the workers. Each is a
process of one thread that keeps the robot; it was sent once. What is computed depends on the states alone, so
results have the same bits for any number of workers, on processors with the same instructions. A worker that
dies is started again and its work done once more, by others where there is no machine for it: nothing is
lost.

    import ray
    from robot_dynamics.ray import Workers, compute

    states = ray.data.read_parquet("s3://recordings")       # columns q, v, a, tau
    torques = compute(states, robot, "inverse_dynamics")     # any quantity, and `audit`; nothing is computed
    yet torques.write_parquet("s3://torques")                    # streams: no more in memory than is under
    way

    workers = Workers(robot)
    ends = workers.rollout(q, v, tau, steps=1000, dt=1e-3)
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

if TYPE_CHECKING:
    from robot_dynamics.parquet import Counter, Job, Part, Runner

T = TypeVar("T")
_remote: Any = ray.remote
_PATIENCE = 10.0
"""After so many seconds without an answer what was asked is asked again, of others [s]."""


class Compute:
    """What `compute` maps over the batches of a data set: a `Computation` by one thread, of which Ray keeps
    copies.

    For pipelines of your own: ``dataset.map_batches(Compute, fn_constructor_args=[computation],
    batch_format="pyarrow", ...)``.
    """

    def __init__(self, computation: Computation) -> None:
        rd.set_num_threads(1)
        self._computation = computation

    def __call__(self, batch: Any) -> Any:
        """The quantities of a batch, which is only read."""
        return self._computation(batch)


def compute(dataset: Any, robot: Robot, *quantities: str, workers: int | None = None, **options: Any) -> Any:
    """Quantities of the rows of a `ray.data.Dataset`, as one; `options` as in
    `robot_dynamics.arrow.Computation`.

    Lazy, as pipelines of Ray are. By `workers` processes, as many as there are cores where not given. The
    order of the rows is Ray's; `keep` a column that tells them apart, or set `preserve_order` in Ray's
    execution options.
    """
    computation = Computation(robot, quantities, **{"threads": 1, **options})
    pool = (
        ray.data.ActorPoolStrategy(size=workers)
        if workers
        else ray.data.ActorPoolStrategy(min_size=1, max_size=_cores())
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
    """Processes of a cluster that keep a robot, for rollouts and for functions of your own.

    As many as there are cores where `workers` is not given. A worker that dies is started again, its work
    done again.
    """

    def __init__(self, robot: Robot, workers: int | None = None) -> None:
        self.robot = robot
        self._workers = _started(_Worker, robot, workers or _cores())

    def __len__(self) -> int:
        return len(self._workers)

    def processes(self) -> list[int]:
        """The workers' process numbers."""
        found: list[int] = ray.get([worker.process.remote() for worker in self._workers])
        return found

    def map(self, function: Callable[..., T], items: Sequence[tuple[Any, ...]]) -> list[T]:
        """function(robot, *item) of each item, in their order; arrays come in read-only.

        Who is done gets the next. Random numbers should be seeded by the item, not by the worker.
        """
        sent = ray.put(function)
        results: dict[int, T] = {}
        for number, result in _served(self._workers, [("call", (sent, *item)) for item in items]):
            results[number] = result
        return [results[number] for number in range(len(items))]

    def rollout(
        self, q: Numbers, v: Numbers | None = None, tau: Numbers | None = None, *, group: int = 4096, **options: Any
    ) -> Rollout:
        """`Robot.rollout` of many states q (n, nq), v (n, nv), by all workers, a `group` at a time: the same
        bits.

        tau is (nv,) or (n, nv), held over all steps, or (n, steps, nv), one for each; `options` as there.
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
        parts = self.map(_rolled_out, items)
        names = [field.name for field in fields(Rollout)]
        whole = Rollout(*(_joined([getattr(ends, name) for ends, _, _ in parts]) for name in names))
        bad = np.concatenate([cut.start + rows for cut, (_, rows, _) in zip(cuts, parts, strict=True)])
        if len(bad):
            reason = next(reason for _, _, reason in parts if reason)
            message = f"{len(bad)} of {count} states have no rollout, the first is state {bad[0]}: {reason}"
            raise rd.BadStatesError(message, indices=bad, result=whole)
        return whole

    def close(self) -> None:
        """Ends the workers."""
        for worker in self._workers:
            ray.kill(worker)
        self._workers = []


class _Worker:
    """One process with one thread and its robot."""

    def __init__(self, pickled: bytes) -> None:
        rd.set_num_threads(1)
        self._robot: Robot = pickle.loads(pickled)

    def process(self) -> int:
        return os.getpid()

    def call(self, function: Callable[..., Any], *item: Any) -> Any:
        return function(self._robot, *item)


class _PartWorker:
    """One process with one thread that writes parts of a job."""

    def __init__(self, pickled: bytes) -> None:
        rd.set_num_threads(1)
        self._job: Job = pickle.loads(pickled)

    def write(self, part: Part) -> Part:
        return self._job.write(part)


def by_actors(workers: int | None, address: str, count: Counter | None = None) -> Runner:
    """A runner for `robot_dynamics.parquet.run` on the Ray cluster at an address; ``local`` starts one on
    this machine.

    The files have to be where every machine of the cluster finds them, under the same path.
    """

    def runner(job: Job, parts: list[Part]) -> Generator[Part, None, None]:
        is_ours = not ray.is_initialized()
        if is_ours:
            here = {"num_cpus": workers, "include_dashboard": False} if address == "local" else {"address": address}
            ray.init(log_to_driver=False, logging_level=logging.ERROR, **here)
        pool: list[Any] = []
        try:
            pool = _started(_PartWorker, job.for_worker(), min(workers or _cores(), max(len(parts), 1)))
            for number, part in _served(pool, [("write", (part,)) for part in parts]):
                yield part
                if count is not None:
                    count(parts[number].rows)
        finally:
            for worker in pool:  # now, whoever still knows of them: others need the cores
                ray.kill(worker)
            if is_ours:
                ray.shutdown()

    return runner


def _started(kind: type, kept: Any, count: int) -> list[Any]:
    """Workers that keep something, and are started again whenever they die.

    It is pickled once, and travels with the orders to start: these outlive any machine's shared memory.
    """
    pickled = pickle.dumps(kept)
    actor = _remote(num_cpus=1, max_restarts=-1, max_task_retries=-1)(kind)
    return [actor.remote(pickled) for _ in range(count)]


def _served(workers: Sequence[Any], calls: Iterable[tuple[str, tuple[Any, ...]]]) -> Iterator[tuple[int, Any]]:
    """Calls methods of the workers, and gives number and result of each call as it is done; two wait at each
    worker.

    A worker whose machine is gone, or that never found one, answers when there is another. Meanwhile what it
    was given is given to others that have nothing to do: whoever is first counts, the results are the same.
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
            if worker in answered:  # the first answer has the start of the process in it
                longest = max(longest, now - max(sent, answered[worker]))
            answered[worker] = heard = now
            if number in left:
                del left[number]
                yield number, _got(reference)
        if answered and now - heard > max(_PATIENCE, 3.0 * longest):
            idle = [worker for worker in range(len(workers)) if load[worker] == 0]
            for number, worker in zip(left, idle, strict=False):
                send(number, worker)
            heard = now


def _got(reference: Any) -> Any:
    """A result, or the error as it was raised in the worker."""
    try:
        return ray.get(reference)
    except ray.exceptions.RayTaskError as error:
        raise error.cause from None


def _rolled_out(robot: Robot, q: Any, v: Any, tau: Any, options: dict[str, Any]) -> tuple[Rollout, Any, str]:
    """Where states come, those of them that are bad, and why."""
    try:
        ends = robot.rollout(q, v, tau, **{"threads": 1, **options})
    except rd.BadStatesError as error:
        return error.result, error.indices, str(error)
    return ends, np.zeros(0, np.intp), ""


def _joined(parts: Sequence[NDArray[Any]]) -> NDArray[Any]:
    return np.concatenate(parts) if len(parts) > 1 else parts[0]


def _cores() -> int:
    """The cores of the cluster."""
    if not ray.is_initialized():
        ray.init()
    resources: Any = ray.cluster_resources  # untyped
    return max(int(resources().get("CPU", 1)), 1)
