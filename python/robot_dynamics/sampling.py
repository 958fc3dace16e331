"""Sampling-based control: model predictive path integrals."""

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
"""Costs (n,) of motions q (n, horizon, nq) and v (n, horizon, nv) under torques (n, horizon, nv)."""
Map: TypeAlias = Callable[[Callable[..., Any], Sequence[tuple[Any, ...]]], list[Any]]
"""Function that calls f(robot, *item) for each item and returns the results in order."""


class Mppi:
    """Torques of least cost by a weighted average of random samples (MPPI).

    Samples uₖ = u + εₖ surround the planned torques u (horizon, nv). Their standard deviations are `noise`,
    and they are clipped to `limits`. Each is rolled out from the state of the robot. Then u becomes Σ wₖ uₖ /
    Σ wₖ with wₖ = exp(−(cost − least cost) / `temperature`).

    Samples are drawn, rolled out and summed in groups, each with separate random numbers. So the plan has the
    same bits wherever a group is computed.

    The effects and the method are those of `Robot.rollout`. If everything that matters is smooth,
    ``integrator="semi-implicit-euler"`` is fastest. It integrates many samples at once, without position
    limits and contact.

    The method is that of Williams, Aldrich, Theodorou, *Model Predictive Path Integral Control*, 2017,
    without its cost of the noise.

    Parameters
    ----------
    robot : Robot
        Robot to control.
    cost : callable
        Function of the states after each step, q (n, horizon, nq) and v (n, horizon, nv), and of the torques
        (n, horizon, nv). It returns the costs (n,). A motion with a cost that is not finite has weight 0.
    horizon : int
        Number of steps of a plan.
    dt : float
        Step size [s].
    samples : int
        Number of samples of each round.
    noise : array_like, shape (nv,) or scalar
        Standard deviations of the samples [N·m or N].
    temperature : float
        Difference of costs that changes a weight by the factor e.
    seed : int
        Seed of the random numbers.
    limits : array_like, shape (nv,), optional
        Limits of the magnitude of τ [N·m or N]; default: the effort limits of the robot.
    integrator : str, optional
        Method; see `Robot.simulate`.
    conservative : bool
        Whether to leave out damping, friction, limits, actuators and contact.
    without : sequence of str
        Effects to leave out; see `Robot.simulate`.
    dissipation : bool
        Whether damping and friction act.
    group : int
        Number of samples of a group.
    run : callable, optional
        Function that computes the groups, such as `robot_dynamics.ray.Workers.map` for a cluster. Default:
        all cores of this process.

    Raises
    ------
    ValueError
        A number that must be positive is not.

    Examples
    --------
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
        """Current plan (horizon, nv) [N·m or N], which may be changed."""
        self.least_cost = np.inf
        """Least cost of the samples of the last round."""
        bound = robot.limits.effort if limits is None else np.asarray(limits, np.float64)
        deviations = np.broadcast_to(np.asarray(noise, np.float64), (robot.nv,))
        options: dict[str, Any] = {"steps": horizon, "dt": dt, "integrator": integrator, "dissipation": dissipation}
        # The samples are clipped to `limits` instead.
        options |= {"conservative": conservative, "without": [*without, "effort-limits"]}
        self._sample_group = _SampleGroup(cost, deviations, np.broadcast_to(bound, (robot.nv,)), temperature, options)
        self._sizes = [min(group, samples - start) for start in range(0, samples, group)]
        self._seed, self._round = seed, 0
        self._temperature = temperature
        self._run = self._here if run is None else run

    def plan(self, q: Numbers, v: Numbers) -> Array:
        """Improve the plan for a state by one round of samples.

        Parameters
        ----------
        q : array_like, shape (nq,)
            Configuration.
        v : array_like, shape (nv,)
            Velocity [rad/s or m/s].

        Returns
        -------
        ndarray, shape (horizon, nv)
            The plan [N·m or N].

        Raises
        ------
        ArithmeticError
            No sample has a finite cost.
        ValueError
            The cost function returns a wrong shape.
        """
        start = (np.asarray(q, np.float64), np.asarray(v, np.float64), self.torques)
        groups = [(*start, (self._seed, self._round, k), size) for k, size in enumerate(self._sizes)]
        results = self._run(self._sample_group, groups)
        self._round += 1
        self.least_cost = min(least for least, _, _ in results)
        if not np.isfinite(self.least_cost):
            raise ArithmeticError(
                f"none of {sum(self._sizes)} samples has a finite cost; use less noise or a shorter step"
            )
        # The fixed order of the groups gives the sums the same bits.
        weight, total = 0.0, np.zeros_like(self.torques)
        for least, own_weight, own_total in results:
            factor = np.exp((self.least_cost - least) / self._temperature)
            weight += factor * own_weight
            total += factor * own_total
        self.torques = total / weight
        return self.torques.copy()

    def act(self, q: Numbers, v: Numbers) -> Array:
        """Torques of the next step: improve the plan, and shift it by one step. The last torques are
        repeated.

        Parameters
        ----------
        q : array_like, shape (nq,)
            Configuration.
        v : array_like, shape (nv,)
            Velocity [rad/s or m/s].

        Returns
        -------
        ndarray, shape (nv,)
            Torques [N·m or N].

        Raises
        ------
        ArithmeticError
            No sample has a finite cost.
        """
        first: Array = self.plan(q, v)[0]
        self.torques = np.concatenate([self.torques[1:], self.torques[-1:]])
        return first

    def motion(self, q: Numbers, v: Numbers, torques: Numbers | None = None) -> tuple[Array, Array, Array]:
        """Motion under a plan.

        Parameters
        ----------
        q : array_like, shape (nq,)
            Initial configuration.
        v : array_like, shape (nv,)
            Initial velocity [rad/s or m/s].
        torques : array_like, shape (horizon, nv), optional
            Plan [N·m or N]; default: the current one.

        Returns
        -------
        q : ndarray, shape (horizon, nq)
            Configurations after each step.
        v : ndarray, shape (horizon, nv)
            Velocities after each step [rad/s or m/s].
        tau : ndarray, shape (horizon, nv)
            The plan [N·m or N].

        Raises
        ------
        BadStatesError
            `q` or `v` is invalid, or the motion diverges.
        ShapeError
            An array has the wrong shape.
        """
        tau = self.torques if torques is None else np.asarray(torques, np.float64)
        states = self.robot.rollout(q, v, tau, stride=1, **self._sample_group.options)
        return states.q_trajectory, states.v_trajectory, tau

    def _here(self, function: Callable[..., Any], items: Sequence[tuple[Any, ...]]) -> list[Any]:
        return [function(self.robot, *item) for item in items]


class _SampleGroup:
    """Function that computes one group of samples. It can be pickled."""

    def __init__(self, cost: Cost, noise: Array, limits: Array, temperature: float, options: dict[str, Any]) -> None:
        self.cost, self.noise, self.limits, self.temperature, self.options = cost, noise, limits, temperature, options

    def __call__(self, robot: Robot, q: Array, v: Array, plan: Array, seed: Sequence[int], size: int) -> tuple[float, float, Array]:
        """Least cost c of the group, Σ w and Σ w u, with w = exp(−(cost − c) / temperature)."""
        noise = np.random.default_rng(seed).standard_normal((size, *plan.shape)) * self.noise
        if seed[-1] == 0:
            noise[0] = 0.0  # the first sample is the plan itself
        tau = np.clip(plan + noise, -self.limits, self.limits)
        states = np.broadcast_to(q, (size, len(q)))
        try:
            moved = robot.rollout(states, v, tau, stride=1, **self.options)
        except BadStatesError as error:  # diverged samples are NaN
            moved = error.result
        with np.errstate(invalid="ignore", over="ignore"):
            costs = np.asarray(self.cost(moved.q_trajectory, moved.v_trajectory, tau), np.float64)
        if costs.shape != (size,):
            raise ValueError(f"cost gave shape {costs.shape} for {size} motions: it must give ({size},)")
        costs = np.where(np.isfinite(costs), costs, np.inf)
        least = float(costs.min())
        if least == np.inf:
            return least, 0.0, np.zeros_like(plan)
        weights = np.exp((least - costs) / self.temperature)
        return least, float(weights.sum()), np.einsum("k,kij->ij", weights, tau)
