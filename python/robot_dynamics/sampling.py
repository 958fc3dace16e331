"""Control by sampling: model predictive path integrals."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from robot_dynamics.errors import BadStatesError
from robot_dynamics.numbers import Numbers
from robot_dynamics.robot import Robot

Array: TypeAlias = NDArray[np.float64]
Cost: TypeAlias = Callable[[Array, Array, Array], Array]
"""The costs (n,) of motions q (n, horizon, nq), v (n, horizon, nv) under torques (n, horizon, nv)."""
Map: TypeAlias = Callable[[Callable[..., Any], Sequence[tuple[Any, ...]]], list[Any]]
"""Calls f(robot, *item) for each item and gives the results in their order."""


class Mppi:
    """Torques that bring a robot where a cost is small, by weighing random ones (MPPI).

    Around planned torques u (horizon, nv) so many `samples` are drawn, uₖ = u + εₖ with the standard
    deviations `noise` (nv,), cut off at `limits` (nv,), those of the robot where not given; each is rolled
    out from the robot's state, and u becomes Σ wₖ uₖ / Σ wₖ with wₖ = exp(−(cost − least cost) /
    `temperature`).

    `cost` is a function of q (n, horizon, nq), v and tau (n, horizon, nv), the states being those after each
    step; a motion whose cost is not finite weighs nothing. Samples are drawn, rolled out and added up in
    groups of `group`, each with random numbers of its own: the plan has the same bits whoever computes a
    group. `run` computes them, all cores of this process where it is not given;
    `robot_dynamics.ray.Workers.map` is a cluster.

    The effects and the method are as in `Robot.rollout`. Where everything that matters is smooth,
    ``integrator="semi-implicit-euler"`` is the quickest: it moves many samples at once, without position
    limits and contact.

    Williams, Aldrich, Theodorou, *Model Predictive Path Integral Control*, 2017, without its price on the
    noise.

    >>> from robot_dynamics.sampling import Mppi
    >>> robot = rd.example("two_r")
    >>> def cost(q, v, tau):  # upright and at rest
    ...     return ((q - [np.pi / 2, 0.0]) ** 2).sum(axis=(1, 2)) + 0.01 * (v**2).sum(axis=(1, 2))
    >>> control = Mppi(robot, cost, horizon=20, dt=0.02, samples=128, noise=[2.0, 1.0], temperature=1.0, seed=1)
    >>> start = [1.0, 0.0], [0.0, 0.0]
    >>> still = control.motion(*start)  # the plan is 0 yet
    >>> plans = [control.plan(*start) for _ in range(2)]
    >>> bool(control.least_cost < cost(*(x[np.newaxis] for x in still))[0])
    True
    """

    def __init__(
        self,
        robot: Robot,
        cost: Cost,
        *,
        horizon: int,
        dt: float,
        samples: int,
        noise: Numbers,
        temperature: float,
        seed: int,
        limits: Numbers | None = None,
        integrator: str | None = None,
        conservative: bool = False,
        without: Sequence[str] = (),
        dissipation: bool = True,
        group: int = 128,
        run: Map | None = None,
    ) -> None:
        if min(horizon, samples, group) < 1 or not (temperature > 0.0 and dt > 0.0):
            raise ValueError("horizon, samples, group, temperature and dt must be positive")
        self.robot = robot
        self.torques: Array = np.zeros((horizon, robot.nv))
        """The plan, (horizon, nv) [N·m or N]; write another start into it."""
        self.least_cost = np.inf
        """Of the samples of the last plan."""
        bound = robot.limits.effort if limits is None else np.asarray(limits, np.float64)
        deviations = np.broadcast_to(np.asarray(noise, np.float64), (robot.nv,))
        options: dict[str, Any] = {"steps": horizon, "dt": dt, "integrator": integrator, "dissipation": dissipation}
        # `limits` are those of the samples.
        options |= {"conservative": conservative, "without": [*without, "effort-limits"]}
        self._sampled = _Sampled(cost, deviations, np.broadcast_to(bound, (robot.nv,)), temperature, options)
        self._sizes = [min(group, samples - start) for start in range(0, samples, group)]
        self._seed, self._round = seed, 0
        self._temperature = temperature
        self._run = self._here if run is None else run

    def plan(self, q: Numbers, v: Numbers) -> Array:
        """Improves the plan for a robot at q (nq,), v (nv,) by one round of samples; gives it, (horizon,
        nv)."""
        start = (np.asarray(q, np.float64), np.asarray(v, np.float64), self.torques)
        groups = [(*start, (self._seed, self._round, k), size) for k, size in enumerate(self._sizes)]
        results = self._run(self._sampled, groups)
        self._round += 1
        self.least_cost = min(least for least, _, _ in results)
        if not np.isfinite(self.least_cost):
            raise ArithmeticError(
                f"none of {sum(self._sizes)} samples has a finite cost: less noise, or a shorter step"
            )
        # Always in the order of the groups: sums have the same bits then.
        weight, total = 0.0, np.zeros_like(self.torques)
        for least, own_weight, own_total in results:
            factor = np.exp((self.least_cost - least) / self._temperature)
            weight += factor * own_weight
            total += factor * own_total
        self.torques = total / weight
        return self.torques.copy()

    def act(self, q: Numbers, v: Numbers) -> Array:
        """The torques (nv,) for the next step: plans, and shifts the plan by a step, whose last torques
        stay."""
        first: Array = self.plan(q, v)[0]
        self.torques = np.concatenate([self.torques[1:], self.torques[-1:]])
        return first

    def motion(self, q: Numbers, v: Numbers, torques: Numbers | None = None) -> tuple[Array, Array, Array]:
        """q, v after each step, and the torques, of a plan: this one, or those given."""
        tau = self.torques if torques is None else np.asarray(torques, np.float64)
        states = self.robot.rollout(q, v, tau, stride=1, **self._sampled.options)
        return states.q_trajectory, states.v_trajectory, tau

    def _here(self, function: Callable[..., Any], items: Sequence[tuple[Any, ...]]) -> list[Any]:
        return [function(self.robot, *item) for item in items]


class _Sampled:
    """One group of samples, as a function that travels."""

    def __init__(self, cost: Cost, noise: Array, limits: Array, temperature: float, options: dict[str, Any]) -> None:
        self.cost, self.noise, self.limits, self.temperature, self.options = cost, noise, limits, temperature, options

    def __call__(self, robot: Robot, q: Array, v: Array, plan: Array, seed: Sequence[int], size: int) -> Any:
        """The least cost c of the group, Σ w and Σ w u with w = exp(−(cost − c) / temperature)."""
        noise = np.random.default_rng(seed).standard_normal((size, *plan.shape)) * self.noise
        if seed[-1] == 0:
            noise[0] = 0.0  # the plan itself is a sample
        tau = np.clip(plan + noise, -self.limits, self.limits)
        states = np.broadcast_to(q, (size, len(q)))
        try:
            moved = robot.rollout(states, v, tau, stride=1, **self.options)
        except BadStatesError as error:  # some flew off to infinity, and are NaN
            moved = error.result
        with np.errstate(invalid="ignore", over="ignore"):
            costs = np.asarray(self.cost(moved.q_trajectory, moved.v_trajectory, tau), np.float64)
        if costs.shape != (size,):
            raise ValueError(f"cost gave shape {costs.shape} for {size} motions: it has to give ({size},)")
        costs = np.where(np.isfinite(costs), costs, np.inf)
        least = float(costs.min())
        if least == np.inf:
            return least, 0.0, np.zeros_like(plan)
        weights = np.exp((least - costs) / self.temperature)
        return least, float(weights.sum()), np.einsum("k,kij->ij", weights, tau)
