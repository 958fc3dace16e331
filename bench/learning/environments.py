"""Measure control steps a second of the environments, and the share of the time that is not simulation.

    python bench/learning/environments.py [--envs 256] [--threads 2] [--steps 200]

Actions are random. The time includes resets, observations and rewards.
"""

import argparse
import os
import platform
import time
from typing import Any

import numpy as np

import robot_dynamics as rd
from robot_dynamics.gym import Lift, Reach, RobotEnv, SwingUp, Walk, humanoid, rough_ground


def measure(envs: RobotEnv, steps: int) -> tuple[float, float]:
    """Control steps a second, and the share of the time outside of `SimulationBatch.step`."""
    inside = 0.0
    step = type(envs.simulations).step

    def timed(self: Any, *arguments: Any, **named: Any) -> None:
        nonlocal inside
        begun = time.perf_counter()
        step(self, *arguments, **named)
        inside += time.perf_counter() - begun

    actions = np.random.default_rng(1).uniform(-0.5, 0.5, (16, *envs.action_space.shape))
    envs.reset(seed=1)
    for k in range(20):
        envs.step(actions[k % 16])
    type(envs.simulations).step = timed  # type: ignore[method-assign]
    begun = time.perf_counter()
    for k in range(steps):
        envs.step(actions[k % 16])
    whole = time.perf_counter() - begun
    type(envs.simulations).step = step  # type: ignore[method-assign]
    return steps * envs.num_envs / whole, 1.0 - inside / whole


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--envs", type=int, default=256)
    parser.add_argument("--threads", type=int, default=None)
    parser.add_argument("--steps", type=int, default=200)
    options = parser.parse_args()
    how: dict[str, Any] = {"threads": options.threads}
    tasks: dict[str, Any] = {
        "SwingUp": SwingUp,
        "Reach, two joints": Reach,
        "Reach, panda": lambda n, **how: Reach(n, rd.example("panda"), "panda_link8", **how),
        "Walk, flat": Walk,
        "Walk, rough": lambda n, **how: Walk(n, ground=rough_ground(), **how),
        "Walk, humanoid": lambda n, **how: Walk(n, humanoid(), **how),
        "Lift": Lift,
    }
    print(f"{platform.processor() or platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}, NumPy {np.__version__}")
    print("| task | environments | simulation steps in a control step | control steps/s | not simulation |")
    print("| --- | --- | --- | --- | --- |")
    for name, make in tasks.items():
        envs = make(options.envs, **how)
        rate, share = measure(envs, options.steps)
        print(f"| {name} | {options.envs} | {envs._substeps} of {1e3 * envs.simulations.dt:g} ms | {rate:,.0f} | {share:.0%} |", flush=True)


if __name__ == "__main__":
    main()
