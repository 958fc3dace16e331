"""Environments continue from a checkpoint with the same bits."""

from typing import Any

import numpy as np
import pytest

import robot_dynamics as rd
from robot_dynamics.gym import DeviceWalk, Lift, Pushes, Randomization, RobotEnv, SwingUp, Walk


def everything(**more: Any) -> Walk:
    """Walks with all differences between environments, and with short episodes."""
    ranges = Randomization((0.5, 1.2), (0.8, 1.2), "trunk", 4, (0.9, 1.1), (0.8, 1.2), (0.8, 1.2), (0, 5))
    pushes = Pushes("trunk", 80.0, 5.0, (0.1, 0.3), 0.1)
    return Walk(6, horizon=30, command_time=0.3, latency=1, noise=0.01, pushes=pushes, randomization=ranges, **more)


MAKERS: dict[str, Any] = {
    "swing-up": lambda: SwingUp(5, horizon=12),
    "walk": everything,
    "rigid": lambda: Walk(2, horizon=12, integrator="implicit"),
    "lift": lambda: Lift(4, horizon=20, pushes=Pushes("box", 0.5, 0.01, (0.1, 0.3), 0.1), latency=1),
}


def run(envs: RobotEnv, actions: Any) -> list[Any]:
    """Results of steps."""
    return [x for action in actions for x in envs.step(action)[:4]]


def equal(some: list[Any], others: list[Any]) -> bool:
    """Whether all numbers have the same bits."""
    return len(some) == len(others) and all(np.array_equal(x, y) for x, y in zip(some, others, strict=True))


@pytest.mark.parametrize("task", MAKERS)
def test_restored_environments_take_the_same_steps(task: str) -> None:
    envs, others = MAKERS[task](), MAKERS[task]()
    count, width = envs.action_space.shape
    steps = 20 if task == "rigid" else 70
    actions = np.random.default_rng(1).uniform(-1.2, 1.2, (steps, count, width))
    envs.reset(seed=3)
    run(envs, actions[: steps // 2])
    kept = envs.checkpoint()
    expected = run(envs, actions[steps // 2 :])
    # Others that were used before, and never used ones.
    others.reset(seed=9)
    run(others, actions[:7])
    for other in (others, MAKERS[task]()):
        other.restore(kept)
        assert equal(run(other, actions[steps // 2 :]), expected)
    assert np.array(expected[3::4]).any()
    assert not equal(run(envs, actions[: steps // 2]), expected)


def test_a_checkpoint_changes_no_bits_of_explicit_steps() -> None:
    envs, undisturbed = MAKERS["swing-up"](), MAKERS["swing-up"]()
    actions = np.random.default_rng(2).uniform(-1.0, 1.0, (30, 5, 1))
    for own in (envs, undisturbed):
        own.reset(seed=1)
    for action in actions:
        envs.checkpoint()
        assert equal(run(envs, [action]), run(undisturbed, [action]))


def test_states_of_actuators_are_kept() -> None:
    # The filter of the motor has a time constant of 0.5 s, much longer than these steps.
    text = """<mujoco><option gravity="0 0 0"/><worldbody><body><joint name="a" axis="0 1 0" damping="0.1"/>
    <geom type="sphere" size="0.1" pos="0 0 -0.5" mass="1"/></body></worldbody><actuator>
    <general joint="a" dyntype="filter" dynprm="0.5" ctrlrange="-1 1"/></actuator></mujoco>"""
    batches = [rd.SimulationBatch(rd.loads(text), 3, dt=1e-3) for _ in range(2)]
    batches[0].controls = [[1.0], [0.5], [-1.0]]
    batches[0].step(100)
    assert batches[0].activations.shape == (3, 1) and 0.1 < batches[0].activations[0, 0] < 0.3
    batches[1].activations = batches[0].activations
    batches[1].controls = batches[0].controls
    q, v = batches[0].q, batches[0].v
    for own in batches:
        own.set_state(q, v)
        own.step(50)
    assert np.array_equal(batches[0].q, batches[1].q) and np.array_equal(batches[0].activations, batches[1].activations)


def test_checkpoints_of_others_are_refused() -> None:
    envs = SwingUp(2)
    envs.reset(seed=1)
    with pytest.raises(ValueError, match="2 environments SwingUp .* not of 3 environments SwingUp"):
        SwingUp(3).restore(envs.checkpoint())


def test_tensors_continue_with_the_same_bits() -> None:
    torch: Any = pytest.importorskip("torch")
    made = [DeviceWalk(8, device="cpu", horizon=20, friction=(0.5, 1.0), command_time=0.1) for _ in range(3)]
    envs, other, undisturbed = made
    actions = torch.linspace(-1.0, 1.0, 50 * 8 * 12).reshape(50, 8, 12)
    for own in (envs, undisturbed):
        own.reset(seed=1)
    for k, action in enumerate(actions):
        if k == 25:
            other.restore(envs.checkpoint())
        results = [own.step(action) for own in ([envs, undisturbed, other] if k >= 25 else [envs, undisturbed])]
        for found in results[1:]:
            assert all(torch.equal(x, y) for x, y in zip(found, results[0], strict=True)), k
    assert other.q.dtype == torch.float32 and other.age.dtype == torch.long
