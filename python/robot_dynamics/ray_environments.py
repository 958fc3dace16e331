"""Environments on the actors of a Ray cluster; use it as `robot_dynamics.ray.Environments`."""

from __future__ import annotations

import os
import pickle
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import ray
import ray.exceptions
from numpy.typing import NDArray

import robot_dynamics as rd

_remote: Any = ray.remote
_ATTEMPTS = 5
"""Processes that may die in a row during one call before the call fails."""

Policy = Callable[[NDArray[np.float32], np.random.Generator], Any]
"""Function of observations and of random numbers that returns actions."""


class Collected(NamedTuple):
    """Steps of all environments with a policy."""

    observations: NDArray[np.float32]
    """Observations before each step (steps, environments, observations)."""
    actions: NDArray[np.float32]
    """Actions of the policy (steps, environments, actions)."""
    rewards: NDArray[np.float32]
    """Rewards (steps, environments)."""
    terminated: NDArray[np.bool_]
    """Whether an episode ended with failure in a step (steps, environments)."""
    truncated: NDArray[np.bool_]
    """Whether an episode ended without failure in a step (steps, environments)."""
    following: NDArray[np.float32]
    """Observations after the last step (environments, observations)."""


class _Group:
    """Vector environments with a seed of their own, and what a checkpoint needs to continue them.

    Parameters
    ----------
    make : callable
        Function without arguments that makes the environments.
    seed : int
        Seed of all groups.
    number : int
        Number of this group.
    """

    def __init__(self, make: Callable[[], Any], seed: int, number: int) -> None:
        self.envs, self._make = make(), make
        self._sequences = [np.random.SeedSequence(seed, spawn_key=(number, k)) for k in range(2)]
        self._random = np.random.default_rng(self._sequences[1])
        self._seen: NDArray[np.float32] = np.zeros((self.envs.num_envs, 0), np.float32)
        self._has_tensors = not hasattr(self.envs, "action_space")

    def size(self) -> int:
        """Number of environments."""
        return int(self.envs.num_envs)

    def reset(self) -> NDArray[np.float32]:
        """Make the environments anew, and start an episode in each from the seed of the group."""
        self.envs, self._random = self._make(), np.random.default_rng(self._sequences[1])
        seen = self.envs.reset(seed=int(self._sequences[0].generate_state(1, np.uint64)[0] >> 1))
        self._seen = seen.cpu().numpy() if self._has_tensors else seen[0]
        return self._seen

    def step(self, actions: Any) -> tuple[NDArray[Any], ...]:
        """Observations, rewards, failures and other ends of one control step."""
        if self._has_tensors:
            import torch

            given = torch.as_tensor(np.array(actions, np.float32), device=self.envs.device)
            seen, *others = (x.cpu().numpy() for x in self.envs.step(given))
        else:
            seen, *others, _ = self.envs.step(actions)
        self._seen = seen
        rewards, terminated, truncated = others
        return seen, rewards.astype(np.float32), terminated, truncated

    def collect(self, policy: Policy, steps: int) -> Collected:
        """Steps with a policy."""
        rows: list[tuple[NDArray[Any], ...]] = []
        for _ in range(steps):
            before = self._seen
            actions = np.asarray(policy(before, self._random), np.float32)
            rows.append((before, actions, *self.step(actions)[1:]))
        columns = [np.stack(column) for column in zip(*rows, strict=True)]
        return Collected._make([*columns, self._seen])

    def checkpoint(self) -> bytes:
        """All that changes."""
        return pickle.dumps((self.envs.checkpoint(), self._random, self._seen))

    def restore(self, checkpoint: bytes) -> None:
        """Continue from a checkpoint."""
        own, self._random, self._seen = pickle.loads(checkpoint)
        self.envs.restore(own)


class _Host:
    """Process with one thread that keeps some groups."""

    def __init__(self, make: Callable[[], Any], seed: int, numbers: Sequence[int]) -> None:
        rd.set_num_threads(1)
        self._groups = [_Group(make, seed, number) for number in numbers]

    def process(self) -> int:
        return os.getpid()

    def restore(self, checkpoints: Sequence[bytes]) -> None:
        for group, checkpoint in zip(self._groups, checkpoints, strict=True):
            group.restore(checkpoint)

    def call(self, name: str, given: Sequence[tuple[Any, ...]], *shared: Any) -> list[Any]:
        """Call a method of each group with arguments of its own, and with arguments of all."""
        return [getattr(group, name)(*own, *shared) for group, own in zip(self._groups, given, strict=True)]


class _Call(NamedTuple):
    """A call since the last checkpoint."""

    name: str
    given: list[tuple[Any, ...]]
    """Arguments for each group."""
    shared: tuple[Any, ...]
    """Arguments of all groups; large ones are references to Ray's memory."""


