"""Learn to swing up a pendulum whose motor is too weak to lift it, in half a minute on a CPU.

    python examples/learn_swing_up.py [--generations 60] [--seed 1]

The method is an evolution strategy, and a policy is a small network. Each generation tries 128 policies, in
pairs of opposite changes of the current one, with four episodes each. These 512 environments step together.
The ranks of the policies give the direction of the update (Salimans and others, *Evolution Strategies as a
Scalable Alternative to Reinforcement Learning*, 2017).
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
    """Actions u = tanh(f(x) − f(x')) with f = w·tanh(W x + b) of policies (n, SIZE).

    The observations x are (n, episodes, SEES), and x' is x mirrored: cos, −sin, −v. The mirrored task needs
    the opposite torque, and this policy gives it. So the policy cannot lean to one side forever. Leaning
    scores better than hanging, and a search could end there.
    """
    w, b, out = np.split(policies, [HIDDEN * SEES, HIDDEN * (SEES + 1)], axis=1)
    both = np.stack([seen, seen * MIRRORED])
    layer = np.tanh(np.einsum("nhs,mnes->mneh", w.reshape(-1, HIDDEN, SEES), both) + b[:, np.newaxis])
    action: NDArray[np.float64] = np.tanh(np.einsum("neh,nh->ne", layer[0] - layer[1], out))
    return action


def scores(policies: NDArray[np.float64], envs: SwingUp, seed: int) -> NDArray[np.float64]:
    """Mean reward of a step of each policy."""
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
    """Policy (SIZE,), and the score of the current policy before each generation and after the last."""
    random = np.random.default_rng(seed)
    policy = random.standard_normal(SIZE)
    options: dict[str, Any] = {"dt": 0.01, "substeps": 5, "horizon": 120}
    # The score is that of episodes that start near hanging.
    envs, alone = SwingUp(2 * pairs * episodes, **options), SwingUp(4, within=0.1, **options)
    spread, rate, mean, square = 0.5, 0.2, np.zeros(SIZE), np.zeros(SIZE)
    learned = [float(scores(policy[np.newaxis], alone, seed)[0])]
    for generation in range(1, generations + 1):
        changes = random.standard_normal((pairs, SIZE))
        changes = np.concatenate([changes, -changes])
        found = scores(policy + spread * changes, envs, seed + generation)
        ranks = found.argsort().argsort() / (2 * pairs - 1) - 0.5
        direction = ranks @ changes / (2 * pairs * spread)
        # Adam step.
        mean, square = 0.9 * mean + 0.1 * direction, 0.99 * square + 0.01 * direction**2
        step = mean / (1 - 0.9**generation) / (np.sqrt(square / (1 - 0.99**generation)) + 1e-8)
        policy = policy + rate * step
        learned.append(float(scores(policy[np.newaxis], alone, seed)[0]))
        if show and generation % 10 == 0:
            print(f"generation {generation:4}: reward of a step {learned[-1]:7.3f}, of the best policy {found.max():7.3f}")
    return policy, learned


def main() -> None:
    """Learn a policy and print its score."""
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
