"""Walking with steps on a device, and its observation and reward beside those of `Walk`."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robot_dynamics as rd
from robot_dynamics import walking_terms
from robot_dynamics._native import _contact_links
from robot_dynamics.gym import DeviceWalk, Walk, quadruped


def test_points_of_contact_have_links() -> None:
    links = _contact_links(rd.example("quadruped", floating_base=True))
    assert links.count("trunk") == 8 and links.count("front_left_foot") == 1
    assert len(_contact_links(rd.example("panda"))) == 0 or set(_contact_links(rd.example("panda"))) <= set(rd.example("panda").link_names)


def states_of_walk() -> walking_terms.WalkingState:
    """State of environments after some random control steps."""
    envs, random = Walk(6), np.random.default_rng(3)
    envs.reset(seed=2)
    for _ in range(12):
        envs.step(random.uniform(-1.0, 1.0, (6, 12)))
    return envs._state()


def test_terms_are_those_of_tensors() -> None:
    torch: Any = pytest.importorskip("torch")
    own = states_of_walk()
    tensors = {field.name: torch.as_tensor(getattr(own, field.name)) for field in fields(own) if field.name != "xp"}
    other = replace(own, xp=torch, **tensors)
    assert_allclose(walking_terms.observation(other).numpy(), walking_terms.observation(own), rtol=0, atol=1e-12)
    assert np.array_equal(walking_terms.has_failed(other).numpy(), walking_terms.has_failed(own))
    options = (quadruped().phases, 0.5, 0.02)
    expected, found = walking_terms.reward_terms(own, *options), walking_terms.reward_terms(other, *options)
    assert list(found) == list(expected)
    for name, term in expected.items():
        assert_allclose(found[name].numpy(), term, rtol=1e-6, atol=1e-9, err_msg=name)
    assert own.has_contact.any() and (expected["gait"] != 0.0).any()


class TestDeviceWalk:
    """Environments on a device, where PyTorch is installed."""

    def test_the_quadruped_stands(self) -> None:
        torch: Any = pytest.importorskip("torch")
        envs = DeviceWalk(32, device="cpu", horizon=60)
        seen = envs.reset(seed=1)
        assert seen.shape == (32, envs.observations) == (32, 50) and envs.actions == 12
        for k in range(59):
            seen, rewards, terminated, truncated = envs.step(torch.zeros(32, 12))
            assert not terminated.any() and not truncated.any(), k
            assert (rewards >= 0.0).all() and rewards.mean() > 0.0
        assert ((envs.q[:, 2] - envs.machine.height).abs() < 0.03).all() and envs.has_contact[:, :4].float().mean() > 0.5
        assert torch.equal(seen, walking_terms.observation(envs._state()))
        _, _, terminated, truncated = envs.step(torch.zeros(32, 12))
        assert truncated.all() and not terminated.any()
        _, rewards, _, truncated = envs.step(torch.zeros(32, 12))
        assert not truncated.any() and (rewards == 0.0).all() and (envs.age == 0).all()

    def test_a_robot_that_is_upside_down_fails_and_restarts(self) -> None:
        torch: Any = pytest.importorskip("torch")
        envs = DeviceWalk(4, device="cpu")
        envs.reset(seed=1)
        envs.q[1, 3:7] = torch.tensor([1.0, 0.0, 0.0, 0.0])
        envs.q[2, 8] = float("nan")
        _, _, terminated, _ = envs.step(torch.zeros(4, 12))
        assert terminated.tolist() == [False, True, True, False]
        seen, _, terminated, _ = envs.step(torch.zeros(4, 12))
        assert not terminated.any() and seen.isfinite().all() and envs.age.tolist() == [2, 0, 0, 2]

    def test_the_same_seed_gives_the_same_bits(self) -> None:
        torch: Any = pytest.importorskip("torch")
        ends = []
        for _ in range(2):
            envs = DeviceWalk(16, device="cpu", friction=(0.5, 1.0), strength=(0.9, 1.1))
            envs.reset(seed=5)
            actions = torch.linspace(-0.5, 0.5, 16 * 12).reshape(16, 12)
            for _ in range(30):
                seen, rewards, *_ = envs.step(actions)
            ends.append((seen, rewards))
        assert torch.equal(ends[0][0], ends[1][0]) and torch.equal(ends[0][1], ends[1][1])
        assert envs._friction.min() >= 0.5 and envs._friction.max() > 0.8

    def test_wrong_options_are_named(self) -> None:
        pytest.importorskip("torch")
        with pytest.raises(ValueError, match="there is no reward 'speed'"):
            DeviceWalk(2, rewards={"speed": 1.0})
        machine = replace(quadruped(), base="front_left_calf_of_another_robot")
        with pytest.raises(rd.DescriptionError, match="has no shape that touches the ground"):
            DeviceWalk(2, machine, device="cpu")

    def test_gradients_are_slopes_along_a_direction(self) -> None:
        torch: Any = pytest.importorskip("torch")
        envs = DeviceWalk(8, device="cpu", differentiable=True, sweeps=100, rewards={"joint_acceleration": 0.0})
        envs.reset(seed=1)
        for _ in range(25):  # after that, most feet rest on the ground
            envs.step(torch.zeros(8, 12))
        start, generator = envs.checkpoint(), torch.Generator().manual_seed(1)
        actions, direction = 0.1 * torch.randn(2, 5, 8, 12, generator=generator)

        def total(given: Any) -> Any:
            envs.restore(start)
            envs.detach()
            rewards = [envs.step(action)[1] for action in given]
            return torch.stack(rewards).sum(0) + 0.2 * envs.q[:, 2]

        given = actions.requires_grad_()
        (gradient,) = torch.autograd.grad(total(given).sum(), given)
        assert (gradient[0].abs() > 0.0).any() and envs.has_contact[:, :4].float().mean() > 0.5
        with torch.no_grad():
            ends = [total(given + way * direction) for way in (1e-3, -1e-3)]
        # Rewards have 32 bits, so slopes are known to 1e-4. In some environments friction or a stop changes
        # between stick and slip within the difference; all environments together agree to some percent.
        slopes = (ends[0] - ends[1]).double() / 2e-3
        difference = (gradient * direction).sum((0, 2)) - slopes
        assert float(difference.norm()) < 0.05 * float(slopes.norm())

    def test_no_gradient_passes_a_cut_or_a_restart(self) -> None:
        torch: Any = pytest.importorskip("torch")
        envs = DeviceWalk(3, device="cpu", differentiable=True)
        envs.reset(seed=1)
        early, late = torch.zeros(2, 3, 12, requires_grad=True)
        envs.step(early)
        envs.detach()
        envs.age[1] = envs.horizon - 1
        _, rewards, _, truncated = envs.step(late)
        assert truncated.tolist() == [False, True, False]
        assert torch.autograd.grad(rewards.sum(), early, allow_unused=True, retain_graph=True) == (None,)
        envs.step(torch.zeros(3, 12))  # environment 1 restarts
        _, rewards, _, _ = envs.step(torch.zeros(3, 12))
        (gradient,) = torch.autograd.grad(rewards.sum(), late)
        assert (gradient[1] == 0.0).all() and (gradient[[0, 2]] != 0.0).any(1).all()

    def test_a_state_that_diverges_leaves_other_gradients_finite(self) -> None:
        torch: Any = pytest.importorskip("torch")
        envs = DeviceWalk(3, device="cpu", differentiable=True)
        envs.reset(seed=1)
        actions = torch.zeros(3, 12, requires_grad=True)
        envs.step(actions)
        envs.v = torch.where(torch.tensor([[False], [True], [False]]), float("nan"), envs.v)
        total = 0.0
        for _ in range(3):
            _, rewards, _, _ = envs.step(actions)
            total = total + rewards.sum()
        (gradient,) = torch.autograd.grad(total, actions)
        assert gradient.isfinite().all() and (gradient[[0, 2]] != 0.0).any()
