"""Gymnasium's environments: its rules, the physics behind them, and that something learns in them."""

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robot_dynamics as rd

gymnasium = pytest.importorskip("gymnasium")

from robot_dynamics.gym import PENDULUM, Reach, RobotEnv, SwingUp  # noqa: E402

TASKS = [SwingUp(7, horizon=5), Reach(7, horizon=5), Reach(7, rd.example("panda"), "panda_link8", horizon=5)]


@pytest.mark.parametrize("envs", TASKS, ids=["swing-up", "reach", "panda"])
def test_the_rules_of_vectors_hold(envs: RobotEnv) -> None:
    first, info = envs.reset(seed=3)
    assert envs.observation_space.contains(first) and info == {}
    assert envs.single_action_space.shape == (envs.robot.nv,)
    random = np.random.default_rng(1)
    actions = random.uniform(-1.5, 1.5, (12, 7, envs.robot.nv))  # some of them clipped

    def run() -> list[Any]:
        return [envs.reset(seed=3), *(envs.step(action) for action in actions)]

    once, again = run(), run()
    for one, other in zip(once, again, strict=True):
        for x, y in zip(one, other, strict=True):
            assert np.array_equal(x, y) if isinstance(x, np.ndarray) else x == y
    for k, (seen, rewards, terminated, truncated, _) in enumerate(once[1:]):
        assert envs.observation_space.contains(seen) and rewards.shape == (7,)
        # Five steps, then one that starts anew, with no reward.
        assert truncated.tolist() == [k % 6 == 4] * 7 and not terminated.any()
        assert (rewards == 0.0).all() == (k % 6 == 5) and (rewards <= 0.0).all()
    assert not np.array_equal(envs.reset()[0], first)  # without a seed it goes on


def test_a_step_is_a_rollout_under_the_torque() -> None:
    envs = SwingUp(3, step=0.01, substeps=4)
    envs.reset(seed=1)
    q, v = envs.q.copy(), envs.v.copy()
    seen, rewards, _, _, _ = envs.step(np.array([[0.5], [-3.0], [0.0]]))
    end = rd.loads(PENDULUM).rollout(q, v, 2.0 * np.array([[0.5], [-1.0], [0.0]]), steps=4, step=0.01, dissipation=True)
    assert np.array_equal(envs.q, end.q) and np.array_equal(envs.v, end.v)
    away = np.arctan2(-np.sin(end.q[:, 0]), -np.cos(end.q[:, 0]))
    assert_allclose(rewards, -(away**2 + 0.1 * end.v[:, 0] ** 2 + 0.001 * np.array([1.0, 4.0, 0.0])), rtol=1e-12)
    assert_allclose(seen[:, 0], -np.cos(end.q[:, 0]), rtol=1e-6)
    assert_allclose(np.hypot(seen[:, 0], seen[:, 1]), 1.0, rtol=1e-6)


def test_the_motor_cannot_lift_it() -> None:
    envs = SwingUp(1, within=0.0, horizon=10**4)
    envs.reset(seed=1)
    highest = max(float(np.abs(envs.q).max()) for _ in range(1000) if envs.step(np.ones((1, 1))))
    assert 0.5 < highest < np.pi / 2


def test_what_blows_up_ends_alone() -> None:
    envs = SwingUp(4)
    envs.reset(seed=1)
    envs.v[0], envs.v[2] = 2e4, 1e200
    seen, _, terminated, truncated, _ = envs.step(np.zeros((4, 1)))
    assert terminated.tolist() == [True, False, True, False] and not truncated.any()
    assert np.isfinite(envs.q).all()
    _, rewards, terminated, _, _ = envs.step(np.zeros((4, 1)))
    assert not terminated.any() and rewards[2] == 0.0 and np.abs(envs.v).max() < 10.0


def test_targets_can_be_reached() -> None:
    # Joint velocities that bring the frame there, by damped least squares, and torques M (v* − v)/T for them.
    envs = Reach(32, rd.example("panda"), "panda_link8", horizon=10**6)
    envs.reset(seed=5)
    start = np.linalg.norm(envs.target - envs.tip(), axis=1)
    for _ in range(400):
        jacobian = envs.robot.frame_jacobian_world_aligned(envs.q, envs.frame)[:, :3]
        gram = jacobian @ jacobian.transpose(0, 2, 1) + 1e-2 * np.eye(3)
        wanted = np.linalg.solve(gram, 2.0 * (envs.target - envs.tip())[..., np.newaxis])
        error = (jacobian.transpose(0, 2, 1) @ wanted)[..., 0] - envs.v
        tau = np.einsum("nij,nj->ni", envs.robot.mass_matrix(envs.q), error) / 0.1
        envs.step(tau / envs.effort)
    end = np.linalg.norm(envs.target - envs.tip(), axis=1)
    assert (end < 0.02 + 0.1 * start).mean() > 0.9


def test_tasks_are_made_by_name_and_say_what_they_need() -> None:
    envs = gymnasium.make_vec("robot_dynamics/Reach-v0", num_envs=3, horizon=10)
    assert isinstance(envs.unwrapped, Reach) and envs.unwrapped.horizon == 10
    assert envs.metadata["autoreset_mode"] is gymnasium.vector.AutoresetMode.NEXT_STEP
    with pytest.raises(rd.DescriptionError, match="a pendulum has one"):
        SwingUp(2, rd.example("two_r"))
    with pytest.raises(rd.DescriptionError, match="quaternions"):
        Reach(2, rd.example("quadruped", floating_base=True))
    with pytest.raises(rd.DescriptionError, match="give effort="):
        SwingUp(2, rd.loads(PENDULUM.replace('effort="2"', 'effort="inf"')))
    with pytest.raises(ValueError, match=r"actions have shape \(2,\), they must have \(2, 1\)"):
        SwingUp(2).step(np.zeros(2))