class Environments:
    """Groups of vector environments on the actors of a Ray cluster.

    Each group is one object of `robot_dynamics.gym`, such as ``Walk(64)`` or ``DeviceWalk(64)``, with a seed
    that depends on `seed` and on the number of the group. So the results have the same bits for any number of
    workers. Rows of all arrays are in the order of the groups.

    A worker that dies is replaced. Its groups continue from the last checkpoint: the new worker repeats the
    calls since then, and all later results have the bits of a run without the failure. Checkpoints are kept
    in the memory of this process; `save` writes them to a file.

    Parameters
    ----------
    make : callable
        Function without arguments that makes the environments of one group.
    groups : int
        Number of groups.
    workers : int, optional
        Number of worker processes; default: the number of groups, at most that of cores.
    seed : int
        Seed of all random numbers.
    checkpoint_every : int
        Control steps between two checkpoints. Walks with soft contact have other last digits for other
        values; see `RobotEnv.checkpoint`.

    Attributes
    ----------
    num_envs : int
        Number of environments of all groups.
    observations : ndarray, shape (num_envs, observations)
        Last observations.

    Raises
    ------
    ValueError
        A number is not positive.

    Examples
    --------
    ::

        from robot_dynamics.gym import Walk
        from robot_dynamics.ray import Environments

        envs = Environments(lambda: Walk(64), groups=8, seed=1)
        observations = envs.reset()
        observations, rewards, terminated, truncated = envs.step(np.zeros((512, 12)))
        steps = envs.collect(lambda seen, random: random.uniform(-1, 1, (len(seen), 12)), 24)
        envs.save("checkpoint")
    """

    def __init__(
        self, make: Callable[[], Any], groups: int, workers: int | None = None, *, seed: int = 0, checkpoint_every: int = 100
    ) -> None:
        cores = core_count()
        count = min(groups, cores) if workers is None else min(groups, workers)
        if groups < 1 or count < 1 or checkpoint_every < 1:
            raise ValueError(
                f"groups is {groups}, workers {workers} and checkpoint_every {checkpoint_every}; each must be at least 1"
            )
        self._make, self._seed, self._every = ray.put(make), seed, checkpoint_every
        self._numbers = [list(range(worker, groups, count)) for worker in range(count)]
        self._checkpoints: list[bytes | None] = [None] * groups
        self._calls: list[_Call] = []
        self._steps_since = 0
        self._workers = [self._start(worker) for worker in range(count)]
        sizes = self._run(_Call("size", [()] * groups, ()), is_kept=False)
        self.num_envs: int = sum(sizes)
        self._cuts = np.cumsum(sizes)[:-1]
        self.observations: NDArray[np.float32] = np.zeros((self.num_envs, 0), np.float32)

    def __len__(self) -> int:
        return len(self._checkpoints)

    def processes(self) -> list[int]:
        """Process numbers of the workers.

        Returns
        -------
        list of int
            Process numbers.
        """
        found: list[int] = [ray.get(worker.process.remote()) for worker in self._workers]
        return found

    def reset(self) -> NDArray[np.float32]:
        """Start an episode in every environment, from the seeds of the groups.

        Returns
        -------
        ndarray, shape (num_envs, observations)
            Observations.
        """
        self._checkpoints, self._calls, self._steps_since = [None] * len(self), [], 0
        self.observations = np.concatenate(self._run(_Call("reset", [()] * len(self), ())))
        return self.observations

    def step(self, actions: Any) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.bool_], NDArray[np.bool_]]:
        """Take one control step in every environment; see `RobotEnv.step`.

        Parameters
        ----------
        actions : array_like, shape (num_envs, actions)
            Actions.

        Returns
        -------
        observations : ndarray, shape (num_envs, observations)
            Observations.
        rewards : ndarray, shape (num_envs,)
            Rewards.
        terminated : ndarray of bool, shape (num_envs,)
            Whether an episode ended with failure.
        truncated : ndarray of bool, shape (num_envs,)
            Whether an episode ended without failure.

        Raises
        ------
        ValueError
            `actions` has the wrong shape.
        """
        given = np.array(actions)
        if given.ndim != 2 or len(given) != self.num_envs:
            raise ValueError(f"actions have shape {given.shape}, they must have one row for each of {self.num_envs} environments")
        found = self._run(_Call("step", [(own,) for own in np.split(given, self._cuts)], ()), steps=1)
        seen, rewards, terminated, truncated = (np.concatenate(parts) for parts in zip(*found, strict=True))
        self.observations = seen
        return seen, rewards, terminated, truncated

    def collect(self, policy: Policy, steps: int) -> Collected:
        """Take control steps with a policy, which runs in the workers.

        Parameters
        ----------
        policy : callable
            Function `f(observations, random)` that returns actions for the rows of a group. Random numbers
            must come from `random`, a `numpy.random.Generator` of the group.
        steps : int
            Number of control steps.

        Returns
        -------
        Collected
            All steps.

        Raises
        ------
        ValueError
            `steps` is not positive.
        Exception
            The error of the policy; the environments are then as before the call.
        """
        if steps < 1:
            raise ValueError(f"steps is {steps}; it must be at least 1")
        found = self._run(_Call("collect", [()] * len(self), (ray.put(policy), steps)), steps=steps)
        *tables, following = zip(*found, strict=True)
        self.observations = np.concatenate(following)
        columns = [np.concatenate(parts, axis=1) for parts in tables]
        return Collected._make([*columns, self.observations])

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a checkpoint of all groups to a file.

        Parameters
        ----------
        path : path
            File, which is replaced when the new one is complete.

        Raises
        ------
        OSError
            The file cannot be written.
        """
        self._keep()
        whole = {"checkpoints": self._checkpoints, "observations": self.observations}
        target = Path(path)
        temporary = target.with_name(f"{target.name}.{os.getpid()}")
        temporary.write_bytes(pickle.dumps(whole))
        temporary.replace(target)

    def load(self, path: str | os.PathLike[str]) -> NDArray[np.float32]:
        """Continue from a checkpoint of environments that were made in the same way, with the same bits.

        Parameters
        ----------
        path : path
            File that `save` wrote. It is a pickle, which can run code: load only files of your own.

        Returns
        -------
        ndarray, shape (num_envs, observations)
            Last observations.

        Raises
        ------
        ValueError
            The file has another number of groups, or is of other environments.
        """
        whole = pickle.loads(Path(path).read_bytes())
        if len(whole["checkpoints"]) != len(self):
            raise ValueError(f"{os.fspath(path)} has {len(whole['checkpoints'])} groups, not {len(self)}")
        self._run(_Call("restore", [(own,) for own in whole["checkpoints"]], ()), is_kept=False)
        self._checkpoints, self._calls, self._steps_since = whole["checkpoints"], [], 0
        self.observations = whole["observations"]
        return self.observations

    def close(self) -> None:
        """End the workers."""
        for worker in self._workers:
            ray.kill(worker)
        self._workers = []

    def _start(self, worker: int) -> Any:
        """Start a process, which continues from the last checkpoints."""
        numbers = self._numbers[worker]
        actor = _remote(num_cpus=1, max_restarts=0)(_Host).remote(self._make, self._seed, numbers)
        if self._checkpoints[numbers[0]] is not None:
            try:
                ray.get(actor.restore.remote([self._checkpoints[number] for number in numbers]))
            except ray.exceptions.RayTaskError as error:
                raise error.cause from None
            except ray.exceptions.RayActorError:
                pass  # It died, so the next call fails as well and starts another process.
        for call in self._calls:
            self._send(actor, worker, call)
        return actor

    def _replace(self, workers: Sequence[int]) -> None:
        for worker in workers:
            ray.kill(self._workers[worker])
            self._workers[worker] = self._start(worker)

    def _send(self, actor: Any, worker: int, call: _Call) -> Any:
        return actor.call.remote(call.name, [call.given[number] for number in self._numbers[worker]], *call.shared)

    def _run(self, call: _Call, *, steps: int = 0, is_kept: bool = True) -> list[Any]:
        """Results of a call for each group, in the order of the groups.

        Calls of one actor run in their order, so a new process first repeats the calls before this one.
        """
        sent = [self._send(actor, worker, call) for worker, actor in enumerate(self._workers)]
        found: list[Any] = [None] * len(self)
        for worker, numbers in enumerate(self._numbers):
            for number, result in zip(numbers, self._result(worker, sent[worker], call), strict=True):
                found[number] = result
        if is_kept:
            self._calls.append(call)
            self._steps_since += steps
            if self._steps_since >= self._every:
                self._keep()
        return found

    def _result(self, worker: int, reference: Any, call: _Call) -> list[Any]:
        """Result of a worker; another process takes its place if it dies."""
        for attempt in range(1, _ATTEMPTS + 1):
            try:
                result: list[Any] = ray.get(reference)
                return result
            except ray.exceptions.RayTaskError as error:
                # Some groups have taken steps, others have not.
                self._replace(range(len(self._workers)))
                raise error.cause from None
            except ray.exceptions.RayActorError:
                if attempt == _ATTEMPTS:
                    raise
                self._replace([worker])
                reference = self._send(self._workers[worker], worker, call)
        raise AssertionError("unreachable")

    def _keep(self) -> None:
        """Make checkpoints of all groups."""
        found = self._run(_Call("checkpoint", [()] * len(self), ()), is_kept=False)
        self._checkpoints, self._calls, self._steps_since = found, [], 0


def core_count() -> int:
    """Number of cores of the cluster, which is started if necessary."""
    if not ray.is_initialized():
        ray.init()
    resources: Any = ray.cluster_resources  # untyped
    return max(int(resources().get("CPU", 1)), 1)


__all__ = ["Collected", "Environments"]
