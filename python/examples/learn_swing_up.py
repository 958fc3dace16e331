"""Learns to swing up a pendulum whose motor is too weak to lift it, by an evolution strategy, in half a
minute on a CPU.

A policy is a small network. In each generation 128 policies, pairs of opposite changes of the present one,
are tried at once, four episodes each: 512 environments that step together. The policies' ranks say in which
direction to go (Salimans and others, *Evolution Strategies as a Scalable Alternative to Reinforcement
Learning*, 2017).

    python examples/learn_swing_up.py [--generations 60] [--seed 1]
"""

import argparse
import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robot_dynamics.gym import SwingUp

HIDDEN, SEES = 16, 3
SIZE = HIDDEN * (SEES + 1) + HIDDEN
MIRRORED = np.array([1.0, -1.0, -1.0])


def act(policies: NDArray[np.float64], seen: NDArray[np.float64]) -> NDArray[np.float64]:
    """u = tanh(f(x) − f(x')) with f = w·tanh(W x + b) of each policy (n, SIZE) for its observations x (n,
    episodes, SEES).

    Seen in a mirror, cos, −sin, −v, the task is the same with the opposite torque, and so is the policy: it
    cannot lean to one side for good, which is better than hanging and where a search would stay.
    """
    w, b, out = np.split(policies, [HIDDEN * SEES, HIDDEN * (SEES + 1)], axis=1)
    both = np.stack([seen, seen * MIRRORED])
    layer = np.tanh(np.einsum("nhs,mnes->mneh", w.reshape(-1, HIDDEN, SEES), both) + b[:, np.newaxis])
    action: NDArray[np.float64] = np.tanh(np.einsum("neh,nh->ne", layer[0] - layer[1], out))
    return action


def scores(policies: NDArray[np.float64], envs: SwingUp, seed: int) -> NDArray[np.float64]:
    """The mean reward of a step of each policy."""
    count, total = len(policies), np.zeros(envs.num_envs)
    seen, _ = envs.reset(seed=seed)
    for _ in range(envs.horizon):
        actions = act(policies, seen.reshape(count, -1, SEES).astype(np.float64)).reshape(-1, 1)
        seen, rewards, _, _, _ = envs.step(actions)
        total += rewards
    mean: NDArray[np.float64] = total.reshape(count, -1).mean(axis=1) / envs.horizon
    return mean


def learn(
    generations: int, seed: int = 1, pairs: int = 64, episodes: int = 4, *, show: bool = False
) -> tuple[NDArray[np.float64], list[float]]:
    """The policy (SIZE,) and the score of the present policy before each generation and after the last."""
    random = np.random.default_rng(seed)
    policy = random.standard_normal(SIZE)
    course: dict[str, Any] = {"dt": 0.01, "substeps": 5, "horizon": 120}
    envs, alone = SwingUp(2 * pairs * episodes, **course), SwingUp(4, within=0.1, **course)  # judged from hanging
    spread, rate, mean, square = 0.5, 0.2, np.zeros(SIZE), np.zeros(SIZE)
    learned = [float(scores(policy[np.newaxis], alone, seed)[0])]
    for generation in range(1, generations + 1):
        changes = random.standard_normal((pairs, SIZE))
        changes = np.concatenate([changes, -changes])
        found = scores(policy + spread * changes, envs, seed + generation)
        ranks = found.argsort().argsort() / (2 * pairs - 1) - 0.5
        direction = ranks @ changes / (2 * pairs * spread)
        # Adam.
        mean, square = 0.9 * mean + 0.1 * direction, 0.99 * square + 0.01 * direction**2
        step = mean / (1 - 0.9**generation) / (np.sqrt(square / (1 - 0.99**generation)) + 1e-8)
        policy = policy + rate * step
        learned.append(float(scores(policy[np.newaxis], alone, seed)[0]))
        if show and generation % 10 == 0:
            print(f"generation {generation:4}: reward of a step {learned[-1]:7.3f}, of the best {found.max():7.3f}")
    return policy, learned


def main() -> None:
    """Learns, and says how far it came."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--generations", type=int, default=60)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    begun = time.perf_counter()
    policy, learned = learn(options.generations, options.seed, show=True)
    steps = options.generations * 512 * 120 * 5
    seconds = time.perf_counter() - begun
    print(f"{learned[0]:.2f} -> {learned[-1]:.2f} in {seconds:.0f} s: {steps / seconds / 1e6:.1f} million steps a second")
    envs = SwingUp(1, within=0.1, dt=0.01, substeps=5, horizon=10**6)
    seen, _ = envs.reset(seed=options.seed + 1000)
    for _ in range(200):
        seen, _, _, _, _ = envs.step(act(policy[np.newaxis], seen[np.newaxis].astype(np.float64)).reshape(-1, 1))
    print(f"after 10 s the pendulum stands {np.degrees(np.arccos(seen[0, 0])):.1f} degrees from upright")


if __name__ == "__main__":
    main()
