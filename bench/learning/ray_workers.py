#!/usr/bin/env python3
"""Measures control steps a second of walking environments on Ray workers, beside one process without Ray.

    python bench/learning/ray_workers.py --envs 128 --steps 50 --workers 1 2

All runs take the same steps of two groups, with a random policy. One process without Ray takes them one group
after the other, on one thread. The time of a call is that of the fastest of three, without the start of the
processes.
"""

import argparse
import time
from collections.abc import Callable

import numpy as np
import ray

import robot_dynamics as rd
from robot_dynamics.gym import DeviceWalk, RobotEnv, Walk
from robot_dynamics.ray import Environments

GROUPS = 2


def policy(seen: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Random actions of at most 0.5."""
    return random.uniform(-0.5, 0.5, (len(seen), 12))


def seconds(call: Callable[[], object]) -> float:
    """Time of the fastest of three calls."""
    times = []
    for _ in range(3):
        begun = time.perf_counter()
        call()
        times.append(time.perf_counter() - begun)
    return min(times)


def plain(make: Callable[[], RobotEnv | DeviceWalk], steps: int) -> float:
    """Time without Ray."""
    rd.set_num_threads(1)
    groups, random = [make() for _ in range(GROUPS)], np.random.default_rng(1)
    tensors = isinstance(groups[0], DeviceWalk)
    if tensors:
        import torch

        torch.set_num_threads(1)
    for group in groups:
        group.reset(seed=1)

    def run() -> None:
        for group in groups:
            for _ in range(steps):
                actions = policy(np.zeros((group.num_envs, 1)), random).astype(np.float32)
                group.step(torch.from_numpy(actions) if tensors else actions)

    return seconds(run)


def main() -> None:
    """Prints a row for each number of workers."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--task", choices=["walk", "device"], default="walk")
    parser.add_argument("--envs", type=int, default=128, help="environments of a group")
    parser.add_argument("--steps", type=int, default=50, help="control steps of a call")
    parser.add_argument("--workers", type=int, nargs="+", default=[1, 2])
    options = parser.parse_args()
    count = options.envs

    def make() -> RobotEnv | DeviceWalk:
        return DeviceWalk(count, device="cpu") if options.task == "device" else Walk(count)

    total = GROUPS * count * options.steps
    print(f"{options.task}, {GROUPS} groups of {count}, {options.steps} steps in a call")
    print(f"without Ray: {total / plain(make, options.steps):.0f} control steps/s")
    ray.init(num_cpus=max(options.workers), include_dashboard=False, log_to_driver=False)
    actions = policy(np.zeros((GROUPS * count, 1)), np.random.default_rng(1))
    for workers in options.workers:
        envs = Environments(make, GROUPS, workers, seed=1, checkpoint_every=10**9)
        envs.reset()
        collected = total / seconds(lambda envs=envs: envs.collect(policy, options.steps))
        stepped = total / seconds(lambda envs=envs: [envs.step(actions) for _ in range(options.steps)])
        kept = seconds(envs._keep)
        print(f"{workers} workers: collect {collected:.0f}, step {stepped:.0f} control steps/s, checkpoint {kept:.3f} s")
        envs.close()
    ray.shutdown()


if __name__ == "__main__":
    main()
