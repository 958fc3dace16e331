"""Sampling-based control."""

from typing import Any

import numpy as np
import pytest

import robot_dynamics as rd
from robot_dynamics.sampling import Mppi

ROBOT = rd.example("two_r")
UPRIGHT = np.array([np.pi / 2, 0.0])


def cost(q: Any, v: Any, tau: Any) -> Any:
    """Squared distance from the upright pose, summed over the motion."""
    return (1.0 - np.cos(q - UPRIGHT)).sum(axis=(1, 2)) + 0.01 * (v**2).sum(axis=(1, 2))


def control(**changes: Any) -> Mppi:
    options: dict[str, Any] = {"horizon": 25, "dt": 0.02, "samples": 256, "noise": [4.0, 2.0], "seed": 1}
    return Mppi(ROBOT, cost, **{**options, "temperature": 0.5, **changes})


def test_it_holds_an_arm_upright() -> None:
    mine = control(noise=[3.0, 1.5], temperature=0.05)
    q, v = UPRIGHT + [0.1, -0.1], np.zeros(2)
    for _ in range(60):
        q, v = ROBOT.step(q, v, mine.act(q, v), dt=0.02)
    assert np.abs(q - UPRIGHT).max() < 0.1 and np.abs(v).max() < 0.5
    fallen = ROBOT.rollout(UPRIGHT + [0.1, -0.1], np.zeros(2), steps=60, dt=0.02)
    assert np.abs(fallen.q - UPRIGHT).max() > 0.5  # without control it falls


def test_one_round_is_the_weighted_mean_of_its_samples() -> None:
    mine = control(samples=5, group=2, integrator="semi-implicit-euler")
    q, v = np.array([1.0, 0.2]), np.zeros(2)
    found = mine.plan(q, v)
    noise = np.concatenate(
        [np.random.default_rng((1, 0, k)).standard_normal((size, 25, 2)) for k, size in enumerate((2, 2, 1))]
    ) * [4.0, 2.0]
    noise[0] = 0.0
    tau = np.clip(noise, -ROBOT.limits.effort, ROBOT.limits.effort)
    moved = ROBOT.rollout(q, v, tau, steps=25, dt=0.02, stride=1, integrator="semi-implicit-euler")
    costs = cost(moved.q_trajectory, moved.v_trajectory, tau)
    weights = np.exp(-(costs - costs.min()) / 0.5)
    np.testing.assert_allclose(found, np.tensordot(weights, tau, 1) / weights.sum(), rtol=1e-12)
    assert mine.least_cost == costs.min()


def test_the_same_seed_is_the_same_plan_and_torques_keep_their_limits() -> None:
    q, v = [1.0, 0.2], [0.0, 0.0]
    assert np.array_equal(control().plan(q, v), control().plan(q, v))
    assert not np.array_equal(control().plan(q, v), control(seed=2).plan(q, v))
    wild = control(noise=[1e3, 1e3], limits=[3.0, 1.0])
    assert (np.abs(wild.plan(q, v)) <= [3.0, 1.0]).all()


def test_samples_that_fly_off_weigh_nothing() -> None:
    endless = [np.inf, np.inf]
    mine = control(noise=[1e150, 1e150], limits=endless, samples=64)
    found = mine.plan([1.0, 0.2], [0.0, 0.0])
    # The previous plan is the only valid sample.
    assert not found.any() and np.isfinite(mine.least_cost)
    with pytest.raises(ArithmeticError, match="none of 64 samples has a finite cost"):
        mine.plan([1.0, 0.2], [1e200, 0.0])


def test_invalid_options_raise_errors() -> None:
    with pytest.raises(ValueError, match="positive"):
        control(horizon=0)
    options: Any = {"horizon": 2, "dt": 0.1, "samples": 4, "noise": 1.0, "temperature": 1.0, "seed": 1}
    wrong = Mppi(ROBOT, lambda q, v, tau: 0.0, **options)  # type: ignore[arg-type,return-value]
    with pytest.raises(ValueError, match=r"cost gave shape \(\) for 4 motions: it must give \(4,\)"):
        wrong.plan([0.0, 0.0], [0.0, 0.0])
